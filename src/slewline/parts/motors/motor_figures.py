"""Figures of a motor, a driver or a load: their names, units and ranges, and how text sets them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from math import inf
from types import MappingProxyType
from typing import Any

from ...core.datasheet.option import Option
from ...core.datasheet.option import read as read_texts
from ...errors import SlewlineError, UsageError

IT = "it"
REACH: Mapping[str, tuple[float, str]] = MappingProxyType(  # maximum value of any stepper motor; usual value
    {"kg m2": (1.0, "g cm2"), "N m": (100.0, "mN m"), "m": (1.0, "mm"), "H": (10.0, "mH"), "A": (100.0, "mA")}
)


def figure(name: str, unit: str, description: str, default: float | None = 0.0) -> Option:
    """Return the row of a figure that is 0 or more; if the default is None, None is allowed as well."""
    return Option(name, "quantity", default, description, low=0, unit=unit, check=in_reach(unit), none=default is None)


def positive(name: str, unit: str, description: str, default: Any = ...) -> Option:
    """Return the row of a figure that is more than 0; required, unless a default is passed, which may be None."""
    return Option(name, "quantity", default, description, unit=unit, check=above_0(unit), none=default is None)


def signed(name: str, unit: str, description: str) -> Option:
    """Return the row of a figure that may be negative."""
    return Option(name, "quantity", 0.0, description, unit=unit, check=in_reach(unit))


def above_0(unit: str) -> Callable[[float], str]:
    """Return a check of numbers, which complains unless a number is more than 0 and plausible (`in_reach`)."""
    reach = in_reach(unit)
    return lambda value: reach(value) if value > 0 else f"allowed more than 0 {unit}".rstrip()


def in_reach(unit: str) -> Callable[[float], str]:
    """Return a check that rejects a number so far beyond any real motor or load that its unit must be wrong."""
    most, usual = REACH.get(unit, (inf, ""))
    message = f"allowed up to {most:g} {unit}; a number alone is in {unit}, so write the unit, such as '68 {usual}'"
    return lambda value: "" if abs(value) <= most else message


def share(value: float) -> str:
    """Return the complaint about a value outside the range 0 < value <= 1, or "" if it is in range."""
    return "" if 0 < value <= 1 else "allowed more than 0, up to 1"


def of_text(
    text: str, rows: Sequence[Option], name: str, spelled: Mapping[str, str], beside: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the table for a text such as "inertia 68 g cm2, friction 5 mNm".

    Args:
        name: name of the described object, for messages.
        spelled: maps other wordings, in lower case, to names of figures, such as "holding torque" to
            "torque"; or whole parts of the text to replacements, such as "unipolar" to "windings unipolar".
        beside: names allowed in addition to the figures.

    Raises:
        UsageError: a number has no name, a figure occurs twice, or a comma is missing.  A figure with an
            unknown name is included in the table, and `checked` refuses it later.
    """
    if ";" in text:
        raise UsageError(f"{name} {text!r}: separate figures with commas, not semicolons")
    words = {row.name.replace("_", " "): row.name for row in rows} | {row.name: row.name for row in rows}
    words |= {each: each for each in beside} | dict(spelled)
    pairs: dict[str, str] = {}
    for part in filter(None, map(str.strip, text.split(","))):
        given = re.sub(r"\s+", " ", re.sub(r"\s*[=:]\s*", " ", part, count=1))
        whole = words.get(given.lower(), "")
        given = whole if " " in whole else given
        if given[0] in "0123456789.+-":
            raise UsageError(
                f"{name} {text!r}: {part!r} has no name; write the name, the number (with a decimal point) and "
                "the unit of each figure, such as friction 0.5 mNm"
            )
        known = max((each for each in words if f"{given} ".lower().startswith(f"{each} ")), key=len, default="")
        word = known or re.split(r" (?=[\d.+-])", given, maxsplit=1)[0]
        figure, value = words.get(known, word), given[len(word) :].strip()
        if figure in pairs:
            raise UsageError(f"{name} {text!r}: {figure} is given twice; leave one out")
        figures = [row for row in rows if row.kind == "quantity"]
        if any(row.name == figure for row in figures):
            for other in (row.name.replace("_", " ") for row in figures):
                if re.search(rf"\d.* {other} ", value):
                    raise UsageError(f"{name} {text!r}: a comma is missing before {other!r}")
        is_bool = any(row.name == figure and row.kind == "bool" for row in rows)
        pairs[figure] = value or ("true" if is_bool else "")
    return read_texts(rows, pairs.items())


def complaint(read: Callable[[Any, str], object]) -> Callable[[Any], str]:
    """Return a check for an option: its result is the message of the error that `read` raises, or "" if none."""

    def refusal(value: Any) -> str:
        try:
            read(value, IT)
        except SlewlineError as error:
            return str(error).removeprefix(IT).removeprefix(f" {value!r}").lstrip(":; ")
        return ""

    return refusal
