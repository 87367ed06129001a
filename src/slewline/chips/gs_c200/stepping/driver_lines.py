"""The lines to the driver and from the machine, and the user lines: UI1 to UI3 and UO1 to UO3."""

from __future__ import annotations

from collections.abc import Mapping

from ....core.context import ChipContext
from ....core.wires.waits import until


class StepLines:
    """The outputs to a driver, and the inputs that delay or end a motion."""

    def __init__(self, chip: ChipContext, times_ps: Mapping[str, int]) -> None:
        self.kernel, self.reset_ps = chip.kernel, times_ps["reset"]
        self.mov, self.ramp, self.dir, self.clock = (chip.drivers[name] for name in ("mov", "ramp", "dir", "clock"))
        self.reset = chip.drivers["reset"]
        self.enable, self.eot, self.home = (chip.pins[name].net for name in ("enable", "eot", "home"))

    def rest(self) -> None:
        """Lower MOV and RAMP together."""
        self.mov.deactivate()
        self.ramp.deactivate()

    async def pulse_reset(self) -> None:
        """Pull the driver's RESET line low for 400 µs, and wait; K may end the waiting program, but not the pulse."""
        end = self.kernel.now + self.reset_ps
        self.reset.strobe(self.kernel.now, end)
        await until(self.kernel, end)


class UserLines:
    """A program's inputs and outputs other than those for the motor."""

    def __init__(self, chip: ChipContext) -> None:
        self.inputs = tuple(chip.pins[f"ui{n}"].net for n in (1, 2, 3))
        self.outputs = tuple(chip.drivers[f"uo{n}"] for n in (1, 2, 3))

    def read_inputs(self) -> int:
        """Return UI1 + 2 UI2 + 4 UI3; an open input reads 1."""
        return sum((net.level != 0) << n for n, net in enumerate(self.inputs))

    def read_outputs(self) -> int:
        """Return UO1 + 2 UO2 + 4 UO3."""
        return sum((driver.net.level == 1) << n for n, driver in enumerate(self.outputs))

    def clear(self) -> None:
        """Drive all user outputs low."""
        for driver in self.outputs:
            driver.drive(0)
