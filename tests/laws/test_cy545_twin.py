"""The CY545's motions, jog and HOME: the fast path and its step-by-step twin leave the same edges, whatever happens."""

from __future__ import annotations

from collections import Counter

import pytest

from .cy545_dialogues import KINDS, Motions, Moved, differences, made, play
from .digests import digests
from .test_twin import explained


def compared(seed: int, shuffle: int | None = None) -> tuple[Motions, Moved]:
    """Play a dialogue both ways and assert that nothing differs; return it, and the fast way."""
    dialogue = made(seed)
    fast = play(dialogue)
    found = differences(fast, play(dialogue, stepwise=True, shuffle=shuffle))
    assert not found, explained(dialogue, found)
    return dialogue, fast


ENDS = {("G", "done"), ("G", "stopped"), ("G", "limit"), ("G", "cut"), ("H", "done"), ("H", "limit"), ("J", "done")}


@pytest.mark.parametrize("block", range(4))
def test_fast_path_and_twin_agree(block: int) -> None:
    kinds: Counter[str] = Counter()
    ends: set[tuple[str, str]] = set()
    for seed in range(block * 20, block * 20 + 20):
        dialogue, played = compared(seed, shuffle=seed)
        kinds.update(dialogue.kinds)
        ends |= {(motion.text[0], motion.end.why) for motion in played.chip.motions() if motion.end}
    assert all(kinds[kind] >= 3 for kind in KINDS), dict(kinds)  # the short form meets everything, too
    assert len(ENDS - ends) <= 1, ENDS - ends


def test_shuffled_ties_change_nothing() -> None:
    for seed in range(1000, 1010):
        dialogue = made(seed)
        plain = play(dialogue)
        for shuffle in (1, 2):
            assert not differences(plain, play(dialogue, shuffle=shuffle)), explained(dialogue, [f"shuffle {shuffle}"])


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted: Counter[str] = Counter()
    for seed in range(10_000, 12_000):
        counted.update(compared(seed, shuffle=seed)[0].kinds)
    print(dict(counted))
    for kind in KINDS:
        assert counted[kind] >= 200, f"only {counted[kind]} dialogues with {kind}"


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_hash_seeds_give_the_same_edges() -> None:
    one = digests("cy545_dialogues", "1", 20_000, 20_100)
    assert one == digests("cy545_dialogues", "2", 20_000, 20_100)
    assert all(fast == slow for fast, slow in (line.split() for line in one.splitlines()))
