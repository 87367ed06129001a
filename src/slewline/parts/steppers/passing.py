"""Counts that change as a rotor turns, found from the grid points of the rotor's motion.

    grid points    *------*------*------*------*
    count          3      3      4      4      3         between points with different counts, the exact
                             ^             ^             picosecond of the change is searched for

A `Linkage` determines the position of a load that the rotor moves: its shaft, a shaft after a gear, a
carriage with backlash, or the rotor relative to its command.  `Passings` finds each change in the count
of such a load once, and keeps it.  A `RunCounter` shows the changes on a wire
(`parts/shafts/shaft_counter.py`).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ...core.time.events import NotYet, When
from ..motors.integration import Point
from ..motors.law import MotorLaw
from .linkage import Linkage

if TYPE_CHECKING:
    from ..shafts.shaft_counter import CountScale
    from .motor_run import Run

MARKS = 512  # milestones kept in case the future is cut
FIRST_PS = 1_000_000_000  # first distance that is searched ahead; it is then doubled
MOST_PS = 100_000_000_000
SOON = 30_000  # number of changes that take plain Python less time than compiling
AHEAD_PS = 400_000_000_000  # how far a single query looks ahead at most


@dataclass(slots=True)
class Milestone:
    """The known state of a count at an instant (ps): the count, and the number of its changes so far.

    `places` holds the positions of the linkages at the last grid point; they do not
    include the motion since that point.
    """

    ps: int
    places: tuple[float, ...]
    count: int
    changes: int


@dataclass(slots=True)
class Going:
    """The state of a search for the instants at which a count changes.

    Attributes:
        before: the last grid point that has been processed.
        law: the law of motion from this point on.
        done: the instant (ps) up to which changes have been found.
        places: the positions of the linkages at this point.
        count: the present count.
        times, counts: the changes found so far: their instants (ps), and the counts after them.
    """

    before: Point
    law: MotorLaw
    done: int
    places: tuple[float, ...]
    count: int
    times: list[int]
    counts: list[int]

    def show(self, ps: int, count: int) -> None:
        """Set the count from an instant (ps) on, and record the change if there is one."""
        if count != self.count:
            self.times.append(ps)
            self.counts.append(count)
            self.count = count


class Passings:
    """The changes in the count of a load that a rotor moves, found up to the last query.

    The changes within a grid step are computed from the first point of the step alone, as if the step had
    its full length.  So they depend neither on the instants of queries, nor on an input edge that ends the
    step early.  If the rotor reverses within a step, the parts before and after the reversal are processed
    one after the other.

    Args:
        run: the motion of the rotor.
        linkage: the linkage between the rotor and the load; it determines the load's position.
        scale: either the number of counts per step, or a list of bounds; with bounds, the count is the
            number of bounds at or below the position.
        zero: the count at position 0, before rounding down; not used with bounds.
    """

    def __init__(self, run: Run, linkage: Linkage, scale: CountScale, zero: float = 0.0) -> None:
        self.run, self.linkage = run, linkage
        self._per_step = float(scale.per_step)
        self._bounds = [float(bound) for bound in scale.bounds]
        self._zero = zero
        self.times: list[int] = []
        self.counts: list[int] = []
        point = run.stretches[0].first
        law = run.stretches[0].law
        places = linkage.begun(point.state[0] / law.motor.step, point.command / law.micro)
        self.first = self._count(places[-1])
        self._marks = [Milestone(point.t - 1, places, self.first, 0)]
        self._block = FIRST_PS
        run.cuts.append(self._cut)

    def _count(self, place: float) -> int:
        if self._per_step:
            return int((place * self._per_step + self._zero) // 1.0)
        return bisect_right(self._bounds, place)

    def _place(self, count: int) -> float:
        """Return the lowest position that has a given count, in steps of the load."""
        return (count - self._zero) / self._per_step if self._per_step else self._bounds[count - 1]

    @property
    def known(self) -> int:
        """The instant (ps) up to which the changes are known."""
        return self._marks[-1].ps

    def _cut(self, ps: int) -> None:
        """Drop the foreseen changes at or after an instant (ps)."""
        self._block = FIRST_PS
        while len(self._marks) > 1 and self._marks[-1].ps >= ps:
            self._marks.pop()
        mark = self._marks[-1]
        del self.times[mark.changes :], self.counts[mark.changes :]

    # ---------------------------------------------------------------------------------------------- finding changes
    def look(self, ps: int) -> None:
        """Find the changes up to an instant (ps)."""
        mark = self._marks[-1]
        if ps <= mark.ps:
            return
        places, count = self._go(mark, ps, self.times, self.counts)
        self._marks.append(Milestone(ps, places, count, len(self.times)))
        if len(self._marks) > 2 * MARKS:
            del self._marks[1:MARKS]

    def place(self, ps: int) -> float:
        """Return the position at an instant (ps)."""
        return self.places(ps)[-1]

    def places(self, ps: int) -> tuple[float, ...]:
        """Return the positions of all linkages at an instant (ps)."""
        self.look(ps)
        mark = self._marks[max(bisect_right(self._marks, ps, key=lambda mark: mark.ps) - 1, 0)]
        places, _ = self._go(mark, ps, [], [])
        before, law = self.run.at_or_before(ps), self.run.stretch_at(ps).law
        places = self._turned(law, before, ps - before.t, places)
        return self.linkage.follow(places, self.run.state(ps)[0] / law.motor.step, before.command / law.micro)

    def _go(self, mark: Milestone, ps: int, times: list[int], counts: list[int]) -> tuple[tuple[float, ...], int]:
        """Append the changes after a milestone, up to an instant (ps), to `times` and `counts`.

        Return the positions of the linkages at the last grid point, and the count at the instant.
        """
        run = self.run
        run.reach(ps)
        going = Going(
            run.at_or_before(mark.ps), run.stretch_at(mark.ps).law, mark.ps, mark.places, mark.count, times, counts
        )
        for law, columns, changed in run.between(mark.ps, ps):
            if changed:
                self._altered(going, law, point_of(columns, 0))
                columns = tuple(column[1:] for column in columns)
            if len(columns[0]):
                self._along(going, columns)
        if ps > going.done:
            self._within(going, ps)
        return going.places, going.count

    def _altered(self, going: Going, law: MotorLaw, point: Point) -> None:
        """Continue from a point at which the law or the position was changed externally."""
        before = going.before
        if point.t > before.t:
            state = going.law.after(before.t, before.state, before.code, point.t - before.t)
            self._step(going, replace(point, state=state, command=before.command))
        going.places = self.linkage.follow(going.places, point.state[0] / law.motor.step, point.command / law.micro)
        going.before, going.law, going.done = point, law, point.t
        going.show(point.t, self._count(going.places[-1]))

    def _along(self, going: Going, columns: Any) -> None:
        """Process consecutive grid points, given as columns."""
        import numpy as np

        times, states, commands, _ = columns
        law, before, linkage = going.law, going.before, self.linkage
        if not linkage.simple:
            self._with_play(going, columns)
            return
        rotor, asked = states[:, 0] / law.motor.step, commands / law.micro
        then = np.append(before.command / law.micro, asked[:-1])
        arrived = self._counts(linkage.begun(rotor, then)[-1])  # just before the edge
        left = self._counts(linkage.begun(rotor, asked)[-1]) if linkage.is_lagging else arrived
        came = np.append(self._count(going.places[-1]), left[:-1])
        speed = np.append(before.state[1], states[:, 1])
        turns = (speed[:-1] * speed[1:] <= 0.0) & (speed[:-1] != 0.0)
        if turns.any():
            farthest = rotor + 2e-12 * law.step_ps * speed[:-1] / law.motor.step
            turns &= self._counts(linkage.begun(farthest, then)[-1]) != arrived
        for n in np.flatnonzero((arrived != came) | (left != arrived) | turns).tolist():
            if n:
                going.before, going.done = point_of(columns, n - 1), int(times[n - 1])
                going.places = self._begun(law, going.before)
            self._step(going, point_of(columns, n))
        going.before, going.done = point_of(columns, len(times) - 1), int(times[-1])
        going.places = self._begun(law, going.before)

    def _with_play(self, going: Going, columns: Any) -> None:
        """Process consecutive grid points, given as columns, if any linkage has backlash."""
        import numpy as np

        law, first = going.law, going.before.state
        step, rotor = law.motor.step, columns[1][:, 0] / law.motor.step
        speed = np.append(first[1], columns[1][:, 1])
        farthest = rotor + 2e-12 * law.step_ps * speed[:-1] / step
        turns = (speed[:-1] * speed[1:] <= 0.0) & (speed[:-1] != 0.0)
        peaks: dict[int, float] = {}  # step by step, if the rotor reverses and this makes a difference
        while True:
            at = sorted(peaks)
            path = np.insert(rotor, at, [peaks[n] for n in at])
            grid = np.arange(len(rotor)) + np.searchsorted(at, np.arange(len(rotor)), "right")
            places = [each[grid] for each in self.linkage.gone(going.places, first[0] / step, path)]
            befores = [np.append(now, each[:-1]) for now, each in zip(going.places, places, strict=True)]
            there = self.linkage.followed(self.linkage.followed(befores, farthest), rotor)
            moved = [one != two for one, two in zip(there, self.linkage.followed(befores, rotor), strict=True)]
            more = set(np.flatnonzero(turns & np.logical_or.reduce(moved)).tolist()) - peaks.keys()
            if not more:
                break
            for n in more:
                before = point_of(columns, n - 1) if n else going.before
                turn = self._turns(law, before)
                turned = 0 < turn <= int(columns[0][n]) - before.t
                peaks[n] = law.after(before.t, before.state, before.code, turn)[0] / step if turned else float(rotor[n])
        counts = self._counts(places[-1])
        came = np.append(self._count(going.places[-1]), counts[:-1])
        for n in sorted({*np.flatnonzero(counts != came).tolist(), *peaks}):
            if n:
                going.before, going.done = point_of(columns, n - 1), int(columns[0][n - 1])
                going.places = tuple(float(each[n - 1]) for each in places)
            self._step(going, point_of(columns, n))
        going.before, going.done = point_of(columns, len(rotor) - 1), int(columns[0][-1])
        going.places = tuple(float(each[-1]) for each in places)

    def _begun(self, law: MotorLaw, point: Point) -> tuple[float, ...]:
        return self.linkage.begun(point.state[0] / law.motor.step, point.command / law.micro)

    def _counts(self, along: Any) -> Any:
        """Return the counts at some positions: (n,) int64."""
        import numpy as np

        if self._per_step:
            return np.floor(along * self._per_step + self._zero).astype(np.int64)
        return np.searchsorted(np.array(self._bounds), along, "right")

    def _step(self, going: Going, point: Point) -> None:
        """Advance to the next grid point; if the command changes there, apply the new command after the motion."""
        law, before = going.law, going.before
        asked, rotor = before.command / law.micro, point.state[0] / law.motor.step
        places = going.places
        if before.state[1] * point.state[1] <= 0.0:
            places = self._turned(law, before, point.t - before.t, places)
        arrived = self.linkage.follow(places, rotor, asked)
        if places is not going.places or self._count(arrived[-1]) != self._count(going.places[-1]):
            self._within(going, point.t)
        going.places, going.before, going.done = arrived, point, point.t
        going.show(point.t, self._count(arrived[-1]))
        if self.linkage.is_lagging and point.command != before.command:
            going.places = self.linkage.follow(arrived, rotor, point.command / law.micro)
            going.show(point.t, self._count(going.places[-1]))

    def _turns(self, law: MotorLaw, before: Point) -> int:
        """Return the time (ps) from a grid point to the rotor's reversal within the next step; 0 if there is none."""
        step, omega = law.step_ps, before.state[1]
        low, high = 0, step
        if omega == 0.0 or law.after(before.t, before.state, before.code, step)[1] * omega > 0.0:
            return 0
        while high - low > 1:
            middle = (low + high) // 2
            if law.after(before.t, before.state, before.code, middle)[1] * omega > 0.0:
                low = middle
            else:
                high = middle
        return high

    def _turned(self, law: MotorLaw, before: Point, span: int, places: tuple[float, ...]) -> tuple[float, ...]:
        """Return the positions at the rotor's reversal, if there is one up to `span` ps after a grid point.

        Without a reversal, return `places`.
        """
        turn = self._turns(law, before)
        if not 0 < turn <= span:
            return places
        rotor = law.after(before.t, before.state, before.code, turn)[0] / law.motor.step
        return self.linkage.follow(places, rotor, before.command / law.micro)

    def _within(self, going: Going, ps: int) -> None:
        """Record the changes up to an instant (ps) within the grid step that is being processed."""
        law, before = going.law, going.before
        step = law.step_ps
        if ps - before.t > step or before.t + step <= going.done:  # the rotor rests
            return
        turn = self._turns(law, before)
        places, low = going.places, 0
        for high in (turn, step) if turn else (step,):
            rotor = law.after(before.t, before.state, before.code, high)[0] / law.motor.step
            after = self.linkage.follow(places, rotor, before.command / law.micro)
            for at, count in self._crossings(law, before, low, high, self._count(places[-1]), self._count(after[-1])):
                if going.done < at <= ps:
                    going.show(at, count)
                if at > ps:
                    return
            places, low = after, high

    def _crossings(
        self, law: MotorLaw, before: Point, low: int, high: int, count: int, after: int
    ) -> Iterator[tuple[int, int]]:
        """Yield each change by 1 on the way from `count` to `after`: its instant (ps), and the count after it.

        The rotor turns in one direction from `low` to `high` (ps after the grid point `before`).
        """
        rising, model, table = after > count, law.model, law.table
        engine = model.python
        if (len(self.times) >= SOON or self.run.compiled) and model.is_compiled:
            engine, table = model.numba, law.rows  # type: ignore[assignment]
        for n in range(count + 1, after + 1) if rising else range(count, after, -1):
            factor, bound, up = self.linkage.bound(self._place(n), rising, before.command / law.micro)
            found = engine.crossing(
                law.parameters, table, before.t, before.state, before.code, low, high, 0,
                factor / law.motor.step, bound, up,
            )  # fmt: skip
            yield before.t + found, n if rising else n - 1

    # ---------------------------------------------------------------------------------------------------------- queries
    def level(self, ps: int) -> int:
        """Return the count at an instant (ps)."""
        self.look(ps)
        n = bisect_right(self.times, ps)
        return self.counts[n - 1] if n else self.first

    def after(self, ps: int, number: int = 1) -> When:
        """Return when (ps) the count will have changed `number` times after an instant (ps).

        Return NotYet if this has not been found yet, None if no such change is foreseen.
        """
        self.look(ps)
        n = bisect_right(self.times, ps) + number - 1
        farthest = ps + AHEAD_PS
        while n >= len(self.times):
            known, feed = self.known, self.run.feed.now
            until = feed.until
            if until is not None and ps < until <= known + 1:
                return NotYet(until)
            if known >= farthest:
                return NotYet(known)
            ahead = known + self._block
            if self.run.rests(known):
                following = feed.look_after(known)
                if following is None:
                    return None
                ahead = max(ahead, following)
            if until is not None and until > ps:
                ahead = min(ahead, until - 1)
            self._block = min(2 * self._block, MOST_PS)
            self.look(max(ahead, known + 1))
        return self.times[n]

    def edges(self, start: int, stop: int) -> tuple[list[int], list[int]]:
        """Return the changes at start < t <= stop (ps): their instants, and the counts after them."""
        self.look(stop)
        a, b = bisect_right(self.times, start), bisect_right(self.times, stop)
        return self.times[a:b], self.counts[a:b]

    def forget(self, before: int) -> None:
        """Drop the changes before an instant (ps) that has been reached."""
        self.look(before)
        n = bisect_right(self._marks, before, key=lambda mark: mark.ps) - 1
        if n < 0:
            return
        mark = self._marks[n]
        if mark.ps < before:  # a later milestone may belong to a future that does not occur
            places, count = self._go(mark, before, [], [])
            mark = Milestone(before, places, count, bisect_right(self.times, before))
        gone, self.first = mark.changes, mark.count
        del self.times[:gone], self.counts[:gone]
        self._marks[: n + 1] = [mark]
        for mark in self._marks:
            mark.changes -= gone


def point_of(columns: Any, n: int) -> Point:
    """Return grid point n of some columns."""
    times, states, commands, codes = columns
    return Point(int(times[n]), tuple(states[n].tolist()), int(commands[n]), int(codes[n]))
