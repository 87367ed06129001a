"""Clock edges: the edges of one direction of a wire, numbered, asked rather than counted one by one.

What counts steps (a translator, a shaft, the counter of a driver module) follows the falls, or the rises, of one wire:

    wire     ‾‾|__|‾‾‾|__|‾‾‾|__|‾‾‾‾
    falls      1      2      3               how many by t, when comes number k, all of a window

A promise that follows a train answers by arithmetic (its `clock`).  Every other one is walked along, a stretch at a
time, and remembers little: one place in `BLOCK` edges.

Rules of this file: an edge is a change *to* the level; edges are numbered from 1 after the instant `since`, which the
caller has dealt with itself; nothing here has an effect on the wire.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import TYPE_CHECKING, Any, Protocol

from ..time.timebase import Clock

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

BLOCK = 1 << 14  # edges that are expanded at a time
LOOKS = 64  # edges that one question about the future looks ahead at most
FIRST_PS = 1_000_000_000  # the stretch that is walked first; the next ones are longer, as long as edges are few


class ClockEdges(Protocol):
    """Edges to one level, numbered from 1."""

    def by(self, ps: int) -> int:
        """Return how many there have been by an instant, that instant included."""

    def at(self, k: int) -> int | None:
        """Return the instant of edge k, or an earlier one at which to ask again; None: it does not come.

        An instant at which `by` is less than k is one at which to ask again.
        """

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of edges first ... last, all of which come: (n,) int64 ps, ascending."""

    def few(self, numbers: list[int]) -> list[int]:
        """Return the instants of some edges (ps), ascending, all of which come: fewer than are worth an array."""
        return [at for k in numbers if (at := self.at(k)) is not None]


class NoEdges(ClockEdges):
    """No edges: a level that stays."""

    def by(self, ps: int) -> int:
        """Return how many edges there have been by an instant (ps), that instant included."""
        return 0

    def at(self, k: int) -> int | None:
        """Return None: no edge comes."""
        return None

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of edges first ... last, all of which come: (n,) int64 ps, ascending."""
        import numpy as np

        return np.empty(0, np.int64)


class UniformEdges(ClockEdges):
    """Edges at an even rate (1/s), the first one a period after `since`."""

    def __init__(self, since: int, rate: int) -> None:
        self.since, self.clock = since, Clock(rate)

    def by(self, ps: int) -> int:
        """Return how many edges there have been by an instant (ps), that instant included."""
        return max(self.clock.ticks_until(ps - self.since), 0)

    def at(self, k: int) -> int | None:
        """Return the instant of edge k (ps), rounded down to a whole picosecond."""
        return self.since + self.clock.ps(k)

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of edges first ... last, all of which come: (n,) int64 ps, ascending."""
        import numpy as np

        return self.since + self.clock.ps_array(np.arange(first, last + 1))


class BoundedEdges(ClockEdges):
    """Edges of another clock as long as they lie before an instant, `until`; None: all of them."""

    until: int | None

    def __init__(self, of: ClockEdges, until: int | None = None) -> None:
        self.of, self.until = of, until

    def cut(self, ps: int) -> None:
        """Count only what lies before an instant or at it (ps)."""
        self.until = ps + 1

    def by(self, ps: int) -> int:
        """Return how many edges there have been by an instant (ps), that instant included."""
        until = self.until
        return self.of.by(ps if until is None or ps < until else until - 1)

    def at(self, k: int) -> int | None:
        """Return the instant of edge k (ps), or an earlier one at which to ask again; None from `until` on."""
        time, until = self.of.at(k), self.until
        return time if time is None or until is None or time < until else None

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of edges first ... last, all of which come: (n,) int64 ps, ascending."""
        return self.of.many(first, last)

    def few(self, numbers: list[int]) -> list[int]:
        """Return the instants of some edges, all of which come, in ps."""
        return self.of.few(numbers)


class DelayedEdges(ClockEdges):
    """Edges of another clock, each so many picoseconds later."""

    def __init__(self, of: ClockEdges, lag_ps: int) -> None:
        self.of, self.lag_ps = of, lag_ps

    def by(self, ps: int) -> int:
        """Return how many edges there have been by an instant (ps), that instant included."""
        return self.of.by(ps - self.lag_ps)

    def at(self, k: int) -> int | None:
        """Return the instant of edge k (ps), or an earlier one at which to ask again; None: it does not come."""
        time = self.of.at(k)
        return time if time is None else time + self.lag_ps

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of edges first ... last, all of which come: (n,) int64 ps, ascending."""
        return self.of.many(first, last) + self.lag_ps

    def few(self, numbers: list[int]) -> list[int]:
        """Return the instants of some edges, all of which come, in ps."""
        return [at + self.lag_ps for at in self.of.few(numbers)]


