"""What chips on a serial line share: lines in, answers out, one line in work at a time.

    rxd   ... characters ... CR                               characters go into a line until its carriage return;
    txd                         |<- turnround ->| answer CR   then the line is obeyed; its effect shows with it

While an answer is on its way one further line is kept; what comes beyond that is lost.  A chip brings its sheet (with a
serial line among its channels, and the dialect of lines), and a method for each command or an `obey` of its own.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from inspect import isawaitable
from typing import Any, NamedTuple

from ..core.chip import Chip
from ..core.datasheet.channel import SerialLine
from ..core.time.kernel import Kernel, Task
from ..core.wires.serial import RS232, Receiver, Straps, Word, bit_clock, transmit
from ..core.wires.waits import next_round
from ..language.dialect import Refusal, dialect_of
from ..language.lines import KEPT, parse, refusal

CR, LF = 0x0D, 0x0A
TURNROUND_PS = 10**9


class Line(NamedTuple):
    """A line as it came, without its carriage return."""

    text: bytes
    faulty: bool  # a character of it had a parity or framing fault
    first_faulty: bool  # and it was the first one
    too_long: bool
    checked: bool  # a checksum was asked for at its carriage return; it rules the answer, too
    end_ps: int


class LineChip(Chip):
    """A chip that is spoken to in lines over RS-232.

    `answering` is true from the carriage return of a line to the end of its answer.
    """

    straps: Straps
    turnround_ps = TURNROUND_PS
    baud = 0  # the rate at which it listens
    up_ps = 0  # when the supply was switched on
    done, refused = b"OK", b"?"  # what `obey` answers where a command says nothing, and to what is no command
    lenient = False  # forgive a line feed between two lines

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        port = self.sheet.channel(SerialLine)
        assert port is not None  # a mistake in the sheet of the chip
        self.port: SerialLine = port
        self.straps = Straps(self.port, self.pins, kept=KEPT)
        self.longest = dialect_of(self.sheet).longest or 256  # characters of a line
        self.work: deque[Line | bytes] = deque()  # lines to obey, and answers that came late
        self.worker: Task | None = None
        self.listener: Task | None = None
        self.receiver: Receiver | None = None
        self.coming = bytearray()  # the line that has not ended
        self.line_feeds = False  # one has come, and been told of

    # --------------------------------------------------------------------------------------------------- public face
    @property
    def answering(self) -> bool:
        """Is a line in work, or its answer on its way?"""
        return self.worker is not None

    @property
    def unfinished(self) -> str:
        return self.coming.decode("latin-1")

    @property
    def how_to_end(self) -> str:
        """What to do about a line that has come without its end; one of odd characters was sent in another format."""
        odd = any(not 0x20 <= byte < 0x7F for byte in self.coming.replace(b"\n", b""))
        here = f"; such characters come of another rate or format than {self.straps.setting.in_full}" if odd else ""
        return super().how_to_end + here

    async def obey(self, line: Line) -> Sequence[bytes]:
        """Do what a line says; returns the answers, without their carriage returns.

        As it stands here: the method named after the row of the command is called, and what it returns is the answer.
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
        """What a line says to this chip, without address and checksum; None: nothing, or it is for another one."""
        return line.text

    @property
    def under_way(self) -> str:
        """What the chip works on besides a line of the host."""
        return ""

    def busy(self, on: bool) -> None:
        """The chip begins or ends to work on a line; a chip with a pin for it shows it there."""

    def refresh_idle(self) -> None:
        """Something has begun or ended."""
        self.idle = not self.answering

    # --------------------------------------------------------------------------------------------------------- line
    @property
    def checked(self) -> bool:
        """Do lines carry a checksum at present?"""
        return self.straps.checked

    @property
    def kept(self) -> int:
        """The bits that its checksums always have."""
        return self.straps.kept

    def strapped_address(self) -> int:
        """Return the address that stands in front of its lines, as the pins say; 0: none."""
        return self.straps.address

    def listen(self) -> None:
        """Begin to receive, at the rate that the straps say now."""
        self.word = Word(self.port.bits, self.port.parity, self.port.stop)
        self.baud = self.straps.take()
        self.bits = bit_clock(self.baud, self.name)
        self.listener = self.kernel.spawn(self._listen, name=f"{self.name} listens")
        self.refresh_idle()

    def hang_up(self) -> None:
        """No line any more: the supply is off."""
        for task in (self.listener, self.worker):
            if task is not None:
                task.kill()
        if self.receiver is not None:
            self.receiver.close()
        self.listener = self.worker = self.receiver = self.straps.taken = None
        self.work.clear()
        self.coming.clear()

    async def _listen(self) -> None:
        receiver = self.receiver = Receiver(self.pins["rxd"].net, self.bits, self.word, RS232)
        text, faulty, first, too_long = self.coming, False, False, False
        while True:
            character = await receiver.character()
            byte = character.byte
            if byte == LF and character.good:
                self._line_feed(bool(text))
            if byte == CR:
                faulty |= not character.good
                self.take(Line(bytes(text), faulty, first, too_long, self.checked, character.end_ps))
                text.clear()
                faulty = first = too_long = False
            elif byte == LF and self.lenient and not text:
                continue
            elif len(text) < self.longest:
                first |= not text and not character.good
                faulty |= not character.good
                text.append(byte)
            else:
                too_long = True

    def _line_feed(self, within: bool) -> None:
        """Report once that the host sends line feeds."""
        if self.line_feeds or (self.lenient and not within) or (self.checked and not self.kept):
            return  # the last: it may be a checksum
        self.line_feeds = True
        ends = "with LF; this part wants CR" if within else "with CR LF; this part wants CR, and takes LF for a command"
        self.finding("line-end", f"the host ends its lines {ends}: send \\r alone, without \\n")

    def take(self, item: Line | bytes) -> None:
        """A line is complete, or an answer that took its time is ready."""
        if isinstance(item, Line) and len(self.work) > 1:
            self.finding("line-lost", f"{item.text!r} came while a line was in work and another one waited: lost")
            return
        self.work.append(item)
        if self.worker is None:
            self.worker = self.kernel.spawn(self._work, name=f"{self.name} answers")
            self.refresh_idle()

    async def _work(self) -> None:
        while self.work:
            item = self.work[0]
            if isinstance(item, Line):
                self.busy(True)
                if self.on_command and (said := self.meant(item)) is not None:
                    self.on_command(said.decode("latin-1"))
                await self.at_tick(self.clock.ticks_from(item.end_ps + self.turnround_ps))
                await next_round(self.kernel)  # a line acts after all timed work of its instant
                self.sync()
                answers = await self.obey(item)
                self.busy(False)
                if self.on_command:
                    self.on_command(self.under_way)
            else:
                answers = [item]
            for answer in answers:
                await self._send(answer + b"\r")
            self.work.popleft()
        self.worker = None
        self.refresh_idle()

    async def _send(self, data: bytes) -> None:
        """Put characters on the line, then let go of it."""
        driver = self.drivers["txd"]
        await transmit(driver, self.bits, self.word, data, RS232)
        driver.drive(None)
