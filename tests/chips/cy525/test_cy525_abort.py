"""ABORT: the manual's cases I to VI, when the chip looks, and what an abort leaves behind.  Clocks of 11 MHz."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import pytest

from tests.ensembles import few

Make = Callable[..., Any]
SMALL = "F 10\rR 12\rS 245\rZ 10\r"  # one unit every 49,720 clocks
LOW, TOP = 11_000, 9167
UP = [LOW] * 5 + [10_000] * 5
DOWN = UP[::-1]
READY = 180  # clocks from MOTION COMPLETE to READY: 30 us at 6 MHz


def slewing(x: Any, number: int = 1000, command: str = "G\r") -> int:
    """Begin a move with a ramp of ten steps; the clock at which it begins to slew."""
    x.send(f"{SMALL}N {number}\r")
    x.begin(command)
    return sum(UP)


def rested(x: Any, end: int) -> None:
    """The motion ended at a clock: outputs rest, MOTION COMPLETE low, READY back."""
    assert x.changes("motion_complete")[-1] == (end, 0)
    assert x.changes("ready")[-1] == (end + READY, 1)
    assert (x.x.pin("slew").level, x.x.pin("pulse").level) == (1, 1)


# ---------------------------------------------------------------------------------------------------- cases I and II
@pytest.mark.fact("ABORT-2")
def test_case_2_abort_low_from_the_start_is_disabled_for_the_whole_motion(mover: Make) -> None:
    x = mover(number=300)
    x.send(SMALL)
    x.put(x.now, "abort", 0)
    x.begin()
    for clock in (40_000, 200_000, 2_000_000):  # in every leg: high, and low again
        x.on(clock, "abort", 1)
        x.on(clock + 100_000, "abort", 0)
    x.on(1_000_000, "step_inhibit", 1)
    x.on(1_500_000, "step_inhibit", 0)
    x.finish()
    plain = UP + [TOP] * 280 + DOWN
    periods = x.periods()
    assert len(periods) == 300
    (held,) = (step for step in range(300) if periods[step] != plain[step])
    assert sum(plain[: held + 1]) > 1_000_000 - 28 >= sum(plain[:held]) - 28
    assert 1_500_000 < sum(periods[: held + 1]) <= 1_500_000 + 33 + 28  # the inhibit still holds steps


@pytest.mark.fact("ABORT-2", "UND-ABORT-SAMPLE")
@pytest.mark.parametrize("stepwise", [False, True])
@pytest.mark.parametrize(("clock", "steps"), [(-1, 300), (0, 1), (1, 1)])
def test_the_level_of_abort_when_the_first_step_could_begin_decides(
    mover: Make, clock: int, steps: int, stepwise: bool
) -> None:
    probe = mover(number=300)
    probe.send(SMALL)
    sent = probe.now
    probe.begin()
    x = mover(number=300, stepwise=stepwise)
    x.send(SMALL)
    x.put(x.now + probe.now - sent + clock, "abort", 0)
    x.give("G\r")
    x.finish()
    assert x.x.travel == steps


@pytest.mark.fact("ABORT-2", "UND-ABORT-INITIALLY", "UND-INHIBIT-ABORT")
@pytest.mark.parametrize("stepwise", [False, True])
@pytest.mark.parametrize(("commands", "low", "steps"), [("G\r", 0, 1), ("H\rG\r", 0, 1), ("G\r", -30_000, 300)])
def test_abort_lowered_while_the_first_step_is_inhibited_aborts_the_motion(
    mover: Make, commands: str, low: int, steps: int, stepwise: bool
) -> None:
    x = mover(number=300, stepwise=stepwise)
    x.send(SMALL)
    x.put(x.now, "step_inhibit", 1)
    if low < 0:
        x.put(x.now, "abort", 0)  # low before the motion: off a limit switch
    x.give(commands)
    x.run(20_000)
    x.put(x.now, "abort", 0)
    x.run(20_000)
    x.put(x.now, "step_inhibit", 0)
    x.finish()
    assert x.x.travel == steps
    assert "abort-low-at-start" not in x.codes


# ----------------------------------------------------------------------------------------------------------- case III
@pytest.mark.fact("ABORT-3", "ABORT-8")
def test_case_3_abort_kept_low_ramps_down_and_stops(mover: Make) -> None:
    x = mover(number=60_000, position=7)
    x.send("F 3\rR 80\rS 100\rZ 1\r")
    x.begin()
    up = x.way_up(3, 80, 100)
    look = sum(up) + (20_000 - len(up)) * 1840
    x.on(look - 1, "abort", 0)
    x.finish()
    assert x.periods() == up + [1840] * (20_000 - len(up)) + up[::-1]
    rested(x, look + sum(up))
    assert x.x.position == 7 + 20_000 + len(up)
    x.on(look + sum(up) + 1_000_000, "abort", 1)  # any time later
    x.run(5_000_000)
    assert x.x.position == 7 + 20_000 + len(up)


@pytest.mark.fact("ABORT-3", "ABORT-8", "UND-ABORT-SAMPLE")
@pytest.mark.parametrize(
    ("before", "width", "seen"), [(1, 1, True), (0, 1, False), (TOP - 1, TOP - 2, False), (TOP, TOP, True)]
)
def test_abort_is_sampled_once_in_a_step_as_it_begins(mover: Make, before: int, width: int, seen: bool) -> None:
    # a low that ends exactly at the look was still there before that instant; one that begins there was not
    x = mover()
    look = slewing(x, 600) + 100 * TOP
    x.on(look - before, "abort", 0)
    x.on(look - before + width, "abort", 1)
    x.finish()
    assert len(x.begins()) == 600
    slews = [clock for clock, level in x.changes("slew") if level == 1]
    assert slews == [look if seen else look + 480 * TOP]


# ----------------------------------------------------------------------------------------------------- cases IV and V
@pytest.mark.fact("ABORT-4", "ABORT-8", "SLEW-2", "CON-SLEW-STEADY")
def test_case_4_released_on_the_down_ramp_continues_to_the_target_at_the_first_rate(mover: Make) -> None:
    x = mover(position=0)
    look = slewing(x, 1000) + 100 * TOP
    x.on(look - 100, "abort", 0)
    x.on(look + sum(DOWN) - 1, "abort", 1)  # the last moment
    x.finish()
    assert x.periods() == UP + [TOP] * 100 + DOWN + [LOW] * 880
    assert x.x.position == 1000
    assert x.changes("slew") == [(sum(UP), 0), (look, 1)]  # high although the rate is steady
    rested(x, sum(x.periods()))


@pytest.mark.fact("ABORT-4", "ABORT-8")
def test_the_level_at_the_bottom_decides_and_not_those_in_between(mover: Make) -> None:
    x = mover()
    look = slewing(x, 1000) + 100 * TOP
    x.on(look - 100, "abort", 0)
    x.on(look + 100, "abort", 1)
    x.on(look + sum(DOWN) - 1, "abort", 0)
    x.finish()
    assert x.periods() == UP + [TOP] * 100 + DOWN


@pytest.mark.fact("ABORT-5", "UND-ABORT-TURN")
@pytest.mark.parametrize("held", [True, False])
@pytest.mark.parametrize(("clock", "made"), [(54_999, 5), (64_999, 6), (95_000, 10)])
def test_case_5_abort_in_the_up_ramp_turns_it_down_immediately(mover: Make, clock: int, made: int, held: bool) -> None:
    x = mover()
    slewing(x, 500)
    x.on(clock, "abort", 0)
    if not held:
        x.on(clock + 12_000, "abort", 1)
    x.finish()
    if made == 5:  # still at the first rate: nothing to come down from
        assert x.periods() == UP[:5]
        return
    down = [LOW] * 5  # from the rate of the last step, 11
    assert x.periods() == UP[:made] + down + [LOW] * (0 if held else 500 - made - 5)
    assert x.changes("slew") == []


@pytest.mark.fact("ABORT-5", "RAMP-6", "UND-ABORT-TURN")
def test_case_5_after_100_ramp_steps_comes_down_the_same_curve(mover: Make) -> None:
    x = mover(number=60_000)
    x.send("F 3\rR 127\rS 100\rZ 1\r")
    x.begin()
    up = x.way_up(3, 127, 100)
    x.on(sum(up[:100]) - 1, "abort", 0)
    x.finish()
    top = next(rate for rate in range(3, 128) if x.period(rate) == up[99])
    assert x.periods() == up[:100] + x.way_up(3, top, 100)[::-1]


@pytest.mark.fact("ABORT-7")
def test_only_the_first_abort_of_a_motion_acts(mover: Make) -> None:
    x = mover()
    look = slewing(x, 1000) + 100 * TOP
    x.on(look - 100, "abort", 0)
    x.on(look + 20_000, "abort", 1)
    bottom = look + sum(DOWN)
    x.on(bottom + 50_000, "abort", 0)  # in the slow run, and for good
    x.on(bottom + 70_000, "io_select", 1)  # read-outs make the chip look at its inputs with every step
    x.on(bottom + 200_000, "io_select", 0)
    x.finish()
    assert x.periods() == UP + [TOP] * 100 + DOWN + [LOW] * 880
    x.put(x.now, "abort", 1)
    x.begin()
    x.on(sum(UP) + TOP, "abort", 0)  # the next motion can be aborted again
    x.finish()
    assert x.periods() == UP + [TOP] * 2 + DOWN


# --------------------------------------------------------------------------------------------- abort and its own ramp
@pytest.mark.fact("UND-ABORT-DECEL")
@pytest.mark.parametrize(("release", "steps"), [(None, 20), (sum(UP) * 2 - 1, 70), (sum(UP) * 2 + 1, 20)])
def test_abort_on_the_normal_down_ramp_decides_at_the_bottom(mover: Make, release: int | None, steps: int) -> None:
    x = mover()
    slewing(x, 70)  # up, down, and 50 steps at the first rate
    x.on(sum(UP) + 15_000, "abort", 0)
    if release is not None:
        x.on(release, "abort", 1)
    x.finish()
    assert x.periods() == (UP + DOWN + [LOW] * 50)[:steps]


@pytest.mark.fact("UND-ABORT-DECEL")
def test_abort_in_the_steps_at_the_first_rate_stops_immediately(mover: Make) -> None:
    x = mover()
    slewing(x, 70)
    end = 2 * sum(UP) + 7 * LOW
    x.on(end - 1, "abort", 0)
    x.on(end + 1, "abort", 1)
    x.finish()
    assert x.periods() == UP + DOWN + [LOW] * 7
    rested(x, end)


@pytest.mark.fact("UND-ABORT-DECEL", "ABORT-8")
def test_abort_of_a_motion_without_ramp_stops_immediately(mover: Make) -> None:
    x = mover(number=500, firstrate=10, rate=10)
    x.begin()
    x.on(100 * LOW - 1, "abort", 0)
    x.on(100 * LOW, "abort", 1)
    x.finish()
    assert x.periods() == [LOW] * 100


@pytest.mark.fact("ABORT-3", "ABORT-8")
def test_abort_that_falls_with_the_last_step_is_too_late(mover: Make) -> None:
    x = mover(position=0)
    slewing(x, 276)
    x.on(2 * sum(UP) + 256 * TOP - 1, "abort", 0)
    x.finish()
    assert x.x.position == 276


# ------------------------------------------------------------------------------------------------- case VI, continuous
@pytest.mark.fact("ABORT-6", "CONT-2")
@pytest.mark.parametrize("case", few(product(["G\r", "-\rH\rG\r", "P 62000\r"], [1, 5, 9, 10, 11, 65_536], [0, 1]), 10))
def test_case_6_the_nominal_target_in_the_down_ramp_is_an_abrupt_stop(mover: Make, case: tuple[str, int, int]) -> None:
    start, left, wraps = case
    number, made = 60_000, min(left, 10)
    x = mover(position=2000)
    slewing(x, number, f"A 2000\rH\r{start}")
    steps = number + wraps * 65_536 + (65_536 if left == 65_536 else 0) - left  # steps over when ABORT is seen
    x.on(sum(UP) + (steps - 10) * TOP - 1, "abort", 0)
    x.finish()
    assert x.x.travel == (steps + made) * (-1 if start.startswith("-") else 1)
    assert x.periods()[-made:] == DOWN[:made]
    assert ("target-in-ramp" in x.codes) == (made < 10)
    assert x.x.pin("motion_complete").level == 0 and x.x.pin("ready").level == 1


@pytest.mark.fact("CONT-2", "UND-FLY-RAMPING")
@pytest.mark.parametrize("held", [True, False])
def test_after_the_abort_of_a_continuous_motion_rate_requests_are_not_served(mover: Make, held: bool) -> None:
    x = mover("instrobe")
    look = slewing(x, 300, "H\rG\r") + 275 * TOP
    x.on(look - 1, "abort", 0)
    if not held:
        x.on(look + 50_000, "abort", 1)
    x.request(look + 20_000, 50, look + sum(DOWN) + (-1 if held else 5 * LOW))  # ramp and crawl, up to the target
    x.finish()
    assert x.periods() == UP + [TOP] * 275 + DOWN + [LOW] * (0 if held else 5)
    assert x.changes("instrobe") == []


@pytest.mark.fact("CONT-3", "ABORT-9", "UND-CONT-ABORT-RELEASE")
@pytest.mark.parametrize("sign", [1, -1])
def test_case_4_in_continuous_motion_continues_to_the_nominal_target_and_is_reported(mover: Make, sign: int) -> None:
    x = mover(position=100)
    slewing(x, 300, "A 100\rH\r" + ("+" if sign > 0 else "-") + "\rG\r")
    look = sum(UP) + 1990 * TOP
    x.on(look - 1, "abort", 0)
    x.on(look + 20_000, "abort", 1)
    x.finish()
    assert x.x.position == (100 + sign * 300) % 65536
    assert x.x.travel == sign * (65_536 + 300)
    assert x.periods() == UP + [TOP] * 1990 + DOWN + [LOW] * (65_836 - 2010)
    assert x.changes("slew") == [(sum(UP), 0), (look, 1)]
    assert x.codes.count("abort-released") == 1


@pytest.mark.fact("UND-ABORT-CONT-LOW")
def test_a_continuous_motion_that_begins_with_abort_low_ends_by_reset_only(mover: Make) -> None:
    x = mover(number=60_000)
    x.send(SMALL)
    x.put(x.now, "abort", 0)
    x.begin("H\rG\r")
    assert x.codes.count("abort-low-at-start") == 1
    x.on(1_000_000, "abort", 1)
    x.on(2_000_000, "abort", 0)
    x.till(70_000 * TOP)
    assert x.x.travel > 65_536
    travel = x.x.travel
    x.x.reset()
    x.run(1_000_000)
    assert x.x.travel <= travel + 1
    assert x.x.pin("slew").level == 1 and x.x.idle


@pytest.mark.fact("UND-ABORT-CONT-LOW", "CONT-4")
def test_that_warning_is_not_given_where_the_motion_ends_by_itself(mover: Make) -> None:
    x = mover(number=100)
    x.send(SMALL)
    x.put(x.now, "abort", 0)
    x.send("H\rG\r")
    assert x.x.travel == 100
    assert "abort-low-at-start" not in x.codes


# ----------------------------------------------------------------------------------------------------------- programs
@pytest.mark.fact("ABORT-11")
def test_the_program_around_an_aborted_motion_continues(rig: Make) -> None:
    x = rig(record=("run", "motion_complete"), position=0)
    x.send("A 0\rF 10\rR 12\rS 245\rZ 10\rE\rN 60000\rG\rN 5\rG\r0\rQ")
    x.start("X\r")
    x.bench.run_until(x.x.reaches(5000))
    x.drive("abort", 0)
    x.bench.run_until(x.x.pin("motion_complete").is_(0))
    stopped = x.x.position
    assert 5010 <= stopped <= 5011
    x.drive("abort", 1)
    x.bench.run_until_idle()
    assert x.x.position == stopped + 5 == len(x.x.steps())
    assert x.level("run") == 1


@pytest.mark.fact("ABORT-4", "ABORT-7")
def test_the_waiting_text_of_an_aborted_motion(mover: Make) -> None:
    x = mover()
    look = slewing(x, 1000) + 10 * TOP
    x.on(look - 1, "abort", 0)
    x.till(look + LOW)
    assert x.x.waiting.startswith(
        "x: G aborted: decelerating to rate 10 (it then continues to its target unless abort=0) since "
    )
    x.put(x.now, "abort", 1)
    x.till(look + sum(DOWN) + 10)
    x.put(x.now, "abort", 0)  # no longer looked at
    x.run(3 * LOW)
    assert x.x.waiting.startswith("x: G aborted, abort=1 at rate 10: continues to its target since ")
    x.on(x.now - x.origin + 1000, "step_inhibit", 1)
    x.run(2 * LOW)
    x.put(x.now, "step_inhibit", 0)
    x.run(2 * LOW)
    assert x.x.waiting.startswith("x: G aborted, abort=1 at rate 10: continues to its target since ")
    x.finish()
    assert x.x.travel == 1000


@pytest.mark.fact("ABORT-2", "ABORT-11")
def test_abort_still_low_lets_the_next_motion_run(mover: Make) -> None:
    """One can move off a limit switch that keeps ABORT low."""
    x = mover()
    look = slewing(x, 1000) + 10 * TOP
    x.on(look - 1, "abort", 0)
    x.finish()
    made = x.x.travel
    assert made == 30
    x.send("-\rN 300\rG\r")
    assert x.x.travel == made - 300
