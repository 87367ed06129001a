r"""Exchanges by value: a transfer causes no events on the wires while nothing observes them.

    strobe         ‾‾‾‾\___/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾     a `DrawnLine`, whose edges are queried, not run as events
    bus            ----<  byte  >----------     a `DrawnLine`
    by value             one call          |    a probe or another driver is added: withdraw
    edge by edge                           |    ordinary waves, and the ends watch their nets

A bus cycle or a strobe has many edges.  All of them follow from a few values, such as the start, an
address and a byte; these values are the state of the exchange.  An exchange is made by value while both
ends are known, and nothing else watches, samples or drives their wires.  Then the edges are not events:
one end calls the other with the data, and each driver has a `DrawnLine`, which computes its edges when
its level is queried.  Where a wire is recorded, the states of its exchanges are kept, and the edges are
computed on request (`PastExchanges`).

As soon as anything begins to observe the wires, or any other driver drives a level, the exchange is
withdrawn: the lines become ordinary waves, the ends watch their nets again, and the rest continues edge
by edge.  Transfers that cannot be made by value also run edge by edge.  The reference model (the twin)
always runs edge by edge; an exchange by value agrees with it in every edge, byte and finding.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Generic, Protocol, TypeVar

from ..time.events import When
from .net import Driver, Net
from .wave import Level, Promise, Wave, floats

SEGMENT = 1024  # exchanges in one entry of a log: a recorder drops old entries

Shown = Callable[[Any], Wave]  # from the state of an exchange to the wave of a driver


class End(Protocol):
    """One end of an exchange: it watches nets or, while the exchange is made by value, is called with the data."""

    @property
    def watches(self) -> Sequence[tuple[Net, Callable[[Net], object]]]:
        """The nets that this end watches, each with the function to call when that net changes."""


class DrawnLine:
    """The waveform of a driver in the current or the last exchange, computed on request."""

    __slots__ = ("driver", "exchange", "shown")
    until: int | None = None

    def __init__(self, driver: Driver, shown: Shown, exchange: Exchange) -> None:
        self.driver, self.shown, self.exchange = driver, shown, exchange

    @property
    def wave(self) -> Wave:
        """The wave with all edges of the driver in this exchange."""
        return self.shown(self.exchange.state)

    @property
    def floats(self) -> bool:
        """True if the driver releases the wire at times."""
        return floats(self.wave)

    def level(self, ps: int) -> Level:
        """Return the level at an instant (ps), after any edge at that instant."""
        return self.wave.level(ps)

    def after(self, ps: int) -> When:
        """Return the instant (ps) of the first edge strictly after the instant `ps`; None if no edge is foreseen."""
        return self.wave.after(ps)

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop: a list of instants (ps) and a list of levels."""
        return self.wave.edges(start, stop)


