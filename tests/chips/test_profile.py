"""The law of motion as pure functions: plans against a step-by-step reckoning, for any parameters."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slewline.chips.cy525 import profile
from slewline.chips.cy525.sheet import STEP_TICKS, STEPS_PER_SECOND
from slewline.core.motion.train import OPEN
from slewline.errors import SlewlineError

rates, slopes, divisors = st.integers(0, 127), st.integers(0, 255), st.integers(0, 255)
numbers = st.one_of(st.integers(1, 700), st.integers(1, 65_535))
LAW = profile.Law(452, jumps=False)
LAWS = (LAW, profile.Law(479, jumps=False), profile.Law(452, jumps=True), profile.Law(1, True), profile.Law(65535))
thorough = settings(max_examples=150)


def spread(runs: profile.Runs) -> list[int]:
    return [interval for interval, count in runs for _ in range(count)]


def one_by_one(low: int, high: int, slope: int, divisor: int, most: int, law: profile.Law = LAW) -> list[int]:
    """The way up, a step at a time, at most so many: of the units that are due, a step takes one, or all."""
    unit = (divisor or 256) * (256 - slope) * law.unit
    steps, elapsed, rate = [], 0, low
    while len(steps) < most and rate < high:
        steps.append(round(11_000_000 / STEPS_PER_SECOND[rate]))
        elapsed += steps[-1]
        while rate < high and elapsed >= (rate + 1 - low) * unit:
            rate += 1
            if not law.jumps:
                break
    return steps


@pytest.mark.fact("RATE-1")
def test_the_clocks_of_a_step_are_rounded_to_the_nearest() -> None:
    for ticks, rate in zip(STEP_TICKS, STEPS_PER_SECOND, strict=True):
        assert abs(ticks * rate - 11_000_000) * 2 <= rate


@pytest.mark.fact("UND-RAMP-LAW", "UND-S0", "UND-Z0")
def test_a_unit_scales_with_slope_and_divisor() -> None:
    assert profile.unit_ticks(255, 1) == 452 == round(11_000_000 * 9375 / (22988 * 80 * 124))
    assert profile.unit_ticks(100, 3) == 3 * 156 * 452
    assert profile.unit_ticks(0, 1) == 256 * 452
    assert profile.unit_ticks(1, 0) == 256 * 255 * 452
    assert profile.unit_ticks(1, 0, profile.Law(479)) == 256 * 255 * 479


@pytest.mark.fact("UND-RAMP-LAW", "RAMP-1")
@thorough
@given(rates, rates, slopes, divisors, st.sampled_from(LAWS))
def test_a_ramp_equals_the_calculation_step_by_step(
    low: int, high: int, slope: int, divisor: int, law: profile.Law
) -> None:
    runs = profile.ramp(low, high, slope, divisor, law)
    assert spread(profile.head(runs, 3000)) == one_by_one(low, high, slope, divisor, 3000, law)
    assert bool(runs) == (low < high)
    if runs:
        intervals = [interval for interval, _ in runs]
        assert intervals == sorted(set(intervals), reverse=True)  # never slower, never the same rate twice
        assert STEP_TICKS[high] < intervals[-1] and intervals[0] == STEP_TICKS[low]
        if not law.jumps:
            assert intervals == list(STEP_TICKS[low:high])  # one run at each rate
        # no step is made at R before R is due; the last step is the first at whose end it is, or has its rate to itself
        units, time = (high - low) * profile.unit_ticks(slope, divisor, law), sum(i * n for i, n in runs)
        assert units <= time
        assert time - intervals[-1] < units or runs[-1][1] == 1


@pytest.mark.fact("RAMP-6")
@thorough
@given(rates, rates, rates, slopes, divisors)
def test_a_lower_maximum_is_the_same_curve_cut_short(low: int, one: int, two: int, slope: int, divisor: int) -> None:
    shorter, longer = sorted((profile.ramp(low, high, slope, divisor) for high in (one, two)), key=profile.steps)
    assert profile.head(longer, profile.steps(shorter)) == shorter


@pytest.mark.fact("RAMP-2", "RAMP-9", "RAMP-10", "RAMP-14", "UND-SHORT-NORAMP", "UND-R-BELOW-F")
@thorough
@given(numbers, rates, rates, slopes, divisors)
def test_a_move_has_equal_ramps_and_slews_256_steps_or_none(
    number: int, first: int, rate: int, slope: int, divisor: int
) -> None:
    plan = profile.move(number, first, rate, slope, divisor)
    legs = {leg.name: spread(leg.runs) for leg in plan.legs}
    assert list(legs) == [name for name in ("up", "slew", "down", "crawl") if name in legs]
    up = one_by_one(first, rate, slope, divisor, number // 2 + 1)
    enough = 2 * len(up) <= number  # else it turns in the middle
    up = up if enough else up[: number // 2]
    rest = number - 2 * len(up)
    assert legs.get("up", []) == up and legs.get("down", []) == up[::-1]
    slews = legs.get("slew", [])
    assert slews == ([STEP_TICKS[max(first, rate)]] * rest if rest >= 256 else [])
    assert legs.get("crawl", []) == [STEP_TICKS[first]] * (rest - len(slews))
    assert enough or (rest < 2 and not slews)
    assert sum(map(len, legs.values())) == plan.steps == number


@thorough
@given(st.integers(3, 100), st.integers(1, 27), slopes, st.data())
def test_head_and_tail_put_together_are_the_whole(first: int, more: int, slope: int, data: st.DataObject) -> None:
    runs = profile.ramp(first, first + more, slope, 3)
    count = data.draw(st.integers(0, profile.steps(runs)))
    head, tail = profile.head(runs, count), profile.tail(runs, count)
    assert spread(head) + spread(tail) == spread(runs)
    assert profile.steps(head) == count
    assert spread(profile.mirrored(runs)) == spread(runs)[::-1]


@thorough
@given(numbers, rates, rates, slopes, st.data())
def test_the_rate_of_a_step_is_that_of_its_interval(
    number: int, first: int, rate: int, slope: int, data: st.DataObject
) -> None:
    plan = profile.move(number, first, rate, slope, 1)
    step = data.draw(st.integers(0, number - 1))
    before = profile.steps(profile.head(plan.runs, step))
    interval = profile.tail(plan.runs, before)[0][0]
    assert STEP_TICKS[profile.rate(plan, step)] == interval


@pytest.mark.fact("CONT-1")
def test_a_steady_plan_has_no_end() -> None:
    plan = profile.steady(80, ("up", profile.ramp(3, 80, 200, 1)))
    assert [leg.name for leg in plan.legs] == ["up", "slew"]
    assert plan.legs[1].runs == ((1840, OPEN),)
    assert [leg.name for leg in profile.steady(80).legs] == ["slew"]


def test_an_inconsistent_plan_is_refused() -> None:
    good = profile.plan(("up", ((2000, 3),)), ("slew", ((1137, 300),)))
    assert good.verified(303) is good
    for wrong in (302, 304):
        with pytest.raises(SlewlineError, match=r"takes 303 steps instead of"):
            good.verified(wrong)
    too_fast = profile.plan(("slew", ((1136, 300),)))
    hole = profile.Plan((profile.Leg("up", ((2000, 3),), 1, 3),))
    miscounted = profile.Plan((profile.Leg("up", ((2000, 3),), 0, 4),))
    for bad in (too_fast, hole, miscounted):
        with pytest.raises(SlewlineError, match="is inconsistent"):
            bad.verified()
