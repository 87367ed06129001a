"""Nothing that comes through the host port, and nothing on the other pins, stops an MC1451A or a sister of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.ensembles import few

from .fuzz_mc import PARTS, Mad, replayed, run
from .mc_misuse import OF_MOTION

OF_PORT = {
    "aborted-packet", "busy-access", "early-read", "extra-word", "illegal-command", "odd-byte", "out-of-range",
    "undocumented-command",
}  # fmt: skip
OF_STROBES = {"conflict", "late-release", "short-recovery", "short-strobe", "strobes"}
OF_RESET = {"early-reset", "short-reset"}
OF_ENCODER = {"encoder-fast", "encoder-illegal", "gear-backlog"}
OF_NONE = {"no-encoder"}


def check(part: str, operations: int, seed: int, path: Path, *, wires: bool = False) -> Mad:
    """Run it twice; strobes are replayed from their journal, too."""
    journal = str(path / "journal") if wires else None
    one = run(part, operations, seed, wires=wires, journal=journal)
    print(one.hand.operations, one.steps, dict(one.done), dict(one.findings))
    for name in one.misuses:
        assert one.done[name] > operations // 1000, f"{name} was hardly tried"
    missing = OF_PORT | (OF_STROBES if wires else set())
    assert not missing - set(one.findings), "what is wrong is told"
    assert run(part, operations, seed, wires=wires).digest() == one.digest()
    if journal is not None:
        assert replayed(journal) == one.end_state()
    return one


@pytest.mark.parametrize("part", few(reversed(PARTS), 2))
def test_a_mad_host_stops_nothing_and_can_be_repeated(part: str, tmp_path: Path) -> None:
    check(part, 800, 1, tmp_path)


def test_a_host_with_mad_strobes_stops_nothing_and_can_be_replayed(tmp_path: Path) -> None:
    check("mc1151a-e", 400, 1, tmp_path, wires=True)


@pytest.mark.long
@pytest.mark.timeout(6000)
@pytest.mark.parametrize("part", PARTS)
def test_a_million_operations_stop_nothing_and_can_be_repeated(part: str, tmp_path: Path) -> None:
    called = check(part, 150_000, 2, tmp_path)
    strobed = check(part, 17_000, 3, tmp_path, wires=True)
    found = OF_RESET | OF_MOTION - (OF_NONE if part.endswith("-e") else OF_ENCODER)
    if part == "mc1151a-e":
        found -= {"encoder-illegal"}  # the shaft at its only input never changes both channels at once
    assert not found - set(called.findings) and not OF_RESET - set(strobed.findings)
    assert called.steps > 1_000_000 and strobed.steps > 10_000
