"""The CY500: the first chip of the family, which an external line may start and stop, step by step, and turn round.

Most of what it does where no source tells is inferred from its successors: see quirks.py.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..cy5xx import interpreter
from ..cy5xx.firmware import Cy5xx
from ..cy5xx.lines import line_in
from ..cy5xx.program import Moves
from ..cy5xx.supply import PowerUp
from . import profile, sheet
from .instructions import Instructions, Registers
from .motion import Motion


class Interpreter(interpreter.Interpreter):
    """Commands and the stored program; in jog mode XSS low comes before the next command."""

    lasting = frozenset(("GOSTEP", "POSITION", "ONESTEP", "UNTIL"))
    announces = False
    instructions: Instructions

    async def perform(self, code: int, values: tuple[int, ...]) -> None:
        """Call the handler of a command; the next one may look back at it."""
        registers = self.instructions.registers
        await super().perform(code, values)
        registers.last = self.rows[code].name

    async def no_instruction(self) -> None:
        """The program has come to its end without 0, which is the same."""
        self.chip.finding("end-of-program", "the program ends without 0: command mode")
        self.program.end()


class Cy500(Cy5xx):
    """A CY500 on a bench."""

    sheet = sheet.SHEET
    power_up = PowerUp(sheet.POWER_UP_RESET_PS, sheet.POWER_UP_RC_PS)
    registers_class = Registers
    instructions_class = Instructions
    interpreter_class = Interpreter
    state: Registers
