"""Journals and bench files of an earlier state of the project still give, to the bit, what they gave there.

`earlier_runs/outcomes.json` was written by that state: the instant of the end, every edge of every pin as a digest,
positions, numbers of steps, registers, and findings.  New findings may come, none may go.  The CY545 has another
behaviour since: an empty handshake no longer locks out its serial side.  None of these runs had one.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import warnings
from pathlib import Path
from typing import Any

import pytest

import slewline
from slewline.bench import load
from slewline.errors import NotRecorded, OtherLaws, Timeout, WiringError

RUNS = Path(__file__).with_name("earlier_runs")
OUTCOMES = json.loads((RUNS / "outcomes.json").read_text("utf-8"))


def pins(bench: slewline.Bench, name: str) -> str:
    """Return a digest of all edges of all pins of a chip, but for its clock."""
    digest = hashlib.sha256()
    for pin in bench.chips[name].pins:
        with contextlib.suppress(NotRecorded, WiringError):  # a clock, or no signal
            times, levels = bench.edges(f"{name}.{pin}")
            digest.update(repr((pin, [int(t) for t in times], [int(v) for v in levels])).encode())
    return digest.hexdigest()[:16]


def outcome(bench: slewline.Bench) -> dict[str, Any]:
    """Return what a run has come to."""
    found = {}
    for name, chip in bench.chips.items():
        axes = [chip.axis(number) for number in range(1, len(chip.axes) + 1)]
        found[name] = {
            "axes": [{"position": axis.position, "steps": len(axis.steps())} for axis in axes],
            "pins": pins(bench, name),
            "registers": dict(chip.registers),
        }
    return {"end": bench.now_ps, "chips": found}


@pytest.mark.parametrize("name", OUTCOMES)
def test_an_earlier_run_is_the_same_to_the_bit(name: str) -> None:
    before = dict(OUTCOMES[name])
    findings = before.pop("findings")
    if name.endswith(".toml"):
        bench = load(str(RUNS / name))
        bench.record()
        with contextlib.suppress(Timeout):
            bench.run_until_idle("3 s")
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OtherLaws)
            bench = slewline.replay(RUNS / name, prepare=lambda bench: bench.record(), other_laws=True)
    assert outcome(bench) == before
    here = [f"{finding.time_ps} {finding.code}" for finding in bench.findings]
    assert [finding for finding in findings if finding not in here] == []
