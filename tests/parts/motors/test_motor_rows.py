"""Motors by name and by a table with figures."""

from __future__ import annotations

from math import pi, sqrt

import pytest

from slewline.core.datasheet.option import Option
from slewline.core.datasheet.units import expected
from slewline.errors import UnknownName, UsageError
from slewline.parts.motors.motor_data import MotorData
from slewline.parts.motors.motors import EXAMPLE, FIGURES, MOTORS, motor_complaint, motor_named, read_motor
from tests.rows import rows

NATURAL = {  # Hz, with two phases on at the rated current and without detent torque or load
    "QSH4218-35-10-027": 312.6,
    "QSH4218-41-10-035": 286.5,
    "QSH4218-51-10-049": 302.1,
    "QSH4218-47-28-040": 272.9,
    "QSH5718-41-28-055": 240.9,
    "QSH5718-51-28-101": 215.7,
    "QSH5718-56-28-126": 230.6,
    "QSH5718-76-28-189": 223.3,
    "QSH6018-45-28-110": 225.1,
    "QSH6018-56-28-165": 228.6,
    "QSH6018-65-28-210": 216.0,
    "QSH6018-86-28-310": 216.2,
    "AS1010": 293,
    "AS1030": 190,
    "AS1050": 206,
    "AS1060": 145,
    "SS2421-5041": 265,
    "SS2422-5041": 290,
    "17HS4401": 314,
}
SMALL = {"current": 1, "resistance": 5, "inductance": "8 mH", "torque": "490 mNm", "inertia": "68 gcm2"}
VR = {"windings": "reluctance", "current": 1, "resistance": 5, "inductance": "8 mH", "inertia": "68 gcm2"}
NAMES = ", ".join(MOTORS)
NEEDS = (
    "current (A: rated current of a phase), resistance (ohm: resistance of a phase), "
    "inductance (H: inductance of a phase; for a reluctance motor, its mean), "
    "torque (N m: holding torque at the rated current), inertia (kg m2: inertia of the rotor)"
)
TABLE = ", ".join(row.name for row in FIGURES)
ALLOWED = f"the name of a motor, text such as '{EXAMPLE}', or a table (keys: like, step_angle, {TABLE})"
OTHER = f"; for another motor use the figures of its data sheet: '{EXAMPLE}'"


@rows("name", MOTORS)
def test_every_row_is_a_motor_that_can_be(name):
    motor = MOTORS[name]
    assert (motor.name, motor.full_steps, motor.windings, motor.rated) == (name, 200, "bipolar", "two")
    assert motor.source
    assert motor.constant == pytest.approx(motor.torque / motor.current / sqrt(2), rel=1e-15)
    assert 0.02 < motor.constant < 1 and 1e-4 < motor.inductance / motor.resistance < 1e-2
    assert 0 <= motor.detent < 0.1 * motor.torque
    natural = sqrt(motor.teeth * motor.torque / motor.inertia) / (2 * pi)
    assert 100 < natural < 400
    if name in NATURAL:
        assert natural == pytest.approx(NATURAL[name], abs=0.06 if "QSH" in name else 0.8)
    assert read_motor({"like": name}) == MotorData(
        **{each: getattr(motor, each) for each in MotorData.__slots__} | {"name": f"like {name}"}
    )


def test_the_rows_of_a_table_are_the_figures_of_a_motor_with_the_same_defaults():
    assert [row.name for row in FIGURES] == [*MotorData.__slots__]
    own = {row.name: row.default for row in FIGURES if not row.required}
    plain = MotorData(name="own motor", source="own figures", current=1, resistance=1, inductance=1, inertia=1)
    assert own == {name: getattr(plain, name) for name in own}
    for row in FIGURES:
        assert row.required or row.checked("m", row.default) == row.default


def test_a_motor_by_its_name():
    motor = read_motor("QSH4218-51-10-049")
    assert motor is motor_named("QSH4218-51-10-049") is read_motor(motor)
    assert (motor.current, motor.resistance, motor.inductance, motor.inertia) == (1.0, 5.0, 8e-3, 6.8e-6)
    assert motor.constant == pytest.approx(0.346482, abs=1e-6)


def test_a_motor_by_its_figures():
    motor = read_motor(SMALL)
    row = MOTORS["QSH4218-51-10-049"]
    assert (motor.name, motor.source, motor.detent, motor.iron) == ("own motor", "own figures", 0.0, None)
    for name in SMALL:
        assert getattr(motor, name) == getattr(row, name)


def test_a_motor_like_another_one_lists_its_changes():
    motor = read_motor({"like": "QSH4218-51-10-049", "inertia": "80 g cm2", "iron": 0})
    row = MOTORS["QSH4218-51-10-049"]
    assert (motor.inertia, motor.iron, motor.torque, motor.detent) == (8e-6, 0.0, row.torque, row.detent)
    assert motor.name == "like QSH4218-51-10-049"
    assert motor.source == "Trinamic, QSH4218 manual, V1.10; changed: inertia, iron"
    assert read_motor({"like": "AS1010", "name": "z axis"}).name == "z axis"


