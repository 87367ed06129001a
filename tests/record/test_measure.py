"""Measurements: exact numbers from small arrays and from trains."""

from __future__ import annotations

import numpy as np
import pytest

from slewline.core.motion.train import StepTrain
from slewline.core.time.timebase import Clock
from slewline.errors import UsageError
from slewline.record.measuring.measure import MeasuredRamp, glitches, intervals, pulse_widths, ramp, rates, runs


def at(*times: int):
    return np.array(times, np.int64)


def levels(*values: int):
    return np.array(values, np.int8)


def test_intervals_and_rates():
    assert intervals(at(5, 7, 12)).tolist() == [2, 5]
    assert rates(at(0, 10**9, 3 * 10**9)).tolist() == [1000.0, 500.0]
    for few in (at(), at(5)):
        assert intervals(few).tolist() == []
        assert rates(few).tolist() == []


def test_instants_must_ascend():
    with pytest.raises(UsageError, match="number 2 is not later than"):
        rates(at(1, 5, 5, 9))


def test_runs_of_a_train_with_a_fractional_period_in_picoseconds():
    train = StepTrain(Clock(11_000_000), 3, [(137, 400), (100, 300), (137, 2)])
    first, count = runs(train.times(1, train.steps))
    assert first.tolist() == [0, 400, 700]
    assert count.tolist() == [400, 300, 1]
    for few in (at(), at(5)):
        assert [column.tolist() for column in runs(few)] == [[], []]


def test_pulse_widths_are_those_of_whole_pulses():
    times, after = at(1, 4, 10, 12, 13), levels(0, 1, 0, 1, 0)
    assert pulse_widths(times, after).tolist() == [3, 2]
    assert pulse_widths(times, after, 1).tolist() == [6, 1]
    assert pulse_widths(at(), levels()).tolist() == []


def test_floating_is_not_a_pulse():
    assert pulse_widths(at(1, 4, 10), levels(0, -1, 1)).tolist() == [3]


def test_glitches_are_shorter_than_requested():
    assert glitches(at(1, 4, 10, 12, 13), 3).tolist() == [2, 3]
    assert glitches(at(1, 4, 10, 12, 13), 4).tolist() == [0, 2, 3]
    assert glitches(at(3), 9).tolist() == []


def test_ramp_of_a_move():
    train = StepTrain(Clock(10**12), 7, [(50, 2), (40, 3), (20, 10), (40, 3), (50, 2)])
    assert ramp(train.times(1, train.steps)) == MeasuredRamp(
        up_ps=220, plateau_ps=200, down_ps=170, plateau_first=5, plateau_steps=10, peak_sps=5e10
    )


def test_plateau_is_the_longest_stretch_at_the_top():
    measured = ramp(StepTrain(Clock(10**12), 0, [(50, 2), (20, 3), (30, 1), (20, 9), (50, 3)]).times(1, 18))
    assert (measured.plateau_first, measured.plateau_steps, measured.up_ps) == (6, 9, 190)


def test_ramp_of_sampled_instants():
    """Rounded down to 1 us, one rate has intervals of 167 and of 168 us; told so, it is one plateau all the same."""
    rounded = 10**6 * np.cumsum([0, 400, 300, *[167, 167, 168] * 20, 200])
    assert ramp(rounded, rounding_ps=10**6) == MeasuredRamp(
        up_ps=700_000_000,
        plateau_ps=20 * 502_000_000,
        down_ps=200_000_000,
        plateau_first=2,
        plateau_steps=60,
        peak_sps=10**12 * 60 / (20 * 502_000_000),
    )
    assert ramp(rounded).plateau_steps == 2


def test_ramp_needs_steps():
    with pytest.raises(UsageError, match="at least two steps; found 1"):
        ramp(at(5))
