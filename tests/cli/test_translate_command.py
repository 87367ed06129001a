"""slewline translate: what it prints, as text and as data, and what a user who makes a mistake reads."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import slewline
from tests.rows import rows

WELD = Path(__file__).parents[2] / "examples/programs/weld.cy525"
BENCH = Path(__file__).parents[2] / "examples/drill/looped.toml"
HEX = Path(__file__).parents[2] / "examples/programs/five_steps.hex"


def test_the_result_goes_to_the_standard_output_and_the_report_to_the_standard_error(call: Any) -> None:
    found = call("translate", str(WELD), "--to", "gs-c200s", "--prove")
    assert found.status == 0
    assert found.out.startswith("; WARNING") and "\nPo\n" in found.out
    report = found.err.splitlines()
    assert report[0].endswith("cy525 to gs-c200s: 19 lines: 13 same, 6 nearly, 0 not possible")
    assert any(line.startswith("wire     pulse -> clock") for line in report)
    assert any(line.startswith("assumed  crystal: 11 MHz") for line in report)
    assert report[-1].startswith("proof    the same: 7 moves")


def test_with_an_output_the_report_is_printed_and_the_picture_written(call: Any, tmp_path: Path) -> None:
    result, picture = tmp_path / "weld.gs-c200s", tmp_path / "both.svg"
    found = call("translate", str(WELD), "--to", "gs-c200s", "-o", str(result), "--prove", "--plot", str(picture))
    assert found.status == 0 and "13 same" in found.out and f"wrote {result}" in found.out
    assert result.read_text().startswith("; WARNING") and picture.read_text().startswith("<?xml")
    assert call("lint", str(result)).status == 0


def test_as_data_each_line_has_its_kind(call: Any) -> None:
    found = json.loads(call("translate", str(WELD), "--to", "gs-c200s", "--prove", "--json").out)
    assert found["counts"] == {"same": 13, "nearly": 6, "not possible": 0}
    assert found["proof"]["proven"] and found["proof"]["moves"] == 7
    (rate,) = [line for line in found["lines"] if line["code"] == "R 80"]
    assert rate["written"] == ["T598"] and rate["kind"] == "nearly" and 0 < rate["verdicts"][0]["off"] < 0.001


def test_an_impossible_translation_fails_the_command(call: Any, tmp_path: Path) -> None:
    program = tmp_path / "fast.cy525"
    program.write_text("F 3\nR 127\nS 200\nN 900\n+\nG\n")
    found = call("translate", str(program), "--to", "cy512")
    assert found.status == 1
    report = found.err
    assert "9674.58" in report and "174 to 5000 steps/s" in report and "moves take longer" in report


def test_strict_writes_nothing_and_lists_the_differences(call: Any, tmp_path: Path) -> None:
    result = tmp_path / "weld.gs-c200s"
    found = call("translate", str(WELD), "--to", "gs-c200s", "--strict", "-o", str(result))
    assert found.status == 1 and not result.exists()
    assert "6 lines are not the same" in found.err and "line 7: R 80: nearly" in found.err


@rows(
    ("text", "arguments", "says"),
    [
        ("R 80\n", ("--to", "cy52"), "no target 'cy52'; known: cy525"),
        ("R 80\n", ("--to", "cy525", "--crystal", "40 MHz"), "MHz"),
        ("hello world\n", ("--to", "cy525"), "line 1, column 1"),
        ("R 80\nK 7\n", ("--to", "cy525"), "line 2, column 1: K is not a command"),
        ("R 999\n", ("--to", "cy525"), "R 999: allowed 1..255"),
        ("; nothing\n", ("--to", "cy525"), "has no commands"),
        ("R 80\n", ("--to", "linuxcnc", "--steps-per-mm", "0"), "allowed more than 0"),
        ("R 80\n", ("--to", "cy525", "--plot", "x.svg"), "needs --prove"),
        ("R 80\n", ("--to", "grbl", "--set", "repeats"), "write NAME=VALUE"),
        ("R 80\n", ("--to", "grbl", "--set", "repeats=x"), "allowed 1 or more"),
        ("R 80\n", ("--to", "linuxcnc", "--axis", "Q"), "axis Q: allowed X, Y, Z"),
        ("A\nE\n" + "N 1\nG\n" * 20 + "Q\n", ("--to", "cy525"), "allowed 48 (CY512 manual, guide)"),
    ],
)
def test_a_mistake_is_answered_with_place_what_was_found_what_is_allowed_and_a_remedy(
    call: Any, tmp_path: Path, text: str, arguments: tuple[str, ...], says: str
) -> None:
    program = tmp_path / "mine.cy512"
    program.write_text(text)
    found = call("translate", str(program), *arguments)
    assert found.status in (1, 2) and says in found.err.replace("RATE", "R"), found.err


def test_a_program_for_another_part_is_recognised(call: Any) -> None:
    found = call("translate", str(WELD), "--chip", "gs-c200", "--to", "gs-c200s")
    assert found.status == 1 and "It looks like a program for the cy525" in found.err


def test_invalid_programs_are_refused(call: Any, tmp_path: Path) -> None:
    binary = tmp_path / "dump.cy525"
    binary.write_bytes(bytes(range(256)))
    assert "is not UTF-8 text" in call("translate", str(binary), "--to", "gs-c200s").err
    assert "slewline dis" in call("translate", str(HEX), "--chip", "cy525", "--to", "gs-c200s").err
    assert "--output FOLDER" in call("translate", str(BENCH), "--to", "gs-c200s").err
    assert "for each chip" in call("translate", str(BENCH), "--to", "gs-c200s", "--chip", "gs-c200").err
    assert "already uses the file" in call("translate", str(WELD), "--to", "cy512", "-o", str(WELD)).err


@pytest.mark.parametrize("crystal", ["11 MHz", "5.5 MHz"])
def test_a_crystal_that_is_given_counts_and_one_that_is_missing_is_assumed(call: Any, crystal: str) -> None:
    found = call("translate", str(WELD), "--to", "gs-c200s", "--crystal", crystal)
    assert "assumed  crystal" not in found.err
    assert ("T598" in found.out) == (crystal == "11 MHz")


# -------------------------------------------------------------------------------------------------------- whole benches
def test_a_bench_becomes_a_folder_with_a_bench_that_runs_and_each_chip_is_proven(call: Any, tmp_path: Path) -> None:
    found = call("translate", str(BENCH), "--to", "gs-c200s", "-o", str(tmp_path / "new"), "--prove")
    assert found.status == 0
    assert {path.name for path in (tmp_path / "new").iterdir()} == {
        "bench.toml",
        "bar_unit.gs-c200s",
        "drill_unit.gs-c200s",
    }
    proofs = [line for line in found.out.splitlines() if line.startswith("proof")]
    assert [line.split()[1] for line in proofs] == ["bar_unit:", "drill_unit:"]
    assert all("the same: " in line for line in proofs)
    assert call("run", str(tmp_path / "new" / "bench.toml"), "-q").status == 0


def test_features_that_the_target_lacks_are_listed_and_become_comments(call: Any, tmp_path: Path) -> None:
    found = call("translate", str(BENCH), "--to", "cy525", "-o", str(tmp_path / "new"), "--prove")
    assert found.status == 1
    text = (tmp_path / "new" / "bench.toml").read_text()
    assert "# NOT POSSIBLE: the CY525 has no pin for bar_unit.uo2\n# [[wire]]" in text
    assert 'from = "drill_unit.programmable_output"\nto = "bar_unit.dowhile"' in text
    assert "# The drilling machine of the GS-C data sheet" in text
    assert "bench    [[wire]] bar_unit.uo2, drill_unit.ui2 => nothing; the CY525" in found.out
    assert 'bench    [[part]] kind = "drill", to = "drill_unit" => nothing; drill: ' in found.out
    assert '# kind = "drill"' in text and slewline.load(tmp_path / "new" / "bench.toml").chips


def test_chips_of_a_bench_become_a_controller_each_and_the_wires_are_listed(call: Any, tmp_path: Path) -> None:
    found = call("translate", str(BENCH), "--to", "linuxcnc", "-o", str(tmp_path / "new"), "--prove")
    assert {path.name for path in (tmp_path / "new").iterdir()} == {"bar_unit.ngc", "drill_unit.ngc"}
    assert "bar_unit: motion.digital-out-01 -> drill_unit: motion.digital-in-01" in found.out
    assert "a controller with linuxcnc for each chip" in found.out
    data = json.loads(call("translate", str(BENCH), "--to", "grbl", "-o", str(tmp_path / "grbl"), "--json").out)
    assert set(data["programs"]) == {"bar_unit", "drill_unit"} and data["refused"] == ""
    assert any(line["becomes"] == "" and "ui2" in line["what"] for line in data["bench"])


PAIR = """
[[chip]]
part = "cy525"
name = "one"
crystal = "11 MHz"

