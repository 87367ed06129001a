"""Runs that an earlier state of the project played give the same edges, positions, findings and waveforms, to the bit.

`kept_runs/outcomes.json` was written by that state, except for the findings of an MC1451A: at that time stalls and
refused commands were none.  An intended change of behaviour writes the rows of its runs again and gives the reason; a
change of structure changes none.
"""

from __future__ import annotations

import json
from itertools import chain

import pytest

from . import kept

OUTCOMES = json.loads(kept.TABLE.read_text("utf-8"))
PARTS = "cy500 cy512 cy525 cy545 cy545b gs-c200 gs-c200s mc1151a mc1251a mc1451a mc1151a-e mc1251a-e mc1451a-e"


def test_every_run_that_was_kept_has_its_outcome():
    assert kept.names() == sorted(OUTCOMES)


@pytest.mark.parametrize("name", OUTCOMES)
def test_a_kept_run_with_all_pins_recorded_is_the_same_to_the_bit(name):
    assert kept.recorded(name) == OUTCOMES[name]


@pytest.mark.parametrize("name", OUTCOMES)
def test_a_kept_run_of_which_nothing_is_recorded_comes_to_the_same(name):
    found = kept.unrecorded(name)
    assert found == {key: OUTCOMES[name][key] for key in found}


def test_every_chip_is_in_a_kept_run_and_steps():
    moved = {
        part
        for run in OUTCOMES.values()
        for name, part in run["parts"].items()
        if any(steps for _, steps, _ in run["axes"][name])
    }
    assert moved == set(PARTS.split())


def test_kept_runs_are_small():
    assert sum(path.stat().st_size for path in kept.RUNS.iterdir()) < 300_000


def test_kept_runs_have_steps_findings_and_edges_of_parts():
    assert sum(axis[1] for run in OUTCOMES.values() for axis in chain(*run["axes"].values())) > 50_000
    codes = {finding.split()[1] for run in OUTCOMES.values() for finding in run["findings"]}
    assert {"steps-lost", "hard-stop", "motion-error", "E1", "E4"} <= codes
    assert sum(len(run["edges"]) for run in OUTCOMES.values()) > 90
