"""The common base of chips on a serial line: they receive text lines, and process and answer them one at a time.

    rxd   ... characters ... CR                               a carriage return ends a line; then
    txd                         |<- turnround ->| answer CR   the line is executed, and takes effect with its answer

While a line is in progress, one further line is kept; any more are lost.  Every chip on a line has a
`LineInterface`.  A `LineChip` has no other interface: it defines its sheet (with a serial line among its
channels, and the lines dialect), and a method for each command or an `obey` of its own.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from inspect import isawaitable
from typing import Any, ClassVar, NamedTuple, Protocol

from ..core.chip import Chip
from ..core.datasheet.channel import SerialLine
from ..core.datasheet.table import Sheet
from ..core.time.hook import Hook
from ..core.time.kernel import Kernel, Task
from ..core.time.timebase import Clock
from ..core.wires.characters import begin_line, frames_of
from ..core.wires.net import Driver
from ..core.wires.pin import Terminal
from ..core.wires.receiver import Character, Receiver
from ..core.wires.serial import RS232, CharacterFormat, Straps, bit_clock
from ..core.wires.waits import next_round, suspended, until
from ..errors import UsageError
from ..language.dialect import Refusal, dialect_of
from ..language.lines import KEPT, parse, refusal

CR, LF = 0x0D, 0x0A
TURNROUND_PS = 10**9


class Line(NamedTuple):
    """A line as it was received, without its carriage return.

    Attributes:
        text: the characters.
        faulty: True if a character had a parity or framing error.
        first_faulty: True if the first character had such an error.
        too_long: True if the line was longer than the part accepts.
        checked: True if checksums were selected at the end of the line; this applies to its answer as well.
        end_ps: the end of the line's carriage return, ps.
    """

    text: bytes
    faulty: bool
    first_faulty: bool
    too_long: bool
    checked: bool
    end_ps: int


class LineOwner(Protocol):
    """The members of a chip that its line interface uses."""

    kernel: Kernel
    name: str
    clock: Clock
    idle: bool
    on_command: Hook[[str]]

    @property
    def drivers(self) -> Mapping[str, Driver]:
        """The drivers by pin name, including `txd`."""

    @property
    def pins(self) -> Mapping[str, Terminal]:
        """The pins by name, including `rxd`."""

    @property
    def under_way(self) -> str:
        """Work in progress other than a line from the host, as text; "" for none."""

    def finding(self, code: str, text: str) -> None:
        """Add a finding."""

    def sync(self) -> None:
        """Move to the next clock tick at or after this instant."""

    async def obey(self, line: Line) -> Sequence[bytes]:
        """Execute a line; return the answers, without their carriage returns."""

    def meant(self, line: Line) -> bytes | None:
        """Return the command in a line, without address and checksum; None if there is none for this chip."""

    def busy(self, on: bool) -> None:
        """Show that the chip begins (True) or has finished (False) the execution of a line."""

    def refresh_idle(self) -> None:
        """Record whether the chip is idle."""


class LineInterface:
    """The serial side of a chip whose commands are lines: it receives characters and sends answers.

    Args:
        longest: the maximum number of characters in a line.
        turnround_ps: the time from the carriage return to the effect and answer of a line, ps.
        lenient: True if a line feed between two lines is ignored.
    """

    def __init__(
        self, owner: LineOwner, port: SerialLine, straps: Straps, *, longest: int, turnround_ps: int, lenient: bool
    ) -> None:
        self.owner, self.kernel, self.straps = owner, owner.kernel, straps
        self.longest, self.turnround_ps, self.lenient = longest, turnround_ps, lenient
        self.word = CharacterFormat(port.bits, port.parity, port.stop)
        self.baud = 0  # the rate of reception
        self.work: deque[Line | bytes] = deque()  # lines to execute, and late answers
        self.worker: Task | None = None
        self.answering = False  # a line is in progress, or its answer is being sent
        self.listener: Task | None = None
        self.receiver: Receiver | None = None
        self._coming = bytearray()
        self._faulty = self._first_faulty = self._too_long = False
        self.line_feeds = False  # a line feed has been reported

    @property
    def coming(self) -> bytearray:
        """The characters of the line that has not ended yet."""
        if self.receiver is not None:
            self.receiver.catch_up()
        return self._coming

    @property
    def unfinished(self) -> str:
        """The characters of the line that has not ended yet, as text."""
        return self.coming.decode("latin-1")

    @property
    def odd(self) -> str:
        """A remark to append if the unfinished line contains unprintable characters; otherwise ""."""
        odd = any(not 0x20 <= byte < 0x7F for byte in self.coming.replace(b"\n", b""))
        in_full = self.straps.setting.in_full
        return f"; such characters indicate another rate or format than {in_full}" if odd else ""

    def listen(self) -> None:
        """Begin to receive, at the baud rate that the straps now select."""
        self.baud = self.straps.take()
        self.bits = bit_clock(self.baud, self.owner.name)
        self.frames = frames_of(self.bits.hz, self.word, RS232)
        self.listener = self.kernel.spawn(self._listen, name=f"{self.owner.name} listens")
        self.owner.refresh_idle()

    def hang_up(self) -> None:
        """Stop receiving and sending, and discard all lines, because the supply is off."""
        for task in (self.listener, self.worker):
            if task is not None:
                task.kill()
        if self.receiver is not None:
            self.receiver.close()
        self.listener = self.worker = self.receiver = self.straps.taken = None
        self.work.clear()
        self.answering = False
        self._forget_line()

    def _forget_line(self) -> None:
        self._coming.clear()
        self._faulty = self._first_faulty = self._too_long = False

    async def _listen(self) -> None:
        self.receiver = Receiver(self.owner.pins["rxd"].net, self.bits, self.word, RS232)
        await self.receiver.receive(self._receive, self._passed, _line_end)

    def _passed(self, data: bytes) -> None:
        """Add fault-free characters to the line; none of them is a CR or an LF."""
        room = self.longest - len(self._coming)
        self._coming += data[: max(room, 0)]
        self._too_long |= len(data) > room

    def _receive(self, character: Character) -> None:
        """Add a character; a carriage return ends a line."""
        byte, text, good = character.byte, self._coming, character.good
        if byte == LF and good:
            self._line_feed(bool(text))
        if byte == CR:
            faulty = self._faulty or not good
            checked = self.straps.checked
            self.take(Line(bytes(text), faulty, self._first_faulty, self._too_long, checked, character.end_ps))
            self._forget_line()
        elif byte == LF and self.lenient and not text:
            return
        elif len(text) < self.longest:
            self._first_faulty |= not text and not good
            self._faulty |= not good
            text.append(byte)
        else:
            self._too_long = True

    def _line_feed(self, within: bool) -> None:
        """Report, once, that the host sends line feeds.

        `within` is True if the present line feed comes after other characters of a line.
        """
        if self.line_feeds or (self.lenient and not within) or (self.straps.checked and not self.straps.kept):
            return  # the last character may be a checksum
        self.line_feeds = True
        ends = (
            "with LF, but this part expects CR"
            if within
            else "with CR LF, but this part expects CR and treats LF as part of a command"
        )
        self.owner.finding("line-end", f"the host ends its lines {ends}: send \\r alone, without \\n")

    def take(self, item: Line | bytes) -> None:
        """Queue a complete line, or a late answer, for processing; a line is lost if another line already waits."""
        if isinstance(item, Line) and len(self.work) > 1:
            self.owner.finding(
                "line-lost", f"{item.text!r} was lost: one line was being processed and another was waiting"
            )
            return
        self.work.append(item)
        if self.answering:
            return
        self.answering, self.owner.idle = True, False
        if self.worker is None:
            self.worker = self.kernel.spawn(self._work, name=f"{self.owner.name} answers")
        else:
            self.kernel.wake(self.worker)

    async def _work(self) -> None:
        owner, clock = self.owner, self.owner.clock
        while True:
            if not self.work:
                self.answering = False
                owner.refresh_idle()
                await suspended()
            item = self.work[0]
            if isinstance(item, Line):
                owner.busy(True)
                if owner.on_command.listeners and (data := owner.meant(item)) is not None:
                    owner.on_command(data.decode("latin-1"))
                await until(self.kernel, clock.ps(clock.ticks_from(item.end_ps + self.turnround_ps)))
                await next_round(self.kernel)  # a line acts after all timed work of its instant
                owner.sync()
                answers = await owner.obey(item)
                owner.busy(False)
                if owner.on_command.listeners:
                    owner.on_command(owner.under_way)
            else:
                answers = [item]
            driver = owner.drivers["txd"]
            for answer in answers:
                await until(self.kernel, begin_line(driver, self.frames, answer + b"\r"))
                driver.release()
            self.work.popleft()


def _line_end(data: bytes, at: int) -> int:
    """Return the index of the first carriage return or line feed at or after `at`; -1 if there is none."""
    end = data.find(b"\r", at)
    feed = data.find(b"\n", at)
    return end if feed < 0 else feed if end < 0 else min(end, feed)


class InLines:
    """A mixin for chips on a serial line, with properties for users and hosts; it precedes `Chip` among the bases."""

    _for_users: ClassVar[tuple[str, ...]] = ("baud", "checked")
    line: LineInterface

    @property
    def answering(self) -> bool:
        """True while a line is in progress, or its answer is being sent."""
        return self.line.answering

    @property
    def unfinished(self) -> str:
        """The characters of the line that has not ended yet, as text."""
        return self.line.unfinished

    @property
    def _how_to_end(self) -> str:
        """A hint on ending an unfinished line, with a remark if it contains unprintable characters."""
        return f"{super()._how_to_end}{self.line.odd}"  # type: ignore[misc]  # of Chip

    @property
    def baud(self) -> int:
        """The rate at which the chip receives, in baud; 0 before it has read its straps."""
        return self.line.baud

    @property
    def checked(self) -> bool:
        """True while lines carry a checksum, which the straps select."""
        return self.line.straps.checked

    def strapped_address(self) -> int:
        """Return the address, selected by the pins, with which the chip's lines begin; 0 for none."""
        return self.line.straps.address


