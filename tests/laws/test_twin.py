"""The fast path and its step-by-step twin leave the same edges on every pin, whatever happens when."""

from __future__ import annotations

from collections import Counter
from random import Random

import pytest

import slewline

from .dialogues import Dialogue, Played, differences, made, play
from .digests import digests

KINDS = ("abort", "inhibit", "rate", "read", "reset", "tie")


def explained(dialogue: Dialogue, found: list[str]) -> str:
    text = f"dialogue {dialogue.seed} at {dialogue.crystal}, {dialogue.options}: {found[:3]}"
    return f"{text}\n  sent {dialogue.sent!r}\n  events {dialogue.events}"


def compared(seed: int, shuffle: int | None = None) -> Dialogue:
    """Play a dialogue both ways and assert that nothing differs."""
    dialogue = made(seed)
    found = differences(play(dialogue), play(dialogue, stepwise=True, shuffle=shuffle))
    assert not found, explained(dialogue, found)
    return dialogue


@pytest.mark.parametrize("block", range(5))
def test_fast_path_and_twin_agree(block: int) -> None:
    for seed in range(block * 20, block * 20 + 20):
        compared(seed)


@pytest.mark.parametrize("block", range(2))
def test_shuffled_ties_change_nothing(block: int) -> None:
    for seed in range(1000 + block * 10, 1000 + block * 10 + 10):
        dialogue = made(seed)
        plain = play(dialogue)
        for shuffle in (1, 2, 3):
            assert not differences(plain, play(dialogue, shuffle=shuffle)), explained(dialogue, [f"shuffle {shuffle}"])


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


@pytest.mark.parametrize("seed", range(12))
def test_a_chip_that_inhibits_another_gives_the_same_edges_step_by_step(seed: int) -> None:
    fast, slow = follower_bench(seed, stepwise=False), follower_bench(seed, stepwise=True, shuffle=seed)
    for name, one, two in zip("xy", fast, slow, strict=True):
        assert pulses(one, name) == pulses(two, name)
    assert len(fast[1].chip.steps()) > 0


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_thousand_dialogues_agree() -> None:
    counted: Counter[str] = Counter()
    for seed in range(10_000, 12_200):
        counted.update(compared(seed, shuffle=seed).kinds)
    print(dict(counted))
    for kind in KINDS:
        assert counted[kind] >= 220, f"only {counted[kind]} dialogues with {kind}"


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_followers_agree() -> None:
    for seed in range(100, 300):
        fast, slow = follower_bench(seed, stepwise=False), follower_bench(seed, stepwise=True, shuffle=seed)
        for name, one, two in zip("xy", fast, slow, strict=True):
            assert pulses(one, name) == pulses(two, name), f"followers {seed}"


def test_hash_seeds_change_nothing() -> None:
    one = digests("dialogues", "1", 20_000, 20_010)
    assert one == digests("dialogues", "2", 20_000, 20_010)
    assert all(fast == slow for fast, slow in (line.split() for line in one.splitlines()))


@pytest.mark.long
@pytest.mark.timeout(3000)
def test_two_hash_seeds_and_a_thousand_dialogues() -> None:
    one = digests("dialogues", "11", 30_000, 31_000)
    assert one == digests("dialogues", "22", 30_000, 31_000)
    assert all(fast == slow for fast, slow in (line.split() for line in one.splitlines()))
