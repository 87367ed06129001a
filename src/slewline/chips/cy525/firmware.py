"""The CY525, a CY5xx chip with ramps, rates on the fly, and live commands (sent while a program runs).

Choices where the manual is silent are in quirks.py.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..cy5xx.firmware import Cy5xx
from ..cy5xx.sheet import PHASES, POWER_UP_RC_PS, POWER_UP_RESET_PS
from ..cy5xx.stepping.phase_outputs import Patterns
from ..cy5xx.supply import PowerUp
from .instructions import Instructions, Registers
from .motion import Motion
from .profile import Law
from .sheet import SHEET

if TYPE_CHECKING:
    from .twin import Stepwise


class Cy525(Cy5xx):
    """A CY525 on a bench."""

    sheet = SHEET
    _power_up = PowerUp(POWER_UP_RESET_PS, POWER_UP_RC_PS)
    _crystal_where = "Table VIII"
    _registers_class = Registers
    _instructions_class = Instructions
    _motion_class = Motion
    state: Registers

    def phase_patterns(self) -> Patterns:
        return PHASES

    def _twin_class(self) -> type[Stepwise]:
        from .twin import Stepwise

        return Stepwise

    def _law(self) -> Law:
        """Return the law by which the rate parameter changes in ramps, as the chip options set it."""
        return Law(self.options.ramp_unit, self.options.ramp_jumps)
