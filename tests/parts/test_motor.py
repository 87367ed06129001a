"""Translator and rotor follow the outputs of the chip."""

from __future__ import annotations

import pytest

import slewline
from slewline.core.time.events import Even, NotYet
from slewline.core.wires.clocking import LOOKS
from slewline.core.wires.net import Driver, Net, Wave
from slewline.parts.shafts.followed_steps import FollowedSteps, MotorLimits, PulseFollowing

US = 1_000_000
MOVES = "A 1000\rO 0\rF 20\rR 90\rS 230\rZ 1\rN 300\rG\r-\rN 77\rG\rP 5\rP 2040\r"


@pytest.mark.fact("CIRCUIT-DRIVER-1")
def test_a_translator_needs_only_pulse_and_direction(circuit):
    c = circuit()
    motor = c.part("translator", to="x")
    wrong = []
    c.settle()
    behind = lambda: c.x.position - 1000 - motor.position  # noqa: E731
    motor.pin("pulse").net.watch(lambda _: wrong.append(c.x.position) if behind() else None)
    c.bench.host(c.x).send(MOVES)
    c.finish()
    assert c.x.position == 2040
    assert motor.position == 2040 - 1000
    assert c.x.travel == motor.position
    assert wrong == []


@pytest.mark.fact("CIRCUIT-DRIVER-1")
@pytest.mark.parametrize("pin", ["abort", "step_inhibit"])
def test_a_translator_keeps_the_position_through_an_abort_and_a_hold(circuit, pin):
    c = circuit()
    motor = c.part("translator", to="x")
    c.bench.host(c.x).send("A 0\rF 20\rR 90\rS 200\rZ 1\rN 2000\rG\r")
    c.settle()
    c.bench.run_until(c.x.reaches(700))
    c.x.pin(pin).drive(0 if pin == "abort" else 1)
    c.bench.run("250 ms")
    c.x.pin(pin).release()
    c.finish()
    assert c.x.position == motor.position
    assert (motor.position == 2000) == (pin == "step_inhibit")


@pytest.mark.fact("CIRCUIT-DRIVER-2")
def test_a_rotor_between_two_windings_follows_the_phases(circuit):
    c = circuit()
    rotor = c.part("rotor", to="x")
    wrong = []
    c.settle()
    rotor.pin("phase1").net.watch(lambda _: wrong.append(c.x.travel) if (c.x.travel - rotor.position) % 4 else None)
    c.bench.host(c.x).send(MOVES)
    c.finish()
    assert rotor.position == c.x.travel == 1040
    assert rotor.findings == []
    assert wrong == []
    assert rotor.field == rotor.position % 4


@pytest.mark.fact("CIRCUIT-DRIVER-2")
def test_a_rotor_without_current_stays_where_it_is(circuit):
    c = circuit()
    rotor = c.part("rotor", to="x")
    host = c.bench.host(c.x)
    host.send("A 0\rO 0\rF 3\rR 3\rS 255\rZ 1\rN 6\rG\rO 4\r")
    c.finish()
    assert (rotor.field, rotor.position) == (None, 6)
    host.send("-\rG\r")
    c.finish()
    assert rotor.position == 0


def test_a_rotor_cannot_follow_a_field_that_jumps_to_the_other_side(circuit):
    c = circuit()
    rotor = c.part("rotor", to="x")
    host = c.bench.host(c.x)
    host.send("O 0\rO 2\r")
    c.finish()
    assert rotor.position == 0
    assert c.codes("rotor") == ["rotor-lost"]
    host.send("O 3\r")
    c.finish()
    assert rotor.position == -1


def test_a_step_withdrawn_in_its_very_instant_is_not_counted_in_it():
    """The motor looks at its clock anew in the next round; one who is told in this one asks it before."""
    bench = slewline.Bench()
    motor = bench.part("translator", "m")
    pulse, other = Driver(motor.pin("pulse").net, "test"), Net(bench.kernel, "other")
    task = Driver(other, "test")
    asked = []
    other.watch(lambda _: asked.append(motor.position))
    bench.run(0)
    pulse.play(Wave(1, (US, 2 * US, 3 * US), (0, 1, 0)))
    bench.kernel.call_at(3 * US, lambda: (pulse.drive(1), task.drive(1)))
    bench.run("5 us")
    assert (asked, motor.position) == ([1], 1)


def test_a_motor_that_loses_every_pulse_does_not_know_yet_when_it_steps():
    pulses = Even(0, 10_000)
    steps = FollowedSteps(
        pulses, MotorLimits(0, pull_in=100.0, acceleration=0.0, loses=frozenset()), PulseFollowing(), 1
    )
    assert steps.time(1) == pulses.time(1)  # the one before was long ago
    assert steps.time(2) == NotYet(pulses.time(1 + LOOKS))
    assert steps.count(pulses.time(1 + LOOKS)) == 1
