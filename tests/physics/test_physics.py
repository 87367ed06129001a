"""The checks of the physics of motors: quick ones, and the others with the long tests."""

from __future__ import annotations

import pytest

from .rows import ROWS
from .table import Check, Reading


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(row, id=row.name, marks=[pytest.mark.long, pytest.mark.timeout(900)] if row.long else [])
        for row in ROWS
    ],
)
def test_value_is_within_its_tolerance(row: Check) -> None:
    readings: list[Reading] = list(row.read())

    if not readings:
        pytest.skip("needs Numba")
    assert [reading for reading in readings if not reading.passed] == []


def test_names_of_checks_are_unique() -> None:
    assert len({row.name for row in ROWS}) == len(ROWS)
