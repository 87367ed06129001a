"""asm, dis, lint, describe and chips: what they print, in which format, and that they agree with each other."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from slewline.chips.cy525.sheet import SHEET

LINES = ("R 80", "E", "A$N 100", "G ; go", "L 6,A", "0", "QX")
STORED = bytes.fromhex("4E 64 00 47 4C 06 41 00")
RESOLVED = bytes.fromhex("4E 64 00 47 4C 06 00 00")


@pytest.fixture
def program(write):
    return write("p.cy525", *LINES)


# ------------------------------------------------------------------------------------------------------------------ asm
def test_asm_lists_address_bytes_and_source(call, program):
    ran = call("asm", program)
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.splitlines() == [
        "00  4E 64 00  A$N 100",
        "03  47        G",
        "04  4C 06 41  L 6,A",
        "07  00        0",
        "; 8 of 60 bytes",
    ]


def test_asm_as_json(call, program):
    found = call("asm", program, "--json").json
    assert (found["chip"], found["program"], found["bytes"]) == ("cy525", STORED.hex(), 8)
    assert (found["labels"], found["preset"], found["findings"]) == ({"A": 0}, ["R 80", "X"], [])
    assert found["lines"][2] == {"address": 4, "number": 5, "source": "L 6,A", "data": "4c0641"}


def output_of(*arguments):
    """The standard output as bytes, of a process of its own: carriage returns must arrive as they are."""
    code = "from slewline.tools.main import main; main()"
    return subprocess.run([sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, check=True).stdout


@pytest.mark.parametrize(
    ("form", "data"),
    [
        ("hex", b"4E 64 00 47 4C 06 41 00\n"),
        ("bin", STORED),
        ("ascii", b"E\rA$N 100\rG\rL 6,A\r0\rQ"),
        ("binary", bytes.fromhex("45 00 4E 02 64 00 47 00 4C 02 06 00 30 00 51")),
    ],
)
def test_asm_formats(call, program, form, data):
    assert output_of("asm", program, "--format", form) == data
    assert call("asm", program, "--format", form, "--output", "out").out == ""
    assert Path("out").read_bytes() == data


@pytest.mark.parametrize(
    ("name", "data"), [("p.hex", b"4E 64 00 47 4C 06 00 00\n"), ("p.bin", RESOLVED), ("p.lst", None)]
)
def test_asm_takes_the_format_from_the_ending(call, program, name, data):
    call("asm", program, "--resolve", "-o", name)
    written = Path(name).read_bytes()
    assert written == data if data else written.startswith(b"00  4E 64 00")


def test_asm_refuses_with_all_errors_and_writes_nothing(call, write):
    program = write("p.cy525", "E", "R 200", "J Z", "Q")
    ran = call("asm", program, "-o", "out.hex")
    assert (ran.status, ran.out, Path("out.hex").exists()) == (1, "", False)
    assert "p.cy525, line 2, column 3: RATE 200: allowed 0..127 (CY525 manual, T.V)\n    R 200\n      ^^^\n" in ran.err
    assert "p.cy525, line 3, column 3: JUMP Z" in ran.err


def test_asm_tells_what_is_odd_beside_the_bytes(call, write):
    program = write("p.cy525", "E", "R  20", "0", "Q")
    ran = call("asm", program, "--format", "hex")
    assert (ran.status, ran.out) == (0, "52 14 00\n")
    assert "p.cy525, line 2: note: spacing" in ran.err


# ------------------------------------------------------------------------------------------------------------------ dis
@pytest.mark.parametrize(("name", "form"), [("p.hex", "hex"), ("p.bin", "bin")])
def test_dis_turns_either_form_back_into_the_program(call, program, name, form):
    call("asm", program, "--resolve", "-o", name)
    ran = call("dis", name, "--chip", "cy525", "--labels")
    Path("again.cy525").write_text(ran.out)
    assert call("asm", "again.cy525", "--resolve", "--format", "hex").out == "4E 64 00 47 4C 06 00 00\n"
    assert "A$N 100" in ran.out and "L 6,A" in ran.out
    assert "L 6,0" in call("dis", name, "--chip", "cy525", "--format", form).out, "without --labels: addresses"


def test_dis_reads_comments_in_hex_and_can_be_told_that_it_is_none(call):
    Path("p.hex").write_text("47 ; go\n00")
    assert "G  " in call("dis", "p.hex", "--chip", "cy525").out
    Path("p.bin").write_bytes(b"4200")  # four bytes that look like hexadecimal digits
    assert len(call("dis", "p.bin", "--chip", "cy525", "--json").json["lines"]) == 2
    assert len(call("dis", "p.bin", "--chip", "cy525", "--format", "bin", "--json").json["lines"]) == 4


def test_dis_as_json(call):
    Path("p.bin").write_bytes(STORED + b"\xff")
    found = call("dis", "p.bin", "--chip", "cy525", "--json").json
    assert found["lines"][0] == {"address": 0, "data": "4e6400", "name": "NUMBER", "values": [100]}
    assert found["lines"][-1] == {"address": 8, "data": "ff", "name": None, "values": []}


def test_dis_reads_what_a_binary_host_sends(call, program):
    call("asm", program, "--format", "binary", "-o", "p.bin")
    ran = call("dis", "p.bin", "--chip", "cy525", "--stream")
    assert (ran.out.splitlines(), ran.err) == (["E", "N 100", "G", "L 6,0", "0", "Q"], "")
    Path("bad.hex").write_text("79 00")
    assert "unknown-command: y is no command" in call("dis", "bad.hex", "--chip", "cy525", "--stream").err


# ----------------------------------------------------------------------------------------------------------------- lint
def test_lint_is_content_with_a_good_program(call, write):
    ran = call("lint", write("p.cy525", "F 5", "R 5", "N 10", "G", "@until motion_complete=0"))
    assert (ran.status, ran.out) == (0, "p.cy525: nothing to complain about\n")


def test_lint_shows_the_line_and_fails_on_errors(call, write):
    program = write("p.cy525", "E", "J 5", "R 200", "Q")
    ran = call("lint", program)
    assert ran.status == 1
    assert (
        "p.cy525, line 3, column 3: error: RATE 200: allowed 0..127 (CY525 manual, T.V)\n    R 200\n      ^^^\n"
        in ran.out
    )
    assert ran.out.splitlines()[-1].startswith("p.cy525: 1 error, ")


@pytest.mark.parametrize(("options", "status"), [([], 0), (["--strict"], 1)])
def test_warnings_count_if_strict(call, write, options, status):
    ran = call("lint", write("p.cy525", "E", "J 5", "Q"), *options)
    assert ran.status == status and "warning: JUMP to byte 5" in ran.out


def test_notes_never_count(call, write):
    ran = call("lint", write("p.cy525", "R  20"), "--strict")
    assert ran.status == 0 and "note: spacing" in ran.out


def test_lint_looks_at_directives_too(call, write):
    ran = call("lint", write("p.cy525", "A 0", " @wait 0.5"))
    assert ran.status == 1
    assert "p.cy525, line 2, column 2: error: time '0.5': expected a number and a unit" in ran.out
    assert "write, for example, @wait 20 ms" in ran.out


def test_lint_knows_what_only_this_chip_cannot_do(call, write):
    ran = call("lint", write("p.cy525", "F 20", "R 10", "S 200", "Z 1", "N 500", "G"))
    assert "R 10 is below F 20" in ran.out


def test_lint_of_several_files_as_json(call, program, write):
    bad = write("bad.cy525", "r 20")
    ran = call("lint", program, bad, "--json")
    assert ran.status == 1 and list(ran.json) == [program, bad]
    (problem,) = ran.json[bad]
    assert (problem["line"], problem["column"], problem["code"], problem["severity"]) == (
        1,
        1,
        "unknown-command",
        "error",
    )


# ------------------------------------------------------------------------------------------------------ describe, chips
def test_describe_prints_the_sheet_as_markdown(call):
    text = call("describe", "CY525").out
    assert all(f"| {row.name} |" in text for row in SHEET.commands)
    assert text.startswith("# CY525")


@pytest.mark.parametrize("command", ["L", "l", "loop", "LOOP"])
def test_describe_one_command(call, command):
    assert call("describe", "cy525", command).out.startswith("# LOOP: ")
    found = call("describe", "cy525", command, "--json").json
    assert [row["form"] for row in found["commands"]] == ["L"] and "pins" not in found


def test_describe_as_json_has_everything(call):
    found = call("describe", "cy525", "--json").json
    assert len(found["commands"]) == len(SHEET.commands) and len(found["pins"]) == 40
    assert {register["name"] for register in found["registers"]} == {row.name for row in SHEET.registers}
    assert found["times"]["wait_poll"]["us"] == SHEET.times["wait_poll"].us


def test_describe_on_a_terminal_is_typeset(monkeypatch, capsys):
    from slewline.tools.main import invoke

    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    assert invoke(["describe", "cy525", "L"]) == 0
    text = capsys.readouterr().out
    assert "LOOP: " in text and "# LOOP" not in text and "- ASCII" not in text


def test_chips(call):
    assert call("chips").out.startswith("cy525       CY525 intelligent ramping")
    assert call("chips", "--json").json[0]["chip"] == "cy525"
