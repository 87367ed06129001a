"""The CY512, described by its differences from the CY525, a later chip that fits the CY512's socket.

Choices without a source are in quirks.py.
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
from .instructions import Instructions
from .motion import Motion
from .sheet import PERIODS, SHEET

if TYPE_CHECKING:
    from .twin import Stepwise


class Interpreter(interpreter.Interpreter):
    """The CY512's interpreter: READY does not show a program's motions, and there are no live commands."""

    lasting = frozenset(("GO", "POSITION", "EXPEND", "UNTIL", "WAIT"))
    announces = False


class Cy512(Cy5xx):
    """A CY512 on a bench."""

    sheet = SHEET
    _power_up = PowerUp(POWER_UP_RESET_PS, POWER_UP_RC_PS)
    _crystal_where = "the CY525"
    _registers_class = sloped.Registers
    _instructions_class = Instructions
    _interpreter_class = Interpreter
    _motion_class = Motion

    def _twin_class(self) -> type[Stepwise]:
        from .twin import Stepwise

        return Stepwise

    def _law(self) -> Law:
        """Return the step periods by rate parameter, and the parameter at which ramps start."""
        return sloped.law(self.options.inferred, PERIODS)

    def phase_patterns(self) -> Patterns:
        """Return the phase levels in full steps, one row per step, in clockwise order."""
        return sloped.full_steps(self.options.inferred)
