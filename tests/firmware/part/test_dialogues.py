"""The core and the model in the same dialogues: bytes, steps and every output, to the picosecond."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from . import cases, dialogues, library

pytestmark = pytest.mark.system

SOME = 1000


@pytest.mark.timeout(300)
def test_random_dialogues(core):
    found = dialogues.run(core, range(SOME))
    assert not found.difference
    assert found.answers > 25 * SOME and found.steps > 100 * SOME and found.edges > 500 * SOME


@pytest.mark.parametrize("part", dialogues.PARTS)
@pytest.mark.parametrize("script", [script for _, script in cases.CASES], ids=[name for name, _ in cases.CASES])
def test_boundaries(core, script, part):
    case = cases.Case(part, script)
    case.play()
    found = case.compare(core)
    assert not found.difference
    assert found.answers > 0


def broken(tmp_path: Path, file: str, old: str, new: str) -> library.Library:
    """Return the core with a change in one place."""
    copy = tmp_path / "core"
    copy.mkdir()
    for path in library.CORE.iterdir():
        text = path.read_text("ascii")
        if path.name == file:
            assert text.count(old) == 1
            text = text.replace(old, new)
        (copy / path.name).write_text(text, "ascii")
    return library.Library(library.build(tmp_path, copy, ("-O1", "-w", "-std=c11", "-ffp-contract=off")))


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("sheet.h", "#define DIR_SETUP_PS 10000000ULL", "#define DIR_SETUP_PS 10000001ULL"),
        ("sheet.h", "#define TURNROUND_PS 1000000000ULL", "#define TURNROUND_PS 1000000001ULL"),
        ("sheet.c", "{4800, 2291666666ULL}", "{4800, 2291666667ULL}"),
        ("profile.c", "return whole + (rest > 0.5", "return whole + (rest > 0.6"),
        ("serial.c", "if (g->serial.waiting < 2)", "if (g->serial.waiting < 3)"),
        ("motion.c", "start_timer(g, GSC_RUN_TIMER, RELEASE_PS);", "start_timer(g, GSC_RUN_TIMER, CLOCK_PS);"),
        ("part.c", "    obey_strings(g);\n    run_settled(g);", "    run_settled(g);\n    obey_strings(g);"),
    ],
)
def test_a_change_of_the_core_is_noticed(tmp_path, file, old, new):
    library.need()
    core = broken(tmp_path, file, old, new)
    assert any(dialogues.converse(core, seed).difference for seed in range(400))


def test_a_difference_is_reported_with_place_and_kind(tmp_path):
    library.need()
    core = broken(tmp_path, "sheet.h", "#define RESET_PS 400000000ULL", "#define RESET_PS 400000007ULL")
    found = dialogues.converse(core, 0)
    assert re.fullmatch(r"seed 0, m0 \(gs-c200s?\): .*", found.difference)
