"""Pieces of Markdown that all references are made of."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def mhz(hz: float) -> str:
    """A frequency in MHz."""
    return f"{hz / 1e6:g}"


def table(heads: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(str(cell).replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
