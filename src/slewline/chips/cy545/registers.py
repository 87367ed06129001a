"""The registers of a CY545 other than its position: parameters, mode, memory pointer and direction."""

from __future__ import annotations

from dataclasses import dataclass

from ..cy5xx import registers
from . import sheet


@dataclass
class Registers(registers.Registers):
    """The registers of a CY545; RESET and the I command set all of them to their power-up values (ch.10)."""

    clockwise: bool = False  # all pins are high after reset, CCW among them
    directed: bool = False  # a command has set the direction since reset
    continuous: bool = False  # True after C, until the next motion

    def power_up(self) -> None:
        """Set every register to its power-up value; on this chip these values are defined, so none counts as unset."""
        super().power_up()
        self.unset.clear()

    def clear(self) -> None:
        """Set every register to its power-up value, for RESET and the command I."""
        super().clear()
        self.power_up()

    def has(self, bit: int) -> bool:
        """Return whether a mode register bit is set; `bit` is one of the MB_... constants in sheet.py."""
        return bool(self.values["mode"] & bit)

    @property
    def ascii(self) -> bool:
        """True while commands are in ASCII, not in binary."""
        return bool(self.values["mode"] & sheet.MB_ASCII)

    @property
    def pointer(self) -> int:
        """The memory pointer, which is the program counter while a program runs."""
        return self.values["pointer"]

    @pointer.setter
    def pointer(self, address: int) -> None:
        self.values["pointer"] = address % sheet.MEMORY_BYTES