class LineChip(InLines, Chip):
    """A chip that receives commands as lines of text over RS-232.

    Attributes:
        straps: the levels of the pins that select baud rate, address and checksums.
        turnround_ps: the time from the end of a line to the start of its answer, ps.
        up_ps: the time at which the supply was switched on, ps.
        done: the answer of `obey` to a command whose method returns None.
        refused: the answer of `obey` to a line that is not a command.
        lenient: True if a line feed between two lines is ignored.
        answering: True from the carriage return of a line to the end of its answer.
    """

    straps: Straps
    turnround_ps = TURNROUND_PS
    up_ps = 0
    done, refused = b"OK", b"?"
    lenient = False

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        port = serial_line(self.sheet)
        self.straps = Straps(port, self.pins, kept=KEPT)
        longest = dialect_of(self.sheet).longest or 256
        self.line = LineInterface(
            self, port, self.straps, longest=longest, turnround_ps=self.turnround_ps, lenient=self.lenient
        )

    async def obey(self, line: Line) -> Sequence[bytes]:
        """Execute a line; return the answers, without their carriage returns.

        This default calls the method named after the command's row (do_loop for LOOP), which returns the answer.
        """
        command = parse(self.sheet, line.text.decode("ascii", "replace"))
        if isinstance(command, Refusal):
            self.finding("refused", refusal(self.sheet, line.text.decode("ascii", "replace"), command))
        if line.faulty or line.too_long or isinstance(command, Refusal):
            return [self.refused]
        answer = getattr(self, command.row.handler)(*command.values)
        if isawaitable(answer):
            answer = await answer
        return [self.done if answer is None else str(answer).encode("ascii")]

    def meant(self, line: Line) -> bytes | None:
        """Return the command in a line, without address and checksum; this default returns the whole line."""
        return line.text

    @property
    def under_way(self) -> str:
        """Work in progress other than a line from the host, as text; "" for none."""
        return ""

    def busy(self, on: bool) -> None:
        """Show on a pin, if the chip has one for this, that a line is in progress (True) or finished (False)."""

    def refresh_idle(self) -> None:
        """Update `idle` after something has begun or ended."""
        self.idle = not self.answering

    def listen(self) -> None:
        """Begin to receive, at the baud rate that the straps now select."""
        self.line.listen()

    def hang_up(self) -> None:
        """Stop receiving and sending, because the supply is off."""
        self.line.hang_up()


def serial_line(sheet: Sheet) -> SerialLine:
    """Return the serial line among the channels of a sheet.

    Raises:
        UsageError: the sheet has no serial line.
    """
    port = sheet.channel(SerialLine)
    if port is None:
        raise UsageError(f"{sheet.part}: a chip with a line interface needs a SerialLine among its channels")
    return port
