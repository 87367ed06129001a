"""The registers of an interface board on TCP: IN and OUT of a PC program, as short messages.

A line of text comes first, "slewline registers 1 mc1451a 4": the version of this protocol, the part,
and the number of axes.  It also has the register offsets, as in "data=0 status=1 command=1", unless
they are those of the application note.  After that every request is two bytes and every answer is one
byte, in the order of the requests:

    0r --    IN      read register r of the board (parts/boards/board.py)       the byte
    1r bb    OUT     write bb to register r                              bb again, once it is written
    24 nn    READY   wait until status bit 7 is 1, at most nn ms         the status; bit 7 is 0: timeout
    34 nn    ANSWER  the same until bit 7 is 0; parallel card only       the status
    44 nn    MESSAGE the same until bit 6 is 0; parallel card only       the status
    54 nn    POLL    read the status until bit 7 is 1, at most nn ms     the status
    90 --    HELLO   query the version                                   02, or 82 in lockstep;
                                                                         FF: SERIES not supported
    C0 nn    SERIES  nn requests follow, any of the above except HELLO   a byte for each
    C1 nn    ON      as SERIES; skipped if a wait in the preceding       a byte for each
                     series failed
    other    not a request                                               FF, as from an empty address

A series is one message, counts as one input to the board, and is answered by one message; it takes a
fraction of the time that its requests would take singly.  A failed wait ends it: the remaining
requests are not executed, and each is answered with FF.  So a host may send further requests before it
has an answer, as if every wait had succeeded, and learns afterwards at which wait a real program would
still be polling.  A series and the ON messages that continue it are executed as one series if they
arrive together.

A host may send the next request before it has the answer to the previous one: a whole packet of
requests, including their waits, takes one round trip.  Requests are executed one after another; each
access is made at the pins of the chip, and takes a bus cycle of 750 ns of virtual time.

In lockstep, time passes only for accesses, so a polling host would poll a hundred times for each word.
Therefore, after an IN that reads bit 7 of the status as 0, time passes until the bit is 1, but no more
than 100 µs.  READY lets time pass until its wait ends.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, cast

from ...parts.boards.board import FLOATING, Board
from ...parts.boards.register_layouts import COMMAND, PMD, STATUS, Layout
from ...parts.boards.series import IN, MS, OUT, POLL, POLL_PS, WAITS, Done, is_step, spelled
from ...parts.lines.far_end import TELNET
from ..lines.line_transcript import TO_CHIP, TO_HOST, TranscriptFile
from ..lines.pace import Pace
from ..lines.request_line import RequestLine
from ..sockets.preamble import REGISTERS
from .tcp import TcpPort, TurnSession

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...parts.base.request_queue import Request

VERSION = 1
NEWEST = 2  # answers to HELLO
HELLO, SERIES, ON = 0x90, 0xC0, 0xC1
LOCKSTEP = 0x80  # in the answer to HELLO
TURNS = 64  # limits of the wait of a request to the control port, in shares of a host or slices of time: 4 kB, a second
MOST = 512  # bytes of pieces of a series executed together
ALL_OF_IT = "none of the series is executed; "
SHARE = 64  # bytes per turn of the loop: 32 accesses take a millisecond


class RegisterLine(RequestLine):
    """A line on which a host sends requests to an interface board on the bench, and receives the answers."""

    ports = ("tcp",)
    greetings = REGISTERS
    share = SHARE

    def __init__(self, name: str, chip: Chip, pace: Pace, log: TranscriptFile, board: Board) -> None:
        super().__init__(name, [chip], pace, log, board)
        self.half = b""  # an incomplete request
        self.strange = False  # an invalid request of this host was reported
        self.shown = -1  # the last status in the transcript: polls with the same result are left out

    @property
    def board(self) -> Board:
        """Interface board on the bench."""
        return cast("Board", self.part)

    @property
    def status(self) -> int | None:
        """Offset of the status register; None if the board has none."""
        return self.board.layout.offset(STATUS)

    def _read_from(self, request: int) -> int:
        """Return the offset of the register that a request reads: for a wait, the status register."""
        status = self.status
        return request & 0x0F if request - IN < OUT or status is None else status

    @property
    def greeting(self) -> bytes:
        """First line of text sent to every host, as bytes."""
        sheet = self.chips[0].sheet
        return f"slewline registers {VERSION} {sheet.part} {sheet.axes}{placed(self.board.layout)}\r\n".encode("ascii")

    def attach(self, name: str, host: Callable[[bytes], int], resume: Callable[[], object]) -> None:
        """Connect a host; if the previous host left an incomplete request, the transcript shows this request."""
        if self.half:
            self.log.event(self.name, f"the previous host left an incomplete request, {self.half[:8].hex(' ', -2)}")
        self.half, self.strange = b"", False
        super().attach(name, host, resume)

    # ------------------------------------------------------------------------------------------------------- requests
    def feed(self, data: bytes) -> None:
        """Receive bytes from the host; queue each complete request."""
        data = self.half + data
        at, steps, on = 0, b"", False  # `steps`: the steps of a series, which may continue
        while len(data) >= at + 2:
            request, value = data[at], data[at + 1]
            number = value if request in (SERIES, ON) else 0
            end = at + 2 + 2 * number
            if len(data) < end:
                break
            more, at = data[at + 2 : end], end
            if steps and (request != ON or not number or len(steps) + len(more) > MOST):
                self._series(steps, on)
                steps = b""
            if not number:
                self._request(request, value)
            elif not steps:
                steps, on = more, request == ON
            else:
                steps += more
        if steps:
            self._series(steps, on)
        self.half = data[at:]

    def whole(self, data: bytes) -> bytes:
        """Return the complete requests received; the start of the next request is kept until its end arrives."""
        data, at = self.half + data, 0
        while len(data) >= at + 2 and len(data) >= (end := at + 2 + 2 * data[at + 1] * (data[at] in (SERIES, ON))):
            at = end
        self.half = data[at:]
        return data[:at]

    def forget_half(self) -> None:
        self.half = b""

    def _series(self, steps: bytes, on: bool) -> None:
        """Queue a series and its answers; if one of its steps is not a request, answer every step with FF instead."""
        board, number = self.board, len(steps) // 2
        wrong = next((at for at in range(0, len(steps), 2) if not is_step(steps[at], board.waits)), None)
        if wrong is not None:
            self.answer(
                lambda _board, _: bytes([self._nobody(steps[wrong], steps[wrong + 1], "in a series ")]) * number
            )
            return
        work = board.series(spelled(steps), POLL_PS if self.pace.lockstep else 0, on)
        self.answer(lambda _board, work: self._worked(steps, work), work)

    def _worked(self, steps: bytes, work: Request[Done]) -> bytes:
        """Return the answers to an executed series; write its accesses into the transcript."""
        answers, ends = work.result
        if self.log.file is not None and not self.silent:
            for request, byte, ps in zip(steps[::2], answers, ends, strict=False):
                if request & 0xF0 == OUT:
                    self._show(TO_CHIP, request & 0x0F, byte, ps)
                else:
                    self._note(self._read_from(request), byte, ps)
        return answers

    def _request(self, request: int, value: int) -> None:
        """Queue a request and its answer."""
        board, offset = self.board, self._read_from(request)
        if request & 0xF0 == OUT:
            register = request & 0x0F
            board.cycle(board.base + register, value)
            self.answer(lambda _board, _: self._written(register, value))
        elif request == HELLO:
            self.answer(lambda _board, _: bytes([NEWEST | LOCKSTEP * self.pace.lockstep]))
        elif request == POLL:
            self._series(bytes([request, value]), False)
        elif request & 0xF0 == IN or WAITS.get(request) in board.waits:
            if request in WAITS:
                board.ready(value * MS, WAITS[request])
            access = board.cycle(board.base + offset)
            self.answer(lambda _board, access: self._read(offset, access), access)
            if self.pace.lockstep and request not in WAITS and offset == self.status:
                board.ready(POLL_PS)
        else:
            self.answer(lambda _board, _: bytes([self._nobody(request, value)]))

    def _read(self, offset: int, access: Request[int]) -> bytes:
        """Return the byte that an access has read; write it into the transcript."""
        self._note(offset, access.result, self.kernel.now)
        return bytes([access.result])

    def _note(self, offset: int, byte: int, ps: int) -> None:
        """Write into the transcript a byte that was read, unless it is a status equal to the last status read."""
        if self.silent:
            return
        if offset != self.status or byte != self.shown:
            self._show(TO_HOST, offset, byte, ps)
        if offset == self.status:
            self.shown = byte

    def _written(self, offset: int, byte: int) -> bytes:
        self._show(TO_CHIP, offset, byte, self.kernel.now)
        return bytes([byte])

    def _nobody(self, request: int, value: int, where: str = "") -> int:
        if self.silent:
            return FLOATING
        self.log.event(self.name, f"{request:02x} {value:02x} {where}is not a request")
        if not self.strange:
            self.strange = True
            self.board.finding("no-request", self._what_is_here(bytes([request, value]), where))
        return FLOATING

    def _what_is_here(self, came: bytes, where: str) -> str:
        """Return a message about bytes that are not a request, with a remedy."""
        text = " (text, it seems)" if came.isascii() and came.decode("ascii").isprintable() else ""
        if TELNET.match(came + b"\0"):
            text = " (telnet negotiation, it seems)"
        return (
            f"{came!r}{text} {where}is not a request, and reads FF: {ALL_OF_IT if where else ''}"
            "this is a port for registers, with two bytes per request, "
            'the first 00 to 4F; see "Registers on a socket" (docs/howto/serve_registers.md)'
        )

    # ----------------------------------------------------------------------------------------------------- transcript
    def note(self, direction: str, data: bytes) -> None:
        """Do nothing: the transcript shows the accesses, not the bytes of the requests."""

    def _show(self, direction: str, offset: int, byte: int, ps: int) -> None:
        """Write an access into the transcript, such as "< 2 31" (write) or "> 0 5c" (read)."""
        if not self.silent:
            self.log.write(ps, self.name, direction, f"{offset:x} {byte:02x}")


def placed(layout: Layout) -> str:
    """Return a board's register offsets for the greeting; "" if they are the usual ones.

    Also return "" if the board has no command register.
    """
    if layout.offset(COMMAND) is None or (layout.reads, layout.writes) == (PMD.reads, PMD.writes):
        return ""
    found = {name: offset for each in (layout.reads, layout.writes) for offset, name in each.items()}
    return "".join(f" {name}={offset}" for name, offset in found.items())


class RegisterSession(TurnSession):
    """A host that uses the registers of a board."""

    line: RegisterLine

    def arrive(self) -> None:
        """Send the greeting."""
        self.stream.write(self.line.greeting)

    def room(self) -> int:
        """Return the number of bytes that may be read from the host now.

        It is 0 while the host does not read its answers, so that no answer is dropped.
        """
        if self.stream.outgoing:
            return 0
        return min(super().room(), self.line.room()) if self.begun else super().room()


class RegisterPort(TcpPort):
    """The registers of a board on a TCP port."""

    scheme = "registers"
    make = RegisterSession
    line: RegisterLine

    def catch_up(self) -> None:
        """Pass on everything that the host has sent so far; let time run until the board has processed it.

        The run is limited.  In lockstep, a host need not wait for answers.  This method ensures that a later
        request to another port is executed after all requests already sent to this one.
        """
        pace, line = self.line.pace, self.line
        for _ in range(TURNS):
            taken = line.taken
            if self.session is not None:
                self.session.stream.read_now()
            if line.quiet() and line.taken == taken:
                return
            pace.pass_time()
