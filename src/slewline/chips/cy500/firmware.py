"""The CY500: the first chip of the family; an external line may start and stop it, step by step, and reverse it.

Most of its behaviour without a source is inferred from its successors: see quirks.py.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..cy5xx import interpreter
from ..cy5xx.firmware import Cy5xx
from ..cy5xx.sheet import POWER_UP_RC_PS, POWER_UP_RESET_PS
from ..cy5xx.stepping import sloped
from ..cy5xx.stepping.phase_outputs import Patterns
from ..cy5xx.stepping.slope import Law
from ..cy5xx.supply import PowerUp
from .instructions import Instructions, Registers
from .motion import Motion
from .sheet import PERIODS, SHEET

if TYPE_CHECKING:
    from .twin import Stepwise


class Interpreter(interpreter.Interpreter):
    """Commands and the stored program; in jog mode, XSS low has priority over the next command."""

    lasting = frozenset(("GOSTEP", "POSITION", "ONESTEP", "UNTIL"))
    announces = False
    instructions: Instructions

    async def next_byte(self) -> int:
        """Return the next byte of the host.  In jog mode the motor runs first for as long as XSS is low."""
        port, program, registers, xss = self.port, self.program, self.instructions.registers, self.instructions.dowhile
        while True:
            jogs = registers.jog and self.decoder.at_letter and not program.entering
            port.others = (xss.when_active,) if jogs else ()
            if not (jogs and xss.is_active):
                byte = await super().next_byte()
                if byte >= 0:
                    return byte
            self.chip.sync()
            port.close()
            await program.motion.move(1, self.instructions.sign, "J")
            port.open()

    async def perform(self, code: int, values: tuple[int, ...]) -> None:
        """Call the handler of a command, and keep the command for the next handler."""
        registers = self.instructions.registers
        await super().perform(code, values)
        registers.last = self.rows[code].name

    async def no_instruction(self, at: int) -> None:
        """End a program that has no 0 at its end, as if it had one."""
        self.chip.finding("end-of-program", "the program ends without 0; the chip returns to command mode")
        self.program.end()


class Cy500(Cy5xx):
    """A CY500 on a bench."""

    sheet = SHEET
    _power_up = PowerUp(POWER_UP_RESET_PS, POWER_UP_RC_PS)
    _crystal_where = "the article"
    state: Registers
    _registers_class = Registers
    _instructions_class = Instructions
    _interpreter_class = Interpreter
    _motion_class = Motion

    def _twin_class(self) -> type[Stepwise]:
        from .twin import Stepwise

        return Stepwise

    def left_over(self) -> list[tuple[str, str]]:
        """Return the unfinished input of a host: a line, and a P that waits for its G."""
        found, state = super().left_over(), self.state
        if state.waits:
            part = self.sheet.part.upper()
            found.append(("no-go", f"P {state.target} has no G after it; on the {part} P only sets the target: send G"))
        return found

    def _law(self) -> Law:
        """Return the periods by rate parameter, and the start of ramps."""
        return sloped.law(self.options.inferred, PERIODS)

    def phase_patterns(self) -> Patterns:
        """Return the levels of the phases in full steps, one row per step, in clockwise order."""
        return sloped.full_steps(self.options.inferred)
