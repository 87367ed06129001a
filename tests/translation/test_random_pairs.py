"""Random programs from every part to every target: limits are cited, and where nothing is lost both run alike."""

from __future__ import annotations

import pytest

from tests.ensembles import in_long_runs, members
from tests.translation.ensemble import FAILED, NAMED, OTHERS, outcome

TWENTY = range(20)
EVERY_RUN = ("cy500", "cy545", "gs-c200s")  # whose programs take least


@pytest.mark.parametrize("pair", [pair if pair[0] in EVERY_RUN else in_long_runs(pair) for pair in NAMED], ids="-".join)
@members("seeds", 1, 300, at_once=100)
def test_programs_of_the_pairs_that_people_need(pair: tuple[str, str], seeds: range) -> None:
    for seed in seeds:
        what, about = outcome(*pair, seed)
        assert what != FAILED, (seed, about)


@pytest.mark.parametrize("pair", [in_long_runs(pair) for pair in OTHERS], ids="-".join)
@pytest.mark.timeout(600)
def test_programs_of_all_other_pairs(pair: tuple[str, str]) -> None:
    for seed in TWENTY:
        what, about = outcome(*pair, seed)
        assert what != FAILED, (seed, about)
