"""The tables of the part in C are those of the sheet, and its pins are numbered as its header says."""

from __future__ import annotations

import re

import pytest

from slewline.chips.gs_c200.sheet import PINS
from tools import part_tables

pytestmark = pytest.mark.check

HEADER = (part_tables.FOLDER / "gsc200.h").read_text("ascii")


@pytest.mark.parametrize("path", part_tables.files(), ids=lambda path: path.name)
def test_a_table_agrees_with_the_sheet(path) -> None:
    assert path.read_text("ascii") == part_tables.files()[path], "run: python tools/part_tables.py"


def test_the_command_finds_nothing_wrong() -> None:
    assert part_tables.main(["--check"]) == 0


def test_the_header_has_the_pins_of_the_sheet() -> None:
    numbers = {pin.name.upper(): pin.number for pin in PINS}
    named = re.findall(r"GSC_([A-Z0-9]+)\b[^\n/]*/\* pin ([0-9]+)", HEADER)
    assert len(named) > 14 and {name: int(number) for name, number in named} == {
        name: numbers[name] for name, _ in named
    }
    ways = {pin.name.upper(): pin.in_out for pin in PINS}
    inputs = set(re.findall(r"GSC_([A-Z0-9]+) = 1 <<", HEADER))
    assert inputs == {name for name, way in ways.items() if way == "in"} - {"TEST", "TXPD"}
    assert {name.upper() for name in part_tables.OUTPUTS} == {n for n, way in ways.items() if way == "out"} - {
        "TXD",
        "CLOCK",
    }


def test_the_outputs_are_in_the_order_of_the_header() -> None:
    found = re.search(r"enum gsc_pin \{(.*?)\}", HEADER, re.DOTALL)
    assert found is not None
    order = re.findall(r"GSC_([A-Z0-9]+)\b", found[1])
    assert order == [*(name.upper() for name in part_tables.OUTPUTS), "TALK", "PINS"]


def test_the_header_has_the_sizes_of_the_sheet() -> None:
    sizes = dict(re.findall(r"#define GSC_(\w+) ([0-9]+)", HEADER))
    assert sizes == {"LOCATIONS": str(part_tables.sheet.LOCATIONS), "LONGEST": str(part_tables.sheet.LONGEST)}
