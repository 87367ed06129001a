"""What an axis of the slow twin plays: the steps of one cycle, each at its own tick."""

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
    """The steps of a cycle that begins at a tick, each at its own, and how far they displace the position."""

    def __init__(self, clock: Clock, origin: int, steps: list[int], displaced: int) -> None:
        super().__init__(clock, origin)
        self.ticks = [tick - origin for tick in steps]
        self.steps, self.length = len(steps), sheet.CYCLE_TICKS
        self.speed = displaced / ONE * clock.hz / self.length

    def begin(self, k: int) -> int:
        return self.origin + (self.ticks[k] if k < self.steps else self.length)

    def begun_by(self, tick: int) -> int:
        return sum(at <= tick - self.origin for at in self.ticks)

    def begun_counts(self, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
        return sum(((ticks >= at).astype("i8") for at in self.ticks), ticks * 0)

    def begin_ticks(self, first: int = 0, last: int | None = None) -> NDArray[np.int64]:
        import numpy as np

        return np.array(self.ticks[first:last], np.int64)

    def velocities(self, since: int, to: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        import numpy as np

        return np.array([since]), np.array([self.speed])

    def pieces(self, since: int, to: int) -> int:
        return 1

    def rests(self, until: int) -> int:
        return min(max(self.clock.ticks_from(until - 1) - self.origin, 0), self.length)
