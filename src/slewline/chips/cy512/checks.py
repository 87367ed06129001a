"""What only the CY512's linter knows: nothing yet beyond its sheet."""

from __future__ import annotations

from ...core.table import Sheet
from ...language.lint import Check


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return the rules of this part."""
    return ()
