"""The CY500, the first of its family: input lines can start, stop and reverse its motor, and trigger each step.

Where no source describes its behaviour, most of it is inferred from its successors: see quirks.py.
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
    """The executor of host commands and programs; in jog mode, XSS low has priority over the next command."""

    lasting = frozenset(("GOSTEP", "POSITION", "ONESTEP", "UNTIL"))
    announces = False
    instructions: Instructions

    async def next_byte(self) -> int:
        """Return the next byte from the host.  In jog mode, the motor first runs for as long as XSS is low."""
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
        """Call the handler of a command, and record the command for the handler of the next command."""
        registers = self.instructions.registers
        await super().perform(code, values)
        registers.last = self.rows[code].name

    async def no_instruction(self, at: int) -> None:
        """End a program that lacks its final 0, as if the 0 were there."""
        self.chip.finding("end-of-program", "the program ends without command 0; the chip returns to command mode")
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
        """Return the code and text of a finding for each unfinished input: a line, or a P that waits for its G."""
        found, state = super().left_over(), self.state
        if state.waits:
            part = self.sheet.part.upper()
            text = f"P {state.target} is not followed by G; on the {part} P only sets the target: send G"
            found.append(("no-go", text))
        return found

    def _law(self) -> Law:
        """Return the step periods by rate parameter, and the parameter at which ramps start."""
        return sloped.law(self.options.inferred, PERIODS)

    def phase_patterns(self) -> Patterns:
        """Return the phase levels in full steps, one row per step, in clockwise order."""
        return sloped.full_steps(self.options.inferred)
