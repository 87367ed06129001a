"""How the CY500 moves: rates, slopes, half steps, single steps, and the lines that start, turn, hold and stop it."""

from __future__ import annotations

from itertools import pairwise

import pytest
from cy500 import FULL, HALF, MS, US, Rig500, made

import slewline
from slewline.bench.ramp_calculator import find_ramps
from slewline.chips import sheet_of
from slewline.chips.cy5xx.stepping.slope import Law
from slewline.chips.cy500 import profile
from slewline.chips.cy500.sheet import PERIODS
from slewline.core.motion.plan import steps as steps_of
from slewline.errors import UsageError, WiringError

LAW = Law(PERIODS)
both = pytest.mark.parametrize("stepwise", [False, True], ids=["fast", "twin"])


def rate_of(rig: Rig500) -> float:
    """Steps per second of the last two steps."""
    return 10**12 / (rig.times[-1] - rig.times[-2])


# ------------------------------------------------------------------------------------------------------------- rates
@pytest.mark.fact("CY500-RATE-1", "CY500-RATE-4", "CY500-CON-TOP-SPEED")
def test_rates_at_both_ends() -> None:
    assert rate_of(made("R 1", "N 3", "G")) == pytest.approx(50, rel=1e-9)
    top = rate_of(made("R 253", "N 3", "G"))
    assert top == pytest.approx(3350, rel=0.0005)
    assert 3300 < top < 3361


@pytest.mark.fact("CY500-RATE-2")
def test_rates_are_far_from_linear() -> None:
    assert rate_of(made("R 128", "N 3", "G")) == pytest.approx(99.3, rel=0.001)


@pytest.mark.fact("CY500-RATE-5", "CY500-UND-RATE-LAW")
def test_the_period_falls_by_the_same_with_each_unit_of_the_rate() -> None:
    for rate, steps_per_s in ((100, 81.57), (200, 225.1), (240, 760.5), (252, 2654.7)):
        assert 6_000_000 / LAW.period(rate) == pytest.approx(steps_per_s, rel=0.0005)
    assert len(PERIODS) == 254
    assert {a - b for a, b in pairwise(PERIODS)} == {469, 470}


@pytest.mark.fact("CY500-RATE-3", "CY500-CON-SCALE")
@pytest.mark.parametrize(("crystal", "steps_per_s"), [("3.58 MHz", 1999), ("1 MHz", 558)])
def test_rates_follow_the_crystal(crystal: str, steps_per_s: int) -> None:
    assert rate_of(made("R 253", "N 3", "G", crystal=crystal)) == pytest.approx(steps_per_s, rel=0.001)


@pytest.mark.fact("CY500-CMD-F-1")
def test_a_factor_divides_the_rate() -> None:
    assert made("R 253", "F 10", "N 2", "G").gaps == [17_910]
    assert rate_of(made("R 253", "F 255", "N 2", "G")) == pytest.approx(13.14, rel=0.001)
    assert made("R 253", "F 0", "N 2", "G").gaps == [256 * 1791]


def test_options_replace_inferred_facts() -> None:
    periods = [6000 - 10 * rate for rate in range(254)]
    rig = Rig500(record=("pulse",), inferred={"periods": periods, "ramp_start": 5, "pulse_high": 60})
    rig.say("R 35", "S 10", "N 20", "G")
    assert rig.gaps[:4] == [5950, 5850, 5750, 5650]
    falls, rises = rig.falls("pulse"), rig.rises("pulse")
    assert round((falls[1] - rises[0]) * 6 / 10**6) == 60
    rig = Rig500(inferred={"phases": [1, 2, 3, 4, 5, 6, 7, 8]})
    rig.say("R 253", "N 1", "G")
    assert rig.phases == (0, 0, 1, 1)


def test_a_bench_file_replaces_inferred_facts(tmp_path: object) -> None:
    file = tmp_path / "bench.toml"  # type: ignore[operator]
    periods = [6000 - 10 * rate for rate in range(254)]
    file.write_text(f'[[chip]]\npart = "cy500"\nname = "x"\n[chip.options.inferred]\nperiods = {periods}\n')
    bench = slewline.load(file)
    host = bench.host(bench["x"])
    host.send("R 100\rN 3\rG\r")
    bench.run_until_idle("1 s")
    assert bench["x"].steps().times_ps[-1] - bench["x"].steps().times_ps[0] == pytest.approx(2 * 5000 / 6 * US)
    with pytest.raises(UsageError, match="3 numbers; allowed none or 254"):
        Rig500(inferred={"periods": [2000, 2000, 2000]})


