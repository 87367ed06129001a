"""Drivers as texts and as tables of figures."""

from __future__ import annotations

from dataclasses import replace

import pytest

from slewline.core.datasheet.option import Option
from slewline.errors import UnknownName, UsageError
from slewline.parts.motors.drivers import (
    ALWAYS,
    DRIVERS,
    EXAMPLES,
    FIGURES,
    SAYINGS,
    TAKES,
    driver_complaint,
    read_driver,
)
from slewline.parts.motors.motor_data import DriverData
from slewline.parts.motors.motors import MOTORS, read_motor
from tests.rows import rows

A = MOTORS["QSH4218-51-10-049"]  # 1 A, 5 ohm
AVERAGED = DriverData(kind="averaged", supply=24.0, current=1.0)
CHOPPER = DriverData(kind="chopper", supply=24.0, current=1.4)
TEXTS = ", ".join(map(repr, EXAMPLES))
TABLE = ", ".join(row.name for row in FIGURES)
GSD = DRIVERS["GS-D200"].data


@rows(
    ("text", "driver"),
    [
        ("24 V, 1 A", AVERAGED),
        ("24 V", AVERAGED),
        ("24V,1A", AVERAGED),
        ("24 V, 1 A averaged", AVERAGED),
        ("24 V averaged, 1 A", AVERAGED),
        ("24 V, 1 A, averaged, averaged", AVERAGED),
        ("1000 mA, 24 V", AVERAGED),
        ("24 V, 1.4 A chopper", CHOPPER),
        ("24 V, 1.4 A chopper, 20 kHz, slow decay", CHOPPER),
        ("24 V, 1.4 A, 36 kHz", replace(CHOPPER, frequency=36e3)),
        ("24 V, 1.4 A Chopper, Mixed  decay", replace(CHOPPER, decay="mixed")),
        ("24 V, 1.4 A, fast decay", replace(CHOPPER, decay="fast")),
        ("24 V, 1.4 A chopper, least on 2 us, diode 0.7 V", replace(CHOPPER, least_on=2e-6, diode=0.7)),
        ("24 V, 1.4 A chopper, least on 2 µs", replace(CHOPPER, least_on=2e-6)),
        ("24 V, 1 A, boost, clamp 24 V", replace(AVERAGED, boost=True, clamp=24.0)),
        ("24 V, 2 A, rest 0.5 A, slew 1 A, ramp 3 A", replace(AVERAGED, current=2.0, rest=0.25, slew=0.5, ramp=1.5)),
        ("24 V, rest 500 mA", replace(AVERAGED, rest=0.5)),
        ("24 V, rest .5 A", replace(AVERAGED, rest=0.5)),
        ("24 V, rest 0 A", replace(AVERAGED, rest=0.0)),
        ("L/R 5 V", DriverData(kind="voltage", supply=5.0, current=1.0)),
        ("L/1R 5 V", DriverData(kind="voltage", supply=5.0, current=1.0)),
        ("L/4R 20 V", DriverData(kind="voltage", supply=20.0, current=1.0, series=15.0)),
        ("L/2.5R 20 V", DriverData(kind="voltage", supply=20.0, current=1.6, series=7.5)),
        ("L/R 20 V, series 15 Ω", DriverData(kind="voltage", supply=20.0, current=1.0, series=15.0)),
        (
            "bilevel 24 V 2 ms, 5 V",
            DriverData(kind="bilevel", supply=5.0, current=1.0, high=24.0, high_time=2e-3),
        ),
        (
            "bilevel 24 V 2 ms, 5 V, series 5 ohm",
            DriverData(kind="bilevel", supply=5.0, current=0.5, high=24.0, high_time=2e-3, series=5.0),
        ),
        ("current 1.5 A", DriverData(kind="current", current=1.5)),
        ("current 1 A, boost, lag 0.3 ms", DriverData(kind="current", current=1.0, boost=True, lag=3e-4)),
        (
            "GS-D200, 24 V, 1 A, rest 0.25 A, ramp 1.5 A",
            replace(GSD, supply=24.0, current=1.0, rest=0.25, ramp=1.5),
        ),
        ("24 V, GS-D200, fast decay", replace(GSD, supply=24.0, current=1.0, decay="fast")),
        ("L297+L298, 36 V, 2 A", replace(DRIVERS["L297+L298"].data, supply=36.0, current=2.0)),
    ],
)
def test_a_text_is_a_driver(text, driver):
    assert read_driver(text, "d", A) == replace(driver, name=text)


