"""How a shaft turns: asked, not stepped.

The place of a shaft is kept in parts of a count, so that nothing drifts: a count is `steps` parts long, and a step of
the motor moves the shaft by `counts` parts.  So the count is floor(steps made * counts / steps) at every instant.

    place    |-------|-------|-------|-------|           counts
             |----|----|----|----|----|----|----         steps

A `Drive` knows when the steps come, for example a train that PULSE promises.  A `Course` makes counts of them, from an
instant on and until something happens that it does not know of, and a `Channel` is the promise of a wire that shows
the counts.  None of them has a state, and none makes an event of a step.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from ..core.cycles import SquareView
from ..core.timebase import Clock
from ..core.train import PulseView, StrobeView

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Shown: TypeAlias = tuple[int, Any, Any]
DWELL_PS = 800_000  # the counts of one step follow each other so fast, where a step is several of them
MANY = 64  # counts; more are worth arrays


# --------------------------------------------------------------------------------------------------- what turns a shaft
class Drive(Protocol):
    """Steps that turn a shaft, numbered from 1."""

    def by(self, ps: int) -> int:
        """How many there have been by an instant, that instant included."""

    def at(self, k: int) -> int | None:
        """The instant of step k; None: it does not come."""

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        """The instants of steps first ... last, as far as they come: (n,) int64 ps."""


class Still:
    """Nothing turns the shaft."""

    def by(self, ps: int) -> int:
        return 0

    def at(self, k: int) -> int | None:
        return None

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        import numpy as np

        return np.empty(0, np.int64)


class Fall(Still):
    """PULSE falls once, driven by a level."""

    def __init__(self, ps: int) -> None:
        self.ps = ps

    def by(self, ps: int) -> int:
        return int(ps >= self.ps)

    def at(self, k: int) -> int | None:
        return self.ps if k == 1 else None


class Falls:
    """The falls of PULSE under a promise that follows a train."""

    def __init__(self, view: SquareView | PulseView | StrobeView) -> None:
        self.view, self.of = view, view.of

    def by(self, ps: int) -> int:
        return self.of.begun(ps)

    def at(self, k: int) -> int | None:
        train = self.of.train
        if k > train.steps:
            return None
        time = train.clock.ps(train.begin(k - 1))
        return time if self.of.until is None or time < self.of.until else None

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        return self.of.train.begins(first - 1, last)


class Ended:
    """A drive as far as it has come at an instant."""

    def __init__(self, drive: Drive, end: int) -> None:
        self.drive, self.end = drive, end

    def by(self, ps: int) -> int:
        return self.drive.by(min(ps, self.end))

    def at(self, k: int) -> int | None:
        return self.drive.at(k) if k <= self.drive.by(self.end) else None

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        return self.drive.many(first, last)


class Rotation:
    """A shaft that another machine turns evenly, a step being a count."""

    def __init__(self, since: int, rate: int) -> None:
        self.since, self.clock = since, Clock(rate)

    def by(self, ps: int) -> int:
        return self.clock.ticks_until(ps - self.since)

    def at(self, k: int) -> int | None:
        return self.since + self.clock.ps(k)

    def many(self, first: int, last: int) -> NDArray[np.int64]:
        import numpy as np

        return self.since + self.clock.ps_array(np.arange(first, last + 1))


# ------------------------------------------------------------------------------------------------------- the course
@dataclass(slots=True)
class Course:
    """How a shaft turns from an instant on, and what its outputs show.

    From `since` on the shaft follows `drive`, the way `sign` says, once the motor has taken up `slack` parts of a
    count.  Outputs show what the shaft did `lag_ps` before: `coming` are the changes (instants, counts) that were on
    their way at `since`, when the count was `before`.  The first change of this course ends them.
    """

    counts: int  # parts of a count that a step moves the shaft by
    steps: int  # parts in a count
    lag_ps: int
    drive: Drive
    since: int = 0
    sign: int = 1
    place: int = 0
    slack: int = 0
    before: int = 0
    coming: tuple[list[int], list[int]] = ([], [])
    first: int = field(init=False)  # steps of the drive that were before this course
    count: int = field(init=False)  # when everything that was coming is through
    reach: int = field(init=False)  # parts from the count before to the place, less the slack
    _recent: tuple[int, int, int, Shown] | None = field(init=False, default=None)  # A and B ask for the same windows

    def __post_init__(self) -> None:
        self.count, part = divmod(self.place, self.steps)
        self.first = self.drive.by(self.since)
        self.reach = (part if self.sign > 0 else self.steps - 1 - part) - self.slack

    # ---------------------------------------------------------------------------- changes of this course, from 1 on
    def _changes(self, k: int) -> int:
        """How many changes the first k steps of this course make."""
        return max(0, (k * self.counts + self.reach) // self.steps)

    def _step(self, j: int) -> int:
        """The step of this course that makes change j."""
        return -((self.reach - j * self.steps) // self.counts)

    def _due(self, j: int) -> int | None:
        """When the outputs show change j; None: never, as things stand."""
        k = self._step(j)
        ps = self.drive.at(self.first + k)
        if ps is None:
            return None
        if self.counts > self.steps and (late := j - 1 - self._changes(k - 1)):
            following = self.drive.at(self.first + k + 1)  # takes the shaft further at once
            ps += late * DWELL_PS
            ps = ps if following is None else min(ps, following)
        return ps + self.lag_ps

    def _shown(self, ps: int) -> int:
        """How many changes of this course the outputs show at an instant."""
        ps -= self.lag_ps
        k = self.drive.by(ps) - self.first
        if k <= 0:
            return 0
        over = self._changes(k)
        if self.counts > self.steps:  # the last step may be under way
            begun = self.drive.at(self.first + k)
            assert begun is not None
            over = min(over, self._changes(k - 1) + 1 + (ps - begun) // DWELL_PS)
        return over

    # ------------------------------------------------------------------------------------------------------- questions
    def at(self, ps: int) -> int:
        """The count that the outputs show at an instant."""
        return self._after_changes(self._shown(ps), ps)

    def _after_changes(self, j: int, ps: int) -> int:
        """The count after j changes of this course, at an instant."""
        if j:
            return self.count + self.sign * j
        times, counts = self.coming
        over = bisect_right(times, ps)
        return counts[over - 1] if over else self.before

    def after(self, ps: int) -> int | None:
        """When the count that is shown changes next, after an instant."""
        j = self._shown(ps)
        due = self._due(j + 1)
        times = self.coming[0]
        over = bisect_right(times, ps)
        if j or over == len(times) or (due is not None and due <= times[over]):
            return due
        return times[over]

    def between(self, start: int, stop: int) -> Shown:
        """What the outputs have shown at start < t <= stop, the last committed instant at most.

        Returns:
            The count before, the instants of its changes, ascending, and the counts from there on: two lists, or two
            int64 arrays.
        """
        recent = self._recent
        if recent is not None and recent[:2] == (start, stop):
            return recent[3]
        a, b = recent[2] if recent is not None and recent[1] == start else self._shown(start), self._shown(stop)
        times, counts = self._own(a, b)
        held, shown = self.coming
        if not a and held:
            part = slice(bisect_right(held, start), bisect_right(held, int(times[0]) if b else stop))
            times, counts = _joined(held[part], times), _joined(shown[part], counts)
        found = self._after_changes(a, start), times, counts
        self._recent = start, stop, b, found
        return found

    def _own(self, a: int, b: int) -> tuple[Any, Any]:
        """Changes a+1 ... b of this course, all of which come: instants, and the counts from there on."""
        if b - a <= MANY:
            numbers = range(a + 1, b + 1)
            return [self._due(j) for j in numbers], [self.count + self.sign * j for j in numbers]
        import numpy as np

        n, first, last = np.arange(b - a), self._step(a + 1), self._step(b)
        k = -((self.reach - (a + 1) * self.steps + first * self.counts - n * self.steps) // self.counts)  # from first
        falls = self.drive.many(self.first + first, self.first + last)
        times = falls[k]
        if self.counts > self.steps:
            begins = np.searchsorted(k, k)
            late = n - begins + np.where(begins, 0, a - self._changes(first - 1))
            following = np.append(falls[1:], np.iinfo(np.int64).max)  # behind the last one nothing has come yet
            times = np.minimum(times + late * DWELL_PS, following[k])
        return times + self.lag_ps, self.count + self.sign * (a + 1 + n)

    # ------------------------------------------------------------------------------------------------ from here on
    def onward(self, ps: int) -> Course:
        """The same from an instant on; what the drive does afterwards may still change."""
        k = self.drive.by(ps) - self.first
        moved = max(0, k * self.counts - self.slack)
        past = replace(self, drive=Ended(self.drive, ps))
        _, times, counts = past.between(ps, ps + self.lag_ps + DWELL_PS * self.counts // self.steps + DWELL_PS)
        return replace(
            self, since=ps, place=self.place + self.sign * moved, slack=max(0, self.slack - k * self.counts),
            before=self.at(ps), coming=([int(time) for time in times], [int(count) for count in counts]),
        )  # fmt: skip

    def pushed(self, way: int, now: int) -> Course:
        """The same, turned by a count, forward (1) or back (-1), at the instant from which this course is."""
        times, counts = self.coming
        due = now + self.lag_ps
        over = bisect_right(times, due)
        here = counts[over - 1] if over else self.before
        later = [here + way, *(count + way for count in counts[over:])]
        return replace(
            self,
            place=self.place + way * self.steps,
            coming=([*times[:over], due, *times[over:]], counts[:over] + later),
        )


class Channel:
    """An output of an encoder, as a promise: its level goes with the count."""

    __slots__ = ("course", "levels")
    until: int | None = None  # what a course assumes holds until the shaft takes up another

    def __init__(self, course: Course, levels: tuple[int, ...]) -> None:
        self.course, self.levels = course, levels

    def level(self, ps: int) -> int:
        return self.levels[self.course.at(ps) % 4]

    def after(self, ps: int) -> int | None:
        """The next edge, or where to look for it: the counts of a shaft that is too fast may jump for ever."""
        here, time = self.level(ps), self.course.after(ps)
        for _ in self.levels:
            if time is None or self.level(time) != here:
                break
            time = self.course.after(time)
        return time

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Edges at start < t <= stop: two lists, or two arrays (int64 ps, int8 levels)."""
        before, times, counts = self.course.between(start, stop)
        level = self.levels[before % 4]
        if not isinstance(times, list):
            return self._edges_many(times, counts, level)
        shown = {
            time: self.levels[count % 4] for time, count in zip(times, counts, strict=True)
        }  # the last in an instant
        real_times, real_levels = [], []
        for time, now in shown.items():
            if now != level:
                level = now
                real_times.append(time)
                real_levels.append(now)
        return real_times, real_levels

    def _edges_many(self, times: Any, counts: Any, before: int) -> tuple[Any, Any]:
        import numpy as np

        last = np.append(times[1:] != times[:-1], True)  # in an instant
        times, levels = times[last], np.array(self.levels, np.int8)[counts[last] % 4]
        real = levels != np.append(np.int8(before), levels[:-1])
        return times[real], levels[real]


def _joined(few: list[int], more: Any) -> Any:
    """Two lists as one, or a list and an array."""
    if isinstance(more, list):
        return few + more
    import numpy as np

    return np.concatenate((np.array(few, np.int64), more))
