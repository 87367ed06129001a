"""Memory images: the content from address 0 upwards, as bytes or as the text of an Intel HEX file.

:10 0010 00 4E20310D2B0D470D4420323030300D4C 5F        count, address, type, data, checksum
:00 0000 01 FF                                         the end

A binary image is a dump: the bytes of the part, one after another.  Bytes missing from a HEX file are FF, as in an
erased part.  An image whose length is in SIZES is treated as a dump of a part of that size.
"""

from __future__ import annotations

from ...errors import BenchFileError, UsageError

ERASED = 0xFF
LARGEST = 1 << 16
SIZES = tuple(1 << bits for bits in range(11, 17))  # of parts: 2K to 64K bytes
DATA, END, SEGMENT, START_SEGMENT, LINEAR, START_LINEAR = range(6)  # types of records
SHIFTS = {SEGMENT: 4, LINEAR: 16}  # shift of the base of later addresses
ROW = 16  # bytes per record in written files


HEX = (".hex", ".ihx", ".ihex")  # extensions of Intel HEX; any other file has the bytes themselves


def named_file(owner: str, name: str) -> UsageError:
    """Return the error to raise when a file name is given instead of an image."""
    return UsageError(
        f"{owner}: image {name!r} is the name of a file, but text is taken as the content itself; pass "
        f"slewline.read_image({name!r}), or use the key 'file' in a bench file"
    )


def check_text(owner: str, image: object) -> None:
    """Check that an image is not text that ends with the file extension of an image, such as ".bin".

    Raises:
        UsageError: the image is such text, so it is probably a file name.
    """
    if isinstance(image, str) and image.lower().endswith((".bin", *HEX)):
        raise named_file(owner, image)


def size_of(image: bytes) -> int:
    """Return the size in bytes of the part for an image: the image's length if it is in SIZES, else 64K."""
    return len(image) if len(image) in SIZES else LARGEST


def is_hex(data: bytes) -> bool:
    """Return whether the content of a file is Intel HEX, judging by its first line."""
    first = data.lstrip()[:44].replace(b"\r", b"\n").split(b"\n", 1)[0].strip()
    return first[:1] == b":" and all(byte in b"0123456789ABCDEFabcdef" for byte in first[1:])


def from_file(data: bytes, where: str) -> bytes:
    """Return the image in a file with this content: decoded if it is Intel HEX, else the content itself.

    Args:
        where: the file, as named in messages.

    Raises:
        BenchFileError: the file has more than 64K bytes, or is faulty Intel HEX; the message states the number
            of the line.
    """
    if is_hex(data):
        return from_hex(data.decode("latin-1"), where)
    if len(data) > LARGEST:
        raise BenchFileError(f"{where}: an image of {len(data)} bytes; allowed up to {LARGEST} (sixteen address lines)")
    return data


def from_hex(text: str, where: str) -> bytes:
    """Return the image in an Intel HEX text; missing bytes are FF.

    Args:
        where: the file, for messages.

    Raises:
        BenchFileError: a line that is not a record, an address beyond 64K, a byte with two different values, or no end
            record.
    """
    image, given, base = bytearray(), bytearray(), 0
    for number, line in enumerate(text.splitlines(), 1):
        at = f"{where}, line {number}"
        if not line.strip():
            continue
        address, kind, data = _record(line.strip(), at)
        if kind == END:
            return bytes(image)
        if kind in SHIFTS:
            base = int.from_bytes(data, "big") << SHIFTS[kind]
        elif kind == DATA:
            _put(image, given, base + address, data, at)
        elif kind not in (START_SEGMENT, START_LINEAR):  # start address of a processor: not used by a controller
            raise BenchFileError(f"{at}: a record of type {kind:02X}; allowed 00 to 05")
    raise BenchFileError(f"{where}: no end record (type 01); the file is truncated: read the memory chip again")


def _record(line: str, at: str) -> tuple[int, int, bytes]:
    """Return address, type and data of a record, which is one line of an Intel HEX file."""
    try:
        record = bytes.fromhex(line[1:]) if line[0] == ":" and " " not in line else b""
    except ValueError:
        record = b""
    if len(record) < 5:
        remedy = "a colon and pairs of hexadecimal digits; put raw bytes into a .bin file"
        raise BenchFileError(f"{at}: {line[:40]!r} is not a record; a record is {remedy}")
    if len(record) != record[0] + 5:
        raise BenchFileError(
            f"{at}: {len(record) - 5} bytes of data, but the count is {record[0]}; the line is truncated"
        )
    if sum(record) & 0xFF:
        right = -sum(record[:-1]) & 0xFF
        raise BenchFileError(f"{at}: checksum {record[-1]:02X}, calculated {right:02X}; the file is damaged")
    address, kind, data = int.from_bytes(record[1:3], "big"), record[3], record[4:-1]
    if kind in SHIFTS and len(data) != 2:
        raise BenchFileError(f"{at}: a base address of {len(data)} bytes; required 2")
    return address, kind, data


def _put(image: bytearray, given: bytearray, address: int, data: bytes, at: str) -> None:
    """Copy the data of a record into an image; `given` marks the bytes that this and earlier records have set."""
    end = address + len(data)
    if end > LARGEST:
        raise BenchFileError(f"{at}: the data end at address {end - 1:X}; allowed up to FFFF (sixteen address lines)")
    if end > len(image):
        given.extend(bytes(end - len(image)))
        image.extend(bytes([ERASED]) * (end - len(image)))
    for n, byte in enumerate(data, address):
        if given[n] and image[n] != byte:
            raise BenchFileError(f"{at}: address {n:04X} is {byte:02X} here and {image[n]:02X} above; remove one")
        given[n] = 1
        image[n] = byte


def to_hex(image: bytes) -> str:
    """Return an image as Intel HEX text; rows with only FF are left out, except at the end of the image."""
    lines = []
    for address in range(0, len(image), ROW):
        row = image[address : address + ROW]
        if row.count(ERASED) < len(row) or address + ROW >= len(image):  # the last one defines the length of the image
            record = bytes([len(row), *address.to_bytes(2, "big"), DATA, *row])
            lines.append(f":{record.hex().upper()}{-sum(record) & 0xFF:02X}\n")
    return "".join(lines) + ":00000001FF\n"
