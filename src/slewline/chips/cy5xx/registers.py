"""The registers of a CY5xx: parameters survive RESET; flags and pointers are cleared by RESET or command I."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields


@dataclass
class Registers:
    """The parameters (under the manual's names), flags and pointers.

    A part adds its own flags; some of them are also cleared by events other than RESET and command I.
    `defaults` are the parameters after power-up.  `values` does not contain the position, because the axis
    counts it.
    """

    defaults: Mapping[str, int]
    values: dict[str, int] = field(init=False)
    unset: set[str] = field(init=False)  # registers that no command has loaded since power-up
    clockwise: bool = True
    phase: int = 0  # row of the phase table

    def __post_init__(self) -> None:
        self.power_up()

    def power_up(self) -> None:
        """Set every parameter to its power-up value; mark each as not set by a command."""
        self.values = {name: value for name, value in self.defaults.items() if name != "position"}
        self.unset = set(self.defaults)

    def load(self, name: str, value: int) -> None:
        """Set a parameter."""
        self.values[name] = value
        self.unset.discard(name)

    def clear(self) -> None:
        """Set each flag and pointer (a field with a default) to its default, as RESET and the I command do (s.4)."""
        for each in fields(self):
            if each.default is not MISSING:
                setattr(self, each.name, each.default)
