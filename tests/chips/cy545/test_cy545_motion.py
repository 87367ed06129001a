"""The CY545's motions: rates, ramps, continuous motion, SLEW, STOPPED, INHIBIT_ABORT, the limits, and the position."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import pairwise

import pytest
from cy545 import MS, US, Rig545, near, periods, steppable

import slewline
from slewline.chips.cy545 import profile, sheet
from slewline.errors import UsageError

PINS = ("pulse", "ccw", "stopped", "slew")
RATES = sheet.TABLES["20k"]
rigged = partial(steppable, PINS)


def slewing(*lines: str, number: int = 10_000, **options: object) -> Rig545:
    """A chip in the midst of a long motion, at the rate of R."""
    rig = rigged("+", f"N {number}", *lines, **options)
    rig.start("G\r")
    rig.bench.run_until(rig.x.pin("slew").is_(0), "20 s")
    rig.bench.run("20 ms")
    return rig


# ------------------------------------------------------------------------------------------------- PULSE, CCW, position
@pytest.mark.fact("CY545-PULSE-1", "CY545-PULSE-5", "CY545-CMD-G-1", "CY545-CMD-G-2")
def test_each_step_is_a_low_pulse_and_moves_the_position_by_one() -> None:
    rig = rigged("A 100", "N 7", "-", "G")
    assert len(rig.falls("pulse")) == len(rig.rises("pulse")) == 7
    assert rig.x.position == 93 and rig.level("ccw") == 1
    rig.send("+\rG\rG\rG\r")
    assert len(rig.falls("pulse")) == 28
    assert rig.x.position == 114
    rig.x.pin("inhibit_abort").drive(0)
    rig.start("G\r")
    for step in range(3):
        rig.drive("inhibit_abort", 1)
        rig.bench.run_until(rig.x.pin("pulse").edges(2))  # it falls, and rises
        assert rig.x.position == 115 + step


@pytest.mark.fact("CY545-PULSE-2", "CY545-PULSE-3", "CY545-UND-PULSE-WIDTH")
@pytest.mark.parametrize(("crystal", "low"), [("12 MHz", 5 * US), ("6 MHz", 10 * US), ("16 MHz", 3_750_000)])
def test_pulse_is_low_at_the_start_of_a_step_for_a_time_that_only_the_crystal_changes(crystal: str, low: int) -> None:
    for rate in (0, 100, 255):
        rig = rigged("+", "N 3", f"F {rate}", f"R {rate}", crystal=crystal)
        assert rig.level("pulse") == 1
        rig.send("G\r")
        widths = [rise - fall for fall, rise in zip(rig.falls("pulse"), rig.rises("pulse"), strict=True)]
        assert all(abs(width - low) <= 1 for width in widths), (rate, widths)
        assert rig.falls("pulse")[0] < rig.rises("pulse")[0]
        assert rig.level("pulse") == 1


@pytest.mark.fact("CY545-PULSE-4", "CY545-CMD-F-1", "CY545-CMD-R-1", "CY545-UND-PERIOD-FIRST")
@pytest.mark.parametrize(("index", "us"), [(36, 1086.96), (137, 168.0), (255, 50.0), (0, 50_000.0)])
def test_a_period_is_between_two_falls_and_is_one_over_the_rate(index: int, us: float) -> None:
    rig = rigged("+", f"F {index}", f"R {index}", "N 20", "G")
    assert {near(period, us * US, 0.01) for period in periods(rig)} == {True}
    assert len(rig.x.steps()) == 20


@pytest.mark.fact("CY545-CCW-1", "CY545-CMD-PLUS-1", "CY545-CMD-G-1")
def test_ccw_high_counts_down_and_low_counts_up() -> None:
    rig = rigged("A 10", "N 3")
    found = []
    for line in ("", "-\rG\r", "+\rG\r", "G\r"):
        rig.send(line)
        found.append((rig.x.position, rig.level("ccw")))
    assert found == [(10, 1), (7, 1), (10, 0), (13, 0)]


@pytest.mark.fact("CY545-CCW-2", "CY545-CCW-4")
def test_ccw_pulled_low_from_outside_turns_the_steps_clockwise_one_by_one() -> None:
    rig = rigged("-", "A 50", "N 10", "F 100", "R 100")
    rig.drive("ccw", 0)
    rig.start("G\r")
    rig.bench.run_until(rig.x.reaches(55), "1 s")
    rig.x.pin("ccw").release()
    rig.bench.run_until_idle()
    steps = rig.x.steps()
    assert steps.directions.tolist() == [1] * 5 + [-1] * 5
    assert rig.x.position == 50 and not rig.codes
    assert rig.x.motions()[-1].direction == 1
    assert len({round(period, -6) for period in periods(rig)}) == 1


@pytest.mark.fact("CY545-CCW-3")
def test_pulling_ccw_high_while_the_chip_drives_it_low_fails_with_a_finding() -> None:
    rig = rigged("+", "A 0", "N 4")
    rig.drive("ccw", 1)
    rig.send("G\r")
    assert rig.x.position == 4
    assert "conflict" in rig.codes


@pytest.mark.fact("CY545-CMD-P-1", "CY545-UND-P-DIRECTION")
def test_p_finds_its_direction_and_leaves_it_and_takes_no_step_to_its_position() -> None:
    rig = rigged("A 0", "N 5", "P 40")
    assert rig.x.position == 40 and rig.level("ccw") == 0
    rig.send("P 15\r")
    assert rig.x.position == 15 and rig.level("ccw") == 1 and len(rig.x.steps()) == 65
    rig.send("G\r")
    assert rig.x.position == 10  # the direction of P stays
    stops = len(rig.edges("stopped"))
    rig.send("P 10\r")
    assert len(rig.edges("stopped")) == stops and rig.level("ccw") == 0
    rig.send("G\r")
    assert rig.x.position == 15


@pytest.mark.fact("CY545-UND-RESET-DIRECTION")
@pytest.mark.parametrize("first", ["+", "-", "P 3", None])
def test_a_g_with_no_direction_set_is_reported_once(first: str | None) -> None:
    rig = rigged("N 5", *([first] if first else []), "G", "G")
    assert rig.codes == ([] if first else ["direction-inferred"])
    told = rig.x.findings[-1].text if rig.codes else "counter-clockwise (inferred), and the position counts down"
    assert "counter-clockwise (inferred), and the position counts down" in told
    rig.send("I\rG\rG\r")
    assert rig.codes == ["direction-inferred"]


@pytest.mark.fact("CY545-UND-WRAP", "CY545-RESET-3", "CY545-UND-RESET-DIRECTION", "CY545-DER-DIR-RESET")
def test_the_first_steps_after_reset_count_down_and_the_position_wraps_at_24_bits() -> None:
    rig = rigged("N 5", "G")
    assert rig.x.position == (1 << 24) - 5
    rig.send("A 16777214\rN 3\r+\rG\r")
    assert rig.x.position == 1
    assert rigged("N 5", "G", direction="+").x.position == 5


@pytest.mark.fact("CY545-UND-N-ZERO")
def test_g_with_n_0_takes_no_step_and_is_a_finding() -> None:
    rig = rigged("+", "N 0", "G")
    assert not rig.edges("stopped") and not rig.falls("pulse")
    assert rig.codes == ["no-steps"]


@pytest.mark.fact("CY545-UND-FIRST-STEP", "CY545-UND-CCW-SETUP")
def test_a_motion_begins_100_us_after_its_command_and_ccw_comes_well_before() -> None:
    rig = rigged("+", "N 3", "F 255")
    began: list[int] = []
    rig.x.on_motion_begin.add(lambda motion: began.append(motion.time_ps))
    rig.send("-\rP 4\rP 0\r")
    moves = [at for at in began if any(0 < fall - at < MS for fall in rig.falls("pulse"))]
    assert len(moves) == 2
    for at in moves:
        first = next(fall for fall in rig.falls("pulse") if fall > at)
        assert abs(first - at - 100 * US) <= 1
        change = max(edge for edge, _ in rig.edges("ccw") if edge <= first)
        assert first - change >= 20 * US


# ------------------------------------------------------------------------------------------------------- STOPPED, SLEW
@pytest.mark.fact("CY545-STOPPED-1", "CY545-STOPPED-2", "CY545-STOPPED-3", "CY545-STOPPED-4", "CY545-UND-STOPPED-REF")
@pytest.mark.parametrize(("crystal", "hold"), [("12 MHz", 5 * MS), ("6 MHz", 10 * MS)])
def test_stopped_is_low_throughout_and_rises_5_ms_after_the_last_step(crystal: str, hold: int) -> None:
    rig = rigged("+", "N 10", "F 36", crystal=crystal)
    assert rig.level("stopped") == 1
    rig.send("G\r")
    (low, _), (high, _) = rig.edges("stopped")
    falls = rig.falls("pulse")
    assert near(falls[0] - low, hold / 250, 0.01)
    assert near(high - falls[-1], hold + falls[1] - falls[0], 0.01)  # the last step is as long as the first one
    assert low < falls[0] and falls[-1] < high


@pytest.mark.fact("CY545-SLEW-1", "CY545-SLEW-2", "CY545-CON-SLEW-TIME", "CY545-RATE-5", "CY545-DER-RAMP-STEPS")
def test_slew_is_low_exactly_while_steps_are_made_at_the_rate_of_r() -> None:
    rig = rigged("+", "F 14", "R 100", "S 220", "N 10000", "G")
    (low, _), (high, _) = rig.edges("slew")
    (begin, _), (end, _) = rig.edges("stopped")
    falls, gaps = rig.falls("pulse"), periods(rig)
    assert len(falls) == 10_000 and rig.x.position == 10_000
    assert falls[1599] == low and falls[10_000 - 1599] == high
    assert {round(gap, -5) for gap in gaps[1599 : 10_000 - 1599]} == {242_800_000}
    assert min(gaps[:1599]) > max(gaps[1600:8000])
    assert near(low - begin, 793 * MS, 2) and near(end - high, 798 * MS, 2)
    assert near(gaps[0], 2702.7 * US, 0.01) and near(end - 5 * MS - falls[-1], 2702.7 * US, 0.01)
    assert near(rig.x.motions()[-1].end.time_ps - begin, 3.2415 * 10**12, 0.1)


@pytest.mark.fact("CY545-SLEW-3", "CY545-SLEW-4", "CY545-CONT-5", "CY545-UND-SLEW-INPUT")
def test_slew_pulled_low_before_the_first_step_makes_a_motion_continuous_and_later_does_not() -> None:
    rig = rigged("+", "F 100", "R 100", "N 10")
    for _ in range(2):
        rig.drive("slew", 0)
        before = rig.x.travel
        rig.start("G\r")
        rig.bench.run("100 ms")
        assert rig.x.travel - before > 300
        assert rig.level("slew") == 0
        rig.x.pin("inhibit_abort").pulse(0, "1 ms")
        rig.bench.run_until_idle()
    rig.x.pin("slew").release()
    before = rig.x.travel
    rig.send("G\r")
    assert rig.x.travel - before == 10
    rig.send("N 100\r")
    rig.start("G\r")
    rig.bench.run_until(rig.x.pin("pulse").is_(0))
    rig.drive("slew", 0)
    rig.bench.run_until_idle()
    assert rig.x.travel - before == 110


@pytest.mark.fact("CY545-SLEW-5", "CY545-RAMP-3", "CY545-DER-DEFAULT-MOVE")
def test_a_short_motion_makes_a_partial_ramp_with_slew_high() -> None:
    rig = rigged("G")
    assert not rig.edges("slew")
    falls = rig.falls("pulse")
    assert len(falls) == 200
    assert near(1e12 / min(periods(rig)), 820, 0.01)
    assert near(falls[-1] + periods(rig)[0] - falls[0], 340.9 * MS, 0.05)
    assert "slew" not in {name for _, _, name in rig.x.phases()}


# ---------------------------------------------------------------------------------------------------- rates and ramps
@pytest.mark.fact("CY545-RATE-1", "CY545-RATE-4")
@pytest.mark.parametrize(("crystal", "factor"), [("12 MHz", 1.0), ("6 MHz", 0.5), ("16 MHz", 4 / 3)])
def test_rates_are_those_of_the_table_times_the_crystal_over_12_mhz(crystal: str, factor: float) -> None:
    rig = rigged("+", "N 3", crystal=crystal)
    for index in (0, 1, 14, 36, 37, 100, 136, 137, 200, 254, 255):
        law = 20 + 25 * index if index <= 36 else 920 + 50 * (index - 36) if index <= 136 else 1e6 / (305 - index)
        since = rig.bench.now_ps
        rig.send(f"F {index}\rR {index}\rG\r")
        falls = rig.falls("pulse", since)
        assert near(1e12 / (falls[1] - falls[0]), law * factor, 0.02), index


@pytest.mark.fact("CY545-RATE-4", "CY545-RATE-2", "CY545-DER-RATE-FIT")
def test_all_256_rates_follow_the_law_and_their_distances_grow_as_documented() -> None:
    by = [b - a for a, b in pairwise(RATES)]
    assert len(RATES) == 256 and set(by[:36]) == {25} and set(by[36:136]) == {50}
    assert by[136] == 32 and by[137:141] == [36, 36, 37, 37]
    assert all(b >= a - 1 for a, b in pairwise(by[137:]))  # they grow; the table is in whole steps/s
    assert (by[199], by[253]) == (90, 377)
    law = profile.law_of(sheet.CY545)
    assert all(law.periods[k] == 12 * (305 - k) for k in range(137, 256))
    assert all(near(12e6 / law.periods[k], RATES[k], 0.025) for k in range(256))


@pytest.mark.fact("CY545-RATE-3", "CY545-CON-RATE-TOP", "CY545-DER-RATE-TOP-16")
def test_the_option_selects_a_top_rate_of_20000_or_27000() -> None:
    tops = []
    for crystal, table in (("12 MHz", "20k"), ("16 MHz", "20k"), ("12 MHz", "27k")):
        rig = rigged("+", "F 255", "R 255", "N 9", "G", crystal=crystal, rate_table=table)
        tops.append(round(1e12 / periods(rig)[0]))
    assert tops == [20_000, 26_667, 27_027]


MINE = [10 * (k + 1) for k in range(256)]


@pytest.mark.fact("CY545-RATE-4")
def test_custom_rates_replace_the_table_in_the_chip_and_in_its_sheet() -> None:
    rig = rigged("+", "F 9", "R 9", "N 3", "G", inferred={"rates": MINE})
    assert {near(period, 10 * MS, 0.01) for period in periods(rig)} == {True}
    assert rig.x.sheet.rates == tuple(MINE) and sheet.CY545B.rates == RATES


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (MINE[:255], "255 numbers; allowed 256 or none"),
        ([*MINE[:255], 5], "5 at 255 is below 2550; allowed ascending numbers"),
        ([0, *MINE[1:]], "allowed whole numbers, each 1..40000"),
    ],
)
def test_an_invalid_table_is_refused(wrong: list[int], says: str) -> None:
    with pytest.raises(UsageError, match=says):
        slewline.Bench().add("cy545", inferred={"rates": wrong})


@pytest.mark.fact("CY545-RAMP-1", "CY545-RAMP-2", "CY545-UND-RAMP-RULE")
@pytest.mark.parametrize("number", [1, 2, 3, 199, 3197, 3198, 3199, 3200, 5001])
def test_a_motion_is_its_own_mirror_image_with_its_number_of_steps(number: int) -> None:
    rig = rigged("+", f"N {number}", "G")
    falls = rig.falls("pulse")
    (end,) = (edge for edge, level in rig.edges("stopped") if level)
    gaps = [b - a for a, b in pairwise([*falls, end - 5 * MS])]
    assert len(falls) == number
    clocks = [round(gap * 12 / US) for gap in gaps]
    assert clocks == clocks[::-1]
    assert bool(rig.edges("slew")) is (number > 3198)


def by_hand(first: int, rate: int, slope: int, jumps: bool = True) -> list[int]:
    """The way up, step by step, by the maker's formula: a rate every 256 * (256 - S) cycles; clocks."""
    clocks, index, found = 0, first, list[int]()
    while index < rate:
        found.append(round(12e6 / RATES[index]))
        clocks += found[-1]
        due = first + clocks // (3072 * (256 - slope))
        index = due if jumps else min(index + 1, due)
    return found


