"""The law of lines: characters that are taken as a line leave what they leave one by one, whoever disturbs them."""

from __future__ import annotations

from collections import Counter

import pytest

from slewline.core.wires.characters import Receiver
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


def test_a_quiet_dialogue_takes_lines_whole_and_its_twin_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the law would say nothing."""
    counted: Counter[str] = Counter()
    passed, single = Receiver._take, Receiver._character

    def counting(receiver: Receiver, *what: object) -> None:
        counted["line"] += 1
        passed(receiver, *what)  # type: ignore[arg-type]

    async def alone(receiver: Receiver) -> object:
        counted["character"] += 1
        return await single(receiver)

    monkeypatch.setattr(Receiver, "_take", counting)
    monkeypatch.setattr(Receiver, "_character", alone)
    for seed in range(12):
        exchange_lines.played(exchange_lines.base(seed), False, seed, recorded=True)
    assert counted["line"] > 30 and counted["character"] < counted["line"], counted
    whole = counted["line"]
    for seed in range(12):
        exchange_lines.played(exchange_lines.base(seed), True, seed, recorded=False)
    assert counted["line"] == whole
