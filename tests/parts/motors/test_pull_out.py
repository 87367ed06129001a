"""Pull-out torque as it is measured, against the closed form for a supply behind resistors."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, pi

import pytest

import slewline
from slewline.errors import UsageError
from slewline.parts.motors.law import MotorLaw
from slewline.parts.motors.pull_out import PullOutPoint, pull_out
from tests.rows import rows


def closed(law, rate):
    """Square voltages by their first harmonic; drag is taken off."""
    motor, resistance, speed = law.motor, law.resistance, rate * law.motor.step
    impedance = hypot(resistance, motor.teeth * speed * motor.inductance)
    driven = motor.constant * 4 / pi * law.driver.supply / impedance
    return driven - motor.constant**2 * speed * resistance / impedance**2 - motor.drag * speed


def test_a_motor_with_series_resistors_has_the_torque_of_the_formula():
    law = slewline.motor_law(
        {"like": "QSH4218-51-10-049", "detent": 0, "iron": 2e-4}, "L/4R 20 V", "inertia 270 g cm2", step_ps=50_000_000
    )
    rates = (400, 1600)
    found = [point.torque for point in pull_out(law, rates, neighbours=False)]
    assert found == pytest.approx([closed(law, rate) for rate in rates], rel=0.04)


def test_a_load_takes_its_part_and_a_rate_too_high_leaves_none():
    law = slewline.motor_law(driver="L/4R 20 V", load="inertia 270 g cm2", step_ps=50_000_000)
    loaded = MotorLaw(law.motor, law.driver, replace(law.load, torque=0.05), law.steps, law.step_ps)
    (without,), (beside,) = pull_out(law, [800], neighbours=False), pull_out(loaded, [800], neighbours=False)
    assert without.torque - beside.torque == pytest.approx(0.05, abs=0.01)
    (fast,) = pull_out(law, [9000])
    assert (fast.torque, fast.isolated, [torque for _, torque in fast.neighbours]) == (0.0, "", [0.0, 0.0])


def test_a_rate_may_be_in_turns_of_the_motor():
    law = slewline.motor_law({"like": "QSH4218-51-10-049", "teeth": 100}, "L/4R 20 V", step_ps=50_000_000)
    (turns,), (steps,) = pull_out(law, ["120 rpm"], neighbours=False), pull_out(law, [800], neighbours=False)
    assert turns == steps and turns.rate == 800.0
    for rate, says in (
        (0, "allowed 20 to 100000 full"),
        ("-75 rpm", "-500 steps/s; allowed"),
        ("1e9 rpm", "allowed 20 to"),
        ("3 Nm", "Nm is a unit of torque"),
    ):
        with pytest.raises(UsageError, match=says):
            pull_out(law, [rate])


def test_a_chopper_that_beats_with_the_steps_makes_an_isolated_success():
    # 20 kHz are 10 periods a step at 2000 steps/s; there both windings are switched at the same places of each step.
    clocked = slewline.motor_law(
        "QSH5718-51-28-101", "24 V, 2.8 A chopper, 20 kHz", "inertia 100 g cm2, friction 5 mNm"
    )
    (point,) = pull_out(clocked, [2000])
    assert point.isolated == "success" and point.torque > 0.1 * point.holding + max(t for _, t in point.neighbours)
    assert [rate for rate, _ in point.neighbours] == pytest.approx([1988, 2012])
    assert (
        "2000 steps/s: " in str(point)
        and "N m, an isolated success: " in str(point)
        and " at 1988 steps/s" in str(point)
    )
    averaged = slewline.motor_law("QSH5718-51-28-101", "24 V, 2.8 A", "inertia 100 g cm2, friction 5 mNm")
    (point,) = pull_out(averaged, [2000])
    assert point.isolated == "" and "isolated" not in str(point)


def test_and_at_another_rate_an_isolated_failure():
    # The clock beats with the steps at 20,000 - 9 x 2200 = 200 Hz, near the 255 Hz at which this rotor swings undamped.
    light = slewline.motor_law({"like": "QSH4218-47-28-040", "iron": 0}, "24 V, 2.8 A chopper", "inertia 10 g cm2")
    (point,) = pull_out(light, [2200])
    assert point.isolated == "failure" and point.torque + 0.1 * point.holding < min(t for _, t in point.neighbours)
    assert " N m, an isolated failure: " in str(point)


def test_an_interrupt_reports_the_number_of_finished_rates(monkeypatch):
    left = iter(range(7))

    def interrupted(_law, _rate):
        if next(left, None) is None:
            raise KeyboardInterrupt
        return 0.1

    monkeypatch.setattr("slewline.parts.motors.pull_out._at", interrupted)
    with pytest.raises(KeyboardInterrupt, match="interrupted after 2 of 5 rates; nothing is kept"):
        pull_out(slewline.motor_law(), range(1000, 6000, 1000))


@rows(
    ("torques", "isolated"),
    [
        ((0.3, 0.3, 0.3), ""),
        ((0.3, 0.0, 0.3), "failure"),
        ((0.3, 0.25, 0.3), "failure"),
        ((0.3, 0.27, 0.3), ""),
        ((0.0, 0.3, 0.1), "success"),
        ((0.3, 0.1, 0.0), ""),  # a slope
        ((0.0, 0.0, 0.3), ""),
    ],
)
def test_a_rate_is_isolated_if_both_neighbours_differ_alike(torques, isolated):
    low, own, high = torques
    point = PullOutPoint(2000.0, own, ((1988.0, low), (2012.0, high)), 0.4)
    assert point.isolated == isolated and (f"isolated {isolated}: " in str(point)) == bool(isolated)
    assert point._replace(neighbours=()).isolated == ""
