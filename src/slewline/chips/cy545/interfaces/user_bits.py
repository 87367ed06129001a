"""User bits and bits of the data bus: latches with weak high drive; a high latch makes its pin an input too (ch.6).

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
        """Set all bits high, and FPL and HP_SEL to rest, for RESET and I."""
        self.latch = self.bus_latch = 0xFF
        self.flow = self.cts = self.selected = 1
        self.show()

    # ------------------------------------------------------------------------------------------------ other functions
    def fpl(self, level: int) -> None:
        """Set FPL, low while there is output for the host of the parallel port."""
        self.flow = level
        self.show()

    def clear_to_send(self, level: int) -> None:
        """Set CTS, low while the host of the serial side may send."""
        self.cts = level
        if self.shared == "CTS":
            self.show()

    def hp_sel(self, level: int) -> None:
        """Set HP_SEL, low while the display is selected."""
        self.selected = level
        self.show()

    @property
    def sixth(self) -> int:
        """The level of USRB6: FPL, CTS or the latch."""
        return {"FPL": self.flow, "CTS": self.cts}.get(self.shared, self.latch >> 6 & 1)

    @property
    def shared(self) -> str:
        """Present other function of USRB6; empty while it is a user bit."""
        has = self.registers.has
        if has(sheet.MB_PARALLEL) and not has(sheet.MB_HP):
            return "FPL"
        return "CTS" if has(sheet.MB_CTS) else ""

    def show(self) -> None:
        """Drive the pins from the latches: low, or released, so that others may pull a pin low."""
        levels = self.latch & FREE | self.sixth << 6 | (self.latch >> 7 & self.selected) << 7
        for n, driver in enumerate(self.drivers):
            level = None if levels >> n & 1 else 0
            if driver.level != level or driver.pending:
                driver.drive(level)

    # ---------------------------------------------------------------------------------------------------- the data bus
    def show_bus(self) -> None:
        """Drive the data bus from its latch: its zeros are driven, the other bits are open."""
        zeros = ~self.bus_latch & 0xFF
        self.chip.bus_driver.drive((zeros, 0) if zeros else None)

    def bus_used(self) -> None:
        """Open the latch of the bus again after a byte has been on it (quirk CY545-UND-BIT-BUS)."""
        self.bus_latch = 0xFF

    # ----------------------------------------------------------------------------------------------------- as read
    @property
    def user(self) -> int:
        """The levels of USRB0 to USRB7."""
        return sum(1 << n for n, net in enumerate(self.pins) if net.level != 0)

    @property
    def word(self) -> int:
        """Answer to ? B: the bits of the data bus above the user bits."""
        return self.chip.bus.byte << 8 | self.user

    def act(self, argument: int) -> None:
        """B: apply an argument to the latches, all at one instant."""
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
        """B below 40: apply an argument to one bit, of the user bits or of the data bus."""
        bit, high = 1 << (argument & 7), not argument & sheet.CLEAR_BIT
        if argument & sheet.DATA_BUS:
            self.bus_latch = self.bus_latch | bit if high else self.bus_latch & ~bit
            self.show_bus()
        else:
            self.latch = self.latch | bit if high else self.latch & ~bit

    def nets(self, argument: int) -> tuple[Net, ...]:
        """Return the nets that `matches` samples for an argument."""
        if argument & 0xC0:
            return tuple(self.pins[:6])
        return (self.chip.bus,) if argument & sheet.DATA_BUS else (self.pins[argument & 7],)

    def single(self, argument: int, match: bool) -> tuple[str, int] | None:
        """Return the pin and the level that make the pins match an argument, or not; None if there are several pins."""
        if argument & 0xC0 or argument & sheet.DATA_BUS:
            return None
        return f"usrb{argument & 7}", int(bool(argument & sheet.CLEAR_BIT) is not match)

    def matches(self, argument: int) -> bool:
        """T, W and H: return whether the pins match an argument."""
        operand, group = argument & FREE, self.user & FREE
        match sheet.MATCHES.get(argument & 0xC0):
            case "equal":
                return group == operand
            case "all":
                return group & operand == operand
            case "any":
                return bool(group & operand)
        word = self.chip.bus.byte if argument & sheet.DATA_BUS else self.user
        return bool(word >> (argument & 7) & 1) is not bool(argument & sheet.CLEAR_BIT)
