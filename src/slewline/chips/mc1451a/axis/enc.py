"""The encoder chip: a filter on every input, and a quadrature counter.

    A        ____|‾‾‾‾‾‾‾|_______|‾‾‾‾        forward: A leads B by a quarter of a period
    B        ________|‾‾‾‾‾‾‾|_______|
    count    0   1   2   3   4   5   6        four counts per period

A level is accepted once it has lasted for three chip clocks: a change at tick t becomes visible at tick
t + 12.  If changes of both channels leave the filters at the same tick, the shaft has not moved; they
are not counted.

The CP chip reads the counter at the start of a cycle.  All changes since the last reading are processed
together, one by one if there are few, in arrays if there are many.  However few there are, this takes
most of the computing time of a cycle.  Therefore the counter looks ahead: it processes the promises of A
and B for the next cycles (a window) in one pass, with the same filters and decoder, and answers queries
from this window.  The result holds unless a driver of A or B changes.

    promised   _|‾|_|‾|_|‾|_|‾|_|‾|_|‾|_|‾|_|‾|_|‾|_|‾|_|‾|_
    windows    | 4    | 8          | 16            x              in cycles, each twice the one before
    queries    ^   ^  ^  ^  ^      ^  ^   ^   ^        ^ read     x: a driver changes; the window is dropped, the
                                                                  changes so far are read, the next window is short

At its end a window is adopted: filters and decoder take over its final state.  Until then it is a
forecast; a query about the past (`history`) makes the counter read all changes up to the last query.

Rules of this file: a window with a finding is refused, so that no finding is reported before its cause
occurs.  No result of a window is stored before the window's end.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from copy import copy
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Self

from ....core.motion.history import History
from ....core.time.timebase import Clock, readable
from ....core.wires.pin import Terminal
from ....core.wires.wave import real_edges
from .. import sheet
from .pin_edges import PinEdges

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

MUCH = 64  # changes; for more, arrays are faster
FILTER_TICKS = sheet.FILTER_TICKS
DWELL_TICKS = sheet.TIMES["dwell"].ticks  # the shortest state within the specification
Edges = tuple[Any, Any]  # instants and levels, as in a reading


class Filter:
    """An input's filter: its output level, and the edges that it still delays, with their ticks and levels.

    `level` is the output level just before the tick of the last query; None while it is unknown.
    """

    __slots__ = ("clock", "late", "level")

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self.level: int | None = None
        self.late: tuple[list[int], list[Any]] = ([], [])

    def passed(self, tick: int, edges: Edges) -> Sequence[int] | Any:
        """Return the ticks at which the filter's output changed, from the last query up to but excluding a tick.

        Args:
            edges: the edges at the filter's input since the last query.
        """
        times, levels = edges
        if len(times) > MUCH:
            return self._passed_many(tick, times, levels)
        ticks = self.late[0] + self.clock.ticks_list(times if isinstance(times, list) else times.tolist())
        levels = [*self.late[1], *levels]
        passed = bisect_left(ticks, tick - FILTER_TICKS)
        self.late, found = (ticks[passed:], levels[passed:]), []
        here, following = self.level, [*ticks[1 : passed + 1], tick]  # the last edge's level has lasted until the query
        for begin, end, shown in zip(ticks[:passed], following, levels, strict=False):
            level = 1 if shown else 0
            if level != here and end - begin >= FILTER_TICKS:
                found.append(begin + FILTER_TICKS)
                here = level
        self.level = here
        return found

    def _passed_many(self, tick: int, times: Any, levels: Any) -> Any:
        """Return the result of `passed`, computed with arrays."""
        import numpy as np

        ticks, levels = self.clock.ticks_array(np.asarray(times, np.int64)), np.asarray(levels) == 1
        if self.late[0]:
            ticks = np.concatenate((np.array(self.late[0], np.int64), ticks))
            levels = np.concatenate((np.array(self.late[1], bool), levels))
        passed = int(ticks.searchsorted(tick - FILTER_TICKS))
        self.late = ticks[passed:].tolist(), levels[passed:].tolist()
        lasting = ticks[1 : passed + 1] - ticks[:passed][: len(ticks) - 1] >= FILTER_TICKS
        ticks, levels = ticks[:passed], levels[:passed]
        if not lasting.all():
            lasting = np.concatenate((lasting, [True]))[:passed]  # the last edge's level has lasted until the query
            ticks, levels = ticks[lasting], levels[lasting]
        ticks, levels = real_edges(ticks, levels.view(np.int8), self.level)
        self.level = int(levels[-1]) if len(levels) else self.level
        return ticks + FILTER_TICKS


class FilteredInput:
    """An input with its filter: HOME, or an encoder channel.  An open input reads low."""

    def __init__(self, pin: Terminal, clock: Clock) -> None:
        self.pin, self.clock = pin, clock
        self.reading = PinEdges(pin)
        self.begin()

    def begin(self) -> None:
        """Start with the level at the end of this instant, as if it had been steady for a long time."""
        self.reading.begin()
        self.begun = self.pin.net.kernel.now
        self.filter = Filter(self.clock)

    @property
    def quiet(self) -> bool:
        """True if no edge will leave the filter, unless a driver of the pin changes."""
        return not self.filter.late[0] and self.reading.quiet

    def level_before(self, tick: int) -> int:
        """Return the filter's output level just before a tick, which must not be earlier than the last query's."""
        self.filter.passed(tick, self.edges_before(tick))
        return self.filter.level or 0

    def edges_before(self, tick: int) -> Edges:
        """Return the edges at the filter's input, from the last query up to but excluding a tick."""
        clock = self.clock
        if clock.ps(tick) <= self.begun:
            return [], []  # the first level is not known before the end of its instant
        edges = self.reading.edges_until(clock.ps(tick) - 1)
        if self.filter.level is None:
            self.filter.level = int(bool(self.reading.first))
        return edges


