"""The registers of an interface board on TCP: what IN and OUT are to a program on a PC, as short messages.

A line of text comes first, "slewline registers 1 mc1451a 4": the version of this protocol, the part, how many axes.
After that every request is two bytes and every answer is one, in the order of the requests:

    0r --    IN      read register r of the board (parts/boards/board.py)       the byte
    1r bb    OUT     write bb to register r                              bb again, when it is written
    24 nn    READY   wait until bit 7 of the status is 1, for nn ms      the status; bit 7 is 0 if it has stayed so
    34 nn    ANSWER  ... is 0; of a parallel card                        the status
    44 nn    MESSAGE wait until bit 6 is 0; of a parallel card           the status
    other    is no request                                               FF, as from an empty address

A host may send the next request before it has the answer to the last one: a whole packet, its waits included, is one
round trip.  Requests are worked one after the other, each access at the pins of the chip, and takes its bus cycle of
750 ns of virtual time.

In lockstep that is all the time there is, so a host that polls would poll a hundred times for each word: there, 100 us
may pass after an IN that finds bit 7 of the status at 0, until it is 1.  READY lets pass what it waits for.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ...core.time.timebase import PS_PER_S
from ...parts.boards.board import FLOATING, STATUS, Board
from ..lines.line import HostLine
from ..lines.log import TO_CHIP, TO_HOST, TranscriptFile
from ..lines.pace import Pace
from ..sockets.preamble import REGISTERS
from .tcp import Session, TcpPort

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...parts.base.request_queue import Request

VERSION = 1
IN, OUT, READY = 0x00, 0x10, 0x20 + STATUS
WAITS = {READY: "ready", 0x30 + STATUS: "answer", 0x40 + STATUS: "message"}  # what a board knows by these names
MS = PS_PER_S // 1000
POLL_PS = MS // 10  # in lockstep, what passes after a poll at most; HostRdy is low for 82 us
BACKLOG = 256  # pieces of work for the board that may wait; the next answer lets in more
SHARE = 64  # bytes in a turn of the loop: 32 accesses take a millisecond


class RegisterLine(HostLine):
    """Requests to an interface board on the bench, and its answers."""

    ports = ("tcp",)
    greetings = REGISTERS
    share = SHARE

    def __init__(self, name: str, chip: Chip, pace: Pace, log: TranscriptFile, board: Board) -> None:
        super().__init__(name, [chip], pace, log)
        self.board = board
        self.half = b""  # the first byte of a request
        self.full = False
        self.strange = False  # this host has sent what is not a request, and that was reported
        self.shown = -1  # the last status in the transcript: polls that read the same are left out

    @property
    def greeting(self) -> bytes:
        """What a host gets first."""
        sheet = self.chips[0].sheet
        return f"slewline registers {VERSION} {sheet.part} {sheet.axes}\r\n".encode("ascii")

    def attach(self, name: str, host: Callable[[bytes], int], resume: Callable[[], object]) -> None:
        """Connect a host."""
        self.half, self.strange = b"", False
        super().attach(name, host, resume)

    # ------------------------------------------------------------------------------------------------------- requests
    def feed(self, data: bytes) -> None:
        """Take bytes of the host: accesses to registers."""
        data = self.half + data
        self.half = data[len(data) & ~1 :]
        for request, value in zip(data[::2], data[1::2], strict=False):
            self._request(request, value)

    def _request(self, request: int, value: int) -> None:
        """Queue what is asked for, and the answer to it."""
        board, offset = self.board, request & 0x0F
        if request & 0xF0 == OUT:
            board.cycle(board.base + offset, value)
            self._answer(lambda: self._written(offset, value))
        elif request & 0xF0 == IN or WAITS.get(request) in board.waits:
            if request in WAITS:
                board.ready(value * MS, WAITS[request])
            access = board.cycle(board.base + offset)
            self._answer(lambda: self._read(offset, access))
            if self.pace.lockstep and request == IN + STATUS:
                board.ready(POLL_PS)
        else:
            self._answer(lambda: self._nobody(request, value))

    def _answer(self, byte: Callable[[], int]) -> None:
        """Queue an answer, for the host of this moment: the next one has not asked."""
        host = self.host

        async def answer() -> None:
            found = byte()
            if self.host is host is not None:
                self.give(bytes([found]))
            if self.full and self.room() > 0 and self.resume is not None:
                self.resume()

        self.board.queue.post("an answer", answer)

    def _read(self, offset: int, access: Request[int]) -> int:
        """The byte that a read access has brought."""
        byte: int = access.result
        if offset != STATUS or byte != self.shown:
            self._show(TO_HOST, offset, byte)
        if offset == STATUS:
            self.shown = byte
        return byte

    def _written(self, offset: int, byte: int) -> int:
        self._show(TO_CHIP, offset, byte)
        return byte

    def _nobody(self, request: int, value: int) -> int:
        self.log.event(self.name, f"{request:02x} {value:02x} is not a request")
        if not self.strange:
            self.strange = True
            self.board.finding("no-request", self._what_is_here(bytes([request, value])))
        return FLOATING

    def _what_is_here(self, came: bytes) -> str:
        """Return what to do about bytes that are no request."""
        text = " (text, it seems)" if came.isascii() and came.decode("ascii").isprintable() else ""
        return (
            f"{came!r}{text} is not a request, and reads FF: this is a port of registers, with two bytes a request, "
            '00 to 4F first; see "Registers on a socket" (docs/howto/serve_registers.md)'
        )

    # ----------------------------------------------------------------------------------------------------- transcript
    def note(self, way: str, data: bytes) -> None:
        """Write accesses into the transcript, not the bytes that ask for them."""

    def _show(self, way: str, offset: int, byte: int) -> None:
        """An access in the transcript: "< 2 31", "> 0 5c"."""
        self.log.write(self.kernel.now, self.name, way, f"{offset:x} {byte:02x}")

    def room(self) -> int:
        """Return how many bytes may come now."""
        room = BACKLOG - len(self.board.queue)
        self.full = room <= 0
        return room

    def sent(self) -> bool:
        """Return whether everything that has come has been carried out."""
        return self.board.idle

    def quiet(self) -> bool:
        """Return whether everything that was asked for is answered."""
        return self.board.idle


class RegisterSession(Session):
    """A host on the registers of a board."""

    line: RegisterLine

    def arrive(self) -> None:
        """Greet; nothing more goes out before its turn, for every answer belongs to a request."""
        self.stream.write(self.line.greeting)

    def begin(self) -> None:
        """Begin the turn of this host."""
        super().begin()
        self.attach()

    def room(self) -> int:
        """Return how many bytes may be read now: none while answers are not read, for none may be dropped."""
        if self.stream.outgoing:
            return 0
        return min(super().room(), self.line.room()) if self.begun else super().room()


class RegisterPort(TcpPort):
    """A board on a TCP port."""

    scheme = "registers"
    make = RegisterSession
