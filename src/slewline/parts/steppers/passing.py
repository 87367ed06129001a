"""What a rotor passes as it turns: counts on a scale, found in the points of its run.

    grid points    *------*------*------*------*
    count          3      3      4      4      3         where it differs, the picosecond is looked for in between
                             ^             ^

A `Track` says where something is that the rotor moves: its shaft, a shaft behind a gear, a carriage with play, or the
rotor as seen from its command.  `Passings` are the changes of a count along it, found once and kept; a `RunCounter`
shows them on a wire (`parts/shafts/counter.py`).
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from ..motors.integration import Point
from ..motors.law import Law

if TYPE_CHECKING:
    from ..shafts.counter import CountScale, Shown
    from .run import Run

MARKS = 512  # places that are known again after the future has been cut
FIRST_PS = 1_000_000_000  # how far ahead is looked at first; then twice as far
MOST_PS = 100_000_000_000
AHEAD_PS = 400_000_000_000  # how far one question looks ahead at most


@dataclass(frozen=True)
class Track:
    """Where something is that a rotor moves, in steps of its own.

    `factor` steps to a full step of the motor; with `play` it stops where the rotor turns round, until so many steps
    are taken up, and it began `offset` above the rotor.  `behind`: its place as seen from the command.
    """

    factor: float = 1.0
    play: float = 0.0
    offset: float = 0.0
    under: Track | None = None
    behind: bool = False

    @property
    def moves(self) -> float:
        """Its steps a full step of the motor, while it moves."""
        return self.factor * (self.under.moves if self.under else 1.0)

    def begun(self, place: float, command: float) -> tuple[float, ...]:
        """Return the places of all tracks, this one last, as the run begins with the rotor at a place (full steps)."""
        below = self.under.begun(place, command) if self.under else ()
        return *below, self._of(below[-1] if below else place, command, None)

    def follow(self, before: tuple[float, ...], place: float, command: float) -> tuple[float, ...]:
        """Return the places of all tracks once the rotor is at a place, having gone there straight."""
        below = self.under.follow(before[:-1], place, command) if self.under else ()
        return *below, self._of(below[-1] if below else place, command, before[-1])

    def _of(self, place: float, command: float, before: float | None) -> float:
        pushed = place * self.factor + self.offset
        if self.behind:
            pushed -= command
        if not self.play or before is None:
            return pushed
        return min(max(before, pushed), pushed + self.play)

    @property
    def simple(self) -> bool:
        """Does its place follow from that of the rotor alone?"""
        return not self.play and (self.under is None or self.under.simple)

    def bound(self, place: float, rising: bool, command: float) -> tuple[float, float, bool]:
        """Return factor, bound and direction such that it passes a place where factor times the rotor passes that."""
        pushed = place - self.offset + (command if self.behind else 0.0)
        if self.play and not rising:
            pushed -= self.play
        if self.under is None:
            return self.factor, pushed, rising
        up = rising if self.factor > 0 else not rising
        return self.under.bound(pushed / self.factor, up, command)


@dataclass(slots=True)
class Known:
    """What is known at an instant (ps): the places of the tracks, the count, and how many changes have been."""

    ps: int
    places: tuple[float, ...]
    count: int
    changes: int


class Passings:
    """The changes of a count along a track, up to where they have been asked for.

    Args:
        run: of the rotor.
        track: what is counted along.
        scale: counts a step, or bounds.
        zero: counts by which the scale is turned against the place.
    """

    def __init__(self, run: Run, track: Track, scale: CountScale, zero: float = 0.0) -> None:
        self.run, self.track = run, track
        self._per_step = float(scale.per_step)
        self._bounds = [float(bound) for bound in scale.bounds]
        self._zero = zero
        self.times: list[int] = []
        self.counts: list[int] = []
        point = run.stretches[0].first
        law = run.stretches[0].law
        places = track.begun(point.state[0] / law.motor.step, point.command / law.micro)
        self.first = self._count(places[-1])
        self._marks = [Known(point.t, places, self.first, 0)]
        self._block = FIRST_PS
        run.cuts.append(self._cut)

    def _count(self, place: float) -> int:
        if self._per_step:
            return int((place * self._per_step + self._zero) // 1.0)
        return bisect_right(self._bounds, place)

    def _place(self, count: int) -> float:
        """The lowest place with a count."""
        return (count - self._zero) / self._per_step if self._per_step else self._bounds[count - 1]

    @property
    def known(self) -> int:
        """The instant (ps) up to which the changes are known."""
        return self._marks[-1].ps

    def _cut(self, ps: int) -> None:
        """Forget what was foreseen from an instant (ps) on."""
        self._block = FIRST_PS
        while len(self._marks) > 1 and self._marks[-1].ps >= ps:
            self._marks.pop()
        mark = self._marks[-1]
        del self.times[mark.changes :], self.counts[mark.changes :]

    # ------------------------------------------------------------------------------------------------- finding them
    def look(self, ps: int) -> None:
        """Find the changes up to an instant (ps)."""
        mark = self._marks[-1]
        if ps <= mark.ps:
            return
        run = self.run
        run.reach(ps)
        before, law = run.at_or_before(mark.ps), run.stretch_at(mark.ps).law
        begin, places, count = mark.ps, mark.places, mark.count
        for law_then, columns in run.between(mark.ps, ps):
            begin, before, places, count = self._along(law_then, law, columns, begin, before, places, count)
            law = law_then
        if ps > begin:
            place = run.state(ps)[0] / law.motor.step
            places, count = self._stretch(law, before, begin, ps, place, places, count)
        self._marks.append(Known(ps, places, count, len(self.times)))
        if len(self._marks) > 2 * MARKS:
            del self._marks[1:MARKS]

    def _along(
        self, law: Law, law_before: Law, columns: Any, begin: int, before: Any, places: Any, count: int
    ) -> tuple[int, Any, tuple[float, ...], int]:
        """Go along some grid points; return the last one's instant, itself, and the places and the count there."""
        import numpy as np

        times, states, commands, _ = columns
        if not self.track.simple or law is not law_before:
            for n, ps in enumerate(times.tolist()):
                place = float(states[n, 0]) / law.motor.step
                if ps > begin:
                    places, count = self._stretch(law_before, before, begin, ps, place, places, count)
                before, begin, law_before = point_of(columns, n), ps, law
                if self.track.behind:  # the command may have jumped at this instant
                    places = self.track.begun(place, before.command / law.micro)
                    count = self._jump(ps, count, self._count(places[-1]))
            return begin, before, places, count
        along = states[:, 0] / law.motor.step * self.track.moves + self._shift
        if self.track.behind:
            asked = commands / law.micro
            arrived = self._counts(along - np.append(before.command / law.micro, asked[:-1]))  # just before the edge
            left = self._counts(along - asked)
        else:
            arrived = left = self._counts(along)
        came = np.empty_like(left)
        came[0], came[1:] = count, left[:-1]
        for n in np.flatnonzero((arrived != came) | (left != arrived)).tolist():
            if n:
                before, begin = point_of(columns, n - 1), int(times[n - 1])
            self._changes(law, before, begin, int(times[n]), int(came[n]), int(arrived[n]))
            self._jump(int(times[n]), int(arrived[n]), int(left[n]))
        last = point_of(columns, len(times) - 1)
        places = self.track.begun(float(states[-1, 0]) / law.motor.step, last.command / law.micro)
        return last.t, last, places, int(left[-1])

    def _counts(self, along: Any) -> Any:
        """The counts at places: (n,) int64."""
        import numpy as np

        if self._per_step:
            return np.floor(along * self._per_step + self._zero).astype(np.int64)
        return np.searchsorted(np.array(self._bounds), along, "right")

    @cached_property
    def _shift(self) -> float:
        return self.track.begun(0.0, 0.0)[-1]

    def _stretch(
        self, law: Law, before: Any, begin: int, end: int, place: float, places: tuple[float, ...], count: int
    ) -> tuple[tuple[float, ...], int]:
        """Go from one instant to another within a step of the grid; return the places and the count there."""
        places = self.track.follow(places, place, before.command / law.micro)
        after = self._count(places[-1])
        if after != count:
            self._changes(law, before, begin, end, count, after)
        return places, after

    def _changes(self, law: Law, before: Any, begin: int, end: int, count: int, after: int) -> None:
        """Find the instants at which the count changes one by one, between two instants of a step of the grid."""
        engine, rising = law.model.python, after > count
        span = end - before.t
        for n in range(count + 1, after + 1) if rising else range(count, after, -1):
            factor, bound, up = self.track.bound(self._place(n), rising, before.command / law.micro)
            found = engine.crossing(
                law.parameters, law.table, before.t, before.state, before.code, begin - before.t, span, 0,
                factor / law.motor.step, bound, up,
            )  # fmt: skip
            begin = before.t + found
            self.times.append(begin)
            self.counts.append(n if rising else n - 1)

    def _jump(self, ps: int, count: int, after: int) -> int:
        if after != count:
            self.times.append(ps)
            self.counts.append(after)
        return after

    # -------------------------------------------------------------------------------------------------------- questions
    def at(self, ps: int) -> int:
        """Return the count at an instant (ps)."""
        self.look(ps)
        n = bisect_right(self.times, ps)
        return self.counts[n - 1] if n else self.first

    def after(self, ps: int, number: int = 1) -> int | None:
        """Return the next change after an instant (ps), or an instant at which to ask again; None: none comes."""
        self.look(ps)
        n = bisect_right(self.times, ps) + number - 1
        farthest = ps + AHEAD_PS
        while n >= len(self.times):
            known, feed = self.known, self.run.feed.now
            until = feed.until
            if until is not None and ps < until <= known + 1:
                return until
            if known >= farthest:
                return known
            ahead = known + self._block
            if self.run.rests(known):
                following = feed.after(known)
                if following is None:
                    return None
                ahead = max(ahead, following)
            if until is not None and until > ps:
                ahead = min(ahead, until - 1)
            self._block = min(2 * self._block, MOST_PS)
            self.look(max(ahead, known + 1))
        return self.times[n]

    def between(self, start: int, stop: int) -> tuple[int, list[int], list[int]]:
        """Return the count at one instant, and the changes up to another: instants (ps), and counts from there on."""
        self.look(stop)
        a, b = bisect_right(self.times, start), bisect_right(self.times, stop)
        return (self.counts[a - 1] if a else self.first), self.times[a:b], self.counts[a:b]

    def forget(self, before: int) -> None:
        """Drop the changes before an instant (ps)."""
        self.look(before)
        marks = [mark for mark in self._marks if mark.ps >= before]
        gone = bisect_right(self.times, before)
        if gone:
            self.first = self.counts[gone - 1]
        del self.times[:gone], self.counts[:gone]
        for mark in marks:
            mark.changes -= gone
        self._marks = marks


