"""The CY525: the chip of the family that ramps, changes its rate on the fly, and takes live commands.

Where the manual is silent see quirks.py.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..cy5xx.firmware import Cy5xx
from ..cy5xx.program import Moves
from ..cy5xx.steps import Patterns
from ..cy5xx.supply import PowerUp
from .instructions import Instructions, Registers
from .motion import Motion
from .profile import Law
from .sheet import PHASES, POWER_UP_RC_PS, POWER_UP_RESET_PS, SHEET


class Cy525(Cy5xx):
    """A CY525 on a bench."""

    sheet = SHEET
    power_up = PowerUp(POWER_UP_RESET_PS, POWER_UP_RC_PS)
    crystal_where = "Table VIII"
    registers_class = Registers
    instructions_class = Instructions
    state: Registers

    def patterns(self) -> Patterns:
        """Return the levels of the phases, a row a step; clockwise goes down the rows."""
        return PHASES

    def moves(self, ticks: Mapping[str, int]) -> Moves:
        """Make what moves the motor: the fast way, or its slow twin."""
        law = Law(self.options.ramp_unit, self.options.ramp_jumps)
        if self.options.stepwise:
            from .twin import Stepwise

            return Stepwise(self, ticks, self.state, self.outputs, self.port, law)
        return Motion(self, ticks, self.state, self.outputs, self.port, law)
