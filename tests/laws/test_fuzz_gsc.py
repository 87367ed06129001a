"""Nothing that comes over the line, and nothing on the pins, stops a GS-C module, and all of it can be repeated."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.ensembles import few

from .fuzz import replayed
from .fuzz_gsc import run

PARTS = ("gs-c200", "gs-c200s")


def check(part: str, characters: int, tmp_path: Path) -> None:
    journal = str(tmp_path / "journal")
    one = run(part, characters, 1, journal)
    print(one.sent, dict(one.answers), dict(one.findings))
    for kind in ("Y", "B", "R", "E1", "E2", "E4", "V", "listing"):
        assert one.answers[kind] >= characters // 500, f"{kind} was hardly reached"
    assert one.answers["E3"] > 0
    for error in ("E1", "E2", "E3", "E4"):  # what is refused is told
        assert one.answers[error] == one.findings[error]
    assert run(part, characters, 1).digest() == one.digest()
    assert replayed(journal) == one.end_state()


@pytest.mark.parametrize("part", few(reversed(PARTS), 1))
def test_a_mad_host_stops_nothing_and_can_be_repeated(part: str, tmp_path: Path) -> None:
    check(part, 2_000, tmp_path)


@pytest.mark.long
@pytest.mark.timeout(6000)
@pytest.mark.parametrize("part", PARTS)
def test_half_a_million_characters_stop_nothing_and_can_be_repeated(part: str, tmp_path: Path) -> None:
    check(part, 500_000, tmp_path)
