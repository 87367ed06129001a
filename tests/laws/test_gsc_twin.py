"""A GS-C module leaves the same edges, answers and findings step by step as whole, whatever happens when."""

from __future__ import annotations

from collections import Counter
from random import Random

import pytest

import slewline

from .dialogues import differences
from .digests import digests
from .gsc_dialogues import OUTPUTS, STRAPS, Dialogue, Talked, made, play

KINDS = {
    "tie": 1000,
    "enable": 400,
    "held": 200,
    "input": 400,
    "line": 600,
    "switch": 200,
    "power": 100,
    "K": 150,
    "Z": 300,
}


def explained(dialogue: Dialogue, found: list[str]) -> str:
    return f"{found[:3]}\n  {dialogue}"


def compared(seed: int, shuffle: int | None = None) -> Dialogue:
    """Play a dialogue both ways and assert that nothing differs."""
    dialogue = made(seed)
    found = differences(play(dialogue), play(dialogue, stepwise=True, shuffle=shuffle))
    assert not found, explained(dialogue, found)
    return dialogue


@pytest.mark.parametrize("block", range(5))
def test_fast_path_and_twin_agree(block: int) -> None:
    for seed in range(block * 20, block * 20 + 20):
        compared(seed, shuffle=seed)


@pytest.mark.parametrize("seed", [10537, 11242])
def test_the_supply_goes_at_the_very_instant_at_which_a_line_is_done(seed: int) -> None:
    compared(seed, shuffle=seed)


@pytest.mark.parametrize("block", range(2))
def test_shuffled_ties_change_nothing(block: int) -> None:
    for seed in range(1000 + block * 10, 1000 + block * 10 + 10):
        dialogue = made(seed)
        plain = play(dialogue)
        for shuffle in (1, 2):
            assert not differences(plain, play(dialogue, shuffle=shuffle)), explained(dialogue, [f"shuffle {shuffle}"])


def pair(seed: int, stepwise: bool, shuffle: int | None = None) -> list[Talked]:
    """Two modules that wait for each other: MOV of one is the ENABLE of the other, which gates its input in return."""
    rnd = Random(seed)
    bench = slewline.Bench(shuffle=shuffle)
    modules = [bench.add(rnd.choice(("gs-c200", "gs-c200s")), name, straps=STRAPS, stepwise=stepwise) for name in "xy"]
    bench.wire("x.mov", "y.enable")
    bench.wire("y.ramp", "x.ui1", invert=True)
    bench.record(*(f"{name}.{pin}" for name in "xy" for pin in OUTPUTS))
    hosts = [bench.host(module) for module in modules]
    for module, host in zip(modules, hosts, strict=True):
        run = "g+1" if module.sheet.part == "gs-c200s" else "G+1"
        host.ask("Po" if module.sheet.part == "gs-c200s" else "P")
        ramp = [f"S{rnd.choice((20, 50, 100))}", f"T{rnd.choice((50, 200, 500))}", f"R{rnd.choice((1, 5, 30))}"]
        for line in (*ramp, "L0", run if host is hosts[0] else "+9", f"+{rnd.randrange(1, 80)}", "D1", "L3"):
            assert host.ask(line) == "Y", line
    for host in hosts:
        host.ask("E")
    bench.run("2 s")
    return [Talked(bench, module, host) for module, host in zip(modules, hosts, strict=True)]


@pytest.mark.parametrize("seed", range(8))
def test_modules_that_wait_for_each_other_leave_the_same_edges_step_by_step(seed: int) -> None:
    fast, slow = pair(seed, stepwise=False), pair(seed, stepwise=True, shuffle=seed)
    for one, two in zip(fast, slow, strict=True):
        assert not differences(one, two)
        assert len(one.chip.steps()) > 10


def test_hash_seeds_change_nothing() -> None:
    one = digests("gsc_dialogues", "1", 20_000, 20_010)
    assert one == digests("gsc_dialogues", "2", 20_000, 20_010)
    assert all(fast == slow for fast, slow in (line.split() for line in one.splitlines()))


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted: Counter[str] = Counter()
    for seed in range(10_000, 12_200):
        counted.update(compared(seed, shuffle=seed).kinds)
    print(dict(counted))
    assert all(counted[kind] >= wanted for kind, wanted in KINDS.items()), counted


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_hundred_pairs_agree() -> None:
    for seed in range(100, 300):
        for one, two in zip(pair(seed, stepwise=False), pair(seed, stepwise=True, shuffle=seed), strict=True):
            assert not differences(one, two), seed
