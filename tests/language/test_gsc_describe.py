"""The reference of the GS-C modules that is made from the sheet: lines instead of letters."""

from __future__ import annotations

import pytest

from slewline.chips import sheet_of
from slewline.errors import UnknownName
from slewline.language.describe import describe
from slewline.language.lines import usage
from tests.rows import rows

SHEETS = {part: sheet_of(part) for part in ("gs-c200", "gs-c200s")}
PAGES = {part: describe(sheet) for part, sheet in SHEETS.items()}
each = pytest.mark.parametrize("part", SHEETS)


@each
def test_every_command_has_its_row(part):
    commands = PAGES[part].partition("## Commands that act immediately")[0].splitlines()
    for row in SHEETS[part].commands:
        (line,) = [line for line in commands if line.startswith(f"| `{usage(row)}` | {row.name} |")]
        assert f"| {row.description} |" in line and f"| {row.size} |" in line
    assert len([line for line in PAGES[part].splitlines() if "command descriptions |" in line]) >= len(
        SHEETS[part].commands
    )


@each
def test_every_pin_register_and_time_is_there_and_no_crystal(part):
    sheet, page = SHEETS[part], PAGES[part]
    for pin in sheet.pins:
        assert f"| {pin.number} | `{pin.name}` | {pin.in_out} | {pin.description} |" in page
    for register in sheet.registers:
        assert f"| `{register.name}` | {register.description} |" in page
    for name, time in sheet.times.items():
        assert f"| `{name}` | {time.description} | {time.us:.10g} | {time.where} | {time.trust} |" in page
    assert "MHz" not in page and "- program buffer: 119 locations\n" in page


@each
def test_the_serial_port(part):
    page = PAGES[part]
    assert "7 data bits, odd parity, 2 stop bits; lines of up to 11 characters; checksums while `chs` is high" in page
    assert "| `br0` | `br1` | `br2` | baud |" in page and "| 1 | 1 | 1 | 110 |" in page
    assert "| `sel2` | `sel1` | `sel0` | address |" in page
    assert "| 0 | 1 | 1 | 1 |" in page and "| 1 | 1 | 1 | none: a dedicated line |" in page
    assert "| `E3` | program memory full |" in page


@each
def test_tables_are_even(part):
    for block in PAGES[part].split("\n\n"):
        if block.startswith("|"):
            assert len({line.count("|") for line in block.splitlines()}) == 1


def test_one_command():
    assert describe(SHEETS["gs-c200s"], "jc").splitlines() == [
        "# JUMP_ON: continue at a location if the user inputs match",
        "",
        "- line: `jc<inputs>,<target>`",
        "- accepted: during program entry (stored)",
        "- program memory: 2 locations, opcode 80 to 87",
        "- manual: command descriptions",
        "- `inputs`: 0..7",
        "- `target`: 0..118",
    ]


@rows(
    ("part", "command", "names"),
    [
        ("gs-c200", "G", ["GOTO", "VELOCITY", "CONTROLLED_VELOCITY"]),
        ("gs-c200s", "G", ["GOTO"]),
        ("gs-c200s", "g", ["VELOCITY", "CONTROLLED_VELOCITY"]),
        ("gs-c200", "L", ["LOOP_START", "LOOP"]),
        ("gs-c200", "s", ["START_STOP"]),
        ("gs-c200s", "f", ["FORCE"]),
        ("gs-c200s", "F", ["FEEDBACK"]),
        ("gs-c200", "top_speed", ["TOP_SPEED"]),
        ("gs-c200", "+250", ["MOVE"]),
        ("gs-c200", "G+2", ["CONTROLLED_VELOCITY"]),
        ("gs-c200s", "G+2", ["GOTO"]),
    ],
)
def test_a_command_is_found_by_letter_name_or_line(part, command, names):
    text = describe(SHEETS[part], command)
    assert [line[2:].split(":")[0] for line in text.splitlines() if line.startswith("# ")] == names


@rows(
    ("part", "command", "line"),
    [
        ("gs-c200", "F", "- accepted: while idle, during program entry, while a program runs"),
        ("gs-c200", "F", "- program memory: not stored"),
        ("gs-c200", "I", "- accepted: while idle"),
        ("gs-c200s", "I", "- accepted: while idle, during program entry (stored)"),
        ("gs-c200", "H", "- `direction`: +, -, optional"),
        ("gs-c200", "S", "- `speed`: 1..1000 (10 steps/s)"),
        ("gs-c200", "-1", "- `steps`: -999999..999999 without 0"),
    ],
)
def test_lines_of_a_command(part, command, line):
    assert line in describe(SHEETS[part], command).splitlines()


def test_unknown_command():
    with pytest.raises(UnknownName, match=r"gs-c200 has no command 'jc'; it has A \(ACTIVATE\), C"):
        describe(SHEETS["gs-c200"], "jc")
