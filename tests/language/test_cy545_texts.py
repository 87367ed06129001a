"""Texts of CY545 programs: assembled byte for byte, disassembled to the same bytes, linted, described."""

from __future__ import annotations

from contextlib import nullcontext

import pytest

import slewline
from slewline.bench.scripts.script import run_script
from slewline.chips import checks_of, sheet_of
from slewline.errors import ProgramError, UsageError
from slewline.language.assemble import assemble, to_ascii, to_binary
from slewline.language.describe import describe
from slewline.language.disassemble import commands, disassemble, instructions
from slewline.language.lint import lint
from slewline.language.text import Entry
from tests.rows import rows

SHEET = sheet_of("cy545b")
PLAIN = sheet_of("cy545")
CC10 = "Y 10\nE\nN 1\n+\nG\nD 2000\nL 50,16\n0\nQ\nY 10\nX\n"
ODD = 'E\n/T 3,0  ; a comment\nR #\n"Hi, you"\n? M,2\n[38H,1,65]\nZ 0421H 92H\n0\nQ\n'


def odd(text, sheet=SHEET):
    found = lint(text, sheet, checks_of(sheet.part))
    return [(problem.line, problem.code) for problem in found if problem.severity != "note"]


def test_a_program_is_assembled_exactly_as_written_and_at_its_address():
    made = assemble(CC10, SHEET)
    assert made.stored == b"N 1\r+\rG\rD 2000\rL 50,16\r0\r"
    assert [line.address for line in made.lines] == [10, 14, 16, 18, 25, 33]
    assert made.listing().splitlines()[4] == "00025  4C 20 35 30 2C 31 36 0D              L 50,16"
    assert made.preset == ("Y 10", "Y 10", "X")


def test_lines_of_a_host_set_the_pointer_unless_the_program_begins_at_0():
    made = assemble(CC10, SHEET)
    assert to_ascii(made) == b"Y 10\rE\r" + made.stored + b"Q"
    assert to_binary(made).hex(" ") == ("59 02 0a 00 45 00 4e 03 01 00 00 2b 00 47 00 44 02 d0 07 4c 02 32 10 00 00 51")
    assert to_ascii(assemble("E\nG\n0\nQ\n", SHEET)) == b"E\rG\r0\rQ"


def test_every_form_is_kept_character_for_character():
    made = assemble(ODD, SHEET)
    assert made.stored == b'/T 3,0\rR #\r"Hi, you"\r? M,2\r[38H,1,65]\rZ 0421H 92H\r0\r'
    again = assemble(disassemble(made.stored, SHEET), SHEET)
    assert again.stored == made.stored


def test_values_of_switches_have_no_binary_form():
    with pytest.raises(UsageError, match=r"# \(read from switches\) exists only in text"):
        to_binary(assemble("E\nR #\n0\nQ\n", SHEET))


def test_the_slash_becomes_part_of_the_number_in_binary():
    assert to_binary(assemble("E\n/B 2\n0\nQ\n", SHEET)).hex(" ") == "45 00 42 01 12 00 00 51"


def test_a_program_that_begins_too_high_is_reported_with_the_available_room():
    with pytest.raises(ProgramError, match=r"12 bytes of program from address 65530 on; .* allowed 6 ") as caught:
        assemble("Y 65530\nE\nN 12345\n+\n0\nQ\n", SHEET)
    assert caught.value.problems[0].remedy == "start it at a lower address"


def test_a_second_program_begins_where_the_pointer_is():
    found = odd("Y 0\nE\nY 500\nQ\nY 500\nE\nG\n0\nQ\n+\nY 0\nX\n")
    assert found == []


def test_unknown_bytes_are_separate_lines():
    found = instructions(b"\xff\xffG\r\x01R 5\rQ\rR", SHEET)
    assert [(one.address, one.row.form if one.row else None) for one in found] == [
        (0, None), (2, "G"), (4, None), (5, "R"), (9, None), (10, None), (11, None),
    ]  # fmt: skip


