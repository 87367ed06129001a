"""The motion of a shaft, in a form that is queried rather than stepped.

A `ShaftMotion` returns the position of a shaft at any instant from its start until an unforeseen event.
The shaft follows the edges of a clock, promised by a pulse train or made by a machine.  Its position is
kept in whole parts of a step, so that it does not drift, whatever gears drive the shaft.  A motion is a
value: its steps are not events.

    edges    |    |    |    |    |    |    |    |        clock edges after `since`
    position 0    0    0    1    2    3    3    3        `slack` is 2 and `room` 5; then the shaft is at a stop

A `Counter` (shaft_counter.py) counts a motion on a scale.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import lcm
from typing import TYPE_CHECKING

from ...core.time.events import Events, Listed, NoEvents, When

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

BLOCKED = 1 << 200  # a slack that no motion takes up
FEW = 16  # edges per queried instant: if there are fewer, all are listed in one array


# ---------------------------------------------------------------------------------------------------- drives of a shaft
class Once(Listed):
    """A single event, at an instant (ps)."""

    def __init__(self, ps: int) -> None:
        super().__init__((ps,))


# ------------------------------------------------------------------------------------------------------- the motion
@dataclass(slots=True)
class ShaftMotion:
    """A segment of the motion of a shaft, valid from an instant until another motion replaces it.

    Positions are counted in parts of a step, with `unit` parts in a step.  With each edge of `drive` after
    `since` the shaft moves by `step` parts in the direction of `sign`, once `slack` parts (backlash or slip)
    are taken up.  After `room` edges, including the edges that take up slack, it is at a stop, and further edges
    are lost.
    """

    drive: Events = field(default_factory=NoEvents)
    since: int = 0
    place: int = 0  # parts
    sign: int = 1
    step: int = 1  # parts by which an edge moves the shaft
    unit: int = 1  # parts in a step; `Shaft.per_turn` steps are a turn
    slack: int = 0  # parts
    room: int | None = None  # edges; None: no stop
    first: int = field(init=False)  # drive edges before this motion

    def __post_init__(self) -> None:
        self.first = self.drive.count(self.since)

    # --------------------------------------------------------------------------------------------------------- queries
    def count(self, ps: int) -> int:
        """Return the number of edges of this motion up to an instant (ps), including lost edges."""
        return max(0, self.drive.count(ps) - self.first)

    def moved(self, k: int) -> int:
        """Return the number of parts by which the first k edges move the shaft."""
        if self.room is not None:
            k = min(k, self.room)
        return max(0, k * self.step - self.slack)

    def level(self, ps: int) -> int:
        """Return the position at an instant (ps), in parts of a step."""
        return self.place + self.sign * self.moved(self.count(ps))

    def steps_at(self, ps: int) -> Fraction:
        """Return the position at an instant (ps), in steps."""
        return Fraction(self.level(ps), self.unit)

    def edge_by(self, parts: int) -> int | None:
        """Return the number of the edge that completes a move by `parts` (at least 1 part); None if no edge does."""
        k = -(-(parts + self.slack) // self.step)
        return k if self.room is None or k <= self.room else None

    def time(self, k: int) -> When:
        """Return the instant (ps) of edge k of this motion; NotYet if unknown; None if the motion has no such edge."""
        return self.drive.time(self.first + k)

    def lost(self, ps: int) -> int:
        """Return the number of edges lost at a stop up to an instant (ps)."""
        return 0 if self.room is None else max(0, self.count(ps) - self.room)

    def places(self, times: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the positions at instants of this motion (int64 ps), in steps: (n,) float64."""
        import numpy as np

        edges = self.count(int(times.max(initial=self.since)))
        if edges < FEW * len(times):
            k = np.searchsorted(self.drive.times(self.first + 1, self.first + edges), times, "right")
        else:
            k = np.array([self.count(int(ps)) for ps in times], np.int64)
        return self._places(k)

    def edges(self, start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the steps at start < t <= stop: (n,) int64 ps, and the positions after them, (n,) float64 steps."""
        import numpy as np

        first, last = self.count(start) + 1, self.count(stop)
        first = max(first, self.edge_by(1) or last + 1)
        last = last if self.room is None else min(last, self.room)
        if last < first:
            return np.empty(0, np.int64), np.empty(0)
        return self.drive.times(self.first + first, self.first + last), self._places(np.arange(first, last + 1))

    def _places(self, k: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the positions after given numbers of edges, in steps."""
        import numpy as np

        if self.room is not None:
            k = np.minimum(k, self.room)
        if self.slack >= BLOCKED:
            return np.full(len(k), self.place / self.unit)
        moved = np.maximum(0, k * self.step - self.slack)
        found: NDArray[np.float64] = (self.place + self.sign * moved) / self.unit
        return found

    # ------------------------------------------------------------------------------------------------ from here on
    def onward(self, ps: int) -> ShaftMotion:
        """Return the motion from an instant (ps) on.

        Its start is computed from the edges of the drive up to that instant only, because later edges may still
        change.
        """
        k = self.count(ps)
        place, slack = self.place + self.sign * self.moved(k), max(0, self.slack - k * self.step)
        room = None if self.room is None else max(0, self.room - k)
        return ShaftMotion(self.drive, ps, place, self.sign, self.step, self.unit, slack, room)

    def within(self, low: Fraction | None, high: Fraction | None) -> ShaftMotion:
        """Return the motion with hard stops at two positions, in steps; None for no stop on that side."""
        stop = high if self.sign > 0 else low
        if stop is None:
            return self if self.room is None else replace(self, room=None)
        ahead = stop * self.unit - self.place if self.sign > 0 else self.place - stop * self.unit
        return replace(self, room=max(0, int((ahead + self.slack) // self.step)))

    def refined(self, times: int) -> ShaftMotion:
        """Return the motion expressed in parts that are smaller by an integer factor."""
        return replace(
            self, place=self.place * times, step=self.step * times, unit=self.unit * times, slack=self.slack * times
        )

    def geared(self, ratio: Fraction) -> ShaftMotion:
        """Return the motion of a geared shaft: `ratio` times as far; a negative `ratio` reverses the direction."""
        n, d = abs(ratio.numerator), ratio.denominator
        sign = 1 if ratio > 0 else -1
        return replace(
            self, place=sign * self.place * n, step=self.step * n, slack=self.slack * n, unit=self.unit * d,
            sign=sign * self.sign,
        )  # fmt: skip

    def played(self, here: ShaftMotion, play: Fraction, offset: Fraction) -> ShaftMotion:
        """Return the motion of a load that this motion drives with backlash, which must be taken up first.

        `here` is the load's motion so far; after forward moves, the position of the load is that of the
        driving shaft plus `offset` steps.
        """
        unit = lcm(self.unit, here.unit, play.denominator, offset.denominator)
        motion, place = common(self, unit), common(here, unit).place
        slop, pushed = int(play * unit), motion.place + int(offset * unit)
        place = min(max(place, pushed), pushed + slop)
        slack = motion.slack + (place - pushed if motion.sign > 0 else pushed + slop - place)
        return ShaftMotion(motion.drive, motion.since, place, motion.sign, motion.step, unit, slack, motion.room)


def common(one: ShaftMotion, unit: int) -> ShaftMotion:
    """Return the motion with its parts subdivided, if needed, so that 1/`unit` step is a whole number of parts."""
    return one if one.unit % unit == 0 else one.refined(lcm(one.unit, unit) // one.unit)
