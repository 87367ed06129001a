"""The law of motion of the MC1451A in random moves: exact, within its limits, no longer than it must be."""

from __future__ import annotations

from random import Random

import pytest
from ruckig import InputParameter, Ruckig, RuckigError, Trajectory

from slewline.chips.mc1451a.profiles.profile import UNIT, Phases, s_curve

from .mc_moves import ONE, Worst, check_curve, check_moves, check_retargets, compare_with_twin, random_curve


@pytest.mark.fact("PMD-TRAP-1", "PMD-TRAP-2", "PMD-TRAP-3", "PMD-TRAP-4", "PMD-SCRV-1", "PMD-SCRV-2", "PMD-SCRV-7")
def test_random_moves_are_exact_within_their_limits_and_as_long_as_they_must_be():
    worst = check_moves(4_000, seed=2)
    assert worst.most["S-curve: cycles beyond the ideal"][0] > 0.99  # the ensemble reaches what rounding can cost
    assert worst.coasting > 600


def test_moves_with_new_destinations_in_motion_arrive():
    assert check_retargets(4_000, seed=2) >= 4_000


def shorter(jerked: int = 0, steady: int = 0, coasting: int = 0):
    """An S-curve whose phases end so many parts of a cycle too soon."""

    def phases(*move: int) -> Phases:
        whole = s_curve(*move)
        times = whole.jerked - jerked, whole.steady - steady, whole.coasting - coasting
        return Phases(*times, *whole[3:])

    return phases


@pytest.mark.parametrize("how", [{"jerked": UNIT}, {"steady": UNIT}, {"coasting": 2 * UNIT}, {"jerked": UNIT // 50}])
def test_a_law_that_takes_a_phase_too_short_is_caught(how, monkeypatch):
    """The checks themselves can fail."""
    monkeypatch.setattr("tests.laws.mc_moves.s_curve", shorter(**how))
    with pytest.raises(AssertionError):
        check_curve(1000 * ONE, ONE, 1024, 2097152, Worst())


def ruckig_cycles(distance: int, velocity: int, acceleration: int, jerk: int) -> float:
    """How long the time-optimal curve of the library takes, from rest to rest.

    It is asked in units in which distance and jerk are 1, for it solves equations in floating point.
    """
    unit = (distance * ONE / jerk) ** (1 / 3)  # cycles
    asked, found = InputParameter(1), Trajectory(1)
    asked.current_position, asked.target_position, asked.max_jerk = [0.0], [1.0], [1.0]
    asked.max_velocity, asked.max_acceleration = [velocity * unit / distance], [acceleration * unit**2 / distance]
    assert Ruckig(1).calculate(asked, found) in (0, 1)
    return float(found.duration) * unit


def compare_with_ruckig(number: int, seed: int) -> tuple[float, float, int]:
    """The least and the greatest number of cycles beyond the library's, and how many moves that one refused."""
    chance, beyond, refused = Random(seed), [], 0
    while len(beyond) < number:
        move = random_curve(chance)
        if move is not None:
            try:
                beyond.append(s_curve(*move).cycles - ruckig_cycles(*move))
            except RuckigError:
                refused += 1
    return min(beyond), max(beyond), refused


def test_s_curves_against_a_time_optimal_library():
    least, most, refused = compare_with_ruckig(2_000, seed=3)
    assert least > -0.01 and 0.99 < most < 1.01
    assert refused < 20  # extreme ratios, which floating point cannot solve


@pytest.mark.fact("PMD-SCRV-13", "PMD-SCRV-14")
def test_the_twin_takes_the_same_cycles_up_to_smooth_stops_at_any_instant():
    assert compare_with_twin(30, seed=4) > 8


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_a_million_moves_and_a_hundred_thousand_new_destinations():
    worst = check_moves(1_000_000)
    print(worst)
    print(check_retargets(100_000), "retargets")
    print(compare_with_twin(5_000, seed=6, most=1000), "smooth stops beside the twin")
    print("beyond the library:", compare_with_ruckig(100_000, seed=5))
