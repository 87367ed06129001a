"""The registers of a chipset that `slewline serve` has on TCP, for a host program on the other end.

    from slewline.links.clients.chipset_port import COMMAND, DATA, ChipsetPort

    with ChipsetPort("127.0.0.1", 4001) as port:         # slewline serve mc1451a --tcp 127.0.0.1:4001
        port.ready()
        port.out(COMMAND, 0x6C)                          # GET_VRSN, as with OUT and IN on a PC
        port.ready()
        print(f"{port.inp(DATA):02x}{port.inp(DATA):02x}")

Of an address the lowest four bits count, so 0x342 is the command register too.  The messages are those of registers.py.
This file needs nothing but the standard library: a host program may take a copy of it to another machine.
"""

from __future__ import annotations

import socket
from collections.abc import Iterable

DATA, COMMAND, STATUS, RESET = 0, 2, 4, 8  # offsets of the registers
HOSTRDY = 0x80  # in the status
IN, OUT, READY = 0x00, 0x10, 0x24
GREETING = "slewline registers 1 "
PATIENCE_MS = 100  # HostRdy is low for 82 us, and for 3.3 ms after a reset


class ChipsetPort:
    """A chipset with its interface board, on a TCP port.

    Args:
        host, port: where `slewline serve` has it.
        timeout: seconds of the wall clock for an answer.

    Raises:
        ConnectionError: no server is there, or it has no chipset, or another host has it.
        TimeoutError: no answer.
    """

    def __init__(self, host: str, port: int, timeout: float = 10.0) -> None:
        self.where = f"{host}:{port}"
        self.socket = socket.create_connection((host, port), timeout)
        try:
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.part, self.axes = self._greeted()
        except BaseException:
            self.close()
            raise

    def _greeted(self) -> tuple[str, int]:
        """The part, and how many axes it has."""
        line = bytearray()
        while not line.endswith(b"\n") and len(line) < 200:
            line += self._read(1)
        text = line.decode("latin-1").strip()
        if not text.startswith(GREETING):
            raise ConnectionError(f"{self.where}: {text!r}; expected '{GREETING}...', the greeting of registers")
        part, axes = text.removeprefix(GREETING).split()
        return part, int(axes)

    def _read(self, number: int) -> bytes:
        found = bytearray()
        while len(found) < number:
            data = self.socket.recv(number - len(found))
            if not data:
                raise ConnectionError(f"{self.where}: the server has hung up")
            found += data
        return bytes(found)

    # ------------------------------------------------------------------------------------------------------ registers
    def exchange(self, *requests: tuple[int, int]) -> bytes:
        """Send requests, first and second byte of each, in one go; return the answers, a byte each.

        A port that gave no answer is closed: a late one would be taken for that to something else.
        """
        try:
            self.socket.sendall(b"".join(map(bytes, requests)))
            return self._read(len(requests))
        except OSError:
            self.close()
            raise

    def out(self, address: int, byte: int) -> None:
        """Write a byte to a register: OUT.  It is written when the call returns."""
        self.exchange((OUT + (address & 0x0F), allowed("byte", byte, 0xFF)))

    def inp(self, address: int) -> int:
        """Read a byte from a register: IN."""
        return self.exchange((IN + (address & 0x0F), 0))[0]

    def ready(self, ms: int = PATIENCE_MS) -> bool:
        """Wait until HostRdy is high, for so many milliseconds (0..255) of the chipset's time; is it?"""
        return bool(self.exchange((READY, allowed("ms", ms, 0xFF)))[0] & HOSTRDY)

    # -------------------------------------------------------------------------------------------------------- packets
    def packet(self, code: int, words: Iterable[int] = (), reads: int = 1) -> tuple[int, ...]:
        """Send a packet in one exchange, a command byte and words after it, and read so many words.

        Returns:
            The words that were read; the last of a packet is its checksum.

        Raises:
            TimeoutError: HostRdy stays low.
        """
        wait = READY, PATIENCE_MS
        requests = [wait, (OUT + COMMAND, allowed("code", code, 0xFF))]
        for word in words:
            high, low = divmod(allowed("word", word, 0xFFFF), 0x100)
            requests += [wait, (OUT + DATA, high), (OUT + DATA, low)]
        requests += [wait, (IN + DATA, 0), (IN + DATA, 0)] * reads
        answers = self.exchange(*requests)
        if not all(answer & HOSTRDY for request, answer in zip(requests, answers, strict=True) if request == wait):
            raise TimeoutError(f"{self.where}: HostRdy stays low in packet {code:02x}")
        found = answers[len(answers) - 3 * reads :]
        return tuple(found[at] << 8 | found[at + 1] for at in range(1, len(found), 3))

    # ------------------------------------------------------------------------------------------------------------ end
    def close(self) -> None:
        """Close the connection; the chipset goes on."""
        self.socket.close()

    def __enter__(self) -> ChipsetPort:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def allowed(what: str, number: int, most: int) -> int:
    """Return a number that is in the range 0 to `most`.

    Raises:
        ValueError: it is not.
    """
    if not isinstance(number, int) or not 0 <= number <= most:
        raise ValueError(f"{what} {number!r}; allowed 0..{most}")
    return number