# ------------------------------------------------------------------------------------------------------------- slopes
@pytest.mark.fact("CY500-RAMP-1", "CY500-RAMP-2", "CY500-UND-RAMP-START")
@both
def test_a_slope_raises_the_rate_parameter_with_each_step_and_lowers_it_alike(stepwise: bool) -> None:
    gaps = made("R 253", "S 10", "N 100", "G", stepwise=stepwise).gaps
    assert gaps[:26] == [PERIODS[rate] for rate in range(1, 253, 10)]
    assert [round(gap / 6) for gap in gaps[:3]] == [20_000, 19_218, 18_436]
    assert set(gaps[26:74]) == {1791}
    assert gaps[74:] == gaps[25:0:-1]
    assert (sum(gaps) + gaps[0]) / 6000 == pytest.approx(546.2, rel=0.0005)


@pytest.mark.fact("CY500-CMD-S-1")
def test_slopes_force_the_factor_to_1() -> None:
    rig = made("F 10", "S 5", "R 253", "N 1000", "G")
    assert min(rig.gaps) == 1791
    assert rig.codes == []


@pytest.mark.fact("CY500-UND-SLOPE-OFF")
def test_slopes_end_with_s_0_and_with_i() -> None:
    for end in ("S 0", "I"):
        rig = made("F 2", "S 50", "R 253", "N 12", "F 3", "G", "N 4")
        assert rig.gaps[0] == PERIODS[1]
        assert rig.codes == ["factor-in-slope"]
        rig.say(end, "G")
        assert rig.gaps[-3:] == [3 * 1791] * 3


@pytest.mark.fact("CY500-RAMP-3", "CY500-UND-SHORT", "CY500-CON-N-BOUND")
@both
def test_too_short_a_slope_is_cut_off_at_the_target(stepwise: bool) -> None:
    up = [PERIODS[rate] for rate in range(1, 253, 50)]  # six steps
    whole = made("R 253", "S 50", "N 13", "G", stepwise=stepwise).gaps
    assert whole == [*up, 1791, *up[:0:-1]]
    assert made("R 253", "S 50", "N 12", "G", stepwise=stepwise).gaps == [*up, *up[:0:-1]]
    cut = made("R 253", "S 50", "N 12", "G", "N 9", stepwise=stepwise)
    assert cut.codes == []
    assert cut.say("G").gaps[-8:] == [*up, *up[:3:-1]]
    assert cut.codes == ["short-slope"]
    assert made("R 253", "S 50", "N 6", "G", stepwise=stepwise).gaps == up[:5]
    assert made("R 253", "S 50", "N 3", "G", stepwise=stepwise).gaps == up[:2]


@pytest.mark.fact("CY500-RAMP-3")
def test_with_s_1_it_takes_505_steps_to_reach_the_top() -> None:
    assert slewline.ramp("cy500", R=253, S=1).reached_from == 505
    for number, slew in ((504, 0), (507, 3)):
        legs = {leg.name: leg.count for leg in profile.move(number, 253, 1, 1, LAW).legs}
        assert legs == {"up": 252, "down": 252} | ({"slew": slew} if slew else {})


@pytest.mark.fact("CY500-RAMP-4")
def test_a_slope_is_steeper_the_faster_it_is() -> None:
    up = LAW.up(253, 1)
    half, elapsed = sum(period for period, _ in up) // 2, 0
    for period, _ in up:
        elapsed += period
        if elapsed > half:
            break
    assert 1791 / period == pytest.approx(0.021, abs=0.001)


@pytest.mark.parametrize(
    ("rate", "slope", "number", "ms"), [(100, 1, 99, 1600.75), (200, 10, 20, 251.46), (253, 20, 13, 138.04)]
)
def test_the_calculator_knows_the_ramps(rate: int, slope: int, number: int, ms: float) -> None:
    ramp = slewline.ramp("cy500", R=rate, S=slope)
    assert (ramp.steps, ramp.time_ps / 10**9) == (number, pytest.approx(ms, abs=0.006))
    assert len(list(ramp.table())) == number
    move = ramp.move(5 * number)
    rig = made(f"R {rate}", f"S {slope}", f"N {5 * number}", "G")
    first = rig.times[0]
    assert [time - first for time in rig.times] == pytest.approx(move.times().tolist(), abs=200_000)