class PastExchanges:
    """The waveform of a net over consecutive exchanges: an entry of the net's log.

    Args:
        net: the net.
        shown: for each driver on the net, a function that returns the driver's wave for a state of an
            exchange.
        starts, states: the instants (ps) at which the exchanges begin, and the states of the exchanges.
    """

    __slots__ = ("net", "shown", "starts", "states")
    until: int | None = None
    floats = True  # possibly at times; the log knows where a net is at rest

    def __init__(self, net: Net, shown: Sequence[Shown], starts: list[int], states: list[Any]) -> None:
        self.net, self.shown, self.starts, self.states = net, shown, starts, states

    def level(self, ps: int) -> Level:
        """Return the level at an instant (ps), after any edge at that instant."""
        state = self.states[max(bisect_right(self.starts, ps) - 1, 0)]
        return self._together([shown(state) for shown in self.shown], ps)

    def after(self, ps: int) -> When:
        """Return the instant (ps) of the first edge strictly after the instant `ps`; None if there was none."""
        for times, _ in self._edges(ps, None):
            if times:
                return times[0]
        return None

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop: a list of instants (ps) and a list of levels."""
        times: list[int] = []
        levels: list[Level] = []
        for its_times, its_levels in self._edges(start, stop):
            times += its_times
            levels += its_levels
        return times, levels

    def _together(self, waves: list[Wave], ps: int) -> Level:
        """Return the combined level of the drivers at an instant (ps)."""
        return waves[0].level(ps) if len(waves) == 1 else self.net.wired([wave.level(ps) for wave in waves])[0]

    def _edges(self, start: int, stop: int | None) -> Iterator[tuple[list[int], list[Level]]]:
        """Yield, for each exchange, its edges in start < t <= stop (ps): the one at its start, then the others.

        The edge at the start of an exchange is the change to its first level.  `stop` is None for no limit.
        Edges are yielded as two lists: the instants, and the levels after them.
        """
        starts = self.starts
        for number in range(max(bisect_right(starts, start) - 1, 0), len(starts)):
            if stop is not None and starts[number] > stop:
                return
            state, end = self.states[number], starts[number + 1] - 1 if number + 1 < len(starts) else stop
            if end is None or (stop is not None and end > stop):
                end = stop
            waves = [shown(state) for shown in self.shown]
            since = max(start, starts[number] - 1)
            until = end if end is not None else max((wave.times[-1] for wave in waves if wave.times), default=since)
            if start < starts[number]:
                yield [starts[number]], [self._together(waves, starts[number])]
            if len(waves) == 1:
                yield waves[0].edges(since, until)
                continue
            times = sorted({time for wave in waves for time in wave.times if since < time <= until})
            yield times, [self._together(waves, time) for time in times]


class Exchange:
    """A transfer between ends, which is made by value where possible, and otherwise edge by edge.

    Args:
        led: the drivers of the leading end, each with a function that returns its wave for a state of the
            exchange.  When an exchange is withdrawn, these drivers play the rest of it.
        answering: the drivers of the answering ends, each with a function as in `led`.  When an exchange is
            withdrawn, each of these drivers keeps its level until its answering end is notified of the next
            edge.
        ends: the ends that watch the nets.
        withdrawn: a function that is called when an exchange is withdrawn, before the ends watch their nets
            again; its argument is the last instant (ps) at which the exchange by value is still valid.

    Attributes:
        state: the state of the current or the last exchange; the waveforms of the drivers follow from it
            alone.
    """

    def __init__(
        self,
        led: Mapping[Driver, Shown],
        answering: Mapping[Driver, Shown],
        ends: Sequence[End],
        withdrawn: Callable[[int], object],
    ) -> None:
        self.led = [DrawnLine(driver, shown, self) for driver, shown in led.items()]
        self.answering = [DrawnLine(driver, shown, self) for driver, shown in answering.items()]
        self.ends, self.withdrawn = ends, withdrawn
        self.state: Any = None
        self.kernel = (self.led or self.answering)[0].driver.kernel
        self.by_value = False
        self.awaited = False  # a task may be waiting for an edge of a net that has none in this exchange
        self.nets: tuple[Net, ...] = ()  # of the wires, while it goes by value
        self.watches: Sequence[tuple[Net, Callable[[Net], object]]] = ()  # the nets that the ends otherwise watch
        self.recorded = False  # one of the nets has a log
        self.starts: list[int] = []  # of the exchanges in the last entries of the logs
        self.states: list[Any] = []

    def begin(self, state: Any) -> bool:
        """Begin an exchange, all of whose edges are in the future; return whether it is made by value."""
        if self.by_value and self.awaited:
            self.awaited = False
            if any(net.looked_at for net in self.nets):
                self.withdraw()
                return False
        before, self.state = self.state, state
        if not self.by_value and not self._enter():
            self.state = before
            return False
        if self.recorded:
            if not self.starts or len(self.starts) >= SEGMENT:
                self._log()
            self.starts.append(self.kernel.now)
            self.states.append(state)
        return True

    def _log(self) -> None:
        """Start a new entry in the log of each recorded net."""
        now = self.kernel.now
        self.starts, self.states = [], []
        for net in self.nets:
            if net.log is not None:
                shown = [line.shown for line in [*self.led, *self.answering] if line.driver.net is net.root]
                net.log_from(now, self.past(net, shown))

    def past(self, net: Net, shown: Sequence[Shown]) -> Promise:
        """Return the waveform of a net over all exchanges since the present log entry was started.

        Args:
            shown: for each driver on the net, a function that returns the driver's wave for a state of an
                exchange.
        """
        return PastExchanges(net, shown, self.starts, self.states)

    def _enter(self) -> bool:
        """Switch to exchanges by value, and return True; return False if anything else drives or observes a wire."""
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
        self.recorded = any(net.log is not None for net in nets)
        self.starts, self.states = [], []
        return True

    def allows_wait(self, net: Net) -> bool:
        """Return True if a task may wait for an edge of a net, as the net has none before the next exchange."""
        return False

    @property
    def changing(self) -> list[Net]:
        """The nets on which a driver of the exchange has an edge in the instant that is about to be committed."""
        kernel = self.kernel
        seen, now = kernel.seen, kernel.now
        roots = {line.driver.net for line in [*self.led, *self.answering] if seen < now and line.after(seen) == now}
        return [net for net in self.nets if net.root in roots]

    def withdraw(self) -> None:
        """Continue edge by edge, because one of the wires is observed, or is about to be driven."""
        nets, self.nets, self.by_value = self.nets, (), False
        seen = self.kernel.seen
        for line in self.led:
            wave = line.wave
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
            if self.recorded and net.log is not None:
                net.log_present(seen)
        for net, observer in self.watches:
            net.watch(observer)


E = TypeVar("E", bound=Exchange)


class Leader(Generic[E]):
    """The leading end: it finds the other ends on its wire, and the exchange that is possible with them.

    Args:
        net: the net of the wire.
    """

    def __init__(self, net: Net) -> None:
        self.net = net
        self.ends: tuple[Any, ...] = ()
        self.exchange: E | None = None

    def made(self, ends: tuple[Any, ...]) -> E | None:
        """Return a new exchange with `ends`, the other ends on the wire; None if no exchange with them is possible."""
        raise NotImplementedError

    def possible(self) -> E | None:
        """Return the exchange that is possible now; None if none is possible."""
        exchange = self.exchange
        if exchange is None or not exchange.by_value:  # else the wiring is unchanged
            ends = tuple(end for net in self.net.root.joined or (self.net,) for end in net.ends)
            if ends != self.ends:
                self.ends, self.exchange = ends, self.made(ends)
        return self.exchange

    def leave(self) -> None:
        """Switch to edge-by-edge transfers, if an exchange is being made by value."""
        if self.exchange is not None and self.exchange.by_value:
            self.exchange.withdraw()
