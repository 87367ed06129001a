"""The start times of a chipset's cycles, which follow one another without a gap from the end of the reset."""

from __future__ import annotations

from ...core.time.timebase import Clock


class CycleClock:
    """The cycle counter.  `origin` is the crystal tick at which cycle 0 begins or will begin."""

    def __init__(self, clock: Clock, cycle_ticks: int) -> None:
        self.clock, self.cycle_ticks = clock, cycle_ticks
        self.origin = 0

    @property
    def per_s(self) -> float:
        """The number of cycles per second."""
        return self.clock.hz / self.cycle_ticks

    def tick(self, n: int) -> int:
        """Return the crystal tick at which a cycle begins."""
        return self.origin + n * self.cycle_ticks

    def ps(self, n: int) -> int:
        """Return the instant (ps) at which a cycle begins."""
        return self.clock.ps(self.origin + n * self.cycle_ticks)

    def cycle_at(self, ps: int) -> int:
        """Return the number of the last cycle that has begun by an instant (ps); negative before cycle 0."""
        return self.cycle_at_tick(self.clock.ticks_until(ps))

    def cycle_at_tick(self, tick: int) -> int:
        """Return the number of the last cycle that has begun by a tick; negative before cycle 0."""
        return (tick - self.origin) // self.cycle_ticks
