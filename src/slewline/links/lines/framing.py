"""A framing specific to slewline, for chips on a bus: lines of text, with read-back and without losses.

The UART of figure 10.16 only receives, and cannot hold off a host.  This link replaces it with a small
host computer that performs the handshake on behalf of the program at the far end:

    R 100            a command, as in a program file; it is sent as fast as the chip accepts it
    ?0 ... ?3        read a verify group, through PROG/LIVE if a program is running; answer:  ?3 4E 20 47
    ?                query whether the chip accepts a command now; answer:  ? ready, or ? busy
    !                discard pending commands and queries; the answer is !

Lines end with CR or LF, answers with CR LF.  Answers come in the order of the queries, except those to
`?` and `!`, which come immediately, even with commands pending.  A line that cannot be sent is answered
with `!` followed by the reason.

A command that is being sent when `!` arrives is not cut in two: the chip receives the rest of it, and
executes it.  A second `!` cuts it, and releases the bus, in case the chip no longer responds.

Up to `BACKLOG` lines may wait.  A line that exceeds this limit is refused, and so are all later lines
until the waiting ones have been sent or discarded: a motion is made with the parameters sent before it,
or not at all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, cast

from ...bench.scripts.script_runner import TAKEN_US
from ...core.datasheet.channel import BusHandshake
from ...core.wires.waits import first_of
from ...errors import SlewlineError, UsageError
from ...language.dialect import spoken_as
from ...language.text import Letters
from ...parts.hosts.bus_host import BusHost
from ...parts.lines.far_end import RAW_REMEDY, TELNET
from ..sockets.stream import CHUNK
from .line_transcript import TranscriptFile
from .outlet import SentBytes
from .pace import Pace
from .served_line import HostLine, Send

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...core.time.kernel import Kernel
    from ...parts.base.part import Part
    from ...parts.base.request_queue import Request
    from ...parts.hosts.ends.handshake_port import CommandPort

LONGEST = 256  # characters of a line
BACKLOG = 4096  # maximum number of lines that may wait for the chip
SHARE = 256  # bytes in a turn of the loop


class FramedLine(HostLine):
    """A line that carries text to a host computer on the bench, and carries the computer's answers back."""

    share = SHARE

    def __init__(self, name: str, chip: Chip, pace: Pace, log: TranscriptFile, computer: BusHost) -> None:
        super().__init__(name, [chip], pace, log)
        self.chip, self.computer = chip, computer
        self.line = bytearray()
        self.too_long = self.full = self.cutting = False

    def feed(self, data: bytes) -> None:
        """Receive bytes from the host: lines of text, each executed when complete."""
        for byte in data:
            if byte not in b"\r\n":
                self.too_long |= len(self.line) >= LONGEST
                if not self.too_long:
                    self.line.append(byte)
            elif self.line:
                line, self.line = bytes(self.line), bytearray()
                self._line(line)
                self.too_long = False

    def _line(self, line: bytes) -> None:
        try:
            if self.too_long:
                raise UsageError(f"the line has more than {LONGEST} characters; not sent")
            odd = next((at for at, byte in enumerate(line) if byte > 0x7F), None)
            if odd is not None:
                why = f"; {RAW_REMEDY}" if TELNET.match(line[odd:]) else ""
                raise UsageError(f"byte {line[odd]:#04x} at character {odd + 1} is not ASCII; not sent{why}")
            self._do(line.decode("ascii"))
        except SlewlineError as error:
            self.send(f"! {error}")

    def _do(self, text: str) -> None:
        if text == "!":
            self._forget()
        elif text == "?":
            self._act(lambda computer, _, send: send(line_of(f"? {'ready' if takes(computer) else 'busy'}"), None))
        elif text[0] == "?":
            groups = [f"?{group}" for group in self.chip.sheet.through(BusHandshake).verify_bytes]
            if text not in groups:
                raise UsageError(f"{text}: allowed {', '.join(['?', *groups])}")
            self._check_room(text)
            request = self.computer.read_group(self.chip.name, int(text[1:]), None, live=None)
            self._act(
                lambda computer, request, send: computer.queue.post("an answer", partial(answer, text, request, send)),
                request,
            )
        else:
            self._check_room(text)
            self.computer.send(spoken_as(self.chip.sheet, Letters).sent(self.chip.sheet, text))
            self._act(lambda computer, _request, _say: computer.do(partial(taken, computer.kernel)))

    def _act(self, do: Callable[[Any, Any, Send], object], request: Request[bytes] | None = None) -> None:
        """Perform an action on the host computer; record it, so that a bench that replays the inputs can repeat it."""
        if self.acts is not None:
            self.acts.add(self.kernel.now, do)
        do(self.computer, request, self.give)

    @property
    def part(self) -> Part:
        """Host computer on the bench."""
        return self.computer

    def move(self, bench: Bench, coming: Sequence[SentBytes]) -> None:
        """Connect the line to the computer of the same name on another bench; `coming` are bytes still in transit."""
        super().move(bench, coming)
        self.chip, self.computer = self.chips[0], cast("BusHost", bench.parts[self.computer.name])

    def _check_room(self, text: str) -> None:
        self.cutting = False
        waiting = len(self.computer.queue) // 2  # each line is two requests
        self.full = waiting >= BACKLOG or (self.full and waiting > 0)
        if self.full:
            raise UsageError(
                f"{text}: not sent, because {waiting} lines are waiting; wait until the reply to '?' is 'ready'"
            )

    def _forget(self) -> None:
        (self.computer.clear if self.cutting else self.computer.drop)()
        self.cutting = self.computer.queue.begun  # the next one cuts a command
        self.send("!")

    def send(self, text: str) -> None:
        """Send one line to the host, as an answer."""
        self._act(lambda _computer, _request, send: send(line_of(text), None))

    def whole(self, data: bytes) -> bytes:
        """Return the complete lines in received bytes; keep the start of an incomplete line until its end arrives."""
        data = bytes(self.line) + data
        end = max(data.rfind(b"\r"), data.rfind(b"\n")) + 1
        self.line = bytearray(data[end:][: LONGEST + 1])
        return data[:end]

    def forget_half(self) -> None:
        """Discard the start of an incomplete line, whose end will go to another destination."""
        self.line.clear()

    def space(self) -> int:
        """Return the number of bytes that may arrive now."""
        return CHUNK  # an excess is refused line by line, so that ? and ! are always read

    def sent(self) -> bool:
        """Return True: another host may begin at any time, even with commands pending, for example to discard them."""
        return True  # the next host may want to discard the commands of the last one

    def quiet(self) -> bool:
        """Return whether all commands have been sent, and all queries answered."""
        return self.computer.idle


def line_of(text: str) -> bytes:
    """Return an answer as bytes to send."""
    return text.encode("ascii", "backslashreplace") + b"\r\n"


def takes(computer: BusHost) -> bool:
    """Return whether the chip takes a command now.

    READY alone does not show this: it stays high during a program even if the chip then takes no live
    commands.
    """
    sheet, pins = computer.chip.sheet, computer.chip.pins
    running = sheet.role("running")
    is_blocked = not sheet.takes_live and running is not None and pins[running.name].level == 0
    return computer.idle and pins["ready"].level == 1 and not is_blocked


async def taken(kernel: Kernel, port: CommandPort) -> None:
    """Wait until the chip is ready again, or has been busy for so long that it must be moving or waiting."""
    await first_of(kernel, kernel.now + port.ps(TAKEN_US), (port.ready, 1))


async def answer(question: str, request: Request[bytes], send: Send) -> None:
    """Answer the query `question` with the data that `request` has read."""
    send(line_of(f"{question} {request.result.hex(' ').upper()}"), None)