def test_branches_go_to_bytes_so_no_label_is_named():
    stored = assemble('E\n? R\n"a"\nL 3,0\n0\nQ\n', SHEET).stored
    assert disassemble(stored, SHEET, labels=True) == disassemble(stored, SHEET)


def test_a_command_may_directly_follow_q():
    made = assemble("Y 10\nE\n0\nQY 10\nX\n", SHEET)
    assert (made.stored, made.preset) == (b"0\r", ("Y 10", "Y 10", "X"))


def test_a_binary_stream_is_reported_as_commands():
    said, notes = commands(bytes.fromhex("52 01 87 44 02 3B 1A 4E 03 11 22 33 5A 03 21 04 92 47 00"), SHEET)
    assert said == ["R 135", "D 6715", "N 3351057", "Z 1057,146", "G"]
    assert not notes
    assert commands(bytes.fromhex("FF FF 47 00"), SHEET) == (["G"], [])


@rows(
    ("text", "code", "says"),
    [
        ("R ABH", "bad-number", "0ABH"),
        ("R 300", "range", "0..255"),
        ("L 3,#", "bad-number", "first argument only"),
        ("/R 5", "slash", "B, T, W, H"),
        ("? Z", "unknown-query", "M,n"),
        ('"open', "no-end-of-string", "quotation mark"),
        ("[1,2,3", "count", "2 values announced"),
        ("[1", "bad-number", "address, count"),
        ("K", "unknown-command", "K is not in any list"),
        ("Q X", "extra-argument", "write X on a line of its own"),
        ("N", "missing-argument", "steps"),
        ("\u2019", "bad-character", "not a byte"),
    ],
)
def test_mistakes_are_reported_with_their_place_and_a_remedy(text, code, says):
    with pytest.raises(ProgramError) as caught:
        assemble(f"E\n{text}\n0\nQ\n", SHEET)
    (problem,) = caught.value.problems
    assert (problem.line, problem.code) == (2, code)
    assert says in str(caught.value)


@rows(
    ("text", "expected"),
    [
        (CC10, []),
        ("+\nE\nN 1\nG\nQ\n", [(4, "no-end")]),
        ("+\nE\nN 1\nG\nL 3,4\nL 2,4\n0\nQ\n", [(6, "nested-loop")]),
        ("+\nE\nN 1\nG\nL 3,4\nZ 2,4\n0\nQ\n", []),
        ("+\nE\nN 1\nL 3,1\n0\nQ\n", [(4, "branch-middle")]),
        ("Y 256\nE\nJ 0\nQ\n", []),
        ("Y 250\nE\nJ 0\nQ\n", [(3, "branch-outside")]),
        ("Y 253\nE\nJ 1\n0\nQ\n", [(3, "page-crossed")]),
        ("E\nE\n0\nQ\n", [(2, "enter-inside")]),
        ("Q\n", [(1, "quit-outside")]),
        ("E\n0\nQY 0\nX\n", []),
        ("E\n0\nQ/G\n", [(3, "slash")]),
        ("", []),
        ("@note nothing is sent\n", []),
        ("L 2,0\n", [(1, "branch-in-command-mode")]),
        ("O 1\nR 5\n", []),
        ("O 1\nR #\n", [(2, "binary-mode")]),
        ("O 1\nO 81H\nR #\n", []),
        ("O 1\nI\nR #\n", []),
        ("O 1\n@reset\nR #\n", []),
        ("O 1\n@bytes 4F 01 81\nR #\n", []),
        ("E\nO 1\nR 50\n0\nQ\n", [(2, "binary-mode")]),
        ("E\nR 50\nO 1\nQ\n", [(3, "no-end")]),
        ("O 1\nE\nO 0\nR 50\n0\nQ\n", []),
        ("O 1\nE\nO 81H\nR 50\n0\nQ\n", [(3, "binary-mode")]),
        ("O 0C0H\n", [(1, "mode-bits")]),
        ("O 81H\nR 5\n", []),
        ("E\n0\nQ\nX\nY 5\n", [(5, "not-immediate")]),
        ("E\n0\nQ\nX\n@wait 5 s\nY 5\n", []),
        ("E\n0\nQ\nX\n0\nY 5\n", []),
    ],
)
def test_oddities_are_reported(text, expected):
    assert odd(text) == expected


