"""Step trains: runs of equal intervals, which are queried rather than expanded.

A move of a hundred thousand steps consists of a few hundred runs.  The number of steps made by an instant is found by
bisection and a division; arrays are made only for the window requested.

    end k-1                  end k
      |<----- interval ------>|
      |______________      ___|______
    __|              |____|          PULSE is low from the start of a step to `high` ticks before its end
                     |<-->| high

The motor outputs that show a train are in step_views.py.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

from ..time.events import Events, Until, When
from ..time.timebase import Clock

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

OPEN = 1 << 62  # a run without end
FEW = 12  # instants: single queries cost less than arrays
LONG = 512  # steps: filling such a run costs less than cumulating it


class Train(Events):
    """Steps that begin at clock ticks: `steps` of them, starting at tick `origin`, `length` ticks long in total."""

    __slots__ = ("_recent", "clock", "length", "origin", "steps")
    steps: int
    length: int

    def __init__(self, clock: Clock, origin: int) -> None:
        self.clock, self.origin = clock, origin
        self._recent: tuple[int, int, NDArray[np.int64]] | None = None

    # ------------------------------------------------------------------- to be implemented by a kind of train, in ticks
    def end(self, k: int) -> int:
        """Return the tick at which step k, counted from 1, ends; for k = 0, the tick at which step 1 begins."""
        raise NotImplementedError

    def ends(self, first: int = 0, last: int | None = None) -> NDArray[np.int64]:
        """Return `end(k)` for k = first ... last-1, but in ticks counted from `origin`: (n,) int64, ascending.

        By default, k is 0 ... steps-1, and the ticks are those at which the steps start.
        """
        raise NotImplementedError

    def step_at(self, tick: int) -> int:
        """Return the number of steps that begin at or before a tick."""
        raise NotImplementedError

    def steps_at(self, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the number of steps that begin at or before each of many ticks: (n,) int64.

        The ticks are counted from `origin`, and may be in any order.
        """
        raise NotImplementedError

    def velocities(self, since: int, to: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the velocities in since <= tick < to; ticks are counted from `origin`, 0 <= since < to <= length.

        Returns:
            Ticks counted from `origin`, (n,) int64, ascending, the first of which is `since`; and the velocity
            from each tick to the next, (n,) float64 steps/s.
        """
        raise NotImplementedError

    def extremes(self, since: int, to: int) -> tuple[list[int], list[float]]:
        """Return the first, lowest, highest and last velocity in since <= tick < to, in chronological order.

        A velocity that is, for example, both the first and the lowest is listed once.  The result is a list of
        the ticks from which the velocities hold, and a list of the velocities, in steps/s; all ticks are
        counted from `origin`.
        """
        ticks, speeds = self.velocities(since, to)
        chosen = sorted({0, int(speeds.argmin()), int(speeds.argmax()), len(ticks) - 1})
        return ticks[chosen].tolist(), speeds[chosen].tolist()

    def pieces(self, since: int, to: int) -> int:
        """Return the number of pieces of constant velocity in since <= tick < to, correct to within one.

        Ticks are counted from `origin`.
        """
        raise NotImplementedError

    def rests(self, until: int) -> int:
        """Return the tick at which the motor comes to rest if the train is cut off at `until` (ps).

        The tick is counted from `origin`.
        """
        raise NotImplementedError

    # ----------------------------------------------------------------------------------------------- derived from these
    def count(self, ps: int) -> int:
        """Return the number of steps that begin at or before an instant (ps)."""
        return self.step_at(self.clock.ticks_until(ps))

    def count_many(self, ps: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the number of steps that begin at or before each of many instants: (n,) int64.

        The instants are int64 ps, in any order.
        """
        return self.steps_at(self.clock.ticks_array(ps + 1) - 1 - self.origin)

    def time(self, k: int) -> When:
        """Return the instant (ps) at which step k, counted from 1, begins; None if the train has fewer steps."""
        return self.clock.ps(self.end(k - 1)) if k <= self.steps else None

    def times(self, first: int, last: int, out: NDArray[np.int64] | None = None) -> NDArray[np.int64]:
        """Return the instants at which steps first ... last begin: (n,) int64 ps, ascending.

        Args:
            first, last: step numbers, counted from 1.
            out: an int64 buffer with n elements or more; the filled part is returned.
        """
        ticks = self.ends(first - 1, last)
        return self.clock.ps_array(ticks, self.origin, out if out is None else out[: len(ticks)])

    def window(self, first: int, last: int) -> NDArray[np.int64]:
        """Return `times(first, last)`, cached and read-only: up to five views of a train query the same window."""
        if self._recent is None or self._recent[:2] != (first, last):
            found = self.times(first, last)
            found.flags.writeable = False
            self._recent = first, last, found
        return self._recent[2]

    def few(self, numbers: list[int]) -> list[int]:
        """Return the instants (ps) at which the steps with the given numbers begin.

        The numbers, counted from 1, must be ascending, and the train must have all of these steps.
        """
        return self.clock.ps_list([self.end(k - 1) for k in numbers])


@dataclass(frozen=True)
class RunTable:
    """A table of consecutive runs; trains with equal runs share a table.

    Attributes:
        starts: the tick at which each run starts, counted from the start of the first.
        intervals: the interval of each run, in ticks.
        counts: the number of steps in each run.
        firsts: the number of steps before each run.
        steps: the total number of steps.
        length: the total length, in ticks.
    """

    starts: list[int]
    intervals: list[int]
    counts: list[int]
    firsts: list[int]
    steps: int
    length: int

    @cached_property
    def shown(self) -> list[int]:
        """The indices of the first, the slowest, the fastest and the last run, ascending, for pictures."""
        return shown(self.intervals)


@lru_cache(maxsize=64)
def run_table(runs: tuple[tuple[int, int], ...]) -> RunTable:
    """Return the table of consecutive runs (interval, count), cached because a program's loops repeat moves."""
    starts, intervals, counts, firsts = [], [], [], []
    start = first = 0
    for interval, count in runs:
        if count:
            starts.append(start)
            intervals.append(interval)
            counts.append(count)
            firsts.append(first)
            start += interval * count
            first += count
    if not starts:  # for an empty train
        starts, intervals, counts, firsts = [0], [1], [0], [0]
    return RunTable(starts, intervals, counts, firsts, first, start)


def shown(intervals: list[int]) -> list[int]:
    """Return the indices of the first, the longest, the shortest and the last interval, ascending.

    An interval that is, for example, both the first and the longest is listed once.
    """
    return sorted({0, intervals.index(max(intervals)), intervals.index(min(intervals)), len(intervals) - 1})


class StepTrain(Train):
    """A step train: runs of steps at equal intervals, in clock ticks; the first step begins at tick `origin`.

    `runs` holds pairs (interval in ticks, number of steps); if the last number is OPEN, the train does not
    end. `steps` is the total number of steps.
    """

    __slots__ = ("counts", "firsts", "intervals", "starts", "table")

    def __init__(self, clock: Clock, origin: int, runs: Iterable[tuple[int, int]]) -> None:
        super().__init__(clock, origin)
        self.table = own = run_table(tuple(runs))
        self.starts, self.intervals, self.counts, self.firsts = own.starts, own.intervals, own.counts, own.firsts
        self.steps, self.length = own.steps, own.length  # ticks from the start of step 0 to the end of the last

    def end(self, k: int) -> int:
        if k >= self.steps:
            return self.origin + self.length
        i = bisect_right(self.firsts, k) - 1
        return self.origin + self.starts[i] + (k - self.firsts[i]) * self.intervals[i]

    def interval(self, k: int) -> int:
        """Return the length of step `k`, in ticks; steps are counted from 0."""
        return self.intervals[bisect_right(self.firsts, k) - 1]

    def step_at(self, tick: int) -> int:
        x = tick - self.origin
        if x < 0:
            return 0
        i = bisect_right(self.starts, x) - 1
        n = (x - self.starts[i]) // self.intervals[i] + 1
        return self.firsts[i] + (n if n < self.counts[i] else self.counts[i])

    def steps_at(self, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
        import numpy as np

        starts = np.array(self.starts, np.int64)
        i = np.maximum(np.searchsorted(starts, ticks, side="right") - 1, 0)
        n = (ticks - starts[i]) // np.array(self.intervals, np.int64)[i] + 1
        n = np.minimum(n, np.array(self.counts, np.int64)[i]) + np.array(self.firsts, np.int64)[i]
        return np.where(ticks < 0, 0, n)

    def pieces(self, since: int, to: int) -> int:
        return bisect_left(self.starts, to) - bisect_right(self.starts, since) + 1

    def rests(self, until: int) -> int:
        return self.end(begun) - self.origin if (begun := self.count(until - 1)) else 0

    def velocities(self, since: int, to: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the velocities in since <= tick < to; ticks are counted from `origin`.

        Returns:
            Ticks counted from `origin`, (n,) int64, ascending, the first of which is `since`; and the velocity
            from each tick to the next, (n,) float64 steps/s.
        """
        import numpy as np

        i, j = bisect_right(self.starts, since) - 1, bisect_left(self.starts, to)
        ticks, intervals = np.array(self.starts[i:j], np.int64), np.array(self.intervals[i:j], np.int64)
        ticks[0] = since
        return ticks, self.clock.hz / intervals

    def extremes(self, since: int, to: int) -> tuple[list[int], list[float]]:
        i, j = bisect_right(self.starts, since) - 1, bisect_left(self.starts, to)
        whole = j - i == len(self.starts)
        chosen = self.table.shown if whole else [i + n for n in shown(self.intervals[i:j])]
        return [since, *(self.starts[n] for n in chosen[1:])], [self.clock.hz / self.intervals[n] for n in chosen]

    def ends(self, first: int = 0, last: int | None = None) -> NDArray[np.int64]:
        import numpy as np

        last = self.steps if last is None else min(last, self.steps)
        if last <= first:
            return np.empty(0, np.int64)
        i, j = bisect_right(self.firsts, first) - 1, bisect_right(self.firsts, last - 1)
        out = np.empty(last - first, np.int64)
        short = i  # runs from here to n are short: they are cumulated together; a long one is filled in one go
        for n in [n for n, count in enumerate(self.counts[i:j], i) if count >= LONG]:
            self._cumulate(out, short, n, first, last)
            a, b = max(self.firsts[n], first), min(self.firsts[n] + self.counts[n], last)
            begin = self.starts[n] + (a - self.firsts[n]) * self.intervals[n]
            _fill(out[a - first : b - first], begin, self.intervals[n])
            short = n + 1
        self._cumulate(out, short, j, first, last)
        return out

    def _cumulate(self, out: NDArray[np.int64], i: int, j: int, first: int, last: int) -> None:
        """Write the starts of the steps in runs i ... j-1 into `out`, which covers steps first ... last-1."""
        import numpy as np

        if i == j:
            return
        a = max(self.firsts[i], first)
        counts = np.array(self.counts[i:j])
        counts[0] -= a - self.firsts[i]
        counts[-1] -= max(self.firsts[j - 1] + self.counts[j - 1] - last, 0)
        part = out[a - first : a - first + int(counts.sum())]
        part[0] = self.starts[i] + (a - self.firsts[i]) * self.intervals[i]
        np.cumsum(np.repeat(np.array(self.intervals[i:j]), counts)[:-1], out=part[1:])
        part[1:] += part[0]


def _fill(out: NDArray[np.int64], begin: int, interval: int) -> None:
    """Fill an array with ticks at equal intervals from `begin`, by doubling the filled part, without a second array."""
    import numpy as np

    done = min(LONG, len(out))
    out[:done] = np.arange(begin, begin + done * interval, interval)
    while done < len(out):
        more = min(done, len(out) - done)
        np.add(out[:more], done * interval, out=out[done : done + more])
        done += more


class Playing(Until):
    """A train being played, shared by all outputs that show it.

    It is valid before the instant `until` (ps), or forever if `until` is None.
    """

    __slots__ = ("train",)

    def __init__(self, train: Train, until: int | None = None) -> None:
        super().__init__(train, until)
        self.train = train

    def count(self, ps: int) -> int:
        train, until = self.train, self.until
        return train.step_at(train.clock.ticks_until(ps if until is None or ps < until else until - 1))

    def count_many(self, ps: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the number of steps that begin at or before each of many instants: (n,) int64.

        The instants are int64 ps, in any order.
        """
        import numpy as np

        if len(ps) < FEW:
            return np.array([self.count(at) for at in ps.tolist()], np.int64)
        return self.train.count_many(ps if self.until is None else np.minimum(ps, self.until - 1))

    @property
    def moves(self) -> int | None:
        """The instant (ps) at which the first step begins; from then on, the train determines the velocity.

        It is None if the train is cut off at or before that instant.
        """
        first = self.train.clock.ps(self.train.origin)
        return first if self.until is None or first < self.until else None

    def _ticks(self, start: int, stop: int) -> tuple[int, int, bool]:
        """Return the window start <= t <= stop (ps) in ticks counted from the train's `origin`.

        The window must not begin before `moves`.

        Returns:
            The first tick; the tick before which the window or the motion ends, whichever is earlier; and
            whether the motor comes to rest before the window ends.
        """
        train, clock = self.train, self.train.clock
        since, to = clock.ticks_until(start) - train.origin, clock.ticks_until(stop) - train.origin + 1
        rest = train.length if self.until is None else train.rests(self.until)
        return since, min(to, rest), rest < to

    def velocities(self, start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the velocities in start <= t <= stop (ps); `start` must not be before `moves`.

        Returns:
            Instants, (n,) int64 ps, ascending, the first of which is `start`; and the velocity from each instant
            to the next, (n,) float64 steps/s.
        """
        import numpy as np

        since, to, rests = self._ticks(start, stop)
        if since >= to:
            return np.array([start]), np.zeros(1)
        ticks, speeds = self.train.velocities(since, to)
        if rests:
            ticks, speeds = np.append(ticks, to), np.append(speeds, 0.0)
        times = self.train.clock.ps_array(ticks, self.train.origin)
        times[0] = start
        return times, speeds

    def pieces(self, start: int, stop: int) -> int:
        """Return the number of pieces of constant velocity in start <= t <= stop (ps), correct to within two."""
        since, to, _ = self._ticks(start, stop)
        return 1 + (self.train.pieces(since, to) if since < to else 0)

    def extremes(self, start: int, stop: int) -> tuple[list[int], list[float]]:
        """Return the first, lowest, highest and last velocity in start <= t <= stop (ps), each of them once.

        If the motor comes to rest in this window, the velocity 0 follows.  The result is a list of the instants
        (ps) from which the velocities hold, ascending, and a list of the velocities, in steps/s.
        """
        since, to, rests = self._ticks(start, stop)
        if since >= to:
            return [start], [0.0]
        ticks, speeds = self.train.extremes(since, to)
        clock, origin = self.train.clock, self.train.origin
        if rests:
            ticks, speeds = [*ticks, to], [*speeds, 0.0]
        return [start, *(clock.ps(origin + tick) for tick in ticks[1:])], speeds
