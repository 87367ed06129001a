"""The sheet as its user has it: every tool reckons with the rates and the law of ramps that options ask for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...core.datasheet.option import defaulted
from ...core.datasheet.table import Sheet
from .sheet import TABLES


def fitted(sheet: Sheet, options: Mapping[str, Any]) -> Sheet:
    """Return a sheet whose options are the defaults, with the rates that they ask for.

    Args:
        options: all of them, checked; rates are `inferred.rates`, or a table by its name, `rate_table`.
    """
    rates = tuple(options["inferred"]["rates"]) or TABLES[options["rate_table"]]
    return replace(sheet, rates=rates, options=defaulted(sheet.options, options))
