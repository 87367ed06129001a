"""What a part keeps of its past, and the quantities that it makes of it: exact at every instant, and in pictures."""

from __future__ import annotations

from itertools import pairwise
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slewline.core.motion.history import History, Polyline, Staircase
from slewline.core.time.kernel import Kernel
from slewline.errors import TimeError, UsageError

MS = 10**9


@pytest.fixture
def kernel():
    kernel = Kernel()
    kernel.run(100 * MS)
    return kernel


# ------------------------------------------------------------------------------------------------------------- history
@pytest.mark.parametrize("many", [False, True])
def test_an_endless_history_keeps_the_latest_values_and_reports_the_lost_ones(many, monkeypatch, kernel):
    monkeypatch.setattr("slewline.core.motion.history.KEPT", 10)
    history = History(0)
    for n in range(1, 1000):
        if many:
            history.note_many(np.array([n * MS // 10]), np.array([float(n)]))
        else:
            history.note(n * MS // 10, n)
        assert len(history) <= 20
    assert history.at(MS) != history.at(MS) and np.isnan(history.values_at(np.array([MS]))).all()
    assert [history.at(n * MS // 10) for n in range(990, 1000)] == [*range(990, 1000)]
    oldest = next(iter(history))[0]
    quantity = history.quantity(kernel, "count", "counts")
    times, values = quantity.changes(0, 100 * MS)
    assert np.isnan(values[0]) and times[1] == oldest and not np.isnan(values[1:]).any()
    times, values = quantity.outline(0, 100 * MS, 2)
    assert np.isnan(values[0]) and times[1] == oldest and values[-1] == 999


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 3))), st.integers(-1, 60), st.integers(0, 60))
def test_a_history_holds_each_value_until_the_next_one(came, start, long):
    history, now, known = History(7), 0, {0: 7.0}
    for later, value in came:
        now += later
        history.note(now, value)
        known[now] = float(value)
    levels = [known[max(at for at in known if at <= ps)] for ps in range(now + 61)]
    asked = np.array(Random(1).sample(range(now + 61), now + 61))
    assert history.values_at(asked).tolist() == [levels[ps] for ps in asked]
    assert [history.at(ps) for ps in range(now + 61)] == levels and history.last == levels[-1]
    times, values = history.changes(start, start + long)
    wanted = [ps for ps in range(1, now + 61) if start < ps <= start + long and levels[ps] != levels[ps - 1]]
    assert [ps for ps in times.tolist() if ps] == wanted and values[times > 0].tolist() == [levels[ps] for ps in wanted]


def test_many_are_noted_as_one_by_one():
    one, many = History(), History()
    for ps, value in ((3, 1), (5, 2), (9, 1)):
        one.note(ps, value)
    many.note_many(np.array([3, 5, 9]), np.array([1, 2, 1]))
    for history in (one, many):
        history.note(12, 4)
    assert [column.tolist() for column in many.changes(0, 20)] == [column.tolist() for column in one.changes(0, 20)]
    assert many.changes(0, 20)[0].tolist() == [3, 5, 9, 12]


def test_forgetting_leaves_the_value_at_that_time():
    history = History()
    for ps in range(1, 10):
        history.note(ps, ps)
    history.forget(5)
    assert [history.at(ps) for ps in (5, 6, 9)] == [5, 6, 9]
    assert history.changes(0, 20)[0].tolist() == [5, 6, 7, 8, 9]
    history.forget(4)
    assert history.at(5) == 5


# ----------------------------------------------------------------------------------------------------------- quantities
def counter(kernel, every=MS // 1000, turn=60 * MS):
    """A count that rises every microsecond, and falls from an instant on."""

    def values(times):
        return np.where(times < turn, times // every, 2 * (turn // every) - times // every).astype(float)

    def changes(start, stop):
        times = np.arange(start // every + 1, stop // every + 1) * every
        return times, values(times)

    return values, changes, lambda start, stop: [turn] * (start <= turn <= stop)


def test_a_quantity_answers_to_times_as_people_write_them(kernel):
    quantity = Staircase(kernel, "count", "counts", *counter(kernel)[:2])
    assert quantity.at("3 ms") == 3000.0 and isinstance(quantity.at(3 * MS), float)
    assert quantity.at(["3 ms", 0, "70 ms"]).tolist() == [3000, 0, 50_000]
    assert quantity.at(np.array([[1, 2], [MS, 0]])).tolist() == [[0, 0], [1000, 0]]
    with pytest.raises(UsageError, match=r"count: 100\.001 ms is in the future; the time is 100 ms"):
        quantity.at(["1 ms", "100.001 ms"])
    with pytest.raises(TimeError, match="float"):
        quantity.at(0.5)


def test_a_long_count_is_drawn_from_few_of_its_changes_and_looks_the_same(kernel):
    values, changes, turns = counter(kernel)
    asked = []

    def counted(start, stop):
        asked.append((start, stop))
        return changes(start, stop)

    plain = Staircase(kernel, "count", "counts", values, changes)
    few = Staircase(kernel, "count", "counts", values, counted, turns=turns)
    for start, stop in ((0, 100 * MS), (3 * MS + 1, 61 * MS), (60 * MS, 90 * MS)):
        outline, exact = few.outline(start, stop, 100), plain.outline(start, stop, 100)
        assert asked == [] and len(outline.times_ps) <= 400
        edges = [start + (stop - start) * column // 100 for column in range(101)]
        for begin, end in pairwise(edges):
            shown = [o.values[(begin <= o.times_ps) & (o.times_ps < end)] for o in (outline, exact)]
            assert (shown[0].min(), shown[0].max()) == (shown[1].min(), shown[1].max())
    assert few.outline(0, MS // 100, 100).times_ps.tolist() == plain.outline(0, MS // 100, 100).times_ps.tolist()
    assert asked == [(0, MS // 100)]


def ramp(kernel):
    """A line that rises by 1 a millisecond, and by 2 from 10 ms on; points at 10 ms and every 25 ms."""

    def values(times):
        return np.where(times < 10 * MS, times / MS, times / MS * 2 - 10)

    def changes(start, stop):
        times = np.array([ps * MS for ps in (10, 25, 50, 75, 100) if start < ps * MS <= stop], np.int64)
        return times, values(times)

    return Polyline(kernel, "angle", "rad", values, changes)


def test_lines_end_where_the_window_ends(kernel):
    angle = ramp(kernel)
    assert not angle.is_staircase
    assert [c.tolist() for c in angle.changes(5 * MS, 30 * MS)] == [
        [5 * MS, 10 * MS, 25 * MS, 30 * MS],
        [5, 10, 40, 50],
    ]
    assert [c.tolist() for c in angle.changes(5 * MS, 25 * MS)] == [[5 * MS, 10 * MS, 25 * MS], [5, 10, 40]]
    assert angle.at("30 ms") == 50


def test_in_a_waveform_file_a_line_is_the_same_stairs_for_every_window(kernel):
    angle = ramp(kernel)
    assert [c.tolist() for c in angle.staircase(30 * MS, 80 * MS)] == [[30 * MS, 50 * MS, 75 * MS], [40, 90, 140]]
    assert [angle.staircase(ps * MS, ps * MS).values.tolist() for ps in (0, 9, 10, 24, 99)] == [
        [0],
        [0],
        [10],
        [10],
        [140],
    ]