class QuadratureDecoder:
    """A quadrature decoder with filters on A and B.  `found` lists its findings: code, text, tick."""

    __slots__ = ("a", "b", "burst", "counts", "found", "since")

    def __init__(self, a: Filter, b: Filter) -> None:
        self.a, self.b = a, b
        self.counts = 0
        self.since: int | None = None  # the tick at which the present state began
        self.burst = False  # states are too short; over when one lasts twice the minimum
        self.found: list[tuple[str, str, int]] = []

    def copy(self) -> Self:
        """Return an independent copy of the present state."""
        twin = copy(self)
        twin.a, twin.b, twin.found = copy(self.a), copy(self.b), []
        return twin

    def count(self, tick: int, of_a: Edges, of_b: Edges) -> tuple[Any, Any]:
        """Count the edges at the filters' inputs, from the last query up to but excluding a tick.

        Returns:
            The ticks at which the count changes, and the new count at each: two lists, or two arrays.
        """
        a, b = self.a.passed(tick, of_a), self.b.passed(tick, of_b)
        if len(a) + len(b) > MUCH:
            return self._count_many(a, b)
        return self._count(a, b) if len(a) or len(b) else ([], [])

    def _differed_before(self, a: Sequence[int], b: Sequence[int]) -> bool:
        """Return whether the levels of A and B differed before the first of their changes at ticks `a` and `b`."""
        return bool(((self.a.level or 0) ^ (self.b.level or 0) ^ len(a) ^ len(b)) & 1)

    def _count(self, a: Sequence[int], b: Sequence[int]) -> tuple[list[int], list[int]]:
        """Process changes of A and B, at the given ticks, one by one; return the same as `count`."""
        differ = self._differed_before(a, b)
        of_a = set(a)
        both = of_a.intersection(b)
        count, since, ticks, counts = self.counts, self.since, [], []
        for tick in sorted(of_a.union(b)):
            if since is not None and (tick - since < DWELL_TICKS or self.burst):
                self._check_states([tick - since], tick)
            since = tick
            if tick in both:
                self.found.append(("encoder-illegal", "changed at the same time, which is not counted", tick))
                continue
            differ = not differ
            count += 1 if differ is (tick in of_a) else -1
            ticks.append(tick)
            counts.append(count)
        self.counts, self.since = count, since
        return ticks, counts

    def _count_many(self, a: Any, b: Any) -> tuple[Any, Any]:
        """Process changes of A and B, at the given ticks, in arrays; return the same as `count`."""
        import numpy as np

        ticks = np.concatenate([np.asarray(a, np.int64), np.asarray(b, np.int64)])
        order = np.argsort(ticks, kind="stable")
        ticks, of_b = ticks[order], order >= len(a)
        lasted = ticks[1:] - ticks[:-1]
        if not lasted.all():  # both at the same tick
            return self._count(np.asarray(a).tolist(), np.asarray(b).tolist())
        differ = self._differed_before(a, b)  # every change inverts it
        up = (np.arange(1, len(ticks) + 1) + differ & 1 == 1) != of_b
        counts = self.counts + np.cumsum(np.where(up, 1, -1))
        self.counts = int(counts[-1])
        if self.since is not None:
            lasted = np.concatenate(([ticks[0] - self.since], lasted))
        if self.burst or lasted.min() < DWELL_TICKS:
            reported = lasted[(lasted < DWELL_TICKS) | (lasted >= 2 * DWELL_TICKS)]
            turns = np.diff(reported < DWELL_TICKS, prepend=self.burst)  # start or end of a burst
            self._check_states(reported[turns].tolist(), int(ticks[-1]))
        self.since = int(ticks[-1])
        return ticks, counts

    def _check_states(self, lasted: Sequence[int], tick: int) -> None:
        """Report an encoder state that is too short; in a burst of short states, report only the first one.

        `lasted` is the duration of each state, in clocks.  The last of these states ended at `tick`.
        """
        for state in lasted:
            if state >= 2 * DWELL_TICKS:
                self.burst = False
            elif state < DWELL_TICKS and not self.burst:
                self.burst = True
                text = f"had a state of {state} clocks, less than {DWELL_TICKS}"
                self.found.append(("encoder-fast", text, tick))


