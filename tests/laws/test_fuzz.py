"""Nothing that a host or the pins do stops a chip, and all of it can be repeated."""

from __future__ import annotations

from pathlib import Path

import pytest

from .fuzz import LETTERS, replayed, run


def check(bytes_wanted: int, tmp_path: Path) -> None:
    journal = str(tmp_path / "journal")
    one = run(bytes_wanted, 1, journal)
    print(one.accepted, dict(one.effects), dict(one.findings))
    assert one.accepted >= bytes_wanted
    for letter in set(LETTERS) - {"Q"}:
        assert one.effects[letter] >= bytes_wanted // 2000, f"{letter} was hardly reached"
    assert run(bytes_wanted, 1).digest() == one.digest()
    assert replayed(journal) == one.end_state()


def test_a_mad_host_stops_nothing_and_can_be_repeated(tmp_path: Path) -> None:
    check(5_000, tmp_path)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_a_million_bytes_stop_nothing_and_can_be_repeated(tmp_path: Path) -> None:
    check(1_000_000, tmp_path)
