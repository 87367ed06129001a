"""The ramp calculator of the GS-C modules: what it says is what the pins do, and what it finds is the best there is."""

from __future__ import annotations

from functools import cache
from random import Random
from typing import Any

import numpy as np
import pytest
from gsc import C200, C200S, base, both

import slewline
from slewline.errors import UsageError
from tests.ensembles import few

PS_PER_S = 10**12
STEADY, LINEAR = "constant acceleration", "linear in steps"
MOVES = [  # S, T, R, law, steps
    (10, 100, 50, STEADY, 1000),
    (10, 100, 50, LINEAR, 1000),
    (30, 500, 999, STEADY, 5000),
    (1, 1000, 1, STEADY, 20),
    (20, 300, 77, LINEAR, 154),  # too short for its speed
    (20, 300, 77, STEADY, 31),
    (10, 100, 50, STEADY, 1),
    (100, 50, 20, STEADY, 300),  # no ramp
]


def asked(start: int, top: int, length: int, law: str, part: str = C200) -> Any:
    return slewline.ramp(part, S=start, T=top, R=length, law=law)


@pytest.mark.parametrize("move", MOVES)
@both
def test_every_step_of_a_move_comes_at_its_calculated_time(part: str, move: tuple[Any, ...]) -> None:
    start, top, length, law, number = move
    rig = base(part, "ramp", "mov", options={"law": law})
    rig.run(f"S{start}", f"T{top}", f"R{length}", f"+{number}")
    first, *_ = pulses = rig.pulses()
    ramp = asked(start, top, length, law, part)
    told = ramp.move(number)
    assert told.times().tolist() == [pulse - first for pulse in pulses]
    assert [fall - first for fall in rig.falls("mov")] == [told.time_ps]
    slews = rig.falls("ramp")[:1] if len(rig.falls("ramp")) == 2 else []
    assert told.reached == (bool(slews) or top <= start)
    assert (ramp.reached_from <= number) == told.reached
    if slews:
        assert ramp.time_ps == slews[0] - first
        assert ramp.steps == length == sum(pulse < slews[0] for pulse in pulses)
        assert [row.begin_ps for row in ramp.table()] == told.times()[:length].tolist()
        assert [PS_PER_S / row.rate for row in ramp.table()] == pytest.approx(np.diff(told.times())[:length].tolist())


@pytest.mark.parametrize("move", [(10, 100, 50, STEADY), (30, 40, 7, LINEAR), (1, 1000, 1, STEADY)])
def test_the_shortest_move_that_reaches_its_speed_does_and_one_step_less_does_not(move: tuple[Any, ...]) -> None:
    start, top, length, law = move
    shortest = asked(*move).reached_from
    for number, reached in ((shortest, True), (shortest - 1, False)):
        rig = base(C200, options={"law": law})
        rig.run(f"S{start}", f"T{top}", f"R{length}", f"+{number}")
        assert (int(np.diff(rig.pulses()).min()) == round(PS_PER_S / (10 * top))) == reached


def test_constant_acceleration_is_one_number_and_another_law_has_three() -> None:
    steady, linear = asked(10, 100, 50, STEADY), asked(10, 100, 50, LINEAR)
    assert steady.accelerations == pytest.approx((9900, 9900, 9900))  # (1000^2 - 100^2) / (2 * 50)
    assert linear.accelerations == pytest.approx((1962, 9900, 17_838))  # (118^2 - 100^2) / 2 ... (1000^2 - 982^2) / 2


@pytest.mark.parametrize(("rate", "value"), [("1000 steps/s", 100), ("1004 steps/s", 100), ("1005 steps/s", 101)])
def test_a_speed_may_be_given_in_steps_per_second(rate: str, value: int) -> None:
    assert slewline.ramp(C200, S=1, T=rate, R=10).values["T"] == value


def test_a_move_longer_than_the_counter_is_refused() -> None:
    with pytest.raises(UsageError, match=r"gs-c200: a move of 10000000 steps; allowed 1\.\.9999999"):
        asked(10, 100, 50, STEADY).move(10_000_000)
    assert asked(10, 100, 50, STEADY, C200S).move(16_777_215).steps == 16_777_215


# ---------------------------------------------------------------------------------------------------------- backwards
@cache
def every_time(start: int, top: int, law: str) -> np.ndarray:
    """The time of the ramp for every R from 1 to 999, made anew here."""
    low, high = 10.0 * start, 10.0 * top
    times = []
    for length in range(1, 1000):
        k = np.arange(length)
        rates = np.sqrt(low**2 + (high**2 - low**2) * k / length) if law == STEADY else low + (high - low) * k / length
        times.append(int(np.rint(PS_PER_S / rates).sum()))
    return np.array(times)


def best_of_all(start: int, top: int, law: str, goal: str, value: float) -> list[int]:
    """The R of the five nearest, the slower of two first."""
    lengths, times = np.arange(1, 1000), every_time(start, top, law)
    gain = 50 * (top**2 - start**2)
    has = {"time": times, "steps": lengths, "acceleration": gain / lengths}[goal]
    return lengths[np.lexsort((-times, np.abs(has - value)))[:5]].tolist()


def cases() -> list[tuple[int, int, str, str, float]]:
    chance = Random(200)
    found = []
    for start, top, law in ((10, 100, STEADY), (7, 1000, LINEAR), (300, 301, STEADY), (1, 450, STEADY)):
        for goal in ("time", "time", "time", "steps", "steps", "acceleration", "acceleration"):
            value = {
                "time": int(10 ** chance.uniform(9, 12.5)),
                "steps": chance.randint(1, 1100),
                "acceleration": round(10 ** chance.uniform(2, 6)),
            }[goal]
            found.append((start, top, law, goal, value))
    return found


@pytest.mark.parametrize("case", few(cases(), 12))
def test_the_search_finds_the_best_of_all_ramp_lengths(case: tuple[int, int, str, str, Any]) -> None:
    start, top, law, goal, value = case
    found = slewline.find_ramps(C200, S=start, T=top, law=law, **{goal: value})
    assert [ramp.values["R"] for ramp in found] == best_of_all(*case)
