"""The CY512: what is known of it as differences from the CY525, which fits its socket.

Where no source says anything see quirks.py.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..cy5xx import interpreter
from ..cy5xx.firmware import Cy5xx
from ..cy5xx.program import Moves
from ..cy5xx.slope import Law
from ..cy5xx.steps import Patterns
from ..cy5xx.supply import PowerUp
from ..cy525.sheet import POWER_UP_RC_PS, POWER_UP_RESET_PS
from .instructions import Instructions, Registers
from .motion import Motion
from .sheet import PERIODS, PHASES, SHEET


class Interpreter(interpreter.Interpreter):
    """A program of the CY512 runs by itself: READY says nothing of its motions, and no live commands come."""

    lasting = frozenset(("GO", "POSITION", "EXPEND", "UNTIL", "WAIT"))
    announces = False


class Cy512(Cy5xx):
    """A CY512 on a bench."""

    sheet = SHEET
    power_up = PowerUp(POWER_UP_RESET_PS, POWER_UP_RC_PS)
    crystal_where = "the CY525"
    registers_class = Registers
    instructions_class = Instructions
    interpreter_class = Interpreter
    live_commands = False

    def clocks(self) -> dict[str, int]:
        """The times of the sheet, those that the option `inferred` replaces as it says."""
        inferred = self.options.inferred
        return {name: inferred.get(name, ticks) for name, ticks in super().clocks().items()}

    def patterns(self) -> Patterns:
        """Return the levels of the phases in full steps, a row a step; clockwise goes down the rows."""
        return PHASES[::2]

    def moves(self, ticks: Mapping[str, int]) -> Moves:
        """Make what moves the motor: the fast way, or its slow twin."""
        law = Law(self.options.inferred["periods"] or PERIODS, self.options.inferred["ramp_start"])
        if self.options.stepwise:
            from .twin import Stepwise

            return Stepwise(self, ticks, self.state, self.outputs, self.port, law)
        return Motion(self, ticks, self.state, self.outputs, self.port, law)
