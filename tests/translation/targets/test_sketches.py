"""Sketches, on an emulated Uno."""

from __future__ import annotations

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
def test_steps_and_end_position_are_those_of_the_part(case, core, tmp_path):
    found = seen(case, core, tmp_path, until=2.0 if case.until else 30.0)
    agree(stretches(found.steps), of_part(case, tmp_path), case)


@pytest.mark.parametrize("case", SHORT, ids=lambda case: case.file)
def test_what_is_read_back_is_what_the_board_does(case, core, tmp_path):
    read = target("arduino").read_back(written(case, "arduino"), case.options)
    agree(stretches(seen(case, core, tmp_path, until=2.0 if case.until else 30.0).steps), of_trace(read), case)


@pytest.mark.parametrize("case", SHORT, ids=lambda case: case.file)
def test_both_libraries_make_the_same_steps(case, core, tmp_path):
    until = 1.0 if case.until else 30.0
    one = seen(case, core, tmp_path, until, library="accelstepper")
    other = seen(case, core, tmp_path, until, library="fastaccelstepper")
    agree(stretches(one.steps), stretches(other.steps), case)
