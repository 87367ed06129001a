"""The client for the registers of a chipset that `slewline serve` offers on TCP, for a host program.

    from slewline.links.clients.chipset_port import COMMAND, DATA, ChipsetPort

    with ChipsetPort("127.0.0.1", 4001) as port:         # slewline serve mc1451a --tcp 127.0.0.1:4001
        port.ready()
        port.out(COMMAND, 0x6C)                          # GET_VRSN, as with OUT and IN on a PC
        port.ready()
        print(f"{port.inp(DATA):02x}{port.inp(DATA):02x}")

Only the lowest four bits of an address are used, so 0x342 is the command register too.  The messages
are described in links/ports/register_port.py.  If the server has a card other than the one in the
application note (--card), its first line contains the register offsets; the attribute `at` has them.

`packet` sends its requests in one message.  In lockstep, OUT does not wait for its answer, nor does a
poll (a read of the status register) whose result can be predicted: after a command, or after the second
byte of a word, the first poll finds HostRdy low, and the next one finds it high; after the first byte of
a word, a poll finds it high.  The server executes these requests at the same instants as if the client
had waited for every answer.  An older server reports that it does not know the request 90 02; the
client then uses the old protocol.

This file needs only the standard library: it can be copied to another machine.
"""

from __future__ import annotations

import socket
from collections.abc import Iterable

DATA, COMMAND, STATUS, RESET = 0, 2, 4, 8  # offsets of the registers, on the board of the application note
HOSTRDY = 0x80  # in the status register
IN, OUT, READY, POLL, HELLO, SERIES, ON = 0x00, 0x10, 0x24, 0x54, 0x90, 0xC0, 0xC1
VERSION, LOCKSTEP, OLDER = 2, 0x80, 0xFF  # in the answer to HELLO
LONGEST = 255  # requests of a series
UNDER_WAY = 64  # requests whose answers are not waited for
TRIES = 10  # number of waits for HostRdy, PATIENCE_MS each, before a byte is read anyway
GREETING = "slewline registers 1 "
PATIENCE_MS = 100  # HostRdy is low for 82 µs, and for 3.3 ms after a reset


