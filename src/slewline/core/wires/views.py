"""Promises derived from promises: an inverter, a gate, a delay, and the combination of several drivers on one wire.

    pulse           ‾|_|‾|_|‾|_|‾|_|‾|_|‾|_|‾‾‾‾      promise of a train
    enable          ‾‾‾‾‾‾‾‾‾‾|_________________      promise of an edge
    Gated: and      ‾|_|‾|_|‾||_________________      queried, not played

A view depends only on the promises from which it is derived: its level, next edge, and edges in a window
follow from theirs, so a million steps cost no more at the output of a gate than at its input.  A view is
immutable, except for `until`: when the drive of an input changes, the part that promised the view bounds
it by `until`, so that no later edge of the withdrawn promise is visible, and promises a new view in the
next round (parts/base/follower.py).

Edges are exact: each is a real change of level, and there is at most one per instant.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from itertools import product
from typing import Any

from ..time.events import Events, NotYet, Until, When, ask_at, before, later
from .clocking import WalkedEdges, clock_edges
from .wave import FLOATING, Level, Promise, floats, joined, promised, real_edges

TRIES = 16  # input changes without effect; after as many, `after` returns the instant reached


class View:
    """A promise derived from others.

    The view holds until the earliest of the bounds of its inputs and its own bound; see `until`.
    """

    __slots__ = ("_bound",)
    floats = False

    def __init__(self) -> None:
        self._bound: int | None = None

    # -------------------------------------------------------------------------- to be implemented by a kind of view
    def inputs(self) -> Iterable[Promise]:
        """Return the promises from which the view is derived."""
        raise NotImplementedError

    def level_of(self, ps: int) -> Level:
        """Return the level at an instant (ps), ignoring the view's own bound."""
        raise NotImplementedError

    def after_of(self, ps: int) -> When:
        """Return the instant of the next edge, NotYet, or None, as `after` does, ignoring the view's own bound."""
        raise NotImplementedError

    def edges_of(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop (ps) as `edges` does, ignoring the view's own bound; start < stop."""
        raise NotImplementedError

    def holds(self) -> int | None:
        """Return the instant (ps) before which all inputs hold; None if they hold forever."""
        return min((bound for of in self.inputs() if (bound := of.until) is not None), default=None)

    # ------------------------------------------------------------------------------------------------- the promise
    @property
    def until(self) -> int | None:
        """The instant (ps) before which the promise holds; None if it holds forever."""
        bounds = [ps for ps in (self.holds(), self._bound) if ps is not None]
        return min(bounds, default=None)

    @until.setter
    def until(self, ps: int | None) -> None:
        self._bound = ps

    @property
    def bound(self) -> int | None:
        """The view's own bound (ps), which ends the view even if its inputs continue; None if it has none."""
        return self._bound

    def level(self, ps: int) -> Level:
        """Return the level at an instant (ps), after any edge at that instant."""
        return self.level_of(ps if self._bound is None or ps < self._bound else self._bound - 1)

    def after(self, ps: int) -> When:
        """Return the time (ps) of the next edge later than `ps`; NotYet if not found yet; None if none is foreseen."""
        return before(self.after_of(ps), self._bound)

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop (ps): two lists, or two arrays (int64 ps, int8 levels)."""
        if self._bound is not None and stop >= self._bound:
            stop = self._bound - 1
        return self.edges_of(start, stop) if stop > start else ([], [])


class Bounded(Until):
    """The events of a source that are before the bound of a view; the bound may still change."""

    def __init__(self, of: Events, view: View) -> None:
        self.of, self.view = of, view

    @property
    def until(self) -> int | None:  # type: ignore[override]
        """The instant (ps) before which events count; None if all events count."""
        return self.view.bound


class Repeated(View):
    """A promise repeated unchanged, but with its own bound: the output of a buffer."""

    __slots__ = ("of",)

    def __init__(self, of: Promise) -> None:
        super().__init__()
        self.of = of

    @property
    def floats(self) -> bool:  # type: ignore[override]
        """True if the repeated promise releases the wire at times."""
        return floats(self.of)

    def inputs(self) -> Iterable[Promise]:
        return (self.of,)

    def clock(self, level: int, since: int) -> Events:
        """Return the edges to a level after an instant (ps), as numbered events (see clocking.py)."""
        return Bounded(clock_edges(self.of, level, since), self)

    def level_of(self, ps: int) -> Level:
        """Return the level at an instant (ps), 0, 1 or None, ignoring the view's own bound."""
        return self.of.level(ps)

    def after_of(self, ps: int) -> When:
        return self.of.after(ps)

    def edges_of(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop (ps): two lists, or two arrays (int64 ps, int8 levels)."""
        times, levels = self.of.edges(start, stop)
        return real_edges(times, levels, self.of.level(start))


class Rested(Repeated):
    """A promise on a wire with a pull or a tie, which sets the level while the promise releases the wire."""

    __slots__ = ("rest",)
    floats = False

    def __init__(self, of: Promise, rest: Level) -> None:
        super().__init__(of)
        self.rest = rest

    def clock(self, level: int, since: int) -> Events:
        return WalkedEdges(self, level, since)

    def level_of(self, ps: int) -> Level:
        return self.rest if (level := self.of.level(ps)) is None else level

    def after_of(self, ps: int) -> When:
        following = self.of.after(ps)
        if isinstance(following, int) and self.level_of(following) == self.level_of(ps):
            return NotYet(following)  # it begins or ceases to float
        return following

    def edges_of(self, start: int, stop: int) -> tuple[Any, Any]:
        times, levels = self.of.edges(start, stop)
        if isinstance(levels, list):
            levels = [self.rest if level is None else level for level in levels]
        return real_edges(times, levels, self.level_of(start))


class Inverted(Repeated):
    """The inverse of a promise; floating is passed on unchanged."""

    __slots__ = ()

    def clock(self, level: int, since: int) -> Events:
        """Return the edges to a level after an instant (ps), which are the input's edges to the opposite level."""
        return super().clock(1 - level, since)

    def level_of(self, ps: int) -> Level:
        return None if (level := self.of.level(ps)) is None else 1 - level

    def edges_of(self, start: int, stop: int) -> tuple[Any, Any]:
        times, levels = super().edges_of(start, stop)
        if isinstance(levels, list):
            return times, [None if level is None else 1 - level for level in levels]
        return times, 1 - levels


class Combined(View):
    """The combination of several inputs (promises and constant levels), at least one of which is a promise."""

    __slots__ = ("of",)

    def __init__(self, of: Sequence[Promise | Level]) -> None:
        super().__init__()
        self.of = tuple(of)

    def combined(self, levels: Sequence[Level]) -> Level:
        """Return the output, 0, 1 or None, for the levels of the inputs."""
        raise NotImplementedError

    def combined_many(self, levels: Any) -> Any:
        """Return the outputs, (n,) int8, for many levels of the inputs, (inputs, n) int8; -1 stands for None."""
        raise NotImplementedError

    def decides(self, number: int, level: Level) -> bool:
        """Return whether an input with this level determines the output, regardless of the others."""
        raise NotImplementedError

    def inputs(self) -> Iterable[Promise]:
        return filter(promised, self.of)

    def _levels(self, ps: int) -> list[Level]:
        return [what.level(ps) if promised(what) else what for what in self.of]

    def level_of(self, ps: int) -> Level:
        """Return the level at an instant (ps), 0, 1 or None, ignoring the view's own bound."""
        return self.combined(self._levels(ps))

    def after_of(self, ps: int) -> When:
        levels = self._levels(ps)
        here = self.combined(levels)
        for _ in range(TRIES):
            deciding = [of for n, of in enumerate(self.of) if promised(of) and self.decides(n, levels[n])]
            times = [ask_at(of.after(ps)) for of in deciding or self.inputs()]
            coming = [time for time in times if time is not None]
            if not coming or (deciding and len(coming) < len(times)):
                return None
            ps = max(coming) if deciding else min(coming)  # constant until the last deciding input changes
            before, levels = levels, self._levels(ps)
            if self.combined(levels) != here:
                return ps
            if levels == before:  # an input without a known edge has searched far enough
                break
        return NotYet(ps)

    def edges_of(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop (ps): two lists, or two arrays (int64 ps, int8 levels)."""
        asked: list[tuple[Any, Any]] = [what.edges(start, stop) if promised(what) else ([], []) for what in self.of]
        before = self._levels(start)
        if all(isinstance(times, list) for times, _ in asked):
            instants = sorted({time for times, _ in asked for time in times})
            return real_edges(instants, [self.level_of(ps) for ps in instants], self.combined(before))
        import numpy as np

        times = np.unique(np.concatenate([np.asarray(times, np.int64) for times, _ in asked]))
        levels = np.empty((len(asked), len(times)), np.int8)
        for n, (own, shown) in enumerate(asked):
            codes = [FLOATING if level is None else level for level in shown] if isinstance(shown, list) else shown
            codes = np.concatenate(([FLOATING if before[n] is None else before[n]], codes)).astype(np.int8)
            levels[n] = codes[np.searchsorted(np.asarray(own, np.int64), times, side="right")]
        return real_edges(times, self.combined_many(levels), self.combined(before))


class Wired(Combined):
    """Several drivers on one wire: low wins, and while none of them drives, the wire has its rest level."""

    __slots__ = ("_rest", "_wired")

    def __init__(
        self, of: Sequence[Promise | Level], wired: Callable[[Iterable[Level]], tuple[Level, bool]], rest: Level
    ) -> None:
        super().__init__(of)
        self._wired, self._rest = wired, rest

    @property
    def floats(self) -> bool:  # type: ignore[override]
        """True if there are times at which no driver drives the wire."""
        return self._rest is None and all(map(floats, self.of))

    def combined(self, levels: Sequence[Level]) -> Level:
        return self._rest if (level := self._wired(levels)[0]) is None else level

    def combined_many(self, levels: Any) -> Any:
        import numpy as np

        rest = FLOATING if self._rest is None else self._rest
        return np.where((levels == 0).any(0), 0, np.where((levels == 1).any(0), 1, rest)).astype(np.int8)

    def decides(self, number: int, level: Level) -> bool:
        return level == 0 and level.__class__ is int


class Gated(Combined):
    """A logic gate.

    `table` holds the output, indexed by the number whose bit 0 is the first input, bit 1 the second ...  A
    floating input reads high, as with TTL.
    """

    __slots__ = ("table",)

    def __init__(self, of: Sequence[Promise | Level], table: tuple[int, ...]) -> None:
        super().__init__(of)
        self.table = table

    def combined(self, levels: Sequence[Level]) -> Level:
        return self.table[sum(1 << n for n, level in enumerate(levels) if level != 0)]

    def combined_many(self, levels: Any) -> Any:
        import numpy as np

        number = ((levels != 0) << np.arange(len(levels))[:, None]).sum(0)
        return np.array(self.table, np.int8)[number]

    def decides(self, number: int, level: Level) -> bool:
        return (number, level != 0) in deciding(self.table)


class Delayed(View):
    """A delayed waveform; `pieces` are pairs (instant in ps, undelayed waveform from that instant), ascending."""

    __slots__ = ("lag_ps", "pieces")

    def __init__(self, pieces: Sequence[tuple[int, Promise | Level]], lag_ps: int) -> None:
        super().__init__()
        self.pieces, self.lag_ps = tuple(pieces), lag_ps

    @property
    def floats(self) -> bool:  # type: ignore[override]
        """True if the delayed waveform releases the wire at times."""
        return any(floats(what) for _, what in self.pieces)

    def holds(self) -> int | None:
        """Return the instant (ps) before which the output is known; None if it is known forever.

        This is the instant before which the input holds, plus the delay.
        """
        last = self.pieces[-1][1]
        return last.until + self.lag_ps if promised(last) and last.until is not None else None

    def _piece(self, ps: int) -> int:
        return max(bisect_right(self.pieces, ps, key=lambda piece: piece[0]) - 1, 0)

    def level_of(self, ps: int) -> Level:
        """Return the level at an instant (ps), 0, 1 or None, ignoring the view's own bound."""
        what = self.pieces[self._piece(ps - self.lag_ps)][1]
        return what.level(ps - self.lag_ps) if promised(what) else what

    def after_of(self, ps: int) -> When:
        n = self._piece(ps - self.lag_ps)
        what = self.pieces[n][1]
        following = what.after(ps - self.lag_ps) if promised(what) else None
        if n + 1 < len(self.pieces) and ((at := ask_at(following)) is None or at > self.pieces[n + 1][0]):
            following = NotYet(self.pieces[n + 1][0])
        return later(following, self.lag_ps)

    def edges_of(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop (ps): two lists, or two arrays (int64 ps, int8 levels)."""
        first, last = self._piece(start - self.lag_ps), self._piece(stop - self.lag_ps)
        parts: list[tuple[Any, Any]] = []
        for n in range(first, last + 1):
            since, what = self.pieces[n]
            begin, end = start - self.lag_ps, stop - self.lag_ps
            if n > first:
                begin = since
                parts.append(([since], [what.level(since) if promised(what) else what]))
            if n < last:
                end = self.pieces[n + 1][0] - 1
            if promised(what) and end > begin:
                parts.append(what.edges(begin, end))
        times, levels = joined(parts)
        times = [time + self.lag_ps for time in times] if isinstance(times, list) else times + self.lag_ps
        return real_edges(times, levels, self.level_of(start))


# --------------------------------------------------------------------------------------------------- the simplest view
def inverted(what: Any) -> Promise | Level:
    """Return the inverse of a level or a promised waveform; None remains None."""
    return Inverted(what) if promised(what) else None if what is None else 1 - what


def gated(inputs: Sequence[Promise | Level], table: tuple[int, ...]) -> Promise | Level:
    """Return the output of a gate: a level if it is constant, otherwise the simplest promised waveform.

    Args:
        inputs: for each input, a promised waveform or a constant level; None (floating) reads high.
        table: the truth table: the output, 0 or 1, indexed by the number whose bit 0 is the first input, bit 1 the
            second ...
    """
    of: list[Promise] = []  # each promise once: several inputs may be on one wire
    for what in inputs:
        if promised(what) and not any(what is other for other in of):
            of.append(what)
    own = tuple(_row(inputs, table, of, bits) for bits in _rows(len(of)))
    for n in reversed(range(len(of))):  # an input without effect on the output is dropped
        if all(own[i] == own[i ^ 1 << n] for i in range(len(own))):
            own = tuple(level for i, level in enumerate(own) if not i >> n & 1)
            del of[n]
    if not of:
        return own[0]
    if len(of) == 1 and not floats(of[0]):
        return Repeated(of[0]) if own == (0, 1) else Inverted(of[0])
    return Gated(of, own)


def _row(inputs: Sequence[Any], table: tuple[int, ...], of: list[Promise], bits: Sequence[int]) -> int:
    """Return the output of a gate while the promises in `of` have the levels in `bits`."""
    number = 0
    for n, what in enumerate(inputs):
        level = next((bit for other, bit in zip(of, bits, strict=True) if other is what), what)
        number |= (level != 0) << n
    return table[number]


@lru_cache(maxsize=16)
def _rows(count: int) -> tuple[tuple[int, ...], ...]:
    """Return all combinations of levels of `count` inputs, ordered so that the first input changes fastest."""
    return tuple(bits[::-1] for bits in product((0, 1), repeat=count))


@lru_cache(maxsize=256)
def deciding(table: tuple[int, ...]) -> frozenset[tuple[int, bool]]:
    """Return the pairs (gate input, level) that each determine the output, regardless of the other inputs."""
    inputs = range(len(table).bit_length() - 1)
    return frozenset(
        (n, bool(level))
        for n in inputs
        for level in (0, 1)
        if len({out for i, out in enumerate(table) if i >> n & 1 == level}) == 1
    )
