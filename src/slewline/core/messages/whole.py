"""Whole numbers that users write, as Python or NumPy numbers, and the form of numbers in messages."""

from __future__ import annotations

from numbers import Integral


def whole(value: object) -> int | None:
    """Return a Python or NumPy whole number as an int; None for anything else, including True and False."""
    if type(value) is int:
        return value
    return int(value) if isinstance(value, Integral) and not isinstance(value, bool) else None


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, which is in the plural unless the number is 1: "1 step", "2 steps"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
