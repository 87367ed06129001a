"""Pull-out torque as it is measured, against the closed form for a supply behind resistors."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, pi

import pytest

import slewline
from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.pull_out import pull_out


def closed(law, rate):
    """Square voltages by their first harmonic; drag is taken off."""
    motor, resistance, speed = law.motor, law.resistance, rate * law.motor.step
    impedance = hypot(resistance, motor.teeth * speed * motor.inductance)
    driven = motor.constant * 4 / pi * law.driver.supply / impedance
    return driven - motor.constant**2 * speed * resistance / impedance**2 - motor.drag * speed


def test_a_motor_behind_resistors_has_the_torque_of_the_formula():
    law = slewline.motor_law(
        {"like": "QSH4218-51-10-049", "detent": 0, "iron": 2e-4}, "L/4R 20 V", "inertia 270 g cm2", step_ps=50_000_000
    )
    rates = (400, 1600)
    assert pull_out(law, rates) == pytest.approx([closed(law, rate) for rate in rates], rel=0.04)


def test_a_load_takes_its_part_and_a_rate_too_high_leaves_none():
    law = slewline.motor_law(driver="L/4R 20 V", load="inertia 270 g cm2", step_ps=50_000_000)
    loaded = MotorLaw(law.motor, law.driver, replace(law.load, torque=0.05), law.steps, law.step_ps)
    (without,), (beside,) = pull_out(law, [800]), pull_out(loaded, [800])
    assert without - beside == pytest.approx(0.05, abs=0.01)
    assert pull_out(law, [9000]).tolist() == [0.0]
