"""When a stepper has come to rest: for `bench.run_until(motor.rests)`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.wires.pin import Condition

if TYPE_CHECKING:
    from ...core.time.kernel import Kernel
    from .stepper import Stepper


class RestCondition(Condition):
    """A stepper has come to rest: nothing changes until an input does."""

    def __init__(self, of: Stepper) -> None:
        self.of, self.text = of, f"{of.name} at rest"

    def belongs(self, kernel: Kernel) -> bool:
        """Return whether it is one of its bench."""
        return self.of.kernel is kernel

    def met(self) -> bool:
        """Return whether it rests now, and no input promises an edge."""
        run, seen = self.of._run, self.of.kernel.seen
        return run.rests(seen) and seen >= run.known_to_rest and self.of._feed.now.after(seen) is None

    def when(self) -> int | None:
        """Return when it will rest, or an instant at which to ask again (ps)."""
        return self.of._run.comes_to_rest(self.of.kernel.seen)