[[chip]]
part = "cy525"
name = "two"

[[wire]]
from = "one.programmable_output"
to = "two.wait"

[[host]]  # begins first
chips = ["two"]
script = ["A 0", "F 10", "R 80", "S 240", "Z 1", "N 500", "E", "U", "G", "0", "QX"]

[[host]]
chips = ["one"]
delay = "20 ms"
script = ["A 0", "F 10", "R 80", "S 240", "Z 1", "N 500", "E", "C", "G", "0", "QX"]

[[record]]
pins = ["one.pulse", "two.pulse"]
"""


def test_scripts_in_a_bench_become_files_and_pins_get_the_names_of_the_target(call: Any, tmp_path: Path) -> None:
    (tmp_path / "pair.toml").write_text(PAIR)
    found = call("translate", str(tmp_path / "pair.toml"), "--to", "cy512", "-o", str(tmp_path / "new"), "--prove")
    text = (tmp_path / "new" / "bench.toml").read_text()
    assert text.count('part = "cy512"') == 2 and '# was: crystal = "11 MHz"' in text
    assert '[[host]]\nchips = ["one"]\nfile = "one.cy512"\ndelay = "20 ms"' in text
    assert [line for line in found.out.splitlines() if "different" in line] == []


@rows(
    ("text", "says"),
    [
        (PAIR.replace('chips = ["two"]', 'chips = ["one", "two"]'), "is connected to several chips"),
        (PAIR.replace('chips = ["two"]', 'chips = ["one"]'), "is the second host of one"),
        (PAIR[: PAIR.index("[[host]]")], "there is nothing to translate"),
        (PAIR.replace("two.wait", "two.nowhere"), "nowhere"),
        (PAIR.replace('"U"', '"K"'), "K is not a command"),
    ],
)
def test_a_mistake_in_a_bench_is_answered_with_its_place(call: Any, tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "pair.toml").write_text(text)
    found = call("translate", str(tmp_path / "pair.toml"), "--to", "cy512", "-o", str(tmp_path / "new"))
    assert found.status in (1, 2) and says in found.err, found.err


# ------------------------------------------------------------------------- where a new user with an old program stops
def test_a_loop_into_the_middle_of_an_instruction_is_refused_with_where_instructions_begin(
    call: Any, tmp_path: Path
) -> None:
    program = tmp_path / "winder.cy512"
    program.write_text("A\nR 150\nS 20\nE\nB\nW\n+\nN 1600\nG\nL 10,4\n0\nQ\nD\n")
    for to in ("cy525", "arduino", "linuxcnc"):
        found = call("translate", str(program), "--to", to)
        assert found.status == 1
        assert "line 10, column 6: LOOP to byte 4, inside N 1600 of line 8: allowed 3 or 6" in found.err
    program.write_text("A\nR 150\nS 20\nE\nN 16\nG\nL 10,9\n0\nQ\nD\n")
    assert "LOOP to byte 9" in call("translate", str(program), "--to", "arduino").err


def test_a_program_that_never_runs_proves_nothing_and_the_proof_reports_it(call: Any, tmp_path: Path) -> None:
    program = tmp_path / "press.gs-c200"
    program.write_text("P\nS25\nT300\nR60\n+1200\n")  # without E, which runs it
    found = call("translate", str(program), "--to", "gs-c200s", "--prove")
    assert "proof    nothing moved or switched on either side" in found.err


def test_repeated_lines_are_counted_in_the_report(call: Any, tmp_path: Path) -> None:
    program = tmp_path / "press.gs-c200"
    program.write_text("P\nS25\nT300\nR60\nL0\n+50\nD2\nL8\nW1\nG0\nE\n")
    found = call("translate", str(program), "--to", "grbl", "--prove")
    assert "G4 P0.2 (8 times)" in found.err
    assert found.err.splitlines()[-1].strip().startswith("a line that is not possible counts as a difference")
    assert "positions: never beyond a limit of the counter of the gs-c200 (0..9999999)" in found.err