def test_the_calculator_finds_a_slope() -> None:
    found = find_ramps("cy500", R="3350 steps/s", time="266 ms")
    assert found[0].values["S"] == 10
    assert abs(found[0].time_ps - 266 * MS) < MS
    with pytest.raises(UsageError, match=r"allowed 50\.\.3350 steps/s"):
        find_ramps("cy500", R="9000 steps/s", time="266 ms")
    with pytest.raises(UsageError, match=r"allowed 1\.\.65535"):
        slewline.ramp("cy500", R=253, S=10).move(0)


def test_a_motion_reports_its_rates_and_its_ideal() -> None:
    rig = made("R 253", "S 10", "N 100", "G", "S 0", "F 2", "G")
    sloped, steady = rig.x.motions()
    assert sloped.rates == {"R = 253": pytest.approx(3350.08, abs=0.01)}
    assert steady.rates == {"R = 253": pytest.approx(1675.04, abs=0.01)}
    for motion in (sloped, steady):
        assert abs(rig.x.deviation(motion).position) <= 1.0001


# ----------------------------------------------------------------------------------------------------- steps and phases
@pytest.mark.fact("CY500-UND-PULSE")
@both
def test_pulse_is_high_for_16_us_between_steps(stepwise: bool) -> None:
    rig = Rig500(record=("pulse",), stepwise=stepwise)
    rig.say("R 253", "N 3", "G")
    falls, rises = rig.falls("pulse"), rig.rises("pulse")
    assert [round((fall - rise) / US) for fall, rise in zip(falls[1:], rises, strict=False)] == [16, 16]
    assert falls == rig.times


@pytest.mark.fact("CY500-CMD-H-1", "CY500-UND-PHASE", "CY500-CON-PHASES", "CY500-PIN-2")
@both
def test_half_steps_go_through_eight_patterns_and_full_steps_through_four(stepwise: bool) -> None:
    rig = Rig500(stepwise=stepwise)
    rig.say("R 253", "N 1")
    seen = []
    for _ in range(5):
        seen.append(rig.say("G").phases)
    assert seen == [FULL[row % 4] for row in range(1, 6)]
    rig.say("H", "H")
    seen = [rig.say("G").phases for _ in range(9)]
    assert seen == [HALF[(2 + row) % 8] for row in range(1, 10)]
    seen = [rig.say("-", "G").phases for _ in range(2)]
    assert seen == [HALF[2], HALF[1]]
    rig.say("I", "N 1")
    assert rig.say("G").phases == FULL[1]


@pytest.mark.fact("CY500-CMD-H-1")
def test_a_whole_motion_in_half_steps_is_promised() -> None:
    rig = Rig500(record=("phase1", "phase2", "phase3", "phase4"))
    rig.say("H", "R 253", "N 8", "G")
    levels = [rig.bench.edges(f"x.phase{n}") for n in (1, 2, 3, 4)]
    seen = []
    for time in rig.times:
        row = []
        for times, values in levels:
            known = [value for at, value in zip(times.tolist(), values.tolist(), strict=True) if at <= time]
            row.append(known[-1] if known else 1)
        seen.append(tuple(row))
    assert seen == [HALF[row % 8] for row in range(1, 9)]


@pytest.mark.fact("CY500-CMD-O-1", "CY500-UND-O-PULSE")
@both
def test_o_takes_one_step_immediately_at_any_rate(stepwise: bool) -> None:
    rig = Rig500(record=("pulse", "motion_complete"), stepwise=stepwise)
    rig.say("R 1", "F 9", "S 3", "O", "O", "-", "O")
    assert rig.signs == [1, 1, -1]
    falls, rises = rig.falls("pulse"), rig.rises("pulse")
    assert [round((rise - fall) * 6 / 10**6) for fall, rise in zip(falls, rises, strict=True)] == [1791 - 96] * 3
    assert rig.falls("motion_complete")[-1] - falls[-1] == pytest.approx(1791 / 6 * US, abs=1)


@pytest.mark.fact("CY500-UND-POSITION-COUNT")
def test_every_kind_of_step_counts_one() -> None:
    rig = made("R 253", "A", "B", "N 3", "G", "O", "H", "O", "G")
    assert rig.x.position == 8
    rig.say("J")
    rig.x.pin("xss").pulse(0, "1 ms")
    rig.bench.run("5 ms")
    assert rig.x.position == 8 + len(rig.times) - 8
    assert len(rig.times) > 10
    rig.say("I", "-", "N 20", "G")
    assert rig.x.position == (len(rig.times) - 40) % 65536


