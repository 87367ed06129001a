"""The position register of one axis, which is exact at every instant, and its entire past.

The past is a list of stretches, each of which follows one step train (train.py); undisturbed travel of
any length is one stretch.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter, itemgetter
from typing import TYPE_CHECKING, NamedTuple, cast, overload

from ...errors import NoSuchStep, UsageError
from ..messages.former_names import formerly
from ..messages.instead import missing
from ..messages.whole import whole
from ..time.hook import Hook
from ..time.kernel import Kernel
from ..time.timebase import readable
from .kept import Kept
from .motions import Mark, Motions, MotionStart
from .plan import Plan
from .train import FEW, Playing, Train

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Step(NamedTuple):
    """One step.

    Attributes:
        time_ps: the instant at which the step begins, ps.
        direction: +1 clockwise, -1 counter-clockwise.
        position: the position register after the step.
    """

    time_ps: int
    direction: int
    position: int


@dataclass(frozen=True, eq=False)
class Steps:
    """The steps of an axis, in chronological order; `steps[0]` is a `Step`, `steps[:10]` are the first ten.

    Attributes:
        times_ps: the instant at which each step begins, (n,) int64 ps, ascending.
        directions: the direction of each step, (n,) int8, +1 clockwise, -1 counter-clockwise.
        positions: the position register after each step, (n,) int64.
    """

    times_ps: NDArray[np.int64]
    directions: NDArray[np.int8]
    positions: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.times_ps)

    @overload
    def __getitem__(self, which: int) -> Step: ...
    @overload
    def __getitem__(self, which: slice) -> Steps: ...
    def __getitem__(self, which: int | slice) -> Step | Steps:
        if not isinstance(which, slice):
            return self._step(which)
        return Steps(self.times_ps[which], self.directions[which], self.positions[which])

    def _step(self, which: int) -> Step:
        count = len(self)
        if whole(which) is None:
            raise UsageError(
                f"steps[{which!r}]: expected a whole number, or a slice such as [:10]; arrays are steps.times_ps, "
                "steps.directions and steps.positions"
            )
        if not -count <= which < count:
            message = f"allowed 0..{count - 1}, and -1 for the last" if count else "there are no steps"
            raise NoSuchStep(f"steps[{which}]: {message}")
        return Step(int(self.times_ps[which]), int(self.directions[which]), int(self.positions[which]))

    __hash__ = None  # type: ignore[assignment]  # arrays can change

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Steps):
            return NotImplemented
        names = ("times_ps", "directions", "positions")
        return all(getattr(self, name).tolist() == getattr(other, name).tolist() for name in names)

    def __repr__(self) -> str:
        if not len(self):
            return "<Steps: none>"
        first, last = self[0], self[-1]
        between = (
            f"{readable(first.time_ps)} to {readable(last.time_ps)}, positions {first.position} to {last.position}"
        )
        return f"<Steps: {len(self)}, {between}>"

    def _repr_html_(self) -> str:
        """Return the notebook view of the steps: the first and the last steps, and a thumbnail of the positions."""
        from ..notebook.steps_card import steps_card

        return steps_card(repr(self)[1:-1], self.times_ps, self.directions, self.positions)


missing(
    Steps,
    **dict.fromkeys(("time", "times", "times_s"), "{it}.times_ps"),
    **dict.fromkeys(("direction", "signs"), "{it}.directions"),
    position="{it}.positions",
    **dict.fromkeys(("count", "number", "size"), "len({it})"),
)


@dataclass(slots=True)
class Segment:
    """A stretch of travel, during which the axis follows one train or is at rest.

    Attributes:
        start: the instant at which the stretch begins, ps.
        travel: the net number of steps of the axis at `start`.
        count: the net number of those steps that the position register has counted.
        sign: the change of `travel` with each step of the train: 1 or -1.
        counts: the change of `count` with each step of the train; 0 if the register does not count them.
        playing: the train; None at rest.
        plan: the plan that the train plays; None if it plays none.
        step: the step of the plan, counted from 0, with which the train starts.
        halted: the instant at which the motion was cut off, even within a step, ps; None if it was not.
    """

    start: int
    travel: int
    count: int
    sign: int
    counts: int
    playing: Playing | None
    plan: Plan | None = None
    step: int = 0
    halted: int | None = None

    def phases(self) -> Iterator[tuple[int, int, str]]:
        """Yield the start (ps), end (ps) and name of each leg of the plan that the train plays, if it plays one."""
        if self.playing is None or self.plan is None:
            return
        train, until = self.playing.train, self.playing.until
        for leg in self.plan.legs:
            begin, end = (train.clock.ps(train.end(max(k - self.step, 0))) for k in (leg.first, leg.end))
            if until is not None:
                end = min(end, until)
            if begin < end:
                yield begin, end, leg.name


_start = attrgetter("start")


@formerly(where="stands")
class Axis:
    """The position of one motor, exact at every instant: past, present and, if its train is promised, future.

    `travel` counts steps without wrap-around; `position` is the register, which wraps within `positions`.
    There are motions, such as homing, whose steps the register does not count.

    Args:
        kernel: the kernel, which has the virtual time.
        positions: the values that the position register can hold.
        position: the value of the position register at time 0.

    Attributes:
        on_change: hook, called without arguments when the axis follows another train, or the register is
            loaded.
        on_forget: hook, called with the instant (ps) before which the past is dropped.
        log: the motions and marks of the axis, as the chip reports them.
    """

    def __init__(self, kernel: Kernel, positions: range, position: int) -> None:
        self.kernel, self.positions = kernel, positions
        self.modulus, self.low = len(positions), positions[0]
        self.offset = position - self.low  # position - low = offset + counted, modulo
        self.past = [Segment(0, 0, 0, 1, 1, None)]
        self.offsets = [(0, self.offset)]
        self.on_change: Hook[[]] = Hook()  # another train is followed, or the register was loaded
        self.on_forget: Hook[[int]] = Hook()  # the past before an instant is dropped
        self.kept = Kept()
        self.forgotten = 0  # steps of the dropped past
        self.homing = 0  # the outward direction of the homing run in progress; 0 if none
        self.sought: tuple[str, int] | None = None  # the pin that ends its current phase, and how
        self.log = Motions(kernel, self.where, self.halt)  # the motions that a chip reports

    def __repr__(self) -> str:
        return f"<Axis: position {self.position}, {'in motion' if self.moving else 'at rest'}>"

    @property
    def travel(self) -> int:
        """The net number of steps, clockwise positive, from time 0 to `kernel.seen`; it does not wrap."""
        now = self.past[-1]
        return now.travel + (now.sign * now.playing.count(self.kernel.seen) if now.playing is not None else 0)

    @property
    def counted(self) -> int:
        """The net number of steps counted by the position register since time 0; homing steps do not count."""
        now = self.past[-1]
        return now.count + (now.counts * now.playing.count(self.kernel.seen) if now.playing is not None else 0)

    @property
    def position(self) -> int:
        """The position register at `kernel.seen`, the last instant whose changes are visible."""
        return self.low + (self.offset + self.counted) % self.modulus

    @property
    def moving(self) -> bool:
        """True while the train that the axis follows has steps left."""
        now = self.past[-1].playing
        return now is not None and now.count(1 << 80) > now.count(self.kernel.seen)

    def load(self, position: int) -> None:
        """Set the position register now; the motor does not move.

        Args:
            position: the new value; a value outside `positions` wraps around into this range.
        """
        self.offset = (position - self.low - self.counted) % self.modulus
        if self.offsets[-1][0] == self.kernel.now:
            self.offsets[-1] = (self.kernel.now, self.offset)
        else:
            self.offsets.append((self.kernel.now, self.offset))
        if self.on_change.listeners:
            self.on_change()

    def follow(
        self, playing: Playing | None, sign: int, counted: bool = True, plan: Plan | None = None, step: int = 0
    ) -> None:
        """Follow a train from now on; the past is unchanged.

        Args:
            playing: the train, with the instant before which it is valid; None if the motor is at rest.
            sign: 1 clockwise, -1 counter-clockwise.
            counted: True if the position register counts the steps of the train.
            plan: the plan that the train plays.
            step: the step of the plan, counted from 0, with which the train starts.
        """
        now, counts = self.past[-1], sign if counted else 0
        begun = now.playing.count(self.kernel.seen) if now.playing is not None else 0
        travel, count = now.travel + now.sign * begun, now.count + now.counts * begun
        self.past.append(Segment(self.kernel.now, travel, count, sign, counts, playing, plan, step))
        if len(self.past) > self.kept.full and self.kept.everything:
            self.kept.warn()
        elif len(self.past) > self.kept.full:
            self.forget(self.kept.bound(self.past, self.kernel.now))
            self.kept.dropped(len(self.past))
        if self.on_change.listeners:
            self.on_change()

    def where(self) -> tuple[int, int]:
        """Return the position register and the travel now, including a step that begins at this instant."""
        now, stretch = self.kernel.now, self.past[-1]
        begun = stretch.playing.count(now) if stretch.playing is not None else 0
        position = self.low + (self.offset + stretch.count + stretch.counts * begun) % self.modulus
        return position, stretch.travel + stretch.sign * begun

    def halt(self) -> None:
        """Cut off the step in progress, if any; the motor is at rest from this instant."""
        if self.past[-1].halted is None:
            self.past[-1].halted = self.kernel.now

    def arrives(self, position: int) -> int | None:
        """Return the instant (ps) at which the present train will bring the position register to a value.

        It is None if the train does not reach this value, or reaches it only after the train's promise ends.
        """
        time, playing = self.would_arrive(position), self.past[-1].playing
        if time is None or playing is None or (playing.until is not None and time >= playing.until):
            return None
        return time

    def would_arrive(self, position: int) -> int | None:
        """Return the instant (ps) at which the present train, if uninterrupted, will next reach a position.

        It is None if the train does not bring the position register to this value.
        """
        now = self.past[-1]
        if now.playing is None or not now.counts:
            return None
        train = now.playing.train
        begun = now.playing.count(self.kernel.seen)
        missing = (position - self.position) * now.sign % self.modulus or self.modulus
        step = begun + missing - 1
        return train.clock.ps(train.end(step)) if step < train.steps else None

    @property
    def since(self) -> int:
        """The earliest instant of the past that is still kept, ps."""
        first = self.past[0].start
        return first if self.kept.ps is None else max(first, self.kernel.seen - self.kept.ps)

    def check_kept(self, start: int) -> None:
        """Check that the past is kept back to an instant (ps).

        Raises:
            NotRecorded: the past is not kept that far back.
        """
        if start < self.since:
            raise self.kept.refusal(start, self.since)

    @property
    def made(self) -> int:
        """The number of steps that the motor has made since time 0."""
        return self.forgotten + self.count(self.past[0].start, self.kernel.now)

    def forget(self, before: int) -> None:
        """Drop the past before an instant (ps), except the stretch in progress at that instant."""
        keep = next((i for i in range(len(self.past) - 1, 0, -1) if self.past[i].start <= before), 0)
        if keep:
            self.forgotten += self.count(self.past[0].start, self.past[keep].start - 1)
        del self.past[:keep]
        in_force = bisect_right(self.offsets, self.past[0].start, key=itemgetter(0)) - 1
        del self.offsets[: max(in_force, 0)]
        self.log.forget(before)
        self.on_forget(before)

    def motions(self, start: int, stop: int) -> list[MotionStart]:
        """Return the motions that begin in start <= t <= stop (ps)."""
        self.check_kept(start)
        return self.log.starts(start, stop)

    def marks(self, start: int, stop: int) -> list[Mark]:
        """Return the events of the axis in start <= t <= stop (ps), other than starts and ends of motions."""
        self.check_kept(start)
        return self.log.marks(start, stop)

    def phases(self, start: int, stop: int) -> list[tuple[int, int, str]]:
        """Return the legs of plans that are played between two instants (ps), cut off at both.

        Returns:
            For each leg: its start and end, ps, and its name; adjacent legs with the same name are joined.
        """
        self.check_kept(start)
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

    def played(self, start: int, stop: int) -> Iterator[tuple[Segment, Train, int, int]]:
        """Yield (stretch, train, a, b) for each stretch with steps that begin in start <= t <= stop (ps).

        The steps that begin in this window are steps a ... b-1 of the train, counted from 0.
        """
        first = max(bisect_left(self.past, start, key=_start) - 1, 0)
        for stretch in self.past[first : bisect_right(self.past, stop, key=_start)]:
            if stretch.playing is not None:
                train = stretch.playing.train
                a, b = train.count(start - 1), stretch.playing.count(stop)
                if b > a:
                    yield stretch, train, a, b

    def count(self, start: int, stop: int) -> int:
        """Return the number of steps that begin in start <= t <= stop (ps)."""
        return sum(b - a for _, _, a, b in self.played(start, stop))

    def times(self, start: int, stop: int, out: NDArray[np.int64] | None = None) -> NDArray[np.int64]:
        """Return the instants in start <= t <= stop at which steps begin: (n,) int64 ps, ascending.

        Args:
            start, stop: the window, ps.
            out: an int64 buffer for the result, with n elements or more; the filled part is returned.
        """
        import numpy as np

        played = list(self.played(start, stop))
        count = sum(b - a for _, _, a, b in played)
        out = np.empty(count, np.int64) if out is None else out[:count]
        at = 0
        for _, train, a, b in played:
            train.times(a + 1, b, out[at:])
            at += b - a
        return out

    def steps(self, start: int, stop: int) -> Steps:
        """Return the steps that begin in start <= t <= stop (ps)."""
        import numpy as np

        self.check_kept(start)
        times = self.times(start, stop)
        directions, positions = np.empty(len(times), np.int8), np.empty(len(times), np.int64)
        at = 0
        for stretch, _, a, b in self.played(start, stop):
            directions[at : at + b - a] = stretch.sign
            positions[at : at + b - a] = stretch.count + stretch.counts * np.arange(a + 1, b + 1)
            at += b - a
        since, offsets = zip(*self.offsets, strict=True)
        positions += np.repeat(offsets, np.diff(np.searchsorted(times, since), append=len(times)))
        positions %= self.modulus
        positions += self.low
        return Steps(times, directions, positions)

    def position_at(self, ps: int) -> int:
        """Return the position register at one past instant (ps)."""
        number = bisect_right(self.past, ps, key=_start)
        if not number or self.kept.ps is not None:  # otherwise the step is kept
            self.check_kept(ps)
        stretch = self.past[number - 1]
        playing = stretch.playing
        count = stretch.count + (stretch.counts * playing.count(ps) if playing is not None else 0)
        since = max(bisect_right(self.offsets, ps, key=itemgetter(0)) - 1, 0)
        return self.low + (self.offsets[since][1] + count) % self.modulus

    def _instants(self, times: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        import numpy as np

        at = np.asarray(times)
        if at.dtype.kind not in "iu" or (at.size and int(at.max()) > self.kernel.now):
            found = int(at.max()) if at.dtype.kind in "iu" else at.dtype
            raise UsageError(f"expected past instants, whole picoseconds up to {self.kernel.now}; found {found}")
        if self.since and at.size:
            self.check_kept(int(at.min()))
        return at

    def positions_at(self, times: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the position register at many past instants (int64 ps): int64, same shape as `times`."""
        return self.low + self.unwrapped_at(times) % self.modulus

    def unwrapped_at(self, times: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the position without wrap-around, minus the register's minimum, at many past instants (int64 ps).

        The result is int64, of the same shape as `times`.
        """
        import numpy as np

        at = self._instants(times)
        ends = (int(at.min()), int(at.max())) if at.size else (0, 0)
        first, last = (max(bisect_right(self.past, ps, key=_start) - 1, 0) for ps in ends)
        order = np.argsort(at, axis=None, kind="stable") if last > first else slice(None)
        instants = at.ravel()[order]
        since, offsets = np.array(self.offsets, np.int64).T
        found = offsets[np.maximum(np.searchsorted(since, instants, side="right") - 1, 0)]
        few = instants.tolist() if at.size < FEW * (last - first) else None  # one stretch at a time: arrays cost more
        for number, group in _groups(instants, [stretch.start for stretch in self.past[first : last + 1]]):
            stretch = self.past[first + number]
            playing, count, counts = stretch.playing, stretch.count, stretch.counts
            if playing is None or not counts:
                found[group] += count
            elif few is not None:
                found[group] += [count + counts * playing.count(ps) for ps in few[group]]
            else:
                found[group] += count + counts * playing.count_many(instants[group])
        out = np.empty(at.size, np.int64)
        out[order] = found
        return out.reshape(at.shape)

    def turns(self, start: int, stop: int) -> list[int]:
        """Return the instants in start <= t <= stop (ps) at which a new train begins, or the register is loaded.

        Between two consecutive instants the register only rises, or only falls, apart from wrap-around.
        """
        first, last = bisect_left(self.past, start, key=_start), bisect_right(self.past, stop, key=_start)
        loads = {since for since, _ in self.offsets if start <= since <= stop}
        return sorted(loads.union(stretch.start for stretch in self.past[first:last]))

    def loads(self, start: int, stop: int) -> list[int]:
        """Return the instants in start < t <= stop (ps) at which the register was loaded."""
        return [since for since, _ in self.offsets[1:] if start < since <= stop]

    def reached(self, unwrapped: int, ps: int) -> int:
        """Return the instant (ps) at which the train in progress at `ps` brings the register to a value.

        `unwrapped` is this value, in the form that `unwrapped_at` returns; the train must take at least one
        counted step to reach it.
        """
        stretch = self.past[max(bisect_right(self.past, ps, key=_start) - 1, 0)]
        offset = self.offsets[max(bisect_right(self.offsets, ps, key=itemgetter(0)) - 1, 0)][1]
        train = cast("Playing", stretch.playing).train
        return train.clock.ps(train.end((unwrapped - offset - stretch.count) * stretch.counts - 1))

    # -------------------------------------------------------------------------------------------------------- velocity
    def driven(self, start: int, stop: int) -> list[tuple[int, int, int, Playing]]:
        """Return the trains that determine the velocity in start <= t <= stop (ps), in chronological order.

        The last step of a train lasts until the train ends, the next train moves the axis, or the motion is cut
        off, whichever comes first.  A train that is cut off is listed twice: up to the cut with its direction,
        and after the cut with direction 0, because the motor is then at rest.

        Returns:
            For each train: its first instant and the instant before which it ends, ps; its direction; the train.
        """
        self.check_kept(start)
        found: list[tuple[int, int, int, Playing]] = []
        end = stop + 1
        for number in range(bisect_right(self.past, stop, key=_start) - 1, -1, -1):
            stretch = self.past[number]
            playing = stretch.playing
            if playing is not None and (moves := playing.moves) is not None and moves < end:
                halted = end if stretch.halted is None else max(stretch.halted, moves)
                if halted < end:
                    found.append((max(halted, start), end, 0, playing))
                    end = halted
                if max(moves, start) < end:
                    found.append((max(moves, start), end, stretch.sign, playing))
                end = moves
                if moves <= start:
                    break
        return found[::-1]

    def velocities(self, start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the velocities in start <= t <= stop (ps).

        Returns:
            `start` and the instants of all later changes, (n,) int64 ps, ascending; and the velocity from each
            of these instants to the next, (n,) float64 steps/s.
        """
        import numpy as np

        at, what = [np.array([start])], [np.zeros(1)]
        for since, end, sign, playing in self.driven(start, stop):
            times, speeds = playing.velocities(since, end - 1)
            at.append(times)
            what.append(sign * speeds + 0.0)  # not a negative zero at rest
        return staircase(np.concatenate(at), np.concatenate(what))

    def velocity_at(self, ps: int) -> float:
        """Return the velocity at one past instant (ps), in steps/s."""
        return float(self.velocities(ps, ps)[1][-1])

    def velocities_at(self, times: Sequence[int] | NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the velocities at many past instants (int64 ps): float64 steps/s, same shape as `times`."""
        import numpy as np

        at = self._instants(times)
        order = np.argsort(at, axis=None, kind="stable")
        instants = at.ravel()[order]
        found = np.zeros(at.size)
        if at.size:
            driven = self.driven(int(instants[0]), int(instants[-1]))
            first = int(np.searchsorted(instants, driven[0][0])) if driven else at.size
            for number, group in _groups(instants[first:], [since for since, *_ in driven]):
                _, _, sign, playing = driven[number]
                asked = instants[first:][group]
                changes, speeds = playing.velocities(int(asked[0]), int(asked[-1]))
                found[first:][group] = sign * speeds[np.searchsorted(changes, asked, side="right") - 1] + 0.0
        out = np.empty(at.size)
        out[order] = found
        return out.reshape(at.shape)


def staircase(times: NDArray[np.int64], values: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return only those points of a staircase, as times and values, at which the value changes.

    Of several points at one instant, the last is kept; of consecutive points with equal values, the first.
    """
    import numpy as np

    last = np.append(times[1:] != times[:-1], True)
    times, values = times[last], values[last]
    changed = np.append(True, values[1:] != values[:-1])
    return times[changed], values[changed]


def _groups(instants: NDArray[np.int64], starts: list[int]) -> Iterator[tuple[int, slice]]:
    """Group ascending instants by the ascending `starts`: each belongs to the last start at or before it.

    Instants before the first start belong to the first one.  For each group, yield the index of its start,
    and the slice of `instants` that it covers.
    """
    import numpy as np

    which = np.maximum(np.searchsorted(np.array(starts, np.int64), instants, side="right") - 1, 0)
    ends = np.append(np.flatnonzero(which[1:] != which[:-1]) + 1, len(which)) if len(which) else which
    begin = 0
    for end in ends.tolist():
        yield int(which[begin]), slice(begin, end)
        begin = end
