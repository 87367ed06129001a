"""A program for a servo chip of this family, sent to a stepper part: one finding, one line of the linter."""

from __future__ import annotations

from pathlib import Path

import pytest

import slewline
from slewline.chips import checks_of, chip_class, sheet_of
from slewline.language.lint import lint
from tests.rows import rows

ROOT = Path(__file__).parents[3]
GAINS = (0x25, 0x26, 0x27, 0x28, 0x2B)
PARTS = ("mc1151a", "mc1251a", "mc1451a", "mc1151a-e", "mc1451a-e")
PROGRAMS = sorted(
    path
    for folder in ("examples", "src/slewline", "templates", "docs", "tests")
    for path in (ROOT / folder).rglob("*.mc1?51a*")
)


def sent(part, *packets):
    """Send packets, a code with its words; return the findings, and the words that were read."""
    bench = slewline.Bench()
    x = bench.add(part, name="x")
    host = bench.host(x)
    for code, words, reads in packets:
        host.packet(code, *words, reads=reads)
    bench.run("100 ms")
    return x, list(bench.findings)


def linted(part, *lines):
    sheet = sheet_of(part)
    return lint("\n".join(lines), sheet, checks_of(chip_class(part), sheet))


@rows("part", PARTS)
def test_a_program_with_gains_is_one_finding(part):
    x, found = sent(
        part,
        (0x3B, (), 0),
        *((code, (200,), 0) for code in GAINS),
        (0x50, (), 1),
        (0x10, (0, 100), 0),
        (0x11, (8, 0), 0),
        (0x12, (0, 0x1000), 0),
        (0x1A, (), 0),
    )
    servo = [each for each in found if each.code == "servo-command"]
    assert [each.text for each in servo] == [
        "25 is SET_KP of the MC1401A, a servo chip: no effect here; 3b is SET_OUTPUT_HIGH here and SET_OUTPUT_DAC16 "
        "there, 3c is SET_OUTPUT_STNDRD here and SET_OUTPUT_PWM there"
    ]
    assert [each.code for each in found] == ["servo-command"] and x.axes[0].position == 100


@rows("code", [0x06, 0x07, 0x0F, 0x2D, 0x38, 0x3A, 0x40, 0x41, 0x61, 0x62, 0x69, 0x6E])
def test_codes_that_a_stepper_part_may_have_too_cause_no_finding(code):
    sibling = sheet_of("mc1451a").dialect.siblings[code]
    assert sent("mc1451a", (code, (1,) * sibling.writes, sibling.reads))[1] == []


def test_every_code_of_the_part_itself_is_accepted_silently():
    """Whatever words they have: the codes of a servo chip among the data of a packet are data."""
    sheet = sheet_of("mc1451a-e")
    for row in sheet.commands:
        if row.name == "RESET":
            continue
        words = tuple([0x2525] * (sum(arg.size for arg in row.args) // 2))
        reads = sum(arg.size for arg in row.reads) // 2
        found = sent("mc1451a-e", (row.code, words, reads))[1]
        assert "servo-command" not in {each.code for each in found}, row.name


@rows(
    ("lines", "at"),
    [
        (["@bytes 25 00 C8"], 1),
        (["SET_POS 5", "@bytes 3B", "@bytes 26 00 C8", "@bytes 25 00 C8", "UPDATE"], 3),
        (["@bytes 10 00 00 00 25 25 00 C8"], 1),
        (["@bytes 10 00 25", "@bytes 25 25", "@bytes 25 00 C8"], 3),
    ],
)
def test_the_linter_reports_it_once(lines, at):
    found = [each for each in linted("mc1451a", *lines) if each.code == "servo-command"]
    assert [(each.line, each.severity) for each in found] == [(at, "warning")]
    assert "a servo chip" in found[0].message and "motion commands are the same" in found[0].remedy


@rows(
    "lines",
    [
        ["@bytes 10 25 25 25 25"],
        ["@bytes 10 25", "@bytes 25 25 25"],
        ["@bytes 10 00 25", "@bytes 25 00", "UPDATE", "@bytes 3B 3C"],
        ["SET_OUTPUT_HIGH", "SET_POS 0x25252525"],
    ],
)
def test_the_linter_takes_no_data_for_a_code(lines):
    assert "servo-command" not in {each.code for each in linted("mc1451a", *lines)}


@rows(("name", "says"), [("SET_KP 200", "the MC1401A, a servo chip"), ("AXIS_ON", "a sister part")])
def test_a_name_of_a_sister_part_is_known(name, says):
    (problem,) = linted("mc1451a", name)
    assert problem.severity == "error" and f"it is a command of {says} and has no effect here" in problem.remedy


def test_a_hex_file_of_a_servo_program_is_split_into_packets(tmp_path):
    sheet = sheet_of("mc1451a")
    assert sheet.dialect.parted(["25 00 C8 3B", "50 10 00", "00 00 05"], sheet) == [
        "25 00 c8",
        "3b",
        "50",
        "10 00 00 00 05",
    ]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.name)
def test_none_of_our_programs_is_taken_for_one_of_a_servo(path: Path):
    part = path.suffix[1:]
    assert "servo-command" not in {each.code for each in linted(part, path.read_text("utf-8"))}
