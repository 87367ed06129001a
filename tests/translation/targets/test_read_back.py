"""Translations for all targets, read back by parsers that share no code with the writers, beside what the part does."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from slewline.translation.proof import prove
from slewline.translation.proof.compare_runs import compared
from slewline.translation.proof.play import Played
from slewline.translation.reading_back.surroundings import RefusedLine
from slewline.translation.source_text.reading import read_program
from slewline.translation.target_writer import PlayedTrace, WriterOptions
from slewline.translation.translate import translate
from slewline.translation.translation_report import LineKind
from slewline.translation.writers import TARGETS, target

PROGRAMS = Path(__file__).parents[3] / "examples" / "programs"
FILES = sorted(path for path in PROGRAMS.iterdir() if path.suffix in (".cy525", ".gs-c200", ".gs-c200s"))
WITHOUT_INPUTS = ("grbl",)  # where the source waits, it differs, and says so


@cache
def source(path: Path) -> Played:
    """Return what the part does."""
    text = path.read_text("utf-8")
    return prove.played(read_program(text, path.suffix[1:], path.name), text)


def read_back(path: Path, name: str, **values: object) -> tuple[PlayedTrace, object]:
    """Return what a translation does, with inputs that change as at the part, and the translation."""
    done = translate(path, to=name, **values)  # type: ignore[arg-type]
    around = prove.around(prove.scene_of(done.program), source(path))
    options = replace(done.options, values={**done.options.values, **around})
    trace = target(name).read_back(done.text, options)
    assert trace is not None
    return trace, done


@pytest.mark.parametrize("name", TARGETS)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_moves_outputs_and_inputs_come_in_the_order_of_the_part(path, name):
    trace, done = read_back(path, name)
    found = compared(source(path).trace, trace, prove.bounds_of(done.program, done.report))
    assert found.proven or (name in WITHOUT_INPUTS and done.report.counts[LineKind.IMPOSSIBLE]), found.text


@pytest.mark.parametrize("name", TARGETS)
@pytest.mark.parametrize("steps_per_mm", [80, 1.27, 5079.9])
def test_steps_are_exact_with_any_number_of_them_a_millimetre(steps_per_mm, name):
    path = PROGRAMS / "two_ramps.gs-c200"
    trace, _ = read_back(path, name, steps_per_mm=steps_per_mm)
    assert [each.value for each in trace.happened if each.kind == "move"] == [3000, -800]


@pytest.mark.parametrize("name", TARGETS)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_each_meaningful_line_has_a_verdict(path, name):
    done = translate(path, to=name)
    judged = {verdict.line for line in done.report for verdict in line.verdicts}
    for line in done.program.lines:
        if line.actions and name != "grbl":  # which leaves out what it cannot decide
            entry = {type(action).__name__ for action in line.actions} <= {"EnterProgram", "LeaveProgram", "Label"}
            assert line.number in judged or entry, line
    for line in done.report:
        for verdict in line.verdicts:
            if verdict.kind is LineKind.IMPOSSIBLE:
                assert verdict.limit and verdict.remedy, verdict


@pytest.mark.parametrize("name", TARGETS)
def test_comments_are_kept(name):
    done = translate(PROGRAMS / "weld.cy525", to=name)
    assert "WAIT high: a workpiece is in place." in done.text


BAD = {
    "grbl": ["G91 G1 X5", "F60\nG1 X[1+2]", "G61.1", "M66 P0 L3", "F60 F70", "G4", "G90 G91", "F60\nG1 X" + "0" * 90],
    "linuxcnc": ["G91 G1 X5", "G21 F60 G1 X[1 +", "o1 while [1]", "#<x> = #<y>", "G38.9 X1", "o<a> call", "M66 P0 L3"],
    "klipper": ["[extruder]", "step_pin PA0", "[gcode_macro PROGRAM]\ngcode:\n  MANUAL_STEPPER STEPPER=axis MOVE=1"],
    "tmcl": ["MVP ABS, 0", "JA Nowhere", "SAP 5, 0, 3", "MVP 1, 0, 2", "FLY 1", "A:\nA:", "SGP 1, 0, 2", "RSUB"],
    "arduino": ["void setup() { moveBy(5); }", "#include <Servo.h>", "void setup() { x = 5; }", "@"],
    "python": [
        "def main(grbl:",
        "class Grbl:\n    pass",
        "import os\nclass Grbl:\n    pass\ndef main(grbl):\n    os.x()",
    ],
}


@pytest.mark.parametrize(("name", "text"), [(name, text) for name, texts in BAD.items() for text in texts])
def test_a_reader_refuses_what_its_target_would_refuse(name, text):
    with pytest.raises((RefusedLine, KeyError)):
        target(name).read_back(text, WriterOptions())
