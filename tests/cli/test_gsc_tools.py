"""The command line for the GS-C modules: asm, dis, lint, describe, chips, run."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

import slewline

EXAMPLES = Path(__file__).parents[2] / "examples"
LINES = ("Po", "S10", "T100", "R10", "+50", "A1", "D1", "C1", "E")
FAST = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}


@pytest.fixture
def program(write):
    return write("p.gs-c200s", *LINES)


# --------------------------------------------------------------------------------------------------- without running
def test_chips_are_listed(call):
    chipsets = [f"mc1{axes}51a{dash}" for dash in ("", "-e") for axes in (1, 2, 4)]
    assert [line.split()[0] for line in call("chips").out.splitlines()] == [
        "cy525",
        "cy500",
        "cy512",
        "cy545",
        "cy545b",
        "gs-c200",
        "gs-c200s",
        *chipsets,
    ]


def test_asm_lists_locations_and_counts_them(call, program):
    ran = call("asm", program)
    assert (ran.status, ran.err) == (0, "")
    assert ran.out.splitlines() == [
        "000  53 0A 00 00  S10",
        "004  54 64 00 00  T100",
        "008  52 0A 00 00  R10",
        "012  2B 32 00 00  +50",
        "016  41 01        A1",
        "018  44 01        D1",
        "020  43 01        C1",
        "; 22 of 119 locations",
    ]


@pytest.mark.parametrize(("name", "locations"), [("bar", 50), ("drill", 36)])
def test_asm_counts_the_printed_programs(call, name, locations):
    ran = call("asm", str(EXAMPLES / "drill" / f"{name}.gs-c200"))
    assert ran.out.splitlines()[-1] == f"; {locations} of 119 locations"


@pytest.mark.parametrize(
    ("options", "sent"),
    [
        ((), b"Po\rS10\rT100\rR10\r+50\rA1\rD1\rC1\rE\r"),
        (("--checksum",), b"Po?\rS104\rT100u\rR103\r+50\x10\rA1r\rD1u\rC1t\rEU\r"),
    ],
)
def test_asm_as_the_lines_of_a_host(call, program, options, sent):
    assert call("asm", program, "--format", "ascii", *options, "-o", "out").status == 0
    assert Path("out").read_bytes() == sent


def test_missing_features_of_the_parts_are_refused(call, program, write):
    ran = call("asm", program, "--format", "binary")
    assert (ran.status, ran.err) == (
        2,
        "slewline: the GS-C200S has no binary commands; choose ascii, the form that a host sends\n",
    )
    ran = call("asm", write("p.cy525", "G"), "--checksum")
    assert (ran.status, ran.err) == (
        2,
        "slewline: --checksum: the CY525 has no checksums; leave out --checksum\n",
    )
    ran = call("dis", write("p.hex", "41 01"), "--chip", "gs-c200", "--stream")
    assert ran.status == 2 and "has no binary mode" in ran.err


def test_asm_refuses_what_does_not_fit_into_the_memory(call, write):
    ran = call("asm", write("p.gs-c200", "P", *["A1"] * 60, "E"))
    assert ran.status == 1 and ran.out == ""
    assert (
        "p.gs-c200, line 61, column 1: 120 locations of program; this instruction does not fit: allowed 119" in ran.err
    )


def test_dis_returns_the_input_of_asm(call, program):
    call("asm", program, "-o", "p.hex")
    text = call("dis", "p.hex", "--chip", "GS-C200S").out
    assert [line.split(";")[0].strip() for line in text.splitlines()] == [*LINES[:-1], "Px"]
    Path("q.gs-c200s").write_text(text)
    assert call("asm", "q.gs-c200s", "--format", "hex").out == Path("p.hex").read_text()
    (first, *_) = call("dis", "p.hex", "--chip", "gs-c200s", "--json").json["lines"]
    assert first == {"address": 0, "data": "530a0000", "name": "START_STOP", "values": [10]}


def test_dis_refuses_more_than_the_memory_holds(call, write):
    ran = call("dis", write("p.hex", "41 01 " * 60), "--chip", "gs-c200")
    assert ran.status == 2 and "120 bytes; the program buffer has 119; check the file name" in ran.err


def test_lint_takes_the_part_from_the_extension(call, write):
    ran = call("lint", write("p.gs-c200s", "Po", "g+1", "j0", "Px"), write("q.gs-c200", "P", "g+1", "j0"))
    assert ran.status == 1
    assert "p.gs-c200s: 1 warning" in ran.out and "q.gs-c200: 2 errors" in ran.out


@pytest.mark.parametrize("path", sorted(EXAMPLES.rglob("*.gs-c200*")), ids=lambda path: path.name)
def test_the_examples_have_neither_errors_nor_warnings(call, path):
    ran = call("lint", "--strict", str(path))
    assert ran.status == 0, ran.out


def test_describe_a_part_and_a_command(call):
    assert call("describe", "gs-c200").out.startswith("# GS-C200 intelligent stepper motor controller module\n")
    assert call("describe", "gs_c200s", "jc").out.startswith("# JUMP_ON: ")
    assert [row["name"] for row in call("describe", "gs-c200", "G", "--json").json["commands"]] == [
        "GOTO",
        "VELOCITY",
        "CONTROLLED_VELOCITY",
    ]
    assert call("describe", "gs-c200", "jc").status == 2


# ------------------------------------------------------------------------------------------------------------------ run
def by_hand(lines, **straps):
    """The same dialogue without the command line."""
    bench = slewline.Bench()
    chip = bench.add("gs-c200s", straps=FAST | straps)
    host = bench.host(chip)
    for line in lines:
        host.ask(line)
    bench.run_until_idle()
    return bench, chip, host


@pytest.mark.parametrize(
    ("options", "straps"), [((), {}), (("--strap", "chs=1", "--strap", "br0=1"), {"chs": 1, "br0": 1})]
)
def test_run_queries_line_by_line_and_prints_the_answers(call, program, options, straps):
    ran = call("run", program, *options, "--json", "-", "--steps", "s.csv")
    bench, chip, host = by_hand(LINES, **straps)
    found = ran.json
    assert (ran.status, found["chip"], found["crystal_hz"], found["ended"]) == (0, "gs-c200s", None, "idle")
    assert (found["time_ps"], found["position"], found["received"]) == (bench.now_ps, 50, host.received.hex())
    assert found["pins"]["chs"] == straps.get("chs", 0) and found["program"] == chip.program.hex()
    with open("s.csv") as file:
        assert [int(row["time_ps"]) for row in csv.DictReader(file)] == chip.steps().times_ps.tolist()


def test_the_transcript_of_a_run(call, program):
    out = call("run", program).out.splitlines()
    assert [line.split(maxsplit=1)[1] for line in out[:-2]] == [
        "gs_c200s  RESET high",
        *(f"host      {line} -> Y" for line in LINES),
        "gs_c200s  moves cw from 0",
        "gs_c200s  at rest at 50: 50 steps in 78.316713 ms",
        "gs_c200s  UO1 high",
        "gs_c200s  UO1 low",
    ]
    assert out[-1] == "gs_c200s (gs-c200s): position 50, 50 steps, up to 1000 steps/s, 0 findings"


def test_errors_are_reported_with_their_meaning_and_count_if_strict(call, write):
    program = write("p.gs-c200", "P", "A4", "f+1", "E", "@until ready")
    ran = call("run", program, "--strict")
    told = [line[15:] for line in ran.out.splitlines()]
    assert ran.status == 1
    assert "host     A4 -> E2 (argument missing, wrong or out of range)" in told
    assert "gs_c200  ! E2: A4: output 4, allowed 1..3; the nearest is 3" in told
    assert "host     f+1 -> E4 (unknown, or not allowed now)" in told
    assert "host     E -> E4 (unknown, or not allowed now)" in told


def test_inputs_are_reported_with_the_waiting_command(call, write):
    program = write("p.gs-c200", "@drive ui2=0", "P", "W2", "E", "@wait 30 ms", "@drive ui2=1")
    assert "UI2 high (waiting for ui2=1 (W2) since 17.299479 ms)" in call("run", program).out


def test_a_bench_of_two_modules(call):
    ran = call("run", str(EXAMPLES / "drill" / "looped.toml"), "--json", "-")
    chips = ran.json["chips"]
    assert (chips["bar_unit"]["position"], chips["drill_unit"]["position"]) == (980, 0)
    assert chips["drill_unit"]["steps"]["count"] == 1500


@pytest.mark.parametrize(
    ("name", "position", "count"),
    [
        ("long_move.gs-c200", 500_000, 500_000),
        ("long_move.gs-c200s", 500_000, 500_000),
        ("two_ramps.gs-c200", 2200, 3800),
        ("segments.gs-c200s", 30, 90),
    ],
)
def test_the_examples_do_what_their_comments_promise(call, name, position, count):
    ran = call("run", str(EXAMPLES / "programs" / name), "--timeout", "600 s", "--strict", "--json", "-")
    assert (ran.status, ran.json["position"], ran.json["steps"]["count"]) == (0, position, count)


def test_a_hex_file_holds_what_goes_over_the_line(call, write):
    ran = call("run", write("p.hex", "56 31 0D ; V1", "56 32 0D"), "--chip", "gs-c200", "--json", "-")
    assert bytes.fromhex(ran.json["received"]) == b"V0\rV70\r"


def test_a_journal_is_replayed(call, program):
    call("run", program, "-q", "--journal", "j.jsonl", "--json", "a.json")
    call("run", "--replay", "j.jsonl", "-q", "--json", "b.json")
    assert json.loads(Path("a.json").read_text()) == json.loads(Path("b.json").read_text())


def test_pins_and_ramps_are_drawn(call, program):
    ran = call("run", program, "--vcd", "p.vcd", "--plot", "p.svg")
    assert ran.out.endswith("wrote p.vcd\nwrote p.svg\n")
    assert ">ramp<" in Path("p.svg").read_text() and "T = 100" in Path("p.svg").read_text()
    assert "clock" in Path("p.vcd").read_text()


@pytest.mark.parametrize(
    ("options", "found"),
    [
        (("p.gs-c200s", "--crystal", "1 MHz"), "the gs-c200s has no selectable crystal"),
        (("p.gs-c200s", "--strap", "clock=1"), "a strap sets an input to 0 or 1"),
        (("p.gs-c200s", "--strap", "chs=2"), "is not a level; levels are 0 (low) and 1 (high)"),
        (
            ("p.txt",),
            "no chip given; give --chip cy525, or a file name ending in .cy525, .cy500, .cy512, .cy545",
        ),
        (
            ("p.txt", "--chip", "gs-c201"),
            "no chip 'gs-c201'; available: cy525, cy500, cy512, cy545, cy545b, gs-c200, gs-c200s",
        ),
    ],
)
def test_wrong_use(call, program, write, options, found):
    write("p.txt", "F")
    ran = call("run", *options)
    assert ran.status == 2 and found in ran.err
