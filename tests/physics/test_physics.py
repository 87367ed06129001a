"""The checks of the equations of motors: quick ones, and the others with the long tests."""

from __future__ import annotations

import pytest

from .rows import EQUATIONS, ROWS
from .table import Check, Reading, as_parameters

SLOW = {12, 23, 35, 108}  # not in every run


@pytest.mark.parametrize("row", as_parameters(ROWS, EQUATIONS, SLOW))
def test_value_is_within_its_tolerance(row: Check) -> None:
    readings: list[Reading] = list(row.read())

    if not readings:
        pytest.skip("needs Numba")
    assert [reading for reading in readings if not reading.passed] == []


def test_names_of_checks_are_unique() -> None:
    assert len({row.name for row in ROWS}) == len(ROWS)
