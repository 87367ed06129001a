"""Random programs from every part to every target: limits are cited, and where nothing is lost both run alike."""

from __future__ import annotations

import pytest

from tests.ensembles import few, in_long_runs, members
from tests.translation.any_programs import any_program
from tests.translation.ensemble import FAILED, NAMED, OTHERS, outcome
from tests.translation.programs import random_program

TWENTY = range(20)
OWN = ("cy525", "gs-c200s", "cy545b", "mc1451a", "cy500")
EVERY_RUN = ("cy500", "cy545", "gs-c200s")  # whose programs take least


@pytest.mark.parametrize("pair", [pair if pair[0] in EVERY_RUN else in_long_runs(pair) for pair in NAMED], ids="-".join)
@members("seeds", 1, 300, at_once=100)
def test_programs_of_the_pairs_that_people_need(pair: tuple[str, str], seeds: range) -> None:
    for seed in seeds:
        what, about = outcome(*pair, random_program(pair[0], seed))
        assert what != FAILED, (seed, about)


@pytest.mark.check  # not in every run of the tests, but in every one of the checks
@pytest.mark.parametrize("pair", OTHERS, ids="-".join)
@pytest.mark.timeout(600)
def test_programs_of_all_other_pairs(pair: tuple[str, str]) -> None:
    for seed in TWENTY:
        what, about = outcome(*pair, random_program(pair[0], seed))
        assert what != FAILED, (seed, about)


@pytest.mark.parametrize("source", few(["cy500", "cy512", "cy525", "cy545b", "gs-c200", "gs-c200s", "mc1451a"], 3))
@members("seeds", 1, 40, at_once=10)
@pytest.mark.timeout(600)
def test_programs_of_any_commands_with_a_host_that_acts_during_motions(source: str, seeds: range) -> None:
    for seed in seeds:
        text = any_program(source, seed)
        for to in OWN:
            if to != source:
                what, about = outcome(source, to, text)
                assert what != FAILED, (seed, to, about)
