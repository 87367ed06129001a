r"""A host on a bus that works both ways: commands out, messages in, a handshake a byte, and FPL says which.

    command     wait BUSY high; IO_REQUEST low, bus open, wait BUSY low: FPL high, so the part listens; IO_REQUEST high
                then for each byte: wait BUSY high, byte on the bus, IO_REQUEST low, wait BUSY low, IO_REQUEST high
    message     FPL low: IO_REQUEST low, wait BUSY low, take the byte, IO_REQUEST high, wait BUSY high, while it is low

The empty handshake in front of a command is what a part wants whose program may run, and ignores otherwise.  A host
that finds FPL low in it takes the message first (ch. 16, Immediate Commands), and so does one with its letter on the
bus: it lets go, for the part answers somebody on its serial side.  The host goes by FPL while it is in use, as far as
it knows from the mode commands that it has sent itself; `heed` tells it of others.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

from ...core.time.inputs import from_outside
from ...core.wires.bell import Bell
from ...core.wires.net import Driver, Net
from ...core.wires.pin import Condition, GotCondition
from ...core.wires.waits import edge, first_of, level, until
from ...errors import Timeout, UsageError
from ..base.part import served
from ..base.worker import Data, as_bytes
from .shadow import Query, Shadow, ShadowHost

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel, Task
    from ...core.time.timebase import Time
    from ..base.caller import Errand
    from .connection import Connection

EMPTY = 0xFF


class FlowHost(ShadowHost):
    """A host computer on the bus of one chip.

    `received` is what messages brought.

    Args:
        delay_ps: what the host's program takes before each byte.
    """

    for_users: ClassVar[tuple[str, ...]] = (
        "prefix",
        "sent",
    )

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[Connection], delay_ps: int = 0) -> None:
        super().__init__(kernel, name, chips)
        sheet, pins = chips[0].sheet, chips[0].pins
        self.delay_ps = delay_ps

        def line(role: str) -> Net:
            row = sheet.role(role)
            assert row is not None  # such a channel has it
            return pins[row.name].net

        self.busy, self.flow = line("ready"), line("flow")
        self.request, self.bus = Driver(line("request"), name), Driver(chips[0].bus, name)
        self.request.drive(1)
        self.received: bytearray = bytearray()
        self.sent = 0
        self.shadow = self.gone = Shadow(sheet)
        self.empty_first = True
        self.turn = Bell(kernel, f"{name}.(turn)")
        self.taken = False  # somebody is using the lines
        self.listener: Task | None = None
        line("reset").watch(lambda _net: self.shadow.reset())

    def switched_on(self) -> None:
        """Note that the part has been switched on, at this instant."""
        self.shadow.reset()

    def rewired(self) -> None:
        """Begin to listen: the host is wired, and time is about to pass."""
        self._listen_again()

    def _listen_again(self) -> None:
        if self.listener is not None:
            self.listener.kill()
        self.taken = False
        self.listener = self.kernel.spawn(self._listen, name=f"{self.name} listens")

    @property
    def offered(self) -> bool:
        """Is there a message for the host?"""
        return self.heeds and self.flow.level == 0

    @property
    def idle(self) -> bool:
        """Nothing is queued, and no message is being read."""
        return not self.taken and not self.offered and super().idle

    def rest(self) -> None:
        """Let go of the bus, and ask for nothing; listen anew, for whatever was under way was cut short."""
        self.request.drive(1)
        self.bus.drive(None)
        self.shadow.decoder.reset()
        self._listen_again()

    # ------------------------------------------------------------------------------------------------------- the lines
    async def _take_turn(self) -> None:
        while self.taken:
            await edge(self.turn.net)
        self.taken = True

    def _give_turn(self) -> None:
        self.taken = False
        self.turn.ring()

    async def _free(self) -> None:
        """Wait until the part takes a byte; messages are read before."""
        while True:
            if self.offered:
                await level(self.busy, 1)
                await self._message()
            elif self.busy.level != 1:
                await first_of(self.kernel, None, (self.busy, 1), *self._flows)
            else:
                return

    @property
    def _flows(self) -> tuple[tuple[Net, int], ...]:
        return ((self.flow, 0),) if self.heeds else ()

    async def _message(self, asked: bool = False) -> None:
        """Read until FPL is high; `asked`: IO_REQUEST is low already."""
        while asked or self.offered:
            self.request.drive(0)
            await level(self.busy, 0)
            if self.bus.net.level is None:
                self._no_message()
            else:
                self.received.append(self.bus.net.byte)  # type: ignore[attr-defined]
            self.news.ring()
            self.request.drive(1)
            await level(self.busy, 1)
            asked = False

    def _no_message(self) -> None:
        """Look at FPL no longer: its pin was low, and nobody drives the bus."""
        self.heeding = False
        self.finding(
            "no-message",
            f"the pin of FPL is low, and {self.chip.name} had nothing to say, but took an empty handshake: the mode is "
            f"not that which {self.name} has set; heed(True) or heed(None) lets it look at FPL again",
        )

    async def _empty_handshake(self) -> None:
        """Ask without a byte until the part listens; what it has to say comes first."""
        while True:
            await self._free()
            self.request.drive(0)
            await first_of(self.kernel, None, *self._flows, (self.busy, 0))
            if self.offered:
                await self._message(asked=True)
                continue
            self.request.drive(1)
            return

    async def _listen(self) -> None:
        """Read messages that come while nothing is sent."""
        while True:
            if not self.offered:
                await first_of(self.kernel, None, (self.news.net, None), *self._flows)
                continue
            await level(self.busy, 1)
            await self._take_turn()
            try:
                if self.offered:
                    await self._message()
            finally:
                self._give_turn()

    async def send_now(self, data: bytes) -> None:
        """Send bytes; an FF where a command begins is an empty handshake."""
        await self._take_turn()
        try:
            for byte in data:
                begins = self.shadow.at_letter
                if begins and (self.empty_first or byte == EMPTY):
                    await self._empty_handshake()
                    self.begun = True
                if not begins or byte != EMPTY:
                    await self._byte(byte, begins)
        finally:
            self.bus.drive(None)
            self._give_turn()

    async def _byte(self, byte: int, begins: bool) -> None:
        """Offer a byte until the part takes it; the answer to another host may come before a letter."""
        while True:
            await self._free()
            if self.delay_ps:
                await until(self.kernel, self.kernel.now + self.delay_ps)
            self.begun = True
            self.bus.drive((0xFF, byte))
            self.request.drive(0)
            if not begins:
                await level(self.busy, 0)
                break
            await first_of(self.kernel, None, *self._flows, (self.busy, 0))
            if not self.offered:
                break
            self.bus.drive(None)
            await self._message(asked=True)
        self.request.drive(1)
        self.bus.drive(None)
        self.sent += 1
        self.shadow.feed(byte)
        self.news.ring()  # FPL may be in use from now on

    async def ask_now(self, data: bytes, query: Query) -> str | bytes:
        """Send a query, and wait until it is answered."""
        since = len(self.received)
        await self.send_now(data)
        while (found := query.answered(self.received, since)) is None:
            await edge(self.news.net)
        return found

    # ------------------------------------------------------------------------ the queue, which is what a journal keeps
    @from_outside
    def write(self, chip: str, data: Sequence[int]) -> None:
        """Queue bytes for a chip."""
        served(self.name, self.chips, chip)
        data = bytes(data)
        self.input("write", chip, data)
        if data:
            self.work(f"sends to {chip}", lambda: self.send_now(data))

    @from_outside
    def query(self, chip: str, command: str) -> Errand[str | bytes]:
        """Queue a query, in the form of the mode at its turn."""
        served(self.name, self.chips, chip)
        self.shadow.query(self.name, command)
        self.input("query", chip, command)

        async def ask() -> str | bytes:
            shadow = self.shadow
            return await self.ask_now(shadow.sent(command), shadow.query(self.name, command))

        return self.errand(f"asks {chip} {command!r}", ask)

    @from_outside
    def prefix(self, on: bool) -> None:
        """Begin every command with the empty handshake (True, from the beginning on), or with its letter (False).

        Raises:
            UsageError: neither of the two.
        """
        if not isinstance(on, bool):
            raise UsageError(f"{self.name}: prefix({on!r}); allowed True, False")
        self.input("prefix", on)
        self.empty_first = on

    # -------------------------------------------------------------------------------------------------- out and back
    def send(self, data: str | bytes) -> None:
        """Queue bytes; they go out as fast as the handshake allows.  No time passes.

        Raises:
            UsageError: text that is not ASCII, or neither text nor bytes.
        """
        self.write(self.chip.name, as_bytes(self.name, data))

    def got(self, data: Data) -> Condition:
        """Return a condition for `bench.run_until`: messages have brought these bytes, one behind the other."""
        return GotCondition(self.name, self.received, as_bytes(self.name, data))

    def ask(self, command: str, timeout: Time = "5 s") -> str | bytes:
        """Send a query such as "? P", and return what the part answers on the bus: text, or bytes in binary mode.

        Raises:
            UsageError: a command that is not answered.
            Timeout: no answer; the mode register may send it elsewhere.
        """
        try:
            return self.answer_of(self.query(self.chip.name, command), timeout)
        except Timeout as error:
            if not (why := self.why_silent()):
                raise
            raise Timeout(f"{error}\n  {why}") from None