@pytest.mark.fact("CY545-RAMP-4", "CY545-UND-RAMP-RULE", "CY545-DER-RAMP-CONST", "CY545-CMD-S-1")
@pytest.mark.parametrize("jumps", [True, False])
@pytest.mark.parametrize(("first", "rate", "slope"), [(14, 100, 220), (0, 60, 250), (36, 136, 254), (100, 255, 255)])
def test_a_ramp_takes_the_due_rates_together_or_one_a_step(first: int, rate: int, slope: int, jumps: bool) -> None:
    up = by_hand(first, rate, slope, jumps)
    number = 2 * len(up) + 3
    rig = rigged("+", f"F {first}", f"R {rate}", f"S {slope}", f"N {number}", "G", ramp_jumps=jumps)
    clocks = [round(period * 12 / US) for period in periods(rig)]
    assert clocks[: len(up)] == up
    assert clocks[len(up) : len(up) + 3] == [round(12e6 / RATES[rate])] * 3
    assert clocks[len(up) + 3 :] == up[:0:-1]


def test_several_rates_in_a_step_come_only_where_a_step_is_longer_than_a_rate() -> None:
    up = by_hand(0, 100, 255)
    assert len(up) < 100 < len(by_hand(0, 100, 255, jumps=False)) + 1
    assert by_hand(14, 100, 220) == by_hand(14, 100, 220, jumps=False)


