"""Whole numbers as users give them: those of Python and of NumPy, and no others; and as messages show them."""

from __future__ import annotations

from numbers import Integral


def whole(value: object) -> int | None:
    """Return a whole number, one of NumPy too, as an int; None: it is none, and True and False are none."""
    if type(value) is int:
        return value
    return int(value) if isinstance(value, Integral) and not isinstance(value, bool) else None


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, "1 step" or "2 steps"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
