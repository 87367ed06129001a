r"""A host on a serial line that finds its rate: two carriage returns first, then commands; CTS tells when to wait.

    txd  \r\r ? P\r -------> rxd                       three or four wires, TTL levels
    rxd  <----- P=00000000\r txd
    cts  <------------------ the part's flow pin       low: the next character may begin

The host goes by CTS while the part uses its pin for that, as far as it knows from the mode commands that it has sent
itself; `heed` tells it of others, or lets it ignore CTS.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from ...core.datasheet.channel import AdaptiveLine
from ...core.time.kernel import Task
from ...core.wires.serial import Character, Setting, Word
from ...core.wires.waits import edge, first_of, until
from ...errors import Timeout
from ..base.worker import as_bytes
from ..lines.rs232 import POWER_UP_PS, SILENCE_PS
from .line_host import LineHost
from .shadow import Shadow, ShadowHost

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from ...core.time.timebase import Time
    from .connection import Connection

USUAL_BAUD = 9600
RETURNS = b"\r\r"  # by which the chip finds the rate
RESET_PS = 20 * 10**9  # a host gives a chip so long behind a reset, which begins with its supply


class Found(NamedTuple):
    """What a chip listens at that has found the rate."""

    setting: Setting
    set_by: str

    def instead(self, _baud: int | str) -> str:
        """Return what would let it listen at another rate."""
        return "two carriage returns behind a reset"


class AdaptiveHost(LineHost, ShadowHost):
    """A host computer on the serial line of one chip that finds the rate.

    `send` and `ask` begin with two carriage returns as long as the chip does not know the rate; `write` sends
    characters as they are.

    Args:
        baud: the rate at which it speaks.
        strapped: the rate that the chip has without looking for one; None: it looks.
    """

    wiring = MappingProxyType({"txd": "serial_in", "rxd": "serial_out", "cts": "flow"})
    burst = 1  # each character looks at CTS

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        chips: Sequence[Connection],
        *,
        baud: int | None = None,
        strapped: int | None = None,
    ) -> None:
        channel, sheet, pins = chips[0].channel, chips[0].sheet, chips[0].pins
        assert isinstance(channel, AdaptiveLine)
        rate = USUAL_BAUD if baud is None else baud
        self.strapped = strapped
        super().__init__(kernel, name, baud=rate, bits=channel.bits, parity=channel.parity, stop=channel.stop, ttl=True)
        self.add_pin("cts", "in", "low: clear to send", pull=1)
        self.join(chips)
        self.port = channel
        self.shadow = Shadow(sheet, self._lost)  # as characters are queued
        self.gone = Shadow(sheet)
        self.sender: Task | None
        self.adapted = self.was_reset = False
        self.fixed_baud: int | str | None = baud
        self.returns = 0  # carriage returns one behind the other, while no rate is known
        self.listens_ps = chips[0].up_ps + POWER_UP_PS  # by then the chip listens
        self._forget()
        reset = sheet.role("reset")
        if reset is not None:
            pins[reset.name].net.watch(lambda _net: self.switched_on())

    # ------------------------------------------------------------------------------------------- what the chip knows
    def switched_on(self) -> None:
        """Note that the chip begins anew, at this instant."""
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
        self.far.ears = {self.chip.name: Found(Setting(baud, self._word), set_by)}

    @property
    def _word(self) -> Word:
        """The format of the chip."""
        return Word(self.port.bits, self.port.parity, self.port.stop)

    @property
    def held(self) -> bool:
        """Does CTS hold the next character?"""
        return self.heeds and self.pins["cts"].net.level != 0

    async def before_burst(self) -> None:
        """Wait until the chip can listen, and for CTS, while the host goes by it."""
        await until(self.kernel, self.listens_ps)
        while self.held:
            await first_of(self.kernel, None, (self.pins["cts"].net, 0), (self.news.net, None))

    def after_burst(self, data: bytes) -> None:
        """Note what has gone out."""
        for byte in data:
            self.gone.feed(byte)
        self.news.ring()

    def take(self, character: Character) -> None:
        """Receive a character."""
        super().take(character)
        self.news.ring()

    # ------------------------------------------------------------------------------------------------------- sending
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters as they are; they go out one behind the other."""
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

    def ask(self, command: str, timeout: Time = "5 s") -> str | bytes:
        """Send a query such as "? P", and return what the chip answers on the line: text, or bytes in binary mode.

        Raises:
            UsageError: a command that is not answered.
            Timeout: no answer; the mode register may send it elsewhere.
        """
        query = self.shadow.query(self.name, command)
        since = len(self.received)
        self.send(self.shadow.sent(command))
        try:
            self.kernel.outside.wait(
                lambda: query.answered(self.received, since) is not None,
                f"{self.name}: an answer to {command!r}",
                timeout,
            )
        except Timeout as error:
            self.give_up()
            if not (why := "\n  ".join(filter(None, (self.far.disagreement, self.why_silent())))):
                raise
            raise Timeout(f"{error}\n  {why}") from None
        return query.answered(self.received, since) or ""

    async def exchange(self, command: str) -> str | bytes | None:
        """Send a command in a task, and wait until it has gone out; return the answer to a query.

        Return None where there is none: the line is silent for longer than any answer takes.
        """
        asks = command.startswith(self.shadow.dialect.query)
        query = self.shadow.query(self.name, command) if asks else None
        since = len(self.received)
        with self.kernel.outside.nested():  # in the script that asks
            self.send(self.shadow.sent(command))
        while self.outgoing:
            await edge(self.news.net)
        while query is not None and query.answered(self.received, since) is None:
            if await first_of(self.kernel, self.kernel.now + SILENCE_PS, (self.news.net, None)) is None:
                return None
        return None if query is None else query.answered(self.received, since)

    def rest(self) -> None:
        """Forget what is queued, and put the line to mark."""
        super().rest()
        self.shadow.decoder.reset()
        self.gone.decoder.reset()

    # ----------------------------------------------------------------------------------------- as a test has need of it
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
