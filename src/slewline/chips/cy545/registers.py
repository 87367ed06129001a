"""What a CY545 remembers beside its position: parameters, mode and pointer, the direction."""

from __future__ import annotations

from dataclasses import dataclass

from ..cy5xx import registers
from . import sheet


@dataclass
class Registers(registers.Registers):
    """The registers; all of them have their values at power-up after RESET and I, too (ch.10)."""

    clockwise: bool = False  # all pins are high after reset, CCW among them
    directed: bool = False  # a command has set the direction since reset
    continuous: bool = False  # C has been given for the next motion

    def power_up(self) -> None:
        """Give every register its value after power-up, which is known of all of them."""
        super().power_up()
        self.unset.clear()

    def clear(self) -> None:
        """RESET and I."""
        super().clear()
        self.power_up()

    def has(self, bit: int) -> bool:
        """Return whether a bit of the mode register, one of MB_..., is set."""
        return bool(self.values["mode"] & bit)

    @property
    def ascii(self) -> bool:
        """Are commands in ASCII?"""
        return self.has(sheet.MB_ASCII)

    @property
    def pointer(self) -> int:
        """The memory pointer, which is the counter of a program that runs."""
        return self.values["pointer"]

    @pointer.setter
    def pointer(self, address: int) -> None:
        self.values["pointer"] = address % sheet.MEMORY_BYTES
