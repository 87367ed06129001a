"""An axis's past, cycle by cycle, computed on request from the runs that its trajectory generator keeps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....core.chip import AxisOfChip
from ....core.motion.history import Staircase
from ....core.motion.quantity import Quantity
from ....core.time.timebase import Time
from ....errors import UsageError
from ..axis.pulses import RANGE, Pulses
from ..motion import Motion
from .cycle_train import Cycles
from .quantities import Acceleration, Forces, Jerk, phases
from .s_curves import SCurve

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ....core.chip import Chip


class ChipsetAxis(AxisOfChip):
    """An axis of a chipset, whose cycles can be queried; `motion` is None with the twin, which keeps no cycles."""

    def __init__(self, chip: Chip, number: int, motion: Motion | None) -> None:
        super().__init__(chip, number)
        self.motion = motion

    def cycles(self, start: Time | None = None, stop: Time | None = None) -> Cycles:
        """Return the cycles since the last reset that begin at start <= t <= stop; all of them by default.

        Raises:
            UsageError: the chipset was created with stepwise=True, and so keeps no record.
            NotRecorded: the record does not reach that far back (`Bench(keep=)`).
        """
        motion = self.motion
        if motion is None:
            raise UsageError(f"{self.name}: with stepwise=True no cycles are kept")
        motion.catch_up()
        begin, end = self._window(start, stop)
        self.motor.check_kept(begin)
        cycle_clock, pulses = motion.cycle_clock, motion.trajectories[self.number - 1].pulses
        if not pulses.past:  # the supply is new, or still off: no cycle has begun
            return cycles_of(pulses, 0, 0)
        first = max(cycle_clock.cycle_at(begin - 1) + 1, pulses.past[0].first)
        return cycles_of(pulses, first, cycle_clock.cycle_at(end) + 1)

    def quantities(self) -> tuple[Quantity, ...]:
        """Return velocity and position and, if cycles are kept, the derived quantities.

        The derived quantities are the acceleration, the jerk if there was an S-curve, and the actual position if
        the axis's encoder has turned.
        """
        found, forces = super().quantities(), self._forces()
        if forces is not None:
            curved = any(entry.curve for entry in forces.pulses.past)
            found += (Acceleration(forces), Jerk(forces)) if curved else (Acceleration(forces),)
            found += encoder_of(forces.motion, self.number)
        return found

    def phases(self, start: Time | None = None, stop: Time | None = None) -> list[tuple[int, int, str]]:
        """Return the S-curve phases between two instants: start (ps), end (ps), "1" to "7"; [] without a record."""
        forces = self._forces()
        return phases(forces, *self._window(start, stop)) if forces is not None else []

    def _forces(self) -> Forces | None:
        return None if self.motion is None else Forces(self.motion, self.number)


def encoder_of(motion: Motion, number: int) -> tuple[Quantity, ...]:
    """Return an axis's actual position, from the filtered counts; () if no encoder has ever turned."""
    import numpy as np

    motion.catch_up()
    feedback = motion.trajectories[number - 1].feedback
    encoder, offsets = feedback.encoder, feedback.offsets
    if encoder is None or len(encoder.history) < 2:
        return ()
    clock = encoder.clock

    def values(times: NDArray[np.int64]) -> NDArray[np.float64]:
        if times.size:
            feedback.pulses.axis.check_kept(int(times.min()))
        return encoder.history.values_at(clock.ticks_array(times + 1) - 1) + offsets.values_at(times)

    def changes(start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        ticks, _ = encoder.history.changes(clock.ticks_until(start), clock.ticks_until(stop))
        times = np.union1d(clock.ps_array(ticks), offsets.changes(start, stop)[0])
        return times, values(times)

    return (Staircase(motion.kernel, "actual_position", "counts", values, changes, from_zero=False),)


def cycles_of(pulses: Pulses, first: int, stop: int) -> Cycles:
    """Return the cycles `first` ... `stop` - 1 of an axis."""
    import numpy as np

    count = max(stop - first, 0)
    targets, velocities = np.zeros(count, np.int64), np.zeros(count, np.int64)
    phases = np.zeros(count, np.int8)
    past, cycle_clock = pulses.past, pulses.cycle_clock
    for entry, following in zip(past, [*past, None][1:], strict=True):
        a, b = max(entry.first, first), stop if following is None else min(following.first, stop)
        if a >= b:
            continue
        here = slice(a - first, b - first)
        targets[here] = entry.x0
        if entry.law is not None:
            cycles = np.arange(a - entry.since, b - entry.since)
            targets[here] += entry.sign * entry.law.travels(cycles)
            velocities[here] = entry.sign * entry.law.velocities(cycles)
            if isinstance(entry.law, SCurve):
                phases[here] = entry.law.phases(cycles)
    numbers = np.arange(first, first + count)
    targets = (targets + RANGE // 2) % RANGE - RANGE // 2
    times = cycle_clock.clock.ps_array(numbers * cycle_clock.cycle_ticks, cycle_clock.origin)
    return Cycles(cycle_clock.per_s, numbers, times, targets, velocities, phases)
