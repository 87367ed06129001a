"""The supply: its effects on the module, and checks of its voltage and loads against the sheet's limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from ...core.context import ChipContext


class Supplied(NamedTuple):
    """A module's actions at power-up and power-down."""

    powered_up: Callable[[], None]  # starts again, with program memory, registers and counter cleared
    powered_off: Callable[[], None]  # ends all work, and releases every output


class Supply:
    """The supply pins, and the pins that supply other parts.

    Args:
        volts: the minimum and maximum supply voltages.
        loads: the maximum total current (mA) that may be drawn from each group of pins.
    """

    def __init__(
        self, chip: ChipContext, supplied: Supplied, volts: tuple[float, float], loads: Mapping[tuple[str, ...], float]
    ) -> None:
        self.chip, self.supplied, self.volts, self.loads = chip, supplied, volts, loads
        self.powered = False

    def switch(self, on: bool) -> None:
        """Switch the supply on or off; do nothing if it is already in that state."""
        if on == self.powered:
            return
        self.chip.switched(on)
        self.powered = on
        # all other events at this instant come first, steps included
        kernel = self.chip.kernel
        kernel.call_at(kernel.now, self.supplied.powered_up if on else self.supplied.powered_off)
        kernel.settle()

    def check(self) -> None:
        """Report a supply voltage or loads beyond the limits."""
        options, (low, high) = self.chip.options, self.volts
        if not low <= options.supply <= high:
            self.chip.finding("supply", f"{options.supply:g} V; the module needs {low} to {high} V")
        for pins, limit in self.loads.items():
            drawn = sum(options.load[pin] for pin in pins)
            if drawn > limit:
                self.chip.finding("load", f"{drawn:g} mA from {' and '.join(pins)}; allowed up to {limit} mA")