class CountWindow(NamedTuple):
    """The promised edges of A and B up to tick `stop`, already counted.

    `counts` has the new count at each of `ticks`; `decoder` has the final state.
    """

    stop: int
    before: int  # counts at the start of the window
    ticks: Any
    counts: Any
    decoder: QuadratureDecoder
    levels: tuple[Any, Any]  # at the inputs of the filters

    def counts_before(self, tick: int) -> int:
        """Return the count just before a tick."""
        i = bisect_left(self.ticks, tick)
        return int(self.counts[i - 1]) if i else self.before

    def coming(self, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return an array with the count just before each of n ticks: (n,) int64."""
        import numpy as np

        return np.append(self.before, self.counts).astype(np.int64)[np.searchsorted(self.ticks, ticks)]


class QuadratureCounter:
    """Channels A and B of an encoder, with four counts per period.

    Args:
        finding: is called for encoder signals beyond the chip's specification.
    """

    least: ClassVar[int] = 4  # cycles of the first window, and of the first one after a dropped window
    most: ClassVar[int] = 256  # cycles of a window; twice as many are hardly faster, and more may be dropped

    def __init__(self, a: Terminal, b: Terminal, clock: Clock, finding: Callable[[str, str], object]) -> None:
        self.a, self.b = FilteredInput(a, clock), FilteredInput(b, clock)
        self.clock, self.finding = clock, finding
        self.window: CountWindow | None = None  # forecast of the counts
        self._reach = self.least  # cycles of the next window
        self._refused = 0  # the end of a window with a finding
        self._history = History()  # the counts, by ticks of the chip
        self._asked = self._done = 0  # the tick of the last query, and the tick before which all has been processed
        self.watch(self._drop)
        self.begin()

    def begin(self) -> None:
        """Count from 0; the first quadrature state is the state at the end of this instant."""
        self._work_off()
        self.a.begin()
        self.b.begin()
        self.decoder = QuadratureDecoder(self.a.filter, self.b.filter)
        self.counts = 0  # before the tick of the last query
        self._history.note(self.clock.ticks_from(self.a.begun), 0)
        self._asked = self._done = 0
        self._drop()

    def watch(self, callback: Callable[[], object]) -> None:
        """Arrange that a function is called whenever a driver of A or B changes, to wake a sleeping axis."""
        self.a.reading.on_change.add(callback)
        self.b.reading.on_change.add(callback)

    @property
    def quiet(self) -> bool:
        """True if the count will not change after the last query, unless a driver of A or B changes."""
        window = self.window
        if window is None:
            return self.a.quiet and self.b.quiet
        if len(window.ticks) and window.ticks[-1] >= self._asked:
            return False
        ps = self.clock.ps(window.stop) - 1
        ends = self.a.reading.ends_by(ps) and self.b.reading.ends_by(ps)
        return ends and not (window.decoder.a.late[0] or window.decoder.b.late[0])

    def counts_before(self, tick: int) -> int:
        """Return the count just before a tick, which must not be earlier than the tick of the last query."""
        if tick == self._asked:
            return self.counts
        self._asked, window = tick, self.window
        if window is not None and tick < window.stop:
            self.counts = window.counts_before(tick)
        else:
            if window is not None:
                self._adopt(window)
            self._read(tick)
            self._look_ahead(tick)
        return self.counts

    @property
    def history(self) -> History:
        """The counts up to the last query, by chip tick."""
        self._work_off()
        return self._history

    def _read(self, tick: int) -> None:
        """Process all changes before a tick."""
        decoder, self._done = self.decoder, tick
        self._history.note_many(*decoder.count(tick, self.a.edges_before(tick), self.b.edges_before(tick)))
        self.counts = decoder.counts
        found, decoder.found = decoder.found, []
        for code, what, at in found:
            self.finding(code, f"{self.a.pin.name} and {self.b.pin.name} {what} (at {readable(self.clock.ps(at))})")

    # ------------------------------------------------------------------------------------------------------- look ahead
    def _look_ahead(self, tick: int) -> None:
        """Process the promises from a tick on as a new window; all changes before the tick must have been read."""
        if tick < self._refused:
            return
        stop = tick + min(self._reach, self.most) * sheet.CYCLE_TICKS
        ps = self.clock.ps(stop) - 1
        a, b = self.a.reading.coming(ps), self.b.reading.coming(ps)
        if a is None or b is None:
            return
        decoder = self.decoder.copy()
        ticks, counts = decoder.count(stop, a[:2], b[:2])
        if decoder.found:
            self._refused, self._reach = stop, self.least
        else:
            self.window = CountWindow(stop, self.counts, ticks, counts, decoder, (a[2], b[2]))

    def _adopt(self, window: CountWindow) -> None:
        """Adopt the state at the end of a window, as if all changes up to that point had been read."""
        ps = self.clock.ps(window.stop) - 1
        self.decoder = decoder = window.decoder
        self.a.filter, self.b.filter = decoder.a, decoder.b
        for channel, level in zip((self.a, self.b), window.levels, strict=True):
            channel.reading.skip(ps, level)
        self._history.note_many(window.ticks, window.counts)
        self.window, self._reach = None, min(2 * self._reach, self.most)

    def _drop(self) -> None:
        """Drop the window, because a driver has changed."""
        self.window = None
        self._reach = self.least
        self._refused = 0

    def _work_off(self) -> None:
        if self._done < self._asked:
            self.window = None
            self._read(self._asked)
