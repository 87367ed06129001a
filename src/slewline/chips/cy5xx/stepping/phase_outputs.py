"""The outputs to a motor: PULSE, the phases, DIRECTION and SLEW."""

from __future__ import annotations

from collections.abc import Sequence

from ....core.context import ChipContext
from ....core.motion.step_views import PatternView, PulseView
from ....core.motion.train import Playing
from ..interfaces.family_lines import line_out
from ..registers import Registers

Patterns = tuple[tuple[int, ...], ...]


class StepOutputs:
    """PULSE, phases 1 to 4, DIRECTION and SLEW.

    Args:
        patterns: the phase levels, one row per step, in clockwise order.
        high: the clocks for which PULSE is high between two steps.
    """

    def __init__(self, chip: ChipContext, registers: Registers, patterns: Patterns, high: int) -> None:
        self.chip, self.registers, self.high = chip, registers, high
        self.pulse, self.slew, self.direction = (line_out(chip, name) for name in ("pulse", "slew", "direction"))
        self.phases = tuple(line_out(chip, f"phase{n}") for n in range(1, len(patterns[0]) + 1))
        self.whole = patterns
        self.clear()

    def clear(self) -> None:
        """Return to full steps, for RESET and the I command."""
        self.walk(self.whole)

    def walk(self, patterns: Patterns) -> None:
        """Use the given phase patterns, beginning with the next step."""
        self.patterns = patterns
        self.columns = tuple(zip(*patterns, strict=True))

    def turn(self, clockwise: bool) -> None:
        """Set the direction, and output it."""
        self.registers.clockwise = clockwise
        self.direction.drive(1 if clockwise else 0)

    def show(self, levels: Sequence[int]) -> None:
        """Drive the phases to the given levels."""
        for driver, level in zip(self.phases, levels, strict=True):
            driver.drive(level)

    def off(self) -> None:
        """Switch all phases off."""
        for driver in self.phases:
            driver.deactivate()

    def step(self, steps: int) -> None:
        """Move the pattern pointer by a number of steps, positive clockwise; output the pattern it then selects."""
        registers = self.registers
        registers.phase = (registers.phase + steps) % len(self.patterns)
        self.show(self.patterns[registers.phase])

    def promise(self, playing: Playing, sign: int) -> None:
        """Promise the edges of PULSE and the phases for a step train that continues from the present pattern."""
        seen = self.chip.kernel.seen
        self.pulse.play(PulseView(playing, self.high))
        for column, driver in zip(self.columns, self.phases, strict=True):
            driver.play(PatternView(playing, column, self.registers.phase, sign, driver.at(seen)))

    def renew(self) -> None:
        """Notify all observers of PULSE and the phases: the promised train now ends at a different time."""
        self.pulse.renew()
        for driver in self.phases:
            driver.renew()
