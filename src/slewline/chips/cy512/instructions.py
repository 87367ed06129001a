"""Commands of the CY512 that differ from the family's: one method per command, found by the name of its row."""

from __future__ import annotations

from collections.abc import Iterable

from ..cy5xx import instructions
from ..cy5xx.stepping import sloped
from . import sheet


class Instructions(sloped.Instructions, instructions.Instructions):
    """Handlers of the CY512's own commands."""

    in_slope = "the factor divides the rates of the ramps, too"

    async def do_expend(self, delay: int) -> None:
        """X: pause for a number of milliseconds (at 11 MHz)."""
        await self.pause("X", delay)

    def do_slope(self, slope: int) -> None:
        """S: load the slope; any value except 0 sets FACTOR to 1."""
        super().do_slope(slope)
        if slope:
            self.registers.load("factor", 1)

    def do_offset(self, offset: int) -> None:
        """O: output a phase pattern: 0 to 3 are full steps; 4 to 7 are the half steps that follow 0 to 3."""
        if offset > sheet.OFFSET.high:
            self.chip.finding("offset", f"O {offset} is ignored; allowed: patterns 0 to {sheet.OFFSET.high}")
            return
        row = 2 * (offset % 4) + offset // 4  # of the half steps
        self.registers.phase = row if self.registers.half else row // 2
        self.outputs.show(sloped.half_steps(self.chip.options.inferred)[row])

    def odd(self) -> Iterable[tuple[bool, str, str]]:
        """Yield a tuple for each possible problem of a motion: whether it is present, its code, and its text."""
        rate, factor = (self.registers.values[name] for name in ("rate", "factor"))
        yield rate == 0, "range", "R 0 is outside 1 to 255: its rate is a little below that of R 1"
        yield factor == 0, "range", "F 0 is outside 1 to 255: it divides by 256"
