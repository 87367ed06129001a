"""The lines to the driver and from the machine: MOV, RAMP, DIR, CLOCK; ENABLE, EOT, HOME."""

from __future__ import annotations

from ...core.chip import Chip


class StepLines:
    """The outputs that a driver sees, and the inputs that hold or end a motion."""

    def __init__(self, chip: Chip) -> None:
        self.mov, self.ramp, self.dir, self.clock = (chip.drivers[name] for name in ("mov", "ramp", "dir", "clock"))
        self.enable, self.eot, self.home = (chip.pins[name].net for name in ("enable", "eot", "home"))

    def rest(self) -> None:
        """Let MOV and RAMP fall together."""
        self.mov.drive(0)
        self.ramp.drive(0)
