"""Step trains against a list of begins: every question, every window, every clock."""

from __future__ import annotations

from bisect import bisect_right
from itertools import pairwise
from random import Random
from weakref import ref

import numpy as np
import pytest
from promises import bounds, check_promise

from slewline.core.motion.step_views import PatternView, PulseView, StrobeView
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.timebase import Clock
from tests.ensembles import few
from tests.rows import rows

CRYSTALS = [11_000_000, 3_579_545, 10_999_999, 1_000_000]
HIGH = 3


def random_train(random: Random, hz: int) -> tuple[StepTrain, list[int]]:
    """A train, and the ticks of its begins with the end of the last step behind them."""
    runs = [(random.randrange(5, 30), random.choice([0, 1, 2, 3, 9])) for _ in range(random.randrange(0, 20))]
    origin = random.choice([0, 1, 7, 10**6, 10**12 + 3])
    begins, tick = [], origin
    for interval, count in runs:
        for _ in range(count):
            begins.append(tick)
            tick += interval
    return StepTrain(Clock(hz), origin, runs), [*begins, tick]


def trains(hz: int, number: int = 40):
    random = Random(hz)
    for _ in range(number):
        yield random, *random_train(random, hz)


@rows("hz", CRYSTALS)
def test_begins_and_intervals_are_those_of_the_list(hz):
    for _, train, ticks in trains(hz):
        assert train.steps == len(ticks) - 1
        assert train.length == ticks[-1] - train.origin
        assert [train.end(k) for k in range(len(ticks))] == ticks
        assert train.end(len(ticks) + 5) == ticks[-1]
        assert [train.interval(k) for k in range(train.steps)] == np.diff(ticks).tolist()


@rows("hz", CRYSTALS)
def test_steps_begun_are_counted_at_every_tick_and_every_picosecond_around_it(hz):
    for random, train, ticks in trains(hz):
        clock, begins = train.clock, ticks[:-1]
        for tick in range(ticks[0] - 3, ticks[-1] + 40):
            assert train.step_at(tick) == bisect_right(begins, tick)
        instants = [clock.ps(tick) for tick in begins]
        asked = [ps + d for ps in instants for d in (-1, 0, 1)] + [
            random.randrange(clock.ps(ticks[-1]) + 10**6) for _ in range(30)
        ]
        expected = [bisect_right(instants, ps) for ps in asked]
        assert [train.count(ps) for ps in asked] == expected
        if train.steps:
            random.shuffle(asked)  # any order
            assert train.count_many(np.array(asked, np.int64)).tolist() == [bisect_right(instants, ps) for ps in asked]


@rows("hz", [*CRYSTALS, 999_983, 7_919_999])
def test_steps_begun_after_a_hundred_days_are_exact(hz):
    clock = Clock(hz)
    origin = 9 * 10**6 * hz + 12_347  # 104 days
    train = StepTrain(clock, origin, ((17, 1000), (11, 960), (1_000_003, 40)))  # the last ones span seconds
    begins = [clock.ps(train.end(k)) for k in range(2000)]
    asked = np.array([ps + d for ps in begins for d in (-1, 0, 1)], np.int64)
    assert train.count_many(asked).tolist() == [train.count(int(ps)) for ps in asked]
    assert train.count_many(asked)[1::3].tolist() == list(range(1, 2001))
    assert train.times(1, train.steps).tolist() == begins


@pytest.mark.parametrize("hz", CRYSTALS)
@pytest.mark.parametrize("number", few((4, 8), 1))
def test_every_window_of_begins_is_a_slice_of_the_list(hz, number):
    for _, train, ticks in trains(hz, number):
        begins = [train.clock.ps(tick) for tick in ticks[:-1]]
        for first in range(train.steps + 2):
            for last in [None, *range(train.steps + 3)]:
                assert train.times(first + 1, last).tolist() == begins[first:last]
                assert train.ends(first, last).tolist() == [tick - train.origin for tick in ticks[:-1][first:last]]


def test_windows_of_long_runs_are_slices_of_the_list():
    train = StepTrain(Clock(11_000_000), 5, tuple((100 + n, 7000) for n in range(12)))
    whole = np.cumsum(np.repeat(np.arange(100, 112), 7000)) + 0
    whole = np.concatenate([[0], whole[:-1]])
    random = Random(3)
    for _ in range(50):
        first, last = sorted(random.sample(range(84_001), 2))
        assert np.array_equal(train.ends(first, last), whole[first:last])


