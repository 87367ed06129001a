"""slewline translate: what it prints, as text and as data, and what a user who makes a mistake reads."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

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


def test_what_is_not_possible_fails_the_command(call: Any, tmp_path: Path) -> None:
    program = tmp_path / "fast.cy525"
    program.write_text("F 3\nR 127\nS 200\nN 900\n+\nG\n")
    found = call("translate", str(program), "--to", "cy512")
    assert found.status == 1
    report = found.err
    assert "9674.58" in report and "174 to 5000 steps/s" in report and "moves take longer" in report


def test_strict_writes_nothing_and_lists_what_is_not_the_same(call: Any, tmp_path: Path) -> None:
    result = tmp_path / "weld.gs-c200s"
    found = call("translate", str(WELD), "--to", "gs-c200s", "--strict", "-o", str(result))
    assert found.status == 1 and not result.exists()
    assert "6 lines are not the same" in found.err and "line 7: R 80: nearly" in found.err


@rows(
    ("text", "arguments", "says"),
    [
        ("R 80\n", ("--to", "cy52"), "no target 'cy52'; there are: cy525"),
        ("R 80\n", ("--to", "cy525", "--crystal", "40 MHz"), "MHz"),
        ("hello world\n", ("--to", "cy525"), "line 1, column 1"),
        ("R 80\nK 7\n", ("--to", "cy525"), "line 2, column 1: K is not a command"),
        ("R 999\n", ("--to", "cy525"), "R 999: allowed 1..255"),
        ("; nothing\n", ("--to", "cy525"), "has no commands"),
        ("R 80\n", ("--to", "linuxcnc", "--steps-per-mm", "0"), "allowed more than 0"),
        ("R 80\n", ("--to", "cy525", "--plot", "x.svg"), "needs --prove"),
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


def test_files_that_are_no_programs_are_refused(call: Any, tmp_path: Path) -> None:
    binary = tmp_path / "dump.cy525"
    binary.write_bytes(bytes(range(256)))
    assert "is not UTF-8 text" in call("translate", str(binary), "--to", "gs-c200s").err
    assert "slewline dis" in call("translate", str(HEX), "--chip", "cy525", "--to", "gs-c200s").err
    assert "each of its chips" in call("translate", str(BENCH), "--to", "gs-c200s").err
    assert "uses that file already" in call("translate", str(WELD), "--to", "cy512", "-o", str(WELD)).err


@pytest.mark.parametrize("crystal", ["11 MHz", "5.5 MHz"])
def test_a_crystal_that_is_given_counts_and_one_that_is_missing_is_assumed(call: Any, crystal: str) -> None:
    found = call("translate", str(WELD), "--to", "gs-c200s", "--crystal", crystal)
    assert "assumed  crystal" not in found.err
    assert ("T598" in found.out) == (crystal == "11 MHz")
