"""A chip's lines by their family names; a line that a part lacks is represented by an unconnected net."""

from __future__ import annotations

from ....core.context import ChipContext
from ....core.wires.net import Driver, Net


def line_in(chip: ChipContext, name: str, level: int = 1) -> Net:
    """Return the net of an input; if the part lacks it, return a net that stays at its inactive level, `level`."""
    if name in chip.pins:
        return chip.pins[name].net
    return Net(chip.kernel, f"{chip.name}.({name})", tie=level, active=1 - level)


def line_out(chip: ChipContext, name: str) -> Driver:
    """Return the driver of an output; if the part lacks it, return the driver of an unconnected net."""
    if name in chip.drivers:
        return chip.drivers[name]
    return Driver(Net(chip.kernel, f"{chip.name}.({name})", active=0), chip.name)
