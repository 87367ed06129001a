r"""The acceleration and jerk of an axis, computed on request from the laws of motion kept for past cycles.

acceleration     ____                 trapezoid: the change of velocity in each cycle; a jump (start velocity, an
          ______|    |____      __    abrupt stop, the electronic gear) counts as no acceleration, and is not drawn
                          |____|
                  2                   S-curve: the acceleration of the continuous curve; the jerk is constant
              1 /---\ 3   4   7       within a phase, which may begin and end within a cycle
          ____/      \____    /--
                          5\_/6
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from itertools import pairwise
from math import isclose
from typing import TYPE_CHECKING, NamedTuple

from ....core.motion.quantity import Outline, Quantity
from ....core.time.timebase import PS_PER_S
from ..axis.pulses import TargetLaw
from ..motion import Motion
from ..registers import ONE
from .ideal import curve
from .profile import UNIT, Phases
from .s_curves import PLACES, SCurve

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class JerkSegment(NamedTuple):
    """A time span of constant jerk: its start, its first acceleration (steps/s^2), the jerk, the phase (or 0)."""

    begin_ps: int
    acceleration: float
    jerk: float
    phase: int = 0


class Forces:
    """The acceleration and the jerk of one axis in the past, up to now."""

    def __init__(self, motion: Motion, number: int) -> None:
        self.motion, self.pulses = motion, motion.trajectories[number - 1].pulses
        self.cycle_clock = motion.cycle_clock
        self.per_s = self.cycle_clock.per_s

    def ps(self, cycle: int, parts: int = 0) -> int:
        """Return the instant (ps) that is `parts` * 2^-PLACES cycle after the start of a cycle."""
        cycle_clock = self.cycle_clock
        if not parts:
            return cycle_clock.ps(cycle)
        ticks = (cycle_clock.tick(cycle) << PLACES) + parts * cycle_clock.cycle_ticks
        return (ticks * PS_PER_S // cycle_clock.clock.hz) >> PLACES

    def cycles(self, start: int, stop: int) -> NDArray[np.int64]:
        """Return the starts of all cycles from the cycle at `start` to the cycle at `stop` (ps): (n,) int64 ps."""
        import numpy as np

        cycle_clock = self.cycle_clock
        numbers = np.arange(max(cycle_clock.cycle_at(start), 0), cycle_clock.cycle_at(stop) + 1)
        return cycle_clock.clock.ps_array(numbers * cycle_clock.cycle_ticks, cycle_clock.origin)

    def stretches(self, start: int, stop: int) -> list[JerkSegment]:
        """Return the segments that cover `start` to `stop` (ps), ascending; the list may begin with earlier ones."""
        self.pulses.axis.check_kept(start)
        self.motion.catch_up()
        past = self.pulses.past
        found = [JerkSegment(0, 0.0, 0.0)]
        if not past or stop < self.ps(past[0].first):
            return found
        cycle = self.cycle_clock.cycle_at(start)
        first = max(bisect_right(past, cycle, key=lambda entry: entry.first) - 2, 0)
        for entry, before, following in zip(
            past[first:], [None, *past[first:]], [*past[first + 1 :], None], strict=False
        ):
            if self.ps(entry.first) > stop:
                break
            if entry.curve is not None and isinstance(entry.law, SCurve):
                found += self._of_curve(entry, entry.curve, entry.law, following)
            else:
                found += self._of_run(entry, before, following)
        return [stretch for stretch in found if stretch.begin_ps <= stop]

    def _of_run(self, entry: TargetLaw, before: TargetLaw | None, following: TargetLaw | None) -> Iterator[JerkSegment]:
        """Yield the segments of constant acceleration of a run, in which the axis follows one law of motion.

        The acceleration in the first cycle follows from the velocity in the cycle before the run, so this cycle
        may need a segment of its own.  If the velocity changes by more than the acceleration of the law allows,
        the change is a jump, and counts as an acceleration of 0.
        """
        unit = self.per_s**2 / ONE
        change = entry.sign * entry.law.velocity(1) - entry.sign * entry.law.velocity(0) if entry.law else 0
        if not entry.acceleration:
            change = 0
        gained = change
        if before is not None and before.curve is None:
            gained = velocity(entry, entry.first) - velocity(before, entry.first - 1)
        if abs(gained) > entry.acceleration:
            gained = 0
        yield JerkSegment(self.ps(entry.first), gained * unit, 0.0)
        if gained != change and (following is None or following.first > entry.first + 1):
            yield JerkSegment(self.ps(entry.first + 1), change * unit, 0.0)

    def _of_curve(
        self, entry: TargetLaw, phases: Phases, law: SCurve, following: TargetLaw | None
    ) -> Iterator[JerkSegment]:
        """Yield one segment for each phase of the S-curve that a run follows.

        If the run continues after the end of the curve, the last segment is one with no acceleration and no jerk.
        """
        zero = entry.since - law.first  # the cycle in which the curve begins
        begun, over = entry.first - zero, None if following is None else following.first - zero
        parts = 0
        for phase, (length, piece) in enumerate(zip(phases.lengths, curve(phases, self.per_s), strict=True), 1):
            late = max(begun * UNIT - parts, 0)  # of the phase, processed by an earlier run
            if length and late < length and (over is None or parts < over * UNIT):
                acceleration = piece.acceleration + piece.jerk * (late / UNIT / self.per_s)
                at = self.ps(zero, parts + late)
                yield JerkSegment(at, entry.sign * acceleration, entry.sign * piece.jerk, phase)
            parts += length
        if over is None or parts < over * UNIT:
            yield JerkSegment(self.ps(zero, parts), 0.0, 0.0)


def velocity(entry: TargetLaw, cycle: int) -> int:
    """Return the signed displacement in a cycle, in 1/65536 step; 0 at rest."""
    return entry.sign * entry.law.velocity(cycle - entry.since) if entry.law is not None else 0


class Acceleration(Quantity):
    """The acceleration of an axis."""

    name, unit, is_staircase = "acceleration", "steps/s²", False

    def __init__(self, forces: Forces) -> None:
        self.forces = forces

    def value(self, stretch: JerkSegment, ps: int) -> float:
        """Return the value of the quantity at an instant (ps) within a segment."""
        return stretch.acceleration + stretch.jerk * (ps - stretch.begin_ps) / PS_PER_S

    def values_at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the values of the quantity at many instants, given as (n,) int64 ps: (n,) float64."""
        import numpy as np

        times = np.asarray(times_ps, np.int64)
        if not times.size:
            return times.astype(np.float64)
        stretches = self.forces.stretches(int(times.min()), int(times.max()))
        begins = np.array([stretch.begin_ps for stretch in stretches])
        which = np.searchsorted(begins, times, side="right") - 1
        values = np.array([self.value(stretch, stretch.begin_ps) for stretch in stretches])[which]
        slopes = np.array([self.slope(stretch) for stretch in stretches])[which]
        return np.asarray(values + slopes * (times - begins[which]) / PS_PER_S, np.float64)

    def slope(self, stretch: JerkSegment) -> float:
        """Return the rate at which the quantity grows in a segment, per second."""
        return stretch.jerk

    def changes(self, start: int, stop: int) -> Outline:
        """Return the outline between two instants (ps), with a point wherever the value jumps or the slope changes."""
        import numpy as np

        points = [(start, float(self.values_at(np.array([start]))[0]))]
        stretches = self.forces.stretches(start, stop)
        for before, stretch in pairwise(stretches):
            if not start < stretch.begin_ps <= stop:
                continue
            end, value = self.value(before, stretch.begin_ps), self.value(stretch, stretch.begin_ps)
            if self.is_staircase:
                points += [(stretch.begin_ps, value)] if value != points[-1][1] else []
                continue
            jumps = not isclose(end, value, rel_tol=1e-9, abs_tol=abs(before.jerk) / PS_PER_S)  # by more than rounding
            if jumps or self.slope(stretch) != self.slope(before):
                points += [(stretch.begin_ps, end)] if jumps else []
                points.append((stretch.begin_ps, value))
        if not self.is_staircase:
            points.append((stop, self.value(stretches[-1], stop)))
        times, values = zip(*points, strict=True)
        return Outline(np.array(times, np.int64), np.array(values, np.float64) + 0.0)

    def staircase(self, start: int, stop: int) -> Outline:
        """Return the outline between two instants (ps) as a staircase, in which each value holds until the next.

        Where the value changes linearly, there is one point per cycle, at the start of the cycle.
        """
        import numpy as np

        stretches = self.forces.stretches(start, stop)
        parts = [np.array([stretch.begin_ps for stretch in stretches])]
        for stretch, end in zip(stretches, [*(later.begin_ps for later in stretches[1:]), stop + 1], strict=True):
            if self.slope(stretch):
                cycles = self.forces.cycles(max(stretch.begin_ps, start), end - 1)
                parts.append(cycles[cycles >= stretch.begin_ps])
        times = np.unique(np.concatenate(parts))
        times = times[max(int(np.searchsorted(times, start, side="right")) - 1, 0) :]
        return Outline(np.maximum(times, start), self.values_at(times) + 0.0)


class Jerk(Acceleration):
    """The jerk of an axis: constant in each phase of an S-curve, otherwise 0; a jump in acceleration has no jerk."""

    name, unit, is_staircase = "jerk", "steps/s³", True

    def value(self, stretch: JerkSegment, ps: int) -> float:
        """Return the jerk of a segment, which is constant."""
        return stretch.jerk

    def slope(self, stretch: JerkSegment) -> float:
        """Return 0, because the jerk of a segment is constant."""
        return 0.0


def phases(forces: Forces, start: int, stop: int) -> list[tuple[int, int, str]]:
    """Return the S-curve phases between two instants (ps), cut to that range: (start ps, end ps, "1" ... "7")."""
    found: list[tuple[int, int, str]] = []
    stretches = forces.stretches(start, stop)
    for stretch, following in zip(stretches, [*stretches[1:], JerkSegment(stop, 0.0, 0.0)], strict=True):
        begin, end, text = max(stretch.begin_ps, start), min(following.begin_ps, stop), str(stretch.phase)
        if stretch.phase and begin < end:
            if found and found[-1][1:] == (begin, text):
                begin = found.pop()[0]
            found.append((begin, end, text))
    return found
