"""A GS-C module leaves the same edges, answers and findings step by step as whole, whatever happens when."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from tests.ensembles import few

from . import gsc_dialogues
from .dialogues import differences
from .gsc_dialogues import OUTPUTS, STRAPS, Talked
from .twins import agree, hashes_are_free, ties_are_free

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


@pytest.mark.parametrize("block", few(range(10), 1))
def test_fast_path_and_twin_agree(block: int) -> None:
    agree(gsc_dialogues, range(block * 10, block * 10 + 10))


@pytest.mark.parametrize("seed", [10537, 11242])
def test_the_supply_goes_at_the_very_instant_at_which_a_line_is_done(seed: int) -> None:
    agree(gsc_dialogues, [seed])


@pytest.mark.parametrize("block", few(range(4), 1))
def test_shuffled_ties_change_nothing(block: int) -> None:
    ties_are_free(gsc_dialogues, range(1000 + block * 5, 1000 + block * 5 + 5))


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


@pytest.mark.parametrize("seed", few(range(8), 2))
def test_modules_that_wait_for_each_other_leave_the_same_edges_step_by_step(seed: int) -> None:
    fast, slow = pair(seed, stepwise=False), pair(seed, stepwise=True, shuffle=seed)
    for one, two in zip(fast, slow, strict=True):
        assert not differences(one, two)
        assert len(one.chip.steps()) > 10


@pytest.mark.long
def test_hash_seeds_change_nothing() -> None:
    hashes_are_free(gsc_dialogues, 20_000, 20_010)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted = agree(gsc_dialogues, range(10_000, 12_200))
    assert all(counted[kind] >= wanted for kind, wanted in KINDS.items()), counted


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_hundred_pairs_agree() -> None:
    for seed in range(100, 300):
        for one, two in zip(pair(seed, stepwise=False), pair(seed, stepwise=True, shuffle=seed), strict=True):
            assert not differences(one, two), seed
