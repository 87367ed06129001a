"""Every bench of the examples for every part: what the report does not name is the same when both benches run."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from slewline.chips import PARTS
from slewline.errors import UsageError
from slewline.translation.proof.prove_bench import prove_bench
from slewline.translation.translation_report import LineKind
from slewline.translation.whole_bench import BenchTranslation, translate_bench
from tests.ensembles import few
from tests.translation.programs import EXAMPLES

BENCHES = sorted(path for path in EXAMPLES.rglob("*.toml") if "[[chip]]" in path.read_text())
EVERY_RUN = ("gs-c200s", "mc1451a")


def bench(name: str) -> Path:
    """Return a bench of the examples."""
    return next(path for path in BENCHES if path.name == name)


def written(done: BenchTranslation, folder: Path) -> Path:
    """Write a result next to the other files of its source, and return the bench file."""
    shutil.copytree(Path(done.where).parent, folder, dirs_exist_ok=True)
    for name, text in done.files.items():
        (folder / name).write_text(text)
    return folder / done.bench


def impossible(done: BenchTranslation) -> list[str]:
    """Return the lines of the programs that are not possible, and the tables that are left out."""
    lines = [line for each in done.programs.values() for line in each.report]
    found = [line.code for line in lines if line.kind is LineKind.IMPOSSIBLE]
    return found + [line.what for line in done.lines if not line.becomes]


@pytest.mark.parametrize("path", few(BENCHES, 6), ids=lambda path: path.stem)
@pytest.mark.parametrize(
    "to",
    [to for to in PARTS if to in EVERY_RUN]
    + [pytest.param(to, marks=pytest.mark.long) for to in PARTS if to not in EVERY_RUN],
)
def test_what_the_report_does_not_name_is_the_same(path: Path, to: str, tmp_path: Path) -> None:
    try:
        done = translate_bench(path, to)
    except UsageError as error:
        assert "no host has commands" in str(error)
        return
    proof = prove_bench(done, written(done, tmp_path))
    assert proof.proven or impossible(done), [each.text for each in proof.compared.values()]


def test_relative_moves_after_a_limit_switch_have_no_counterpart_in_positions(tmp_path: Path) -> None:
    done = translate_bench(bench("limits.toml"), "mc1451a")
    report = done.programs["x"].report
    assert [line.kind for line in report if line.code == "G"] == [LineKind.NEARLY, *[LineKind.IMPOSSIBLE] * 2]
    assert "the position before it is unknown" in report.lines[-1].verdicts[0].description
    assert not prove_bench(done, written(done, tmp_path)).proven


def test_so_they_have_at_a_part_with_relative_moves(tmp_path: Path) -> None:
    done = translate_bench(bench("limits.toml"), "cy545")
    assert not impossible(done) and prove_bench(done, written(done, tmp_path)).proven


def test_parts_without_a_pin_at_the_target_are_left_out_with_the_lines_for_them(tmp_path: Path) -> None:
    done = translate_bench(bench("thumbwheels.toml"), "gs-c200s")
    (line,) = [line for line in done.lines if "thumbwheels" in line.what]
    assert "needs a pin" in line.remedy and not line.becomes
    assert '# kind = "thumbwheels"' in done.files[done.bench]
    assert "; NOT POSSIBLE: @tell wheels turn 40" in done.files["x.gs-c200s"]
    prove_bench(done, written(done, tmp_path))  # it loads and runs


def test_a_level_that_delays_a_start_is_not_a_stop() -> None:
    for to, pin in (("mc1451a", "has no abort input"), ("cy512", "abort of the CY512")):
        report = translate_bench(bench("together.toml"), to).programs["x"].report
        assert report.lines[0].kind is LineKind.IMPOSSIBLE and pin in report.lines[0].verdicts[0].limit
    assert translate_bench(bench("together.toml"), "cy545").programs["x"].report.lines[0].kind is LineKind.SAME
