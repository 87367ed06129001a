"""A motor behind a module, in virtual time: the module is driven as its sheet says, and knows nothing of it."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline.testing  # pySerial knows slewline://
from slewline.chips import ramps_of, sheet_of
from slewline.errors import UsageError
from slewline.labs import module_motor as labs
from slewline.labs.module_motor import ModuleMotor
from slewline.modules.failures import NoAnswer, PortLost, RefusedCommand
from slewline.modules.finding import find

pytest.importorskip("serial")

GSC = {"S": 10, "T": "1000 steps/s", "R": 50}
CY545 = {"F": 20, "R": 100, "S": 200}
KINDS = {
    "gs-c200s": ("slewline://gs-c200s?chs=0", GSC),
    "gs-c200s with checksums": ("slewline://gs-c200s", GSC),
    "gs-c200": ("slewline://gs-c200?chs=0", GSC),
    "cy545": ("slewline://cy545", CY545),
    "cy545b": ("slewline://cy545b", CY545),
}


@pytest.fixture
def motor_at():
    """Return a motor behind a module at a URL."""
    opened = []

    def make(url, values, **more):
        sheet = sheet_of(url.partition("//")[2].partition("?")[0])
        module = find(url, sheet, may_move=True)
        opened.append(module.port)
        return ModuleMotor(module, ramps_of(sheet.part), values, **more)

    yield make
    for port in opened:
        port.close()


def chip_of(motor):
    return motor.module.port.line.chip


def over(motor):
    """Let the motor come to rest; return how often it was asked."""
    asked = 1
    while not motor.at_rest():
        asked += 1
        assert asked < 1000
    return asked


@pytest.mark.parametrize("kind", KINDS)
def test_a_motor_moves_to_positions_and_is_known_to_be_there(motor_at, kind):
    motor = motor_at(*KINDS[kind])
    for target in (1200, 300, 300, 0):
        motor.move(target)
        assert over(motor) >= 1
        assert chip_of(motor).idle or motor.entered  # nothing was said before it was over
        assert motor.position == target == chip_of(motor).position
    assert len(chip_of(motor).steps()) == 1200 + 900 + 300
    assert [found.code for found in chip_of(motor).findings if found.code not in ("E1", "direction-inferred")] == []


@pytest.mark.parametrize("kind", ["gs-c200s", "gs-c200"])
def test_a_motor_is_stopped_by_a_ramp(motor_at, kind):
    motor = motor_at(*KINDS[kind])
    motor.move(50_000)
    assert [motor.at_rest() for _ in range(4)] == [False] * 4
    motor.stop()
    over(motor)
    assert 100 < motor.position < 1000
    assert _intervals(motor)[-1] > 5 * min(_intervals(motor))
    assert motor.position == chip_of(motor).position
    motor.move(0)
    over(motor)
    assert motor.position == 0


def test_a_part_that_takes_no_command_while_it_moves_cannot_be_stopped(motor_at):
    motor = motor_at(*KINDS["cy545"])
    with pytest.raises(UsageError, match="accepts no command while the motor moves"):
        motor.stop()


def test_a_motor_homes_in_the_requested_direction(motor_at):
    motor = motor_at(*KINDS["gs-c200s"])
    motor.move(40)  # the speeds are known from then on
    over(motor)
    for switch in ("eot", "home"):
        chip_of(motor).pin(switch).drive(0)
    motor.home(-1)
    over(motor)
    assert motor.position == chip_of(motor).position == 0


def test_a_position_is_set_without_motion(motor_at):
    for kind, position in (("gs-c200s", -77), ("cy545", 5000)):
        motor = motor_at(*KINDS[kind])
        motor.preset(position)
        assert motor.position == chip_of(motor).position == position
        assert chip_of(motor).steps().times_ps.size == 0
        with pytest.raises(UsageError, match=r"position 99999999 steps; allowed "):
            motor.preset(99999999)
    with pytest.raises(UsageError, match="no command that sets the position"):
        motor_at(*KINDS["gs-c200"]).preset(0)


def test_a_part_that_needs_an_input_for_it_does_not_home(motor_at):
    motor = motor_at(*KINDS["cy545"])
    with pytest.raises(UsageError, match="no homing command with a selectable direction"):
        motor.home(1)


def test_rates_are_those_of_the_ramp_and_may_change(motor_at):
    motor = motor_at(*KINDS["gs-c200s"])
    assert (motor.ramp.start, motor.ramp.top, motor.fastest) == (100, 1000, 10_000)
    ramp = motor.fitted(200, 2004, 0.05)  # it counts in tens
    assert (ramp.start, ramp.top) == (200, 2000)
    assert ramp.time_ps / 1e12 == pytest.approx(0.05, rel=0.03)
    for rate in (0, 1e9):
        with pytest.raises(UsageError, match="allowed"):
            motor.fitted(200, rate, 0.05)
    motor.move(3000, ramp)
    over(motor)
    assert min(interval for interval in _intervals(motor)) == pytest.approx(5e8, rel=0.01)  # ps: 2000 steps/s
    motor.move(6000)
    over(motor)
    assert min(interval for interval in _intervals(motor)[3001:]) == pytest.approx(1e9, rel=0.01)


def _intervals(motor):
    times = chip_of(motor).steps().times_ps
    return [later - earlier for earlier, later in pairwise(times)]


def test_a_foreign_program_is_seen_and_our_own_is_not(motor_at):
    motor = motor_at(*KINDS["gs-c200s"])
    assert motor.foreign_program() == 0
    motor.move(10)
    over(motor)
    assert motor.foreign_program() == 0
    for line in ("Po", "S10", "T100", "R50", "+200", "W1", "Px"):
        motor.module.ask(line)
    assert motor.foreign_program() == 5


def test_a_motion_that_is_refused_leaves_program_entry(motor_at):
    motor = motor_at(*KINDS["gs-c200s"])
    motor.values = {**motor.values, "R": 5000}  # more than the part takes
    with pytest.raises(RefusedCommand, match="R5000 was answered with E"):
        motor.move(10)
    assert not motor.module.entering
    assert motor.at_rest()
    assert chip_of(motor).steps().times_ps.size == 0


def test_a_chip_that_never_answers_is_given_up(motor_at, monkeypatch):
    monkeypatch.setattr(labs, "LATE_S", 1.0)
    motor = motor_at(*KINDS["cy545"])
    motor.move(4000)
    chip_of(motor).pin("inhibit_abort").drive(0)  # it never begins
    with pytest.raises(NoAnswer):
        over(motor)


def test_a_lost_port_is_reported(motor_at):
    motor = motor_at(*KINDS["gs-c200s"])
    motor.module.port.line.close()
    with pytest.raises(PortLost, match="the port is gone"):
        motor.move(10)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"S": 10, "R": 50}, "no value for T"),
        ({"S": 10, "T": 2000, "R": 50}, r"T 2000; allowed 1..1000"),
        ({"S": 10, "T": 100, "R": 50, "X": 1}, "no parameter 'X'"),
    ],
)
def test_a_motor_needs_the_parameters_of_its_ramp(motor_at, values, says):
    with pytest.raises(slewline.errors.SlewlineError, match=says):
        motor_at("slewline://gs-c200s?chs=0", values)
