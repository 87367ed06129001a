"""Quantities with units: "68 g cm2", "62 oz-in", "36 kHz"; a plain number is in the unit of the result.

    quantity("68 gcm2", "kg m2", "inertia")                       6.8e-06
    quantity(6.8e-6, "kg m2", "inertia")                          6.8e-06
    quantity("600 rpm", "steps/s", "rate", per_turn=200)          2000.0
    quantity("5 mH", "kg m2", "inertia")                          UsageError: ... mH is a unit of inductance ...

Text is rounded only once, so "68 g cm2" is the same number as 6.8e-6.  Text must include a unit, unless
it is 0 or an angle: 68 for an inertia is unlikely to mean kg m2.  Spaces, dots, stars and dashes within
a unit are ignored.  Turns are converted to steps only where a motor's steps per revolution are known.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from fractions import Fraction
from numbers import Integral
from types import MappingProxyType

from ...errors import UsageError
from ..messages.decimal_comma import without_comma

UNITS: Mapping[str, Mapping[str, str]] = MappingProxyType(  # by the first unit: the units allowed, and their factors
    {
        "V": {"V": "1", "mV": "1e-3"},
        "A": {"A": "1", "mA": "1e-3"},
        "ohm": {"ohm": "1", "mohm": "1e-3", "kohm": "1e3"},
        "H": {"H": "1", "mH": "1e-3", "uH": "1e-6"},
        "s": {"s": "1", "ms": "1e-3", "us": "1e-6"},
        "Hz": {"Hz": "1", "kHz": "1e3", "MHz": "1e6"},
        "kg": {"kg": "1", "g": "1e-3", "oz": "0.028349523125", "lb": "0.45359237"},
        "m": {"m": "1", "cm": "1e-2", "mm": "1e-3", "um": "1e-6", "in": "0.0254"},
        "N": {"N": "1", "mN": "1e-3", "kN": "1e3", "kgf": "9.80665", "lbf": "4.4482216152605"},
        "N m": {
            "N m": "1", "mN m": "1e-3", "uN m": "1e-6", "N cm": "1e-2", "kg cm": "0.0980665", "g cm": "9.80665e-5",
            "oz in": "0.00706155181422604375", "lb in": "0.1129848290276167",
        },
        "kg m2": {
            "kg m2": "1", "kg cm2": "1e-4", "g m2": "1e-3", "g cm2": "1e-7", "g mm2": "1e-9",
            "oz in2": "1.8289978339325e-5", "oz in s2": "0.00706155181422604375", "lb in2": "2.926396534292e-4",
        },
        "N m s": {"N m s": "1", "mN m s": "1e-3", "uN m s": "1e-6"},
        "N m/rad": {"N m/rad": "1", "mN m/rad": "1e-3"},
        "deg": {"deg": "1", "rad": "57.295779513082320877"},
        "steps/s": {"steps/s": "1"},
        "steps/s2": {"steps/s2": "1"},
    }
)  # fmt: skip
TURNS: Mapping[str, Fraction] = MappingProxyType(  # per second; units of "steps/s" where the steps per turn are known
    {"rev/s": Fraction(1), "rpm": Fraction(1, 60), "rev/min": Fraction(1, 60)}
)
KINDS: Mapping[str, str] = MappingProxyType(
    {
        "V": "voltage", "A": "current", "ohm": "resistance", "H": "inductance", "s": "time", "Hz": "frequency",
        "kg": "mass", "m": "length", "N": "force", "N m": "torque", "kg m2": "inertia", "N m s": "drag",
        "N m/rad": "stiffness", "deg": "angle", "steps/s": "rate", "steps/s2": "acceleration",
    }
)  # fmt: skip
ALONE = ("deg",)  # may be left out in a text, too: step angles are never in radians
GREATEST = sys.float_info.max
_NUMBER = r"([+-]?(?:[0-9]{1,30}(?:\.[0-9]{0,30})?|\.[0-9]{1,30})(?:[eE][+-]?[0-9]{1,2})?)"
_NUMBER_AND_UNIT = re.compile(rf"{_NUMBER}(.*)", re.DOTALL)
_TURNING = re.compile(rf"{_NUMBER}\s*(rev/s|rev/min|rpm)(?:\^?([23]))?(?![\w/])", re.IGNORECASE)
SPELLED = str.maketrans(
    {"µ": "u", "μ": "u", "Ω": "ohm", "\N{OHM SIGN}": "ohm", "²": "2", "°": "deg", "·": None, "*": None, "^": None}
)


def measured(value: object, unit: str, per_turn: int | None = None) -> float:
    """Return a quantity as a number in `unit`, a key of UNITS; a value without a unit is taken to be in `unit`.

    Args:
        per_turn: the motor's steps per revolution, if a rate may be in turns; None if it may not.

    Raises:
        ValueError: the value is neither a finite number nor text made up of such a number and a unit of this
            quantity.
    """
    if isinstance(value, str):
        return _of_text(value, unit, per_turn)
    number = int(value) if isinstance(value, Integral) and not isinstance(value, bool) else value
    if isinstance(number, bool) or not isinstance(number, (int, float)) or not abs(number) <= GREATEST:
        raise ValueError(value)
    return float(number)


def _of_text(text: str, unit: str, per_turn: int | None) -> float:
    found = _NUMBER_AND_UNIT.fullmatch(text.strip())
    if found is None:
        raise ValueError(text)
    spelled = _plain(found[2])
    sizes = {_plain(each): Fraction(size) for each, size in UNITS[unit].items()}
    if not spelled and (unit in ALONE or not Fraction(found[1])):
        return float(Fraction(found[1]))
    if unit == "steps/s" and per_turn is not None:
        sizes |= {each: size * per_turn for each, size in TURNS.items()}
    if spelled not in sizes:
        raise ValueError(text)
    return float(Fraction(found[1]) * sizes[spelled])


def _plain(unit: str) -> str:
    """Return a unit in a form for comparison: ozf-in becomes ozin, oz-in-sec2 becomes ozins2."""
    plain = re.sub(r"(?<=[A-Za-z])-(?=[A-Za-z])", "", "".join(unit.translate(SPELLED).split()))
    plain = re.sub(r"^(kg|g|oz|lb)f(?=[a-z])", r"\1", plain).replace("sec", "s")
    return plain.lower() if plain.lower() in TURNS else plain


def other_kind(value: object, unit: str) -> str:
    """Return a note on the wrong or missing unit in a text; an empty string if no note applies.

    The note begins a message, so it ends with a semicolon and a space: "mH is a unit of inductance; ".
    """
    found = _NUMBER_AND_UNIT.fullmatch(value.strip()) if isinstance(value, str) else None
    if found is None:
        return ""
    spelled, name = _plain(found[2]), found[2].strip()
    if not spelled:
        return f"{found[1]} has no unit; "
    if spelled in TURNS and unit == "steps/s":
        return f"{name} needs the motor's steps per revolution, which are not known here: write the rate in steps/s; "
    for each, sizes in (*UNITS.items(), ("steps/s", TURNS)):
        if each != unit and any(spelled == _plain(known) for known in sizes):
            return f"{name} is a unit of {KINDS[each]}; "
    return ""


def in_steps(text: str, per_turn: int) -> str:
    """Return text with rates, accelerations and jerks converted from turns to steps: 600 rpm to 2000 steps/s.

    Args:
        per_turn: the steps per revolution.
    """

    def steps(found: re.Match[str]) -> str:
        number = Fraction(found[1]) * TURNS[found[2].lower()] * per_turn
        return f"{float(number):.15g} steps/s{found[3] or ''}"

    return _TURNING.sub(steps, text)


def expected(unit: str, number: str = "", per_turn: int | None = None) -> str:
    """Return a description of the allowed forms of a quantity, with all its units.

    Args:
        number: text that states which numbers are allowed; by default all.
        per_turn: as for `measured`.
    """
    units = [*UNITS[unit], *(TURNS if unit == "steps/s" and per_turn is not None else ())]
    return f"{number or f'a number ({unit})'}, or text with a unit: {', '.join(units)}"


def quantity(value: object, unit: str, name: str, per_turn: int | None = None) -> float:
    """Return a quantity as a number in `unit`, as `measured` does; messages call the quantity by `name`.

    Args:
        per_turn: as for `measured`.

    Raises:
        UsageError: the value is not such a quantity; the message states the allowed forms.
    """
    try:
        return measured(value, unit, per_turn)
    except ValueError:
        message = f"{other_kind(value, unit)}allowed {expected(unit, per_turn=per_turn)}{without_comma(value)}"
        raise UsageError(f"{name} {value!r}; {message}") from None
