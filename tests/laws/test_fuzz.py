"""Nothing that a host or the pins do stops a chip, and all of it can be repeated."""

from __future__ import annotations

from pathlib import Path

import pytest

from .fuzz import check


def test_a_mad_host_stops_nothing_and_can_be_repeated(tmp_path: Path) -> None:
    check(2_000, tmp_path)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_a_million_bytes_stop_nothing_and_can_be_repeated(tmp_path: Path) -> None:
    check(1_000_000, tmp_path)
