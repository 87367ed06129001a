"""asm, dis, lint, describe and chips: what they print, in which format, and that they agree with each other."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from slewline.chips.cy525.sheet import SHEET
from slewline.cli.main import invoke

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


FORMS = {
    "hex": b"4E 64 00 47 4C 06 41 00\n",
    "bin": STORED,
    "ascii": b"E\rA$N 100\rG\rL 6,A\r0\rQ",
    "binary": bytes.fromhex("45 00 4E 02 64 00 47 00 4C 02 06 00 30 00 51"),
}


@pytest.mark.parametrize(("form", "data"), FORMS.items(), ids=FORMS)
def test_asm_formats(program, form, data, capfdbinary):
    assert invoke(["asm", program, "--format", form]) == 0
    assert capfdbinary.readouterr().out == data
    assert invoke(["asm", program, "--format", form, "--output", "out"]) == 0
    assert capfdbinary.readouterr().out == b""
    assert Path("out").read_bytes() == data


@pytest.mark.system
def test_carriage_returns_reach_a_pipe_unchanged(program):
    code = "from slewline.cli.main import main; main()"
    command = [sys.executable, "-c", code, "asm", program, "--format", "ascii"]
    assert subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout == FORMS["ascii"]


@pytest.mark.parametrize(
    ("name", "data"), [("p.hex", b"4E 64 00 47 4C 06 00 00\n"), ("p.bin", RESOLVED), ("p.lst", None)]
)
def test_asm_takes_the_format_from_the_extension(call, program, name, data):
    call("asm", program, "--resolve", "-o", name)
    written = Path(name).read_bytes()
    assert written == data if data else written.startswith(b"00  4E 64 00")


def test_asm_refuses_with_all_errors_and_writes_nothing(call, write):
    program = write("p.cy525", "E", "R 200", "J Z", "Q")
    ran = call("asm", program, "-o", "out.hex")
    assert (ran.status, ran.out, Path("out.hex").exists()) == (1, "", False)
    assert "p.cy525, line 2, column 3: RATE 200: allowed 0..127 (CY525 manual, T.V)\n    R 200\n      ^^^\n" in ran.err
    assert "p.cy525, line 3, column 3: JUMP Z" in ran.err


def test_asm_reports_oddities_next_to_the_bytes(call, write):
    program = write("p.cy525", "E", "R  20", "0", "Q")
    ran = call("asm", program, "--format", "hex")
    assert (ran.status, ran.out) == (0, "52 14 00\n")
    assert "p.cy525, line 2: note: spacing" in ran.err


@pytest.mark.parametrize("lines", [("T 5",), ("A$B", "J A", "0"), ("R 5", "G")])
def test_asm_takes_a_file_without_e_for_commands_as_run_and_lint_do(call, write, lines):
    program = write("p.cy525", *lines)
    ran = call("asm", program, "-o", "out.hex")
    assert (ran.status, ran.out, Path("out.hex").exists()) == (2, "", False)
    assert "p.cy525 has no program" in ran.err and "write E above the first of them, and Q below the last" in ran.err
    write("p.cy525", "E", *lines, "Q")
    assert call("asm", program, "-o", "out.hex").status == 0


@pytest.mark.parametrize("form", ["binary", "bin", "ascii"])
def test_bytes_are_kept_from_a_terminal(call, program, monkeypatch, form):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    ran = call("asm", program, "--format", form)
    assert (ran.status, ran.out) == (2, "")
    assert ran.err == "slewline: program bytes are not printed on a terminal; give --output FILE, or write to a pipe\n"


# ------------------------------------------------------------------------------------------------------------------ dis
@pytest.mark.parametrize(("name", "form"), [("p.hex", "hex"), ("p.bin", "bin")])
def test_dis_turns_either_form_back_into_the_program(call, program, name, form):
    call("asm", program, "--resolve", "-o", name)
    ran = call("dis", name, "--chip", "cy525", "--labels")
    Path("again.cy525").write_text(ran.out)
    assert call("asm", "again.cy525", "--resolve", "--format", "hex").out == "4E 64 00 47 4C 06 00 00\n"
    assert "A$N 100" in ran.out and "L 6,A" in ran.out
    assert "L 6,0" in call("dis", name, "--chip", "cy525", "--format", form).out, "without --labels: addresses"


def test_dis_reads_comments_in_hex_and_can_be_forced_to_binary(call):
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


def test_dis_reads_the_stream_of_a_binary_host(call, program):
    call("asm", program, "--format", "binary", "-o", "p.bin")
    ran = call("dis", "p.bin", "--chip", "cy525", "--stream")
    assert (ran.out.splitlines(), ran.err) == (["E", "N 100", "G", "L 6,0", "0", "Q"], "")
    Path("bad.hex").write_text("79 00")
    assert "unknown-command: y is not a command" in call("dis", "bad.hex", "--chip", "cy525", "--stream").err


SINGLE = "45 00 52 0C 7F 4E 2C 01 2B 47 4E EE 02 2D 47 00 51"  # the example of s.5


@pytest.mark.fact("EXAMPLE-BIN")
def test_dis_reads_a_program_under_a_single_count_and_its_text_assembles_again(call, write):
    ran = call("dis", write("p.hex", SINGLE), "--chip", "cy525", "--stream")
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.split("\n") == ["E", "R 127", "N 300", "+", "G", "N 750", "-", "G", "0", "Q", ""]
    Path("again.cy525").write_text(ran.out)
    assert call("asm", "again.cy525", "--format", "hex").out == "52 7F 4E 2C 01 2B 47 4E EE 02 2D 47 00\n"


def test_dis_reads_a_program_as_the_chip_keeps_it_whatever_the_counts_say(call, write):
    stream = "52 01 05 45 00 4E 01 2C 52 02 01 47 51 45 00 51 58 00 00 00"  # N is short of a byte, which R then gives
    ran = call("dis", write("p.hex", stream), "--chip", "cy525", "--stream")
    assert ran.out.split() == ["R", "5", "E", "N", "21036", "???", "01", "G", "Q", "E", "Q", "X"]
    assert "unknown-command" in ran.err  # 00, with count and data behind it, is no letter


@pytest.mark.parametrize("cut", [2, 5, 16])
def test_dis_reports_where_a_stream_is_truncated(call, write, cut):
    ran = call("dis", write("p.hex", " ".join(SINGLE.split()[:cut])), "--chip", "cy525", "--stream")
    where = "from byte 2 on, 52 0C 7F\n"
    assert ran.err == (f"slewline: cut-short: the stream ends inside a command, which is omitted: {where}" * (cut == 5))
    assert ran.out.split()[0] == "E" and ("N" in ran.out) == (cut == 16)


@pytest.mark.parametrize("lines", [LINES, ("A 0", "@wait 2 s", "r 5"), ("B", "C"), ("E\r", "R 5 ; fast\r")])
@pytest.mark.parametrize("options", [(), ("--stream",)])
def test_dis_recognises_a_program_text(call, write, lines, options):
    ran = call("dis", write("p.cy525", *lines), *options)
    assert (ran.status, ran.out) == (2, "")
    assert ran.err == "slewline: p.cy525: this is a program text, not program bytes; slewline asm converts it\n"


@pytest.mark.parametrize("data", [b"BGC", b"G", b"N\n0GC", b"R\nG\0", b"\xc3\x28\nB\nC\n", b"xyz\nB\nq\n"])
def test_dis_takes_bytes_that_happen_to_be_letters(call, data):
    Path("p.bin").write_bytes(data)
    assert call("dis", "p.bin", "--chip", "cy525").status == 0
    assert call("dis", "p.bin", "--chip", "cy525", "--format", "bin").status == 0


# ----------------------------------------------------------------------------------------------------------------- lint
def test_lint_is_content_with_a_good_program(call, write):
    ran = call("lint", write("p.cy525", "F 5", "R 5", "N 10", "G", "@until motion_complete=0"))
    assert (ran.status, ran.out) == (0, "p.cy525: no problems found\n")


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


def test_lint_checks_directives_too(call, write):
    ran = call("lint", write("p.cy525", "A 0", " @wait 0.5"))
    assert ran.status == 1
    assert "p.cy525, line 2, column 2: error: time '0.5': expected a number and a unit" in ran.out
    assert "write, for example, @wait 20 ms" in ran.out


def test_lint_knows_the_limits_of_this_chip_only(call, write):
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


REFUSED = {
    "cy525": ["@until foo=1", "@to y", "@drive nix=0", "@tell shaft slip 5", "@wait", "@rate 300", "@ask V1", "@x 5"],
    "gs-c200": ["@until foo=1", "@live B", "@rate 5", "@drive ui9=1", "@reset", "wait 5", "@expect 5", "@to y"],
    "mc1451a": ["wait motion_done", "expect status", "@drive poslimit9=1", "@until position=x", "@live B", "SET_PSO 5"],
}
PASSED = {
    "cy525": ["A 0", "R 5", "@wait 20 ms", "@drive abort=1", "@until ready=1", "@note so", "@verify 3"],
    "gs-c200": ["F", "V1", "@until ready", "@drive ui1=1", "@ask V2", "@bytes 46 0D"],
    "mc1451a": ["GET_STATUS", "SET_POS 5", "wait motion_complete", "@drive home1=0", "@until atrest1=1"],
}


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(st.data())
def test_whatever_run_refuses_lint_calls_an_error_of_the_same_line(data):
    from slewline.cli.programs import texts_of
    from slewline.cli.run import RunCommand
    from slewline.errors import ProgramError

    part = data.draw(st.sampled_from(sorted(REFUSED)))
    odd = [*REFUSED[part], "@wait x", "A\u00d8", "x" * 999, "@bytes 4", "@until", "@power maybe", "@pulse abort=0"]
    lines = data.draw(st.lists(st.sampled_from([*odd, *PASSED[part]]), min_size=1, max_size=6))
    path = Path(f"p.{part}")
    path.write_text("\n".join(lines))
    none = dict.fromkeys(field.name for field in fields(RunCommand)) | {"strap": (), "drive": (), "quiet": True}
    try:
        RunCommand(**none | {"file": str(path)}).new_bench(None).run("1 us")
        refused = set()
    except ProgramError as error:
        refused = {problem.line for problem in error.problems}
    (linted,) = texts_of(str(path), None)
    assert refused <= {problem.line for problem in linted.problems if problem.severity == "error"}
    assert refused == {number for number, line in enumerate(lines, 1) if line in odd and played(part, line)}


def played(part, line):
    """Are these refused?  Letters and lines of text go out to the chip, right or wrong; packets are checked first."""
    return not ((line == "x" * 999 and part != "mc1451a") or line == "wait 5")


def test_lint_reads_the_scripts_of_a_bench_file_on_its_bench(call, write):
    write("y.cy525", "@until x.slew=0", "R 200", "@tell gate open")
    chips = [f'[[chip]]\npart = "cy525"\nname = "{name}"' for name in "xy"]
    part = '[[part]]\nkind = "inverter"\nname = "gate"'
    hosts = '[[host]]\nchips = ["x"]\nscript = ["A 0", "Z"]\n[[host]]\nchips = ["y"]\nfile = "y.cy525"'
    bench = write("b.toml", *chips, part, hosts)
    ran = call("lint", bench)
    assert ran.status == 1
    assert "b.toml, [[host]] 1, script, line 2, column 2: error: DIVISOR without divisor: allowed 1..255" in ran.out
    assert "y.cy525, line 2, column 3: error: RATE 200: allowed 0..127" in ran.out
    assert "y.cy525, line 3, column 1: error: tell gate 'open'; a script cannot operate this part" in ran.out
    assert "y.cy525: 2 errors" in ran.out.replace(str(Path.cwd()) + "/", "")
    assert call("lint", bench, "--chip", "cy525").status == 2
    assert call("lint", write("e.toml", chips[0])).out == "e.toml: no problems found\n"


def test_lint_of_a_bench_file_lists_each_host_that_plays_a_file(call, write):
    write("y.cy525", "@drive nix=0")
    hosts = [f'[[host]]\nchips = ["{name}"]\nfile = "y.cy525"' for name in "xy"]
    chips = [f'[[chip]]\npart = "cy525"\nname = "{name}"' for name in "xy"]
    found = call("lint", write("b.toml", *chips, *hosts), "--json").json
    assert [problem["found"][:20] for problems in found.values() for problem in problems] == [
        "x (cy525) has no pin",
        "y (cy525) has no pin",
    ]


@pytest.mark.parametrize(
    ("behind", "lost"),
    [
        (("V 0",), True),
        (("@drive abort=1", "V 0"), True),
        (("@live R 5", "V 0"), True),
        (("@until run=1", "V 0"), False),
        (("@wait 1 s", "V 0"), False),
        (("@live 0", "V 0"), False),
        ((), False),
    ],
)
def test_run_loses_or_delays_the_commands_after_x_that_lint_warns_of(call, write, behind, lost):
    program = write("p.cy525", "E", "D 50", "D 50", "0", "QX", *behind)
    findings = call("run", program, "--json").json["findings"]
    assert ("request-while-running" in {found["code"] for found in findings}) == lost
    assert ("the program that X of line 5 started may still run" in call("lint", program).out) == lost


def test_run_refuses_the_verify_after_x_that_lint_warns_of_and_takes_the_advised_one(call, write):
    entered = ("A 12", "E", "D 50", "0", "QX")
    program = write("p.cy525", *entered, "@verify 0")
    found = call("lint", program).out
    assert call("run", program).status == 2
    assert "@verify 0: the program that X of line 5 started may still run" in found
    advised = re.search("@until run=1 waits for its end; (@live V 0) reads through PROG/LIVE", found)
    assert "verify 0: 00012" in call("run", write("q.cy525", *entered, advised[1])).out


def test_lint_names_the_verify_group_that_reads_the_position_at_rest(call, write):
    advised = re.search("at rest, (@verify .) reads the position", call("lint", write("p.cy525", "@read position")).out)
    assert "verify 0: 00012" in call("run", write("q.cy525", "A 12", advised[1])).out


@pytest.mark.parametrize("lines", [("X",), ("E", "Q", "X"), ("E", "0", "QI", "X"), ("J 0",), ("@read position",)])
def test_run_hangs_where_lint_warns_of_it(call, write, lines):
    program = write("p.cy525", *lines)
    assert call("run", program, "-q", "--timeout", "1 s").status == 1
    assert "1 warning" in call("lint", program).out


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (
            "E}",
            "extra-argument: ENTER takes no argument; } is ignored; the manual prints } for the return key",
        ),
        ("A 0}", "bad-number: ABSOLUTE 0}: not a decimal number; ignored; the manual prints } for the return key"),
        ("D", "missing-argument: DELAY needs delay; ignored; in the CY512 D ran the program: here X does"),
        ("X 5", "extra-argument: EXECUTE takes no argument; 5 is ignored; in the CY512 X was the delay: here D is"),
        ("r 5", "unknown-command: r is not a command; the line is ignored; write R: command letters are upper case"),
        ("K 5", "unknown-command: K is not a command; the line is ignored\n"),
        ("R x", "bad-number: RATE x: not a decimal number; ignored\n"),
    ],
)
def test_run_suggests_a_replacement(call, write, line, told):
    assert f"! {told}" in call("run", write("p.cy525", "E", "0", "Q", line, "@wait 1 ms"), "--until", "5 ms").out


def test_run_refuses_the_zero_of_the_manual_and_suggests_a_replacement(call, write):
    ran = call("run", write("p.cy525", "E", "\u00d8", "Q"))
    assert ran.status == 2 and "write 0 for a slashed zero" in ran.err
    ran = call("run", write("p.gs-c200", "S10\u2193"))
    assert ran.status == 2 and "leave out the symbol of the return key" in ran.err
    ran = call("run", write("p.cy525", "R \u00b2"))
    assert ran.status == 2 and "@bytes sends other bytes" in ran.err


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


def test_describe_finds_the_mark_of_labels(call):
    assert call("describe", "cy525", "$").out.startswith("# LABEL: names the next instruction\n")
    assert call("describe", "cy525", "$", "--json").json["labels"] == "ABCDE"
    assert call("describe", "gs-c200", "$").status == 2


@pytest.mark.parametrize(
    ("command", "word"), [("\u00d8", "write 0"), ("}", "leave it out"), ("K", "it has A (ABSOLUTE)")]
)
def test_describe_helps_with_the_signs_of_the_manual(call, command, word):
    ran = call("describe", "cy525", command)
    assert ran.status == 2 and f"cy525 has no command {command!r}; " in ran.err and word in ran.err


def test_describe_explains_the_letter_in_the_cy512(call):
    assert "\n- in the CY512 D ran the program: here X does" in call("describe", "cy525", "D").out
    assert "CY512" not in call("describe", "cy525", "R").out


@pytest.mark.parametrize(
    ("name", "meant"), [("gsc200", "gs-c200"), ("CY525N", "cy525"), ("mc1451", "mc1451a"), ("gs_c200t", "gs-c200")]
)
def test_a_chip_that_is_not_there_is_guessed(call, name, meant):
    ran = call("describe", name)
    assert ran.status == 2 and ran.err.endswith(f"; did you mean {meant}?\n")
    assert "did you mean" not in call("describe", "z80").err


def test_describe_as_json_has_everything(call):
    found = call("describe", "cy525", "--json").json
    assert len(found["commands"]) == len(SHEET.commands) and len(found["pins"]) == 40
    assert {register["name"] for register in found["registers"]} == {row.name for row in SHEET.registers}
    assert found["times"]["wait_poll"]["us"] == SHEET.times["wait_poll"].us


def test_describe_on_a_terminal_is_typeset(monkeypatch, capsys):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    assert invoke(["describe", "cy525", "L"]) == 0
    text = capsys.readouterr().out
    assert "LOOP: " in text and "# LOOP" not in text and "- ASCII" not in text


def test_chips(call):
    assert call("chips").out.startswith("cy525       CY525 intelligent ramping")
    assert call("chips", "--json").json[0]["chip"] == "cy525"
