"""Another bench in the place of the present one, where nothing but the drive uses it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...bench.rewinding import take_over

if TYPE_CHECKING:
    from ...bench import Bench
    from ..state import DriveState


class Alone:
    """Exchanges of a drive whose bench nothing else uses: `drive.bench` is another one then."""

    def __init__(self, state: DriveState) -> None:
        self.state = state

    def exchange(self, bench: Bench, since_ps: int) -> None:
        """Go on with another bench."""
        take_over(bench, self.state.bench)

    def listen(self, bench: Bench) -> None:
        """Do nothing: nobody hears what a bench does."""

    def forget(self, before_ps: int) -> None:
        """Do nothing: nothing is kept."""
