"""The count that an encoder or a switch shows while its shaft turns.

    position |-------|-------|-------|-------|           counts
             |----|----|----|----|----|----|----         steps

A `CountScale` assigns a count, an integer, to each position of a shaft.  For an encoder, the count grows
by a fixed number per step; for a switch, it is the number of bounds at or below the position.  For a
motion of the shaft, a `Counter` returns the count at an instant, the next change of the count, and its
past changes; shown.py converts counts to levels on wires.  Scales and counters have no state, and no
step is an event.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Protocol, cast

from ...core.time.events import Until, When, ask_at, later
from .shaft_motion import ShaftMotion

DWELL_PS = 800_000  # interval between the counts of one step, if there are several
MANY = 64  # counts; for more, arrays are faster


@dataclass(frozen=True)
class CountScale:
    """A scale that assigns a count to each position of a shaft.

    With `per_step` (counts per step), the count is the position times `per_step`, rounded down.  With
    `bounds` (positions in steps, ascending), the count is the number of bounds at or below the position.
    """

    per_step: Fraction = Fraction(0)
    bounds: tuple[Fraction, ...] = ()  # places in steps, ascending

    def of(self, unit: int) -> Marks:
        """Return the same scale for positions in parts of a step; a step has `unit` parts."""
        ratio = self.per_step / unit
        bounds = tuple(-(-bound * unit // 1) for bound in self.bounds)
        return Marks(unit, ratio.numerator, ratio.denominator, bounds)


@dataclass(frozen=True)
class Marks:
    """A `CountScale` for positions in parts of a step; a step has `unit` parts.

    The count is the position times `numerator / denominator`, rounded down; or, if `numerator` is 0, the
    number of `bounds` (in parts) at or below the position.
    """

    unit: int
    numerator: int
    denominator: int
    bounds: tuple[int, ...]

    def count(self, place: int) -> int:
        """Return the count at a position (in parts of a step)."""
        if self.numerator:
            return place * self.numerator // self.denominator
        return bisect_right(self.bounds, place)

    def place(self, count: Any) -> Any:
        """Return the lowest position (in parts) that has a given count; for an int64 array of counts, an array."""
        return -(-count * self.denominator // self.numerator) if self.numerator else self.bounds[count - 1]

    def places(self, counts: range) -> list[int]:
        """Return the lowest position (in parts) for each count of a range."""
        n, d = self.numerator, self.denominator
        return [-(-count * d // n) for count in counts] if n else [self.bounds[count - 1] for count in counts]

    def within(self, count: int) -> bool:
        """Return whether `place` can return a position for a count; with bounds, only for 1 to their number."""
        return bool(self.numerator) or 1 <= count <= len(self.bounds)


UNKNOWN = Marks(0, 0, 1, ())


class Counter(Protocol):
    """The counts of a motion on a scale: a wave whose level is the count (core/wires/wave.py).

    A part that turns its shaft continuously, not in steps, provides its own counter.
    """

    scale: CountScale
    lag_ps: int

    @property
    def direction(self) -> int:
        """Counting direction: 1 for up, -1 for down, 0 if it may reverse."""

    def level(self, ps: int) -> int:
        """Return the count shown at an instant (ps)."""

    def after(self, ps: int, changes: int = 1) -> When:
        """Return when (ps) the count shown will have changed `changes` times after an instant (ps).

        If, at that instant, a change caused by an earlier motion has not been shown yet, return when the next
        change is shown, whatever `changes` is.
        """

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the changes shown at start < t <= stop (ps), but none after the last committed instant.

        Returns:
            The instants of the changes, ascending, and the counts after them: two lists, or two int64 arrays.
        """

    def onward(self, ps: int) -> Counter:
        """Return a counter that continues from an instant (ps)."""

    def on(self, motion: Any, now: int) -> Counter:
        """Return a counter for `motion`, which from `now` (ps) on continues the motion counted so far."""