@pytest.mark.fact("CY545-RAMP-5", "CY545-RAMP-4")
@pytest.mark.parametrize(
    ("first", "rate", "slope", "steps", "ms"),
    [
        (14, 100, 1, 11332, 5614.08),
        (14, 100, 100, 6932, 3434.50),
        (14, 100, 175, 3599, 1783.30),
        (14, 100, 220, 1599, 792.58),
        (14, 100, 250, 266, 132.10),
        (0, 255, 175, 32487, 5287.68),
        (0, 255, 255, 201, 65.28),
    ],
)
def test_ramp_times_are_the_rate_difference_over_the_acceleration(
    first: int, rate: int, slope: int, steps: int, ms: float
) -> None:
    ramp = slewline.ramp("cy545", F=first, R=rate, S=slope)
    assert ramp.steps == steps
    assert near(ramp.time_ps, ms * MS, 0.2)
    if slope <= 250:  # of steeper ones a step of 242 us is too large a part
        middle = slewline.ramp("cy545", F=80, R=90, S=slope)
        assert near(middle.acceleration, 3906 * 50 / (256 - slope), 2)


@pytest.mark.fact("CY545-RAMP-6", "CY545-CMD-S-1")
def test_ramp_times_depend_on_the_rates_passed_and_on_s_alone_and_scale_with_the_crystal() -> None:
    def time(first: int, slope: int, crystal: str = "12 MHz") -> int:
        return slewline.ramp("cy545b", F=first, R=first + 86, S=slope, crystal=crystal).time_ps

    assert near(time(14, 220), 792.6 * MS, 1) and near(time(114, 220), 792.6 * MS, 1)
    assert near(time(14, 220, "6 MHz"), 2 * 792.6 * MS, 1)
    falling = [time(14, slope) for slope in (1, 100, 175, 200, 225, 255)]
    assert falling == sorted(falling, reverse=True)