class ChipsetPort:
    """The registers of a chipset on its interface board, accessed over TCP.

    Args:
        host, port: the address on which `slewline serve` listens.
        timeout: the longest wait for an answer, in wall-clock seconds.
        plain: use only requests that older servers support as well.

    Attributes:
        part: the name of the chipset.
        axes: the number of axes of the chipset.
        at: offsets of the registers, keyed "data", "command", "status", and "reset" if the card has one.

    Raises:
        ConnectionError: there is no server, the server has no chipset, or it has another host already.
        TimeoutError: there is no answer in time; every method may raise this error.
    """

    can_foresee = True  # the accesses predict the next poll

    def __init__(self, host: str, port: int, timeout: float = 10.0, plain: bool = False) -> None:
        self.where = f"{host}:{port}"
        self.hello: int | None = OLDER if plain else None  # the server's answer to HELLO; None: not sent yet
        self.sent: list[tuple[int, int]] = []  # requests whose answers have not been read
        self.stays_low = False  # requests are kept, the first of which is a poll: HostRdy has stayed low
        self.foreseen: list[int] = []  # predicted results of the next polls
        self.high = False  # HostRdy, as the last poll found it
        self.halves: set[int] | None = None  # whether a word is half transferred; None: unknown
        self.socket = socket.create_connection((host, port), timeout)
        try:
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.part, self.axes, self.at = self._greeted()
        except BaseException:
            self.close()
            raise

    def _greeted(self) -> tuple[str, int, dict[str, int]]:
        """Read the first line of the server; return the part name, the number of axes, and the register offsets."""
        line = bytearray()
        while not line.endswith(b"\n") and len(line) < 200:
            line += self._read(1)
        text = line.decode("latin-1").strip()
        if not text.startswith(GREETING):
            raise ConnectionError(f"{self.where}: {text!r}; expected '{GREETING}...', the greeting of a register port")
        part, axes, *places = text.removeprefix(GREETING).split()
        at = {"data": DATA, "command": COMMAND, "status": STATUS, "reset": RESET}
        if places:
            at = {name: int(offset) for name, _, offset in (place.partition("=") for place in places)}
        return part, int(axes), at

    def _read(self, number: int) -> bytes:
        found = bytearray()
        while len(found) < number:
            data = self.socket.recv(number - len(found))
            if not data:
                raise ConnectionError(f"{self.where}: the server has closed the connection")
            found += data
        return bytes(found)

    # ------------------------------------------------------------------------------------------------------- messages
    def exchange(self, *requests: tuple[int, int]) -> bytes:
        """Send requests, each given as its two bytes, in one message; return the answers, one byte each.

        If an answer is missing, the connection is closed: a late answer would be mistaken for the answer to a
        later request.
        """
        self.settle()
        self._forget()
        return self._exchange(b"".join(map(bytes, requests)), len(requests))

    def series(self, *requests: tuple[int, int]) -> bytes:
        """Send requests as a series, which is abandoned if a wait in it fails; return the answers, a byte each.

        Requests after a failed wait are not executed and are answered with FF.  An older server receives the
        requests one by one, and also executes those after a failed wait.
        """
        if self._version() == OLDER:
            return self.exchange(*requests)
        self.settle()
        self._forget()
        found = b""
        for at in range(0, len(requests), LONGEST):
            part = requests[at : at + LONGEST]
            found += self._exchange(framed(ON if at else SERIES, part), len(part))
        return found

    def _exchange(self, data: bytes, number: int) -> bytes:
        try:
            self.socket.sendall(data)
            return self._read(number)
        except OSError:
            self.close()
            raise

    def _version(self) -> int:
        """Return the answer to HELLO: the server's version (plus LOCKSTEP in lockstep); OLDER for an older server."""
        if self.hello is None:
            answer = self._exchange(bytes((HELLO, VERSION)), 1)[0]
            self.hello = OLDER if answer & ~LOCKSTEP < VERSION else answer
        return self.hello

    # ------------------------------------------------------------------------------------------------------ registers
    def out(self, address: int, byte: int) -> None:
        """Write a byte to a register, as OUT does on a PC.

        When the call returns, the byte has been written, except in lockstep: there it may still be in transit,
        but the server writes it before it executes any later request of this program.

        Args:
            address: the register address, of which only the lowest four bits are used: `at["data"]`,
                `at["command"]` ...
            byte: 0 to 255.

        Raises:
            ValueError: `byte` is not 0 to 255.
        """
        register = address & 0x0F
        request = OUT + register, allowed("byte", byte, 0xFF)
        if not self._foreseeing():
            self.exchange(request)
            return
        self._go(*request)
        if register in (self.at["data"], self.at["command"]):
            self._used(*request)
        elif register == self.at.get("reset"):
            self._forget()

    def inp(self, address: int) -> int:
        """Read a byte from a register, as IN does on a PC.

        Args:
            address: the register address, of which only the lowest four bits are used: `at["data"]`, `at["status"]`.
        """
        register = address & 0x0F
        if not self._foreseeing():
            return self.exchange((IN + register, 0))[0]
        if register == self.at["status"]:
            return self._poll()
        self._go(IN + register, 0)
        byte = 0 if self.stays_low else self._collect()
        tries = 0
        while self.stays_low:
            tries += 1
            byte = self._again(self.sent if tries < TRIES else [each for each in self.sent if each[0] != POLL])
        if register == self.at["data"]:
            self._used(IN + register)
        return byte

    def ready(self, ms: int = PATIENCE_MS) -> bool:
        """Wait up to `ms` milliseconds (0 to 255) of chipset time until HostRdy is high; return whether it is."""
        request = READY, allowed("ms", ms, 0xFF)
        self.settle()
        if self.stays_low:
            self._again([(POLL, ms), *self.sent[1:]])
        return not self.stays_low and bool(self.exchange(request)[0] & HOSTRDY)

    def settle(self) -> None:
        """Wait until all requests sent have been executed, or cannot be executed because HostRdy stays low."""
        if self.sent and not self.stays_low:
            self._collect()

    # ---------------------------------------------------------------------------------------------------- predictions
    def _foreseeing(self) -> bool:
        return self.can_foresee and OLDER != self._version() >= LOCKSTEP

    def _forget(self) -> None:
        """Stop predicting the results of polls until a command is written while HostRdy is high."""
        self.foreseen, self.high, self.halves = [], False, None

    def _used(self, request: int, _value: int = 0) -> None:
        """Predict the results of the next polls, after an access to the data or command register."""
        if request == OUT + self.at["command"] and self.high:
            self.halves = set()
        elif self.halves is not None:
            self.halves ^= {request}
        if self.halves is None or not self.high:  # while HostRdy is low, no byte is written
            self._forget()
            return
        self.high = request in self.halves
        self.foreseen = [0xFF] if self.high else [0xFF & ~HOSTRDY, 0xFF]

    def _go(self, request: int, value: int) -> None:
        """Send a request without waiting for its answer; while HostRdy stays low, keep it, to be sent later."""
        if len(self.sent) == UNDER_WAY and not self.stays_low:
            self._collect()
        if len(self.sent) == UNDER_WAY:
            self._again([each for each in self.sent if each[0] != POLL])
        self.sent.append((request, value))
        if not self.stays_low:
            self._post(ON if len(self.sent) > 1 else SERIES, self.sent[-1:])

    def _post(self, kind: int, requests: list[tuple[int, int]]) -> None:
        try:
            self.socket.sendall(framed(kind, requests))
        except OSError:
            self.close()
            raise

    def _collect(self) -> int:
        """Read the answers to all pending requests, and return the last answer.

        If a poll has failed, return a status with HostRdy low instead.  The failed poll and all requests after
        it are kept, to be sent again.
        """
        answers = self._exchange(b"", len(self.sent))
        both = zip(self.sent, answers, strict=True)
        vain = next((at for at, (sent, got) in enumerate(both) if sent[0] == POLL and not got & HOSTRDY), None)
        self.stays_low = vain is not None
        self.sent = [] if vain is None else self.sent[vain:]
        return 0xFF & ~HOSTRDY if self.stays_low else answers[-1]

    def _again(self, requests: list[tuple[int, int]]) -> int:
        self.sent, self.stays_low = list(requests), False
        if not requests:
            return 0xFF
        self._post(SERIES, requests)
        return self._collect()

    def _poll(self) -> int:
        """Return the content of the status register: predicted if possible, otherwise as read from the server."""
        if self.stays_low:
            status = self._exchange(framed(SERIES, [(IN + self.at["status"], 0)]), 1)[0]
            self.high = bool(status & HOSTRDY)
            if not status & HOSTRDY:
                return status
            following = self.sent[1:]  # after the poll that now succeeds
            self._again(following)
            if self.stays_low:
                return 0xFF & ~HOSTRDY
            if not following:
                return status
        if self.foreseen:
            status = self.foreseen.pop(0)
            self.high = bool(status & HOSTRDY)
            self._go(*((POLL, PATIENCE_MS) if status & HOSTRDY else (IN + self.at["status"], 0)))
            return status
        self._go(IN + self.at["status"], 0)
        status = self._collect()
        if self.stays_low:
            self.sent.pop()  # the program polls again
        self.high = bool(status & HOSTRDY)
        return status

    # -------------------------------------------------------------------------------------------------------- packets
    def packet(self, code: int, words: Iterable[int] = (), reads: int = 1) -> tuple[int, ...]:
        """Send a packet, a command byte and words, in one message, and read words in reply.

        Args:
            code: the command byte, 0 to 255.
            words: the words to write, each 0 to 65535.
            reads: the number of words to read, including the checksum.

        Returns:
            The words read; the last word of a complete packet is its checksum.

        Raises:
            ValueError: a number is out of range.
            TimeoutError: HostRdy stays low.
        """
        wait, data = (READY, PATIENCE_MS), self.at["data"]
        requests = [wait, (OUT + self.at["command"], allowed("code", code, 0xFF))]
        for word in words:
            high, low = divmod(allowed("word", word, 0xFFFF), 0x100)
            requests += [wait, (OUT + data, high), (OUT + data, low)]
        requests += [wait, (IN + data, 0), (IN + data, 0)] * reads
        answers = self.series(*requests)
        if not all(answer & HOSTRDY for request, answer in zip(requests, answers, strict=True) if request == wait):
            raise TimeoutError(f"{self.where}: HostRdy stays low in packet {code:02x}")
        found = answers[len(answers) - 3 * reads :]
        return tuple(found[at] << 8 | found[at + 1] for at in range(1, len(found), 3))

    # ------------------------------------------------------------------------------------------------------------ end
    def close(self) -> None:
        """Close the connection; the chipset keeps running."""
        try:
            if self.sent and not self.stays_low and self.socket.fileno() >= 0:
                self._read(len(self.sent))  # unread bytes may cause the loss of sent bytes when a socket is closed
        except OSError:
            pass
        finally:
            self.sent = []
            self.socket.close()

    def __enter__(self) -> ChipsetPort:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def framed(kind: int, requests: Iterable[tuple[int, int]]) -> bytes:
    """Return requests as one message, of the kind `SERIES` or `ON`.

    The server executes an `ON` message only if the previous message succeeded.
    """
    data = b"".join(map(bytes, requests))
    return bytes((kind, len(data) // 2)) + data


def allowed(what: str, number: int, most: int) -> int:
    """Return `number`, which must be in the range 0 to `most`; `what` is its name in the error message.

    Raises:
        ValueError: the number is out of range.
    """
    if not isinstance(number, int) or not 0 <= number <= most:
        raise ValueError(f"{what} {number!r}; allowed 0..{most}")
    return number
