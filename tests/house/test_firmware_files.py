"""The files of the firmware: what boards have in common knows no processor, and no two of them need each other."""

from __future__ import annotations

import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2] / "firmware"
MOST = 400  # lines
OF_A_BOARD = {"board.h", "limits.h"}
SYSTEM = {"stdint.h", "string.h"}

pytestmark = pytest.mark.check


def files(folder: str) -> list[Path]:
    """The files of a folder."""
    found = sorted((ROOT / folder).iterdir())
    assert len(found) > 3
    return found


def included(path: Path) -> set[str]:
    """The headers that a file names."""
    return set(re.findall(r'^#include ["<](.+)[">]', path.read_text("ascii"), re.MULTILINE))


def circles(folder: str) -> None:
    """Sort files, a header and its source as one, so that each needs earlier ones alone.

    Raises:
        graphlib.CycleError: that cannot be done.
    """
    needs: dict[str, set[str]] = {}
    for path in files(folder):
        stems = {Path(name).stem for name in included(path) if (ROOT / folder / name).exists()}
        needs.setdefault(path.stem, set()).update(stems - {path.stem})
    assert any(needs.values())
    list(TopologicalSorter(needs).static_order())


@pytest.mark.parametrize("folder", ["common", "uno", "pc", "part/gs_c200", "pico"])
def test_no_file_is_long(folder: str) -> None:
    lines = {path.name: len(path.read_text("ascii").splitlines()) for path in files(folder)}
    assert not {name: count for name, count in lines.items() if count > MOST}


@pytest.mark.parametrize("folder", ["common", "part/gs_c200", "pico"])
def test_no_circle_of_files(folder: str) -> None:
    circles(folder)


def test_a_part_knows_no_processor_and_no_board() -> None:
    own = {path.name for path in files("part/gs_c200")}
    for path in files("part/gs_c200"):
        assert included(path) <= own | SYSTEM | {"stdbool.h", "math.h"}, path


def test_the_pico_needs_nothing_but_its_own_files_and_the_part() -> None:
    own = {path.name for path in files("pico")}
    for path in files("pico"):
        assert included(path) <= own | SYSTEM | {"stdbool.h", "stddef.h", "gsc200.h"}, path


def test_the_page_of_the_pico_has_all_of_its_sources() -> None:
    page = (ROOT.parent / "docs/reference/pico.md").read_text("utf-8")
    table = set(re.findall(r"`(\w+\.[cS])`", page))
    assert table == {path.name for path in files("pico") if path.suffix in (".c", ".S")}


@pytest.mark.parametrize("folder", ["common", "uno", "pc", "part/gs_c200", "pico"])
def test_nothing_is_from_others(folder: str) -> None:
    for path in files(folder):
        text = path.read_text("ascii")
        assert not re.search(r"copyright|\(c\)|spdx|licen[cs]e|@author|all rights", text, re.IGNORECASE), path


def test_common_files_are_independent_of_processors() -> None:
    own = {path.name for path in files("common")}
    for path in files("common"):
        assert included(path) <= own | OF_A_BOARD | SYSTEM, path
        assert not re.search(
            r"\b(PORT|PIN|DDR|TCCR|OCR|TIFR|TCNT|UCSR|UDR)[A-D0-9]|__AVR|\bcli\(|\bsei\(", path.read_text("ascii")
        )


def test_no_content_of_a_frame_is_taken_for_a_struct() -> None:
    for path in files("common"):
        assert not re.search(r"\(\s*(const\s+)?(struct\s+\w+|u?int(16|32)_t)\s*\*\s*\)", path.read_text("ascii")), path


def test_every_function_of_a_board_is_used() -> None:
    declared = set(re.findall(r"\b(hal_\w+)\(", (ROOT / "common" / "hal.h").read_text("ascii")))
    others = "".join(path.read_text("ascii") for path in files("common") if path.name != "hal.h")
    assert declared == set(re.findall(r"\b(hal_\w+)\(", others)) | {"hal_now"}