@dataclass(slots=True)
class StepCounter:
    """The counts of a motion made of steps, shown `lag_ps` after the steps.

    `coming` holds the changes (instants, counts) that had been caused, but not yet shown, when the motion
    began; `before` is the count shown at that time.  When the first change of this motion is shown, any
    changes in `coming` that have not been shown are cancelled.
    """

    motion: ShaftMotion
    scale: CountScale
    lag_ps: int
    before: int | None = None  # None: the count that the motion begins with
    coming: tuple[list[int], list[int]] = ([], [])
    marks: Marks = UNKNOWN  # the scale, in parts as used by the motion
    count: int = field(init=False)  # when all changes under way have been shown
    several: int = field(init=False)  # interval between the counts of one step; 0: not shown singly
    _recent: tuple[int, int, int, tuple[Any, Any]] | None = field(init=False, default=None)  # A and B ask the same

    def __post_init__(self) -> None:
        if self.marks.unit != self.motion.unit:
            self.marks = self.scale.of(self.motion.unit)
        self.count = self.marks.count(self.motion.place)
        if self.before is None:
            self.before = self.count
        per_edge = -(-self.marks.numerator * self.motion.step // self.marks.denominator)
        self.several = per_edge if per_edge > 1 else 0

    # ---------------------------------------------------------------------------- changes of this motion, from 1 on
    def _changes(self, k: int) -> int:
        """Return the number of changes caused by the first k edges of this motion."""
        motion = self.motion
        return abs(self.marks.count(motion.place + motion.sign * motion.moved(k)) - self.count)

    def _parts(self, j: Any) -> Any:
        if self.motion.sign > 0:
            return self.marks.place(self.count + j) - self.motion.place
        return self.motion.place - self.marks.place(self.count - j + 1) + 1

    def _edge(self, j: int) -> int | None:
        """Return the number of the edge of this motion that causes change j, or None if there is no such edge."""
        if not self.marks.within(self.count + j if self.motion.sign > 0 else self.count - j + 1):
            return None
        return self.motion.edge_by(self._parts(j))

    def _due(self, j: int) -> When:
        """Return the instant (ps) at which change j is shown; NotYet if it is not known yet.

        Return None if no planned edge causes that change.
        """
        k = self._edge(j)
        if k is None:
            return None
        due = self.motion.time(k)
        if self.several and isinstance(due, int) and (late := j - 1 - self._changes(k - 1)):
            due += late * DWELL_PS
            following = ask_at(self.motion.time(k + 1)) if self.motion.count(due) > k else None
            due = due if following is None else min(due, following)  # the next step moves the shaft without delay
        return later(due, self.lag_ps)

    def _shown(self, ps: int) -> int:
        """Return the number of changes of this motion that have been shown by an instant (ps)."""
        ps -= self.lag_ps
        k = self.motion.count(ps)
        if k <= 0:
            return 0
        over = self._changes(k)
        if self.several and isinstance(begun := self.motion.time(k), int):  # the last step may be under way
            over = min(over, self._changes(k - 1) + 1 + (ps - begun) // DWELL_PS)
        return over

    # --------------------------------------------------------------------------------------------------------- queries
    @property
    def direction(self) -> int:
        """Counting direction: 1 up, -1 down."""
        return self.motion.sign

    def level(self, ps: int) -> int:
        """Return the count shown at an instant (ps)."""
        return self._after_changes(self._shown(ps), ps)

    def _after_changes(self, j: int, ps: int) -> int:
        """Return the count shown at an instant (ps), given that j changes of this motion have been shown by then."""
        if j:
            return self.count + self.motion.sign * j
        times, counts = self.coming
        over = bisect_right(times, ps)
        return counts[over - 1] if over else cast("int", self.before)

    def after(self, ps: int, changes: int = 1) -> When:
        """Return when (ps) the count shown will have changed `changes` times after an instant (ps).

        If, at that instant, a change caused by an earlier motion has not been shown yet, return when the next
        change is shown, whatever `changes` is.
        """
        j = self._shown(ps)
        times = self.coming[0]
        over = bisect_right(times, ps)
        if j or over == len(times):
            return self._due(j + changes)
        due = self._due(1)
        at = ask_at(due)
        return due if at is not None and at <= times[over] else times[over]

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the changes shown at start < t <= stop (ps), but none after the last committed instant.

        Returns:
            The instants of the changes, ascending, and the counts after them: two lists, or two int64 arrays.
        """
        recent = self._recent
        if recent is not None and recent[:2] == (start, stop):
            return recent[3]
        a, b = recent[2] if recent is not None and recent[1] == start else self._shown(start), self._shown(stop)
        times, counts = self._own(a, b)
        pending, shown = self.coming
        if not a and pending:
            part = slice(bisect_right(pending, start), bisect_right(pending, int(times[0]) if b else stop))
            times, counts = _joined(pending[part], times), _joined(shown[part], counts)
        self._recent = start, stop, b, (times, counts)
        return times, counts

    def _own(self, a: int, b: int) -> tuple[Any, Any]:
        """Return changes a + 1 to b of this motion: the instants, and the counts after them.

        The instants of all these changes must be known already.
        """
        motion = self.motion
        if b - a <= MANY:
            sign, step, first, lag = motion.sign, motion.step, motion.first, self.lag_ps
            counts = range(self.count + sign * (a + 1), self.count + sign * (b + 1), sign)
            if self.several:
                return [ask_at(self._due(j)) for j in range(a + 1, b + 1)], [*counts]
            entered = counts if sign > 0 else range(counts.start + 1, counts.stop + 1, -1)
            rest = motion.slack - sign * motion.place + (sign < 0)
            edges = [first - -(sign * place + rest) // step for place in self.marks.places(entered)]  # as in _parts
            return [at + lag for at in motion.drive.few(edges)], [*counts]
        import numpy as np

        j = np.arange(a + 1, b + 1)
        parts = self._parts(j)
        k = -(-(parts + motion.slack) // motion.step)
        first, last = int(k[0]), int(k[-1])
        k -= first
        instants = motion.drive.times(motion.first + first, motion.first + last)
        times = instants[k]
        if self.several:
            begins = np.searchsorted(k, k)
            late = np.arange(b - a) - begins + np.where(begins, 0, a - self._changes(first - 1))
            following = np.append(instants[1:], np.iinfo(np.int64).max)  # after the last change there is none yet
            times = np.minimum(times + late * DWELL_PS, following[k])
        return times + self.lag_ps, self.count + motion.sign * j

    # ------------------------------------------------------------------------------------------------ from here on
    def onward(self, ps: int) -> StepCounter:
        """Return a counter that begins at an instant (ps).

        Changes that have been caused, but not yet shown, at that instant are passed on in `coming`.  They are
        computed only from the edges of the drive up to that instant, because later edges may still change.
        """
        motion = self.motion.onward(ps)
        pending = self.coming[0]
        over = self._changes(self.motion.count(ps))
        if self._shown(ps) == over and (over or not pending or pending[-1] <= ps):  # nothing is under way
            return StepCounter(motion, self.scale, self.lag_ps, self.level(ps), ([], []), self.marks)
        past = replace(self, motion=replace(self.motion, drive=Until(self.motion.drive, ps + 1)))
        times, counts = past.edges(ps, ps + self.lag_ps + (self.several + 1) * DWELL_PS * (self.several > 0))
        coming = [int(time) for time in times], [int(count) for count in counts]
        return StepCounter(motion, self.scale, self.lag_ps, self.level(ps), coming, self.marks)

    def on(self, motion: ShaftMotion, now: int) -> StepCounter:
        """Return a counter for `motion`: the present motion, continued or shifted by a push on the shaft.

        `now` is the instant (ps) from which the new counter is used: that of the push, if there is one.
        """
        after = StepCounter(motion, self.scale, self.lag_ps, self.before, self.coming, self.marks)
        by = after.count - self.count
        if by:
            times, counts = self.coming
            due = now + self.lag_ps
            over = bisect_right(times, due)
            here = counts[over - 1] if over else cast("int", self.before)
            later = [here + by, *(count + by for count in counts[over:])]
            after.coming = [*times[:over], due, *times[over:]], counts[:over] + later
        return after


def counter_of(motion: Any, scale: CountScale, lag_ps: int) -> Counter:
    """Return a counter of a motion; the counter shows each count `lag_ps` later.

    A motion that is not made of steps provides the counter itself.
    """
    if isinstance(motion, ShaftMotion):
        return StepCounter(motion, scale, lag_ps)
    own: Counter = motion.counter(scale, lag_ps)
    return own


def _joined(few: list[int], more: Any) -> Any:
    """Return two lists, or a list and an array, joined into one."""
    if isinstance(more, list):
        return few + more
    import numpy as np

    return np.concatenate((np.array(few, np.int64), more))
