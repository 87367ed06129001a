r"""An operation on the host port of a chipset as a value: strobes that nobody else looks at are one call.

HostSlct  ‾‾‾‾\________________________________________/‾‾‾‾‾‾‾
bus       ----<     high byte     X     low byte       >-------
HostWrite ‾‾‾‾‾‾‾‾‾‾‾‾‾\_____/‾‾‾‾‾‾‾\_____/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾   HostRead likewise
value                                      |  here the port hears of all of it

What the wires show of it follows from when it begins, what it is, and its bytes (core/wires/exchange.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Protocol

from ....core.wires.exchange import End, Exchange
from ....core.wires.net import Driver, Wave
from ....core.wires.wave import Edges
from ....core.wires.waits import next_round, until

if TYPE_CHECKING:
    from .packet_port import PacketPort


class Strobed(NamedTuple):
    """The instants of an operation, in ps: the port is selected, each strobe falls and rises, the port is left alone."""

    start: int
    falls: tuple[int, ...]
    rises: tuple[int, ...]
    end: int

    def strobe(self) -> Edges:
        """Return what the strobe shows."""
        return 1, tuple(sorted((*self.falls, *self.rises))), (0, 1) * len(self.falls)

    def select(self) -> Edges:
        """Return what HostSlct shows."""
        return 1, (self.start, self.end), (0, 1)

    def command(self) -> Edges:
        """Return what HostCmd shows, for a command."""
        return 0, (self.start, self.end), (1, 0)

    def bus(self, data: bytes) -> Edges:
        """Return what stands on the bus while bytes are written: they change half way between two strobes."""
        changes = [(rise + fall) // 2 for rise, fall in zip(self.rises, self.falls[1:], strict=False)]
        return None, (self.start, *changes, self.end), (*((0xFF, byte) for byte in data), None)


class HostPort(End, Protocol):
    """The host port of a chipset, as an end of operations."""

    bus_driver: Driver
    access_ps: int  # from the fall of HostRead until a byte is on the bus
    let_go_ps: int  # from its rise until it is off

    def takes(self, reading: bool) -> bool:
        """Return whether it waits for the operation that begins now, a whole one."""

    def shows(self, number: int) -> bytes:
        """Return the bytes that a read operation gives."""

    def operated(self, number: int, data: bytes | None, command: bool) -> None:
        """Take notice of an operation whose last strobe ends now.

        Args:
            number: bytes.
            data: those that are written; None: they are read.
            command: the byte is a command.
        """

    def resume(self, falls: Sequence[int], rises: Sequence[int], data: bytes | None, over: bool) -> None:
        """Go by the pins from now on, in the middle of an operation.

        Args:
            falls, rises: of its strobes (ps), as far as they have come.
            data: what is written; None: it is a read operation.
            over: it has taken notice of the operation.
        """


class Operation:
    """The operation in progress, or the last one, of a host on one chipset.

    Args:
        port: what the host has there.
    """

    chip: HostPort

    def __init__(self, port: PacketPort) -> None:
        self.port, self.kernel = port, port.kernel
        self.ends: tuple[HostPort, ...] = ()
        self.exchange: Exchange | None = None
        self.data: bytes | None = None  # what is written; None: it is a read operation
        self.command = False
        self.strobes = Strobed(0, (), (), 0)
        self.over = True  # the chipset has taken notice of it
        self.shown = bytearray()  # what is read
        self.waited = False  # the host waits for its end: it has not been broken off

    def begin(self, strobes: Strobed, data: bytes | None, command: bool = False) -> bool:
        """Begin one that goes by value, now; return false where it cannot.

        Args:
            strobes: its instants.
            data: what is written; None: it is a read operation.
            command: the byte is a command.
        """
        exchange = self.exchange
        if exchange is None or not exchange.by_value:
            exchange = self._found()
        if exchange is None or not self.chip.takes(data is None) or not exchange.begin():
            return False
        self.strobes, self.data, self.command, self.over = strobes, data, command, False
        if data is None:
            self.shown[:] = self.chip.shows(len(strobes.rises))
        return True

    async def take_place(self) -> bytes:
        """Let the operation take place, until the port is left alone; return what has been read."""
        strobes, self.waited = self.strobes, True
        try:
            await until(self.kernel, strobes.rises[-1])
            await next_round(self.kernel)  # the edge is seen, unless somebody has driven a wire in the same instant
            if self.by_value:
                self._take_notice()
            await until(self.kernel, strobes.end)
        finally:
            self.waited = False
        return bytes(self.shown)

    def _take_notice(self) -> None:
        """Let the chipset hear of all of it: its last strobe has ended."""
        self.over = True
        self.chip.operated(len(self.strobes.rises), self.data, self.command)

    @property
    def by_value(self) -> bool:
        """Do the wires show operations as values?"""
        return self.exchange is not None and self.exchange.by_value

    def leave(self) -> None:
        """Go edge by edge from now on."""
        if self.exchange is not None and self.exchange.by_value:
            self.exchange.withdraw()

    # ----------------------------------------------------------------------------------------- what goes by value at all
    def _found(self) -> Exchange | None:
        """Return what the chipsets on these wires make possible; None: there is none, or more than one."""
        select = self.port.select.net
        ends = tuple(end for net in select.joined or (select,) for end in net.ends)
        if ends != self.ends:
            self.ends, self.exchange = ends, self._made(ends)
        return self.exchange

    def _made(self, ends: tuple[HostPort, ...]) -> Exchange | None:
        port = self.port
        if len(ends) != 1 or ends[0].bus_driver.net is not port.bus.net:
            return None
        (self.chip,) = ends
        led = {
            port.select: lambda: Wave(*self.strobes.select()),
            port.command: self._command,
            port.writing: lambda: self._strobe(self.data is not None),
            port.reading: lambda: self._strobe(self.data is None),
            port.bus: self._bus,
        }
        return Exchange(led, {self.chip.bus_driver: lambda: self._answer(self.strobes.end)}, ends, self._withdrawn)

    # ------------------------------------------------------------------------------------------- what the drivers show
    def _command(self) -> Wave:
        return Wave(*self.strobes.command()) if self.command else Wave(0, (), ())

    def _strobe(self, its: bool) -> Wave:
        """HostWrite or HostRead: the one that the operation is by, or the other one."""
        return Wave(*self.strobes.strobe()) if its else Wave(1, (), ())

    def _bus(self) -> Wave:
        """Return what the host has on the bus."""
        return Wave(None, (), ()) if self.data is None else Wave(*self.strobes.bus(self.data))

    def _answer(self, ps: int) -> Wave:
        """Return what the chipset has on the bus, of what has come over by an instant (ps)."""
        if self.data is not None:
            return Wave(None, (), ())
        edges = [(fall + self.chip.access_ps, (0xFF, byte)) for fall, byte in zip(self.strobes.falls, self.shown) if fall <= ps]
        edges += [(rise + self.chip.let_go_ps, None) for rise in self.strobes.rises if rise <= ps]
        edges.sort(key=lambda edge: edge[0])
        return Wave(None, tuple(time for time, _ in edges), tuple(level for _, level in edges))

    def _withdrawn(self, seen: int) -> None:
        """The chipset goes by the pins from now on, with what has come over; the host looks at the bus in time."""
        _, falls, rises, end = self.strobes
        if seen >= end:
            return
        answer = self._answer(seen)
        if answer.times:
            self.chip.bus_driver.promise = answer
        over = [rise for rise in rises if rise <= seen]
        if len(over) == len(rises) and not self.over:
            self._take_notice()
        self.chip.resume([fall for fall in falls if fall <= seen], over, self.data, self.over)
        if self.data is None and not self.over:
            del self.shown[len(over) :]
            for rise in rises[len(over) :]:
                if rise <= self.kernel.now:  # the host looks before anything changes in that instant
                    self._sample(self.strobes)
                else:
                    self.kernel.call_at(rise, partial(self._sample, self.strobes))

    def _sample(self, strobes: Strobed) -> None:
        """Look at the bus at the end of a strobe, unless the host has been broken off."""
        if self.waited and strobes is self.strobes:
            self.shown.append(self.port.bus.net.byte)  # type: ignore[attr-defined]
