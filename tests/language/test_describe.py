"""The reference that is made from the sheet."""

from dataclasses import replace

import pytest

from slewline.chips import sheet_of
from slewline.chips.cy525.sheet import SHEET
from slewline.errors import UnknownName
from slewline.language.describe import describe, describe_command, table
from tests.rows import rows

PAGE = describe(SHEET)


@rows("row", SHEET.commands)
def test_every_command_is_there(row):
    (line,) = [line for line in PAGE.splitlines() if line.startswith("| `") and f"| {row.name} |" in line]
    assert f"| {row.description} |" in line
    assert f"| {row.time_us} |" in line
    assert all(f"{arg.name} {arg.low}..{arg.high}" in line for arg in row.args)


@pytest.mark.parametrize(
    ("part", "line", "command"), [("cy525", "R 100", "R"), ("cy545", "P 5", "P"), ("mc1451a", "SET_POS 5", "SET_POS")]
)
def test_a_command_with_its_argument_is_that_command(part, line, command):
    assert describe(sheet_of(part), line) == describe(sheet_of(part), command)
    with pytest.raises(UnknownName, match="has no command '~ 100'; it has"):
        describe(SHEET, "~ 100")


@rows("pin", SHEET.pins)
def test_every_pin_is_there(pin):
    assert f"| {pin.number} | `{pin.name}` | {pin.in_out} | {pin.description} |" in PAGE


def test_every_register_and_time_is_there():
    for register in SHEET.registers:
        assert f"| `{register.name}` | {register.description} | `{register.letter}` | {register.bits} |" in PAGE
    for name, time in SHEET.times.items():
        assert (
            f"| `{name}` | {time.description} | {time.us:g} | {time.mhz:g} | {time.ticks} | {time.where} | "
            f"{time.trust} |" in PAGE
        )


def test_tables_are_even():
    for block in PAGE.split("\n\n"):
        if block.startswith("|"):
            assert len({line.count("|") for line in block.splitlines()}) == 1


def test_head():
    assert PAGE.startswith("# CY525 intelligent ramping stepper motor controller\n")
    assert "- program buffer: 60 bytes\n" in PAGE
    assert "- crystal: 1 to 11 MHz;" in PAGE


@rows("name", ["L", "l", "LOOP", "loop"])
def test_one_command(name):
    assert describe(SHEET, name).splitlines() == [
        "# LOOP: branch until the count has run out",
        "",
        "- ASCII: `L count,target`, then a carriage return",
        "- binary: `4C 02 count target`",
        "- program buffer: 3 bytes, `4C count target`",
        "- time at 11 MHz: 150 µs and the conversion of the digits; 40 µs in a program",
        "- manual: s.3; T.V",
        "- `count`: 1..255, 1 byte",
        "- `target`: 0..59 or a label A..E, 1 byte",
    ]


@rows(
    ("command", "line"),
    [
        ("Q", "- ASCII: `Q`, without a carriage return"),
        ("Q", "- binary: `51`"),
        ("Q", "- program buffer: not stored"),
        ("0", "- binary: `30 00`"),
        ("0", "- program buffer: 1 byte, `00`"),
        ("N", "- binary: `4E 02 steps.low steps.high`"),
        ("G", "- time at 11 MHz: 447 µs and the motion; 40 µs in a program"),
        ("D", "- `delay`: 1..65535 (ms at 11 MHz), 2 bytes"),
    ],
)
def test_forms(command, line):
    assert line in describe_command(SHEET, command).splitlines()


def test_unknown_command():
    with pytest.raises(UnknownName, match=r"cy525 has no command 'K'; it has A \(ABSOLUTE\), B"):
        describe(SHEET, "K")


@pytest.mark.parametrize(("most_ps", "explained"), [(-1, True), (0, False), (1, False)])
def test_a_limit_below_zero_is_explained(most_ps, explained):
    page = describe(replace(SHEET, limits=(replace(SHEET.limits[0], most=most_ps),)))
    assert (" Below zero: the second edge must come first.\n" in page) == explained


def test_bars_are_escaped():
    assert table(["a"], [["x|y"]]) == "| a |\n| --- |\n| x\\|y |"