def point_of(columns: Any, n: int) -> Point:
    """Return one of some grid points."""
    times, states, commands, codes = columns
    return Point(int(times[n]), tuple(states[n].tolist()), int(commands[n]), int(codes[n]))


class RunCounter:
    """The counts of a track as a wire shows them, `lag_ps` later: a counter of `parts/shafts/counter.py`."""

    def __init__(self, passings: Passings, scale: CountScale, lag_ps: int) -> None:
        self.passings, self.scale, self.lag_ps = passings, scale, lag_ps

    def at(self, ps: int) -> int:
        """Return the count that is shown at an instant (ps)."""
        return self.passings.at(ps - self.lag_ps)

    def after(self, ps: int, changes: int = 1) -> int | None:
        """Return when the count changes next (ps), or an instant at which to ask again; None: as things stand never."""
        found = self.passings.after(ps - self.lag_ps, changes)
        return None if found is None else found + self.lag_ps

    def between(self, start: int, stop: int) -> Shown:
        """Return the count at an instant (ps), and its changes up to another: instants, and counts from there on."""
        before, times, counts = self.passings.between(start - self.lag_ps, stop - self.lag_ps)
        return before, [time + self.lag_ps for time in times], counts

    way = 0  # it may turn round

    def onward(self, ps: int) -> RunCounter:
        """Return the counter from an instant (ps) on: it is the same, since a run keeps its past."""
        return self

    def on(self, motion: object, now: int) -> RunCounter:
        """Return the counter for what the shaft does from `now` (ps) on: it is the same."""
        return self
