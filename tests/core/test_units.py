"""Quantities with units: how much a text is, to the last bit, and what is said of one that is none."""

from __future__ import annotations

import re
from fractions import Fraction

import numpy as np
import pytest

from slewline.core.datasheet.option import Option
from slewline.core.datasheet.units import ALONE, KINDS, TURNS, UNITS, expected, in_steps, measured, quantity
from slewline.errors import UsageError
from tests.rows import rows

OUNCE, INCH, GRAVITY = Fraction("0.45359237") / 16, Fraction("0.0254"), Fraction("9.80665")  # kg, m, m/s2


@rows(
    ("text", "unit", "value"),
    [
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
def test_every_unit_is_read_in_its_own_spelling(unit):
    assert next(iter(UNITS[unit].items())) == (unit, "1")
    for spelled, size in UNITS[unit].items():
        assert quantity(f"3 {spelled}", unit, "x") == float(3 * Fraction(size))


@rows(
    ("text", "unit", "value"),
    [  # each against the definition of the pound, the inch and the standard gravity
        ("100 oz-in", "N m", 100 * OUNCE * GRAVITY * INCH),
        ("100 ozf in", "N m", 100 * OUNCE * GRAVITY * INCH),
        ("3 lb-in", "N m", 3 * 16 * OUNCE * GRAVITY * INCH),
        ("4.5 kg-cm", "N m", Fraction("4.5") * GRAVITY / 100),
        ("4.5 kgf cm", "N m", Fraction("4.5") * GRAVITY / 100),
        ("450 g·cm", "N m", Fraction("0.45") * GRAVITY / 100),
        ("2 oz-in2", "kg m2", 2 * OUNCE * INCH**2),
        ("0.001 oz-in-sec²", "kg m2", OUNCE * GRAVITY * INCH / 1000),
        ("2 lb in2", "kg m2", 2 * 16 * OUNCE * INCH**2),
        ("0.2 in", "m", INCH / 5),
        ("2 lb", "kg", 32 * OUNCE),
        ("2 lbf", "N", 32 * OUNCE * GRAVITY),
        ("2 kgf", "N", 2 * GRAVITY),
        ("0.44 N-m", "N m", Fraction("0.44")),
        ("1.8°", "deg", Fraction("1.8")),
    ],
)
def test_the_units_of_other_data_sheets(text, unit, value):
    assert quantity(text, unit, "x") == float(value)


@rows("unit", UNITS)
def test_a_unit_of_every_other_quantity_is_refused_and_named(unit):
    own = {each.replace(" ", "") for each in UNITS[unit]}
    for other, spelled in [(kind, each) for kind in UNITS for each in UNITS[kind]]:
        if other == unit or spelled.replace(" ", "") in own:
            continue
        with pytest.raises(UsageError) as error:
            quantity(f"3 {spelled}", unit, "x")
        assert str(error.value) == f"x '3 {spelled}'; {spelled} is a unit of {KINDS[other]}; allowed {expected(unit)}"
    assert KINDS.keys() == UNITS.keys()


@rows("turns", TURNS)
def test_a_rate_in_turns_needs_the_steps_of_a_motor(turns):
    for spelled in (turns, turns.upper()):
        assert quantity(f"90 {spelled}", "steps/s", "x", per_turn=400) == float(90 * 400 * TURNS[turns])
        with pytest.raises(UsageError, match=f"{spelled} needs the motor's steps per revolution"):
            quantity(f"90 {spelled}", "steps/s", "x")
        for other in UNITS.keys() - {"steps/s"}:
            with pytest.raises(UsageError, match=f"{spelled} is a unit of rate; allowed a number"):
                quantity(f"90 {spelled}", other, "x", per_turn=400)


@rows(
    ("text", "found"),
    [
        ("600 rpm", "2000 steps/s"),
        ("1.5 rev/s", "300 steps/s"),
        ("20 rev/s^2", "4000 steps/s2"),
        ("20rev/s3", "4000 steps/s3"),
        ("90 rev/min", "300 steps/s"),
        ("400 steps/s", "400 steps/s"),
        ("8", "8"),
        ("5 rev/s/s", "5 rev/s/s"),
    ],
)
def test_turns_become_steps(text, found):
    assert in_steps(text, 200) == found


@rows(
    "value",
    [
        "5 mH", "5 a", "5 A A", "A", "", " ", "e5", "5 e", "1,4 A", "1.2.3 A", "--5 A", "5e100 A", "nan", "inf A",
        "٣ A", True, None, float("nan"), float("inf"), 5j, [1.4], {"A": 5}, "9" * 31,
    ],
)  # fmt: skip
def test_an_invalid_quantity_is_refused_with_the_allowed_forms(value):
    with pytest.raises(UsageError) as error:
        quantity(value, "A", "m: current")
    other = "mH is a unit of inductance; " if value == "5 mH" else ""
    comma = "; write 1.4 A, with a decimal point" if value == "1,4 A" else ""
    says = f"m: current {value!r}; {other}allowed a number (A), or text with a unit: A, mA{comma}"
    assert str(error.value) == says
    with pytest.raises(ValueError):
        measured(value, "A")
    row = Option("current", "quantity", 0.0, "of a phase", unit="A")
    with pytest.raises(UsageError) as error:
        row.checked("m", value)
    assert str(error.value) == f"m: current {value!r}; {other}allowed {expected('A')}"


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
    assert [repr(INERTIA.checked("m", each)) for each in ("68 g cm2", 0, "10 g cm2", None)] == [
        "6.8e-06",
        "0.0",
        "1e-06",
        "None",
    ]
    assert INERTIA.checked("m", INERTIA.read("68 g cm2")) == 6.8e-6
    assert CURRENT.checked("m", "20 mA") == 0.02
    assert (CURRENT.data()["kind"], CURRENT.data()["unit"], CURRENT.data()["default"]) == ("quantity", "A", 1.0)
    assert CURRENT.shown == "1.0"


@rows(
    ("row", "value", "says"),
    [
        (INERTIA, -1, f"-1; allowed {expected('kg m2', '0..1 kg m2')}, None"),
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


@pytest.mark.parametrize("unit", [each for each in UNITS if each not in ALONE])
def test_a_text_without_a_unit_is_refused_unless_it_is_0(unit):
    with pytest.raises(UsageError, match=f"x '68'; 68 has no unit; allowed a number .*{re.escape(unit)}"):
        quantity("68", unit, "x")
    assert quantity("0", unit, "x") == quantity("0.0", unit, "x") == 0
    assert quantity(68, unit, "x") == 68
