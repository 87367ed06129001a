"""Clock edges against the list of edges that the promise itself gives: by arithmetic, and walked along."""

from __future__ import annotations

from bisect import bisect_right
from random import Random

import pytest
from promises import Asked, Early

from slewline.chips.mc1451a.profiles.cycle_train import CycleTrain, Linear, SquareView
from slewline.core.motion.step_views import PulseView, StrobeView
from slewline.core.motion.train import OPEN, Playing, StepTrain
from slewline.core.time.events import Even, NoEvents, NotYet, Since
from slewline.core.time.timebase import Clock
from slewline.core.wires import clocking
from slewline.core.wires.clocking import WalkedEdges, clock_edges
from slewline.core.wires.views import Bounded, Repeated
from slewline.core.wires.wave import Wave
from tests.ensembles import few

END = 1 << 50


def step_view(random: Random):
    runs = [(random.randrange(5, 30), random.choice([0, 1, 2, 3, 9])) for _ in range(random.randrange(0, 20))]
    train = StepTrain(Clock(random.choice([11_000_000, 3_579_545])), random.choice([0, 7, 10**6]), runs)
    view = random.choice([PulseView, StrobeView])
    return view(Playing(train), 3)


def square_view(random: Random):
    speed, lead = random.randrange(1, 5000), random.randrange(-40_000, 40_000)
    train = CycleTrain(Clock(25_000_000), random.randrange(10**6), Linear(speed, random.randrange(9)), 300, lead)
    return SquareView(Playing(train), random.random() < 0.5)


def wave(random: Random):
    times = tuple(sorted(random.sample(range(1, 10**9), 9)))
    return Wave(1, times, tuple(random.choice([0, 1, None]) for _ in times))


def edges_to(promise, level: int, since: int, stop: int) -> list[int]:
    """The real edges to a level, from the promise's own list."""
    times, levels = promise.edges(since, stop)
    before, found = promise.level(since), []
    for time, now in zip(list(times), list(levels), strict=True):
        if now == level and now != before:
            found.append(int(time))
        before = now
    return found


def bounded(promise, random: Random, last: int) -> None:
    if random.random() < 0.5:
        until = random.randrange(1, last + 2)
        if isinstance(promise, Wave):
            promise.until = until
        else:
            promise.of.until = until


@pytest.mark.parametrize("kind", [step_view, square_view, wave])
@pytest.mark.parametrize("how", ["itself", "walked", "walked early"])
@pytest.mark.parametrize("seeds", few((range(5), range(5, 125)), 1), ids=len)
def test_edges_are_counted_found_and_listed_as_the_promise_shows_them(kind, how, seeds, monkeypatch):
    monkeypatch.setattr(clocking, "BLOCK", 8)
    monkeypatch.setattr(clocking, "FIRST_PS", 2_000_000)
    for seed in seeds:
        random = Random(seed)
        promise, level = kind(random), random.randrange(2)
        last = max([int(ps) for ps in promise.edges(0, END)[0]], default=0)
        bounded(promise, random, last)
        since = random.choice([0, random.randrange(last + 1)])
        edges = edges_to(promise, level, since, END)
        shown = Early(promise, 1_500_000) if how == "walked early" else promise
        clock = clock_edges(shown, level, since) if how == "itself" else WalkedEdges(shown, level, since)
        asked = [random.randrange(since, last + 10**6) for _ in range(20)] + [e + d for e in edges for d in (-1, 0)]
        if random.random() < 0.5:
            asked.sort()
        for ps in asked:
            k = clock.count(ps)
            assert k == bisect_right(edges, ps)
            time = clock.time(k + 1)
            if isinstance(time, NotYet):
                assert kind is wave or how != "itself"  # a train knows
                assert ps < time.at < (edges[k] if k < len(edges) else END) and clock.count(time.at) <= k
            else:
                assert time == (edges[k] if k < len(edges) else None)
            if k:
                a = random.randrange(1, k + 1)
                assert clock.times(a, k).tolist() == edges[a - 1 : k]
                assert clock.few([*range(a, k + 1, 2)]) == edges[a - 1 : k : 2]


def test_an_endless_train_is_walked_with_a_bounded_memory(monkeypatch):
    monkeypatch.setattr(clocking, "BLOCK", 64)
    promise = StrobeView(Playing(StepTrain(Clock(1_000_000), 0, [(10, OPEN)])), 3)
    clock = WalkedEdges(promise, 0, 0)
    step = 10_000_000
    assert clock.count(100_000 * step) == 100_000
    assert len(clock._starts) < 100_000 / 32 and len(clock._cached[-1]) < 1000
    assert clock.times(500, 503).tolist() == [n * step for n in range(500, 504)]
    assert clock.time(70_001) == 70_001 * step and clock.count(70_001 * step - 1) == 70_000


def test_a_query_about_the_future_looks_ahead_to_its_time_and_no_further():
    promise = Asked(Wave(1, tuple(range(5, 5005, 5)), (None, 1) * 500))  # no fall at all
    clock = WalkedEdges(promise, 0, 0)
    assert clock.time(1) == NotYet(5 * clocking.LOOKS) and clock.count(5 * clocking.LOOKS) == 0
    assert promise.asked <= 2 * clocking.LOOKS
    early = WalkedEdges(Early(promise, 2), 0, 0)
    assert early.time(1) == NotYet(2)  # who has looked ahead enough is not asked again


def test_trains_answer_by_arithmetic_and_levels_stay():
    assert isinstance(clock_edges(step_view(Random(1)), 1, 0), Since)
    assert isinstance(clock_edges(square_view(Random(1)), 1, 0), Since)
    for level in (0, 1, None):
        still = clock_edges(level, 0, 0)
        assert (
            isinstance(still, NoEvents)
            and still.count(END) == 0
            and still.time(1) is None
            and not len(still.times(1, 0))
        )


def test_an_even_clock_begins_a_period_after_its_instant():
    even = Even(500, 1000)
    assert [even.count(500), even.count(500 + 10**9 - 1), even.count(500 + 10**9), even.time(2)] == [
        0,
        0,
        1,
        500 + 2 * 10**9,
    ]
    assert even.times(1, 2).tolist() == [500 + 10**9, 500 + 2 * 10**9]


def test_a_bound_that_moves_ends_a_clock():
    frozen = Repeated(Wave(1, (), ()))
    clock = Bounded(Even(0, 1000), frozen)
    assert clock.count(10**10) == 10 and clock.time(3) == 3 * 10**9
    frozen.until = 3 * 10**9
    assert clock.count(10**10) == 2 and clock.time(3) is None and clock.time(2) == 2 * 10**9
