"""The condition that a stepper has come to rest, for `bench.run_until(motor.rests)`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.wires.pin import Condition

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from .motor_run import Run


class RestCondition(Condition):
    """The condition that a stepper has come to rest: nothing changes until an input changes."""

    def __init__(self, name: str, kernel: Kernel, run: Run) -> None:
        self.kernel, self.run, self.text = kernel, run, f"{name} at rest"

    def belongs(self, kernel: Kernel) -> bool:
        """Return whether the condition belongs to the bench with the given kernel."""
        return self.kernel is kernel

    def met(self) -> bool:
        """Return whether the motor is at rest now, and no input promises an edge."""
        run, seen = self.run, self.kernel.seen
        return run.rests(seen) and seen >= run.known_to_rest and run.feed.now.look_after(seen) is None

    def when(self) -> int | None:
        """Return the instant (ps) at which the motor will be at rest, or an instant at which to query again."""
        return self.run.comes_to_rest(self.kernel.seen)
