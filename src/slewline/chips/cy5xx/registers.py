"""What a CY5xx remembers: parameters, which RESET leaves alone, flags and pointers, which RESET and I clear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields


@dataclass
class Registers:
    """Parameters by the manual's names, flags and pointers.  A part adds flags of its own, each with what clears it.

    `defaults` are the parameters after power-up.  The position is not among `values`: it is the axis that counts it.
    """

    defaults: Mapping[str, int]
    values: dict[str, int] = field(init=False)
    unset: set[str] = field(init=False)  # registers that no command has loaded since power-up
    clockwise: bool = True
    phase: int = 0  # row of the phase table

    def __post_init__(self) -> None:
        self.power_up()

    def power_up(self) -> None:
        """Give every parameter its value after power-up; none of them has been set by a command."""
        self.values = {name: value for name, value in self.defaults.items() if name != "position"}
        self.unset = set(self.defaults)

    def load(self, name: str, value: int) -> None:
        """Set a parameter."""
        self.values[name] = value
        self.unset.discard(name)

    def clear(self) -> None:
        """Set all flags and pointers, which are the fields with a default, to what RESET and I make of them (s.4)."""
        for each in fields(self):
            if each.default is not MISSING:
                setattr(self, each.name, each.default)
