"""A client with which host programs use a parallel card that `slewline serve --registers` offers on TCP.

    from slewline.links.clients.card_port import CardPort

    with CardPort("127.0.0.1", 4002) as card:            # slewline serve PART --pty x --registers 127.0.0.1:4002
        card.command("O 81H")                            # the chip now sends its answers over the bus
        print(card.ask("? P"))                           # P=00000000

The registers are described in parts/boards/parallel_card.py, the messages in
links/ports/register_port.py.  This file and chipset_port.py need only the standard library: both can be
copied to another machine.
"""

from __future__ import annotations

import re

from .chipset_port import DATA, IN, OUT, READY, STATUS, ChipsetPort

CONTROL = 2
REQUEST, DRIVE = 0x01, 0x02  # control register bits
IS_READY, IS_FREE = 0x80, 0x40  # status bits: BUSY high, FPL high
ANSWER, MESSAGE = 0x30 + STATUS, 0x40 + STATUS  # requests: wait for BUSY low, for FPL low
STEP_MS = 200  # longest wait of one request
MODE = re.compile(r"O ?([0-9][0-9A-F]*)(H?)")
LISTING = re.compile(r"\? ?M[ ,]+([0-9]+)")  # memory lines, after the pointer
ON_BUS = (0x05, 0x01)  # mode register: mask, and value while messages are sent over the bus


class CardPort(ChipsetPort):
    """A chip on its parallel bus, reached over TCP through a card; arguments and errors as for `ChipsetPort`.

    On connection, the card releases all lines that an earlier program has left driven.

    Attributes:
        messages: the bytes that the chip has sent and that no call has returned yet.
        heeds: True if the last mode command from this program directs messages to the bus; FPL is evaluated
            only in this case.
    """

    can_foresee = False

    def __init__(self, host: str, port: int, timeout: float = 10.0, plain: bool = False) -> None:
        super().__init__(host, port, timeout, plain)
        self.messages = bytearray()
        self.heeds = False
        self.out(CONTROL, 0)

    # ----------------------------------------------------------------------------------------------------- handshakes
    def status(self) -> int:
        """Return the status register, 0 to 255: bit 7 BUSY, bit 6 FPL."""
        return self.inp(STATUS)

    def until(self, request: int, ms: int, bit: int, wanted: int) -> int:
        """Repeat a request until a status bit has a given value; return the status.

        Args:
            request: the first byte of a request whose answer is the status; its second byte is the time to wait.
            ms: the longest wait, in milliseconds of chip time.
            bit: the mask of the bit.
            wanted: the value that the status must have under this mask.

        Raises:
            TimeoutError: the bit does not change in time.
        """
        while True:
            (status,) = self.exchange((request, min(ms, STEP_MS)))
            if status & bit == wanted:
                return status
            ms -= STEP_MS
            if ms <= 0:
                raise TimeoutError(
                    f"{self.where}: the status stays {status:#04x}; expected {wanted:#04x} under the mask {bit:#04x}"
                )

    def free(self, ms: int) -> None:
        """Read pending messages until the chip is ready for a byte; each wait is at most `ms` ms of chip time.

        Raises:
            TimeoutError: the chip is not ready in time.
        """
        while not self.until(READY, ms, IS_READY, IS_READY) & IS_FREE and self.heeds:
            self._fetch()

    def _fetch(self, asked: bool = False) -> None:
        """Read a message byte into `messages`; pass True if IO_REQUEST is already low."""
        if not asked:
            self.out(CONTROL, REQUEST)
            self.until(ANSWER, STEP_MS, IS_READY, 0)
        self.messages += self.exchange((IN + DATA, 0), (OUT + CONTROL, 0))[:1]
        self.until(READY, STEP_MS, IS_READY, IS_READY)

    def empty(self, ms: int = 5000) -> None:
        """Perform the empty handshake that begins a command, after reading any pending messages.

        Raises:
            TimeoutError: the chip does not respond within `ms` milliseconds of chip time.
        """
        while True:
            self.free(ms)
            self.out(CONTROL, REQUEST)
            status = self.until(ANSWER, ms, IS_READY, 0)
            if status & IS_FREE or not self.heeds:
                self.out(CONTROL, 0)
                return
            self._fetch(asked=True)

    def write(self, data: bytes) -> None:
        """Send bytes, each with its handshake, in one TCP message; the chip must be ready to take them.

        Raises:
            TimeoutError: the chip has not taken one of the bytes.
        """
        wait, answer = (READY, STEP_MS), (ANSWER, STEP_MS)
        requests = [wait, (OUT + DATA, 0), (OUT + CONTROL, REQUEST | DRIVE), answer, (OUT + CONTROL, 0)]
        sent = [each if each[0] != OUT + DATA else (OUT + DATA, byte) for byte in data for each in requests]
        answers = self.series(*sent)
        for number, (request, status) in enumerate(zip(sent, answers, strict=True)):
            if request in (wait, answer) and bool(status & IS_READY) is not (request == wait):
                raise TimeoutError(f"{self.where}: byte {number // len(requests)} of {data!r} was not accepted")

    # -------------------------------------------------------------------------------------------------------- commands
    def command(self, text: str, ms: int = 5000) -> None:
        """Send a command and a carriage return; return when both are received, perhaps before execution.

        Raises:
            TimeoutError: the chip does not take the command within `ms` milliseconds of chip time.
        """
        self.empty(ms)
        self.write(text.encode("ascii") + b"\r")
        if match := MODE.fullmatch(text):
            mask, value = ON_BUS
            self.heeds = int(match[1], 16 if match[2] else 10) & mask == value

    def enter(self, program: str, ms: int = 5000) -> None:
        """Store a program, one command per line, starting at the memory pointer.

        Raises:
            TimeoutError: the chip takes longer than `ms` milliseconds of chip time to store a byte.
        """
        self.command("E", ms)
        for byte in "".join(f"{line}\r" for line in program.splitlines()).encode("ascii") + b"Q":
            self.until(READY, ms, IS_READY, IS_READY)
            self.write(bytes([byte]))

    def ask(self, query: str, ms: int = 5000) -> str:
        """Send a query and return its answer.

        The query is, for example, "? P", or "? M,3" for the memory pointer and three lines of memory.

        Returns:
            The answer without its last carriage return.

        Raises:
            TimeoutError: no answer within `ms` ms of chip time; the mode register may direct answers elsewhere.
        """
        self.command(query, ms)
        while (match := answer_to(query).search(self.messages)) is None:
            self.until(MESSAGE, ms, IS_FREE, 0)
            self.until(READY, ms, IS_READY, IS_READY)
            self._fetch()
        answer = bytes(match[0][:-1]).decode("latin-1")
        del self.messages[match.start() : match.end()]
        return answer

    def listen(self, ms: int) -> bytes:
        """Return the message bytes not yet returned; if there are none, wait for some, up to `ms` ms of chip time.

        Raises:
            TimeoutError: the chip has sent nothing.
        """
        while not self.messages:
            self.until(MESSAGE, ms, IS_FREE, 0)
            self.free(ms)
        found = bytes(self.messages)
        self.messages.clear()
        return found


def answer_to(query: str) -> re.Pattern[bytes]:
    """Return the regular expression that matches the answer to a query."""
    listing = LISTING.fullmatch(query)
    letter, lines = ("Y", int(listing[1])) if listing else (query.removeprefix("?").strip()[:1], 0)
    return re.compile(re.escape(f"{letter}=").encode() + rb"[0-9]+\r" + rb"[^\r]*\r" * lines)
