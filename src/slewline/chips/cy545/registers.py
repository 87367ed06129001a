"""The registers of a CY545 other than its position: parameters, mode, pointer and direction."""

from __future__ import annotations

from dataclasses import dataclass

from ..cy5xx import registers
from . import sheet


@dataclass
class Registers(registers.Registers):
    """The registers; RESET and I set all of them to their power-up values (ch.10)."""

    clockwise: bool = False  # all pins are high after reset, CCW among them
    directed: bool = False  # a command has set the direction since reset
    continuous: bool = False  # True after C, until the next motion

    def power_up(self) -> None:
        """Set every register to its power-up value; for this chip, all these values are known."""
        super().power_up()
        self.unset.clear()

    def clear(self) -> None:
        """Reset the registers, for RESET and I."""
        super().clear()
        self.power_up()

    def has(self, bit: int) -> bool:
        """Return whether a bit of the mode register is set; the bit is one of the constants MB_... of the sheet."""
        return bool(self.values["mode"] & bit)

    @property
    def ascii(self) -> bool:
        """True if commands are in ASCII."""
        return self.has(sheet.MB_ASCII)

    @property
    def pointer(self) -> int:
        """The memory pointer; while a program runs, it is the program counter."""
        return self.values["pointer"]

    @pointer.setter
    def pointer(self, address: int) -> None:
        self.values["pointer"] = address % sheet.MEMORY_BYTES