@pytest.mark.parametrize("text", ["", "F", "; nothing"])
def test_a_text_without_a_command_is_linted(text):
    assert [problem.code for problem in lint(text, SHEET, checks_of("cy545b"))] == ["missing-argument"] * (text == "F")


def test_the_plain_part_takes_no_stop_while_its_program_runs():
    text = "E\nJ 0\nQ\nX\n0\n"
    assert odd(text, PLAIN) == [(5, "not-heard")]
    assert odd(text) == []


def test_a_branch_is_judged_by_the_page_after_it():
    assert odd("Y 4096\nE\n+\nN 1\nG\nL 3,6\n0\nQ\n") == []
    assert odd("Y 4096\nE\n+\nN 1\nG\nL 3,7\n0\nQ\n") == [(6, "branch-middle")]


@rows(
    ("ascii", "data", "at"),
    [
        (True, b"Q", 0), (True, b"AQ\rQ", 3), (True, b'"Q\rQ', 3), (False, b"R\x01QQ", 3), (False, b"\xffG\x00Q", 3),
        (False, b'"\x03\x00QQ\x00\x00Q', 7),
    ],
)  # fmt: skip
def test_the_q_that_ends_an_entry_is_distinguished_from_others(ascii, data, at):
    entry = Entry(SHEET.leave[-1], ascii)
    assert [entry.ends(byte) for byte in data] == [place == at for place in range(len(data))]


def test_the_reference_has_every_command_and_how_numbers_are_written():
    page = describe(SHEET)
    for row in SHEET.commands:
        assert f"| {row.name} |" in page
    assert "`0ABH`" in page
    assert "- binary: `5A 03 count.low count.high target`" in describe(SHEET, "Z")
    assert "inverts bit 4" in describe(SHEET, "B")
    assert "P (8 digits)" in describe(SHEET, "?")
    assert "- binary: `51`" in describe(SHEET, "Q")


@rows(
    ("text", "says"),
    [
        ("O 0\nR 77", set()),
        ("O 0\nR #", {"error"}),
        ("O 0\nO 128\nB #\nR 77", set()),
        ("O 0\nI\nB #\nR 77", set()),
        ("E\nO 0\nR 77\n0\nQY 0\nX", {"warning"}),
        ("O 0\nE\nO 1\nR 77\n0\nQ\nY 0\nX", set()),
        ("O 0\nE\nO 128\nR 77\n0\nQ\nY 0\nX", {"warning"}),
    ],
)
def test_of_text_and_binary_the_linter_and_a_run_report_the_same(text, says):
    problems = lint(text, sheet_of("cy545b"), checks_of("cy545b"))
    assert {problem.severity for problem in problems if problem.code == "binary-mode"} == says
    bench = slewline.Bench()
    x = bench.add("cy545b")
    bench.part("ram", to=x, size=2048)
    run_script(bench, bench.host(x), text)
    with pytest.raises(ProgramError) if says == {"error"} else nullcontext():
        bench.run("30 ms")
    assert (x.registers["rate"] == 77) is not bool(says)


@rows(
    ("line", "places"),
    [
        ("  R 5\u2013", [(6, 1)]),  # a character that is no byte
        (" //B 2", [(3, 1)]),  # the second one is no command
        (" /", [(2, 1)]),  # nor is one alone
        (" /R 5", [(2, 1)]),  # a slash where none belongs
        (' "done"now', [(8, 3)]),  # what stands behind a string
        (' "done"x', [(8, 1)]),
        (" [38H,3,65,66", [(3, 11)]),  # fewer values than announced
        (" N 70000000", [(4, 8)]),
    ],
)
def test_a_mistake_is_found_in_its_place(line, places):
    found = lint(line, SHEET, checks_of("cy545b"))
    assert [(problem.column, problem.length) for problem in found if problem.severity == "error"] == places
