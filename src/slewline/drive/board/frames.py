"""Frames: messages on a line that may lose or corrupt bytes, and the detection of damage.

A frame is `number, kind, payload, CRC-16/X-25` (little-endian), made free of zeros by COBS, and
terminated by a zero.  So a receiver is synchronised again at the next zero, whatever was damaged.  This
CRC is inverted after the last byte: otherwise a frame that ends in a zero would also be valid with one
zero more, or one less.
"""

from __future__ import annotations

from typing import NamedTuple

LONGEST_CHUNK = 80  # encoded bytes without the zero; a longer one is damaged


class Frame(NamedTuple):
    """A frame that arrived undamaged."""

    number: int
    kind: int
    payload: bytes


class Damaged(NamedTuple):
    """A chunk of bytes that is not a valid frame; `why` gives the reason."""

    why: str


def _crc_table() -> tuple[int, ...]:
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ 0x8408 * (value & 1)
        table.append(value)
    return tuple(table)


_TABLE = _crc_table()


def crc(data: bytes) -> int:
    """Return the CRC-16/X-25 of bytes."""
    value = 0xFFFF
    for byte in data:
        value = value >> 8 ^ _TABLE[(value ^ byte) & 255]
    return value ^ 0xFFFF


def stuff(data: bytes) -> bytes:
    """Return the zero-free COBS encoding of at most 253 bytes, without the terminating zero.

    No frame is longer than 253 bytes before it is encoded.
    """
    return b"".join([bytes((len(part) + 1,)) + part for part in data.split(b"\0")])


def unstuff(chunk: bytes) -> bytes | None:
    """Return the bytes of a COBS-encoded chunk; None if the encoding is invalid."""
    out, at = [], 0
    while at < len(chunk):
        end = at + chunk[at]
        if end > len(chunk):
            return None
        out.append(chunk[at + 1 : end])
        at = end
    return b"\0".join(out)


def encode(number: int, kind: int, payload: bytes = b"") -> bytes:
    """Return the bytes of a frame on the wire, with the final zero."""
    head = bytes((number, kind)) + payload
    return stuff(head + crc(head).to_bytes(2, "little")) + b"\0"


def decode(chunk: bytes) -> Frame | Damaged:
    """Return the frame in a chunk (the bytes between two zeros), or Damaged with the reason."""
    if len(chunk) > LONGEST_CHUNK:
        return Damaged(f"more than {LONGEST_CHUNK} bytes")
    data = unstuff(chunk)
    if data is None:
        return Damaged("not COBS")
    if len(data) < 4:
        return Damaged(f"{len(data)} bytes; the shortest frame has 4")
    if crc(data[:-2]) != int.from_bytes(data[-2:], "little"):
        return Damaged("CRC")
    return Frame(data[0], data[1], data[2:-2])


class Decoder:
    """A decoder that assembles the bytes on a line into frames, in whatever portions the bytes are read.

    Of an unterminated chunk, it keeps only as much as is needed to detect that the chunk is too long.
    """

    def __init__(self) -> None:
        self._chunk = bytearray()

    def feed(self, data: bytes) -> list[Frame | Damaged]:
        """Return the frames and damaged chunks that these bytes complete; empty chunks are skipped."""
        found = []
        *ends, rest = data.split(b"\0")
        for end in ends:
            self._chunk += end[: LONGEST_CHUNK + 1]
            chunk = bytes(self._chunk)
            self._chunk.clear()
            if chunk:
                found.append(decode(chunk))
        self._chunk += rest
        del self._chunk[LONGEST_CHUNK + 1 :]
        return found
