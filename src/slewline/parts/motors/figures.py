"""Rows of figures: what a table of a motor, a driver or a load may have, and in which range."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...core.datasheet.option import Option
from ...errors import SlewlineError

IT = "it"


def figure(name: str, unit: str, says: str, default: float | None = 0.0) -> Option:
    """Return the row of a figure that is 0 or more; of one with the default None, None is allowed as well."""
    return Option(name, "quantity", default, says, low=0, unit=unit, none=default is None)


def positive(name: str, unit: str, says: str, default: Any = ...) -> Option:
    """Return the row of a figure that is more than 0, and must be given; with the default None, it need not be."""
    return Option(name, "quantity", default, says, unit=unit, check=above_0(unit), none=default is None)


def signed(name: str, unit: str, says: str) -> Option:
    """Return the row of a figure that may be less than 0."""
    return Option(name, "quantity", 0.0, says, unit=unit)


def above_0(unit: str) -> Callable[[float], str]:
    """Return the check of a number that must be more than 0."""
    return lambda value: "" if value > 0 else f"allowed more than 0 {unit}".rstrip()


def share(value: float) -> str:
    """Say what is wrong with a part of a whole, more than 0 and up to 1."""
    return "" if 0 < value <= 1 else "allowed more than 0, up to 1"


def complaint(read: Callable[[Any, str], object]) -> Callable[[Any], str]:
    """Return a check for an option: what `read(value, name)` says of a value that it refuses, or ""."""

    def says(value: Any) -> str:
        try:
            read(value, IT)
        except SlewlineError as error:
            return str(error).removeprefix(IT).removeprefix(f" {value!r}").lstrip(":; ")
        return ""

    return says
