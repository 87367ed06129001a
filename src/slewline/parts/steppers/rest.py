"""When a stepper has come to rest: for `bench.run_until(motor.rests)`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.wires.pin import Condition

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from .motor_run import Run


class RestCondition(Condition):
    """A stepper has come to rest: nothing changes until an input does."""

    def __init__(self, name: str, kernel: Kernel, run: Run) -> None:
        self.kernel, self.run, self.text = kernel, run, f"{name} at rest"

    def belongs(self, kernel: Kernel) -> bool:
        """Return whether it is one of its bench."""
        return self.kernel is kernel

    def met(self) -> bool:
        """Return whether it rests now, and no input promises an edge."""
        run, seen = self.run, self.kernel.seen
        return run.rests(seen) and seen >= run.known_to_rest and run.feed.now.look_after(seen) is None

    def when(self) -> int | None:
        """Return when it will rest, or an instant at which to ask again (ps)."""
        return self.run.comes_to_rest(self.kernel.seen)
