"""The ramp calculator of the MC1451A family: it says what registers and pins show, and finds the best there is."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np
import pytest
from mc import ONE, PARTS
from mc_motion import mover

import slewline
from slewline.errors import UsageError
from tests.ensembles import few

CYCLE_PS = 327_680_000
PER_S = 25e6 / 8192  # cycles in a second
TRAPEZOIDS = [  # SET_VEL, SET_ACC, SET_START_VEL, steps
    (265_107, 478, 0, 5000),
    (265_107, 478, 100_000, 3000),
    (0x10000, 0x400, 0, 1000),
    (0x10000, 1, 0, 300),  # too short for its velocity
    (40_000, 50_000, 0, 100),  # reached in the first cycle
    (30_000, 7, 40_000, 50),  # no ramp
    (100_001, 333, 5, 1),
    (2_000_000, 9001, 0, 20_000),  # beyond the standard pulse range
]


def asked(velocity: int, acceleration: int, start: int, **more: Any) -> Any:
    return slewline.ramp("mc1451a", SET_VEL=velocity, SET_ACC=acceleration, SET_START_VEL=start, **more)


def compare(ramp: Any, commands: list[str], steps: int, velocity: int) -> list[int]:
    """Make the move, compare what registers and pins show with what the calculator says; returns the velocities."""
    rig = mover("mc1451a")
    cycle = rig.begin(*commands, f"SET_POS {steps}")
    speeds = rig.speeds()
    told = ramp.move(steps)
    begin = rig.at(cycle)
    assert told.times().tolist() == [pulse - begin for pulse in rig.pulses(begin)]
    assert told.time_ps == len(speeds) * CYCLE_PS
    assert told.reached == (max(speeds) == velocity) == (ramp.reached_from <= steps)
    assert told.top == pytest.approx(max(speeds) / ONE * PER_S)
    assert sum(steps for _, steps in told.legs) == steps
    return speeds


@pytest.mark.parametrize("move", TRAPEZOIDS)
def test_every_step_of_a_trapezoid_comes_at_its_calculated_time(move: tuple[int, int, int, int]) -> None:
    velocity, acceleration, start, steps = move
    commands = [f"SET_VEL {velocity}", f"SET_ACC {acceleration}", f"SET_START_VEL {start}"]
    ramp, top = asked(velocity, acceleration, start), min(velocity, 16 * ONE)
    speeds = compare(ramp, commands, steps, top)
    if max(speeds) == top:
        cycles = speeds.index(top)
        assert ramp.time_ps == cycles * CYCLE_PS
        assert ramp.steps == sum(speeds[:cycles]) / ONE
        assert [row.parameter for row in ramp.table()] == speeds[:cycles]
        assert dict(ramp.move(steps).legs).get("slew", 0) == speeds.count(top) * top / ONE


S_CURVES = [  # SET_VEL, SET_MAX_ACC, SET_JERK, steps
    (0x10000, 0x400, 0x200000, 1000),
    (265_107, 478, 100_000, 8000),
    (265_107, 478, 100_000, 2000),  # too short for its velocity
    (100_000, 30_000, 50_000_000, 900),  # does not come to its acceleration
    (33_333, 7, 1_000_000, 2000),
    (40_000, 50, 77, 3),
    (2_000_000, 9001, 3_000_000, 20_000),  # beyond the standard pulse range
]


def curve(velocity: int, acceleration: int, jerk: int, **more: Any) -> Any:
    return slewline.ramp(
        "mc1451a", profile="s-curve", SET_VEL=velocity, SET_MAX_ACC=acceleration, SET_JERK=jerk, **more
    )


def ideal(velocity: float, acceleration: float, jerk: float) -> float:
    """Cycles that the way up of an S-curve takes."""
    jerk /= ONE
    full = velocity * jerk >= acceleration**2
    return velocity / acceleration + acceleration / jerk if full else 2 * (velocity / jerk) ** 0.5


@pytest.mark.parametrize("move", S_CURVES)
def test_every_step_of_an_s_curve_comes_at_its_calculated_time(move: tuple[int, int, int, int]) -> None:
    velocity, acceleration, jerk, steps = move
    ramp, top = curve(velocity, acceleration, jerk), min(velocity, 16 * ONE)
    commands = ["SET_PRFL_S_CRV", f"SET_VEL {velocity}", f"SET_MAX_ACC {acceleration}", f"SET_JERK {jerk}"]
    speeds = compare(ramp, commands, steps, top)
    cycles = ideal(top, acceleration, jerk)
    assert ramp.time_ps == pytest.approx(cycles * CYCLE_PS, abs=1)
    assert ramp.steps == pytest.approx(top * cycles / 2 / ONE, abs=1 / ONE)
    first, mean, greatest = ramp.accelerations
    assert mean == pytest.approx(top / cycles / ONE * PER_S**2)
    assert first <= mean <= greatest <= (acceleration + 1) / ONE * PER_S**2
    if max(speeds) == top:
        assert speeds.index(top) == -(-ramp.time_ps // CYCLE_PS)
        assert [row.parameter for row in ramp.table()] == speeds[: speeds.index(top)]


@pytest.mark.parametrize("move", S_CURVES[:4])
def test_the_shortest_s_curve_that_reaches_its_velocity_is_two_ramps_long(move: tuple[int, int, int, int]) -> None:
    ramp = curve(*move[:3])
    assert ramp.reached_from == -(-2 * ramp.steps // 1)
    assert [ramp.move(ramp.reached_from + more).reached for more in (-1, 0, 1)] == [False, True, True]


def test_an_s_curve_that_needs_more_than_the_longest_move_is_reported() -> None:
    ramp = curve((1 << 30) - 1, 1, 1, output="high")
    assert ramp.reached_from is None
    assert ramp.time_ps == pytest.approx(ideal(512 * ONE, 1, 1) * CYCLE_PS)


def test_the_high_pulse_range_lets_a_ramp_continue() -> None:
    standard, high = (asked(2_000_000, 9001, 0, output=output) for output in ("standard", "high"))
    assert (standard.top, high.top) == (16 * PER_S, 2_000_000 / ONE * PER_S)
    commands = ["SET_OUTPUT_HIGH", "SET_VEL 2000000", "SET_ACC 9001", "SET_START_VEL 0"]
    compare(high, commands, 20_000, 2_000_000)


@pytest.mark.parametrize("move", TRAPEZOIDS[:4])
def test_from_the_shortest_move_that_reaches_its_velocity_on_all_do_and_none_below(move: tuple[int, ...]) -> None:
    ramp = asked(*move[:3])
    shortest = ramp.reached_from
    around = range(max(shortest - 15, 1), shortest + 15)
    assert [ramp.move(steps).reached for steps in around] == [steps >= shortest for steps in around]


def test_a_velocity_that_no_move_reaches_is_reported() -> None:
    ramp = slewline.ramp("mc1451a", SET_VEL=(1 << 30) - 1, SET_ACC=1, output="high")
    assert ramp.reached_from is None
    assert ramp.time_ps == (512 * ONE - 1) * CYCLE_PS


@pytest.mark.parametrize("part", PARTS)
def test_registers_may_be_given_in_steps_and_seconds(part: str) -> None:
    ramp = slewline.ramp(part, SET_VEL="12345 steps/s", SET_ACC="67927.9 steps/s^2")
    assert (ramp.values["SET_VEL"], ramp.values["SET_ACC"]) == (265_107, 478)
    assert slewline.ramp(part, SET_VEL="0.25 steps/cycle", SET_ACC=1).values["SET_VEL"] == 0x4000
    assert ramp.accelerations == pytest.approx((478 / ONE * PER_S**2,) * 3)


@pytest.mark.parametrize(("values", "says"), [
    ({"SET_VEL": 1}, "no value for SET_ACC"),
    ({"SET_VEL": 1, "SET_ACC": 0}, r"SET_ACC 0; allowed 1\.\.1073741823 \(2\^-16 steps/cycle\^2\), or text"),
    ({"SET_ACC": 1}, r"no value for SET_VEL \(maximum velocity, 1\.\.1073741823 \(2\^-16 steps/cycle\)\)"),
    ({"SET_VEL": 1, "SET_ACC": "20 steps/s"}, "acceleration 20 steps/s: allowed steps/s2 or steps/cycle2"),
    ({"SET_VEL": "1 steps/s3", "SET_ACC": 2}, "velocity 1 steps/s3: allowed steps/s or steps/cycle"),
    ({"SET_VEL": 1, "SET_ACC": 1, "SET_JERK": 1}, "SET_JERK applies only to profile s-curve; leave it out, or set"),
    ({"SET_VEL": 1, "profile": "gear"}, "profile 'gear'; allowed trapezoid, s-curve"),
])  # fmt: skip
def test_parameters_unsuited_to_the_profile_are_refused(values: dict[str, Any], says: str) -> None:
    with pytest.raises(UsageError, match=says):
        slewline.ramp("mc1451a", **values)


# ---------------------------------------------------------------------------------------------------------- backwards
def every_trapezoid(velocity: int, start: int) -> tuple[np.ndarray, ...]:
    """Accelerations, and cycles and 1/65536 steps of their ramps, cycle by cycle, for all that do not jump."""
    acceleration = np.arange(1, velocity + 100)
    speed = np.maximum(acceleration, start)
    cycles, travel = np.zeros_like(speed), np.zeros_like(speed)
    up = speed < velocity
    most = -(-(velocity - np.maximum(acceleration, start)) // acceleration)  # cycles at these speeds
    cycles[up] = most[up]
    travel[up] = (cycles * speed + acceleration * (cycles * (cycles - 1) // 2))[up]
    return acceleration, cycles, travel


def best_of_all(velocity: int, start: int, goal: str, value: float) -> list[int]:
    """The accelerations of the five nearest, the slower of two first; of those with the same the slowest, the least."""
    acceleration, cycles, travel = every_trapezoid(velocity, start)
    adds = np.minimum(acceleration, velocity) / ONE * PER_S**2
    has = {"time": cycles * CYCLE_PS, "steps": travel / ONE, "acceleration": adds}[goal]
    order = np.lexsort((acceleration, -cycles, np.abs(has - value)))
    found: dict[float, int] = {}
    for each in order.tolist():
        found.setdefault(has[each], int(acceleration[each]))
        if len(found) == 5:
            break
    return list(found.values())


def cases() -> list[tuple[int, int, str, float]]:
    chance = Random(1451)
    found: list[tuple[int, int, str, float]] = []
    for number in range(27):
        velocity = round(10 ** chance.uniform(3, 5.5))
        start = chance.choice((0, 0, velocity // 3))
        goal = ("time", "steps", "acceleration")[number % 3]
        cycles = 10 ** chance.uniform(0, 3.5)
        value = {
            "time": round(cycles * CYCLE_PS),
            "steps": cycles * velocity / ONE / 2,
            "acceleration": velocity / cycles / ONE * PER_S**2,
        }[goal]
        found.append((velocity, start, goal, value))
    edges = [
        (49, 0, "steps", 0.0001),
        (279, 0, "acceleration", 47_102),
        (3, 0, "time", CYCLE_PS),
        (1000, 999, "steps", 1),
    ]
    return [*few(found, 10), *edges]


@pytest.mark.parametrize("case", cases())
def test_the_search_finds_the_best_of_all_accelerations(case: tuple[int, int, str, Any]) -> None:
    velocity, start, goal, value = case
    found = slewline.find_ramps("mc1451a", SET_VEL=velocity, SET_START_VEL=start, **{goal: value})
    assert [ramp.values["SET_ACC"] for ramp in found] == best_of_all(*case)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5))
def test_the_best_acceleration_is_found_at_any_velocities(seed: int) -> None:
    chance = Random(seed)
    for _ in range(400):
        velocity = chance.randint(1, chance.choice((30, 300, 3000, 20_000)))
        start = chance.choice((0, chance.randint(0, velocity + 3)))
        cycles = 10 ** chance.uniform(-0.5, 3)
        for goal, value in (
            ("time", max(1, round(cycles * CYCLE_PS))),
            ("steps", cycles * velocity / 2 / ONE),
            ("acceleration", velocity / cycles / ONE * PER_S**2),
        ):
            found = slewline.find_ramps("mc1451a", SET_VEL=velocity, SET_START_VEL=start, **{goal: value})
            best = best_of_all(velocity, min(start, velocity), goal, value)
            assert [ramp.values["SET_ACC"] for ramp in found] == best, (velocity, start, goal, value)


S_CASES = [  # free, SET_VEL, what is fixed, ramp time in cycles
    ("SET_MAX_ACC", 265_107, {"SET_JERK": 100_000}, 900.3),
    ("SET_MAX_ACC", 265_107, {"SET_JERK": 100_000}, 833.7),  # no acceleration is so fast
    ("SET_MAX_ACC", 40_000, {"SET_JERK": 1 << 30}, 2.5),
    ("SET_MAX_ACC", 65_536, {"SET_JERK": 7777}, 65_000.5),
    ("SET_JERK", 265_107, {"SET_MAX_ACC": 478}, 700.1),
    ("SET_JERK", 265_107, {"SET_MAX_ACC": 478}, 600.0),
    ("SET_JERK", 20_000, {"SET_MAX_ACC": 32_767}, 90.9),
    ("SET_JERK", 1000, {"SET_MAX_ACC": 3}, 400.0),
]


@pytest.mark.parametrize(("free", "velocity", "fixed", "cycles"), S_CASES)
@pytest.mark.parametrize("goal", few(["time", "steps", "acceleration"], 1))
def test_the_search_for_an_s_curve_finds_the_best_of_all(
    goal: str, free: str, velocity: int, fixed: dict[str, int], cycles: float
) -> None:
    values = np.arange(1, 32_768 if free == "SET_MAX_ACC" else 1_000_000).astype(float)
    acceleration = values if free == "SET_MAX_ACC" else fixed["SET_MAX_ACC"]
    jerk = (values if free == "SET_JERK" else fixed["SET_JERK"]) / ONE
    full = velocity * jerk >= acceleration**2
    times = np.where(full, velocity / acceleration + acceleration / jerk, 2 * np.sqrt(velocity / jerk))
    whole = np.floor(times * CYCLE_PS)  # ps
    value = {
        "time": round(cycles * CYCLE_PS),
        "steps": velocity * cycles / 2 / ONE,
        "acceleration": velocity / cycles / ONE * PER_S**2,
    }
    has = {
        "time": whole,
        "steps": velocity * times / 2 / ONE,
        "acceleration": velocity / whole / ONE * PER_S * 1e12,
    }
    best = int(values[np.lexsort((-times, np.abs(has[goal] - value[goal])))[0]])
    found = slewline.find_ramps("mc1451a", profile="s-curve", SET_VEL=velocity, **fixed, **{goal: value[goal]})
    assert found[0].values[free] == best
    errors = [abs(ramp.time_ps - round(cycles * CYCLE_PS)) for ramp in found]
    assert goal == "acceleration" or errors == sorted(errors)
