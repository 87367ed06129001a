"""The user inputs UI1 to UI3, and the user outputs UO1 to UO3."""

from __future__ import annotations

from ...core.context import ChipContext


class UserLines:
    """What a program reads and drives besides the motor."""

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
        """Drive all outputs low."""
        for driver in self.outputs:
            driver.drive(0)
