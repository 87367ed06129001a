"""Promises of drivers: waveforms that are known in advance; the simplest is a list of edges."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from itertools import compress
from operator import ne
from typing import Any, Protocol

from ..time.events import When, before

Level = Any  # 0, 1 or None on a wire; (mask, value) or None on a bus
Edges = tuple[Level, tuple[int, ...], tuple[Level, ...]]  # of a wave: initial level, instants in ps, new levels
FLOATING = -1  # in arrays of levels: None


def promised(what: Any) -> bool:
    """Return whether an object is a promise rather than a level."""
    return not (what is None or what.__class__ is int or what.__class__ is tuple)


def floats(what: Promise | Level) -> bool:
    """Return whether a promise releases the wire at times; for a constant level, whether it is None."""
    return what is None or getattr(what, "floats", False)


def alike(one: Any, two: Any) -> bool:
    """Return whether two objects are the same promise, or equal levels."""
    return one is two or (not promised(one) and not promised(two) and one == two)


class Promise(Protocol):
    """A waveform known in advance; from the instant `until` on, it keeps the level just before `until`."""

    @property
    def until(self) -> int | None:
        """The instant (ps) before which the promise holds; None if it holds forever."""

    def level(self, ps: int) -> Level:
        """Return the level at an instant (ps), after any edges at that instant."""

    def after(self, ps: int) -> When:
        """Return the time (ps) of the next edge later than `ps`; NotYet if not found yet; None if none is foreseen."""

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop: their instants in ps, and the levels after them."""


class Wave:
    """A promise of a few edges at known instants, as for strobes and scheduled changes."""

    __slots__ = ("before", "levels", "times", "until")

    def __init__(self, before: Level, times: tuple[int, ...], levels: tuple[Level, ...]) -> None:
        self.before, self.times, self.levels = before, times, levels
        self.until: int | None = None

    @property
    def floats(self) -> bool:
        """True if the wave releases the wire at times."""
        return self.before is None or None in self.levels

    def whole(self, start: int, stop: int) -> bool:
        """Return whether the wave has no `until`, and one or more edges, all in start < t < stop (ps)."""
        times = self.times
        return self.until is None and bool(times) and start < times[0] and times[-1] < stop

    def level(self, ps: int) -> Level:
        """Return the level at an instant (ps), after any edge at that instant."""
        if self.until is not None and ps >= self.until:
            ps = self.until - 1
        over = bisect_right(self.times, ps)
        return self.levels[over - 1] if over else self.before

    def levels_before(self, instants: list[int]) -> list[Level]:
        """Return the levels just before each of several instants (ps); the wave must not have an `until`."""
        times, levels = self.times, self.levels
        overs = [bisect_left(times, ps) for ps in instants]
        return [levels[over - 1] if over else self.before for over in overs]

    def after(self, ps: int) -> When:
        """Return the time (ps) of the next edge strictly after `ps`; None if no edge is foreseen."""
        times, levels = self.times, self.levels
        over = bisect_right(times, ps)
        here = levels[over - 1] if over else self.before
        while over < len(times):
            time = times[over]
            over = bisect_right(times, time, over)
            if levels[over - 1] != here:
                return before(time, self.until)
        return None

    def edges(self, start: int, stop: int) -> tuple[list[int], list[Level]]:
        """Return the edges in start < t <= stop: a list of instants (ps) and a list of levels."""
        if self.whole(start, stop + 1):
            return [*self.times], [*self.levels]
        pairs = [
            p
            for p in zip(self.times, self.levels, strict=True)
            if start < p[0] <= stop and (self.until is None or p[0] < self.until)
        ]
        return [time for time, _ in pairs], [level for _, level in pairs]


def real_edges(times: Any, levels: Any, before: Level) -> tuple[Any, Any]:
    """Return the edges that change the level; of several edges at one instant, only the last counts.

    Args:
        times, levels: the edges, in ascending order: two lists; or two arrays, with FLOATING for None.
        before: the level before the first edge.
    """
    if not isinstance(times, list):
        import numpy as np

        again = times[1:] == times[:-1]
        if again.any():
            last = np.append(~again, True)
            times, levels = times[last], levels[last]
        real = np.empty(len(levels), bool)
        real[:1] = levels[:1] != (FLOATING if before is None else before)
        np.not_equal(levels[1:], levels[:-1], out=real[1:])
        times, levels = (times, levels) if real.all() else (times[real], levels[real])
        if len(levels) and levels.min() < 0:
            return times.tolist(), [None if level < 0 else level for level in levels.tolist()]
        return times, levels
    lasting = dict(zip(times, levels, strict=True))
    changes = [*map(ne, lasting.values(), [before, *lasting.values()])]
    return [*compress(lasting, changes)], [*compress(lasting.values(), changes)]


def joined(parts: Sequence[tuple[Any, Any]]) -> tuple[Any, Any]:
    """Join consecutive parts of a waveform, each given as edges (times, levels) in lists or arrays.

    The result is two lists if all parts are lists; otherwise two arrays, with FLOATING for None.
    """
    if all(isinstance(times, list) for times, _ in parts):
        return [time for times, _ in parts for time in times], [level for _, levels in parts for level in levels]
    import numpy as np

    codes = [
        [FLOATING if level is None else level for level in levels] if isinstance(levels, list) else levels
        for _, levels in parts
    ]
    return (
        np.concatenate([np.asarray(times, np.int64) for times, _ in parts]),
        np.concatenate([np.asarray(levels, np.int8) for levels in codes]),
    )
