"""The lines of a chip by the names that the family has for them; one that a part lacks is there, but leads nowhere."""

from __future__ import annotations

from ....core.context import ChipContext
from ....core.wires.net import Driver, Net


def line_in(chip: ChipContext, name: str, level: int = 1) -> Net:
    """Return the net of an input; of one that the part lacks, a net that always has a level, and is never active."""
    if name in chip.pins:
        return chip.pins[name].net
    return Net(chip.kernel, f"{chip.name}.({name})", tie=level, active=1 - level)


def line_out(chip: ChipContext, name: str) -> Driver:
    """Return the driver of an output; of one that the part lacks, one of a net that is not seen."""
    if name in chip.drivers:
        return chip.drivers[name]
    return Driver(Net(chip.kernel, f"{chip.name}.({name})", active=0), chip.name)
