"""Loads as texts and as tables of figures, and whether a motor holds them."""

from __future__ import annotations

from math import pi, sin, sqrt

import pytest

from slewline.core.datasheet.option import Option
from slewline.core.datasheet.units import UNITS, expected
from slewline.errors import UsageError
from slewline.parts.motors.drivers import read_driver
from slewline.parts.motors.loads import FIGURES, check_holds, load_complaint, read_load
from slewline.parts.motors.motor_data import DriverData, LoadData
from slewline.parts.motors.motors import MOTORS, read_motor
from tests.rows import rows

A = MOTORS["QSH4218-51-10-049"]  # 0.49 N m at 1 A
TABLE = ", ".join(row.name for row in FIGURES)
KG_M2 = "0 or more kg m2, or text with a unit: " + ", ".join(UNITS["kg m2"])


@rows(
    ("value", "load"),
    [
        ({}, LoadData()),
        ("", LoadData()),
        ("inertia 68 g cm2", LoadData(inertia=6.8e-6)),
        (
            "inertia 68 g cm2, friction 5 mNm, torque 30 mNm",
            LoadData(inertia=6.8e-6, friction=5e-3, torque=30e-3),
        ),
        ("inertia = 68 g cm2,friction=5 mN m", LoadData(inertia=6.8e-6, friction=5e-3)),
        ("friction 5 mNm, stiction 8 mNm, torque -0.1 N m", LoadData(friction=5e-3, stiction=8e-3, torque=-0.1)),
        ({"friction": 5e-3, "stiction": None}, LoadData(friction=5e-3)),
        ({"friction": 5e-3, "stiction": 5e-3}, LoadData(friction=5e-3, stiction=5e-3)),
        (
            {"inertia": "272 gcm2", "stiffness": "10 Nm/rad", "coupling_drag": "1 mNm s", "viscous": 1e-4},
            LoadData(inertia=27.2e-6, stiffness=10.0, coupling_drag=1e-3, viscous=1e-4),
        ),
        (
            "damper_inertia 68 g cm2, damper_drag 7.452 mNm s",
            LoadData(damper_inertia=6.8e-6, damper_drag=7.452e-3),
        ),
        ("low -10, high 200", LoadData(low=-10 * A.step, high=200 * A.step)),
        ({"low": 0}, LoadData(low=0.0)),
        ({"high": 50.5}, LoadData(high=50.5 * A.step)),
    ],
)
def test_a_text_or_a_table_is_a_load(value, load):
    assert read_load(value, "l", A) == load
    assert read_load(load, "l", A) is load


def test_hard_stops_are_in_full_steps_of_the_motor():
    assert read_load({"low": -100, "high": 200}, "l", A) == LoadData(low=pytest.approx(-pi), high=pytest.approx(2 * pi))
    coarse = read_motor({"like": A.name, "teeth": 12})
    assert read_load({"high": 24}, "l", coarse).high == pytest.approx(pi)


@pytest.mark.parametrize(
    "value",
    [
        {"mass": "2 kg", "lead": "5 mm", "force": "10 N", "efficiency": 0.8, "vertical": True, "inertia": 1e-6},
        "mass 2 kg, lead 5 mm, force 10 N, efficiency 0.8, vertical, inertia 10 g cm2",
        "mass 2000 g, lead 0.005 m, force 0.01 kN, efficiency 0.8, vertical true, inertia 0.01 g m2, friction 0",
    ],
)
def test_a_linear_axis_turns_as_inertia_friction_and_torque(value):
    load = read_load(value, "l", A)
    if "0.01" in value:
        assert load.inertia == pytest.approx(1e-5 + 2 * (0.005 / (2 * pi)) ** 2, rel=1e-12)
    else:
        assert load.inertia == pytest.approx(2.2665148e-6, rel=1e-7)
    assert load.friction == pytest.approx(10 * 0.005 / (2 * pi) / 0.8, rel=1e-12)
    assert load.torque == pytest.approx(2 * 9.80665 * 0.005 / (2 * pi), rel=1e-12)


