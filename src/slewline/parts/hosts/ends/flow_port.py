r"""A host's port on a bidirectional bus: commands out, messages in, one handshake per byte.

FPL shows the direction:

    command     wait BUSY high; IO_REQUEST low, bus open, wait BUSY low: FPL high if the part receives;
                IO_REQUEST high; then for each byte: wait BUSY high, byte on the bus, IO_REQUEST low,
                wait BUSY low, IO_REQUEST high
    message     while FPL is low: IO_REQUEST low, wait BUSY low, read the byte, IO_REQUEST high,
                wait BUSY high

The handshake without a byte, before a command, is the empty handshake.  A part whose program may be
running needs it; a part that runs no program ignores it.  A host that finds FPL low during the empty
handshake reads the message first (ch. 16, Immediate Commands).  A host that already has its command
letter on the bus also reads the message first: it releases the bus, since the part may be answering
a command from its serial line.  The host obeys FPL while the part uses it, as far as the mode commands that
the host has sent show; a setting makes the host always obey FPL, or ignore it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ....core.datasheet.channel import FlowBus
from ....core.wires.exchange import Leader
from ....core.wires.handshake import Handshakes, TakingEnd
from ....core.wires.handshaken_bytes import HandshakenBytes
from ....core.wires.net import Driver, Net
from ....core.wires.past_handshakes import ManyCommands
from ....core.wires.waiters import Event
from ....core.wires.waits import edge, first_of, level, until
from ....core.wires.wave import FLOATING, Level, Wave
from .shadow import FlowControl, Query, Shadow

if TYPE_CHECKING:
    from ....core.time.kernel import Task
    from ....core.wires.past_handshakes import Edges
    from ...base.part import Part
    from ...base.request_queue import RequestQueue
    from ..connection import Connection

EMPTY = 0xFF


class FlowPort:
    """A host's port on the bus of its chip: drivers, the nets that the host reads, and a task that reads messages.

    Args:
        host: the host, which reports the port's findings.
        queue: the host's request queue, whose requests send bytes through the port.
        delay_ps: the time that the host's program takes before each byte, ps.
    """

    def __init__(self, chip: Connection, host: Part, queue: RequestQueue, delay_ps: int) -> None:
        self.chip, self.kernel, self.name, self.queue, self.delay_ps = (
            chip.name,
            host.kernel,
            host.name,
            queue,
            delay_ps,
        )
        self.finding = host.finding

        def line(role: str) -> Net:
            return chip.pins[chip.sheet.in_role(role).name].net

        self.busy, self.flow = line("ready"), line("flow")
        self.request, self.bus = Driver(line("request"), self.name), Driver(chip.bus, self.name)
        self.request.drive(1)
        self.received: bytearray = bytearray()
        self.recent = host.keep_recent(self.received)
        self.sent = 0
        self.shadow = Shadow(chip.sheet)
        self.control = FlowControl(chip, chip.sheet.through(FlowBus), self.name, self.shadow)
        self.empty_first = True
        self.turn = Event(self.kernel, f"{self.name}.(turn)")
        self.taken = False  # the lines are in use
        self.listener: Task | None = None
        self.bytes = FlowSender(self)
        line("reset").watch(lambda _net: self.switched_on())

    def switched_on(self) -> None:
        """Record that the part has been reset, or switched on, at this instant."""
        self.bytes.leave()  # the preceding bytes have determined the next byte
        self.shadow.reset()

    def listen(self) -> None:
        """Start, or start again, the task that receives messages."""
        if self.listener is not None:
            self.listener.kill()
        self.taken = False
        self.listener = self.kernel.spawn(self._listen, name=f"{self.name} listens")

    @property
    def offered(self) -> bool:
        """True while FPL is low, offering a message, and the host obeys FPL."""
        return self.control.heeds and self.flow.level == 0

    def rest(self) -> None:
        """Release the bus, set IO_REQUEST high, and restart the receiving task; an exchange under way is cut short."""
        self.request.drive(1)
        self.bus.drive(None)
        self.shadow.decoder.reset()
        self.listen()

    @property
    def all_sent(self) -> int:
        """The number of bytes sent so far, empty handshakes not counted."""
        self.catch_up()
        return self.sent

    def catch_up(self) -> None:
        """Record the bytes that an exchange under way has sent so far; call this before querying their number."""
        if (exchange := self.bytes.exchange) is not None and exchange.in_flight:
            self.queue.begun = True
            self.bytes.feed(exchange.in_flight)

    def awaits(self, number: int, low: bool) -> tuple[tuple[Net, int], ...]:
        """Record the progress of an exchange, and return the (net, level) pairs that the port now waits for.

        Args:
            number: the number of bytes sent so far in the exchange; an empty handshake counts as a byte.
            low: whether IO_REQUEST is low.
        """
        self.queue.begun |= number > 0
        self.bytes.feed(number)
        self.bytes.begins = self.shadow.at_letter
        return (*(self._flows if not low or self.bytes.begins else ()), (self.busy, 0 if low else 1))

    # ------------------------------------------------------------------------------------------------------- the lines
    async def _take_turn(self) -> None:
        while self.taken:
            await edge(self.turn.net)
        self.taken = True

    def _give_turn(self) -> None:
        self.taken = False
        self.turn.set()

    async def _free(self) -> None:
        """Read the messages of the part, if any, and wait until the part accepts a byte."""
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
        return ((self.flow, 0),) if self.control.heeds else ()

    async def _message(self, asked: bool = False) -> None:
        """Read the bytes of a message until FPL is high; `asked`: whether IO_REQUEST is low already."""
        while asked or self.offered:
            self.request.drive(0)
            await level(self.busy, 0)
            if self.bus.net.level is None:
                self._no_message()
            else:
                self.received.append(self.bus.net.byte)  # type: ignore[attr-defined]
            self.control.news.set()
            self.request.drive(1)
            await level(self.busy, 1)
            asked = False

    def _no_message(self) -> None:
        """Ignore FPL from now on, and report that FPL is low although nothing drives the bus."""
        self.control.heeding = False
        self.finding(
            "no-message",
            f"the FPL pin is low, but {self.chip} accepted an empty handshake instead of sending a message: the chip "
            f"is not in the mode that {self.name} has set; heed(True) or heed(None) makes the host use FPL again",
        )

    async def _empty_handshake(self, asked: bool = False) -> None:
        """Perform an empty handshake; if the part offers messages, read these first.

        `asked`: whether IO_REQUEST is low already.
        """
        while True:
            if not asked:
                await self._free()
                self.request.drive(0)
            asked = False
            await first_of(self.kernel, None, *self._flows, (self.busy, 0))
            if self.offered:
                await self._message(asked=True)
                continue
            self.request.drive(1)
            return

    async def _listen(self) -> None:
        """Read messages that arrive while nothing is sent."""
        while True:
            if not self.offered:
                await first_of(self.kernel, None, (self.control.news.net, None), *self._flows)
                continue
            await level(self.busy, 1)
            await self._take_turn()
            try:
                if self.offered:
                    await self._message()
            finally:
                self._give_turn()

    async def send(self, data: bytes) -> None:
        """Send bytes; for a byte FF at the start of a command, perform only an empty handshake."""
        await self._take_turn()
        try:
            at, exchange = 0, None if self.delay_ps else self.bytes.possible()
            begins: bool | None = None  # whether the next byte is the first of a command, when the wait for BUSY began
            while at < len(data):
                begins, byte = self.shadow.at_letter if begins is None else begins, data[at]
                empty = begins and (self.empty_first or byte == EMPTY)
                if exchange is None or not exchange.opened:
                    await self._free()
                asked = False
                if exchange is not None and self.bytes.begin(data, at, begins, empty):
                    self.queue.begun |= not empty
                    try:
                        await exchange.end()
                    finally:
                        at += self.bytes.feed(exchange.through)
                    self.queue.begun |= exchange.through > 0
                    begins, asked = self.bytes.begins, not exchange.by_value and exchange.low
                    if not asked and exchange.through != empty:
                        continue  # with the next byte
                    if asked and empty and not exchange.through:  # withdrawn in the middle of the empty handshake
                        await self._empty_handshake(asked=True)
                        asked = False
                    byte, begins = data[at], self.shadow.at_letter if begins is None else begins
                elif empty:
                    await self._empty_handshake()
                    self.queue.begun = True
                if not begins or byte != EMPTY:
                    await self._byte(byte, begins, asked)
                at, begins = at + 1, None
        finally:
            if not self.bytes.by_value:
                self.bus.drive(None)
            self._give_turn()

    def _sent(self, data: bytes) -> None:
        """Record bytes that have been sent."""
        self.sent += len(data)
        heeded = self.control.heeds
        self.shadow.take(data)
        if self.control.heeds != heeded:
            self.control.news.set()

    async def _byte(self, byte: int, begins: bool, asked: bool) -> None:
        """Offer a byte until the part accepts it.

        If the byte `begins` a command, a message may have to be read first.  `asked`: whether the byte is on the bus
        already, and IO_REQUEST low.
        """
        while True:
            if not asked:
                await self._free()
                if self.delay_ps:
                    await until(self.kernel, self.kernel.now + self.delay_ps)
                self.queue.begun = True
                self.bus.drive((0xFF, byte))
                self.request.drive(0)
            asked = False
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
        self._sent(bytes([byte]))

    async def ask(self, data: bytes, query: Query) -> str | bytes:
        """Send a query, wait for its answer, and return the answer."""
        since = self.recent.total
        await self.send(data)
        while (found := query.answered(self.received, self.recent.place(since))) is None:
            await edge(self.control.news.net)
        return found


class OfferedBytes(HandshakenBytes):
    """Consecutive bytes sent by a host that releases the bus after each; a leading FF is an empty handshake."""

    __slots__ = ()

    def bus(self) -> Wave:
        falls = [self.request_of(number) for number in range(len(self.data))]
        rises = [self.instant(number, self.times.busy) for number in range(len(self.data))]
        times: list[int] = []
        levels: list[Level] = []
        for fall, rise, byte in zip(falls, rises, self.data, strict=True):
            if byte != EMPTY:
                times += (fall, rise)
                levels += ((0xFF, byte), None)
        return Wave(None, tuple(times), tuple(levels))


class ManyOffers(ManyCommands):
    """Consecutive `OfferedBytes`, whose edges are computed together."""

    def bus(self) -> Edges:
        import numpy as np

        times, _ = self.request()
        levels = np.stack((self.driven, np.full_like(self.driven, FLOATING)), axis=1).ravel()
        offered = np.repeat(self.driven & 0xFF != EMPTY, 2)
        return times[offered], levels[offered]


class FlowSender(Leader[Handshakes]):
    """The sender of a port's bytes to its chip.

    Where possible, it sends several bytes as one value (`OfferedBytes`), from which all edges are computed.
    Otherwise the port drives each edge.

    Attributes:
        empty: whether an empty handshake precedes the bytes.
        fed: the number of these bytes that the port has recorded as sent.
        begins: whether the next byte begins a command.  This is recorded when the port has to drive the
            edges of the remaining bytes itself; until then None.
    """

    def __init__(self, port: FlowPort) -> None:
        super().__init__(port.request.net)
        self.port, self.empty, self.fed, self.data = port, False, 0, b""
        self.begins: bool | None = None

    @property
    def by_value(self) -> bool:
        """True if the last bytes were sent as one value, and the lines have not been observed since then."""
        return self.exchange is not None and self.exchange.by_value

    def begin(self, data: bytes, at: int, begins: bool, empty: bool) -> bool:
        """Begin to send bytes of `data`, from index `at` on, as one value; return False if this is not possible.

        The value never extends beyond the end of the present command.

        Args:
            begins: whether the first byte begins a command.
            empty: whether an empty handshake precedes the first byte.
        """
        port, exchange = self.port, self.exchange
        if exchange is None or data[at] == EMPTY or port.offered or exchange.chip.at_letter is not begins:
            return False
        shadow = port.shadow  # the host may take another byte than the chip for the end of a command
        ends = 0 if shadow.entry is not None else shadow.decoder.kept(data, at, shadow.ascii) + 1
        if not (number := min(exchange.chip.takes(data, at), ends)):
            return False
        self.empty, self.fed, self.begins, chip = empty, 0, None, exchange.chip
        self.data = data[at : at + number]
        sent = bytes([EMPTY]) + self.data if empty else self.data
        last = at + number == len(data)
        return exchange.send(OfferedBytes(sent, port.kernel.now, None, last, chip.byte_times, chip.clock))

    def feed(self, number: int) -> int:
        """Record the bytes that have been sent, and return how many there are, without any empty handshake.

        `number`: the number of bytes sent; an empty handshake counts as a byte.
        """
        gone = max(number - self.empty, 0)
        self.port._sent(self.data[self.fed : gone])
        self.fed = gone
        return gone

    def made(self, ends: tuple[Any, ...]) -> Handshakes | None:
        """Return the exchange between this port and the chip on IO_REQUEST.

        Return None unless exactly one chip is wired to IO_REQUEST, and the port reads the BUSY of this chip.
        """
        port = self.port
        if len(ends) != 1 or not hasattr(ends[0], "byte_times"):
            return None
        chip: TakingEnd = ends[0]
        return Handshakes(port, chip, ManyOffers) if chip.ready.net is port.busy.root else None
