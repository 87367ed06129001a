"""The step train of an axis in the slow twin: the steps of one cycle, each at its own tick of the clock."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....core.motion.train import Train
from ....core.time.timebase import Clock
from .. import sheet
from ..registers import ONE

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class OneCycle(Train):
    """The steps of one cycle, which begins at tick `origin`; each step begins at its own tick.

    The velocity of the cycle follows from `displaced`, the displacement of the target in 1/65536 step.
    """

    def __init__(self, clock: Clock, origin: int, steps: list[int], displaced: int) -> None:
        super().__init__(clock, origin)
        self.ticks = [tick - origin for tick in steps]
        self.steps, self.length = len(steps), sheet.CYCLE_TICKS
        self.speed = displaced / ONE * clock.hz / self.length

    def end(self, k: int) -> int:
        return self.origin + (self.ticks[k] if k < self.steps else self.length)

    def step_at(self, tick: int) -> int:
        return sum(at <= tick - self.origin for at in self.ticks)

    def steps_at(self, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the number of steps that have begun at each tick, counted from the start of the cycle: (n,) int64."""
        return sum(((ticks >= at).astype("i8") for at in self.ticks), ticks * 0)

    def ends(self, first: int = 0, last: int | None = None) -> NDArray[np.int64]:
        """Return the ticks at which steps first+1 ... last begin, counted from the start of the cycle: (n,) int64."""
        import numpy as np

        return np.array(self.ticks[first:last], np.int64)

    def velocities(self, since: int, to: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return `since` and the velocity of the cycle, as arrays of one element: (1,) int64, (1,) float64 steps/s."""
        import numpy as np

        return np.array([since]), np.array([self.speed])

    def pieces(self, since: int, to: int) -> int:
        """Return 1, because a cycle has one velocity."""
        return 1

    def rests(self, until: int) -> int:
        """Return the tick, counted from the start of the cycle, at which the train ends if cut off at `until` (ps)."""
        return min(max(self.clock.ticks_from(until - 1) - self.origin, 0), self.length)
