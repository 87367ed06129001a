"""Sketches, on an emulated Uno."""

from __future__ import annotations

import re

import pytest

from slewline.translation.writers import target

from . import sketches
from .ten import TEN, Case, agree, of_part, of_trace, stretches, written

pytestmark = pytest.mark.system
SHORT = [case for case in TEN if case.file != "long_move.gs-c200"]  # 500 s
INPUTS = {"wait": 14, "dowhile": 15}


@pytest.fixture(scope="session")
def core(tmp_path_factory):
    """Arduino's core, compiled."""
    sketches.need()
    return sketches.build_core(tmp_path_factory.mktemp("core"))


def seen(case: Case, core, folder, until=30.0, **values) -> sketches.Seen:
    """Return what an Uno does with a translation."""
    text = written(case, "arduino", **values)
    library = "FastAccelStepper" if "FastAccelStepper" in text else "AccelStepper"
    inputs = [[0, INPUTS[pin], level] for pin, level in case.levels.items()]
    hexadecimal = sketches.build(text, core, folder)
    return sketches.run(hexadecimal, sketches.PINS[library], until, inputs)


@pytest.mark.parametrize("case", SHORT, ids=lambda case: case.file)
def test_steps_and_end_position_are_those_of_the_part_and_of_the_reader(case, core, tmp_path):
    found = stretches(seen(case, core, tmp_path, until=2.0 if case.until else 30.0).steps)
    agree(found, of_part(case, tmp_path), case)
    agree(found, of_trace(target("arduino").read_back(written(case, "arduino"), case.options)), case)


@pytest.mark.parametrize("case", SHORT[:5], ids=lambda case: case.file)
def test_both_libraries_make_the_same_steps(case, core, tmp_path):
    one = seen(case, core, tmp_path, library="accelstepper")
    other = seen(case, core, tmp_path, library="fastaccelstepper")
    agree(stretches(one.steps), stretches(other.steps), case)


def test_times_are_those_of_the_report(core, tmp_path):
    case = next(each for each in SHORT if each.file == "two_ramps.gs-c200")
    found = seen(case, core, tmp_path)
    stated = [
        each
        for each in target("arduino").write(case.program(), case.options).verdicts
        if "instead of" in each.description
    ]
    out = found.times[2999] - found.times[0]
    shown = re.search(r"([\d.]+) s instead of ([\d.]+) s", stated[0].description)
    assert shown and out == pytest.approx(float(shown[1]), rel=0.02)
    assert abs(out - float(shown[2])) <= stated[0].off_ps / 1e12 + 0.02 * out
