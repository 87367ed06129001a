"""What the ramp calculators of all parts share: reading parameters, and looking for the nearest."""

from __future__ import annotations

from itertools import islice
from typing import Any

import pytest

import slewline
from slewline.chips import PARTS, ramps_of, sheet_of
from slewline.errors import UnknownName, UsageError
from slewline.language.ramp_answers import least, levels
from tests.rows import rows


@rows("part", PARTS)
def test_every_part_has_a_calculator_whose_parameters_are_its_commands(part: str) -> None:
    calculator = ramps_of(part)
    assert calculator.sheet is sheet_of(part)
    rows = {row.form: row for row in calculator.sheet.commands}
    for quantity in calculator.quantities:
        assert quantity.description
        if quantity.name in rows:
            (arg,) = rows[quantity.name].args
            assert quantity.arg is not None and arg.high == quantity.arg.high and arg.low <= quantity.arg.low
        else:
            assert quantity.default is not None
    assert any(quantity.free for quantity in calculator.quantities)


def test_capitals_of_a_name_do_not_count_and_hexadecimal_is_a_number() -> None:
    ramp = slewline.ramp("CY525", f="$3", R="0x7F", s="200")
    assert {name: ramp.values[name] for name in "FRSZ"} == {"F": 3, "R": 127, "S": 200, "Z": 1}


@rows(("values", "error", "says"), [
    ({"F": 3, "R": 100, "Q": 1}, UnknownName, "cy525: no parameter 'Q'; available: F, R, S, Z, ramp_unit, ramp_jumps"),
    ({"F": 3, "f": 3}, UsageError, "cy525: f is given twice; give one value"),
    ({"F": 3}, UsageError, r"no value for R \(maximum step rate, 0\.\.127\), S \(acceleration, "),
    ({"F": 3, "R": 128, "S": 1}, UsageError, r"cy525: R 128; allowed 0\.\.127, or text such as '4000 steps/s'"),
    ({"F": 3, "R": 12.5, "S": 1}, UsageError, r"cy525: R 12\.5; allowed 0\.\.127"),
    ({"F": 3, "R": True, "S": 1}, UsageError, "cy525: R True; allowed"),
    ({"F": 3, "R": 100, "S": "steep"}, UsageError, r"cy525: S 'steep'; allowed 1\.\.255$"),
    ({"F": 3, "R": 100, "S": "100 steps/s"}, UsageError, r"cy525: S '100 steps/s'; allowed 1\.\.255$"),
    ({"F": 3, "R": "100 steps/s2", "S": 1}, UsageError, "cy525: R '100 steps/s2'; allowed"),
    ({"F": 3, "R": 100, "S": 1, "crystal": "99 MHz"}, UsageError, "CY525 takes 1 to 11 MHz"),
])  # fmt: skip
def test_bad_parameters_are_refused_with_the_allowed_ones(values: Any, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        slewline.ramp("cy525", **values)


@rows(("wanted", "says"), [
    ({}, "exactly one goal: time, acceleration or steps"),
    ({"time": "1 s", "steps": 4}, "exactly one goal: time, acceleration or steps"),
    ({"time": 0}, "time 0; allowed more than 0"),
    ({"acceleration": -4.0}, r"acceleration -4\.0; allowed more than 0"),
    ({"steps": float("nan")}, "steps nan; allowed more than 0"),
    ({"steps": True}, "steps True; allowed more than 0"),
    ({"time": 1.5}, "a float would be rounded"),
    ({"steps": 4, "count": 0}, "count 0; allowed 1 or more"),
])  # fmt: skip
def test_exactly_one_thing_can_be_wanted_and_it_is_positive(wanted: Any, says: str) -> None:
    with pytest.raises(UsageError, match=says):
        slewline.find_ramps("cy525", F=3, R=100, **wanted)


def test_a_part_without_a_crystal_takes_none() -> None:
    with pytest.raises(UsageError, match="the gs-c200 has no selectable crystal"):
        slewline.ramp("gs-c200", S=1, T=2, R=3, crystal="1 MHz")


@rows("count", [1, 2, 7, 40])
def test_a_longer_list_begins_as_the_shorter_one_does(count: int) -> None:
    wanted: dict[str, Any] = {"F": 3, "R": 90, "steps": 1500}
    longest = [ramp.values for ramp in slewline.find_ramps("cy525", count=60, **wanted)]
    assert [ramp.values for ramp in slewline.find_ramps("cy525", count=count, **wanted)] == longest[:count]


def test_the_list_ends_where_there_are_no_more_ramps() -> None:
    found = slewline.find_ramps("mc1451a", SET_VEL=3, time="1 ms", count=100)
    assert [(ramp.values["SET_ACC"], ramp.time_ps) for ramp in found] == [(1, 655_360_000), (2, 327_680_000), (3, 0)]


# --------------------------------------------------------------------------------------------------------- arithmetic
def test_the_least_number_that_is_enough_is_found_or_none() -> None:
    assert [least(lambda number: number * number >= 50, low, 100) for low in (0, 8, 9)] == [8, 8, 9]
    assert least(lambda number: number > 100, 0, 100) is None


def test_levels_around_a_target_are_represented_by_their_least_values() -> None:
    def tens(value: int) -> int:
        return -(value // 10)

    assert list(levels(tens, -4, 1, 100, 3)) == [40, 50, 60, 30, 20, 10]
    assert list(levels(tens, -3.5, 1, 100, 1)) == [40, 30]
    assert list(levels(tens, 99, 1, 100, 2)) == [1, 10]
    assert list(levels(tens, -99, 1, 100, 2)) == [100, 90, 80]
    assert list(islice(levels(lambda value: -value, -1, 1, 100, 5), 3)) == [1, 2, 3]
