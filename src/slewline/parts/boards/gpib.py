"""A chip as a simple IEEE-488 listener, and its talker (s.12, figs. 12.1 to 12.4).

    NRFD  = READY                       low: not ready for data
    DAV  -> I/O REQUEST                 unless ATN is low, or the byte is a blocked line feed
    NDAC  = READY inverted              low until the byte is accepted
    IFC  -> RESET      MOTION COMPLETE -> SRQ

A blocked byte never makes READY fall, so the gate that blocks the byte also accepts it on behalf of the
chip; otherwise, the talker would wait forever.  The handshake and management lines are open-collector
lines.  The data lines go straight to the chip: this circuit has no inverter, so the talker sends its
bytes in positive logic.
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.wires.net import Net
from ...core.wires.waits import level, until
from ..base.part import Part
from ..base.request_queue import RequestQueue
from ..base.written_data import Data, as_bytes

US = 1_000_000
SETTLING_PS = 2 * US  # data before DAV, and ATN before data
REACTION_PS = US  # response time of a talker to NDAC, and of a controller to DAV
CLEAR_PS = 100 * US  # IFC
LINE_FEED = 0x0A
HANDSHAKE = ("dav", "nrfd", "ndac")
MANAGEMENT = ("atn", "ifc", "srq")


def add_bus_lines(part: Part) -> None:
    """Add the data, handshake and management lines of the IEEE-488 bus to a part, as pins."""
    part.add_bus("dio", "data lines", role="dio")
    for name in (*HANDSHAKE, *MANAGEMENT):
        part.add_pin(name, "both", f"{name.upper()}, low active, open collector", pull=1, role=name)


def pull(part: Part, name: str, low: bool) -> None:
    """Pull an open-collector line low if `low`, otherwise release it."""
    part.drivers[name].drive(0 if low else None)


class GpibListener(Part):
    """The gates that connect a chip to the bus as a listener."""

    _for_users = ("line_feeds",)
    wiring = MappingProxyType(
        {
            "dio": "data",
            "io_request": "request",
            "ready": "ready",
            "reset": "reset",
            "motion_complete": "motion_complete",
        }
    )

    options = (Option("line_feeds", "bool", False, "pass line feeds on; many controllers send one after each return"),)

    def __init__(self, kernel: Kernel, name: str, *, line_feeds: bool) -> None:
        super().__init__(kernel, name)
        self.line_feeds = line_feeds
        add_bus_lines(self)
        self.add_pin("io_request", "out", "I/O REQUEST of the chip", initial=1)
        self.add_pin("reset", "out", "RESET of the chip", initial=1)
        self.add_pin("ready", "in", "READY of the chip", pull=1)
        self.add_pin("motion_complete", "in", "MOTION COMPLETE of the chip", pull=1)

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        for name in ("dio", "dav", "atn", "ifc", "ready", "motion_complete"):
            self.pin(name).net.watch(self._react)
        self._react()

    def _react(self, _net: Net | None = None) -> None:
        offered, ready = not self.high("dav"), self.high("ready")
        blocked = not self.high("atn") or (not self.line_feeds and self.byte("dio") == LINE_FEED)
        self.drivers["io_request"].drive(0 if offered and not blocked else 1)
        self.drivers["reset"].drive(int(self.high("ifc")))
        pull(self, "nrfd", not ready)
        pull(self, "ndac", ready and not (offered and blocked))
        pull(self, "srq", not self.high("motion_complete"))


class SourceHandshake:
    """The source handshake (fig. 12.3) by which a part sends bytes; each user call is journalled as an input.

    `requests` counts the falling edges of SRQ.
    """

    negative = False  # logic of the data lines

    def __init__(self, part: Part, queue: RequestQueue) -> None:
        self.part, self.queue, self.kernel, self.requests = part, queue, part.kernel, 0
        add_bus_lines(part)

    def rewired(self) -> None:
        """Start to count the falling edges of SRQ."""
        self.part.net("srq").watch(self._requested)

    def _requested(self, net: Net) -> None:
        self.requests += net.level == 0

    def send(self, data: Data) -> None:
        """Queue bytes for all listeners."""
        data = as_bytes(self.part.name, data)
        self.part.input("send", data)
        self.queue.post(f"sends {data!r}", lambda: self.talk(data))

    def command(self, data: Data) -> None:
        """Queue bytes that are sent with ATN low."""
        data = as_bytes(self.part.name, data)
        self.part.input("command", data)
        self.queue.post(f"commands {data.hex(' ')}", lambda: self.talk_commands(data))

    def clear(self) -> None:
        """Queue an interface clear."""
        self.part.input("clear")

        async def action() -> None:
            pull(self.part, "ifc", True)
            await until(self.kernel, self.kernel.now + CLEAR_PS)
            pull(self.part, "ifc", False)
            await until(self.kernel, self.kernel.now + SETTLING_PS)

        self.queue.post("clears the interface", action)

    async def talk_commands(self, data: bytes) -> None:
        """Send bytes with ATN low."""
        pull(self.part, "atn", True)
        await self.talk(data)
        pull(self.part, "atn", False)
        await until(self.kernel, self.kernel.now + SETTLING_PS)

    async def talk(self, data: bytes) -> None:
        """Send bytes, then release the data lines."""
        for byte in data:
            await self._byte(byte)
        self.part.drivers["dio"].drive(None)

    async def _byte(self, byte: int) -> None:
        """Send one byte: put it on the data lines, await NRFD high, set DAV low, await NDAC high, set DAV high."""
        part = self.part
        part.drivers["dio"].drive((0xFF, byte ^ 0xFF if self.negative else byte))
        await until(self.kernel, self.kernel.now + SETTLING_PS)
        await level(part.net("nrfd"), 1)
        if part.net("ndac").level == 1:
            part.finding("no-listener", f"{byte:#04x}: NRFD and NDAC are both high: no device listens")
            return
        pull(part, "dav", True)
        await level(part.net("ndac"), 1)
        await until(self.kernel, self.kernel.now + REACTION_PS)
        pull(part, "dav", False)


class Talks:
    """Mixin for parts that have a `SourceHandshake`; provides the calls that users make to operate it."""

    _source: SourceHandshake

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        self._source.rewired()

    @property
    def requests(self) -> int:
        """Number of falling edges of SRQ."""
        return self._source.requests

    @from_outside
    def send(self, data: Data) -> None:
        """Queue bytes for all listeners."""
        self._source.send(data)

    @from_outside
    def command(self, data: Data) -> None:
        """Queue bytes that are sent with ATN low: addresses and interface messages."""
        self._source.command(data)

    @from_outside
    def clear(self) -> None:
        """Queue an interface clear: IFC low for 100 µs."""
        self._source.clear()


class GpibTalker(Talks, Part):
    """A talker and controller that sends to all listeners, without addressing them."""

    _for_users = ("send", "command", "clear", "requests")
    wiring = MappingProxyType({name: name for name in ("dio", *HANDSHAKE, *MANAGEMENT)})

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.queue: RequestQueue = RequestQueue(kernel, name)
        self._source = SourceHandshake(self, self.queue)