# ------------------------------------------------------------------------------------------------------- external lines
@pytest.mark.fact("CY500-CMD-J-1", "CY500-UND-JOG-SAMPLE")
@pytest.mark.parametrize(("stepwise", "low", "steps"), [(False, "1 s", 3350), (True, "100 ms", 335)])
def test_xss_low_runs_the_motor_until_it_is_high(stepwise: bool, low: str, steps: int) -> None:
    rig = Rig500(stepwise=stepwise)
    rig.say("R 253", "+", "J")
    assert rig.times == []
    rig.x.pin("xss").pulse(0, low)
    rig.bench.run("2 s")
    made = len(rig.times)
    assert made in (steps, steps + 1)
    assert set(rig.gaps) == {1791}
    rig.x.pin("xss").pulse(0, "100 us")
    rig.bench.run("2 ms")
    assert len(rig.times) == made + 1


@pytest.mark.fact("CY500-CMD-J-2", "CY500-UND-JOG-SLOPE")
@both
def test_a_jog_has_no_ramp(stepwise: bool) -> None:
    rig = Rig500(stepwise=stepwise)
    rig.say("R 200", "-", "S 3", "J")
    rig.x.pin("xss").pulse(0, "100 ms")
    rig.bench.run("1 s")
    assert set(rig.gaps) == {26_652}
    assert set(rig.signs) == {-1}
    rig.say("I", "F 2", "J")
    rig.x.pin("xss").pulse(0, "100 ms")
    rig.bench.run("1 s")
    assert set(rig.gaps[-5:]) == {2 * 26_652}


@pytest.mark.fact("CY500-UND-JOG-COMMAND", "CY500-CON-JOG")
@both
def test_commands_wait_while_the_motor_jogs(stepwise: bool) -> None:
    rig = Rig500(record=("ready", "programmable_output"), stepwise=stepwise)
    rig.say("R 253", "J", "C", "B")
    low = rig.bench.now_ps
    rig.drive("xss", 0)
    rig.bench.run("1 ms")
    assert rig.level("ready") == 0
    rig.host.send("C\r")
    rig.bench.run("5 ms")
    assert rig.falls("programmable_output", low) == []
    rig.drive("xss", 1)
    rig.bench.run_until_idle("1 s")
    assert len(rig.falls("programmable_output", low)) == 1
    assert rig.x.idle


@pytest.mark.fact("CY500-UND-JOG-COMMAND")
def test_a_command_that_has_begun_is_finished_before_the_motor_jogs() -> None:
    rig = made("R 253", "J")
    rig.host.send("C")
    rig.bench.run_until(rig.x.pin("ready").is_(0), "1 s")
    rig.drive("xss", 0)
    rig.bench.run("5 ms")
    assert rig.times == []
    rig.host.send("\r")
    rig.bench.run("5 ms")
    assert rig.level("programmable_output") == 0
    assert len(rig.times) > 10


@pytest.mark.fact("CY500-UND-JOG-END")
def test_g_is_ignored_in_jog_mode_which_i_ends() -> None:
    rig = made("R 253", "N 3", "J", "G")
    assert rig.times == []
    assert rig.codes == ["go-in-jog"]
    rig.say("I", "G")
    assert len(rig.times) == 3
    rig.drive("xss", 0)
    rig.bench.run("5 ms")
    assert len(rig.times) == 3


@pytest.mark.fact("CY500-CMD-J-3")
def test_t_in_jog_mode_is_reported() -> None:
    rig = made("J")
    rig.enter("T", "0")
    rig.execute()
    assert rig.codes == ["til-and-jog"]


@pytest.mark.fact("CY500-CMD-L-1", "CY500-CMD-L-2")
def test_l_gives_the_direction_to_xdir() -> None:
    rig = Rig500()
    rig.drive("xdir", 0)
    rig.say("R 253", "N 4", "L", "G", "+", "G")
    assert rig.signs == [-1] * 8
    assert rig.phases == FULL[0]
    rig.drive("xdir", 1)
    rig.say("-", "G")
    assert rig.signs[8:] == [1] * 4
    rig.say("I", "G")
    rig.drive("xdir", 0)
    rig.say("G")
    assert rig.signs[12:] == [1] * 8


