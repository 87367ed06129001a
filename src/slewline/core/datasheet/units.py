"""Quantities with units: "68 g cm2", "5 mNm", "36 kHz"; a number alone is in the SI unit.

    quantity("68 gcm2", "kg m2", "inertia")    6.8e-06
    quantity(6.8e-6, "kg m2", "inertia")       6.8e-06
    quantity("5 mH", "kg m2", "inertia")       UsageError: inertia '5 mH'; allowed a number (kg m2), or text with ...

A text is rounded once: "68 g cm2" is the same number as 6.8e-6.  Spaces, dots and stars within a unit do not count.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from fractions import Fraction
from numbers import Integral
from types import MappingProxyType

from ...errors import UsageError

UNITS: Mapping[str, Mapping[str, str]] = MappingProxyType(  # by the SI unit: what may be written, and how much it is
    {
        "V": {"V": "1", "mV": "1e-3"},
        "A": {"A": "1", "mA": "1e-3"},
        "ohm": {"ohm": "1", "mohm": "1e-3", "kohm": "1e3"},
        "H": {"H": "1", "mH": "1e-3", "uH": "1e-6"},
        "s": {"s": "1", "ms": "1e-3", "us": "1e-6"},
        "Hz": {"Hz": "1", "kHz": "1e3", "MHz": "1e6"},
        "kg": {"kg": "1", "g": "1e-3"},
        "m": {"m": "1", "cm": "1e-2", "mm": "1e-3", "um": "1e-6"},
        "N": {"N": "1", "mN": "1e-3", "kN": "1e3"},
        "N m": {"N m": "1", "mN m": "1e-3", "uN m": "1e-6", "N cm": "1e-2"},
        "kg m2": {"kg m2": "1", "kg cm2": "1e-4", "g m2": "1e-3", "g cm2": "1e-7", "g mm2": "1e-9"},
        "N m s": {"N m s": "1", "mN m s": "1e-3", "uN m s": "1e-6"},
        "N m/rad": {"N m/rad": "1", "mN m/rad": "1e-3"},
    }
)
GREATEST = sys.float_info.max
_NUMBER_AND_UNIT = re.compile(
    r"([+-]?(?:[0-9]{1,30}(?:\.[0-9]{0,30})?|\.[0-9]{1,30})(?:[eE][+-]?[0-9]{1,2})?)(.*)", re.DOTALL
)
SPELLED = str.maketrans(
    {"µ": "u", "μ": "u", "Ω": "ohm", "\N{OHM SIGN}": "ohm", "²": "2", "·": None, "*": None, "^": None}
)


def measured(value: object, unit: str) -> float:
    """Return a quantity as a number of an SI unit.

    Raises:
        ValueError: it is neither a finite number nor text with one and a unit of this quantity.
    """
    if isinstance(value, str):
        return _of_text(value, unit)
    number = int(value) if isinstance(value, Integral) and not isinstance(value, bool) else value
    if isinstance(number, bool) or not isinstance(number, (int, float)) or not abs(number) <= GREATEST:
        raise ValueError(value)
    return float(number)


def _of_text(text: str, unit: str) -> float:
    found = _NUMBER_AND_UNIT.fullmatch(text.strip())
    if found is None:
        raise ValueError(text)
    spelled = "".join(found[2].translate(SPELLED).split())
    units = {"": "1"} | {each.replace(" ", ""): size for each, size in UNITS[unit].items()}
    if spelled not in units:
        raise ValueError(text)
    return float(Fraction(found[1]) * Fraction(units[spelled]))


def expected(unit: str, number: str = "") -> str:
    """Return what a quantity may be, in words.

    Args:
        number: which numbers are allowed; by default all.
    """
    return f"{number or f'a number ({unit})'}, or text with a unit: {', '.join(UNITS[unit])}"


def quantity(value: object, unit: str, name: str) -> float:
    """Return a quantity as a number of an SI unit.

    Raises:
        UsageError: it is no such quantity; the message says what is allowed.
    """
    try:
        return measured(value, unit)
    except ValueError:
        raise UsageError(f"{name} {value!r}; allowed {expected(unit)}") from None
