"""The registers of a GS-C module: speeds, and the faults that F reports.  They are lost without supply."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Registers:
    """S, T and R under the sheet's names, and the faults, each of which F reports once."""

    start_stop: int = 0  # units of 10 steps/s; 0: never set
    top_speed: int = 0
    ramp: int = 0  # steps
    overflow: bool = False  # E5 is to be reported
    failed: bool = False  # E6 is to be reported (option early_y)

    @property
    def speeds(self) -> tuple[int, int, int]:
        """The values of S, T and R."""
        return self.start_stop, self.top_speed, self.ramp

    def clear(self) -> None:
        """Clear all registers, as a loss of supply does."""
        vars(self).update(vars(Registers()))