@pytest.mark.fact("CY500-CMD-L-3")
@both
def test_a_change_of_xdir_turns_the_next_step(stepwise: bool) -> None:
    rig = Rig500(record=("phase1", "phase2"), stepwise=stepwise)
    rig.say("R 253", "N 12", "L")
    rig.start("G\r")
    rig.bench.run_until(rig.x.reaches((0xA55A + 3) % 65536), "1 s")
    rig.bench.run("100 us")
    rig.drive("xdir", 0)
    rig.bench.run_until_idle("1 s")
    assert rig.signs == [1] * 3 + [-1] * 9
    assert set(rig.gaps) == {1791}
    assert rig.phases == FULL[(3 - 9) % 4]
    assert [(mark.kind, mark.text) for mark in rig.x.marks()] == [("event", "XDIR")]


@pytest.mark.fact("CY500-CMD-O-2", "CY500-UND-TRIGGER")
@both
def test_trigger_holds_the_next_step_with_pulse_high(stepwise: bool) -> None:
    rig = Rig500(record=("pulse",), stepwise=stepwise)
    rig.drive("trigger", 1)
    rig.host.send("O\r")
    rig.bench.run("5 ms")
    assert rig.times == []
    assert stepwise or "O held by trigger=1" in rig.x.waiting
    now = rig.bench.now_ps
    rig.x.pin("trigger").pulse(0, "400 us")
    rig.bench.run("5 ms")
    assert len(rig.times) == 1
    assert rig.times[0] - now < 33 / 6 * US  # looked at every 33 clocks
    rig.drive("trigger", 0)
    rig.say("R 200", "N 5")
    rig.start("G\r")
    rig.bench.run_until(rig.x.reaches((0xA55A + 3) % 65536), "1 s")
    rig.drive("trigger", 1)
    rig.bench.run("50 ms")
    assert len(rig.times) == 3
    assert rig.level("pulse") == 1
    rig.drive("trigger", 0)
    released = rig.bench.now_ps
    rig.bench.run_until_idle("1 s")
    assert len(rig.times) == 6
    assert 0 <= rig.times[3] - released < 33 / 6 * US
    assert rig.gaps[-2:] == [26_652] * 2


@pytest.mark.fact("CY500-UND-TRIGGER")
@both
def test_abort_ends_a_motion_after_the_running_step(stepwise: bool) -> None:
    rig = Rig500(record=("pulse", "motion_complete"), stepwise=stepwise)
    rig.say("R 253", "S 10", "N 100", "A")
    rig.start("G\r")
    rig.bench.run_until(rig.x.reaches(40), "2 s")
    rig.drive("abort", 0)
    rig.bench.run_until_idle("1 s")
    assert rig.x.position == 40
    assert rig.falls("motion_complete")[-1] - rig.times[-1] == pytest.approx(1791 / 6 * US, abs=10)
    rig.say("G", "O")
    assert rig.x.position == 40
    rig.drive("abort", 1)
    rig.say("G")
    assert rig.x.position == 140
    assert [motion.end.why for motion in rig.x.motions()] == ["stopped", "stopped", "stopped", "done"]


def test_reset_in_mid_motion_stops_it_immediately() -> None:
    rig = made("R 253", "N 1000", "A", "H", "L", "S 4")
    rig.start("G\r")
    rig.bench.run("700 ms")
    before = len(rig.times)
    rig.x.reset()
    rig.bench.run("10 ms")
    assert len(rig.times) == before
    assert rig.phases == (1, 1, 1, 1)
    rig.say("N 4", "G")
    assert rig.phases == FULL[0]
    assert set(rig.gaps[-2:]) == {1791}


def test_the_sheet_marks_inferred_facts() -> None:
    sheet = sheet_of("cy500")
    assert {time.trust for time in sheet.times.values()} == {"inferred"}
    stated = {pin.name for pin in sheet.pins if pin.trust == "stated" and pin.role}
    assert stated == {"xss", "programmable_output"}
    assert steps_of(profile.one(LAW).runs) == 1


@pytest.mark.fact("CY500-PIN-2", "CY500-PIN-4")
def test_a_rotor_follows_the_phases_and_a_translator_misses_a_direction() -> None:
    rig = Rig500()
    rotor = rig.bench.part("rotor", name="motor", to="x")
    rig.say("R 253", "N 12", "+", "G", "-", "N 3", "G")
    assert rotor.position == 9
    with pytest.raises(WiringError, match="shows the direction"):
        rig.bench.part("translator", to="x")
