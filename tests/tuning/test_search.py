"""The search: equal to the minimum of all, in fewer runs, whoever computes, whatever arrives first."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from itertools import pairwise
from multiprocessing import get_context
from random import Random
from threading import Event
from time import sleep
from typing import Any

import pytest

from slewline.chips import ramps_of
from slewline.errors import UsageError
from slewline.tuning.candidates import Candidates
from slewline.tuning.executors import INLINE, Workers, processes
from slewline.tuning.judging import Trial, Verdict
from slewline.tuning.search import WORST
from slewline.tuning.task import NothingHolds, Tuned, TuningTask
from slewline.tuning.tune_ramp import perform, tune
from tests.ensembles import few, in_long_runs

from .stand_in import DRIVER, GRIDS, SISTERS, candidates, hits, task


def search(made: TuningTask, workers: Workers = INLINE, **how: Any) -> Tuned:
    """Perform a task with the judge without physics."""
    return perform(made, ramps_of(made.part), workers, judge=how.pop("judge", hits), **how)


def exhausted(made: TuningTask) -> tuple[Candidates, dict[int, float | None]]:
    """All candidates of a task, each with its worst lag under all scenarios, or None if it is lost under one."""
    every = candidates(made)
    found: dict[int, float | None] = {}
    for place in every.order:
        verdicts = [hits(Trial(every.times(place), scenario)) for scenario in made.scenarios()]
        found[place] = None if any(each.lost for each in verdicts) else max(each.worst for each in verdicts)
    return every, found


def by_hand(made: TuningTask) -> tuple[int, int | None]:
    """The fastest place that holds, and the recommended one, from the exhaustive map."""
    every, worst = exhausted(made)
    holds = [place for place in every.order if worst[place] is not None]
    good = [
        place
        for place in holds
        if (worst[place] or 0.0) <= WORST and all(worst[each] is not None for each in every.neighbours(place))
    ]
    return holds[0], good[0] if good else None


def marked(part: str) -> Any:
    """Return a part as a parameter: two quick ones in every run."""
    if part in SISTERS:
        return in_long_runs(part)
    return part if part in ("cy500", "mc1151a") else pytest.param(part, marks=pytest.mark.system)


@pytest.mark.parametrize("part", [*map(marked, GRIDS)])
def test_best_and_recommended_are_those_of_the_exhaustive_map(part: str) -> None:
    made = task(part)
    best, recommended = by_hand(made)
    found = search(made, switching=False)
    assert found.best is not None and found.best.values == made.grid.at(best)
    assert (found.recommended and found.recommended.values) == (
        None if recommended is None else made.grid.at(recommended)
    )
    assert found.runs == found.runs_here < found.exhaustive / 5


def test_the_region_has_holes_and_bisection_fails() -> None:
    made = task("gs-c200s", "S=10 T=150 R=1..800/60")
    every, worst = exhausted(made)
    holds = [worst[place] is not None for place in every.order]  # the fastest first
    low, high = 0, len(holds) - 1  # bisection: the fast end fails, the slow one holds
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds[middle] else (middle, high)
    assert sum(a != b for a, b in pairwise(holds)) > 3
    best = search(made, switching=False).best
    assert best is not None and best.values == every.values(every.order[holds.index(True)])


def test_the_map_has_every_place_with_its_killer() -> None:
    made = task("cy525")
    every, worst = exhausted(made)
    found = search(made, full_map=True, switching=False)
    assert len(found.map) == made.grid.size
    nominal = [each for each in made.scenarios() if each.nominal]
    for place, row in enumerate(found.map):
        assert row.values == made.grid.at(place) and row.time_ps == every.time_ps[place]
        fails = any(hits(Trial(every.times(place), each)).lost for each in nominal)
        assert row.says == ("holds" if worst[place] is not None else "fails nominally" if fails else "fails")
        assert (row.killer is None) == (row.says == "holds")
        if row.says == "holds":
            assert row.worst == worst[place]
        else:
            (killer,) = (each for each in made.scenarios() if each.name == row.killer)
            assert hits(Trial(every.times(place), killer)).lost
    alone = search(made, switching=False)
    assert (found.best, found.recommended) == (alone.best, alone.recommended)


def test_the_scenario_that_has_killed_most_is_tried_first() -> None:
    def only_one_kills(run: Trial) -> Verdict:
        lost = run.scenario.name == "drag -30 %, backward" and run.times[-1] < 0.7e12
        return Verdict(lost, 0.0, 1.0)

    made = task("gs-c200s")
    found = search(made, judge=only_one_kills, switching=False)
    assert found.best is not None and found.best.time_ps > 0.7e12
    (killed,) = found.killers.values()
    first = 2 * len(made.scenarios())  # the first two candidates meet it last, since nothing was known when they began
    assert killed > 50 and found.runs < first + killed + 9 * len(made.scenarios())


def test_moves_of_the_same_steps_are_judged_once() -> None:
    found = search(task("cy525", "F=3 R=30..60 S=1,2", steps=50), full_map=True, switching=False)
    assert found.candidates == 62 and found.exhaustive == 62 * 20
    judged: list[tuple[int, str]] = []

    def noted(run: Trial) -> Verdict:
        judged.append((hash(run.times.tobytes()), run.scenario.name))
        return hits(run)

    search(task("cy525", "F=3 R=30..60 S=1,2", steps=50), judge=noted, full_map=True, switching=False)
    assert len(judged) == len(set(judged)) < 62 * 20 / 10


# ------------------------------------------------------------------------------------------------------- executors
class Shuffled(Executor):
    """Computes what it has at random, much later than it was asked."""

    def __init__(self, seed: int, longest_s: float = 0.0005) -> None:
        self.random, self.longest_s = Random(seed), longest_s

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self.random.random()

        def work(pause: float = self.random.random() * self.longest_s) -> None:
            sleep(pause)
            if future.set_running_or_notify_cancel():
                future.set_result(fn(*args, **kwargs))

        ThreadPoolExecutor(1).submit(work)
        return future


@contextmanager
def threads() -> Iterator[Workers]:
    with ThreadPoolExecutor(4) as pool:
        yield Workers(pool, 16, "")


@contextmanager
def spawned() -> Iterator[Workers]:
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        yield Workers(pool, 4, "")


@contextmanager
def shuffled() -> Iterator[Workers]:
    yield Workers(Shuffled(7), 9, "")


@pytest.mark.parametrize("full_map", few([True, False], 1))
@pytest.mark.parametrize("begun", [threads, shuffled, pytest.param(spawned, marks=pytest.mark.system)])
def test_the_result_does_not_depend_on_the_computing_process(
    begun: Callable[[], AbstractContextManager[Workers]], full_map: bool
) -> None:
    made = task("mc1151a")
    with begun() as workers:
        alone, together = (search(made, each, full_map=full_map) for each in (INLINE, workers))
    assert replace(together, runs_here=0) == replace(alone, runs_here=0)
    assert together.best is not None and together.runs_here >= together.runs


def test_no_run_that_was_judged_ahead_is_judged_again() -> None:
    judged: list[str] = []

    def noted(run: Trial) -> Verdict:
        judged.append(run.scenario.name)
        return Verdict(False, 0.0, 1.0)

    workers = Workers(Shuffled(7, 0.02), 9, "")
    search(task("gs-c200s", "S=10 T=300 R=400"), workers, judge=noted, switching=False)
    assert len(judged) == len(set(judged)) == 20


class Held(ThreadPoolExecutor):
    """One thread, which does the first runs, and the others when six are in flight or after 5 s."""

    def __init__(self) -> None:
        super().__init__(1)
        self.futures: list[Future[Any]] = []
        self.most, self.six = 0, Event()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        held = len(self.futures) > 8

        def work() -> Verdict:
            if held:
                self.six.wait(5)
                self.six.set()
            return hits(*args)

        self.futures.append(super().submit(work))
        flying = sum(not each.done() for each in self.futures)
        self.most = max(self.most, flying)
        if flying == 6:
            self.six.set()
        return self.futures[-1]


@pytest.mark.parametrize(
    ("grid", "perturb"),
    [("S=10 T=100..400/12 R=20,40", "none"), pytest.param("S=10 T=300 R=400", None, id="one candidate, judged ahead")],
)
def test_an_executor_has_two_runs_in_flight_for_each_processor(
    monkeypatch: pytest.MonkeyPatch, grid: str, perturb: str | None
) -> None:
    monkeypatch.setattr("slewline.tuning.tune_ramp.cpu_count", lambda: 3)
    with Held() as pool:
        tune(
            "gs-c200s", motor="QSH4218-51-10-049", driver="24 V, 1 A averaged", load="friction 5 mNm", steps=200,
            grid=grid, full_map=True, executor=pool, **({"perturb": perturb} if perturb else {}),
        )  # fmt: skip
    assert pool.most == 6


def dies(run: Trial) -> Verdict:
    """End the process."""
    os._exit(3)


@pytest.mark.system
def test_a_process_that_dies_is_reported() -> None:
    with processes(2) as workers, pytest.raises(UsageError, match="a process of the pool has died; try fewer jobs"):
        search(task(), workers, judge=dies)


def test_an_error_of_the_judge_is_its_own() -> None:
    def broken(run: Trial) -> Verdict:
        raise ZeroDivisionError("a mistake in the law")

    with pytest.raises(ZeroDivisionError, match="a mistake in the law"):
        search(task(), judge=broken)


# ------------------------------------------------------------------------------------------------ switching, no move
def test_the_recommended_move_is_judged_with_the_switching_chopper_too() -> None:
    made = task("gs-c200s")
    fast = search(made, switching=False).recommended
    assert fast is not None

    def rings(run: Trial) -> Verdict:
        found = hits(run)
        rings = run.scenario.driver.kind == "chopper" and run.times[-1] < 1.01 * fast.time_ps
        return replace(found, lost=found.lost or rings)

    averaged, switched, ringing = (
        search(made, judge=judge, switching=switching)
        for judge, switching in ((hits, False), (hits, True), (rings, True))
    )
    assert averaged.recommended == switched.recommended and switched.switched and not averaged.switched
    assert switched.runs > averaged.runs
    assert ringing.best == averaged.best and ringing.recommended is not None and averaged.recommended is not None
    assert ringing.recommended.time_ps > averaged.recommended.time_ps
    names = [each.name for each in made.switching()]
    assert all(name.endswith(", switching") for name in names)
    assert {each.step_ps for each in made.switching()} == {1_000_000}
    assert replace(made, driver=replace(DRIVER, kind="current")).switching() == ()


def line(places: int, judge: Callable[[int, Trial], Verdict]) -> Tuned:
    """Search a grid of one parameter; the judge sees the rank of a move, the fastest first."""
    made = task("gs-c200s", f"S=10 T=150..{149 + places} R=20")
    every = candidates(made)
    ranks = {int(every.times(place)[-1]): rank for rank, place in enumerate(every.order)}
    return search(made, judge=lambda run: judge(ranks[int(run.times[-1])], run))


def rank(found: Tuned) -> int | None:
    """Which of the fastest is recommended."""
    return None if found.recommended is None else found.task.grid.values[1][::-1].index(found.recommended.values["T"])


def test_the_lag_of_the_recommended_move_is_at_most_1_8_steps() -> None:
    assert rank(line(8, lambda rank, _: Verdict(False, 0.0, 1.83 - rank / 100))) == 3
    assert rank(line(8, lambda rank, _: Verdict(False, 0.0, 1.9))) is None


def test_the_neighbours_hold_with_the_switching_chopper_too() -> None:
    def rings(rank: int, run: Trial) -> Verdict:
        return Verdict(run.scenario.driver.kind == "chopper" and rank in (3, 4), 0.0, 1.0)

    assert rank(line(9, rings)) == 0  # 1 is its only neighbour
    assert rank(line(9, lambda rank, run: rings(rank + 2, run))) == 4  # 1 and 2 ring: 0 and 3 are next to them


def test_where_nothing_holds_the_killer_of_the_slowest_is_named() -> None:
    made = task("cy525", "F=30..40 by 5 R=60..80 by 10 S=200..254 by 20")
    with pytest.raises(
        NothingHolds, match=r"none of 27 moves holds; the slowest, F=30 R=70 S=200 Z=1, loses steps under '.*'; try"
    ):
        search(made)
    found = search(made, full_map=True)
    assert found.best is None and found.recommended is None and len(found.map) == 27
    with pytest.raises(UsageError, match="no move of the grid passes all scenarios"):
        _ = found.chosen


def test_a_part_that_refuses_every_move_is_reported() -> None:
    with pytest.raises(
        UsageError,
        match=r"none of the 2 grid points gives a valid move; error at the first: .*a move of 99999999 steps; allowed",
    ):
        search(task("cy525", "F=3 R=10,20 S=100", steps=99999999))


def test_progress_counts_down_to_the_best() -> None:
    seen: list[Any] = []
    found = search(task("gs-c200s"), on_progress=seen.append, switching=False)
    assert {each.doing for each in seen} == {"listing the moves", "the fastest that holds", "the recommended one"}
    best = [each for each in seen if each.doing == "the fastest that holds"]
    assert [each.left for each in best[:-1]] == [found.candidates - n - 1 for n in range(len(best) - 1)]
    assert best[-1].left == 0 and best[-1].best is not None and best[0].best is None