@rows("text", EXAMPLES)
def test_the_examples_in_messages_are_drivers(text):
    assert read_driver(text, "d", A).name == text


@rows(
    ("table", "driver"),
    [
        ({"kind": "averaged", "supply": 24, "current": 1}, replace(AVERAGED, name="own")),
        ({"kind": "averaged", "supply": "24 V", "name": "mine"}, replace(AVERAGED, name="mine")),
        ({"kind": "chopper", "supply": 24, "current": "1.4 A"}, replace(CHOPPER, name="own")),
        (
            {"kind": "chopper", "supply": 24, "current": 1.4, "decay": "mixed", "fast_part": 0.5},
            replace(CHOPPER, name="own", decay="mixed", fast_part=0.5),
        ),
        (
            {"kind": "averaged", "supply": 24, "rest": 0.5, "ramp": "1.5 A"},
            replace(AVERAGED, name="own", rest=0.5, ramp=1.5),
        ),
        ({"kind": "averaged", "supply": 24, "rest": "0.5", "slew": None}, replace(AVERAGED, name="own", rest=0.5)),
        (
            {"kind": "voltage", "supply": 20, "series": 15},
            DriverData(name="own", kind="voltage", supply=20.0, series=15.0, current=1.0),
        ),
        ({"like": "GS-D200", "supply": 24, "rest": "0.25 A"}, replace(GSD, supply=24.0, current=1.0, rest=0.25)),
    ],
)
def test_a_table_is_a_driver(table, driver):
    given = {**table}
    assert read_driver(table, "d", A) == driver
    assert table == given
    assert read_driver(driver, "d", A) is driver


def test_the_current_is_by_default_that_of_the_motor_and_the_resistor_goes_by_its_winding():
    b = MOTORS["QSH5718-56-28-126"]
    assert read_driver("30 V", "d", b).current == 2.8
    assert read_driver("L/5R 12 V", "d", b).series == pytest.approx(3.6)
    assert read_driver("L/5R 12 V", "d", b).current == pytest.approx(12 / 4.5)
    assert read_driver("30 V, rest 1.4 A", "d", b).rest == pytest.approx(0.5)
    assert read_driver({"kind": "averaged", "supply": 30, "rest": "0.5", "ramp": "4.2 A"}, "d", b).rest == 0.5
    half = read_motor({"like": A.name, "windings": "unipolar"})
    assert read_driver("L/4R 20 V", "d", half).series == 15.0


def test_the_rows_of_a_table_are_the_figures_of_a_driver():
    assert [row.name for row in FIGURES] == [*DriverData.__slots__]
    plain = DriverData(kind="current")
    for row in FIGURES[2:]:
        assert (row.default or 0.0) == (getattr(plain, row.name) or 0.0)
    assert {each for takes in TAKES.values() for each in takes} | {*ALWAYS} == {row.name for row in FIGURES}
    kinds = {sets["kind"] for sets in SAYINGS.values() if "kind" in sets}
    assert kinds == {*TAKES}


def test_the_rows_have_the_figures_of_their_data_sheets():
    assert {name: (row.data.frequency, row.supply, row.most) for name, row in DRIVERS.items()} == {
        "GS-D200": (17e3, (10, 46), 2.0),
        "GS-D200S": (17e3, (12, 40), 2.5),
        "L297+L298": (20e3, (4.8, 46), 2.0),
        "A4988": (0.0, (8, 35), 1.41),
        "DRV8825": (30e3, (8.2, 45), 1.76),
        "TMC2208": (35.14e3, (4.75, 36), 1.4),
        "TMC2209": (35.14e3, (4.75, 28), 2.0),
    }
    oscillator = 1 / (0.69 * 22e3 * 3.3e-9)
    assert oscillator == pytest.approx(20e3, rel=0.01)


