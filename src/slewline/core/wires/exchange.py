r"""Exchanges as values: what two ends do with each other costs nothing on the wires while nothing else looks.

    strobe      ‾‾‾‾\___/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾     a drawn line: asked, not played
    bus         ----<  byte  >----------     a drawn line
    value             one call          |    a probe comes, or another driver:  withdraw
    real                                |    the rest as waves, which the ends watch

A bus cycle or a strobe has many edges, and all of them follow from a few numbers: when it begins, an address, a byte.
While both ends are known, and nothing else watches, samples, records or drives their wires, no edge is an instant: one
end calls the other with what comes over, and each driver shows a `DrawnLine`, which works out its edges when asked for
a level.  As soon as anything begins to look, or any other driver is given something, the exchange is withdrawn: the
lines become the waves that they were, the ends watch their nets again, and the rest goes edge by edge.  Edge by edge is
also how everything goes that is not quiet: the twin, to which an exchange is equal in every edge, byte and finding.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from ..time.events import When
from .net import Driver, Net
from .wave import Level, Wave, floats


class End(Protocol):
    """An end of exchanges: it watches some nets; while an exchange is a value it is called with what comes over."""

    @property
    def watches(self) -> Sequence[tuple[Net, Callable[[Net], object]]]:
        """Nets, each with what is called when it changes."""


class DrawnLine:
    """What a driver shows of the exchange in progress, or showed of the last one; worked out when asked for."""

    __slots__ = ("driver", "shown")
    until: int | None = None

    def __init__(self, driver: Driver, shown: Callable[[], Wave]) -> None:
        self.driver, self.shown = driver, shown

    @property
    def floats(self) -> bool:
        """Does it let go of the wire at times?"""
        return floats(self.shown())

    def level(self, ps: int) -> Level:
        """Return the level at an instant (ps), edges at that instant included."""
        return self.shown().level(ps)

    def after(self, ps: int) -> When:
        """Return the next edge strictly after an instant (ps); None: none is foreseen."""
        return self.shown().after(ps)

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges at start < t <= stop (ps), as two lists."""
        return self.shown().edges(start, stop)


class Exchange:
    """What may go between ends as a value.

    Args:
        led: the drivers of the end that leads, each with a function that returns its wave of the exchange in progress,
            or of the last one.  When it is withdrawn, they show the rest of it.
        answering: the same of those that answer.  When it is withdrawn, they stay as they are, until their end hears
            of the next edge.
        ends: what watches the nets.
        withdrawn: called with the last instant (ps) of which the value is true, before the ends watch again.
    """

    def __init__(
        self,
        led: Mapping[Driver, Callable[[], Wave]],
        answering: Mapping[Driver, Callable[[], Wave]],
        ends: Sequence[End],
        withdrawn: Callable[[int], object],
    ) -> None:
        self.led = [DrawnLine(driver, shown) for driver, shown in led.items()]
        self.answering = [DrawnLine(driver, shown) for driver, shown in answering.items()]
        self.ends, self.withdrawn = ends, withdrawn
        self.by_value = False
        self.nets: tuple[Net, ...] = ()  # of the wires, while it goes by value
        self.watches: Sequence[tuple[Net, Callable[[Net], object]]] = ()  # what the ends watch of them otherwise

    def begin(self) -> bool:
        """Return whether the exchange that begins now goes by value: all its edges are yet to come."""
        return self.by_value or self._enter()

    def _enter(self) -> bool:
        """Go by value from now on, if nothing else takes part in any wire, or looks at one."""
        lines = [*self.led, *self.answering]
        drivers = {line.driver for line in lines}
        roots = {line.driver.net: None for line in lines}
        nets = {net: None for root in roots for net in root.joined or (root,)}
        if any(net.looked_at or net.exchange is not None for net in nets):
            return False
        watches = [watch for end in self.ends for watch in end.watches if watch[0] in nets]
        if sum(len(net.observers) for net in nets) != len(watches):
            return False
        if any(root.pending_drivers or not drivers.issuperset(root.active) for root in roots):
            return False
        for net, observer in watches:
            net.unwatch(observer)
        for line in lines:
            line.driver.promise = line
        for root in roots:
            root.sort_drivers()
        for net in nets:
            net.token += 1
            net.exchange = self
        self.by_value, self.nets, self.watches = True, tuple(nets), watches
        return True

    @property
    def changing(self) -> list[Net]:
        """The nets whose lines have an edge in the instant whose changes are about to be committed."""
        kernel = self.nets[0].kernel
        seen, now = kernel.seen, kernel.now
        roots = {line.driver.net for line in [*self.led, *self.answering] if seen < now and line.after(seen) == now}
        return [net for net in self.nets if net.root in roots]

    def withdraw(self) -> None:
        """Go on edge by edge: something looks at one of the wires, or is about to drive it."""
        nets, self.nets, self.by_value = self.nets, (), False
        seen = nets[0].kernel.seen
        for line in self.led:
            wave = line.shown()
            line.driver.level = wave.level(seen)
            line.driver.promise = wave if wave.times and wave.times[-1] > seen else None
        for line in self.answering:
            line.driver.level, line.driver.promise = line.level(seen), None
        for net in nets:
            net.exchange = None
            net.token += 1
        self.withdrawn(seen)
        for net in nets:
            net.root.sort_drivers()
            net.value = net.resolve(seen)  # it has not followed the lines
        for net, observer in self.watches:
            net.watch(observer)


class Leader:
    """The end that leads: it looks for the other ends on a wire, and for what may go over to them as a value.

    Args:
        net: of the wire.
    """

    def __init__(self, net: Net) -> None:
        self.net = net
        self.ends: tuple[Any, ...] = ()
        self.exchange: Exchange | None = None

    def made(self, ends: tuple[Any, ...]) -> Exchange | None:
        """Return what is possible with the ends that are on the wire now; None: nothing."""
        raise NotImplementedError

    def possible(self) -> Exchange | None:
        """Return what is possible now; None: nothing."""
        exchange = self.exchange
        if exchange is None or not exchange.by_value:  # else nothing has been wired meanwhile
            ends = tuple(end for net in self.net.root.joined or (self.net,) for end in net.ends)
            if ends != self.ends:
                self.ends, self.exchange = ends, self.made(ends)
        return self.exchange

    def leave(self) -> None:
        """Go edge by edge from now on."""
        if self.exchange is not None and self.exchange.by_value:
            self.exchange.withdraw()
