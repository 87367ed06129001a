"""The fast path and its step-by-step twin leave the same edges on every pin, whatever happens when."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from tests.ensembles import few

from . import dialogues
from .dialogues import Played
from .twins import agree, hashes_are_free, ties_are_free

KINDS = ("abort", "inhibit", "rate", "read", "reset", "tie")


@pytest.mark.parametrize("block", few(range(5), 1))
def test_fast_path_and_twin_agree(block: int) -> None:
    agree(dialogues, range(block * 20, block * 20 + 20))


@pytest.mark.parametrize("block", few(range(4), 1))
def test_shuffled_ties_change_nothing(block: int) -> None:
    ties_are_free(dialogues, range(1000 + block * 5, 1000 + block * 5 + 5), shuffles=3)


def follower_bench(seed: int, stepwise: bool, shuffle: int | None = None) -> tuple[Played, Played]:
    """Two chips, the PULSE of the first on the STEP INHIBIT of the second; random motions on both."""
    rnd = Random(seed)
    bench = slewline.Bench(shuffle=shuffle)
    x = bench.add("cy525", "x", rnd.choice(("11 MHz", "6 MHz")), stepwise=stepwise)
    y = bench.add("cy525", "y", rnd.choice(("11 MHz", "5 MHz")), stepwise=stepwise)
    bench.wire("x.pulse", "y.step_inhibit")
    hosts = [bench.host(chip) for chip in (x, y)]
    bench.record(*(f"{name}.{pin}" for name in "xy" for pin in ("pulse", "slew", "ready", "motion_complete", "phase1")))
    for host in hosts:
        rates = f"F {rnd.choice((10, 40, 127))}\rR {rnd.choice((40, 100, 127))}\rS {rnd.choice((250, 255))}\rZ 1\r"
        host.send(f"A 0\r{rates}N {rnd.randrange(1, 400)}\r{rnd.choice('+-')}\rG\rG\r")
    bench.run("200 ms")
    return Played(bench, x), Played(bench, y)


def pulses(played: Played, name: str) -> list[object]:
    return [
        part.tolist()
        for pin in ("pulse", "slew", "ready", "motion_complete", "phase1")
        for part in played.bench.edges(f"{name}.{pin}")
    ]


@pytest.mark.parametrize("seed", few(range(12), 4))
def test_a_chip_that_inhibits_another_gives_the_same_edges_step_by_step(seed: int) -> None:
    fast, slow = follower_bench(seed, stepwise=False), follower_bench(seed, stepwise=True, shuffle=seed)
    for name, one, two in zip("xy", fast, slow, strict=True):
        assert pulses(one, name) == pulses(two, name)
    assert len(fast[1].chip.steps()) > 0


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted = agree(dialogues, range(10_000, 12_200))
    assert all(counted[kind] >= 220 for kind in KINDS), counted


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_followers_agree() -> None:
    for seed in range(100, 300):
        fast, slow = follower_bench(seed, stepwise=False), follower_bench(seed, stepwise=True, shuffle=seed)
        for name, one, two in zip("xy", fast, slow, strict=True):
            assert pulses(one, name) == pulses(two, name), f"followers {seed}"


@pytest.mark.system
def test_hash_seeds_change_nothing() -> None:
    hashes_are_free(dialogues, 20_000, 20_010)


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_hash_seeds_and_a_thousand_dialogues() -> None:
    hashes_are_free(dialogues, 30_000, 31_000)
