"""The checks of motors behind chips, and of the tuner: quick ones, and the others with the long tests."""

from __future__ import annotations

import pytest

from .rows import AT_WORK, ROWS
from .table import Check, Reading, as_parameters


@pytest.mark.system
@pytest.mark.timeout(900)
@pytest.mark.parametrize("row", as_parameters(ROWS, AT_WORK))
def test_value_is_within_its_tolerance(row: Check) -> None:
    readings: list[Reading] = list(row.read())

    if not readings:
        pytest.skip("needs Numba")
    assert [reading for reading in readings if not reading.passed] == []
