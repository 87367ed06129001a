"""The CY512's ramp calculator, for R and S."""

from __future__ import annotations

from ...core.datasheet.table import Sheet
from ...language.ramp_answers import Calculator
from ..cy5xx.ramps import SlopeRamps
from .profile import LAW, move


def ramps(sheet: Sheet) -> Calculator:
    """Return this part's ramp calculator."""
    return SlopeRamps(sheet, LAW, move)
