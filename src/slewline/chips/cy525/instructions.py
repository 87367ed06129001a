"""CY525 commands beyond those of the family: one method for each, named after it (do_delay for DELAY)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ..cy5xx import instructions, registers


@dataclass
class Registers(registers.Registers):
    """The family's registers, and the flag that H sets."""

    continuous: bool = False  # the next motion runs until aborted


class Instructions(instructions.Instructions):
    """Handlers of the CY525's own commands."""

    registers: Registers

    def do_absolute(self, position: int) -> None:
        """A: set the position, 0 to 65,535."""
        self.declare(position, f"A {position}")

    async def do_delay(self, delay: int) -> None:
        """D: pause for a number of milliseconds (at 11 MHz)."""
        await self.pause("D", delay)

    def do_firstrate(self, rate: int) -> None:
        """F: load the rate parameter of the first step."""
        self.registers.load("firstrate", rate)

    def do_divisor(self, divisor: int) -> None:
        """Z: load the divisor of the slope."""
        self.registers.load("divisor", divisor)

    def do_haltmode(self) -> None:
        """H: make the next motion continuous."""
        self.registers.continuous = True

    def do_execute(self) -> None:
        """X: run the program from its start."""
        self.program.begin(0)

    def do_til(self, target: int) -> None:
        """T: if DOWHILE is low, branch to a program address or, as a host command, start the program there."""
        program = self.program
        target = program.resolved(target)
        if self.dowhile.is_active:
            if program.running:
                program.pc = target
            else:
                self.chip.finding("til-command", "T as a host command starts the program at the target of T")
                program.begin(target)

    async def do_offset(self, offset: int) -> None:
        """O: output a phase pattern, 0 to 3; above 3, switch the phases off; above 127, output a pulse first."""
        outputs = self.outputs
        if offset <= 3:
            self.registers.phase = offset
            outputs.show(outputs.patterns[offset])
            return
        if offset > 127:
            outputs.pulse.activate()
            await self.chip.ticks(self.ticks["phase_pulse"])
            outputs.pulse.deactivate()
        outputs.off()

    def odd(self) -> Iterable[tuple[bool, str, str]]:
        slope, rate, first, divisor = (
            self.registers.values[name] for name in ("slope", "rate", "firstrate", "divisor")
        )
        yield rate < first, "rate-below-firstrate", "R is below F: the whole move runs at F"
        slow = "rates 0, 1 and 2 are not fixed by the manual: 275, 283, 292 steps/s"
        yield min(rate, first) <= 2, "slow-rate", slow
        yield slope == 0, "range", "S 0 is outside 1 to 255: its ramp is a little slower than that of S 1"
        yield divisor == 0, "range", "Z 0 is outside 1 to 255: it divides by 256"
