"""Constants that no sheet has come out of what they make a motor do."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest

from slewline.errors import UsageError
from slewline.parts.motors import calibration as room
from slewline.parts.motors.calibration import calibrate
from slewline.parts.motors.drivers import read_driver
from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.motor_data import LoadData
from slewline.parts.motors.motors import MOTORS
from tests.rows import rows

MOTOR = MOTORS["QSH4218-51-10-049"]
DRIVER = read_driver("L/4R 20 V", "driver", MOTOR)
LOAD = LoadData(inertia=68e-7, friction=8e-3)
REAL = replace(MOTOR, iron=1.0e-3)


def limit(does, low, high):
    """The greatest whole number for which it does."""
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if does(middle) else (low, middle)
    return low


@cache
def measured(motor, load):
    """What would be measured on such a motor: the rate at which it starts, and at which it stalls."""
    law = MotorLaw(motor, DRIVER, load)
    return limit(lambda rate: room._starts(law, rate), 800, 1600), limit(
        lambda rate: room._comes_to(law, rate), 1800, 3600
    )


def test_measurements_determine_both_constants():
    starts, stalls = measured(REAL, LOAD)
    found = calibrate(MOTOR, DRIVER, replace(LOAD, friction=0.0), start_stop=starts, pull_out=stalls)
    assert found.friction == pytest.approx(8e-3, rel=0.05) and found.iron == pytest.approx(1e-3, rel=0.03)
    assert (found.load.friction, found.motor.iron) == (found.friction, found.iron)
    assert found.before == (0.0, MOTOR.drag)
    law = MotorLaw(found.motor, DRIVER, found.load)
    for does, rate in ((room._starts, starts), (room._comes_to, stalls)):  # what is measured on it is the same to 1 %
        assert does(law, 0.99 * rate) and not does(law, 1.01 * rate)


def test_one_measurement_gives_one_constant():
    starts, stalls = measured(REAL, LOAD)
    only = calibrate(REAL, DRIVER, replace(LOAD, friction=0.0), start_stop=starts)
    assert only.friction == pytest.approx(8e-3, rel=0.03) and only.iron is None and only.motor == REAL
    only = calibrate(MOTOR, DRIVER, LOAD, pull_out=stalls)
    assert only.iron == pytest.approx(1e-3, rel=0.02) and only.friction is None and only.load == LOAD


def test_a_torque_at_the_stall_counts():
    loaded = replace(LOAD, torque=50e-3)
    law = MotorLaw(REAL, DRIVER, loaded)
    stalls = limit(lambda rate: room._comes_to(law, rate), 1000, 3000)
    found = calibrate(MOTOR, DRIVER, LOAD, pull_out=stalls, torque=50e-3)
    assert found.iron == pytest.approx(1e-3, rel=0.03) and found.load == LOAD


@rows(
    ("given", "says"),
    [
        ({}, "nothing to calibrate with; set a start-stop rate, a pull-out rate, or both"),
        ({"start_stop": 5000}, "start-stop rate 5000 steps/s: this motor does not reach it even without friction"),
        ({"pull_out": 9000}, "pull-out rate 9000 steps/s: this motor does not reach it even without iron loss"),
        ({"pull_out": 0.0}, "pull-out rate 0 steps/s; allowed 20 to 100000 full steps/s"),
        ({"start_stop": 2e5}, "start-stop rate 200000 steps/s; allowed"),
    ],
)
def test_impossible_measurements_are_reported(given, says):
    with pytest.raises(UsageError, match=says.replace("(", r"\(")):
        calibrate(MOTOR, DRIVER, LOAD, **given)


def test_more_than_the_motor_could_with_any_constant_is_reported():
    with pytest.raises(UsageError, match="it: this motor is faster than that even with a drag of 3"):
        room._greatest(lambda constant: True, 3.0, "it", "drag", "a drag of 3")


def test_a_law_is_that_of_the_part():
    import slewline

    law = slewline.motor_law("17HS4401", "24 V, 1 A", "inertia 54 g cm2", steps="half")
    part = slewline.Bench().part(
        "stepper", "m", motor="17HS4401", driver="24 V, 1 A", load="inertia 54 g cm2", steps="half"
    )
    assert law == part._law
    with pytest.raises(UsageError, match=r"load: 2 N m at rest"):
        slewline.motor_law(load="torque 2 N m")
