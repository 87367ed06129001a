"""The reference of the MC1451A family that is made from its sheets: packets instead of letters."""

from __future__ import annotations

import pytest

from slewline.chips import PARTS, sheet_of
from slewline.errors import UnknownName
from slewline.language.describe import describe
from slewline.language.packets.packet_reference import packet
from tests.rows import rows

SHEETS = {part: sheet_of(part) for part, row in PARTS.items() if row.folder == "mc1451a"}
PAGES = {part: describe(sheet) for part, sheet in SHEETS.items()}
each = pytest.mark.parametrize("part", SHEETS)


@each
def test_every_command_pin_wire_register_and_time_is_there(part):
    sheet, page = SHEETS[part], PAGES[part]
    for row in sheet.commands:
        (line,) = [line for line in page.splitlines() if line.startswith(f"| `{packet(row)}` | {row.name} |")]
        assert f"| {row.description} |" in line and ("takes effect at the next update" in line) == row.buffered
        assert ("needs an encoder" in line) == row.encoder
    for pin in sheet.pins:
        assert f"| {pin.number} | `{pin.name}` | {pin.in_out} | {pin.description} |" in page
    for wire in sheet.wires:
        assert f"| {', '.join(f'`{name}`' for name in wire)} |" in page
    for register in sheet.registers:
        assert f"| `{register.name}` | {register.description} |" in page
    for name, time in sheet.times.items():
        assert (
            f"| `{name}` | {time.description} | {time.us:.10g} | {time.mhz:g} | {time.ticks} | {time.where} |" in page
        )


@each
def test_there_is_no_program_and_no_serial_port(part):
    assert "program" not in PAGES[part].lower() and "Serial port" not in PAGES[part]


def test_words_and_codes():
    page = PAGES["mc1251a"]
    assert "| 5 | `positive_limit` | the positive limit switch has become active |\n" in page
    assert "| 12-13 | `axis` | number of the axis |\n" in page
    assert "| 13-15 | `phase` | phase of the S-curve, 1 to 7; else 0 |\n" in page
    assert "## Version word\n\n`4C11`\n" in page
    assert "| 00, 03-04, 22, 80-FF | illegal: checksum 0 |\n| 49 | reserved: no effect |\n" in page
    assert "| 07, 2D-2E, 3A, 50-54, 61, 69, 6E | a sister part's; no effect, a word is returned, 0 |\n" in page


def test_a_command_in_full():
    assert describe(SHEETS["mc1451a"], "set_ratio 5") == (
        "# SET_RATIO: gear ratio\n"
        "\n"
        "- line: `SET_RATIO <ratio>`\n"
        "- packet: `14 ratio.high ratio.low`\n"
        "- acts on: the current axis\n"
        "- busy at 25 MHz: for 82 µs after the command and after each word\n"
        "- manual: command reference\n"
        "- `ratio`: -1073741824..1073741823 (2^-16 steps/count)\n"
        "- takes effect at the next update\n"
        "- needs an encoder; other parts accept it\n"
    )
    assert "- packet: `31 [status]`\n" in describe(SHEETS["mc1451a"], "GET_STATUS")
    assert "- acts on: the axis that it sets\n" in describe(SHEETS["mc1451a"], "SET_3")


def test_an_unknown_command_is_refused_with_a_suggestion():
    with pytest.raises(UnknownName, match="SET_VELO is not a command of the MC1151A; write SET_VEL"):
        describe(SHEETS["mc1151a"], "SET_VELO")
    with pytest.raises(UnknownName, match="SET_3 is not a command of the MC1251A; a part with more axes"):
        describe(SHEETS["mc1251a"], "SET_3")


@rows("code", ["4e", "4E", "0x4e", "$4E"])
def test_a_command_is_found_by_its_code(code):
    assert describe(sheet_of("mc1451a"), code).startswith("# SMOOTH_STOP: ")


@rows("code", ["ff", "4", "04e", "4g"])
def test_a_code_without_a_command_is_unknown(code):
    with pytest.raises(UnknownName, match=f"{code} is not a command of the MC1451A"):
        describe(sheet_of("mc1451a"), code)