@pytest.mark.fact("CY545-UND-R-BELOW-F")
def test_r_below_f_makes_the_whole_motion_at_f_with_slew_low() -> None:
    rig = rigged("+", "F 100", "R 14", "N 20", "G")
    assert len({round(period, -5) for period in periods(rig)}) == 1
    assert near(periods(rig)[0], 1e12 / RATES[100], 0.02)
    assert rig.falls("slew") == [rig.falls("pulse")[0]]
    rig.send("G\r")
    assert rig.codes == ["rate-below-firstrate"]  # once


@pytest.mark.fact("CY545-UND-S-ZERO")
def test_s_0_counts_as_256_less_0() -> None:
    rig = rigged("+", "S 0", "F 14", "R 15", "N 200", "G")
    slow = round(12e6 / RATES[14])
    lasts = -(-(256 * 3072) // slow)  # steps at the first rate: until 256 units are over
    clocks = [round(period * 12 / US) for period in periods(rig)]
    assert clocks == [slow] * lasts + [round(12e6 / RATES[15])] * (200 - 2 * lasts) + [slow] * (lasts - 1)
    assert set(rig.codes) == {"range"}


# ---------------------------------------------------------------------------------------------------------- continuous
@pytest.mark.fact("CY545-CMD-C-1", "CY545-CONT-1", "CY545-CONT-2", "CY545-CONT-3", "CY545-CONT-4")
def test_c_makes_the_next_motion_endless_until_inhibit_abort_slows_it_down() -> None:
    rig = rigged("+", "N 10", "C")
    rig.bench.run("1 s")
    assert not rig.falls("pulse")
    rig.start("G\r")
    rig.bench.run("30 s")
    assert rig.x.position > 100_000
    steady = {round(period, -4) for period in periods(rig)[2000:]}
    assert len(steady) == 1
    rig.drive("inhibit_abort", 0)
    asked = rig.bench.now_ps
    rig.bench.run_until_idle("5 s")
    up = by_hand(14, 100, 220)
    clocks = [round(period * 12 / US) for period in periods(rig)]
    fast = round(12e6 / RATES[100])
    down = clocks[max(k for k, each in enumerate(clocks) if each == fast) + 1 :]
    slow = [each for each in up[::-1] if each != up[0]]
    assert down[: len(slow)] == slow and len(down) == len(slow)  # and one step at the first rate
    assert rig.level("stopped") == 1 and rig.bench.now_ps - asked < 900 * MS
    assert rig.x.position == len(rig.falls("pulse")) == len(rig.x.steps())
    assert rig.x.motions()[-1].end.why == "stopped"
    rig.drive("inhibit_abort", 1)
    before = rig.x.position
    rig.send("G\r")
    assert rig.x.position == before + 10


@pytest.mark.fact("CY545-UND-CONT-P")
@pytest.mark.parametrize(("target", "sign"), [(5, -1), (500, 1), (100, 1)])
def test_p_in_continuous_mode_takes_its_direction_from_the_target_and_runs_on(target: int, sign: int) -> None:
    rig = rigged("A 100", "F 100", "C")
    rig.start(f"P {target}\r")
    rig.bench.run("2 s")
    assert rig.x.travel * sign > 4000


@pytest.mark.fact("CY545-UND-CONT-RELEASE")
def test_a_continuous_motion_whose_abort_is_taken_back_continues_at_the_first_rate_until_the_line_is_low() -> None:
    rig = rigged("+", "N 10", "C")
    rig.start("G\r")
    rig.bench.run("2 s")
    rig.x.pin("inhibit_abort").pulse(0, "10 ms")
    rig.bench.run("30 s")
    assert near(rig.x.velocity_at(rig.bench.now_ps), RATES[14], 0.01)
    before = rig.x.position
    rig.drive("inhibit_abort", 0)
    rig.bench.run_until_idle()
    assert rig.x.position - before <= 1


# ------------------------------------------------------------------------------------------------------- INHIBIT_ABORT
@pytest.mark.fact("CY545-INHIB-1", "CY545-INHIB-2", "CY545-UND-STOPPED-OTHER")
@pytest.mark.parametrize("command", ["G", "P 200"])
def test_inhibit_abort_low_holds_a_motion_back_however_long_and_nothing_else_ends_that(command: str) -> None:
    rig = rigged("+", "N 200")
    rig.drive("inhibit_abort", 0)
    rig.start(f"{command}\r")
    rig.bench.run("10 s")
    for pin in ("cw_limit", "ccw_limit", "jog"):
        rig.x.pin(pin).pulse(0, "1 s")
        rig.bench.run("2 s")
    rig.bench.run("990 s")
    assert not rig.falls("pulse") and rig.level("stopped") == 1 and rig.level("busy") == 0
    rig.drive("inhibit_abort", 1)
    rose = rig.bench.now_ps
    rig.bench.run_until_idle()
    assert rig.falls("pulse")[0] - rose <= 26 * US
    assert rig.x.position == 200


@pytest.mark.fact("CY545-UND-FIRST-STEP", "CY545-INHIB-1")
def test_an_inhibited_motion_begins_25_us_after_the_rise_of_the_line() -> None:
    rig = rigged("+", "N 3")
    rig.drive("inhibit_abort", 0)
    rig.start("G\r")
    rig.bench.run("10 ms")
    rig.drive("inhibit_abort", 1)
    rose = rig.bench.now_ps
    rig.bench.run_until_idle()
    assert 25 * US <= rig.falls("pulse")[0] - rose <= 25 * US + 83_334


@pytest.mark.fact("CY545-INHIB-3")
def test_several_chips_on_one_line_begin_together() -> None:
    bench = slewline.Bench()
    chips = [
        bench.add("cy545", name=name, crystal=crystal)
        for name, crystal in (("x", "12 MHz"), ("y", "11 MHz"), ("z", "16 MHz"))
    ]
    line = chips[0].pin("inhibit_abort")
    for chip in chips[1:]:
        bench.wire(f"{chip.name}.inhibit_abort", "x.inhibit_abort")
    line.drive(0)
    for number, chip in enumerate(chips):
        bench.host(chip).send(f"+\rN {10 + number}\rG\r")
    bench.run("1 s")
    line.drive(1)
    bench.run_until_idle()
    first = [int(chip.steps().times_ps[0]) for chip in chips]
    assert max(first) - min(first) < 100 * US
    assert [chip.position for chip in chips] == [10, 11, 12]


@pytest.mark.fact("CY545-INHIB-4", "CY545-INHIB-5", "CY545-INHIB-8", "CY545-UND-INHIB-SAMPLE")
def test_kept_low_it_decelerates_a_motion_by_the_mirrored_up_ramp_and_stops_it_at_the_first_rate() -> None:
    rig = slewing()
    rig.drive("inhibit_abort", 0)
    rig.bench.run_until(rig.x.pin("stopped").is_(1), "5 s")
    clocks = [round(period * 12 / US) for period in periods(rig)]
    up = by_hand(14, 100, 220)
    mirror = [each for each in up[::-1] if each != up[0]]
    assert clocks[-len(mirror) :] == mirror  # then one step at the first rate, which nothing follows
    assert rig.x.position == len(rig.falls("pulse")) < 10_000
    last, (high,) = rig.falls("pulse")[-1], rig.rises("stopped")
    assert near(high - last, 5 * MS + 2702.7 * US, 0.1)
    rig.bench.run_until_idle()
    assert rig.level("busy") == 1


@pytest.mark.fact("CY545-UND-INHIB-SAMPLE")
def test_on_the_up_ramp_it_turns_immediately_and_descends_as_far_as_it_climbed() -> None:
    rig = rigged("+", "N 10000")
    rig.start("G\r")
    rig.bench.run("300 ms")
    made = rig.x.position
    rig.drive("inhibit_abort", 0)
    rig.bench.run_until_idle()
    clocks = [round(period * 12 / US) for period in periods(rig)]
    up = by_hand(14, 100, 220)[:made]
    assert clocks[:made] == up
    assert clocks[made:] == [each for each in up[::-1] if each != up[0]]
    assert not rig.edges("slew")


def test_a_low_between_two_samples_is_missed() -> None:
    rig = slewing()
    rig.bench.run_until(rig.x.pin("pulse").is_(0))
    rig.x.pin("inhibit_abort").pulse(0, "100 us", at=rig.bench.now_ps + 50 * US)
    rig.bench.run_until_idle()
    assert rig.x.position == 10_000
    assert rig.x.motions()[-1].end.why == "done"


@pytest.mark.fact("CY545-INHIB-6", "CY545-INHIB-7")
def test_released_before_the_first_rate_it_lets_the_motion_crawl_to_its_target_and_a_second_low_stops_it() -> None:
    for second in (False, True):
        rig = slewing(number=6000)
        rig.x.pin("inhibit_abort").pulse(0, "50 ms")
        rig.bench.run("1500 ms")
        assert near(rig.x.velocity_at(rig.bench.now_ps), RATES[14], 0.01)
        if second:
            before = rig.x.position
            rig.drive("inhibit_abort", 0)
        rig.bench.run_until_idle("60 s")
        assert rig.x.position == (before if second else 6000)
        assert len({round(period, -5) for period in periods(rig)[-5:]}) == 1
        assert len(rig.edges("slew")) == 2  # it never speeds up again


@pytest.mark.fact("CY545-UND-INHIB-TARGET")
def test_the_target_ends_a_motion_that_inhibit_abort_slows_down() -> None:
    rig = slewing(number=8000)
    rig.bench.run_until(rig.x.reaches(5500), "5 s")
    rig.drive("inhibit_abort", 0)
    rig.bench.run_until(rig.x.reaches(6700), "5 s")
    rig.drive("inhibit_abort", 1)
    rig.bench.run_until_idle("60 s")
    assert rig.x.position == 8000
    near_the_end = slewing(number=4000)
    near_the_end.bench.run_until(near_the_end.x.reaches(3900), "5 s")
    near_the_end.x.pin("inhibit_abort").pulse(0, "30 ms")
    near_the_end.bench.run_until_idle()
    assert near_the_end.x.position == 4000


@pytest.mark.fact("CY545-UND-INHIB-NORAMP")
@pytest.mark.parametrize("lines", [("F 100", "R 100"), ("F 100", "R 14"), ("F 14", "R 100")])
def test_low_in_a_motion_at_the_first_rate_it_ends_with_the_step_in_progress(lines: Sequence[str]) -> None:
    rig = rigged("+", "N 100", *lines)
    rig.start("G\r")
    rig.bench.run_until(rig.x.reaches(2))
    rig.drive("inhibit_abort", 0)
    rig.bench.run_until_idle()
    assert rig.x.position == 2


# -------------------------------------------------------------------------------------------------------------- limits
@pytest.mark.fact("CY545-LIMIT-1", "CY545-LIMIT-5", "CY545-UND-LIMIT-SAMPLE")
@pytest.mark.parametrize(("turn", "pin"), [("+", "cw_limit"), ("-", "ccw_limit")])
@pytest.mark.parametrize("continuous", ["", "C"])
def test_a_limit_ends_a_motion_with_the_step_in_progress(turn: str, pin: str, continuous: str) -> None:
    rig = rigged("A 5000", turn, "N 10000", *([continuous] if continuous else []))
    rig.start("G\r")
    rig.bench.run_until(rig.x.reaches(6000 if turn == "+" else 4000), "5 s")
    rig.bench.run("20 us")
    rig.drive(pin, 0)
    at = rig.bench.now_ps
    rig.bench.run_until_idle()
    assert rig.falls("pulse", at) == []
    assert rig.x.position == (6000 if turn == "+" else 4000)
    assert rig.x.motions()[-1].end.why == "limit"
    assert rig.level("stopped") == 1
    period = periods(rig)[-1]
    assert 5 * MS - US <= rig.rises("stopped")[-1] - rig.falls("pulse")[-1] - period <= 5 * MS + 20 * US
    widths = [rise - fall for fall, rise in zip(rig.falls("pulse"), rig.rises("pulse"), strict=True)]
    assert widths[-1] == pytest.approx(5 * US, abs=1)


@pytest.mark.fact("CY545-LIMIT-2", "CY545-LIMIT-3", "CY545-LIMIT-4", "CY545-UND-STOPPED-OTHER")
def test_a_limit_that_is_low_already_refuses_its_direction_and_no_other() -> None:
    rig = rigged("A 100", "N 30", "+")
    rig.drive("cw_limit", 0)
    rig.send("G\rP 120\r")
    assert rig.x.position == 100 and not rig.edges("stopped") and not rig.falls("pulse")
    assert rig.level("busy") == 1
    assert [motion.end.why for motion in rig.x.motions()] == ["limit", "limit"]
    rig.send("-\rG\r")
    assert rig.x.position == 70
    rig.drive("cw_limit", 1)
    rig.drive("ccw_limit", 0)
    rig.send("+\rG\r")
    assert rig.x.position == 100


@pytest.mark.fact("CY545-LIMIT-4", "CY545-UND-LIMIT-SAMPLE")
def test_a_limit_counts_after_a_hold_and_a_short_low_between_steps_does_not() -> None:
    rig = rigged("+", "N 30")
    rig.drive("inhibit_abort", 0)
    rig.start("G\r")
    rig.drive("cw_limit", 0)
    rig.bench.run("10 ms")
    rig.drive("inhibit_abort", 1)
    rig.bench.run_until_idle()
    assert rig.x.position == 0
    rig.drive("cw_limit", 1)
    rig.start("G\r")
    rig.bench.run_until(rig.x.reaches(5))
    rig.x.pin("cw_limit").pulse(0, "100 us", at=rig.bench.now_ps + 50 * US)
    rig.bench.run_until_idle()
    assert rig.x.position == 30


@pytest.mark.fact("CY545-UND-LIMIT-PROGRAM")
def test_a_program_continues_after_a_limit() -> None:
    rig = Rig545(*PINS, replies=False)
    rig.enter("N 50", "+", "G", "-", "N 20", "G", "B 16", "0")
    rig.drive("cw_limit", 0)
    rig.run_program()
    assert rig.x.travel == -20 and rig.level("usrb0") == 0


# -------------------------------------------------------------------------------------------------------- long motions
def test_a_move_of_16_million_steps_is_planned_whole() -> None:
    rig = rigged("+", "F 14", "R 255", "S 220", "N 16000000")
    rig.start("G\r")
    rig.bench.run_until_idle("1000 s")
    assert rig.x.position == 16_000_000
    assert len(rig.x.motor.past) == 2
    assert len(profile.move(16_000_000, 14, 255, 220, profile.law_of(sheet.CY545)).legs) == 3


@pytest.mark.fact("CY545-CMD-P-1")
def test_reset_in_mid_motion_ends_it_and_the_next_one_is_whole() -> None:
    rig = slewing()
    rig.x.reset()
    rig.bench.run_until_idle()
    assert (
        rig.x.position == 0 and rig.level("stopped") == rig.level("slew") == rig.level("pulse") == rig.level("ccw") == 1
    )
    assert rig.x.motions()[-1].end.why == "cut"
    rig.send("+\rN 5\rG\r")
    assert rig.x.position == 5


@pytest.mark.fact("CY545-LIMIT-6")
def test_the_reference_warns_that_limits_are_not_a_safety_device() -> None:
    assert "not a safety device" in sheet.CY545.notes["limits"] and "cut the power" in sheet.CY545.notes["limits"]
