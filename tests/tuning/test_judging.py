"""The judge over the physics: who is lost, who is not, in both directions, and what rings for a while."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

import slewline
from slewline.parts.motors.motor_data import DriverData, LoadData
from slewline.parts.motors.motors import read_motor
from slewline.tuning import judging
from slewline.tuning.judging import Trial, Verdict, judge
from slewline.tuning.perturbations import NOMINAL, Scenario, scenarios

MOTOR = read_motor("QSH4218-51-10-049")
DRIVER = DriverData(kind="current", current=1.0)
LOAD = LoadData(inertia=6.8e-6, friction=5e-3)


@pytest.fixture(autouse=True)
def plain_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """Short moves: to compile takes longer."""
    monkeypatch.setattr(judging, "engine", lambda: "python")


def ways(stepping: str = "full", load: LoadData = LOAD, step_ps: int = 50_000_000) -> tuple[Scenario, ...]:
    return scenarios((MOTOR, DRIVER, load), (NOMINAL,), stepping, step_ps)


@cache
def even(rate: int, steps: int) -> tuple[int, ...]:
    return tuple(int(1e12 / rate) * n for n in range(steps))


def verdict(rate: int, scenario: Scenario, steps: int = 24) -> Verdict:
    return judge(Trial(np.array(even(rate, steps), np.int64), scenario))


@pytest.mark.parametrize("direction", [0, 1])
def test_a_slow_move_holds_and_a_fast_start_is_lost(direction: int) -> None:
    scenario = ways()[direction]
    slow, fast = verdict(800, scenario), verdict(4000, scenario)
    assert not slow.lost and abs(slow.error) < 0.1 and 0.5 < slow.worst < 2
    assert fast.lost and fast.worst > 3.9


def test_where_steps_are_lost_the_rotor_stops_early() -> None:
    fast = verdict(4000, ways()[0], 400)
    assert fast.lost and 3.9 < fast.worst < 5.2  # the run ends at the limit


def test_ringing_is_watched_until_it_rests() -> None:
    free = replace(LOAD, friction=0.0)
    found = verdict(150, ways(load=free)[0], 2)
    assert not found.lost and abs(found.error) < 0.6


def test_endless_ringing_is_watched_for_600_ms_after_the_last_step_and_is_lost() -> None:
    law, stops = judging.law_of(ways()[0]), []

    class Ringing:
        """A law whose rotor swings by 1 full step without end."""

        lost_at, at_rest = law.lost_at, staticmethod(law.at_rest)

        def integrate(self, times: object, numbers: object, stop: int, **_: object) -> SimpleNamespace:
            stops.append(stop)
            ends = np.array([stop - 1_000_000_000, stop])
            lag, states, commands = np.array([1.0, -1.0]), np.zeros((2, 3)), np.zeros(2, np.int64)
            return SimpleNamespace(times=ends, lag=lag, states=states, commands=commands, rests=False)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(judging, "law_of", lambda _: Ringing())
        found = judge(Trial(np.zeros(1, np.int64), ways()[0]))
    assert found == Verdict(True, -1.0, 1.0)
    last_step = 1
    assert stops[-1] - last_step == 600_000_000_000


@pytest.mark.parametrize(("off", "lost"), [(0.55, False), (0.65, True)])
def test_a_rotor_that_rests_more_than_0_6_steps_from_its_command_is_lost(off: float, lost: bool) -> None:
    stuck = replace(LOAD, friction=1e-3, stiction=0.45, torque=0.0)  # nothing takes it further
    law = judging.law_of(ways(load=stuck)[0])
    there = law.at_rest(0)

    class Beside:
        """A law that begins beside its command."""

        lost_at = law.lost_at

        def at_rest(self, command: int) -> tuple[float, ...]:
            return (there[0] - off * law.step, *there[1:])

        integrate = staticmethod(law.integrate)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(judging, "law_of", lambda _: Beside())
        found = judge(Trial(np.zeros(1, np.int64), replace(ways(load=stuck)[0], direction=0)))
    assert found.lost == lost and found.error == pytest.approx(off, abs=0.01)


def test_half_steps_may_begin_at_either() -> None:
    for scenario in ways("half"):
        found = verdict(1200, scenario)
        assert not found.lost and abs(found.error) < 0.1


def test_a_weight_pulls_backward() -> None:
    up, down = (verdict(800, each) for each in ways(load=replace(LOAD, torque=0.06)))
    assert up.error > 0.02 and down.error > 0.02  # the rotor hangs below its command either way
    assert up.worst > down.worst + 0.05


def test_the_first_step_is_at_the_start_of_the_move() -> None:
    times = np.array(even(800, 10), np.int64)
    one, other = (judge(Trial(times + shift, ways()[0])) for shift in (0, 7_000_000_000))
    assert one == other


def test_a_found_ramp_holds_under_the_judge(monkeypatch: pytest.MonkeyPatch) -> None:
    found = slewline.tune(
        "cy525", motor="QSH4218-51-10-049", driver="L/4R 20 V", load="inertia 68 g cm2, friction 5 mNm, torque 30 mNm",
        steps=30, grid="F=4,8 R=8..14 by 3 S=200", perturb="load 20%, current -20%",
    )  # fmt: skip
    assert found.best is not None and found.runs < found.exhaustive
    times = slewline.ramp("cy525", **dict(found.best.values)).move(30).times()
    assert not any(judge(Trial(times, each)).lost for each in found.task.scenarios())
    assert max(judge(Trial(times, each)).worst for each in found.task.scenarios()) == found.best.worst
