"""A chip's fast path and its step-by-step twin: what every family of dialogues is put through.

A family is a module beside this one: `made(seed)` draws a dialogue, `play(dialogue)` plays it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from types import ModuleType
from typing import Any

from .dialogues import Played, differences
from .digests import digests


def compared(family: ModuleType, dialogue: Any, shuffle: int | None = None) -> Played:
    """Play a dialogue both ways and assert that nothing differs; return the fast way."""
    fast = family.play(dialogue)
    found = differences(fast, family.play(dialogue, stepwise=True, shuffle=shuffle))
    assert not found, f"{found[:3]}\n  {dialogue}"
    return fast


def agree(family: ModuleType, seeds: Iterable[int]) -> Counter[str]:
    """Compare dialogues, the ties of the twin shuffled; return how many there were of each kind."""
    counted: Counter[str] = Counter()
    for seed in seeds:
        dialogue = family.made(seed)
        compared(family, dialogue, seed)
        counted.update(dialogue.kinds)
    return counted


def ties_are_free(family: ModuleType, seeds: Iterable[int], shuffles: int = 2) -> None:
    """Assert that the fast path does the same in whatever order what is at one instant comes."""
    for seed in seeds:
        dialogue = family.made(seed)
        plain = family.play(dialogue)
        for shuffle in range(1, shuffles + 1):
            found = differences(plain, family.play(dialogue, shuffle=shuffle))
            assert not found, f"shuffle {shuffle}: {found[:3]}\n  {dialogue}"


def hashes_are_free(family: ModuleType, first: int, last: int) -> None:
    """Assert that dialogues `first` to `last` - 1 come out the same under another hash seed of Python."""
    name = family.__name__.rpartition(".")[2]
    one = digests(name, "1", first, last)
    assert one == digests(name, "2", first, last)
    assert len(one.splitlines()) == last - first
    assert all(fast == slow for fast, slow in (line.split() for line in one.splitlines()))
