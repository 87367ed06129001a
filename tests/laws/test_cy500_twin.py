"""The CY500's fast path and its step-by-step twin leave the same edges on every pin, whatever happens when."""

from __future__ import annotations

from collections import Counter

import pytest

from .cy500_dialogues import KINDS, made, play
from .dialogues import Dialogue, differences
from .test_twin import explained


def compared(seed: int, shuffle: int | None = None) -> Dialogue:
    """Play a dialogue both ways and assert that nothing differs."""
    dialogue = made(seed)
    found = differences(play(dialogue), play(dialogue, stepwise=True, shuffle=shuffle))
    assert not found, explained(dialogue, found)
    return dialogue


@pytest.mark.parametrize("block", range(2))
def test_fast_path_and_twin_agree(block: int) -> None:
    for seed in range(block * 8, block * 8 + 8):
        compared(seed, shuffle=seed)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted: Counter[str] = Counter()
    for seed in range(10_000, 12_000):
        counted.update(compared(seed, shuffle=seed).kinds)
    print(dict(counted))
    for kind in KINDS:
        assert counted[kind] >= 200, f"only {counted[kind]} dialogues with {kind}"
