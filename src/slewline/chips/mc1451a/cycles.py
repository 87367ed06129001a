"""What an axis did, cycle by cycle: asked afterwards, from the runs that its trajectory generator keeps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...core.chip import AxisOfChip
from ...core.timebase import picoseconds
from ...errors import UsageError
from .motion import Motion
from .sheet import CYCLE_TICKS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .registers import Registers
    from .trajectory import Trajectory

RANGE = 1 << 47


@dataclass(frozen=True)
class Cycles:
    """Cycles of an axis: numbers, instants of their begins in ps, targets there in 1/65536 step, target velocities
    in 1/65536 step per cycle, and the phases of S-curves (0: none).  All (n,); int64, phases int8."""

    numbers: NDArray[np.int64]
    times_ps: NDArray[np.int64]
    targets: NDArray[np.int64]
    velocities: NDArray[np.int64]
    phases: NDArray[np.int8]

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def accelerations(self) -> NDArray[np.int64]:
        """Changes of velocity from each cycle to the next: (n-1,) int64."""
        import numpy as np

        return np.diff(self.velocities)

    @property
    def jerks(self) -> NDArray[np.int64]:
        """Changes of acceleration from each cycle to the next: (n-2,) int64."""
        import numpy as np

        return np.diff(self.velocities, 2)


class ChipsetAxis(AxisOfChip):
    """An axis of a chipset, which can be asked for its cycles."""

    chip: Registers

    def cycles(self, start: str | int | None = None, stop: str | int | None = None) -> Cycles:
        """Cycles since the last reset that begin at start <= t <= stop; all of them by default.

        Raises:
            UsageError: for a chipset that works step by step, which keeps no record.
        """
        chip = self.chip
        if not isinstance(chip.motion, Motion):
            raise UsageError(f"{self.name}: with stepwise=True no cycles are kept")
        chip.motion.catch_up()
        now = self.kernel.now
        begin, end = 0 if start is None else picoseconds(start), now if stop is None else min(picoseconds(stop), now)
        first = max(-(-(chip.clock.ticks_from(begin) - chip.origin) // CYCLE_TICKS), 0)
        last = (chip.clock.ticks_until(end) - chip.origin) // CYCLE_TICKS
        return cycles_of(chip.motion.trajectories[self.number - 1], first, last + 1)


def cycles_of(trajectory: Trajectory, first: int, stop: int) -> Cycles:
    """Cycles `first` ... `stop` - 1 of an axis."""
    import numpy as np

    count = max(stop - first, 0)
    targets, velocities = np.zeros(count, np.int64), np.zeros(count, np.int64)
    phases = np.zeros(count, np.int8)
    past = trajectory.past
    for entry, following in zip(past, [*past[1:], None], strict=True):
        a, b = max(entry.first, first), stop if following is None else min(following.first, stop)
        if a >= b:
            continue
        here = slice(a - first, b - first)
        targets[here] = entry.x0
        if entry.law is not None:
            cycles = np.arange(a - entry.since, b - entry.since)
            targets[here] += entry.sign * entry.law.travels(cycles)
            velocities[here] = entry.sign * entry.law.velocities(cycles)
        if entry.phases is not None:
            ends = np.cumsum(entry.phases.lengths)
            done = np.arange(a, b) - entry.since + entry.done
            phases[here] = np.minimum(np.searchsorted(ends, done, side="right"), 6) + 1
    numbers = np.arange(first, first + count)
    clock = trajectory.chip.clock
    targets = (targets + RANGE // 2) % RANGE - RANGE // 2
    return Cycles(numbers, clock.ps_array(numbers * CYCLE_TICKS, trajectory.chip.origin), targets, velocities, phases)
