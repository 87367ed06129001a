"""The law of motion as pure functions: plans against the rate at each step, for any parameters."""

from __future__ import annotations

import pytest
from gsc import gaps, spacing
from hypothesis import given
from hypothesis import strategies as st

from slewline.chips.gs_c200 import profile
from slewline.core.motion.plan import Plan, Runs
from slewline.core.motion.train import OPEN
from slewline.core.time.timebase import PS_PER_S
from slewline.errors import UsageError

speeds, lengths = st.integers(1, 1000), st.integers(1, 999)
numbers = st.one_of(st.integers(1, 2500), st.integers(1, 9_999_999))


def spread(runs: Runs) -> list[int]:
    return [interval for interval, count in runs for _ in range(count)]


def legs(plan: Plan) -> list[tuple[str, int]]:
    return [(leg.name, leg.count) for leg in plan.legs]


@pytest.mark.fact("GSC-SPEED-1", "GSC-CON-SPEED-GRID")
@pytest.mark.parametrize(("speed", "interval"), [(1, 10**11), (3, 33_333_333_333), (37, 2_702_702_703), (1000, 10**8)])
def test_a_period_is_rounded_to_the_nearest_picosecond(speed: int, interval: int) -> None:
    assert profile.period(speed) == interval
    assert all(
        abs(profile.period(any_speed) * 10 * any_speed - PS_PER_S) <= 5 * any_speed for any_speed in range(1, 1001)
    )


@pytest.mark.fact("GSC-RAMP-1", "GSC-RAMP-2", "GSC-RAMP-3", "GSC-RAMP-4", "GSC-RAMP-6", "GSC-UND-SHORT-ODD")
@given(st.integers(1, 2500), speeds, speeds, lengths)
def test_a_move_equals_the_calculation_step_by_step(number: int, start: int, top: int, length: int) -> None:
    assert spread(profile.move(number, start, top, length).runs) == spacing(number, start, top, length)


@pytest.mark.fact("GSC-RAMP-1", "GSC-RAMP-3", "GSC-RAMP-4", "GSC-RAMP-6", "GSC-UND-SINGLE", "GSC-UND-RAMP-COUNT")
@given(numbers, speeds, speeds, lengths)
def test_a_move_has_two_equal_ramps_and_slews_between_or_has_none(
    number: int, start: int, top: int, length: int
) -> None:
    found = legs(profile.move(number, start, top, length))
    if top <= start or number == 1:
        assert found == [("slew", number)]
    elif number > 2 * length + 1:
        assert found == [("up", length), ("slew", number - 2 * length - 1), ("down", length + 1)]
    else:
        assert found == [("up", number // 2), ("down", number - number // 2)]


@pytest.mark.fact("GSC-RAMP-2", "GSC-UND-RAMP-LAW")
@pytest.mark.parametrize("law", profile.LAWS.values())
@given(speeds, speeds, lengths)
def test_a_ramp_goes_from_the_start_stop_rate_towards_the_slew_rate_and_never_back(
    law: profile.Law, start: int, top: int, length: int
) -> None:
    intervals = spread(profile.ramp(start, top, length, law))
    assert len(intervals) == (length if top > start else 0)
    if intervals:
        assert intervals[0] == profile.period(start)
        assert min(intervals) >= profile.period(top)
        assert all(gap <= 0 for gap in gaps(intervals))


@pytest.mark.fact("GSC-UND-RAMP-LAW")
def test_the_laws_differ_between_the_ends_of_a_ramp() -> None:
    squares, line = profile.LAWS["constant acceleration"], profile.LAWS["linear in steps"]
    assert [round(squares(100, 1000, 50, k), 1) for k in range(6)] == [100.0, 172.6, 222.7, 263.4, 298.7, 330.2]
    assert [line(100, 1000, 50, k) for k in (0, 1, 25, 50)] == [100, 118, 550, 1000]


@pytest.mark.fact("GSC-UND-RAMP-LAW")
@pytest.mark.parametrize(
    ("law", "says"),
    [
        (lambda start, top, ramp, k: top + 1, r"1001 steps/s at step 1 of 10; allowed 100\.\.1000"),
        (lambda start, top, ramp, k: start - 1, r"99 steps/s at step 1 of 10; allowed 100\.\.1000"),
        (lambda start, top, ramp, k: 200 + 50 * (k % 5), "step 5 of 10 is slower than the step before"),
    ],
)
def test_a_law_that_leaves_its_range_or_turns_back_is_refused(law: profile.Law, says: str) -> None:
    with pytest.raises(UsageError, match=f"ramp law: {says}"):
        profile.ramp(10, 100, 10, law)


@pytest.mark.fact("GSC-RAMP-7")
@given(st.integers(0, 3000), speeds, speeds, lengths)
def test_a_stopped_motion_decelerates_as_it_accelerated(step: int, start: int, top: int, length: int) -> None:
    run = profile.endless(start, top, length)
    assert run.steps >= OPEN
    rest = spread(profile.stopped(run, step).runs)
    up = spread(profile.ramp(start, top, length))
    if not up or step == 0:
        assert rest == []
    else:
        gone = (up + [profile.period(top)] * step)[:step]
        whole = gone + rest[:-1]
        assert whole == whole[::-1]
        assert len(rest) == min(step, length + 1) and rest[-1] == up[0]


@pytest.mark.fact("GSC-RAMP-7")
@given(st.integers(1, 3000), speeds, speeds, lengths, st.data())
def test_a_move_that_is_stopped_never_goes_further(
    number: int, start: int, top: int, length: int, data: st.DataObject
) -> None:
    move = profile.move(number, start, top, length)
    step = data.draw(st.integers(0, number - 1))
    rest = profile.stopped(move, step)
    assert rest.steps <= number - step
    assert spread(move.runs)[:step] + spread(rest.runs) == spacing(step + rest.steps, start, top, length)


@pytest.mark.fact("GSC-POS-7", "GSC-UND-E5")
@given(st.integers(1, 3000), st.integers(0, 3000), speeds, speeds, lengths)
def test_the_end_of_the_counter_cuts_a_run_and_its_stop_ramp(
    limit: int, step: int, start: int, top: int, length: int
) -> None:
    run = profile.endless(start, top, length, limit=limit)
    assert run.steps == limit
    assert spread(run.runs) == (spread(profile.ramp(start, top, length)) + [profile.period(top)] * limit)[:limit]
    step = min(step, limit - 1)
    rest = profile.stopped(run, step)
    assert spread(profile.within(rest, limit - step).runs) == spread(rest.runs)[: limit - step]
