"""The ramps of the CY525 through the pins: the manual's tables, and every step to the clock.

The expected steps come from Mover.way_up, which adds up a ramp step by step; another law is an option of the part.
Clocks count 1/11 us at 11 MHz.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from random import Random
from statistics import mean
from typing import Any

import pytest

import slewline
from tests.ensembles import few

Make = Callable[..., Any]

# S: (computed ms, measured ms, computed steps/s^2), the table of section 8
SLOPES = {
    1: (1299, 1350, 7211),
    2: (1294, 1350, 7240),
    10: (1254, 1250, 7475),
    25: (1177, 1200, 7961),
    50: (1050, 1050, 8927),
    100: (795, 800, 11788),
    150: (540, 550, 17349),
    200: (285, 270, 32840),
    225: (158, 150, 59323),
    250: (30, 38, 306506),
}
TABLE_RISE = 9675 - 300  # steps/s from F 3 to R 127
PER_MS = 11_000


def moved(x: Any, number: int, first: int, rate: int, slope: int, divisor: int = 1) -> list[int]:
    """Play a whole move; the clocks of its steps."""
    x.send(f"N {number}\rF {first}\rR {rate}\rS {slope}\rZ {divisor}\r")
    x.begin()
    x.finish()
    return x.periods()  # type: ignore[no-any-return]


def ramp_clocks(x: Any, first: int, rate: int, slope: int, divisor: int = 1) -> int:
    """Clocks from the first fall of PULSE to the fall of SLEW."""
    moved(x, 65_535, first, rate, slope, divisor)
    return next(clock for clock, level in x.changes("slew") if level == 0)


def law(x: Any, number: int, first: int, rate: int, slope: int, divisor: int = 1) -> list[int]:
    """What the chip should do, step by step."""
    up = x.way_up(first, rate, slope, divisor, number // 2 + 1)
    if 2 * len(up) > number:
        up = up[: number // 2]
    rest = number - 2 * len(up)
    top = x.period(max(first, rate))
    return [*up, *([top] * rest if rest >= 256 else ()), *up[::-1], *([x.period(first)] * rest if rest < 256 else ())]


@pytest.mark.fact("RAMP-1", "RAMP-2", "RAMP-14", "SLEW-1", "ABORT-1")
def test_a_normal_move_climbs_slews_and_comes_down_on_its_target(mover: Make) -> None:
    x = mover(position=0)
    periods = moved(x, 20_000, 3, 80, 100)
    up = x.way_up(3, 80, 100)
    assert periods == up + [1840] * (20_000 - 2 * len(up)) + up[::-1]
    assert periods[0] == periods[-1] == 36_667  # 3333 us
    assert x.changes("slew") == [(sum(up), 0), (sum(periods[: -len(up)]), 1)]
    tail = next(n for n, period in enumerate(reversed(periods)) if period != 36_667)
    assert 1 <= tail <= 20
    assert x.x.position == 20_000


@pytest.mark.fact("RAMP-3", "RAMP-4", "CON-RAMP-TABLE", "CON-D-SLOPE", "UND-RAMP-LAW")
def test_ramp_times_from_3_to_127_are_the_computed_column_and_near_the_measured_one(mover: Make) -> None:
    x = mover()
    first = x.period(3) / PER_MS
    off, off_curve = {}, {}
    for slope, (computed, measured, _) in SLOPES.items():
        clocks = ramp_clocks(x, 3, 127, slope)
        assert clocks == sum(x.way_up(3, 127, slope))
        took = clocks / PER_MS
        if slope < 250:
            assert abs(took - computed) < 1
        off[slope] = abs(took / measured - 1)
        off_curve[slope] = abs((took - first) / measured - 1)  # a curve of velocity begins where the first step ends
    assert max(off.values()) == off[250] < 0.106 and mean(off.values()) < 0.035, off
    assert max(off_curve.values()) < 0.045 and mean(off_curve.values()) < 0.0245, off_curve


@pytest.mark.fact("UND-RAMP-LAW")
@pytest.mark.parametrize(
    ("law", "flattest", "steepest", "off", "worst"),
    [
        ({"ramp_unit": 479}, 1376.9, 42.0, 0.049, 0.108),
        ({"ramp_jumps": True}, 1299.3, 30.6, 0.050, 0.282),
        ({"ramp_unit": 479, "ramp_jumps": True}, 1376.9, 32.4, 0.070, 0.235),
    ],
)
def test_other_laws_are_farther_from_the_measured_column(
    mover: Make, law: dict[str, Any], flattest: float, steepest: float, off: float, worst: float
) -> None:
    x = mover(**law)
    times = {slope: ramp_clocks(x, 3, 127, slope) / PER_MS for slope in SLOPES}
    assert (round(times[1], 1), round(times[250], 1)) == (flattest, steepest)
    curve = [abs((times[slope] - x.period(3) / PER_MS) / SLOPES[slope][1] - 1) for slope in SLOPES]
    assert (round(mean(curve), 3), round(max(curve), 3)) == (off, worst)


@pytest.mark.fact("UND-RAMP-LAW")
@pytest.mark.parametrize("unit", [0, -1, 65_536, 452.0, "452", True])
def test_a_unit_that_is_not_a_number_of_clocks_is_refused(mover: Make, unit: object) -> None:
    with pytest.raises(slewline.UsageError, match=re.escape(f"x: ramp_unit {unit!r}; allowed 1..65535 clocks")):
        mover(ramp_unit=unit)


def test_jumps_are_true_or_false(mover: Make) -> None:
    with pytest.raises(slewline.UsageError, match="x: ramp_jumps 1; allowed True, False"):
        mover(ramp_jumps=1)


@pytest.mark.fact("RAMP-4", "RAMP-15")
def test_the_basic_program_of_the_manual_prints_its_table() -> None:
    def program(d: int, r1: int, r0: int, slopes: list[int]) -> list[tuple[int, int, int]]:
        """Lines 3014 to 3030: INPUT S, A=22988*D/(256-S), PRINT S;INT(A);INT(1000*(R1-R0)/A)."""
        rows = []
        for s in slopes:
            a = 22988 * d / (256 - s)
            rows.append((s, int(a), int(1000 * (r1 - r0) / a)))
        return rows

    assert program(80, 9675, 300, list(SLOPES)) == [(s, row[2], row[0]) for s, row in SLOPES.items()]


@pytest.mark.fact("RAMP-4", "RAMP-5", "CON-D-SLOPE", "CON-S-PRIME", "RAMP-13")
@pytest.mark.parametrize(("unit", "constant"), [(452, 24_336), (479, 22_988)])
@pytest.mark.parametrize(("low", "high"), [(3, 40), (41, 60), (61, 80), (100, 127)])
@pytest.mark.parametrize("slope", few([50, 1, 100], 1))
def test_a_rate_unit_takes_its_time_wherever_it_is_so_the_acceleration_goes_with_its_increment(
    mover: Make, unit: int, constant: int, low: int, high: int, slope: int
) -> None:
    x = mover(ramp_unit=unit)
    rise = x.rate(high) - x.rate(low)
    increment = rise / (high - low)  # D: 100, 56.8, 42.1, 94
    seconds = ramp_clocks(x, low, high, slope) / 11e6
    assert rise / seconds == pytest.approx(constant * increment / (256 - slope), rel=0.01)
    assert seconds == pytest.approx(rise / (constant * 80 / (256 - slope)) * 80 / increment, rel=0.01)


@pytest.mark.fact("RAMP-13")
def test_the_increments_are_100_then_small_and_rise_steadily_from_80_on(mover: Make) -> None:
    steps = {r: mover.rate(r + 1) - mover.rate(r) for r in range(3, 127)}
    assert {steps[r] for r in range(3, 40)} == {100}
    assert all(45 <= steps[r] <= 71 for r in range(41, 60))
    assert min(steps, key=lambda r: steps[r]) == 61 and steps[61] == 36 and steps[126] == 126
    assert all(steps[r] <= steps[r + 1] for r in range(75, 126))


@pytest.mark.fact("RAMP-5")
@pytest.mark.parametrize(("unit", "time"), [(452, 387.8), (479, 411.0)])  # the formula with D = 100: 410.4 ms
def test_the_ramp_to_40_takes_388_ms_and_twice_that_at_half_the_crystal(mover: Make, unit: int, time: float) -> None:
    clocks = []
    for crystal in ("11 MHz", "5.5 MHz"):
        x = mover(crystal=crystal, ramp_unit=unit)
        clocks.append(ramp_clocks(x, 3, 40, 1))
        fall = x.bench.edges("x.slew")[0][0]
        took = (int(fall) - x.x.clock.ps(x.origin)) / 1e9
        assert round(took / (2 if crystal == "5.5 MHz" else 1), 1) == time
    assert clocks[0] == clocks[1]


@pytest.mark.fact("UND-RAMP-LAW", "CON-Z-RANGE")
def test_one_rate_unit_is_a_whole_number_of_clocks(mover: Make) -> None:
    # 9375/(22988*80) s for 124 units are 452.22 clocks a unit; a counter of whole clocks takes the nearest, 452.  The
    # longest unit shows it: with S 1 and Z 255 one clock more or less in it moves the fall of SLEW by 56 steps.
    assert abs(11_000_000 * 9375 / (22988 * 80 * 124) - 452) < 0.5
    x = mover()
    unit = 255 * 255 * 452
    assert ramp_clocks(x, 126, 127, 1, 255) == -(-unit // 1152) * 1152


@pytest.mark.fact("UND-RAMP-LAW")
def test_a_step_takes_one_unit_however_many_are_due(mover: Make) -> None:
    x = mover()
    periods = moved(x, 65_535, 3, 127, 250)  # 13 units are due after the first step
    assert periods[:124] == [x.period(parameter) for parameter in range(3, 127)]
    floor = sum(x.period(parameter) for parameter in range(3, 127))
    assert [ramp_clocks(x, 3, 127, slope) for slope in range(248, 256)] == [floor] * 8
    assert round(floor / PER_MS, 1) == 42.0 and round((floor - x.period(3)) / PER_MS, 1) == 38.7
    assert ramp_clocks(x, 3, 127, 247) > floor
    floor = ramp_clocks(x, 10, 127, 255)
    assert round(floor / PER_MS, 1) == 28.7 and floor == ramp_clocks(x, 10, 127, 251) < ramp_clocks(x, 10, 127, 250)


@pytest.mark.fact("UND-RAMP-LAW")
def test_units_keep_their_times_however_late_one_is_taken(mover: Make) -> None:
    # A unit falls due every 9040 clocks; steps at 300, 400, 500 steps/s (36667, 27500, 22000 clocks) take theirs late.
    # From R 12 on the steps are shorter than a unit, and each is made where the times of the units, not the steps, say.
    x = mover()
    periods = moved(x, 65_535, 3, 127, 236)
    due = next(begin for begin, clocks in zip(x.begins(), periods, strict=False) if clocks == x.period(60))
    assert 0 <= due - 57 * 9040 < x.period(59)
    assert due < sum(max(9040, x.period(parameter)) for parameter in range(3, 60))  # with times that move: later


@pytest.mark.fact("UND-RAMP-LAW", "RAMP-14")
def test_all_due_rate_units_may_be_taken_together_by_option(mover: Make) -> None:
    x = mover(ramp_jumps=True, ramp_unit=479)
    rates = [round(11_000_000 / period) for period in moved(x, 65_535, 3, 127, 250)]
    assert rates[:4] == [300, 1500, 1800, 2000]  # 12, 3 and 2 units of 2874 clocks later
    assert rates[-4:] == [2000, 1800, 1500, 300]


@pytest.mark.fact("UND-RAMP-LAW", "RAMP-10", "RAMP-14")
def test_the_five_steps_of_section_11_are_a_small_ramp(mover: Make) -> None:
    x = mover()
    periods = moved(x, 5, 3, 100, 254)
    assert [round(period / 11) for period in periods] == [3333, 2500, 2500, 3333, 3333]


@pytest.mark.fact("RAMP-6")
def test_the_rate_decides_only_where_on_the_curve_slewing_begins(mover: Make) -> None:
    x = mover()
    low, high = (moved(x, 30_000, 3, rate, 50) for rate in (60, 127))
    up = len(x.way_up(3, 60, 50))
    assert low[:up] == high[:up] and low[-up:] == high[-up:]
    assert high[up + 100] < 2140 == low[up + 100]


@pytest.mark.fact("RAMP-7", "CON-S1-PANEL")
def test_a_larger_slope_is_a_shorter_ramp_down_to_a_step_at_each_rate(mover: Make) -> None:
    x = mover()
    clocks = [ramp_clocks(x, 3, 127, slope) for slope in (0, 1, 2, 50, 100, 150, 200, 240, 247)]
    assert clocks == sorted(set(clocks), reverse=True)
    least = [ramp_clocks(x, 3, 127, slope) for slope in (248, 250, 252, 254, 255)]
    assert set(least) == {sum(x.period(parameter) for parameter in range(3, 127))} and clocks[-1] > least[0]


@pytest.mark.fact("RAMP-8")
def test_the_divisor_stretches_the_ramp(mover: Make) -> None:
    x = mover()
    clocks = {divisor: ramp_clocks(x, 3, 40, 1, divisor) for divisor in (1, 2, 5, 10)}
    for divisor, time in clocks.items():
        assert time == sum(x.way_up(3, 40, 1, divisor))
        assert time == pytest.approx(divisor * clocks[1], rel=0.05)


@pytest.mark.fact("UND-S0")
def test_slope_0_is_a_little_slower_than_slope_1(mover: Make) -> None:
    x = mover()
    assert ramp_clocks(x, 10, 20, 0, 7) == sum(x.way_up(10, 20, 0, 7)) > ramp_clocks(x, 10, 20, 1, 7)
    assert sum("S 0 is outside" in found.text for found in x.x.findings) == 1


@pytest.mark.fact("UND-Z0", "CON-Z-RANGE")
def test_divisor_0_divides_by_256_one_more_than_255(mover: Make) -> None:
    x = mover()
    assert ramp_clocks(x, 10, 20, 250, 0) == sum(x.way_up(10, 20, 250, 256)) > ramp_clocks(x, 10, 20, 250, 255)
    assert sum("Z 0 is outside" in found.text for found in x.x.findings) == 1


@pytest.mark.fact("RAMP-9", "SLEW-6")
@pytest.mark.parametrize("rest", [0, 1, 200, 255])
def test_fewer_than_256_steps_for_slewing_are_made_at_the_first_rate_at_the_end(mover: Make, rest: int) -> None:
    x = mover()
    up = x.way_up(3, 80, 200)
    assert moved(x, 2 * len(up) + rest, 3, 80, 200) == up + up[::-1] + [36_667] * rest
    assert x.changes("slew") == []
    assert 1840 not in x.periods()  # not one step at R


@pytest.mark.fact("RAMP-9")
@pytest.mark.parametrize("rest", [256, 300])
def test_from_256_steps_on_the_chip_slews(mover: Make, rest: int) -> None:
    x = mover()
    up = x.way_up(3, 80, 200)
    assert moved(x, 2 * len(up) + rest, 3, 80, 200) == up + [1840] * rest + up[::-1]
    assert x.changes("slew") == [(sum(up), 0), (sum(up) + rest * 1840, 1)]


@pytest.mark.fact("RAMP-10", "SLEW-6")
@pytest.mark.parametrize("number", [1, 2, 3, 1000, 1001])
def test_a_short_move_turns_in_the_middle_and_ends_at_the_first_rate(mover: Make, number: int) -> None:
    x = mover(position=0)
    periods = moved(x, number, 3, 127, 100)
    up = x.way_up(3, 127, 100)[: number // 2]
    assert periods == up + up[::-1] + [36_667] * (number % 2)
    assert x.changes("slew") == []
    assert x.x.position == number
    if number >= 1000:
        assert 1137 < min(periods) == periods[499] < 36_667


@pytest.mark.fact("RAMP-10", "RAMP-9")
def test_a_move_just_long_enough_reaches_the_last_rate_below_the_maximum(mover: Make) -> None:
    x = mover()
    up = x.way_up(3, 80, 200)
    assert moved(x, 2 * len(up) - 1, 3, 80, 200) == up[:-1] + up[-2::-1] + [36_667]
    assert moved(x, 2 * len(up), 3, 80, 200) == up + up[::-1]


@pytest.mark.fact("RAMP-11", "CON-RAV")
@pytest.mark.parametrize("slope", [1, 50, 100])
def test_steps_in_a_ramp_are_about_the_mean_rate_times_its_time(mover: Make, slope: int) -> None:
    x = mover()
    clocks = ramp_clocks(x, 3, 127, slope)
    up = len([begin for begin in x.begins() if begin < clocks])
    half_the_sum, half_the_difference = ((9675 + sign * 300) / 2 * SLOPES[slope][1] / 1000 for sign in (1, -1))
    assert up == pytest.approx(half_the_sum, rel=0.12)
    assert abs(up - half_the_sum) < abs(up - half_the_difference)


@pytest.mark.fact("RAMP-1", "RAMP-2", "RAMP-9", "RAMP-10", "RAMP-14", "UND-SHORT-NORAMP")
@pytest.mark.parametrize("seed", few(range(60), 12))
def test_any_move_is_the_law_step_by_step(mover: Make, seed: int) -> None:
    chance = Random(seed)
    first = chance.choice([3, 10, 40, 100, chance.randrange(3, 128)])
    rate = min(127, first + chance.choice([0, 1, 5, 30, 127]))
    slope, divisor = chance.choice([255, 250, 200, chance.randrange(1, 256)]), chance.choice([1, 1, 2, 7, 255])
    accelerate = 2 * len(mover.way_up(first, rate, slope, divisor, 1500))
    number = max(1, accelerate + chance.choice([-accelerate // 3, -1, 0, 1, 100, 255, 256, 257, 400]))
    x = mover(position=1000)
    assert moved(x, number, first, rate, slope, divisor) == law(x, number, first, rate, slope, divisor)
    assert x.x.position == 1000 + number
