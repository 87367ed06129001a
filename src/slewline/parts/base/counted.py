"""Promises that follow from clock edges: the outputs of a counter, and of a latch.

    clock       __|‾|__|‾|__|‾|__|‾|__|‾|__
    Counted     0  | 1  | 1  | 0  | 0  | 1       levels selected by the edge count, repeated
    data        _____|‾‾‾‾‾‾‾‾‾‾‾‾‾‾|_______
    Sampled     _______|‾‾‾‾‾‾‾‾‾‾‾‾‾‾|_____       data level at the last edge

If a clock edge and the data change at the same instant, the edge samples the new level.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ...core.time.events import Events, NotYet, When
from ...core.wires.views import View
from ...core.wires.wave import Level, Promise, promised, real_edges


class Counted(View):
    """Levels selected by the number of clock edges: `levels[edges % len(levels)]`.

    Args:
        clock: the clock edges, derived from `of`.
        of: the promise or constant level of the clock wire; the levels are known only as far as the promise is.
        levels: the levels to repeat, each 0 or 1.
    """

    __slots__ = ("clocked", "levels", "of")

    def __init__(self, clock: Events, of: Promise | Level, levels: tuple[int, ...]) -> None:
        super().__init__()
        self.clocked, self.of, self.levels = clock, of, levels

    def inputs(self) -> Iterable[Promise]:
        return (self.of,) if promised(self.of) else ()

    def level_of(self, ps: int) -> Level:
        """Return the level at an instant (ps), 0 or 1, ignoring the view's own bound."""
        return self.levels[self.clocked.count(ps) % len(self.levels)]

    def after_of(self, ps: int) -> When:
        """Return the time (ps) of the next edge, NotYet, or None, as `after` does, ignoring the view's own bound."""
        levels, k = self.levels, self.clocked.count(ps)
        here = levels[k % len(levels)]
        for more in range(1, len(levels)):
            if levels[(k + more) % len(levels)] != here:
                return self.clocked.time(k + more)
        return None

    def edges_of(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return instants and levels of the edges in start < t <= stop (ps), ignoring the view's own bound.

        Returns:
            Two empty lists, or two arrays (int64 ps, int8 levels).
        """
        import numpy as np

        a, b = self.clocked.count(start), self.clocked.count(stop)
        if a == b:
            return [], []
        cycle = np.array(self.levels, np.int8)
        levels = cycle[np.arange(a, b + 1) % len(cycle)]
        real = levels[1:] != levels[:-1]
        return self.clocked.times(a + 1, b)[real], levels[1:][real]


class Sampled(View):
    """The data level at the last clock edge; a floating wire reads high.

    Args:
        clock: the clock edges after an instant.
        data: the promise or constant level of the data wire after that instant.
        before: the level until the first of these clock edges.
    """

    __slots__ = ("before", "clocked", "data")

    def __init__(self, clock: Events, data: Promise | Level, before: int) -> None:
        super().__init__()
        self.clocked, self.data, self.before = clock, data, before

    def inputs(self) -> Iterable[Promise]:
        return (self.data,) if promised(self.data) else ()

    def _read(self, ps: int) -> int:
        return int((self.data.level(ps) if promised(self.data) else self.data) != 0)

    def taken(self, k: int) -> int:
        """Return the level, 0 or 1, after the first k edges of the clock."""
        return self._read(int(self.clocked.times(k, k)[0])) if k else self.before

    def level_of(self, ps: int) -> Level:
        """Return the level at an instant (ps), 0 or 1, ignoring the view's own bound."""
        return self.taken(self.clocked.count(ps))

    def after_of(self, ps: int) -> When:
        """Return the time (ps) of the next edge, NotYet, or None, as `after` does, ignoring the view's own bound."""
        k = self.clocked.count(ps)
        following = self.clocked.time(k + 1)
        if isinstance(following, int) and self._read(following) == self.taken(k):
            return NotYet(following)
        return following

    def edges_of(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return instants and levels of the edges in start < t <= stop (ps), ignoring the view's own bound.

        Returns:
            Two lists, or two arrays (int64 ps, int8 levels).
        """
        import numpy as np

        a, b = self.clocked.count(start), self.clocked.count(stop)
        if a == b:
            return [], []
        times = self.clocked.times(a + 1, b)
        first = int(times[0])
        own, shown = self.data.edges(first, int(times[-1])) if promised(self.data) else ([], [])
        read = np.array([self._read(first), *(level != 0 for level in shown)], np.int8)
        levels = read[np.searchsorted(np.asarray(own, np.int64), times, side="right")]
        return real_edges(times, levels, self.taken(a))
