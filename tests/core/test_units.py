"""Quantities with units: how much a text is, to the last bit, and what is said of one that is none."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from slewline.core.datasheet.option import Option
from slewline.core.datasheet.units import UNITS, expected, measured, quantity
from slewline.errors import UsageError
from tests.rows import rows


@rows(
    ("text", "unit", "value"),
    [
        ("6.8e-6", "kg m2", 6.8e-6),
        ("68 g cm2", "kg m2", 6.8e-6),
        ("68gcm2", "kg m2", 6.8e-6),
        ("68 g·cm²", "kg m2", 6.8e-6),
        ("68 g*cm^2", "kg m2", 6.8e-6),
        ("3e-5 kgm2", "kg m2", 3e-5),
        ("0.056 kg cm2", "kg m2", 5.6e-6),
        ("5 mNm", "N m", 5e-3),
        ("5 mN m", "N m", 5e-3),
        ("59 Ncm", "N m", 0.59),
        ("-1.26Nm", "N m", -1.26),
        ("8 mH", "H", 8e-3),
        ("860 µH", "H", 860e-6),
        ("24 V", "V", 24.0),
        (" 1.4 A ", "A", 1.4),
        ("+.5 A", "A", 0.5),
        ("5. A", "A", 5.0),
        ("300 mA", "A", 0.3),
        ("36 kHz", "Hz", 36e3),
        ("2 ms", "s", 2e-3),
        ("2 us", "s", 2e-6),
        ("2 \N{MICRO SIGN}s", "s", 2e-6),
        ("2 \N{GREEK SMALL LETTER MU}s", "s", 2e-6),
        ("1.5 Ω", "ohm", 1.5),
        ("1.5 \N{OHM SIGN}", "ohm", 1.5),
        ("2.2 kΩ", "ohm", 2200.0),
        ("0.5 mNm s", "N m s", 0.5e-3),
        ("10 Nm/rad", "N m/rad", 10.0),
        ("2 kg", "kg", 2.0),
        ("5 mm", "m", 5e-3),
        ("12 N", "N", 12.0),
        (5, "V", 5.0),
        (0.1, "V", 0.1),
        (np.int64(7), "V", 7.0),
        (np.float64(0.25), "V", 0.25),
    ],
)
def test_a_quantity_is_rounded_once(text, unit, value):
    found = quantity(text, unit, "x")
    assert type(found) is float and found == value


@rows("unit", UNITS)
def test_every_unit_is_read_as_it_is_spelled(unit):
    assert next(iter(UNITS[unit].items())) == (unit, "1")
    for spelled, size in UNITS[unit].items():
        assert quantity(f"3 {spelled}", unit, "x") == float(3 * Fraction(size))


@rows(
    "value",
    [
        "5 mH", "5 a", "5 A A", "A", "", " ", "e5", "5 e", "1,4 A", "1.2.3 A", "--5 A", "5e100 A", "nan", "inf A",
        "٣ A", True, None, float("nan"), float("inf"), 5j, [1.4], {"A": 5}, "9" * 31,
    ],
)  # fmt: skip
def test_what_is_no_quantity_is_refused_with_what_is(value):
    with pytest.raises(UsageError) as error:
        quantity(value, "A", "m: current")
    assert str(error.value) == f"m: current {value!r}; allowed a number (A), or text with a unit: A, mA"
    with pytest.raises(ValueError):
        measured(value, "A")
    row = Option("current", "quantity", 0.0, "of a phase", unit="A")
    with pytest.raises(UsageError) as error:
        row.checked("m", value)
    assert str(error.value) == f"m: current {value!r}; allowed {expected('A')}"


def test_a_number_that_no_float_holds_is_refused():
    with pytest.raises(UsageError, match="allowed a number"):
        quantity(10**400, "A", "m: current")
    assert measured(10**300, "A") == 1e300


INERTIA = Option("inertia", "quantity", None, "of the rotor", low=0, high=1.0, unit="kg m2", none=True)
CURRENT = Option(
    "current",
    "quantity",
    1.0,
    "of a phase",
    unit="A",
    check=lambda value: "" if value > 0 else f"{value:g} drives none",
)


def test_an_option_makes_a_float_of_a_quantity():
    assert [repr(INERTIA.checked("m", each)) for each in ("68 g cm2", 0, "1e-6", None)] == [
        "6.8e-06",
        "0.0",
        "1e-06",
        "None",
    ]
    assert INERTIA.checked("m", INERTIA.read("68 g cm2")) == INERTIA.checked("m", INERTIA.read("6.8e-6")) == 6.8e-6
    assert CURRENT.checked("m", "20 mA") == 0.02
    assert (CURRENT.data()["kind"], CURRENT.data()["unit"], CURRENT.data()["default"]) == ("quantity", "A", 1.0)
    assert CURRENT.shown == "1.0"


@rows(
    ("row", "value", "says"),
    [
        (INERTIA, -1, "-1; allowed 0..1 kg m2, or text with a unit: kg m2, kg cm2, g m2, g cm2, g mm2, None"),
        (INERTIA, "2 kg m2", "'2 kg m2'; allowed 0..1 kg m2, or text with"),
        (INERTIA, "-1 g cm2", "'-1 g cm2'; allowed 0..1 kg m2, or text with"),
        (CURRENT, 0, "0; 0 drives none"),
        (CURRENT, "0 mA", "'0 mA'; 0 drives none"),
        (CURRENT, "-20 mA", "'-20 mA'; -0.02 drives none"),
    ],
)
def test_the_range_of_an_option_bounds_the_quantity(row, value, says):
    with pytest.raises(UsageError) as error:
        row.checked("m", value)
    assert str(error.value).startswith(f"m: {row.name} {says}")
