"""The CY512's fast path and its step-by-step twin leave the same edges on every pin, whatever happens when."""

from __future__ import annotations

import pytest

from tests.ensembles import few

from . import cy512_dialogues
from .twins import agree, hashes_are_free, ties_are_free

SLOW = (5, 34)  # with TERMINATE held low for tens of thousands of steps: half a minute each
KINDS = ("abort", "inhibit", "request", "terminate", "select", "reset", "tie")


@pytest.mark.parametrize("block", few(range(2), 1))
def test_fast_path_and_twin_agree(block: int) -> None:
    agree(cy512_dialogues, (seed for seed in range(block * 15, block * 15 + 15) if seed not in SLOW))


def test_shuffled_ties_change_nothing() -> None:
    ties_are_free(cy512_dialogues, range(1000, 1005))


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted = agree(cy512_dialogues, (*SLOW, *range(10_000, 12_000)))
    assert all(counted[kind] >= 200 for kind in KINDS), counted


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_hash_seeds_give_the_same_edges() -> None:
    hashes_are_free(cy512_dialogues, 20_000, 20_100)
