r"""The UART of a host whose chip detects the rate: two carriage returns first, then commands, with flow control by CTS.

    txd  \r\r ? P\r -------> rxd                       three or four wires, TTL levels
    rxd  <----- P=00000000\r txd
    cts  <------------------ the part's flow pin       low: the next character may begin

The host obeys CTS while the part uses its flow pin, as far as the mode commands that the host has sent
show; a setting makes the host always obey CTS, or ignore it.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, NamedTuple

from ....core.datasheet.channel import AdaptiveLine
from ....core.wires.characters import Characters, FrameTable
from ....core.wires.receiver import Character
from ....core.wires.serial import TTL, CharacterFormat, LineSetting
from ....core.wires.waits import edge, first_of, until
from ...base.written_data import as_bytes
from ...lines.host_uart import BURST, POWER_UP_PS, SILENCE_PS, HostUart
from .shadow import FlowControl, Shadow

if TYPE_CHECKING:
    from ...base.part import Part
    from ..connection import Connection

USUAL_BAUD = 9600
LINES = re.compile(rb"[^\r]*\r|[^\r]+")
RETURNS = b"\r\r"  # from which the chip detects the rate
RESET_PS = 20 * 10**9  # pause of a host after a reset; a reset begins when the supply comes up


class Found(NamedTuple):
    """The line setting of a chip whose rate is known, and, in words, how the rate was set (`set_by`)."""

    setting: LineSetting
    set_by: str

    def instead(self, _baud: int | str) -> str:
        """Return a text on how to make the chip use another rate."""
        return "two carriage returns after a reset"


class AdaptiveUart(HostUart):
    """A UART that obeys CTS, and first sends two carriage returns if the chip has yet to detect the rate.

    Args:
        baud: the rate of the UART; None: 9600.
        strapped: the fixed rate of the chip; None: the chip detects the rate.
    """

    longest = BURST  # characters sent as one line; the twin sends each by itself
    begun: tuple[int, FrameTable] | None = None  # when the line being sent has begun (ps), and its format
    recorded = 0  # the number of its characters that are recorded as sent

    def __init__(self, part: Part, chip: Connection, baud: int | None, strapped: int | None) -> None:
        sheet = chip.sheet
        channel = sheet.through(AdaptiveLine)
        self.chip, self.port, self.strapped = chip.name, channel, strapped
        super().__init__(part, LineSetting(USUAL_BAUD if baud is None else baud, self._word), TTL)
        self.cts = part.add_pin("cts", "in", "low: clear to send", pull=1).net
        self.cts.watch(lambda _net: self.cut())
        self.shadow = Shadow(sheet, self._lost)  # as characters are queued
        self.gone = Shadow(sheet)
        self.control = FlowControl(chip, channel, self.name, self.gone)
        self.news = self.control.news
        self.adapted = self.was_reset = False
        self.fixed_baud: int | str | None = baud
        self.returns = 0  # consecutive carriage returns, while no rate is known
        self.listens_ps = chip.up_ps + POWER_UP_PS  # the instant from which the chip receives
        self._forget()
        reset = sheet.role("reset")
        if reset is not None:
            chip.pins[reset.name].net.watch(lambda _net: self.switched_on())

    # --------------------------------------------------------------------------------------------- state of the chip
    def switched_on(self) -> None:
        """Record that the chip restarts at this instant."""
        self.cut()
        self.shadow.reset()
        self.gone.reset()
        self.adapted, self.returns, self.far.compared = False, 0, False
        self._forget()
        self.listens_ps = self.kernel.now + RESET_PS

    def _lost(self) -> None:
        """Record that a command that resets the chip is being sent."""
        self.adapted, self.returns, self.was_reset = False, 0, True
        self._forget()

    def _forget(self) -> None:
        """Record that the chip no longer has a detected rate: it has its fixed rate (`strapped`), or none."""
        self.far.receivers.clear()
        if self.strapped is not None:
            self._found(self.strapped, "fixed by an option")

    def _found(self, baud: int | str, set_by: str) -> None:
        """Record that the chip has this rate from now on; `set_by` describes how the rate was set."""
        self.far.receivers = {self.chip: Found(LineSetting(baud, self._word), set_by)}

    @property
    def _word(self) -> CharacterFormat:
        """Character format of the chip."""
        return CharacterFormat(self.port.bits, self.port.parity, self.port.stop)

    @property
    def waits_for_rate(self) -> bool:
        """True while CTS delays the next character."""
        return self.control.heeds and self.cts.level != 0

    async def before_burst(self) -> None:
        """Wait until the chip can receive, and, if the host obeys CTS, until CTS permits sending."""
        await until(self.kernel, self.listens_ps)
        while self.waits_for_rate:
            await first_of(self.kernel, None, (self.cts, 0), (self.news.net, None))
        if not self.gone.ascii or self.listens_ps > self.kernel.now:  # a byte may end a command; the chip has restarted
            self._split(1)
        self.begun = self.kernel.now, self.frames

    def after_burst(self, data: bytes) -> None:
        """Record the characters sent."""
        self.gone.take(data[self.recorded :])
        self.begun, self.recorded = None, 0
        self.news.set()

    def bursts(self, data: bytes, fault: str) -> list[bytes]:
        """Return the parts of `data` between which nothing can affect how they are sent: each command."""
        length = 1 if fault or not data.isascii() else self.longest
        return [line[at : at + length] for line in LINES.findall(data) for at in range(0, len(line), length)]

    def _split(self, number: int) -> None:
        """Make a separate line of the first `number` characters of the next line, or of the line being sent."""
        data, fault = self.outgoing[0]
        if number < len(data):
            self.outgoing[0] = data[number:], fault
            self.outgoing.appendleft((data[:number], fault))

    @property
    def _complete(self) -> int:
        """The number of characters of the line being sent that are complete, its last one excepted."""
        if self.begun is None:
            return 0
        start, frames = self.begun
        return min((self.kernel.seen - start) // frames.length, len(self.outgoing[0][0]) - 1)

    def cut(self) -> None:
        """End the line being sent after the present character, because something may change how the rest is sent."""
        if self.begun is None or self.sender is None:
            return
        complete = self._complete
        self.gone.take(self.outgoing[0][0][self.recorded : complete])
        self.recorded = complete
        if complete + 1 < len(self.outgoing[0][0]):
            self._split(complete + 1)
            start, frames = self.begun
            line = Characters(frames, self.outgoing[0][0], start)
            self.driver.drive(line)
            self.kernel.wake_at(line.end, self.sender)
            self.kernel.settle()

    def drop(self, verb: str) -> None:
        """Drop the queued characters, except the one being sent; this call is recorded as the part's input `verb`."""
        self.cut()
        if self.begun is None and self.outgoing:
            self._split(1)
        super().drop(verb)

    def space(self, on: bool) -> None:
        """Begin (True) or end (False) a break, within which a queued character may begin; recorded as an input."""
        self.cut()
        super().space(on)

    def set_line(self, baud: int | str, word: CharacterFormat) -> None:
        self.cut()
        super().set_line(baud, word)

    @property
    def backlog(self) -> int:
        """Number of characters not yet sent, including the one being sent."""
        return super().backlog - self._complete

    def acts(self, data: bytes, at: int) -> int:
        return data.find(b"\r", at)

    def take(self, character: Character) -> None:
        super().take(character)
        self.news.set()

    # ------------------------------------------------------------------------------------------------------- sending
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters to be sent unchanged, each with `fault` if given; record the call as the part's input."""
        data = as_bytes(self.name, data)
        super().write(data, fault)
        for byte in data:
            if self.adapted:
                self.shadow.feed(byte)
            else:
                self.returns = self.returns + 1 if byte == RETURNS[0] else 0
                self.adapted = self.returns == len(RETURNS)
                if self.adapted and self.strapped is None:
                    self._found(self.baud, "detected from its two carriage returns")

    def send(self, data: str | bytes) -> None:
        """Queue characters, after two carriage returns if the chip does not know the rate.

        Raises:
            UsageError: the text is not ASCII, or the data are neither text nor bytes.
        """
        if not self.adapted:
            self.write(RETURNS, "late" if self.was_reset else "")
            self.was_reset = False
        self.write(data)

    def opened_at(self, baud: int) -> None:
        """Do nothing: the rate that a program chooses needs no report, because a real chip would detect that rate."""

    async def exchange(self, command: str) -> str | bytes | None:
        """Send a command from within a task, and wait until it has been sent; if it is a query, return its answer.

        Return None for a command that is not a query, or if the line has been silent for longer than any
        answer takes.
        """
        asks = command.startswith(self.shadow.dialect.query)
        query = self.shadow.query(self.name, command) if asks else None
        since = self.recent.total
        with self.kernel.outside.nested():  # in the calling script
            self.send(self.shadow.sent(command))
        while self.outgoing:
            await edge(self.news.net)
        while query is not None and query.answered(self.received, self.recent.place(since)) is None:
            if await first_of(self.kernel, self.kernel.now + SILENCE_PS, (self.news.net, None)) is None:
                return None
        return None if query is None else query.answered(self.received, self.recent.place(since))

    def rest(self) -> None:
        """Drop all queued characters, and set the line to mark."""
        super().rest()
        self.begun, self.recorded = None, 0
        self.shadow.decoder.reset()
        self.gone.decoder.reset()

    # ----------------------------------------------------------------------------------------- for tests
    def spoken(self, command: str) -> bytes:
        """Return the bytes to send for a query, and use the character format of the chip from now on.

        Raises:
            UsageError: the command has no answer.
        """
        self.shadow.query(self.name, command)
        self.set_line(self.baud, self._word)
        return (b"" if self.adapted else RETURNS) + self.shadow.sent(command)

    def ends(self, command: str, data: bytes) -> bool:
        """Return whether these characters contain the answer to a query."""
        return self.shadow.query(self.name, command).answered(data, 0) is not None

    def answer_in(self, command: str, data: bytes) -> str | bytes:
        """Return the answer to a query, as found in these characters; empty if they contain none."""
        return self.shadow.query(self.name, command).answered(data, 0) or b""