def test_the_load_of_an_axis_is_added_to_the_given_one():
    level = read_load({"mass": 2, "lead": 5e-3}, "l", A)
    assert (level.friction, level.torque) == (0.0, 0.0)
    more = read_load(
        {"mass": 2, "lead": 5e-3, "force": 1, "vertical": True, "friction": 1e-3, "torque": 2e-3, "stiction": 3e-3},
        "l",
        A,
    )
    assert more.friction == pytest.approx(1e-3 + 5e-3 / (2 * pi))
    assert more.torque == pytest.approx(2e-3 + 2 * 9.80665 * 5e-3 / (2 * pi))
    assert more.stiction == 3e-3
    coupled = read_load({"mass": 2, "lead": 5e-3, "stiffness": 10}, "l", A)
    assert coupled.stiffness == 10 and coupled.inertia > 0


def test_the_rows_of_a_table_begin_with_the_figures_of_a_load():
    names = [*LoadData.__slots__]
    assert [row.name for row in FIGURES[: len(names)]] == names
    assert {row.name: row.default for row in FIGURES[: len(names)]} == {
        each: getattr(LoadData(), each) for each in names
    }
    for row in FIGURES:
        assert row.checked("l", row.default) == row.default


@rows(
    ("value", "says"),
    [
        (5, f"l 5; expected text such as 'inertia 68 g cm2, friction 5 mNm', or a table (keys: {TABLE})"),
        ({"inertia": -1}, f"l: inertia -1; allowed {KG_M2}"),
        ("inertia -1 g cm2", f"l: inertia '-1 g cm2'; allowed {KG_M2}"),
        ("inertia", f"l: inertia ''; allowed {KG_M2}"),
        ("inertia 5 mNm", f"l: inertia '5 mNm'; mNm is a unit of torque; allowed {KG_M2}"),
        ("inertai 1", f"l: no option 'inertai'; its options: {TABLE}; did you mean inertia?"),
        ("friction 1, friction 1", "l 'friction 1, friction 1': friction is given twice; leave one out"),
        ({"friction": -1e-3}, f"l: friction -0.001; allowed 0 or more {expected('N m', 'N m')}"),
        ("low a", "l: low 'a'; allowed a number (full steps), None"),
        ("low 5, high 5", "l: 'low' 5; must be less than 'high' (5 full steps)"),
        ("friction 5 mNm, stiction 4 mNm", "l: stiction 0.004 N m; must be at least the friction (0.005 N m)"),
        ("efficiency 0", "l: efficiency 0.0; allowed more than 0, up to 1"),
        ("efficiency 1.2", "l: efficiency 1.2; allowed more than 0, up to 1"),
        ("mass 2 kg", "l: mass has no effect without lead; add lead, or leave mass out"),
        ("force 2 N", "l: force has no effect without lead; add lead, or leave force out"),
        ("lead 5 mm", "l: lead has no effect without mass or force; add mass or force, or leave lead out"),
        ("vertical", "l: vertical has no effect without mass; add mass, or leave vertical out"),
        (
            "inertia 1 kg m2, coupling_drag 1 N m s",
            "l: coupling_drag has no effect without stiffness; add stiffness, or leave coupling_drag out",
        ),
        (
            "stiffness 10 Nm/rad",
            "l: stiffness has no effect without inertia or mass; add inertia or mass, or leave stiffness out",
        ),
        (
            "damper_inertia 10 g cm2",
            "l: damper_inertia has no effect without damper_drag; add damper_drag, or leave damper_inertia out",
        ),
        (
            "damper_drag 1 mNms",
            "l: damper_drag has no effect without damper_inertia; add damper_inertia, or leave damper_drag out",
        ),
    ],
)
def test_an_impossible_load_is_refused_with_the_allowed_values(value, says):
    with pytest.raises(UsageError) as error:
        read_load(value, "l", A)
    assert str(error.value) == says


