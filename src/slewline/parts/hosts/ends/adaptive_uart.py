r"""The UART of a host of a chip that finds the rate: two carriage returns first, then commands; CTS says when to wait.

    txd  \r\r ? P\r -------> rxd                       three or four wires, TTL levels
    rxd  <----- P=00000000\r txd
    cts  <------------------ the part's flow pin       low: the next character may begin

The host goes by CTS while the part uses its pin for that, as far as it knows from the mode commands that it has sent
itself; `heed` makes it go by others, or lets it ignore CTS.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from ....core.datasheet.channel import AdaptiveLine
from ....core.wires.characters import Character
from ....core.wires.serial import TTL, CharacterFormat, LineSetting
from ....core.wires.waits import edge, first_of, until
from ...base.written_data import as_bytes
from ...lines.host_uart import POWER_UP_PS, SILENCE_PS, HostUart
from .shadow import FlowControl, Shadow

if TYPE_CHECKING:
    from ...base.part import Part
    from ..connection import Connection

USUAL_BAUD = 9600
RETURNS = b"\r\r"  # by which the chip finds the rate
RESET_PS = 20 * 10**9  # a host gives a chip so long after a reset, which begins with its supply


class Found(NamedTuple):
    """What a chip listens at that has found the rate."""

    setting: LineSetting
    set_by: str

    def instead(self, _baud: int | str) -> str:
        """Return what would let it listen at another rate."""
        return "two carriage returns after a reset"


class AdaptiveUart(HostUart):
    """A UART that begins with two carriage returns as long as the chip does not know the rate, and goes by CTS.

    Args:
        baud: the rate at which it speaks.
        strapped: the rate that the chip has without looking for one; None: it looks.
    """

    burst = 1  # each character looks at CTS

    def __init__(self, part: Part, chip: Connection, baud: int | None, strapped: int | None) -> None:
        sheet = chip.sheet
        channel = sheet.through(AdaptiveLine)
        self.chip, self.port, self.strapped = chip.name, channel, strapped
        super().__init__(part, LineSetting(USUAL_BAUD if baud is None else baud, self._word), TTL)
        self.cts = part.add_pin("cts", "in", "low: clear to send", pull=1).net
        self.shadow = Shadow(sheet, self._lost)  # as characters are queued
        self.gone = Shadow(sheet)
        self.control = FlowControl(chip, channel, self.name, self.gone)
        self.news = self.control.news
        self.adapted = self.was_reset = False
        self.fixed_baud: int | str | None = baud
        self.returns = 0  # carriage returns one after the other, while no rate is known
        self.listens_ps = chip.up_ps + POWER_UP_PS  # by then the chip listens
        self._forget()
        reset = sheet.role("reset")
        if reset is not None:
            chip.pins[reset.name].net.watch(lambda _net: self.switched_on())

    # ------------------------------------------------------------------------------------------- what the chip knows
    def switched_on(self) -> None:
        """Note that the chip begins again, at this instant."""
        self.shadow.reset()
        self.gone.reset()
        self.adapted, self.returns, self.far.compared = False, 0, False
        self._forget()
        self.listens_ps = self.kernel.now + RESET_PS

    def _lost(self) -> None:
        """A command that resets the chip is on its way."""
        self.adapted, self.returns, self.was_reset = False, 0, True
        self._forget()

    def _forget(self) -> None:
        """The chip has no rate any more, or that of its option."""
        self.far.ears.clear()
        if self.strapped is not None:
            self._found(self.strapped, "fixed by an option")

    def _found(self, baud: int | str, set_by: str) -> None:
        """The chip has this rate from now on."""
        self.far.ears = {self.chip: Found(LineSetting(baud, self._word), set_by)}

    @property
    def _word(self) -> CharacterFormat:
        """The format of the chip."""
        return CharacterFormat(self.port.bits, self.port.parity, self.port.stop)

    @property
    def held(self) -> bool:
        """Does CTS hold the next character?"""
        return self.control.heeds and self.cts.level != 0

    async def before_burst(self) -> None:
        """Wait until the chip can listen, and for CTS, while the host goes by it."""
        await until(self.kernel, self.listens_ps)
        while self.held:
            await first_of(self.kernel, None, (self.cts, 0), (self.news.net, None))

    def after_burst(self, data: bytes) -> None:
        """Note what has gone out."""
        for byte in data:
            self.gone.feed(byte)
        self.news.set()

    def acts(self, data: bytes, at: int) -> int:
        return data.find(b"\r", at)

    def take(self, character: Character) -> None:
        super().take(character)
        self.news.set()

    # ------------------------------------------------------------------------------------------------------- sending
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters as they are, as an input; they go out one after the other."""
        data = as_bytes(self.name, data)
        super().write(data, fault)
        for byte in data:
            if self.adapted:
                self.shadow.feed(byte)
            else:
                self.returns = self.returns + 1 if byte == RETURNS[0] else 0
                self.adapted = self.returns == len(RETURNS)
                if self.adapted and self.strapped is None:
                    self._found(self.baud, "as its two carriage returns had it")

    def send(self, data: str | bytes) -> None:
        """Queue characters; two carriage returns go first if the chip does not know the rate.

        Raises:
            UsageError: text that is not ASCII, or neither text nor bytes.
        """
        if not self.adapted:
            self.write(RETURNS, "late" if self.was_reset else "")
            self.was_reset = False
        self.write(data)

    def opened_at(self, baud: int) -> None:
        """Take notice of a rate that changes nothing: the chip would have found it."""

    async def exchange(self, command: str) -> str | bytes | None:
        """Send a command in a task, and wait until it has gone out; return the answer to a query.

        Return None where there is none: the line is silent for longer than any answer takes.
        """
        asks = command.startswith(self.shadow.dialect.query)
        query = self.shadow.query(self.name, command) if asks else None
        since = self.recent.total
        with self.kernel.outside.nested():  # in the script that asks
            self.send(self.shadow.sent(command))
        while self.outgoing:
            await edge(self.news.net)
        while query is not None and query.answered(self.received, self.recent.place(since)) is None:
            if await first_of(self.kernel, self.kernel.now + SILENCE_PS, (self.news.net, None)) is None:
                return None
        return None if query is None else query.answered(self.received, self.recent.place(since))

    def rest(self) -> None:
        """Forget what is queued, and put the line to mark."""
        super().rest()
        self.shadow.decoder.reset()
        self.gone.decoder.reset()

    # ----------------------------------------------------------------------------------------- for tests
    def spoken(self, command: str) -> bytes:
        """Return a query as it goes over the wire, in the format of the chip from now on.

        Raises:
            UsageError: a command that is not answered.
        """
        self.shadow.query(self.name, command)
        self.set_line(self.baud, self._word)
        return (b"" if self.adapted else RETURNS) + self.shadow.sent(command)

    def ends(self, command: str, data: bytes) -> bool:
        """Return whether these characters have the answer to a query."""
        return self.shadow.query(self.name, command).answered(data, 0) is not None

    def answer_in(self, command: str, data: bytes) -> str | bytes:
        """Return the answer to a query, of these characters; nothing, where there is none."""
        return self.shadow.query(self.name, command).answered(data, 0) or b""