def test_a_reluctance_motor_has_a_swing_and_its_phases_produce_its_steps():
    motor = read_motor(VR | {"swing": "4 mH", "teeth": 6})
    assert (motor.full_steps, motor.swing, motor.torque) == (24, 4e-3, 0.0)
    assert read_motor(VR | {"swing": "4 mH", "teeth": 8, "phases": 3}).step == pytest.approx(2 * pi / 24)


@rows(
    ("value", "says"),
    [
        (5, f"m 5; expected {ALLOWED}"),
        ({"like": 5}, "m: 'like' is 5; expected the name of a motor, such as QSH4218-35-10-027"),
        ({}, f"m needs {NEEDS}; write, for example, '{EXAMPLE}', or add 'like' and the name of a motor"),
        (SMALL | {"current": 0}, "m: current 0; allowed more than 0 A"),
        (SMALL | {"current": "-1 A"}, "m: current '-1 A'; allowed more than 0 A"),
        (SMALL | {"resistance": 0}, "m: resistance 0; allowed more than 0 ohm"),
        (SMALL | {"inductance": "0 mH"}, "m: inductance '0 mH'; allowed more than 0 H"),
        (SMALL | {"inertia": "0 g cm2"}, "m: inertia '0 g cm2'; allowed more than 0 kg m2"),
        (SMALL | {"inertia": -1e-6}, "m: inertia -1e-06; allowed more than 0 kg m2"),
        (SMALL | {"inertia": "68 g"}, f"m: inertia '68 g'; g is a unit of mass; allowed {expected('kg m2')}"),
        (
            SMALL | {"detent": -1e-3},
            f"m: detent -0.001; allowed {expected('N m', '0 or more N m')}",
        ),
        (SMALL | {"teeth": 0}, "m: teeth 0; allowed 1 or more"),
        (SMALL | {"rated": "both"}, "m: rated 'both'; allowed two, one"),
        (SMALL | {"windings": "delta"}, "m: windings 'delta'; allowed bipolar, unipolar, reluctance"),
        (
            SMALL | {"resistence": 5},
            f"m: no option 'resistence'; its options: {TABLE}, like, step_angle; did you mean resistance?",
        ),
        (
            SMALL | {"torque": 0},
            "m: torque 0 N m; must be more than the detent torque (0 N m): "
            "give the holding torque at the rated current",
        ),
        (
            SMALL | {"detent": 0.49},
            "m: torque 0.49 N m; must be more than the detent torque (0.49 N m): "
            "give the holding torque at the rated current",
        ),
        (SMALL | {"swing": "1 mH"}, "m: swing 0.001 H; only a reluctance motor has a swing: leave it out"),
        (
            VR,
            "m needs swing (H: amplitude of the inductance of a reluctance motor around its mean); "
            f"write, for example, '{EXAMPLE}', or add 'like' and the name of a motor",
        ),
        (
            VR | {"swing": "8 mH"},
            "m: swing 0.008 H of a reluctance motor; must be more than 0 and less than the inductance (0.008 H)",
        ),
        (VR | {"swing": "4 mH", "phases": 2}, "m: phases 2; allowed 3 or more"),
    ],
)
def test_an_impossible_figure_is_refused_with_its_place_and_the_allowed_values(value, says):
    with pytest.raises(UsageError) as error:
        read_motor(value, "m")
    assert str(error.value) == says


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("qsh4218-51-10-049", f"m 'qsh4218-51-10-049'; known: {NAMES}; did you mean QSH4218-51-10-049?"),
        ("NEMA", f"m 'NEMA'; known: {NAMES}{OTHER}"),
        ({"like": "AS101"}, f"m: 'like' is 'AS101'; known: {NAMES}{OTHER}"),
    ],
)
def test_an_unknown_motor_is_refused_with_the_known_ones(value, says):
    with pytest.raises(UnknownName) as error:
        read_motor(value, "m")
    assert str(error.value) == says


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("AS101", f"p: motor 'AS101'; known: {NAMES}{OTHER}"),
        ({"like": "AS1010", "inertia": 0}, "inertia': 0}; inertia 0; allowed more than 0 kg m2"),
        (5, f"p: motor 5; expected {ALLOWED}"),
    ],
)
def test_a_motor_is_an_option_of_a_part(value, says):
    row = Option("motor", "object", "QSH4218-51-10-049", "the motor", check=motor_complaint)
    assert row.checked("p", row.default) == row.default
    assert row.checked("p", SMALL) == SMALL
    with pytest.raises(UsageError) as error:
        row.checked("p", value)
    assert str(error.value).endswith(says)