@pytest.mark.parametrize(
    ("changed", "current", "torque"),
    [
        ({}, 1.0, 0.49),
        ({}, 0.5, 0.245),
        ({"rated": "one"}, 1.0, 0.49 * sqrt(2)),
    ],
)
def test_the_holding_torque_follows_the_current_of_two_phases(changed, current, torque):
    assert read_motor({"like": A.name} | changed).holding_torque(current) == pytest.approx(torque, rel=1e-12)


def test_the_holding_torque_of_a_reluctance_motor_follows_the_square_of_the_current():
    given = {"current": 2, "resistance": 1, "inductance": "8 mH", "swing": "4 mH", "inertia": 1e-6, "teeth": 6}
    motor = read_motor(given | {"windings": "reluctance"})

    def phase(angle: float) -> float:
        return -0.5 * 6 * 4e-3 * 2**2 * sin(angle)

    most = max(phase(k * 1e-3) + phase(k * 1e-3 - pi / 2) for k in range(6284))
    assert motor.holding_torque(2.0) == pytest.approx(most, rel=1e-6)
    assert motor.holding_torque(4.0) == pytest.approx(4 * most, rel=1e-6)


END = "use a higher current, a stronger motor or a smaller load"


@rows(
    ("driver", "load", "says"),
    [
        ("24 V, 1 A", "torque 480 mNm", ""),
        ("24 V, 1 A", "torque 400 mNm, friction 80 mNm", ""),
        ("24 V, 1 A, rest 0.5 A", "torque 300 mNm, friction 60 mNm", ""),
        ("24 V, 1 A, slew 0.5 A", "torque 400 mNm", ""),  # at its ramp level it moves
        ("24 V, 1 A, ramp 0.5 A", "torque 400 mNm", ""),  # or at its slew level
        ("24 V, 1 A, rest 0 A", "friction 50 mNm", ""),
        ("24 V, 1 A, rest 0 A", "torque 50 mNm, friction 40 mNm, stiction 60 mNm", ""),
        (
            "24 V, 1 A",
            "torque 0.5 N m",
            f"0.5 N m at rest (0.5 less 0 of stiction); the {A.name} holds 0.49 N m at 1 A: {END}",
        ),
        (
            "24 V, 1 A",
            "torque -0.5 N m",
            f"0.5 N m at rest (0.5 less 0 of stiction); the {A.name} holds 0.49 N m at 1 A: {END}",
        ),
        (
            "24 V, 1 A, rest 0.5 A",
            "torque 0.3 N m, friction 0.04 N m",
            f"0.26 N m at rest (0.3 less 0.04 of stiction); the {A.name} holds 0.245 N m at 0.5 A: {END}",
        ),
        (
            "24 V, 1 A",
            "torque 0.45 N m, friction 0.05 N m",
            f"0.5 N m in motion (0.45 and 0.05 of friction); the {A.name} holds 0.49 N m at 1 A: {END}",
        ),
        (
            "24 V, 1 A, slew 0.5 A, ramp 0.6 A",
            "friction 0.3 N m",
            f"0.3 N m in motion (0 and 0.3 of friction); the {A.name} holds 0.294 N m at 0.6 A: {END}",
        ),
        (
            "L/4R 10 V",
            "torque 0.3 N m",
            f"0.3 N m at rest (0.3 less 0 of stiction); the {A.name} holds 0.245 N m at 0.5 A: {END}",
        ),
    ],
)
def test_a_load_that_the_motor_does_not_hold_is_refused(driver, load, says):
    data: DriverData = read_driver(driver, "d", A)
    if not says:
        check_holds(A, data, read_load(load, "l", A))
        return
    with pytest.raises(UsageError) as error:
        check_holds(A, data, read_load(load, "l", A), "p: load")
    assert str(error.value) == f"p: load: {says}"


def test_a_load_is_an_option_of_a_part():
    row = Option("load", "object", "", "what it drives", check=load_complaint)
    assert row.checked("p", row.default) == "" and row.checked("p", {"inertia": 1e-5}) == {"inertia": 1e-5}
    with pytest.raises(UsageError) as error:
        row.checked("p", {"inertia": -1})
    assert str(error.value) == f"p: load {{'inertia': -1}}; inertia -1; allowed {KG_M2}"
