"""The examples run as they stand, and print what lies beside them."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from slewline.cli.main import invoke

EXAMPLES = Path(__file__).parents[2] / "examples"
SCRIPTS = sorted(EXAMPLES.glob("*.py"))
CIRCUITS = sorted((EXAMPLES / "cy545").glob("*.toml"))


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_an_example_prints_its_documented_output(script, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # it needs nothing from where it is started, and leaves nothing there
    runpy.run_path(str(script), run_name="__main__")
    assert capsys.readouterr().out == script.with_suffix(".out").read_text("utf-8")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("file", CIRCUITS, ids=lambda path: path.stem)
def test_a_bench_file_of_a_circuit_runs_as_is_written_down(file, capfd):
    assert invoke(["run", str(file)]) == 0
    assert capfd.readouterr().out == file.with_suffix(".out").read_text("utf-8")


def test_an_example_is_shorter_than_twenty_lines():
    for script in (*SCRIPTS, *CIRCUITS):
        assert len(script.read_text("utf-8").splitlines()) < 20, script.stem


def test_there_is_an_example_for_each_circuit():
    circuits = "gpib handoff host_computer position_latch prom shared_bus synchronised uart welding_machine"
    assert set(circuits.split()) <= {script.stem for script in SCRIPTS}