@pytest.mark.parametrize("name", DRIVERS)
def test_every_row_can_be_driven_within_its_data_sheet(name):
    row = DRIVERS[name]
    low, high = row.supply
    assert row.data.name == name and row.data.source and row.data.kind in ("chopper", "averaged") and low < high
    for volts in row.supply:
        assert read_driver(f"{name}, {volts:g} V, {row.most:g} A", "d", A).supply == volts
    for volts in (low - 0.1, high + 0.1):
        with pytest.raises(UsageError) as error:
            read_driver(f"{name}, {volts:g} V", "d", A)
        assert str(error.value) == f"d: supply {volts:g} V; the {name} allows {low:g}..{high:g} V"


NUMBER = "a number ({0}), or text with a unit: {0}, m{0}"


@rows(
    ("value", "says"),
    [
        ("24 v", f"d '24 v': '24 v' is not recognised; examples: {TEXTS}"),
        ("", f"d '': '' is not recognised; examples: {TEXTS}"),
        (
            "24 V, 1 A choper",
            f"d '24 V, 1 A choper': '1 A choper' is not recognised; examples: {TEXTS}; did you mean chopper?",
        ),
        ("24 V, GSD200", f"d '24 V, GSD200': 'GSD200' is not recognised; examples: {TEXTS}; did you mean GS-D200?"),
        (
            "TB6600, 24 V, 1 A",
            f"d 'TB6600, 24 V, 1 A': 'TB6600' is not recognised; examples: {TEXTS}; drivers with a name: "
            f"{', '.join(DRIVERS)}; for another driver, set frequency and decay",
        ),
        ("24 V 1 A", f"d '24 V 1 A': '24 V 1 A' is not recognised; examples: {TEXTS}"),
        ("bilevel 24 V, 5 V", f"d 'bilevel 24 V, 5 V': 'bilevel 24 V' is not recognised; examples: {TEXTS}"),
        ("L/.R 5 V", f"d 'L/.R 5 V': 'L/.R 5 V' is not recognised; examples: {TEXTS}"),
        ("L/0R 5 V", "d: 'L/0R 5 V'; allowed L/1R or more (the winding itself is 1 R), such as L/4R 20 V"),
        ("24 V, 12 V", "d '24 V, 12 V': '24 V' and '12 V' both set supply; leave one out"),
        (
            "24 V, 1 A averaged, chopper",
            "d '24 V, 1 A averaged, chopper': 'averaged' and 'chopper' both set kind; leave one out",
        ),
        ("0 V", "d: supply '0 V'; allowed more than 0 V"),
        ("-5 V", "d: supply '-5 V'; allowed more than 0 V"),
        ("24 V, 0 A", "d: current '0 A'; allowed more than 0 A"),
        ("24 V, 1 A, 0 kHz", "d: frequency '0 kHz'; allowed more than 0 Hz"),
        ("24 V, rest -1 A", "d: rest -1.0; allowed 0 or more"),
        ("1 A", f"d needs supply: {NUMBER.format('V')}"),
        ("chopper", f"d needs supply: {NUMBER.format('V')}"),
        ("bilevel 24 V 2 ms", f"d needs supply: {NUMBER.format('V')}"),
        ("bilevel 24 V 0 ms, 5 V", "d: high_time '0 ms'; allowed more than 0 s"),
        ("bilevel 5 V 2 ms, 5 V", "d: 'high' 5 V; must be more than the supply (5 V)"),
        ("L/R 5 V, 1 A", "d: current '1 A'; not for kind 'voltage', only for: current, averaged, chopper"),
        ("L/R 5 V, boost", "d: boost True; not for kind 'voltage', only for: current, averaged, chopper"),
        ("L/R 5 V, rest 1 A", "d: rest '1 A'; not for kind 'voltage', only for: current, averaged, chopper"),
        ("24 V, 1 A averaged, 20 kHz", "d: frequency '20 kHz'; not for kind 'averaged', only for: chopper"),
        (
            "current 1 A, 24 V",
            "d: supply '24 V'; not for kind 'current', only for: averaged, chopper, voltage, bilevel",
        ),
        ("24 V, 1 A, series 5 ohm", "d: series '5 ohm'; not for kind 'averaged', only for: voltage, bilevel"),
        ("GS-D200, 24 V, 2.5 A", "d: 2.5 A per phase; the GS-D200 allows up to 2 A: use a smaller current"),
        ("GS-D200, 24 V, 1 A, ramp 2.5 A", "d: 2.5 A per phase; the GS-D200 allows up to 2 A: use a smaller current"),
        ("GS-D200, 24 V, 1.5 A, boost", "d: 2.12 A per phase; the GS-D200 allows up to 2 A: use a smaller current"),
        ("GS-D200, 1 A", f"d needs supply: {NUMBER.format('V')}"),
        (3, f"d 3; expected text such as '24 V, 1 A', or a table (keys: 'like', {TABLE})"),
        ({}, "d needs the option kind: current, averaged, chopper, voltage, bilevel"),
        ({"kind": "x"}, "d: kind 'x'; allowed current, averaged, chopper, voltage, bilevel"),
        ({"kind": ["x"]}, "d: kind ['x']; allowed current, averaged, chopper, voltage, bilevel"),
        ({"kind": "averaged", "supply": 0}, "d: supply 0; allowed more than 0 V"),
        ({"kind": "averaged", "supply": None}, f"d needs supply: {NUMBER.format('V')}"),
        (
            {"kind": "bilevel", "supply": 5, "high": 24},
            "d needs high_time: a number (s), or text with a unit: s, ms, us",
        ),
        (
            {"kind": "averaged", "supply": 24, "currant": 1},
            f"d: no option 'currant'; its options: {TABLE}, like; did you mean current?",
        ),
        (
            {"kind": "averaged", "supply": 24, "rest": "5 V"},
            "d: rest '5 V'; allowed a factor of the current, or text with a unit: A, mA",
        ),
        ({"kind": "averaged", "supply": 24, "ramp": -1}, "d: ramp -1; allowed 0 or more"),
        ({"kind": "chopper", "supply": 24, "fast_part": 0}, "d: fast_part 0; allowed more than 0, up to 1"),
        ({"kind": "chopper", "supply": 24, "fast_part": 1.1}, "d: fast_part 1.1; allowed more than 0, up to 1"),
        (
            {"kind": "chopper", "supply": 24, "diode": -1},
            "d: diode -1; allowed 0 or more V, or text with a unit: V, mV",
        ),
    ],
)
def test_an_impossible_driver_is_refused_with_the_allowed_values(value, says):
    with pytest.raises(UsageError) as error:
        read_driver(value, "d", A)
    assert str(error.value) == says


@pytest.mark.parametrize("like", ["gs-d200", "GS-D20", 5])
def test_a_driver_like_one_that_there_is_not(like):
    with pytest.raises(UnknownName) as error:
        read_driver({"like": like, "supply": 24}, "d", A)
    meant = "; did you mean GS-D200?" if like == "gs-d200" else ""
    assert str(error.value) == f"d: 'like' is {like!r}; known: {', '.join(DRIVERS)}{meant}"


def test_a_driver_is_an_option_of_a_part():
    row = Option("driver", "object", "24 V, 1 A", "the driver", check=driver_complaint)
    assert row.checked("p", row.default) == row.default
    with pytest.raises(UsageError) as error:
        row.checked("p", "24 V, 0 A")
    assert str(error.value) == "p: driver '24 V, 0 A'; current '0 A'; allowed more than 0 A"
    with pytest.raises(UsageError) as error:
        row.checked("p", "24 X")
    assert str(error.value) == f"p: driver '24 X'; '24 X' is not recognised; examples: {TEXTS}"