def test_an_empty_train_has_no_steps_and_ends_where_it_begins():
    train = StepTrain(Clock(11_000_000), 50, ())
    assert (train.steps, train.end(0), train.length) == (0, 50, 0)
    assert train.times(1, train.steps).tolist() == []


def test_an_endless_run_is_queried_in_any_window():
    clock = Clock(11_000_000)
    train = StepTrain(clock, 100, ((50, 3), (20, OPEN)))
    assert train.steps == OPEN + 3
    assert train.end(10**12) == 250 + 20 * (10**12 - 3)
    assert train.step_at(250 + 20 * 10**12) == 10**12 + 4
    assert train.interval(10**15) == 20
    begins = train.times(10**11 + 1, 10**11 + 4)
    assert begins.tolist() == [clock.ps(250 + 20 * (10**11 - 3 + n)) for n in range(4)]
    asked = begins.repeat(2)
    asked[::2] -= 1
    assert train.count_many(asked).tolist() == [10**11 + n for n in (0, 1, 1, 2, 2, 3, 3, 4)]


# -------------------------------------------------------------------------------------------------------------- views


some = pytest.mark.parametrize("number", few((3, 7), 1))


def small_trains(number=7):
    """Short trains of a clock of one picosecond, and of one that does not divide it."""
    random = Random(17)
    for hz in (10**12, 7 * 10**10):
        for _ in range(number):
            runs = [(random.randrange(5, 12), random.choice([0, 1, 2, 4])) for _ in range(random.randrange(1, 5))]
            train = StepTrain(Clock(hz), random.choice([2, 9]), runs)
            yield random, train, [train.end(k) for k in range(train.steps + 1)]


@some
def test_pulse_is_low_from_the_start_of_a_step_to_shortly_before_its_end(number):
    for random, train, ticks in small_trains(number):
        clock = train.clock
        lows = [(clock.ps(a), clock.ps(b - HIGH)) for a, b in pairwise(ticks)]
        for until in bounds(random, ticks, clock):
            view = PulseView(Playing(train, until), HIGH)
            last = clock.ps(ticks[-1]) + 5
            check_promise(view, 0, last, lambda ps, lows=lows: 0 if any(a <= ps < b for a, b in lows) else 1, until)


@some
def test_a_strobe_is_low_at_the_start_of_each_step(number):
    for random, train, ticks in small_trains(number):
        clock = train.clock
        lows = [(clock.ps(a), clock.ps(a + HIGH)) for a in ticks[:-1]]
        for until in bounds(random, ticks, clock):
            view = StrobeView(Playing(train, until), HIGH)
            last = clock.ps(ticks[-1]) + 5
            check_promise(view, 0, last, lambda ps, lows=lows: 0 if any(a <= ps < b for a, b in lows) else 1, until)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("levels", few([(0, 1, 1, 0), (1, 1, 0, 0), (0, 0, 0, 1), (1, 1, 1, 1)], 2))
@some
def test_a_phase_follows_its_table_step_by_step(levels, sign, number):
    for random, train, ticks in small_trains(number):
        clock = train.clock
        begins = [clock.ps(tick) for tick in ticks[:-1]]
        index, before = random.randrange(4), random.randrange(2)
        for until in bounds(random, ticks, clock):
            view = PatternView(Playing(train, until), levels, index, sign, before)

            def plain(ps, begins=begins, index=index, before=before):
                begun = bisect_right(begins, ps)
                return levels[(index + sign * begun) % 4] if begun else before

            check_promise(view, 0, clock.ps(ticks[-1]) + 5, plain, until)


def test_a_played_train_counts_steps_up_to_its_bound_and_no_further():
    for random, train, ticks in small_trains():
        if not train.steps:
            continue
        clock = train.clock
        begins = [clock.ps(tick) for tick in ticks[:-1]]
        for until in bounds(random, ticks, clock):
            playing = Playing(train, until)
            instants = list(range(0, clock.ps(ticks[-1]) + 5))
            expected = [bisect_right([ps for ps in begins if until is None or ps < until], ps) for ps in instants]
            assert [playing.count(ps) for ps in instants] == expected
            assert playing.count_many(np.array(instants, np.int64)).tolist() == expected


def test_a_train_keeps_no_more_than_the_window_that_its_views_share():
    train = StepTrain(Clock(1_000_000), 0, [(10, 1000)])
    asked = ref(train.times(1, 1000))
    assert asked() is None  # a train of the past that had kept it would take 8 bytes a step
    shared = train.window(1, 1000)
    assert train.window(1, 1000) is shared and not shared.flags.writeable
