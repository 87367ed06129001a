"""Markdown building blocks for all reference pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..core.datasheet.table import Pin, Row


def mhz(hz: float) -> str:
    """Return a frequency in MHz, as text without the unit."""
    return f"{hz / 1e6:g}"


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(str(cell).replace('|', chr(92) + '|') for cell in line)} |" for line in lines)


def source(of: Row | Pin) -> str:
    """Return the section of the manual about a row or a pin.

    If the `trust` of the row or pin is anything other than "stated", it follows in brackets.
    """
    return of.where if of.trust == "stated" else f"{of.where} ({of.trust})"