class ScanWindow:
    """How far to walk along a wire at a time, so that edges are expanded by the thousand."""

    def __init__(self) -> None:
        self.ps = FIRST_PS

    def stop(self, start: int, stop: int) -> int:
        """Return where a stride ends that begins at one instant and goes no further than another."""
        return min(start + self.ps, stop)

    def told(self, count: int) -> None:
        """Take notice of how many edges a stride had."""
        if count > BLOCK:
            self.ps = max(self.ps // 4, 1)
        elif count < BLOCK // 4:
            self.ps *= 2

    def skipped(self, ps: int) -> None:
        """Take notice of a pause: after it edges may be many."""
        if ps > self.ps:
            self.ps = FIRST_PS


class ScannedEdges(ClockEdges):
    """Edges of any promise, found by walking along it.

    `_starts` are places on the way: instants after which stretches begin, and `_counts` how many edges lie before.
    The last stretch that was expanded is kept, since one question is often followed by another near by.
    """

    def __init__(self, promise: Any, level: int, since: int) -> None:
        self.promise, self.level = promise, level
        self._starts, self._counts = [since], [0]
        self._reached, self._found = since, 0  # how far it has been walked, and how many edges there were
        self._strides = ScanWindow()
        self._held: tuple[int, int, int, Any] = (since, 0, 0, ())  # since when; first ... last-1, from 0; instants

    def _edges(self, start: int, stop: int) -> Any:
        """The instants at start < t <= stop: a list or an array."""
        times, levels = self.promise.edges(start, stop)
        if isinstance(levels, list):
            befores = [self.promise.level(start), *levels]  # a list may hold edges that are none
            return [
                time
                for time, before, level in zip(times, befores, levels, strict=False)
                if level == self.level != before
            ]
        return times[levels == self.level]

    def _walk(self, ps: int) -> None:
        """Find all edges up to an instant."""
        while self._reached < ps:
            stop = self._strides.stop(self._reached, ps)
            times = self._edges(self._reached, stop)
            count = len(times)
            self._strides.told(count)
            self._held = (self._reached, self._found, self._found + count, times)
            if self._found + count - self._counts[-1] > BLOCK:
                self._starts.append(self._reached)
                self._counts.append(self._found)
            self._reached, self._found = stop, self._found + count
            if not count:
                following = self.promise.after(stop)
                self._reached = ps if following is None else max(stop, min(following - 1, ps))
                self._strides.skipped(self._reached - stop)

    def by(self, ps: int) -> int:
        """Return how many edges there have been by an instant (ps), that instant included."""
        self._walk(ps)
        start, first, _, times = self._held
        if ps >= self._reached:
            return self._found
        if ps >= start:
            return first + bisect_right(times, ps)
        i = max(bisect_right(self._starts, ps) - 1, 0)
        return self._counts[i] + (len(self._edges(self._starts[i], ps)) if ps > self._starts[i] else 0)

    def at(self, k: int) -> int | None:
        """Return the instant of edge k (ps), or an earlier one at which to ask again; None: it does not come."""
        time: int | None = self._reached
        if k > self._found:
            for _ in range(LOOKS):
                before, time = time, self.promise.after(time)
                if time is None:
                    return None
                self._walk(time)
                if k <= self._found:
                    break
                if self.promise.level(time) == self.promise.level(before):  # it has looked ahead enough itself
                    return time
            else:
                return time
        found = self.many(k, k)
        return int(found[0]) if len(found) else None  # it was promised, and is no more

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of edges first ... last, all of which come: (n,) int64 ps, ascending."""
        import numpy as np

        _, a, b, times = self._held
        if a >= first or b < last:
            i = bisect_right(self._counts, first - 1) - 1
            start, a = self._starts[i], self._counts[i]
            parts, b = [], a
            for stop in (*self._starts[i + 1 :], self._reached):
                parts.append(self._edges(start, stop))
                b, start = b + len(parts[-1]), stop
                if b >= last:
                    break
            times = parts[0] if len(parts) == 1 else np.concatenate([np.asarray(part, np.int64) for part in parts])
        return np.asarray(times[first - 1 - a : last - a], np.int64)


def clock_edges(shown: Any, level: int, since: int) -> ClockEdges:
    """Return the edges to a level that a wire makes after an instant, under what is shown on it.

    Args:
        shown: a promise, or a level that stays.
        level: 0 for falls, 1 for rises.
        since: an edge at this instant itself is not counted any more.
    """
    if not hasattr(shown, "after"):
        return NoEdges()
    clock = getattr(shown, "clock", None)
    found: ClockEdges = ScannedEdges(shown, level, since) if clock is None else clock(level, since)
    return found
