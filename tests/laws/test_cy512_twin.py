"""The CY512's fast path and its step-by-step twin leave the same edges on every pin, whatever happens when."""

from __future__ import annotations

from collections import Counter

import pytest

from .cy512_dialogues import Dialogue, differences, made, play
from .digests import digests
from .test_twin import explained

SLOW = (5, 34)  # with TERMINATE held low for tens of thousands of steps: half a minute each
KINDS = ("abort", "inhibit", "request", "terminate", "select", "reset", "tie")


def compared(seed: int, shuffle: int | None = None) -> Dialogue:
    """Play a dialogue both ways and assert that nothing differs."""
    dialogue = made(seed)
    found = differences(play(dialogue), play(dialogue, stepwise=True, shuffle=shuffle))
    assert not found, explained(dialogue, found)
    return dialogue


@pytest.mark.parametrize("block", range(2))
def test_fast_path_and_twin_agree(block: int) -> None:
    for seed in range(block * 15, block * 15 + 15):
        if seed not in SLOW:
            compared(seed)


def test_shuffled_ties_change_nothing() -> None:
    for seed in range(1000, 1005):
        dialogue = made(seed)
        plain = play(dialogue)
        for shuffle in (1, 2):
            assert not differences(plain, play(dialogue, shuffle=shuffle)), explained(dialogue, [f"shuffle {shuffle}"])


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted: Counter[str] = Counter()
    for seed in (*SLOW, *range(10_000, 12_000)):
        counted.update(compared(seed, shuffle=seed).kinds)
    print(dict(counted))
    for kind in KINDS:
        assert counted[kind] >= 200, f"only {counted[kind]} dialogues with {kind}"


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_hash_seeds_give_the_same_edges() -> None:
    one = digests("cy512_dialogues", "1", 20_000, 20_100)
    assert one == digests("cy512_dialogues", "2", 20_000, 20_100)
    assert all(fast == slow for fast, slow in (line.split() for line in one.splitlines()))
