"""The ramp calculator of the CY525: what it says is what the pins do, and what it finds is the best there is."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from random import Random
from typing import Any

import numpy as np
import pytest

import slewline
from slewline.errors import UsageError
from tests.ensembles import few

Make = Callable[..., Any]
Period = Callable[[int], int]  # clocks of a step at a rate
PS_PER_S = 10**12

MOVES = [  # F, R, S, Z, steps, crystal
    (3, 127, 200, 1, 5000, "11 MHz"),
    (3, 127, 254, 1, 60_000, "11 MHz"),
    (3, 80, 100, 1, 20_000, "11 MHz"),
    (10, 100, 240, 1, 2000, "6 MHz"),
    (3, 40, 250, 7, 3000, "11 MHz"),
    (20, 60, 1, 1, 700, "11 MHz"),  # too short for its rate
    (3, 100, 254, 1, 5, "11 MHz"),
    (60, 61, 255, 3, 300, "4 MHz"),
    (50, 50, 200, 1, 300, "11 MHz"),  # no ramp
    (80, 20, 200, 1, 100, "11 MHz"),  # no ramp, and too short to slew
]


def asked(first: int, rate: int, slope: int, divisor: int, crystal: str) -> Any:
    return slewline.ramp("cy525", F=first, R=rate, S=slope, Z=divisor, crystal=crystal)


@pytest.mark.parametrize("move", MOVES)
def test_every_step_of_a_move_comes_at_its_calculated_time(mover: Make, move: tuple[int, ...]) -> None:
    first, rate, slope, divisor, number, crystal = move
    x = mover(position=0, crystal=crystal)
    x.send(f"N {number}\rF {first}\rR {rate}\rS {slope}\rZ {divisor}\r")
    x.begin()
    x.finish()
    ps, begins, ends = x.x.clock.ps, x.begins(), [clock for clock, level in x.changes("motion_complete") if level == 0]
    ramp = asked(first, rate, slope, divisor, crystal)
    told = ramp.move(number)
    assert told.times().tolist() == [ps(begin) for begin in begins]
    assert told.time_ps == ps(ends[-1])
    slews = [clock for clock, level in x.changes("slew") if level == 0]
    assert dict(told.legs).get("slew", 0) > 0 if slews else "slew" not in dict(told.legs)
    assert told.reached == (ramp.reached_from <= number) == (bool(slews) or rate <= first)
    if slews and first < rate:
        assert ramp.time_ps == ps(slews[0])
        assert ramp.steps == sum(begin < slews[0] for begin in begins)
        periods = x.periods()
        shown = [(row.begin_ps, row.position, row.steps, row.rate) for row in ramp.table()]
        assert [position for _, position, _, _ in shown] == np.cumsum([0, *(row[2] for row in shown[:-1])]).tolist()
        for begin, position, steps, each in shown:
            assert begin == ps(begins[position])
            assert {x.x.crystal_hz / period for period in periods[position : position + steps]} == {each}
        assert sum(steps for _, _, steps, _ in shown) == ramp.steps


@pytest.mark.parametrize("move", [(3, 60, 250, 1), (10, 40, 200, 1), (30, 127, 255, 2)])
def test_the_shortest_move_that_reaches_its_rate_slews_and_one_step_less_does_not(
    mover: Make, move: tuple[int, int, int, int]
) -> None:
    shortest = asked(*move, "11 MHz").reached_from
    for number, slews in ((shortest, 1), (shortest - 1, 0)):
        x = mover(position=0)
        x.send("N {}\rF {}\rR {}\rS {}\rZ {}\r".format(number, *move))
        x.begin()
        x.finish()
        assert [level for _, level in x.changes("slew")].count(0) == slews


@pytest.mark.parametrize("options", [{"ramp_unit": 479}, {"ramp_jumps": True}, {"ramp_unit": 1000, "ramp_jumps": True}])
def test_the_options_of_the_chip_change_its_ramps_and_their_description(mover: Make, options: dict[str, int]) -> None:
    x = mover(position=0, **options)
    x.send("N 3000\rF 3\rR 80\rS 240\rZ 1\r")
    x.begin()
    x.finish()
    told = slewline.ramp("cy525", F=3, R=80, S=240, Z=1, **options)
    assert told.time_ps == x.x.clock.ps(next(clock for clock, level in x.changes("slew") if level == 0))
    assert told.move(3000).times().tolist() == [x.x.clock.ps(begin) for begin in x.begins()]
    found = slewline.find_ramps("cy525", F=3, R=80, time=told.time_ps, Z=1, **options)[0]
    assert (found.values["S"], found.time_ps) == (240, told.time_ps)


def test_a_ramp_that_leaves_no_room_to_slew_in_any_move_is_reported() -> None:
    ramp = asked(3, 127, 1, 200, "11 MHz")
    assert ramp.steps > 32_768
    assert ramp.reached_from is None
    assert not ramp.move(65_535).reached


@pytest.mark.parametrize(("slope", "ms"), [
    (1, 1299), (2, 1294), (10, 1254), (25, 1177), (50, 1050), (100, 795), (150, 540), (200, 285), (225, 158),
])  # fmt: skip
def test_the_times_equal_those_computed_by_the_manual(slope: int, ms: int) -> None:
    assert round(asked(3, 127, slope, 1, "11 MHz").time_ps / 1e9) == ms


def test_the_mean_acceleration_is_what_the_rate_gains_over_the_time_of_the_ramp() -> None:
    ramp = asked(3, 127, 100, 1, "11 MHz")
    first, mean, greatest = ramp.accelerations
    assert mean == ramp.acceleration == pytest.approx((ramp.top - ramp.start) / (ramp.time_ps / PS_PER_S))
    assert 0 < first < greatest and mean < greatest
    assert [round(rate) for rate in (ramp.start, ramp.top)] == [300, 9675]


@pytest.mark.parametrize(("rate", "crystal", "parameter"), [
    ("4000 steps/s", "11 MHz", 40), ("4050 steps/s", "11 MHz", 41), ("6000 steps/s", "11 MHz", 80),
    ("9999 steps/s", "11 MHz", 127), ("4000 steps/s", "5.5 MHz", 111), ("1.2e3 steps/s", "11 MHz", 12),
])  # fmt: skip
def test_a_rate_may_be_given_in_steps_per_second(rate: str, crystal: str, parameter: int) -> None:
    ramp = slewline.ramp("cy525", F=3, R=rate, S=200, crystal=crystal)
    assert {name: ramp.values[name] for name in "FRSZ"} == {"F": 3, "R": parameter, "S": 200, "Z": 1}


@pytest.mark.parametrize("rate", ["30000 steps/s", "20 steps/s", "-300 steps/s"])
def test_a_rate_far_from_all_of_the_table_is_refused(rate: str) -> None:
    with pytest.raises(UsageError, match=r"allowed 275\.\.9675 steps/s"):
        slewline.ramp("cy525", F=3, R=rate, S=200)


# ---------------------------------------------------------------------------------------------------------- backwards
def every_ramp(period: Period, first: int, rate: int, slopes: range, divisors: range) -> tuple[np.ndarray, ...]:
    """Clocks and steps of all ramps, rate by rate for all S and Z at once: at most one unit a step, due times kept."""
    divisor, slope = (each.ravel() for each in np.meshgrid(divisors, slopes, indexing="ij"))
    unit = divisor * (256 - slope) * 452
    clocks, steps = np.zeros(len(unit), np.int64), np.zeros(len(unit), np.int64)
    for number, parameter in zip(count(1), range(first, rate)):
        more = np.maximum(1, -(-(number * unit - clocks) // period(parameter)))
        clocks, steps = clocks + more * period(parameter), steps + more
    return slope, divisor, clocks, steps


def best_of_all(
    period: Period, first: int, rate: int, goal: str, value: float, fixed: dict[str, int]
) -> list[tuple[int, int]]:
    """S and Z of the five nearest, the slower of two first; of those with the same the slowest, least Z, least S."""
    ranges = [range(fixed[name], fixed[name] + 1) if name in fixed else range(1, 256) for name in "SZ"]
    slope, divisor, clocks, steps = every_ramp(period, first, rate, *ranges)
    times = np.array([each * PS_PER_S // 11_000_000 for each in clocks.tolist()])
    gain = 11e6 / period(rate) - 11e6 / period(first)
    has = {"time": times, "steps": steps, "acceleration": gain * PS_PER_S / times}[goal]
    order = np.lexsort((slope, divisor, -times, np.abs(has - value)))
    found: dict[float, tuple[int, int]] = {}
    for each in order.tolist():
        found.setdefault(has[each], (int(slope[each]), int(divisor[each])))
        if len(found) == 5:
            break
    return list(found.values())


def cases() -> list[tuple[int, int, str, float, dict[str, int]]]:
    chance = Random(525)
    found: list[tuple[int, int, str, float, dict[str, int]]] = []
    for number in range(24):
        first = chance.randint(3, 60)
        rate = chance.randint(first + 1, 127)
        goal = ("time", "steps", "acceleration")[number % 3]
        value = {
            "time": 10 ** chance.uniform(9, 13) // 1,
            "steps": chance.randint(5, 20_000),
            "acceleration": round(10 ** chance.uniform(2, 5.5)),
        }[goal]
        fixed = ({}, {}, {}, {}, {"Z": chance.randint(1, 9)}, {"S": chance.randint(1, 255)})[number % 6]
        found.append((first, rate, goal, value, fixed))
    edges = [
        (3, 127, "time", 5e11, {}),
        (3, 127, "time", 4.4e10, {}),  # most steps take longer than their unit
        (3, 127, "steps", 135, {}),
        (3, 127, "acceleration", 215_000, {}),
        (3, 4, "steps", 2, {}),
        (3, 127, "time", 9e15, {}),  # longer than any
        (3, 127, "time", 1000, {}),  # shorter than any
    ]
    return [*found, *edges]


@pytest.mark.parametrize("case", few(cases(), 8))
def test_the_search_finds_the_best_of_all_s_and_z(
    mover: Make, case: tuple[int, int, str, float, dict[str, int]]
) -> None:
    first, rate, goal, value, fixed = case
    wanted = {goal: int(value) if goal == "time" else value}
    found = slewline.find_ramps("cy525", F=first, R=rate, **wanted, **fixed)
    best = best_of_all(mover.period, first, rate, goal, value, fixed)  # type: ignore[attr-defined]
    assert [(ramp.values["S"], ramp.values["Z"]) for ramp in found] == best
    (only,) = slewline.find_ramps("cy525", F=first, R=rate, count=1, **wanted, **fixed)
    assert (only.values["S"], only.values["Z"]) == best[0]


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5))
def test_the_best_s_and_z_are_found_for_any_rates(mover: Make, seed: int) -> None:
    chance = Random(seed)
    for _ in range(60):
        first = chance.randint(3, 126)
        rate = chance.randint(first + 1, min(127, first + chance.choice((3, 30, 127))))
        for goal, value in (
            ("time", int(10 ** chance.uniform(9, 13))),
            ("steps", chance.randint(1, 20_000)),
            ("acceleration", round(10 ** chance.uniform(2, 6))),
        ):
            found = slewline.find_ramps("cy525", F=first, R=rate, **{goal: value})
            best = best_of_all(mover.period, first, rate, goal, value, {})  # type: ignore[attr-defined]
            assert [(ramp.values["S"], ramp.values["Z"]) for ramp in found] == best, (first, rate, goal, value)


def test_without_a_free_parameter_there_is_nothing_to_look_for() -> None:
    with pytest.raises(UsageError, match="cy525: every parameter is given; leave out S or Z"):
        slewline.find_ramps("cy525", time="1 s", F=3, R=100, S=1, Z=1)
