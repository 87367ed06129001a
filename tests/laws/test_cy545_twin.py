"""The CY545's motions, jog and HOME: the fast path and its step-by-step twin leave the same edges, whatever happens."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import pytest

from tests.ensembles import few

from . import cy545_dialogues
from .cy545_dialogues import KINDS, made
from .twins import agree, compared, hashes_are_free, ties_are_free

QUICK = (4, 9, 21, 29, 35, 60, 63, 69, 73)  # short dialogues, in which everything occurs
ENDS = {("G", "done"), ("G", "stopped"), ("G", "limit"), ("G", "cut"), ("H", "done"), ("H", "limit"), ("J", "done")}


@pytest.mark.parametrize("seeds", few((QUICK, *(range(at, at + 20) for at in range(0, 80, 20))), 1))
def test_fast_path_and_twin_agree(seeds: Iterable[int]) -> None:
    kinds: Counter[str] = Counter()
    ends: set[tuple[str, str]] = set()
    for seed in seeds:
        dialogue = made(seed)
        played = compared(cy545_dialogues, dialogue, shuffle=seed)
        kinds.update(dialogue.kinds)
        ends |= {(motion.text[0], motion.end.why) for motion in played.chip.motions() if motion.end}
    assert all(kinds[kind] >= 3 for kind in KINDS), dict(kinds)  # the short form meets everything, too
    assert len(ENDS - ends) <= 1, ENDS - ends


@pytest.mark.parametrize("block", few(range(4), 1))
def test_shuffled_ties_change_nothing(block: int) -> None:
    ties_are_free(cy545_dialogues, range(1000 + block * 3, 1000 + block * 3 + 3))


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted = agree(cy545_dialogues, range(10_000, 12_000))
    assert all(counted[kind] >= 200 for kind in KINDS), counted


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_hash_seeds_give_the_same_edges() -> None:
    hashes_are_free(cy545_dialogues, 20_000, 20_100)
