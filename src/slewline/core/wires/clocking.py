"""The edges of one direction on a wire, as numbered events (core/time/events.py).

Step counters (a translator, a shaft, the counter of a driver module) follow the falls, or the rises, of one wire:

    wire     ‾‾|__|‾‾‾|__|‾‾‾|__|‾‾‾‾
    falls      1      2      3

A wave that follows a step train computes these edges by arithmetic (its `clock`).  Any other wave is
scanned, one stretch at a time; the scan takes little memory: one entry per `BLOCK` edges.

Rules of this file: an edge is a change *to* the given level; edges are numbered from 1 after the instant
`since`, and an edge at `since` itself is left to the caller; queries have no effect on the wire.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import TYPE_CHECKING, Any

from ..time.events import Events, NoEvents, NotYet, When, ask_at

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

BLOCK = 1 << 14  # edges expanded at a time
LOOKS = 64  # maximum number of edges that a query about the future looks ahead
FIRST_PS = 1_000_000_000  # the first stretch; the next ones are longer, as long as edges are few


class ScanWindow:
    """The length of the next stride of a scan along a wire, adapted to find thousands of edges per stride."""

    def __init__(self) -> None:
        self.ps = FIRST_PS

    def stop(self, start: int, stop: int) -> int:
        """Return the end (ps) of a stride that begins at `start`; it is not later than `stop`."""
        return min(start + self.ps, stop)

    def adapt(self, count: int) -> None:
        """Adapt the length of the next stride to `count`, the number of edges found in the stride just finished."""
        if count > BLOCK:
            self.ps = max(self.ps // 4, 1)
        elif count < BLOCK // 4:
            self.ps *= 2

    def skipped(self, ps: int) -> None:
        """Reset the stride length if the scan skipped `ps`, more than one stride: edges may be dense there."""
        if ps > self.ps:
            self.ps = FIRST_PS


class WalkedEdges(Events):
    """The edges of any wave, found by scanning it.

    The scan is divided into stretches.  `_starts` has the instant at which each stretch begins, and
    `_counts` the number of edges up to and including that instant.  The last expanded stretch is kept, since
    consecutive queries are often close together.
    """

    def __init__(self, promise: Any, level: int, since: int) -> None:
        self.promise, self.level = promise, level
        self._starts, self._counts = [since], [0]
        self._reached, self._found = since, 0  # the end of the scan so far, and the number of edges found
        self._strides = ScanWindow()
        self._cached: tuple[int, int, int, Any] = (since, 0, 0, ())  # start; first ... last-1, from 0; instants

    def _edges(self, start: int, stop: int) -> Any:
        """Return the instants of the edges in start < t <= stop (ps), as a list or an array."""
        times, levels = self.promise.edges(start, stop)
        if isinstance(levels, list):
            befores = [self.promise.level(start), *levels]  # a list may contain edges that do not change the level
            return [
                time
                for time, before, level in zip(times, befores, levels, strict=False)
                if level == self.level != before
            ]
        return times[levels == self.level]

    def _walk(self, ps: int) -> None:
        """Continue the scan, counting edges, up to an instant (ps)."""
        while self._reached < ps:
            stop = self._strides.stop(self._reached, ps)
            times = self._edges(self._reached, stop)
            count = len(times)
            self._strides.adapt(count)
            self._cached = (self._reached, self._found, self._found + count, times)
            if self._found + count - self._counts[-1] > BLOCK:
                self._starts.append(self._reached)
                self._counts.append(self._found)
            self._reached, self._found = stop, self._found + count
            if not count:
                following = ask_at(self.promise.after(stop))
                self._reached = ps if following is None else max(stop, min(following - 1, ps))
                self._strides.skipped(self._reached - stop)

    def count(self, ps: int) -> int:
        """Return the number of edges up to and including an instant (ps)."""
        self._walk(ps)
        start, first, _, times = self._cached
        if ps >= self._reached:
            return self._found
        if ps >= start:
            return first + bisect_right(times, ps)
        i = max(bisect_right(self._starts, ps) - 1, 0)
        return self._counts[i] + (len(self._edges(self._starts[i], ps)) if ps > self._starts[i] else 0)

    def time(self, k: int) -> When:
        """Return the instant (ps) of edge k; NotYet if the search stopped early; None if edge k is not foreseen."""
        reached = self._reached
        for _ in range(LOOKS):
            if k <= self._found:
                break
            following = self.promise.after(reached)
            if following is None:
                return None
            reached = following.at if isinstance(following, NotYet) else following
            self._walk(reached)
            if k > self._found and isinstance(following, NotYet):  # the wave itself has looked ahead far enough
                return following
        if k > self._found:
            return NotYet(reached)
        found = self.times(k, k)
        return int(found[0]) if len(found) else None  # it was promised, and is withdrawn

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of edges first ... last, all of which must exist: (n,) int64 ps, ascending."""
        import numpy as np

        _, a, b, times = self._cached
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


def clock_edges(shown: Any, level: int, since: int) -> Events:
    """Return, as events, the edges to a level after an instant, given the present waveform of the wire.

    Args:
        shown: the waveform: a wave, or a constant level.
        level: 0 for falls, 1 for rises.
        since: the instant (ps) after which edges count; an edge at `since` itself does not.
    """
    if not hasattr(shown, "after"):
        return NoEvents()
    clock = getattr(shown, "clock", None)
    found: Events = WalkedEdges(shown, level, since) if clock is None else clock(level, since)
    return found
