"""What only the CY500's linter knows."""

from __future__ import annotations

from ...core.table import Sheet
from ...language.lint import Check


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return the rules of this part, for `language.lint.lint`."""
    return ()
