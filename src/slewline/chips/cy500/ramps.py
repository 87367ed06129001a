"""The CY500's ramp calculator, for R and S."""

from __future__ import annotations

from ...core.datasheet.table import Sheet
from ...language.ramp_answers import Calculator
from ..cy5xx.ramps import SlopeRamps
from ..cy5xx.stepping.slope import Law
from .profile import move
from .sheet import PERIODS


def ramps(sheet: Sheet) -> Calculator:
    """Return this part's ramp calculator."""
    return SlopeRamps(sheet, Law(PERIODS), move)
