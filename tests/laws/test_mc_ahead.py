"""A chipset that looks ahead at its encoders leaves what its cycle-by-cycle twin leaves, however far it looks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from random import Random

import pytest

from tests.ensembles import few

from . import mc_shafts
from .dialogues import differences

KINDS = {"encoder": 2500, "quadrature": 700, "wires": 800, "encoder-fast": 5000, "encoder-illegal": 1500}  # of 5,000
QUICK = (*range(10, 20), 39, 3)  # short dialogues that have found every mistake so far
REACHES = (1, 2, 3, 4, 7, 16, 50, 64, 256)  # cycles


def agree(seeds: Iterable[int], reaches: int) -> Counter[str]:
    """Compare dialogues; each is played with so many bounds of the windows, always with the one in use."""
    counted: Counter[str] = Counter()
    for seed in seeds:
        dialogue, rnd = mc_shafts.made(seed), Random(seed)
        twin = mc_shafts.play(dialogue, stepwise=True, shuffle=seed)
        bounds = [(4, 256), *((rnd.randint(1, most), most) for most in rnd.sample(REACHES, reaches))]
        asked = None
        for least, most in bounds:
            fast = mc_shafts.play(dialogue, least=least, most=most)
            found = differences(fast, twin)
            assert not found, f"{least} to {most}: {found[:3]}\n  {dialogue}"
            asked = fast.actual if asked is None else asked
            assert fast.actual == asked, f"{least} to {most}: what is asked of the past\n  {dialogue}"
        counted.update(dialogue.kinds)
        counted.update(code for _, code in twin.state()["found"])
    return counted


@pytest.mark.parametrize("seeds", few((QUICK, range(40)), 1), ids=len)
def test_windows_of_any_length_and_the_twin_agree(seeds: Iterable[int]) -> None:
    agree(seeds, 2)


@pytest.mark.long
@pytest.mark.timeout(3000)
@pytest.mark.parametrize("block", range(10))
def test_five_thousand_dialogues_about_shafts_agree(block: int) -> None:
    """A tenth of them; a few noisy shafts have most of the findings, so half of a tenth of these will do."""
    counted = agree(range(10_000 + block * 500, 10_500 + block * 500), 5)
    assert all(counted[kind] * 20 >= wanted for kind, wanted in KINDS.items()), counted
