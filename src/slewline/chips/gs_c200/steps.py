"""The lines to the driver and from the machine: MOV, RAMP, DIR, CLOCK, RESET; ENABLE, EOT, HOME."""

from __future__ import annotations

from collections.abc import Mapping

from ...core.context import ChipContext
from ...core.wires.waits import until


class StepLines:
    """The outputs that a driver sees, and the inputs that hold or end a motion."""

    def __init__(self, chip: ChipContext, times_ps: Mapping[str, int]) -> None:
        self.kernel, self.reset_ps = chip.kernel, times_ps["reset"]
        self.mov, self.ramp, self.dir, self.clock = (chip.drivers[name] for name in ("mov", "ramp", "dir", "clock"))
        self.reset = chip.drivers["reset"]
        self.enable, self.eot, self.home = (chip.pins[name].net for name in ("enable", "eot", "home"))

    def rest(self) -> None:
        """Let MOV and RAMP fall together."""
        self.mov.drive(0)
        self.ramp.drive(0)

    async def pulse_reset(self) -> None:
        """Reset the driver: RESET low for 400 us."""
        self.reset.drive(0)
        await until(self.kernel, self.kernel.now + self.reset_ps)
        self.reset.drive(1)
