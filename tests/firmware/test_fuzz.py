"""What boards have in common, with frames at random: laws that hold whatever a host sends, under sanitizers."""

from __future__ import annotations

import re
import subprocess

import pytest

from tools.firmware import build_on_pc

from . import needs

pytestmark = pytest.mark.system

SOME, ALL = 200_000, 10_000_000  # frames
SEEDS = 10


@pytest.fixture(scope="module")
def fuzz(tmp_path_factory):
    needs.need()
    return build_on_pc(tmp_path_factory.mktemp("fuzz"), "fuzz")


def fuzzed(program, seed, frames):
    """Return what it counts: frames, taken, steps, of them with an edge, times on."""
    ran = subprocess.run([program, str(seed), str(frames)], capture_output=True, text=True, check=False, timeout=500)
    assert (ran.returncode, ran.stderr) == (0, ""), f"seed {seed}: {ran.stderr}"
    return [int(number) for number in re.findall("[0-9]+", ran.stdout)]


def enough(counts, frames):
    """A law about what never happens would say nothing."""
    seen, taken, steps, edges, on = counts
    assert seen == frames and frames / 3 < taken < frames
    assert frames / 10 < edges < steps and on > frames / 200


def test_some_frames(fuzz):
    for seed in range(1, 1 + SEEDS):
        enough(fuzzed(fuzz, seed, SOME // SEEDS), SOME // SEEDS)


@pytest.mark.long
@pytest.mark.timeout(900)
def test_ten_million_frames(fuzz):
    for seed in range(101, 101 + SEEDS):
        enough(fuzzed(fuzz, seed, ALL // SEEDS), ALL // SEEDS)
