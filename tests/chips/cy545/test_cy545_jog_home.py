"""The CY545's JOG and HOME: single steps between commands, and the edge of a sensor, always from the same side."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from random import Random
from typing import Any

import pytest
from cy545 import MS, US, Rig545, near, periods, steppable

import slewline
from slewline.chips.cy545 import sheet
from slewline.core.wires.net import Driver

PINS = ("pulse", "ccw", "stopped", "slew", "usrb0")
RATES = sheet.TABLES["20k"]
rigged = partial(steppable, PINS)


# ----------------------------------------------------------------------------------------------------------------- jog
@pytest.mark.fact("CY545-JOG-1", "CY545-JOG-5", "CY545-JOG-13", "CY545-JOG-7", "CY545-JOG-12")
def test_jog_open_rests_low_steps_clockwise_and_high_counter_clockwise() -> None:
    rig = rigged()
    rig.bench.run("1 s")
    assert not rig.falls("pulse")
    rig.drive("jog", 0)
    rig.bench.run("1 s")
    assert len(rig.falls("pulse")) in (18, 19)  # 370 / 20 a second, straight after reset
    assert rig.x.position == len(rig.falls("pulse"))
    rig.drive("jog", 1)
    rig.bench.run("1 s")
    assert rig.x.position <= 1
    directions = rig.x.steps().directions.tolist()
    assert directions == sorted(directions, reverse=True) and set(directions) == {1, -1}
    rig.x.pin("jog").release()
    rig.bench.run("100 ms")
    count = len(rig.falls("pulse"))
    rig.bench.run("1 s")
    assert len(rig.falls("pulse")) == count


@pytest.mark.fact("CY545-JOG-2")
def test_only_a_driver_of_the_line_jogs_and_a_pull_of_the_bench_does_not() -> None:
    rig = rigged()
    loose = Driver(rig.x.pin("jog").net, "loose")
    loose.drive(None)
    rig.bench.run("1 s")
    assert rig.level("jog") is None and not rig.falls("pulse")
    loose.drive(1)
    rig.bench.run("1 s")
    assert rig.falls("pulse")


@pytest.mark.fact("CY545-JOG-3", "CY545-JOG-6", "CY545-JOG-11")
def test_jog_waits_for_commands_and_resumes_after_them() -> None:
    rig = rigged("F 100")
    rig.drive("jog", 0)
    rig.start("D 1000\r")
    began = rig.bench.now_ps
    rig.bench.run("900 ms")
    assert len(rig.falls("pulse", began)) <= 1
    rig.bench.run("300 ms")
    assert len(rig.falls("pulse", began)) > 10
    rig.start("B 16\r")
    rig.bench.run("100 ms")
    assert rig.level("usrb0") == 0
    before = rig.bench.now_ps
    assert all(near(period, 20e12 / RATES[100], 1) for period in periods(rig, before - 50 * MS))
    rig.start("F 200\r")
    rig.bench.run("20 ms")
    now = rig.bench.now_ps
    rig.bench.run("100 ms")
    assert all(near(period, 20e12 / RATES[200], 1) for period in periods(rig, now))


@pytest.mark.fact("CY545-JOG-4", "CY545-UND-JOG-SETTLE")
def test_ccw_shows_the_direction_of_jog_in_each_step_and_the_programmed_one_between_and_after() -> None:
    rig = rigged("-", "F 200")
    rig.drive("jog", 0)
    rig.bench.run("20 ms")
    rig.x.pin("jog").release()
    rig.bench.run("20 ms")
    falls, changes = rig.falls("pulse"), rig.edges("ccw")
    assert rig.level("ccw") == 1 and len(changes) == 2 * len(falls)
    for fall, (low, to_low), (high, to_high) in zip(falls, changes[::2], changes[1::2], strict=True):
        assert (to_low, to_high) == (0, 1)
        assert fall - low >= 20 * US and high - fall > 5 * US
    rig.send("N 2\rG\r")
    assert rig.x.position == len(falls) - 2


@pytest.mark.fact("CY545-JOG-8", "CY545-JOG-10")
@pytest.mark.parametrize(("first", "per_s"), [(0, 1.0), (36, 46.0), (255, 1000.0)])
def test_jog_steps_at_a_twentieth_of_the_first_rate_without_ramps(first: int, per_s: float) -> None:
    rig = rigged(f"F {first}", "R 255")
    rig.drive("jog", 0)
    rig.bench.run(f"{round(6000 / per_s)} ms")
    gaps = periods(rig)
    assert len(gaps) >= 3 and len({round(gap, -6) for gap in gaps}) == 1
    assert near(gaps[0], 1e12 / per_s, 0.01)
    assert not rig.edges("slew")


@pytest.mark.fact("CY545-JOG-9", "CY545-CON-RATE-TOP")
def test_the_other_rate_table_jogs_up_to_1351_a_second() -> None:
    rig = rigged("F 255", rate_table="27k")
    rig.drive("jog", 0)
    rig.bench.run("10 ms")
    assert near(periods(rig)[0], 1e12 / 1351.4, 0.1)


@pytest.mark.fact("CY545-JOG-14", "CY545-JOG-15", "CY545-DER-MB4-SLOW")
def test_with_bit_4_of_the_mode_the_position_follows_each_jog_step_and_slows_it_down() -> None:
    rig = rigged(serial=True, fixed_baud=9600)
    rig.send("F 255\rO 90H\r")
    rig.drive("jog", 0)
    rig.bench.run("60 ms")
    rig.x.pin("jog").release()
    rig.bench.run("30 ms")
    count = rig.x.position
    assert 4 <= count <= 6
    expected = "".join(f"P={place:08}\r" for place in range(1, count + 1))
    assert bytes(rig.serial.received).decode() == expected
    assert all(gap > 11.4 * MS for gap in periods(rig))


@pytest.mark.fact("CY545-UND-STOPPED-OTHER")
def test_stopped_is_low_from_the_first_jog_step_until_5_ms_after_the_last_one() -> None:
    rig = rigged("F 255")
    rig.drive("jog", 0)
    rig.bench.run("20500 us")
    rig.x.pin("jog").release()
    rig.bench.run("20 ms")
    (low, _), (high, _) = rig.edges("stopped")
    falls = rig.falls("pulse")
    assert 20 * US <= falls[0] - low <= 100 * US
    assert near(high - falls[-1], 6 * MS, 0.1)
    (motion,) = rig.x.motions()
    assert (motion.text, motion.end.why, motion.end.steps) == ("JOG", "done", len(falls))


@pytest.mark.fact("CY545-UND-LIMIT-JOG", "CY545-UND-INHIB-JOG")
def test_a_limit_ends_jog_in_its_direction_and_inhibit_abort_does_not() -> None:
    rig = rigged("F 255")
    rig.drive("inhibit_abort", 0)
    rig.drive("jog", 0)
    rig.bench.run("20 ms")
    assert rig.x.position >= 19
    rig.drive("cw_limit", 0)
    rig.bench.run("10 ms")
    here = rig.x.position
    rig.bench.run("1 s")
    assert rig.x.position == here <= 22
    rig.drive("jog", 1)
    rig.bench.run("10 ms")
    assert here - 11 <= rig.x.position < here
    rig.drive("jog", 0)
    rig.bench.run("10 ms")
    here = rig.x.position
    rig.bench.run("1 s")
    assert rig.x.position == here
    rig.drive("cw_limit", 1)
    rig.bench.run("100 ms")
    assert rig.x.position > here + 90  # it steps again as soon as the limit is high


@pytest.mark.fact("CY545-UND-LIMIT-JOG")
@pytest.mark.parametrize(("limit", "steps"), [("cw_limit", 0), ("ccw_limit", 1)])
def test_jog_goes_by_the_limit_of_the_direction_to_which_ccw_is_forced(limit: str, steps: int) -> None:
    rig = rigged("-", "F 255", "A 1000")
    rig.drive("ccw", 0)  # clockwise, whatever JOG says
    rig.drive(limit, 0)
    rig.drive("jog", 1)
    rig.bench.run("20 ms")
    made = rig.x.position - 1000
    assert made >= 15 * steps and rig.x.steps().directions.tolist() == [1] * made
    rig.x.pin("ccw").release()  # now JOG says it
    here = rig.x.position
    rig.bench.run("20 ms")
    assert here - rig.x.position >= 15 * (1 - steps) and rig.x.position <= here + 1


@pytest.mark.fact("CY545-UND-CONT-LASTS")
@pytest.mark.parametrize("motion", ["G", "P 5", "limited", "N 0"])
def test_c_lasts_through_jog_and_home_to_the_end_of_the_next_motion(motion: str) -> None:
    rig = rigged("+", "F 255", "R 255", "N 3", "C")
    rig.drive("jog", 0)
    rig.bench.run("5 ms")
    rig.x.pin("jog").release()
    rig.bench.run("10 ms")
    rig.drive("usrb0", 0)
    rig.start("H 0\r")
    rig.bench.run("5 ms")
    rig.x.pin("usrb0").release()
    rig.bench.run_until_idle()
    if motion == "limited":
        rig.drive("cw_limit", 0)
    rig.start({"G": "G\r", "limited": "G\r", "N 0": "N 0\rG\r"}.get(motion, f"{motion}\r"))
    rig.bench.run("50 ms")
    assert rig.x.moving is (motion != "limited")
    rig.drive("inhibit_abort", 0)
    rig.bench.run_until_idle()
    rig.x.pin("inhibit_abort").release()
    rig.x.pin("cw_limit").drive(1)
    before = rig.x.travel
    rig.send("N 3\rG\r")
    assert rig.x.travel == before + 3


@pytest.mark.fact("CY545-UND-JOG-PROGRAM")
def test_jog_waits_for_the_end_of_a_program() -> None:
    rig = Rig545(*PINS, replies=False)
    rig.enter("D 50", "D 50", "0")
    rig.host.send("F 255\rY 0\rX\r")
    rig.bench.run("20 ms")
    rig.drive("jog", 0)
    rig.bench.run("60 ms")
    assert not rig.falls("pulse")
    rig.bench.run("60 ms")
    assert rig.falls("pulse")


# ---------------------------------------------------------------------------------------------------------------- home
class Machine:
    """A CY545 that moves a carriage; a switch pulls USRB0 low below place 0, so the sensor tells the side."""

    def __init__(
        self, start: float, backlash: float = 0, sensor: tuple[float | None, float | None] = (None, 0), **options: Any
    ) -> None:
        self.bench = bench = slewline.Bench()
        self.x = bench.add("cy545", "x", **options)
        motor = bench.part("motor", "motor", to=self.x)
        self.carriage = bench.part("carriage", "carriage", on=motor, backlash=backlash, start=start)
        self.switch = bench.part("switch", "home", on=self.carriage, low=sensor[0], high=sensor[1])
        bench.wire("home.out", "x.usrb0")
        self.host = bench.host(self.x)

    def home(self, command: str = "H 0", timeout: str = "300 s") -> float:
        """Send a command; return where the carriage is then."""
        self.host.send(f"F 255\r{command}\r")
        self.bench.run_until_idle(timeout)
        return self.carriage.place


@pytest.mark.fact("CY545-HOME-1", "CY545-HOME-5", "CY545-HOME-6", "CY545-HOME-3")
def test_home_steps_clockwise_to_the_first_match_and_makes_it_zero() -> None:
    machine = Machine(-50)
    assert machine.home() == 0
    steps = machine.x.steps()
    assert machine.x.position == 0 and steps.directions.tolist() == [1] * 50
    gaps = [b - a for a, b in pairwise(steps.times_ps.tolist())]
    assert all(near(gap, MS, 0.01) for gap in gaps)
    (motion,) = machine.x.motions()
    assert (motion.text, motion.end.why, motion.end.steps) == ("H 0", "done", 50)


@pytest.mark.fact("CY545-HOME-4", "CY545-HOME-6", "CY545-UND-HOME-DIRECTION")
def test_home_leaves_a_match_counter_clockwise_first_and_comes_back_clockwise() -> None:
    machine = Machine(30)
    assert machine.home() == 0
    assert machine.x.steps().directions.tolist() == [-1] * 31 + [1]
    assert machine.x.position == 0 and machine.x.pin("ccw").level == 0
    machine.host.send("N 5\rG\r")
    machine.bench.run_until_idle()
    assert machine.x.position == 5  # clockwise


@pytest.mark.fact("CY545-HOME-2")
@pytest.mark.parametrize(("argument", "place"), [("0", 0), ("16", 0), ("43H", 0), ("0C1H", 0)])
def test_the_argument_of_h_is_one_of_t_and_w(argument: str, place: int) -> None:
    low_below = argument != "16"
    machine = Machine(-20, sensor=(None, 0) if low_below else (0, None))
    machine.host.send("B 1\rB 18\rB 19\rB 20\rB 21\r")
    assert machine.home(f"H {argument}") == place
    assert machine.x.position == 0


@pytest.mark.fact("CY545-HOME-3")
def test_home_steps_at_a_twentieth_of_the_first_rate_without_ramp() -> None:
    machine = Machine(-5)
    machine.host.send("F 36\rR 255\rH 0\r")
    machine.bench.run_until_idle()
    gaps = {round(b - a, -5) for a, b in pairwise(machine.x.steps().times_ps.tolist())}
    assert len(gaps) == 1 and near(gaps.pop(), 21.739 * MS, 0.01)


@pytest.mark.fact("CY545-HOME-7", "CY545-HOME-1")
def test_home_ends_at_the_same_position_from_everywhere_with_any_backlash() -> None:
    places(Random(1), 20)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_a_thousand_random_starts_end_at_the_same_position() -> None:
    places(Random(2), 1000)


def places(rnd: Random, many: int) -> None:
    for _ in range(many):
        start, backlash = rnd.randrange(-400, 400), rnd.choice((0, 1, 7, 30, 2.5))
        machine = Machine(start, backlash)
        machine.host.send(f"R 255\rF {rnd.randrange(100, 256)}\rN {rnd.randrange(1, 100)}\r{rnd.choice('+-')}\rG\r")
        machine.bench.run_until_idle()
        assert 0 <= machine.home() < 1, (start, backlash)
        assert machine.x.position == 0 and not machine.x.findings
        first = machine.carriage.place
        machine.host.send(f"P {rnd.randrange(300)}\r")
        machine.bench.run_until_idle()
        assert machine.home() == first, (start, backlash)


@pytest.mark.fact("CY545-HOME-11", "CY545-UND-HOME-ENDLESS")
def test_with_a_sensor_that_does_not_show_the_side_home_is_found_from_one_side_only() -> None:
    wrong = Machine(50, sensor=(0, 10))
    wrong.host.send("F 255\rH 16\r")
    wrong.bench.run("100 s")
    assert wrong.x.moving and wrong.carriage.place > 50_000  # away from it, for ever
    right = Machine(50, sensor=(0, 10))
    limit = right.bench.part("switch", "end", on=right.carriage, to=right.x, role="end_minus", high=-200)
    right.host.send("F 255\rN 100000\r-\rG\r")
    right.bench.run_until_idle("300 s")
    assert limit.closed and right.x.motions()[-1].end.why == "limit"
    assert right.home("H 16") == 0
    assert right.x.position == 0


@pytest.mark.fact("CY545-HOME-10")
@pytest.mark.parametrize(("start", "steps"), [(100, [1] * 100), (5, [-1] * 6 + [1])])
def test_on_a_wheel_the_sensor_is_found_from_everywhere(start: int, steps: list[int]) -> None:
    rig = rigged("F 255", f"A {start}", direction="+")
    sensor = Driver(rig.x.pin("usrb0").net, "wheel")

    def turned(_: object) -> None:
        place = (start + rig.x.travel) % 200
        sensor.drive(None if place < 10 else 0)  # high from 0 to 9

    turned(None)
    rig.x.pin("pulse").net.watch(turned)
    rig.bench.run("1 ms")
    rig.send("H 0\r")
    assert rig.x.steps().directions.tolist() == steps
    assert rig.x.position == 0


@pytest.mark.fact("CY545-HOME-8", "CY545-UND-LIMIT-HOME", "CY545-UND-HOME-DIRECTION")
@pytest.mark.parametrize(("start", "pin", "position"), [(-50, "cw_limit", 20), (60, "ccw_limit", -30)])
def test_a_limit_of_its_direction_ends_home_without_setting_the_position(start: int, pin: str, position: int) -> None:
    machine = Machine(start)
    other = "ccw_limit" if pin == "cw_limit" else "cw_limit"
    machine.x.pin(other).drive(0)  # of the other direction: nothing
    machine.host.send("A 1000\rF 255\rH 0\r")
    machine.bench.run_until(machine.x.reaches(1000 + position), "1 s")
    machine.x.pin(pin).drive(0)
    machine.bench.run_until_idle()
    assert machine.x.position == 1000 + position
    assert machine.x.pin("ccw").level == (0 if position > 0 else 1)
    assert machine.x.motions()[-1].end.why == "limit"
    machine.host.send("H 0\r")
    before = machine.x.travel
    machine.bench.run_until_idle()
    assert machine.x.travel == before and machine.x.position == 1000 + position


@pytest.mark.fact("CY545-UND-INHIB-JOG", "CY545-UND-STOPPED-OTHER")
def test_home_shows_stopped_low_and_ignores_inhibit_abort() -> None:
    machine = Machine(-20)
    machine.bench.record("x.stopped", "x.pulse", "x.slew")
    machine.x.pin("inhibit_abort").drive(0)
    assert machine.home() == 0
    times, levels = machine.bench.edges("x.stopped")
    assert levels.tolist() == [0, 1]
    last = int(machine.x.steps().times_ps[-1])
    assert near(int(times[1]) - last, 6 * MS, 0.1)
    assert not len(machine.bench.edges("x.slew")[0])


@pytest.mark.fact("CY545-HOME-9")
def test_with_bit_4_of_the_mode_the_position_follows_each_step_of_home() -> None:
    machine = Machine(3, fixed_baud=9600)
    serial = machine.bench.host(machine.x, over="serial")
    machine.host.send("A 100\rO 90H\r")
    assert machine.home() == 0
    shown = [int(line.removeprefix("P=")) for line in bytes(serial.received).decode().split()]
    assert shown == [99, 98, 97, 96, 97]
    assert machine.x.position == 0


@pytest.mark.fact("CY545-HOME-6")
def test_home_takes_a_step_even_if_it_starts_at_the_edge() -> None:
    machine = Machine(0)
    assert machine.home() == 0
    assert machine.x.steps().directions.tolist() == [-1, 1]
