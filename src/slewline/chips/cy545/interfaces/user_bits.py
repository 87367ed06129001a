"""User bits and data bus bits: latches with a weak high level, so a pin whose latch is high is also an input (ch.6).

USRB6 is FPL while output goes to the parallel port, otherwise CTS if the mode register selects it, otherwise a user
bit; USRB7 is HP_SEL while the display is written.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .. import sheet

if TYPE_CHECKING:
    from ....core.context import ChipContext
    from ....core.wires.net import Net
    from ..registers import Registers

FREE = 0x3F  # user bits that have no other function


class UserBits:
    """The latches, and the only writer of the pins USRB0 to USRB7."""

    def __init__(self, chip: ChipContext, registers: Registers) -> None:
        self.chip, self.registers = chip, registers
        self.pins = [chip.pins[f"usrb{n}"].net for n in range(8)]
        self.drivers = [chip.drivers[f"usrb{n}"] for n in range(8)]
        self.clear()

    def clear(self) -> None:
        """Set all bits high, and FPL and HP_SEL to their idle levels, for RESET and the command I."""
        self.latch = self.bus_latch = 0xFF
        self.flow = self.cts = self.selected = 1
        self.show()

    # ------------------------------------------------------------------------------------------------ other functions
    def fpl(self, level: int) -> None:
        """Set FPL, which is low while there is output for the parallel host."""
        self.flow = level
        self.show()

    def clear_to_send(self, level: int) -> None:
        """Set CTS, which is low while the serial host may send."""
        self.cts = level
        if self.shared == "CTS":
            self.show()

    def hp_sel(self, level: int) -> None:
        """Set HP_SEL, which is low while the display is selected."""
        self.selected = level
        self.show()

    @property
    def sixth(self) -> int:
        """The level to show on USRB6: that of FPL, of CTS or of its latch."""
        return {"FPL": self.flow, "CTS": self.cts}.get(self.shared, self.latch >> 6 & 1)

    @property
    def shared(self) -> str:
        """The function that USRB6 has at present, "FPL" or "CTS"; empty while it is a user bit."""
        has = self.registers.has
        if has(sheet.MB_PARALLEL) and not has(sheet.MB_HP):
            return "FPL"
        return "CTS" if has(sheet.MB_CTS) else ""

    def show(self) -> None:
        """Drive the pins from the latches: low for 0; released for 1, so that other outputs may pull the pin low."""
        levels = self.latch & FREE | self.sixth << 6 | (self.latch >> 7 & self.selected) << 7
        for n, driver in enumerate(self.drivers):
            level = None if levels >> n & 1 else 0
            if driver.level != level or driver.pending:
                driver.drive(level)

    # ---------------------------------------------------------------------------------------------------- the data bus
    def show_bus(self) -> None:
        """Drive the data bus from its latch: zeros are driven low, the other bits are left open."""
        zeros = ~self.bus_latch & 0xFF
        self.chip.bus_driver.drive((zeros, 0) if zeros else None)

    def bus_used(self) -> None:
        """Set the data bus latch to all ones, because a byte has been on the bus (quirk CY545-UND-BIT-BUS)."""
        self.bus_latch = 0xFF

    # ----------------------------------------------------------------------------------------------------- as read
    @property
    def user(self) -> int:
        """The levels of USRB0 to USRB7, as bits 0 to 7; an open pin reads as 1."""
        return sum(1 << n for n, net in enumerate(self.pins) if net.level != 0)

    @property
    def word(self) -> int:
        """The answer to the query "? B": the data bus bits in the high byte, the user bits in the low byte."""
        return self.chip.bus.byte << 8 | self.user

    def act(self, argument: int) -> None:
        """B: carry out the operation that an argument encodes; all pins change at the same instant."""
        operand = argument & FREE
        match sheet.OPCODES.get(argument & 0xC0):
            case "write":
                self.latch = self.latch & ~FREE | operand
            case "and":
                self.latch &= operand | ~FREE & 0xFF
            case "or":
                self.latch |= operand
            case _:
                self.act_one(argument)
        self.show()

    def act_one(self, argument: int) -> None:
        """B with an argument below 40 (hex): set or clear a single bit, either a user bit or a data bus bit."""
        bit, high = 1 << (argument & 7), not argument & sheet.CLEAR_BIT
        if argument & sheet.DATA_BUS:
            self.bus_latch = self.bus_latch | bit if high else self.bus_latch & ~bit
            self.show_bus()
        else:
            self.latch = self.latch | bit if high else self.latch & ~bit

    def nets(self, argument: int) -> tuple[Net, ...]:
        """Return the nets that `matches` samples for the given argument."""
        if argument & 0xC0:
            return tuple(self.pins[:6])
        return (self.chip.bus,) if argument & sheet.DATA_BUS else (self.pins[argument & 7],)

    def single(self, argument: int, match: bool) -> tuple[str, int] | None:
        """Return the one user pin that an argument selects, and the level at which `matches` returns `match`.

        Return None if the argument selects several pins, or the data bus.
        """
        if argument & 0xC0 or argument & sheet.DATA_BUS:
            return None
        return f"usrb{argument & 7}", int(bool(argument & sheet.CLEAR_BIT) is not match)

    def matches(self, argument: int) -> bool:
        """T, W and H: return whether the levels of the pins match an argument."""
        kind = sheet.MATCHES.get(argument & 0xC0)
        if kind is None:
            bit = argument & 7
            high = self.chip.bus.byte >> bit & 1 if argument & sheet.DATA_BUS else self.pins[bit].level != 0
            return bool(high) is not bool(argument & sheet.CLEAR_BIT)
        operand, group = argument & FREE, self.user & FREE
        if kind == "equal":
            return group == operand
        return group & operand == operand if kind == "all" else bool(group & operand)
