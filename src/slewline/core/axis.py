"""Where a motor is: the position register of one axis, exact at every instant, and its whole past.

The past is a list of stretches, each following one train; undisturbed travel of any length is one stretch.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING

from ..errors import UsageError
from .kernel import Kernel
from .motions import Mark, Motions, MotionStart, Parameters
from .plan import Plan
from .train import Playing, Train

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["Axis", "Mark", "MotionStart", "Parameters", "Steps", "Stretch"]


@dataclass(frozen=True)
class Steps:
    """Steps of a chip: instants (n,) int64 ps, directions (n,) int8 +1/-1, positions after each step (n,) int64."""

    times_ps: NDArray[np.int64]
    directions: NDArray[np.int8]
    positions: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.times_ps)


@dataclass(slots=True)
class Stretch:
    """A stretch of travel: from an instant on, `playing` moves the axis by `sign` a step, starting from `travel`.

    `count` is `travel` without those steps that the position register did not count; it counts `counts` a step.  A
    train that plays a plan from one of its steps on tells of both.
    """

    start: int
    travel: int
    count: int
    sign: int
    counts: int
    playing: Playing | None
    plan: Plan | None = None
    step: int = 0

    def phases(self) -> Iterator[tuple[int, int, str]]:
        """Yield the legs of the plan that are played: begin and end in ps, and the name."""
        if self.playing is None or self.plan is None:
            return
        train, until = self.playing.train, self.playing.until
        for leg in self.plan.legs:
            begin, end = (train.clock.ps(train.begin(max(k - self.step, 0))) for k in (leg.first, leg.end))
            if until is not None:
                end = min(end, until)
            if begin < end:
                yield begin, end, leg.name


_start = attrgetter("start")


class Axis:
    """Position of one motor: exact at every instant, through the bounded promise, and its whole past.

    `travel` counts steps without wrap-around; `position` is the register, which holds one of `positions` and wraps.
    A motion may leave the register alone.
    """

    def __init__(self, kernel: Kernel, positions: range, position: int) -> None:
        self.kernel, self.positions = kernel, positions
        self.modulus, self.low = len(positions), positions[0]
        self.offset = position - self.low  # position - low = offset + counted, modulo
        self.past = [Stretch(0, 0, 0, 1, 1, None)]
        self.offsets = [(0, self.offset)]
        self.watchers: list[Callable[[], object]] = []  # called when a plan or the register changes
        self.forgetters: list[Callable[[int], object]] = []  # called when the past before an instant is dropped
        self.log = Motions(kernel)  # what a chip tells of its motions

    @property
    def travel(self) -> int:
        """Steps clockwise minus steps counter-clockwise, at the last committed instant."""
        now = self.past[-1]
        return now.travel + (now.sign * now.playing.begun(self.kernel.seen) if now.playing is not None else 0)

    @property
    def counted(self) -> int:
        """The same, of those steps that the position register counts."""
        now = self.past[-1]
        return now.count + (now.counts * now.playing.begun(self.kernel.seen) if now.playing is not None else 0)

    @property
    def position(self) -> int:
        """The position register at the last committed instant."""
        return self.low + (self.offset + self.counted) % self.modulus

    @property
    def moving(self) -> bool:
        """Does the present promise have steps to come?"""
        now = self.past[-1].playing
        return now is not None and now.begun(1 << 80) > now.begun(self.kernel.seen)

    def load(self, position: int) -> None:
        """Declare the present position."""
        self.offset = (position - self.low - self.counted) % self.modulus
        if self.offsets[-1][0] == self.kernel.now:
            self.offsets[-1] = (self.kernel.now, self.offset)
        else:
            self.offsets.append((self.kernel.now, self.offset))
        for watcher in self.watchers:
            watcher()

    def follow(
        self, playing: Playing | None, sign: int, counted: bool = True, plan: Plan | None = None, step: int = 0
    ) -> None:
        """From this instant on, the axis follows a train; what was played before stays as it is.

        Args:
            counted: false: the position register does not count these steps.
            plan, step: what the train plays, and the step of it that is the first of the train.
        """
        counts = sign if counted else 0
        self.past.append(Stretch(self.kernel.now, self.travel, self.counted, sign, counts, playing, plan, step))
        for watcher in self.watchers:
            watcher()

    def arrives(self, position: int) -> int | None:
        """When the present promise reaches a position; None if it does not."""
        time, playing = self.would_arrive(position), self.past[-1].playing
        if time is None or playing is None or (playing.until is not None and time >= playing.until):
            return None
        return time

    def would_arrive(self, position: int) -> int | None:
        """When the present train reaches a position if nothing interferes; None if it does not."""
        now = self.past[-1]
        if now.playing is None or not now.counts:
            return None
        train = now.playing.train
        begun = now.playing.begun(self.kernel.seen)
        missing = (position - self.position) * now.sign % self.modulus or self.modulus
        step = begun + missing - 1
        return train.clock.ps(train.begin(step)) if step < train.steps else None

    def forget(self, before: int) -> None:
        """Drop the past before an instant."""
        keep = next((i for i in range(len(self.past) - 1, 0, -1) if self.past[i].start <= before), 0)
        del self.past[:keep]
        in_force = bisect_right(self.offsets, self.past[0].start, key=itemgetter(0)) - 1
        del self.offsets[: max(in_force, 0)]
        self.log.forget(before)
        for forgetter in self.forgetters:
            forgetter(before)

    def motions(self, start: int, stop: int) -> list[MotionStart]:
        """Return the motions that begin at start <= t <= stop, in ps."""
        return self.log.starts(start, stop)

    def marks(self, start: int, stop: int) -> list[Mark]:
        """Return what has happened to the axis at start <= t <= stop, in ps, besides motions that begin."""
        return self.log.marks(start, stop)

    def phases(self, start: int, stop: int) -> list[tuple[int, int, str]]:
        """Return the legs of plans that are played between two instants, as far as they lie there: begin and end in
        ps, and the name; neighbours of one name are one."""
        found: list[tuple[int, int, str]] = []
        first = max(bisect_left(self.past, start, key=_start) - 1, 0)
        for stretch in self.past[first : bisect_right(self.past, stop, key=_start)]:
            for begin, end, name in stretch.phases():
                if begin >= stop or end <= start:
                    continue
                if found and found[-1][1:] == (max(begin, start), name):
                    begin = found.pop()[0]
                found.append((max(begin, start), min(end, stop), name))
        return found

    def _played(self, start: int, stop: int) -> Iterator[tuple[Stretch, Train, int, int]]:
        """Stretches with steps at start <= t <= stop, and which steps of their trains these are: a ... b-1."""
        first = max(bisect_left(self.past, start, key=_start) - 1, 0)
        for stretch in self.past[first : bisect_right(self.past, stop, key=_start)]:
            if stretch.playing is not None:
                train = stretch.playing.train
                a, b = train.begun(start - 1), train.begun(stretch.playing.bounded(stop))
                if b > a:
                    yield stretch, train, a, b

    def count(self, start: int, stop: int) -> int:
        """How many steps there are at start <= t <= stop."""
        return sum(b - a for _, _, a, b in self._played(start, stop))

    def span(self, start: int, stop: int) -> tuple[int, int] | None:
        """The first and the last step at start <= t <= stop, in ps; None: there is none."""
        played = [(train, a, b - 1) for _, train, a, b in self._played(start, stop)]
        if not played:
            return None
        (one, first, _), (other, _, last) = played[0], played[-1]
        return one.clock.ps(one.begin(first)), other.clock.ps(other.begin(last))

    def times(self, start: int, stop: int, out: NDArray[np.int64] | None = None) -> NDArray[np.int64]:
        """Instants of the steps at start <= t <= stop: (n,) int64, ps.

        Args:
            out: a buffer of that length or longer; its beginning is the answer.
        """
        import numpy as np

        played = list(self._played(start, stop))
        count = sum(b - a for _, _, a, b in played)
        out = np.empty(count, np.int64) if out is None else out[:count]
        at = 0
        for _, train, a, b in played:
            train.begins(a, b, out[at:])
            at += b - a
        return out

    def steps(self, start: int, stop: int) -> Steps:
        """Steps at start <= t <= stop."""
        import numpy as np

        times = self.times(start, stop)
        directions, positions = np.empty(len(times), np.int8), np.empty(len(times), np.int64)
        at = 0
        for stretch, _, a, b in self._played(start, stop):
            directions[at : at + b - a] = stretch.sign
            positions[at : at + b - a] = stretch.count + stretch.counts * np.arange(a + 1, b + 1)
            at += b - a
        since, offsets = zip(*self.offsets, strict=True)
        positions += np.repeat(offsets, np.diff(np.searchsorted(times, since), append=len(times)))
        positions %= self.modulus
        positions += self.low
        return Steps(times, directions, positions)

    def _offsets_at(self, times: NDArray[np.int64]) -> NDArray[np.int64]:
        import numpy as np

        since = np.array([since for since, _ in self.offsets], np.int64)
        values = np.array([value for _, value in self.offsets], np.int64)
        return values[np.maximum(np.searchsorted(since, times, side="right") - 1, 0)]

    def position_at(self, ps: int) -> int:
        """The position register at one instant of the past."""
        stretch = self.past[max(bisect_right(self.past, ps, key=_start) - 1, 0)]
        count = stretch.count + (stretch.counts * stretch.playing.begun(ps) if stretch.playing is not None else 0)
        since = max(bisect_right(self.offsets, ps, key=lambda offset: offset[0]) - 1, 0)
        return self.low + (self.offsets[since][1] + count) % self.modulus

    def _instants(self, times: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        import numpy as np

        at = np.asarray(times)
        if at.dtype.kind not in "iu" or (at.size and int(at.max()) > self.kernel.now):
            raise UsageError(
                f"instants of the past are int64 picoseconds up to {self.kernel.now}, not {at.dtype} or later ones"
            )
        return at

    def positions_at(self, times: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        """The position register at many instants of the past: (n,) int64, shape as `times`."""
        import numpy as np

        at = self._instants(times)
        starts = np.array([stretch.start for stretch in self.past], np.int64)
        which = np.maximum(np.searchsorted(starts, at, side="right") - 1, 0)
        out = np.empty(at.shape, np.int64)
        for index in np.unique(which):
            stretch, chosen = self.past[index], which == index
            out[chosen] = stretch.count
            if stretch.playing is not None:
                out[chosen] += stretch.counts * stretch.playing.begun_many(at[chosen])
        return self.low + (out + self._offsets_at(at)) % self.modulus

    # -------------------------------------------------------------------------------------------------------- velocity
    def _driven(self, start: int, stop: int) -> list[tuple[int, int, Stretch, Playing]]:
        """What says the velocity at start <= t <= stop: from which instant to before which one, and the stretch.

        A step in progress lasts until its end, or until the next train moves the axis.
        """
        found: list[tuple[int, int, Stretch, Playing]] = []
        end = stop + 1
        for stretch in reversed(self.past[: bisect_right(self.past, stop, key=_start)]):
            playing = stretch.playing
            if playing is not None and (moves := playing.moves) is not None and moves < end:
                found.append((max(moves, start), end, stretch, playing))
                end = moves
                if moves <= start:
                    break
        return found[::-1]

    def velocities(self, start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Velocity at start <= t <= stop (ps).

        Returns:
            Instants of every change (n,) int64 ps, ascending, the first is `start`; steps/s (n,) float64 from each to
            the next.
        """
        import numpy as np

        at, what = [np.array([start])], [np.zeros(1)]
        for since, end, stretch, playing in self._driven(start, stop):
            times, speeds = playing.velocities(since, end - 1)
            at.append(times)
            what.append(stretch.sign * speeds + 0.0)  # rest is no negative zero
        times, speeds = np.concatenate(at), np.concatenate(what)
        last = np.append(times[1:] != times[:-1], True)  # of what begins in one instant
        times, speeds = times[last], speeds[last]
        changed = np.append(True, speeds[1:] != speeds[:-1])
        return times[changed], speeds[changed]

    def velocity_at(self, ps: int) -> float:
        """Velocity at one instant of the past, steps/s."""
        return float(self.velocities(ps, ps)[1][-1])

    def velocities_at(self, times: Sequence[int] | NDArray[np.int64]) -> NDArray[np.float64]:
        """Velocity at many instants of the past: float64 steps/s, shape as `times`."""
        import numpy as np

        at = self._instants(times)
        if not at.size:
            return np.empty(at.shape)
        changes, speeds = self.velocities(int(at.min()), int(at.max()))
        return speeds[np.searchsorted(changes, at, side="right") - 1]
