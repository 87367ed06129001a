"""What only the CY512's linter knows."""

from __future__ import annotations

from ...core.table import Sheet
from ...language.lint import Check
from ..cy5xx.sisters import written_for


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return the rules of this part, for `language.lint.lint`; they read its tables themselves."""
    return (written_for,)
