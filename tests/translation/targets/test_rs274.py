"""Translations for LinuxCNC, in LinuxCNC's own interpreter."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from slewline.translation.reading_back import rs274
from slewline.translation.reading_back.surroundings import RefusedLine
from slewline.translation.target_writer import WriterOptions
from slewline.translation.writers import target

from .ten import TEN, agree, of_part, of_trace, written

pytestmark = pytest.mark.system


UNPACKED = Path(os.environ.get("SLEWLINE_INTERPRETERS", Path(__file__).parents[3] / "build" / "interpreters")) / "rs274"


@pytest.fixture(autouse=True)
def interpreter(monkeypatch):
    """Skip the test without rs274; in CI that is a failure."""
    if UNPACKED.exists():
        monkeypatch.setenv("SLEWLINE_RS274", str(UNPACKED))
    if rs274.command() is None:
        reason = "rs274 of LinuxCNC: not installed; this does it:  make interpreters"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(reason)


@pytest.mark.parametrize("case", TEN, ids=lambda case: case.file)
def test_steps_and_end_position_are_those_of_the_part(case, tmp_path):
    trace = target("linuxcnc").ran(written(case, "linuxcnc"), case.options)
    agree(of_trace(trace), of_part(case, tmp_path), case)


@pytest.mark.parametrize("case", TEN, ids=lambda case: case.file)
def test_a_program_read_back_agrees_with_rs274(case):
    text = written(case, "linuxcnc")
    to = target("linuxcnc")
    ran, read = to.ran(text, case.options), to.read_back(text, case.options)
    of_both = ("move", "output", "delay")  # rs274 prints no waits
    mine = [(each.kind, each.number, each.value) for each in read.happened if each.kind in of_both]
    its = [(each.kind, each.number, each.value) for each in ran.happened]
    assert (ran.stopped, read.stopped) == (bool(case.until), bool(case.until))
    both = min(len(mine), len(its)) if case.until else None
    assert mine[:both] == its[:both]


@pytest.mark.parametrize("line", ["G1 X5", "F60\nG77 X1", "F60\nG1 X[1 +", "G1 X1 F#<_nothing>"])
def test_both_refuse_an_invalid_program(line):
    to = target("linuxcnc")
    text = f"G21 G90 G94\n{line}\nM2\n"
    with pytest.raises(RefusedLine):
        to.ran(text, WriterOptions())
    with pytest.raises(RefusedLine):
        to.read_back(text, WriterOptions())
