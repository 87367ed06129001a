"""Two traces side by side: what a proof compares, and what it lets pass."""

from __future__ import annotations

from dataclasses import replace

from slewline.translation.proof.compare_runs import Compared, StatedBounds, compared
from slewline.translation.target_writer import Happened, PlayedTrace

MS = 10**9
BOUNDS = StatedBounds(time=0.0, rate=0.01, top=2000.0, pause=0.1, command_ps=5 * MS, hosted=0, long=100)
MOVE = Happened("move", 1, 500, 0, 600 * MS, 1000.0, 2 * MS)
HIGH = Happened("output", 1, 1, 700 * MS)
NEXT = replace(MOVE, time_ps=1000 * MS, first_ps=1002 * MS)


def found(*result: Happened, bounds: StatedBounds = BOUNDS) -> Compared:
    """The result of a comparison with a move, an output and a move."""
    return compared(PlayedTrace("one", (MOVE, HIGH, NEXT)), PlayedTrace("two", result), bounds)


def later(each: Happened, ms: int) -> Happened:
    """The same thing, later."""
    first = None if each.first_ps is None else each.first_ps + ms * MS
    return replace(each, time_ps=(each.time_ps or 0) + ms * MS, first_ps=first)


def test_pauses_are_those_from_the_last_step_to_a_change_and_to_the_next_first_step() -> None:
    assert found(MOVE, HIGH, NEXT).pause_off_ps == 0
    assert found(MOVE, later(HIGH, 3), later(NEXT, 3)).pause_off_ps == 3 * MS
    assert found(MOVE, HIGH, later(NEXT, 37)).proven  # a tenth of 302 ms, a hundredth, and 5 ms for commands
    (says,) = found(MOVE, HIGH, later(NEXT, 40)).differences
    assert says == "302 ms before +500 steps at 1 s, in the result 342 ms"


def test_pauses_of_a_host_are_its_own() -> None:
    assert found(MOVE, HIGH, later(NEXT, 500), bounds=replace(BOUNDS, hosted=2)).proven
    assert found(MOVE, HIGH, later(NEXT, 500), bounds=replace(BOUNDS, hosted=None)).proven
    assert not found(MOVE, HIGH, later(NEXT, 500), bounds=replace(BOUNDS, hosted=1)).proven


def test_one_pause_for_each_run_but_the_first_is_that_of_the_host() -> None:
    assert found(MOVE, HIGH, later(NEXT, 500), bounds=replace(BOUNDS, runs=2)).proven
    assert not found(MOVE, later(HIGH, 300), later(NEXT, 900), bounds=replace(BOUNDS, runs=2)).proven


def test_delays_read_back_become_pauses() -> None:
    moves = [replace(each, time_ps=None, first_ps=None, lasts_ps=None) for each in (MOVE, HIGH, NEXT)]
    waits = [Happened("delay", 1, 98 * MS), Happened("delay", 1, 200 * MS), Happened("delay", 1, 102 * MS)]
    assert found(moves[0], waits[0], moves[1], *waits[1:], moves[2]).proven
    assert not found(moves[0], waits[0], moves[1], waits[1], moves[2]).proven


def test_the_rate_of_a_long_move_is_compared_and_of_a_short_one_only_its_bound() -> None:
    assert found(MOVE, HIGH, replace(NEXT, rate=1025.0)).proven
    (says,) = found(MOVE, HIGH, replace(NEXT, rate=900.0)).differences
    assert says == "+500 steps at 1 s: 1000 steps/s, in the result 900"
    assert found(MOVE, HIGH, replace(NEXT, rate=900.0), bounds=replace(BOUNDS, long=500)).proven
    assert not found(MOVE, HIGH, replace(NEXT, rate=2100.0), bounds=replace(BOUNDS, long=500)).proven
