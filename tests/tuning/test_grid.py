"""The grid: what its text means, how values are spaced, who is next to whom, and what is refused."""

from __future__ import annotations

from itertools import pairwise
from math import isclose
from typing import Any

import pytest

from slewline.chips import PARTS, ramps_of
from slewline.errors import UnknownName, UsageError
from slewline.tuning.grid import Grid, read_grid


def read(part: str, given: Any) -> Grid:
    calculator = ramps_of(part)
    return read_grid(calculator, given, calculator.sheet.crystal_hz)


def values(part: str, given: Any, name: str) -> tuple[Any, ...]:
    grid = read(part, given)
    return grid.values[grid.names.index(name)]


@pytest.mark.parametrize(("text", "found"), [
    ("3..6", (3, 4, 5, 6)),
    ("3", (3,)),
    ("9,3,3,5", (3, 5, 9)),
    ("2..10 by 4", (2, 6, 10)),
    ("0x10..0x12", (16, 17, 18)),
    ("1..3, 7 , 5..6", (1, 2, 3, 5, 6, 7)),
    ("300..700 steps/s", (3, 4, 5, 6, 7)),
    ("300 steps/s..700 steps/s", (3, 4, 5, 6, 7)),
    ("4..4/3", (4,)),
    ("4..9/1", (4,)),
])  # fmt: skip
def test_meaning_of_a_text(text: str, found: tuple[int, ...]) -> None:
    assert values("cy525", f"F={text} R=10 S=1", "F") == found


def test_values_are_spaced_evenly_in_what_counts() -> None:
    slopes = [1 / (256 - each) for each in values("cy525", "S=1..254/8", "S")]
    ratios = [b / a for a, b in pairwise(slopes)]
    assert len(slopes) == 8 and values("cy525", "S=1..254/8", "S")[::7] == (1, 254)
    assert all(1.7 < ratio < 2.2 for ratio in ratios)
    accelerations = values("mc1451a", "SET_ACC=2000..200000 steps/s2/9", "SET_ACC")
    assert all(isclose(b / a, 100 ** (1 / 8), rel_tol=0.05) for a, b in pairwise(accelerations))
    starts = values("mc1451a", "SET_START_VEL=0..600 steps/s/4", "SET_START_VEL")
    assert starts[0] == 0 and isclose(starts[1] * 3, starts[3], rel_tol=0.001)


def test_values_may_be_given_by_name() -> None:
    grid = read("cy525", {"F": range(3, 6), "r": [10, "4000 steps/s"], "S": 7, "Z": "1..2"})
    assert grid.values[:4] == ((3, 4, 5), (10, 40), (7,), (1, 2)) and grid.free == ("F", "R", "Z")
    assert str(grid).startswith("F=3,4,5 R=10,40 S=7 Z=1,2")
    assert "R=4..80 (14 values)" in str(read("cy525", ""))


@pytest.mark.parametrize("part", PARTS)
def test_every_part_has_a_grid_of_its_own(part: str) -> None:
    grid, calculator = read(part, None), ramps_of(part)
    assert 50 < grid.size < 2000
    for place in (0, grid.size // 2, grid.size - 1):
        assert calculator.ramp(grid.at(place), calculator.sheet.crystal_hz).move(200).time_ps > 0
    for name, of in zip(grid.names, grid.values, strict=True):
        quantity = calculator.quantity(name)
        assert list(of) == sorted(of, key=lambda each: (isinstance(each, str), each))
        if quantity.arg is not None:
            assert all(a <= b for a, b in pairwise(map(quantity.measure, of)))


def test_an_s_curve_has_parameters_of_its_own() -> None:
    assert read("mc1451a", "profile=s-curve").free == ("SET_VEL", "SET_MAX_ACC", "SET_JERK")
    assert read("mc1451a", "").free == ("SET_VEL", "SET_ACC", "SET_START_VEL")
    says = "applies only to profile s-curve; leave it out, or set profile=s-curve"
    with pytest.raises(UsageError, match=says):
        read("mc1451a", "SET_JERK=5")


def test_neighbours_differ_by_one_value_of_one_parameter() -> None:
    grid = Grid(("a", "b", "c"), ((1, 2, 3), (1,), (1, 2, 3, 4)))
    assert grid.size == 12 and grid.at(7) == {"a": 2, "b": 1, "c": 4}
    for place in range(grid.size):
        near = [
            each
            for each in range(grid.size)
            if sum(abs(x - y) for x, y in zip(grid.digits(place), grid.digits(each), strict=True)) == 1
        ]
        assert sorted(grid.neighbours(place)) == near


@pytest.mark.parametrize(("part", "text", "error", "says"), [
    ("cy525", "Q=1", UnknownName, "cy525: no parameter 'Q'; available: F, R, S, Z, ramp_unit, ramp_jumps"),
    ("cy525", "F", UsageError, "cy525: grid 'F'; give parameters and their values, such as S=1..254/8"),
    ("cy525", "3 F=1", UsageError, "cy525: grid '3'; give parameters"),
    ("cy525", "F=3 F=4", UsageError, "cy525: F is given twice; give its values once"),
    ("cy525", "F=3 f=4", UsageError, "cy525: f is given twice; give its values once"),
    ("cy525", "F=", UsageError, "cy525: F '': no values; allowed a range such as 3..10"),
    ("cy525", "F=..5", UsageError, "cy525: F '..5'; allowed a range"),
    ("cy525", "F=9..3", UsageError, "cy525: F '9..3': 3 is below 9; give the lower value first"),
    ("cy525", "F=1..9/0", UsageError, "empty range; write 1 or more after '/'"),
    ("cy525", "F=1..9 by 0", UsageError, "empty range; write 1 or more after 'by'"),
    ("cy525", "F=1..200", UsageError, "cy525: F '200'; allowed 0..127"),
    ("cy525", "F=1..x", UsageError, "cy525: F 'x'; allowed 0..127, or text such as '4000 steps/s'"),
    ("cy525", "F=0..127 R=0..127 S=1..255", UsageError,
     "cy525: 128 F x 128 R x 255 S = 4177920 points; allowed up to 1000000; use fewer values: /12 "
     "after a range takes 12 of its values"),
    ("mc1451a", "SET_ACC=1..100000000", UsageError, "100000000 values; allowed up to 1000000; use fewer"),
    ("mc1451a", "profile=trapezoid,s-curve", UsageError, "profile: 2 values; give one of trapezoid, s-curve"),
    ("mc1451a", "profile=cubic", UsageError, "mc1451a: profile 'cubic'; allowed trapezoid, s-curve"),
])  # fmt: skip
def test_mistakes_in_a_grid(part: str, text: str, error: type[Exception], says: str) -> None:
    with pytest.raises(error) as caught:
        read(part, text)
    assert says in str(caught.value)


@pytest.mark.parametrize("given", [{"F": []}, {"F": 2.5}, {"F": None}, {"F": [1.5]}])
def test_mistakes_in_values_by_name(given: Any) -> None:
    if given == {"F": None}:
        assert read("cy525", given).names[0] == "F"
        return
    with pytest.raises(UsageError, match=r"^cy525: F"):
        read("cy525", given)
