"""The encoder chip: a filter on every input, and a counter of quadrature states.

    A        ____|‾‾‾‾‾‾‾|_______|‾‾‾‾        forward: A ahead of B by a quarter of a period
    B        ________|‾‾‾‾‾‾‾|_______|
    count    0   1   2   3   4   5   6        four counts a period

A level counts when it has lasted for three clocks of the chip, and from then on: a change at tick t is seen from tick
t + 12 on.  A change of both channels that the filters let through at one tick is no step of a shaft: it is not counted.

Rules of this file: the inputs are read when the CP chip asks, once per cycle.  What has happened since then is worked
off at once, plainly where it is little, in arrays where it is much.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from typing import Any

from ....core.motion.history import History
from ....core.time.timebase import Clock, readable
from ....core.wires.pin import Terminal
from ....core.wires.wave import real_edges
from .. import sheet
from .pin_edges import PinEdges

MUCH = 64  # changes; more are worth arrays


class FilteredInput:
    """An input behind its filter: HOME, or a channel of an encoder.  An open one reads low."""

    def __init__(self, pin: Terminal, clock: Clock) -> None:
        self.pin, self.clock = pin, clock
        self.filter_ticks = sheet.FILTER_TICKS
        self.reading = PinEdges(pin)
        self.begin()

    def begin(self) -> None:
        """What is on the pin at the end of this instant is what the filter has seen for long."""
        self.reading.begin()
        self.begun = self.pin.net.kernel.now
        self.level: int | None = None  # behind the filter, before the tick of the last question
        self.late: tuple[list[int], list[Any]] = ([], [])  # edges that the filter holds back: ticks and levels

    @property
    def quiet(self) -> bool:
        """Will nothing pass the filter any more, unless a driver of the pin is told something?"""
        return not self.late[0] and self.reading.quiet

    def level_before(self, tick: int) -> int:
        """The level behind the filter as it was before a tick, none of which is earlier than the one asked before."""
        self.changes_before(tick)
        return self.level or 0

    def changes_before(self, tick: int) -> Sequence[int] | Any:
        """The ticks at which the level behind the filter has changed since the last question, before a tick."""
        clock, filter_ticks = self.clock, self.filter_ticks
        if clock.ps(tick) <= self.begun:
            return []  # the first level is not known before the end of its instant
        times, levels = self.reading.edges_until(clock.ps(tick) - 1)
        if self.level is None:
            self.level = int(bool(self.reading.first))
        if len(times) > MUCH:
            return self._passed_many(tick, times, levels)
        ticks = self.late[0] + clock.ticks_list(times if isinstance(times, list) else times.tolist())
        levels = [*self.late[1], *levels]
        passed = bisect_left(ticks, tick - filter_ticks)
        self.late, found = (ticks[passed:], levels[passed:]), []
        here, following = self.level, [*ticks[1 : passed + 1], tick]  # what came last has lasted until the question
        for begin, end, shown in zip(ticks[:passed], following, levels, strict=False):
            level = 1 if shown else 0
            if level != here and end - begin >= filter_ticks:
                found.append(begin + filter_ticks)
                here = level
        self.level = here
        return found

    def _passed_many(self, tick: int, times: Any, levels: Any) -> Any:
        """The same of many edges."""
        import numpy as np

        ticks, levels = self.clock.ticks_array(np.asarray(times, np.int64)), np.asarray(levels) == 1
        if self.late[0]:
            ticks = np.concatenate((np.array(self.late[0], np.int64), ticks))
            levels = np.concatenate((np.array(self.late[1], bool), levels))
        passed = int(ticks.searchsorted(tick - self.filter_ticks))
        self.late = ticks[passed:].tolist(), levels[passed:].tolist()
        lasting = ticks[1 : passed + 1] - ticks[:passed][: len(ticks) - 1] >= self.filter_ticks
        ticks, levels = ticks[:passed], levels[:passed]
        if not lasting.all():
            lasting = np.concatenate((lasting, [True]))[:passed]  # what came last has lasted until the question
            ticks, levels = ticks[lasting], levels[lasting]
        ticks, levels = real_edges(ticks, levels.view(np.int8), self.level)
        self.level = int(levels[-1]) if len(levels) else self.level
        return ticks + self.filter_ticks


class QuadratureCounter:
    """The channels A and B of an encoder, counted fourfold.

    Args:
        finding: is told what an encoder does that the chip is not specified for.
    """

    def __init__(self, a: Terminal, b: Terminal, clock: Clock, finding: Callable[[str, str], object]) -> None:
        self.a, self.b = FilteredInput(a, clock), FilteredInput(b, clock)
        self.clock, self.finding = clock, finding
        self.dwell_ticks = sheet.TIMES["dwell"].ticks  # the shortest state within the specification
        self.history = History()  # the counts, by ticks of the chip
        self.begin()

    def begin(self) -> None:
        """Count from 0; the state at the end of this instant is the first one."""
        self.a.begin()
        self.b.begin()
        self.counts = 0
        self.history.note(self.clock.ticks_from(self.a.begun), 0)
        self._asked: int | None = None  # the tick of the last question
        self._since: int | None = None  # the tick at which the present state came
        self._burst = False  # states are too short; over when one lasts twice as long as it must

    def watch(self, told: Callable[[], object]) -> None:
        """Call a function when a driver of A or B is told something: who sleeps while all is quiet must wake."""
        self.a.reading.on_change.add(told)
        self.b.reading.on_change.add(told)

    @property
    def quiet(self) -> bool:
        """Will there be no count after the last question, unless a driver of A or B is told something?"""
        return self.a.quiet and self.b.quiet

    def counts_before(self, tick: int) -> int:
        """The counts as they were before a tick, none of which is earlier than the one asked before."""
        if tick == self._asked:
            return self.counts
        self._asked = tick
        a, b = self.a.changes_before(tick), self.b.changes_before(tick)
        if len(a) + len(b) > MUCH:
            self._count_many(a, b)
        elif len(a) or len(b):
            self._count(a, b)
        return self.counts

    def _differed_before(self, a: Sequence[int], b: Sequence[int]) -> bool:
        """Did A and B differ before some changes up to the present levels?"""
        return bool(((self.a.level or 0) ^ (self.b.level or 0) ^ len(a) ^ len(b)) & 1)

    def _count(self, a: Sequence[int], b: Sequence[int]) -> None:
        """Work off changes of A and B, one after the other."""
        differ = self._differed_before(a, b)
        of_a = set(a)
        both, shortest = of_a.intersection(b), self.dwell_ticks
        count, since, ticks, counts = self.counts, self._since, [], []
        for tick in sorted(of_a.union(b)):
            if since is not None and (tick - since < shortest or self._burst):
                self._check_states([tick - since], tick)
            since = tick
            if tick in both:
                self.finding("encoder-illegal", self._told("changed at once, which is not counted,", tick))
                continue
            differ = not differ
            count += 1 if differ is (tick in of_a) else -1
            ticks.append(tick)
            counts.append(count)
        self.counts, self._since = count, since
        self.history.note_many(ticks, counts)

    def _count_many(self, a: Any, b: Any) -> None:
        """The same of many."""
        import numpy as np

        ticks = np.concatenate([np.asarray(a, np.int64), np.asarray(b, np.int64)])
        order = np.argsort(ticks, kind="stable")
        ticks, of_b = ticks[order], order >= len(a)
        lasted = ticks[1:] - ticks[:-1]
        if not lasted.all():  # both at one tick
            self._count(np.asarray(a).tolist(), np.asarray(b).tolist())
            return
        differ = self._differed_before(a, b)  # every change turns that round
        up = (np.arange(1, len(ticks) + 1) + differ & 1 == 1) != of_b
        counts = self.counts + np.cumsum(np.where(up, 1, -1))
        self.history.note_many(ticks, counts)
        self.counts = int(counts[-1])
        if self._since is not None:
            lasted = np.concatenate(([ticks[0] - self._since], lasted))
        if self._burst or lasted.min() < self.dwell_ticks:
            told = lasted[(lasted < self.dwell_ticks) | (lasted >= 2 * self.dwell_ticks)]
            turns = np.diff(told < self.dwell_ticks, prepend=self._burst)  # where a burst begins or ends
            self._check_states(told[turns].tolist(), int(ticks[-1]))
        self._since = int(ticks[-1])

    def _check_states(self, lasted: Sequence[int], tick: int) -> None:
        """Report bursts of short states.  `lasted`: how long each was, in clocks; the last one ended at a tick."""
        for state in lasted:
            if state >= 2 * self.dwell_ticks:
                self._burst = False
            elif state < self.dwell_ticks and not self._burst:
                self._burst = True
                text = f"made a state of {state} clocks, less than {self.dwell_ticks},"
                self.finding("encoder-fast", self._told(text, tick))

    def _told(self, what: str, tick: int) -> str:
        return f"{self.a.pin.name} and {self.b.pin.name} {what} by {readable(self.clock.ps(tick))}"
