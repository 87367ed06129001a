"""The command line for chipsets that take packets: run, with all that it writes."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

import slewline
from slewline.chips import checks_of, sheet_of
from slewline.language.lint import lint

EXAMPLES = Path(__file__).parents[2] / "examples" / "mc1451a"
TWO_AXES = (
    "SET_POS 20",
    "SET_VEL 65536",
    "SET_ACC 8192",
    "SET_3",
    "SET_POS -30",
    "SET_VEL 65536",
    "SET_ACC 8192",
    "MULTI_UPDATE 5",
    "wait motion_complete",
    "GET_TRGT_POS",
)


@pytest.fixture
def script(write):
    return write("two.mc1451a", *TWO_AXES)


def test_the_transcript_has_commands_answers_and_motions(call, script):
    ran = call("run", script)
    assert (ran.status, ran.err) == (0, "")
    told = [line.split(maxsplit=1)[1] for line in ran.out.splitlines()]
    assert "host     SET_3 -> 0x2300 (motor_on axis_on axis=3)" in told
    assert "host     GET_TRGT_POS -> -30" in told
    moved = [line for line in told if line.startswith("mc1451a") and "axis" in line and "steps" in line]
    assert len(moved) == 2
    assert "mc1451a  axis 1 moves from 0" in told and "mc1451a  axis 3 moves from 0" in told
    assert any(line.startswith("mc1451a  axis 3 at rest at -30: 30 steps in ") for line in told)
    assert ran.out.splitlines()[-4:] == [
        next(
            line for line in ran.out.splitlines() if line.startswith("mc1451a (mc1451a), axis 1: position 20, 20 ste")
        ),
        "mc1451a (mc1451a), axis 2: position 0, 0 steps",
        next(
            line for line in ran.out.splitlines() if line.startswith("mc1451a (mc1451a), axis 3: position -30, 30 st")
        ),
        "mc1451a (mc1451a), axis 4: position 0, 0 steps",
    ]


def test_json_has_every_axis_and_the_returned_values(call, script):
    found = call("run", script, "--json").json
    assert (found["chip"], found["ended"], found["position"]) == ("mc1451a", "idle", 20)
    assert [axis["axis"] for axis in found["axes"]] == [1, 2, 3, 4]
    assert [axis["position"] for axis in found["axes"]] == [20, 0, -30, 0]
    assert [axis["steps"]["count"] for axis in found["axes"]] == [20, 0, 30, 0]
    assert found["axes"][0]["registers"] == found["registers"]
    assert found["axes"][2]["registers"]["pos"] == -30
    assert found["results"] == [
        {"axis": 3, "command": "SET_3", "value": 0x2300},
        {"axis": 3, "command": "GET_TRGT_POS", "value": -30},
    ]
    assert found["received"].startswith("0024") and found["received"].endswith("ffffffe2fffe")


def test_steps_have_a_column_for_the_axis(call, script):
    assert call("run", script, "-q", "--steps", "steps.csv").status == 0
    rows = list(csv.DictReader(Path("steps.csv").read_text().splitlines()))
    for axis, count, sign in (("1", 20, 1), ("3", 30, -1)):
        own = [row for row in rows if row["axis"] == axis]
        assert [int(row["position"]) for row in own] == [sign * k for k in range(1, count + 1)]
        assert {row["direction"] for row in own} == {str(sign)}
    times = [int(row["time_ps"]) for row in rows]
    assert len(rows) == 50 and times == sorted(times)


def test_a_journal_repeats_the_run(call, script):
    assert call("run", script, "-q", "--journal", "run.jsonl", "--json", "one.json", "--steps", "one.csv").status == 0
    assert call("run", "--replay", "run.jsonl", "-q", "--json", "two.json", "--steps", "two.csv").status == 0
    assert Path("one.csv").read_bytes() == Path("two.csv").read_bytes()
    assert Path("one.json").read_bytes() == Path("two.json").read_bytes()


def test_all_pins_go_into_a_waveform_and_axes_that_moved_into_a_plot(call, script):
    assert call("run", script, "-q", "--vcd", "two.vcd", "--plot", "two.svg").status == 0
    vcd = Path("two.vcd").read_text()
    assert all(f" {pin} " in vcd or f".{pin} " in vcd for pin in ("pulse1", "dir4", "hostrdy", "hostdata7"))
    plot = Path("two.svg").read_text()
    shown = [axis for axis in range(1, 5) if f">axis {axis}<" in plot]
    assert shown == [1, 3]


def test_an_expectation_that_is_not_met_fails_the_run(call, write):
    script = write("x.mc1451a", "GET_VRSN", "expect 0x4C11", "GET_POS")
    ran = call("run", script)
    assert (ran.status, ran.err) == (1, "")
    assert "! expect: GET_VRSN of axis 1 returned 0x5C11, expected 0x4C11" in ran.out
    ran = call("run", script, "-q")
    assert ran.status == 1 and ran.err.endswith("returned 0x5C11, expected 0x4C11\n")
    assert call("run", write("y.mc1251a-e", "GET_VRSN", "expect 0x4C11")).status == 0


def test_strict_fails_at_any_finding(call, write):
    script = write("x.mc1451a", "SET_POS 5", "@bytes 80")
    assert call("run", script, "-q").status == 0
    ran = call("run", script, "-q", "--strict")
    assert ran.status == 1 and "illegal" in ran.err


def test_the_bytes_that_asm_makes_run_as_the_lines_do(call, write):
    script = write("x.mc1451a", *TWO_AXES[:-2])
    assert call("asm", script, "-o", "x.hex").status == 0
    reached = [call("run", file, "--chip", "mc1451a", "--json").json["axes"] for file in (script, "x.hex")]
    assert [[axis["position"] for axis in axes] for axes in reached] == [[20, 0, -30, 0]] * 2
    ran = call("run", write("bad.hex", "10 00", "00 00 0x"), "--chip", "mc1451a")
    assert ran.status == 2 and "bad.hex, line 2, column 7: '00 00 0x': bytes are pairs" in ran.err


def test_until_and_timeout(call, write):
    script = write("x.mc1151a", "SET_PRFL_VEL", "SET_VEL 65536", "SET_ACC 65536", "UPDATE")
    found = call("run", script, "--json", "--until", "100 ms").json
    assert (found["ended"], found["time_ps"]) == ("until", 10**11)
    assert 250 < found["position"] < 310
    ran = call("run", script, "--json", "--timeout", "100 ms")
    assert ran.status == 1 and "timed out: waited 100 ms" in ran.err
    assert ran.json["position"] == found["position"] and len(ran.json["axes"]) == 1


def test_drive_from_the_command_line(call, write):
    script = write("x.mc1451a", "wait 20 ms", "GET_HOME")
    assert call("run", script, "--json", "--drive", "home2=0@10 ms").json["results"][-1]["value"] == 0x000D


def test_mistakes_are_reported_before_anything_runs(call, write):
    ran = call("run", write("x.mc1151a", "SET_POS 5", "  SET_2", "wait moving"))
    assert (ran.status, ran.out) == (2, "")
    assert "x.mc1151a, line 2, column 3: SET_2 is not a command of the MC1151A" in ran.err
    assert "x.mc1151a, line 3, column 1: mc1151a has no status bit 'moving'" in ran.err


@pytest.mark.parametrize(
    ("name", "positions", "reported"),
    [
        ("homing.mc1451a", [500, 0, 0, 0], []),
        ("limit_recovery.mc1451a", [0, 30000, 0, 0], ["command-error"]),  # farther into the switch
        ("four_axes.mc1451a", [6000, -3000, 4000, None], []),
        ("stall_recovery.toml", [2000, 0, 0, 0], ["motion-error"]),
    ],
)
def test_the_examples_do_what_their_comments_promise(call, name, positions, reported):
    ran = call("run", str(EXAMPLES / name), "--json")
    assert (ran.status, ran.err == "") == (0, not reported)
    found = json.loads(ran.out)
    found = found["chips"]["x"] if "chips" in found else found
    reached = [axis["position"] for axis in found["axes"]]
    assert [p if wanted is not None else None for p, wanted in zip(reached, positions, strict=True)] == positions
    assert [one["code"] for one in found["findings"]] == reported


@pytest.mark.parametrize(
    "name", ["homing.mc1451a", "limit_recovery.mc1451a", "four_axes.mc1451a", "stall_recovery.toml"]
)
def test_the_examples_have_neither_errors_nor_warnings(call, name):
    ran = call("lint", str(EXAMPLES / name), "--strict")
    assert (ran.status, ran.err) == (0, "")


def test_a_script_for_a_bench_file_needs_its_bench_for_run_and_for_lint(call):
    script = str(EXAMPLES / "stall_recovery.mc1451a")
    told = "line 10, column 1: {}the bench has no part 'shaft'; available: host"
    ran, linted = call("run", script), call("lint", script)
    assert (ran.status, linted.status) == (2, 1)
    assert told.format("") in ran.err and told.format("error: ") in linted.out


LIMITS = ("SET_START_VEL 9", "SET_ACC 9", "SET_MAX_ACC 9", "SET_JERK 99999")


def test_lint_warns_of_a_move_that_does_not_start_where_run_has_a_finding(subtests):
    for mode in ("", "SET_PRFL_TRAP", "SET_PRFL_S_CRV", "SET_PRFL_VEL"):
        for count in range(1 << len(LIMITS)):
            given = [limit for bit, limit in enumerate(LIMITS) if count >> bit & 1]
            lines = [mode, *given, "SET_VEL 65536", "SET_POS 5", "UPDATE"]
            text = "\n".join(line for line in lines if line)
            with subtests.test(text):
                bench = slewline.Bench()
                bench.host(bench.add("mc1451a")).send(text)
                bench.run("10 ms")
                found = {problem.code for problem in lint(text, sheet_of("mc1451a"), checks_of("mc1451a"))}
                assert ("no-start" in found) == ("no-start" in {finding.code for finding in bench.findings})


def test_every_example_is_run_here_but_those_in_c():
    here = [path for path in EXAMPLES.iterdir() if path.suffix not in (".c", ".h")]
    assert {path.stem for path in here} == {"homing", "limit_recovery", "four_axes", "stall_recovery"}
