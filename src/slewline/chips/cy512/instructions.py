"""What the commands of the CY512 do, where it is not what the family does: one method a row, found by its name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ..cy5xx import instructions, registers
from . import sheet


@dataclass
class Registers(registers.Registers):
    """The registers of the family, and the mode of H."""

    half: bool = False


class Instructions(instructions.Instructions):
    """The handlers that the CY512 has for itself."""

    registers: Registers
    request_ends_wait = False

    def do_athome(self) -> None:
        self.declare(0, "A")

    def do_doitnow(self) -> None:
        self.program.begin(0)

    def do_til(self) -> None:
        if self.dowhile.level == 0:
            self.program.begin(0)

    async def do_expend(self, delay: int) -> None:
        await self.pause("X", delay)

    def do_factor(self, factor: int) -> None:
        if self.registers.values["slope"]:
            self.chip.finding("factor-in-slope", f"F {factor} behind S: it divides the rates of the ramps, too")
        self.registers.load("factor", factor)

    def do_slope(self, slope: int) -> None:
        super().do_slope(slope)
        if slope:
            self.registers.load("factor", 1)

    def do_halfstep(self) -> None:
        if not self.registers.half:
            self.registers.half = True
            self.registers.phase *= 2
            self.outputs.walk(sheet.PHASES)

    def do_offset(self, offset: int) -> None:
        if offset > sheet.OFFSET.high:
            self.chip.finding("offset", f"O {offset}: there are patterns 0 to {sheet.OFFSET.high}; ignored")
            return
        row = 2 * (offset % 4) + offset // 4  # of the half steps
        self.registers.phase = row if self.registers.half else row // 2
        self.outputs.show(sheet.PHASES[row])

    def odd(self) -> Iterable[tuple[bool, str, str]]:
        """Yield what a motion should not find: whether it does, the code and the text of a finding."""
        rate, factor = (self.registers.values[name] for name in ("rate", "factor"))
        yield rate == 0, "range", "R 0 is outside 1 to 255: a little slower than R 1"
        yield factor == 0, "range", "F 0 is outside 1 to 255: it divides by 256"
