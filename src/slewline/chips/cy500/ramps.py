"""The CY500's ramp calculator: R and S."""

from __future__ import annotations

from ...core.datasheet.table import Sheet
from ...language.ramp_answers import Calculator
from ..cy5xx.ramps import SlopeRamps
from ..cy5xx.stepping.slope import Law
from .profile import move
from .sheet import PERIODS


def ramps(sheet: Sheet) -> Calculator:
    """Return the calculator of this part."""
    return SlopeRamps(sheet, Law(PERIODS), move)
