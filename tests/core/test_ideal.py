"""Ideals: pieces of constant jerk over time, and how far an axis is from them."""

from __future__ import annotations

import numpy as np
import pytest

from slewline.core.motion.axis import Axis
from slewline.core.motion.deviation import deviation
from slewline.core.motion.ideal_motion import Ideal, IdealPiece, head, mirrored, there_and_down, travelled
from slewline.core.motion.train import Playing, StepTrain
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Clock

S = 10**12
UP = [IdealPiece(2.0, 0.0, 3.0, 0.0), IdealPiece(1.0, 6.0, 4.0, 0.0)]  # to 6 and 10 steps/s, 6 and 8 steps


def test_an_ideal_is_queried_at_any_instant() -> None:
    ideal = Ideal(5 * S, 100.0, [*UP, IdealPiece(3.0, 10.0, 0.0, -2.0)], sign=-1)
    times = np.array([12, 5, 7, 8, 9, 11, 4]) * S
    assert ideal.stop == 11 * S and ideal.bends.tolist() == [5 * S, 7 * S, 8 * S, 11 * S]
    assert ideal.positions(times) == pytest.approx([65, 100, 94, 86, 76 + 1 / 3, 65, 100])
    assert ideal.velocities(times) == pytest.approx([0, 0, -6, -10, -9, 0, 0])


def test_an_interrupted_ideal_stays_where_it_was_interrupted() -> None:
    ideal = Ideal(0, 0.0, UP)
    assert ideal.until(3 * S) is ideal
    cut = ideal.until(2 * S)
    assert (cut.stop, cut.interrupted, ideal.interrupted) == (2 * S, True, False)
    assert cut.positions(np.array([1, 2, 3]) * S) == pytest.approx([1.5, 6, 6])
    assert cut.velocities(np.array([2 * S, 2 * S + 1])) == pytest.approx([6, 0])
    assert cut.bends.tolist() == [0, 2 * S] and ideal.until(-5).stop == 0


def test_there_and_down_comes_as_far_as_it_shall() -> None:
    assert travelled(UP) == 14 and mirrored(UP) == [IdealPiece(1.0, 10.0, -4.0, 0.0), IdealPiece(2.0, 6.0, -3.0, 0.0)]
    assert mirrored([IdealPiece(2.0, 0.0, 0.0, 3.0)]) == [IdealPiece(2.0, 6.0, -6.0, 3.0)]
    assert travelled(head(UP, 10)) == pytest.approx(10) and len(head(UP, 5)) == 1
    for distance in (3, 11, 28, 29, 500):
        pieces = there_and_down(UP, 10.0, distance)
        assert travelled(pieces) == pytest.approx(distance)
        ends = [piece.velocity + piece.acceleration * piece.seconds for piece in pieces if piece.seconds]
        begins = [piece.velocity for piece in pieces if piece.seconds]
        assert ends[:-1] == pytest.approx(begins[1:]) and ends[-1] == pytest.approx(0)


def moved(*runs: tuple[int, int], wraps: int = 1 << 16) -> Axis:
    """An axis that has made steps from 0 on: runs of so many milliseconds, and how often."""
    kernel = Kernel()
    axis = Axis(kernel, range(wraps), wraps - 3)
    axis.follow(Playing(StepTrain(Clock(1000), 0, runs)), 1)
    kernel.run(S)
    return axis


def test_the_deviation_is_the_greatest_also_just_before_a_step() -> None:
    axis = moved((10, 20))
    start = (1 << 16) - 3
    assert deviation(axis, Ideal(0, start, [IdealPiece(0.2, 100.0)])) == (pytest.approx(1), 0, pytest.approx(0), 0)
    found = deviation(axis, Ideal(0, start, [IdealPiece(0.2, 200.0)]))
    assert (found.position, found.position_ps) == (pytest.approx(20 - 40, abs=1e-6), 2 * 10**11)
    found = deviation(axis, Ideal(0, start, [IdealPiece(0.1, 110.0), IdealPiece(0.1, 90.0)]))
    assert (abs(found.position), found.velocity) == (pytest.approx(1), pytest.approx(-10))
    found = deviation(axis, Ideal(0, start, [IdealPiece(0.1, 300.0), IdealPiece(0.1, 0.0)]))
    assert (found.position, found.position_ps) == (pytest.approx(-20, abs=1e-6), 10**11 - 1)
    late = moved((10, 5), (50, 1), (2, 5), (10, 9))
    found = deviation(late, Ideal(0, start, [IdealPiece(0.2, 100.0)]))
    assert (found.position, found.position_ps) == (pytest.approx(-4, abs=1e-6), 10**11 - 1)
    assert (found.velocity, found.velocity_ps) == (pytest.approx(400), 10**11)


def test_the_step_that_lasts_beyond_its_ideal_is_not_too_fast() -> None:
    found = deviation(moved((10, 21)), Ideal(0, (1 << 16) - 3, [IdealPiece(0.2, 100.0)]))
    assert (found.position, found.velocity) == (pytest.approx(1), pytest.approx(0))


def test_an_axis_that_wraps_is_followed() -> None:
    found = deviation(moved((10, 20), wraps=5), Ideal(0, 2.0, [IdealPiece(0.2, 100.0)]))
    assert abs(found.position) <= 1 + 1e-9
