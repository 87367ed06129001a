"""The law of lines: characters that are taken as a line leave what they leave one by one, whoever disturbs them."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.ensembles import few

from . import exchange_lines
from .exchanges import differences

VARIANTS = 5  # of one dialogue


def agree(seeds: range) -> Counter[str]:
    """Compare dialogues with their twins; return how often something disturbed them."""
    counted: Counter[str] = Counter()
    for seed in seeds:
        for dialogue in exchange_lines.dialogues(seed, VARIANTS):
            counted.update(act.what for act in dialogue.acts)
            recorded = dialogue.seed % 3 == 0
            fast = exchange_lines.played(dialogue, False, dialogue.seed, recorded)
            twin = exchange_lines.played(dialogue, True, dialogue.seed, recorded or dialogue.seed % 2 == 0)
            found = differences(fast, twin)
            assert not found, f"{found[:3]}\n  {dialogue}"
    return counted


@pytest.mark.parametrize("block", few(range(10), 2))
def test_a_line_that_is_disturbed_leaves_what_single_characters_leave(block: int) -> None:
    agree(range(block * 100, block * 100 + 12))


@pytest.mark.long
@pytest.mark.timeout(6000)
@pytest.mark.parametrize("block", range(10))
def test_ten_thousand_dialogues_agree(block: int) -> None:
    counted = agree(range(10_000 + block * 200, 10_200 + block * 200))
    assert all(counted[what] for what in ("look", "drive", "space", "hook", "got", "change_line", "power")), counted


def test_a_quiet_dialogue_takes_lines_whole_and_its_twin_none() -> None:
    """Else the law would say nothing: a line that is taken whole has fewer instants."""
    entries = {}  # of the kernel's heap
    for twin in (False, True):
        worlds = [exchange_lines.played(exchange_lines.base(seed), twin, seed, recorded=not twin) for seed in range(12)]
        entries[twin] = sum(next(world.bench.kernel.order) for world in worlds)
    assert entries[False] < 0.8 * entries[True], entries
