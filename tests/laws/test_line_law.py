"""The law of lines: characters that are taken as a line leave what they leave one by one, whoever disturbs them."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest

from slewline.core.wires.receiver import Receiver
from tests.ensembles import few

from . import exchange_lines
from .exchanges import MS, Act, differences

VARIANTS = 5  # of one dialogue
TOLD = (1, 18, 27, 42, 53, 87, 104, 207, 646, 716, 1979, 13966)  # seeds, each of which has shown a fault
ORDERS = 8  # of the tasks in each round: an act within a run may come before or after a character of its instant
QUIET = {"strapped": 9600, "baud": None, "checked": False, "addresses": (None,), "lenient": False}


def agree(seeds: range) -> Counter[str]:
    """Compare dialogues with their twins; return how often something disturbed them."""
    counted: Counter[str] = Counter()
    for seed in seeds:
        for dialogue in exchange_lines.dialogues(seed, VARIANTS):
            counted.update(act.what for act in dialogue.acts)
            recorded = dialogue.seed % 3 == 0
            fast = exchange_lines.played(dialogue, False, dialogue.seed, recorded)
            found: list[str] = []
            for order in range(ORDERS if any(act.within for act in dialogue.acts) else 1):
                twin = exchange_lines.played(dialogue, True, dialogue.seed + order, recorded or dialogue.seed % 2 == 0)
                if not (found := differences(fast, twin)):
                    break
                counted["another order"] += 1
            assert not found, f"{found[:3]}\n  {dialogue}"
    return counted


@pytest.mark.parametrize("block", few(range(10), 2))
def test_a_line_that_is_disturbed_leaves_what_single_characters_leave(block: int) -> None:
    agree(range(block * 100, block * 100 + 12))


@pytest.mark.parametrize("seed", TOLD)
def test_dialogues_that_once_parted_from_single_characters_agree(seed: int) -> None:
    agree(range(seed, seed + 1))


@pytest.mark.long
@pytest.mark.timeout(6000)
@pytest.mark.parametrize("block", range(10))
def test_ten_thousand_dialogues_agree(block: int) -> None:
    counted = agree(range(10_000 + block * 200, 10_200 + block * 200))
    assert all(counted[what] for what in ("look", "drive", "space", "hook", "got", "change_line", "power")), counted
    assert counted["another order"] < 20, counted  # else this would excuse a fault


def test_a_quiet_dialogue_takes_lines_whole_and_its_twin_none() -> None:
    """Else the law would say nothing: a line that is taken whole has fewer instants."""
    entries = {}  # of the kernel's heap
    for twin in (False, True):
        worlds = [exchange_lines.played(exchange_lines.base(seed), twin, seed, recorded=not twin) for seed in range(12)]
        entries[twin] = sum(next(world.bench.kernel.order) for world in worlds)
    assert entries[False] < 0.8 * entries[True], entries


def test_another_host_of_a_cy545_begins_in_the_instant_in_which_a_character_arrives() -> None:
    """Then the first character of a command on the line has to wait, and those after it are no part of a command."""
    dialogue = exchange_lines.Dialogue(0, "cy545b", "N 20\rR 50\r", {"fixed": 9600, "baud": 9600}, 40 * MS)
    arrived: list[int] = []
    world = exchange_lines.Told(dialogue, None)
    world.chips[0]._serial._event.net.watch(lambda net: arrived.append(net.kernel.now))
    taken, Receiver.whole_lines = Receiver.whole_lines, False
    try:
        world.play()
    finally:
        Receiver.whole_lines = taken
    assert len(arrived) >= 10
    for at in arrived:
        acts = [Act(at, "parallel", (0x4E,), within=True)]
        pair = [exchange_lines.played(replace(dialogue, acts=acts), twin, 0, False) for twin in (False, True)]
        assert not differences(*pair)


@pytest.mark.parametrize("how", ["got", "function"])
def test_an_observer_added_in_the_middle_of_a_line_stops_at_the_character(how: str) -> None:
    """Not when the line is over, which is when the receiver would have been woken."""
    stopped = []
    for twin in (False, True):
        dialogue = exchange_lines.Dialogue(0, "gs-c200s", "V1\r", QUIET)
        whole, Receiver.whole_lines = Receiver.whole_lines, not twin
        try:
            world = exchange_lines.Told(dialogue, None)
            world.bench.run_until(world.pins["x.txd"].is_(1))  # the answer begins
            world.bench.run("100 us")
            if how == "got":
                world.bench.run_until(world.host.got("V+"))
            else:
                world.bench.run_until(lambda world=world: len(world.host.received) == 2)  # type: ignore[misc]
            stopped.append([world.bench.now_ps, len(world.host.received)])
        finally:
            Receiver.whole_lines = whole
    assert stopped[0] == stopped[1]
