"""Rates, steps, phases, SLEW and MOTION COMPLETE, through the pins.  Clocks of 11 MHz unless a crystal is named."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from random import Random
from typing import Any

import numpy as np
import pytest

from slewline.chips.cy525 import sheet
from tests.ensembles import few

Make = Callable[..., Any]
HIGH = 28  # 2.5 us
SMALL = "F 10\rR 12\rS 245\rZ 10\r"
UP = [11_000] * 5 + [10_000] * 5
TOP = 9167
PATTERNS = ((0, 1, 0, 1), (1, 0, 0, 1), (1, 0, 1, 0), (0, 1, 1, 0))
PHASES = ("phase1", "phase2", "phase3", "phase4")
LEAD = 110  # clocks from DIRECTION, and in a program READY, to the first PULSE
MOVES = {"position": 3, "number": 2, "rate": 10, "firstrate": 10, "slope": 250, "divisor": 1}


def phases(x: Any) -> tuple[int, ...]:
    return tuple(x.x.pin(pin).level for pin in PHASES)


# ------------------------------------------------------------------------------------------------------------- rates
@pytest.mark.fact("RATE-1", "RATE-2", "RATE-3", "RATE-6", "CON-INCREMENT", "CON-127-RATES")
@pytest.mark.parametrize("crystal", few(["11 MHz", "6 MHz"], 1))
@pytest.mark.parametrize("rates", few([range(first, 128, 4) for first in (3, 4, 5, 6)], 1))
def test_every_rate_of_the_table_is_a_whole_number_of_clocks(mover: Make, rates: range, crystal: str) -> None:
    x = mover(crystal=crystal)
    x.send("N 256\r")
    for parameter in rates:
        x.send(f"F {parameter}\rR {parameter}\r")
        x.begin()
        x.finish()
        assert x.periods() == [round(11_000_000 / x.rate(parameter))] * 256, parameter


@pytest.mark.fact("RATE-1", "RATE-2", "RATE-3", "CON-127-RATES")
def test_the_table_has_128_parameters_with_the_landmarks_of_the_manual(mover: Make) -> None:
    table = sheet.STEPS_PER_SECOND
    assert len(table) == 128
    assert table[3:41] == tuple(100 * parameter for parameter in range(3, 41))
    assert {r: table[r] for r in (41, 60, 80, 100, 127)} == {41: 4062, 60: 5141, 80: 5978, 100: 7138, 127: 9675}
    assert table[3:] == tuple(mover.rate(parameter) for parameter in range(3, 128))
    assert list(table) == sorted(set(table))


@pytest.mark.fact("RATE-4", "UND-R-0-2", "CON-R-LOW", "CON-F-RANGE")
def test_rates_0_1_and_2_of_a_command_are_rates_a_little_below_300(mover: Make) -> None:
    x = mover()
    x.send("N 4\r")
    for parameter, period in ((0, 40_000), (1, 38_869), (2, 37_671)):  # 275, 283, 292 steps/s
        x.send(f"F {parameter}\rR {parameter}\r")
        x.begin()
        x.finish()
        assert x.periods() == [period] * 4
    assert x.codes.count("slow-rate") == 1


@pytest.mark.fact("UND-R-HIGH")
def test_rates_above_127_run_at_127_and_read_back_as_given(rig: Make) -> None:
    x = rig()
    x.send("F 128\rR 255\rN 300\rS 200\rZ 1\rG\r")
    times = x.x.steps().times_ps
    assert set(np.diff(times)) <= {1137 * 10**6 // 11, 1137 * 10**6 // 11 + 1}
    assert x.host.verify(3) == bytes([1, 300 - 256, 200, 255, 128, 1])
    assert "range" in x.codes


@pytest.mark.fact("UND-R-BELOW-F")
def test_a_rate_below_the_first_rate_makes_the_whole_move_at_the_first_rate(mover: Make) -> None:
    x = mover()
    x.send("F 20\rR 10\rS 100\rZ 1\rN 300\r")
    x.begin()
    x.finish()
    assert x.periods() == [5500] * 300
    assert x.changes("slew") == [(0, 0), (300 * 5500, 1)]  # as with R equal to F
    assert x.codes.count("rate-below-firstrate") == 1


@pytest.mark.fact("UND-R-BELOW-F")
def test_a_continuous_motion_with_a_rate_below_the_first_rate_slews_at_the_first_rate(mover: Make) -> None:
    x = mover()
    x.send("F 20\rR 10\rS 100\rZ 1\rN 300\r")
    x.begin("H\rG\r")
    x.till(500 * 5500)
    assert x.begins() == [5500 * step for step in range(501)]


@pytest.mark.fact("RATE-6", "CON-SCALE-INVERSE")
@pytest.mark.parametrize(("crystal", "mhz"), [("6 MHz", 6.0), ("3.579545 MHz", 3.579545), ("1 MHz", 1.0)])
def test_rates_scale_with_the_crystal_without_drift(rig: Make, crystal: str, mhz: float) -> None:
    x = rig(crystal=crystal, firstrate=29, rate=29, number=5000)
    x.send("G\r")
    times = x.x.steps().times_ps
    hz = round(mhz * 1e6)
    period = round(11_000_000 / 2900)
    first = -(-int(times[0]) * hz // 10**12)
    assert times.tolist() == [(first + k * period) * 10**12 // hz for k in range(5000)]
    if mhz == 6.0:
        assert 1e12 * 4999 / float(times[-1] - times[0]) == pytest.approx(1581.8, rel=2e-4)


@pytest.mark.fact("RATE-7", "CON-TOP-RATE")
def test_ten_thousand_steps_per_second_take_a_crystal_of_11_37_mhz(rig: Make) -> None:
    fast, plain = rig(crystal="11.37 MHz", number=10_001), rig(number=9676)
    for x in (fast, plain):
        x.send("F 127\rR 127\rG\r")
    seconds = [float(np.ptp(x.x.steps().times_ps)) / 1e12 for x in (fast, plain)]
    assert seconds == pytest.approx([1.0, 1.0], rel=1e-4)
    assert "crystal" in fast.codes and "crystal" not in plain.codes


# ------------------------------------------------------------------------------------------------------------- steps
@pytest.mark.fact("STEP-1", "CON-PULSE-HIGH")
@pytest.mark.parametrize(("parameter", "period"), [(127, 1137), (10, 11_000)])
def test_pulse_is_low_for_the_whole_step_except_2_5_us(mover: Make, parameter: int, period: int) -> None:
    x = mover(firstrate=parameter, rate=parameter, number=100)
    x.begin()
    x.finish()
    edges = [edge for k in range(100) for edge in ((k * period, 0), ((k + 1) * period - HIGH, 1))]
    assert x.changes("pulse") == edges
    assert x.changes("motion_complete")[-1] == (100 * period, 0)  # the high time belongs to the last step too
    levels = []
    x.begin()
    for clock in (period - HIGH - 1, period - HIGH, period - 1, period):  # the same, asked instead of recorded
        x.till(clock)
        levels.append(x.x.pin("pulse").level)
    assert levels == [0, 1, 1, 0]


@pytest.mark.fact("STEP-2", "STEP-3")
def test_relative_and_absolute_moves_count_in_one_position_register(rig: Make) -> None:
    x = rig(record=("pulse",), firstrate=100, rate=100)
    seen = []
    for command in ("A 1000\rN 7\r+\rG\r", "-\rG\r", "G\r", "P 1003\r", "+\rG\r", "P 990\r", "A 0\rP 40\r", "P 0\r"):
        x.send(command)
        seen.append(x.x.position)
    assert seen == [1007, 1000, 993, 1003, 1010, 990, 40, 0]
    assert len(x.falls("pulse")) == 7 + 7 + 7 + 10 + 7 + 20 + 40 + 40
    steps = x.x.steps()
    assert steps.directions.tolist() == [1] * 7 + [-1] * 14 + [1] * 17 + [-1] * 20 + [1] * 40 + [-1] * 40
    assert x.x.travel == 7 - 14 + 17 - 20


@pytest.mark.fact("STEP-4")
def test_the_position_wraps_without_any_other_sign(mover: Make) -> None:
    edges = []
    for start in (65_530, 100):
        x = mover(*PHASES, "direction", firstrate=10, rate=10, number=10)
        x.send(f"A {start}\r+\r")
        x.begin()
        x.finish()
        assert x.x.position == (start + 10) % 65536
        assert x.x.steps().positions.tolist() == [(start + k) % 65536 for k in range(1, 11)]
        edges.append([x.changes(pin) for pin in (*PHASES, "direction", "pulse", "slew", "motion_complete", "ready")])
    assert edges[0] == edges[1]
    x.send("A 3\r-\rG\r")
    assert x.x.position == 65_529


# ------------------------------------------------------------------------------------------------------------ phases
@pytest.mark.fact("PHASE-1", "PHASE-2", "UND-PHASE-DIR")
@pytest.mark.parametrize(("sign", "way"), [("+", 1), ("-", -1)])
def test_steps_walk_through_the_patterns_up_when_clockwise(rig: Make, sign: str, way: int) -> None:
    x = rig(firstrate=100, rate=100, number=1)
    x.send(f"{sign}\rO 0\r")
    assert x.phases == PATTERNS[0]
    seen = [x.phases]
    for _ in range(8):
        x.send("G\r")
        seen.append(x.phases)
    assert seen == [PATTERNS[way * k % 4] for k in range(9)]
    for before, after in pairwise(seen):
        changed = {n for n in range(4) if before[n] != after[n]}
        assert changed in ({0, 1}, {2, 3})


@pytest.mark.fact("PHASE-2")
def test_while_energised_exactly_one_of_each_pair_is_low_at_every_instant(mover: Make) -> None:
    x = mover(*PHASES)
    x.send(SMALL + "N 300\r")
    x.begin()
    x.on(70_000, "abort", 0)
    x.on(80_000, "abort", 1)
    x.finish()
    x.send("-\rG\r")
    start = x.x.clock.ps(x.origin)
    events = {}
    for pin in PHASES:
        times, levels = x.bench.edges(f"x.{pin}", start)
        for time, level in zip(times.tolist(), levels.tolist(), strict=True):
            events.setdefault(time, {})[pin] = level
    now = dict.fromkeys(PHASES, 1)
    assert len(events) == 600
    for time in sorted(events):
        now |= events[time]
        assert now["phase1"] != now["phase2"] and now["phase3"] != now["phase4"]


@pytest.mark.fact("PHASE-3", "UND-PHASE-POWERUP")
@pytest.mark.parametrize(("target", "pattern"), [(101, 1), (99, 3)])
def test_the_first_step_after_reset_energises_the_phases(rig: Make, target: int, pattern: int) -> None:
    x = rig(position=100, firstrate=100, rate=100)
    x.send("A 100\r")
    assert x.phases == (1, 1, 1, 1)
    x.send(f"P {target}\r")
    assert x.phases == PATTERNS[pattern]
    x.x.reset()
    x.bench.run("1 ms")
    assert x.phases == (1, 1, 1, 1)
    x.send("A 100\rP 101\r")
    assert x.phases == PATTERNS[1]
    x.send("P 102\r")
    assert x.phases == PATTERNS[2]


@pytest.mark.fact("UND-PHASE-EDGE")
def test_phases_and_position_change_with_the_falling_edge_of_pulse(mover: Make) -> None:
    x = mover(*PHASES, firstrate=10, rate=10, number=4, position=0)
    x.begin()
    x.finish()
    falls = [clock for clock, level in x.changes("pulse") if level == 0]
    changes = sorted({clock for pin in PHASES for clock, _ in x.changes(pin)})
    assert changes == falls == [0, 11_000, 22_000, 33_000]
    ps = [x.x.clock.ps(x.origin + clock) for clock in falls]
    assert x.x.position_at(np.array(ps)).tolist() == [1, 2, 3, 4]
    assert x.x.position_at(np.array(ps) - 1).tolist() == [0, 1, 2, 3]


# -------------------------------------------------------------------------------------------------------------- SLEW
@pytest.mark.fact("SLEW-1", "CON-SLEW-STEADY")
def test_in_a_normal_move_slew_is_low_exactly_at_the_maximum_rate(mover: Make) -> None:
    x = mover(number=300)
    x.send(SMALL)
    assert x.x.pin("slew").level == 1
    x.begin()
    x.finish()
    assert x.periods() == UP + [TOP] * 280 + UP[::-1]
    assert x.changes("slew") == [(sum(UP), 0), (sum(UP) + 280 * TOP, 1)]


@pytest.mark.fact("SLEW-3", "CON-SLEW-STEADY")
def test_in_continuous_motion_slew_is_low_at_any_steady_rate(mover: Make) -> None:
    x = mover(number=60_000)
    x.send(SMALL)
    x.begin("H\rG\r")
    slewing = sum(UP)
    x.request(slewing + 10 * TOP + 500, 11)
    x.till(1_000_000)
    down = slewing + 11 * TOP  # the end of the step in which the request came
    assert x.changes("slew") == [(slewing, 0), (down, 1), (down + 5 * 10_000, 0)]
    assert x.periods() == UP + [TOP] * 11 + [10_000] * (len(x.periods()) - 21)


@pytest.mark.fact("SLEW-4")
@pytest.mark.parametrize("continuous", [True, False])
@pytest.mark.parametrize("seed", range(8))
def test_slew_rises_for_three_causes_only(mover: Make, seed: int, continuous: bool) -> None:
    chance = Random(seed)
    x = mover("abort", "io_request", number=60_000 if continuous else 300)
    x.send(SMALL)
    x.begin("H\rG\r" if continuous else "G\r")
    clock = 150_000
    for _ in range(8):  # holds, read-outs and requests at leisure, and in the end an abort, or the target
        pin = chance.choice(["step_inhibit", "io_select", *["io_request"] * 2 * continuous])
        if pin == "io_request":
            x.request(clock, chance.randrange(9, 16), clock + 20_000)
        else:
            x.on(clock, pin, 1)
            x.on(clock + chance.randrange(100, 30_000), pin, 0)
        clock += 220_000
    if continuous or seed % 2:
        x.on(clock, "abort", 0)
    x.finish()
    begins = x.begins()
    causes = [time for pin in ("abort", "io_request") for time, level in x.changes(pin) if level == 0]
    if not continuous and seed % 2 == 0:
        causes.append(begins[-len(UP) - 1])  # the last step of the slewing: the way down is as long as the way up
    rises = [time for time, level in x.changes("slew") if level == 1]
    assert len(rises) == 1 if not continuous else rises
    for rise in rises:
        assert any(0 < rise - cause <= 12_222 for cause in causes), (rise, causes)


@pytest.mark.fact("SLEW-6", "RAMP-12", "UND-SHORT-NORAMP")
@pytest.mark.parametrize(("number", "slews"), [(256, True), (255, False), (1, False)])
def test_without_a_ramp_slew_is_low_from_the_first_step_of_256_or_more(mover: Make, number: int, slews: bool) -> None:
    x = mover(number=number, firstrate=10, rate=10)
    x.begin()
    x.finish()
    assert x.periods() == [11_000] * number
    assert x.changes("slew") == ([(0, 0), (11_000 * number, 1)] if slews else [])


@pytest.mark.fact("SLEW-6")
@pytest.mark.parametrize("number", [20, 275])
def test_a_move_without_slewing_keeps_slew_high(mover: Make, number: int) -> None:
    x = mover(number=number)
    x.send(SMALL)
    x.begin()
    x.finish()
    assert x.periods() == UP + UP[::-1] + [11_000] * (number - 20)
    assert x.changes("slew") == []


# ---------------------------------------------------------------------------------------- just before the first step
@pytest.mark.fact("CMD-P-3", "HS-12", "UND-STEP-LEAD")
@pytest.mark.parametrize(("crystal", "lead_ps"), [("11 MHz", 10_000_000), ("6 MHz", 18_333_333)])
@pytest.mark.parametrize("stepwise", [False, True])
def test_in_a_program_ready_and_direction_are_set_110_clocks_before_the_first_step(
    hand: Make, crystal: str, lead_ps: int, stepwise: bool
) -> None:
    x = hand("direction", "ready", "motion_complete", "pulse", crystal=crystal, stepwise=stepwise, **MOVES)
    x.send("E\rP 0\rP 2\rG\r0\rQX\r")
    x.trace.clear()  # READY has returned behind X
    x.run(90_000)
    begins = [x.falls("pulse")[n] for n in (0, 3, 5)]
    assert x.edges("direction") == [(begins[0] - LEAD, 0), (begins[1] - LEAD, 1)]
    assert x.falls("ready") == [begin - LEAD for begin in begins]
    assert x.rises("motion_complete") == [begin - LEAD for begin in begins[1:]]
    assert x.x.clock.ps(begins[0]) - x.x.clock.ps(begins[0] - LEAD) in (lead_ps, lead_ps + 1)
    assert x.x.position == 4


@pytest.mark.fact("CMD-P-3", "UND-STEP-LEAD")
@pytest.mark.parametrize("crystal", ["11 MHz", "6 MHz"])
@pytest.mark.parametrize("stepwise", [False, True])
def test_a_commanded_motion_sets_direction_110_clocks_before_the_first_step(
    hand: Make, crystal: str, stepwise: bool
) -> None:
    x = hand("direction", "ready", "pulse", crystal=crystal, stepwise=stepwise, **MOVES)
    x.send("P 0\rP 2\rG\r")
    begins = [x.falls("pulse")[n] for n in (0, 3, 5)]
    assert x.edges("direction") == [(begins[0] - LEAD, 0), (begins[1] - LEAD, 1)]
    for begin in begins:
        clock, level = [edge for edge in x.edges("ready") if edge[0] <= begin][-1]
        assert level == 0 and clock < begin - LEAD  # since the carriage return
    assert x.x.position == 4


@pytest.mark.fact("HS-13", "CMD-P-3", "UND-STEP-LEAD")
@pytest.mark.parametrize("stepwise", [False, True])
@pytest.mark.parametrize("program", [False, True])
def test_paused_by_io_request_a_motion_has_set_its_lines_and_steps_when_the_request_ends(
    hand: Make, program: bool, stepwise: bool
) -> None:
    x = hand("direction", "ready", "pulse", "run", stepwise=stepwise, **MOVES)
    if program:
        x.send("E\rD 1\rP 0\r0\rQX\r")
        due = x.falls("run")[0] + 60 * 11 + 11_000 + 40 * 11
    else:
        x.send("P 0")
        x.data(x.now, 0x0D)
        due = x.now + (26 + 550 + 40) * 11
    x.put(x.now, "io_request", 0)
    up = x.now + 100_000
    x.put(up, "io_request", 1)
    x.run_to(up)
    assert x.x.pin("ready").level == 0  # READY does not wait
    x.run_to(up + 4 * 11_000)
    assert x.edges("direction") == [(due - LEAD, 0)]
    assert x.falls("pulse") == [up + 1 + n * 11_000 for n in range(3)]


# -------------------------------------------------------------------------------------------------- MOTION COMPLETE
@pytest.mark.fact("UND-MC-PROGRAM")
def test_motion_complete_rises_with_the_next_motion_of_a_program(rig: Make) -> None:
    x = rig(record=("motion_complete", "ready", "pulse", "programmable_output"), firstrate=10, rate=10, number=2)
    x.send("C\rE\rG\rB\rG\r0\rQ")
    begin = x.bench.now_ps
    x.send("X\r")
    x.bench.run("100 ms")
    rises = [time for time in x.rises("motion_complete", begin) if time > x.falls("motion_complete", begin)[0]]
    high = x.rises("programmable_output", begin)[0]
    falls = x.falls("pulse", begin)
    assert len(rises) == 1 and high < rises[0] == x.falls("ready", begin)[-1] <= falls[2]  # not with B in between


@pytest.mark.fact("UND-MC-PROGRAM")
@pytest.mark.parametrize("by_value", [True, False])
def test_motion_complete_rises_with_the_next_accepted_byte(rig: Make, by_value: bool) -> None:
    x = rig(record=("motion_complete", "instrobe"), firstrate=10, rate=10, number=2)
    if not by_value:
        x.bench.pin("x.io_request").net.watch(lambda _net: None)  # then each edge is an event
    x.send("G\r")
    x.bench.run("100 ms")
    assert x.level("motion_complete") == 0
    begin = x.bench.now_ps
    x.send("B\r")
    assert x.rises("motion_complete", begin) == x.rises("instrobe", begin)[:1]
