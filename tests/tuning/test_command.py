"""slewline tune: what it prints, writes and refuses."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

import slewline
from slewline.cli.main import invoke
from slewline.cli.motors.tune import workers_of

MOTOR = ("--motor", "QSH4218-51-10-049", "--driver", "L/4R 20 V", "--load", "inertia 68 g cm2, friction 5 mNm")
QUICK = (*MOTOR, "--steps", "24", "--grid", "F=4,30 R=8,14,40 S=200", "--perturb", "inertia 20%, current -20%")


@pytest.fixture(autouse=True)
def plain_python(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Short moves: to compile takes longer."""
    monkeypatch.setattr("slewline.tuning.judging.engine", lambda: "python")
    monkeypatch.setattr("slewline.tuning.tuning_picture.engine", lambda: "python")
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def call(capsys: pytest.CaptureFixture[str]) -> Any:
    def called(*arguments: str) -> tuple[int, str, str]:
        status = invoke(["tune", *arguments])
        return (status, *capsys.readouterr())

    return called


@pytest.mark.system
def test_printed_and_written_output(call: Any, tmp_path: Path) -> None:
    status, out, _ = call("cy525", *QUICK, "--bench", "found.toml", "--plot", "found.svg", "--store", "log.jsonl")
    lines = dict(line.split(None, 1) for line in out.splitlines() if not line.startswith((" ", "cy525", "wrote")))
    assert status == 0 and out.startswith("cy525, QSH4218-51-10-049: 24 steps, F=4,30 R=8,14,40 S=200 Z=1\n")
    assert lines["candidates"] == "6; 10 runs each"
    found = slewline.tune("cy525", motor=MOTOR[1], driver=MOTOR[3], load=MOTOR[5], steps=24, grid=QUICK[9],
                          perturb=QUICK[11], full_map=True)  # fmt: skip
    assert found.best is not None and lines["best"].startswith(
        f"F {found.best.values['F']}, R {found.best.values['R']}, S 200, Z 1: "
    )
    assert lines["runs"] == f"{found.runs} of {found.exhaustive}"
    tables = tomllib.loads((tmp_path / "found.toml").read_text("utf-8"))
    assert tables["part"][0]["driver"] == "L/4R 20 V" and tables["host"][0]["script"][-1] == "G"
    first, *others = tables["host"][0]["script"]
    assert lines["commands"] == first and "\n".join(f"              {each}" for each in others) in out
    picture = (tmp_path / "found.svg").read_text("utf-8")
    assert "Every move was simulated" in picture and "Map of R and F: " in picture
    assert len((tmp_path / "log.jsonl").read_text("utf-8").splitlines()) == 1 + found.runs
    again = call("cy525", *QUICK, "--store", "log.jsonl", "--map", "--jobs", "1")[1]
    assert f"runs          {found.runs} of {found.exhaustive}, 0 of them now" in again and "lost: " in again


@pytest.mark.system
def test_the_same_picture_has_the_same_bytes(call: Any, tmp_path: Path) -> None:
    pictures = []
    for name in ("one.svg", "two.svg"):
        assert call("cy525", *QUICK, "--plot", name, "--store", "log.jsonl")[0] == 0
        pictures.append((tmp_path / name).read_bytes())
    assert pictures[0] == pictures[1]


@pytest.mark.system
def test_as_data(call: Any) -> None:
    status, out, _ = call("cy525", *QUICK, "--json", "--map", "--jobs", "1")
    found = json.loads(out)
    assert status == 0 and found["task"]["driver"]["kind"] == "voltage" and len(found["map"]) == 6
    assert found["best"]["values"]["S"] == 200 and found["best"]["time_ps"] > 0 and found["candidates"] == 6
    assert "map" not in json.loads(call("cy525", *QUICK, "--json")[1])


def test_jobs_are_processes_and_a_map_takes_all_processors(monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[int] = []
    monkeypatch.setattr("slewline.cli.motors.tune.processes", taken.append)
    monkeypatch.setattr("os.cpu_count", lambda: 5)
    for jobs, full_map in ((None, False), (None, True), (3, True), (3, False)):
        workers_of(jobs, None, full_map)
    assert taken == [1, 5, 3, 3]


@pytest.mark.parametrize(("arguments", "says"), [
    (("--grid", "Q=3"), "cy525: no parameter 'Q'; available: F, R, S, Z, ramp_unit, ramp_jumps"),
    (("--grid", "F="), "cy525: F '': no values; allowed a range such as 3..10"),
    (
        ("--grid", "F=0..127 R=0..127 S=1..255"),
        "4177920 points; allowed up to 1000000; use fewer values: /12 after a range takes 12 of its values",
    ),
    (("--perturb", "lod 20%"), "perturbation 'lod'; known: load, inertia"),
    (
        ("--stepping", "quarter"),
        "steps 'quarter'; allowed 'full', 'wave', 'half', or 'micro' and a number ('micro 8')",
    ),
    (("--steps", "0"), "cy525: a move of 0 steps; allowed 1 or more"),
    (
        ("--steps", "70000"),
        "none of the 6 grid points gives a valid move; error at the first: cy525: a move of 70000 steps;",
    ),
    (("--jobs", "0"), "jobs 0; allowed 1..256 processes"),
    (("--jobs", "1", "--dask", "tcp://x:1"), "--jobs and --dask: give one of the two"),
    (("--store", "nowhere/log.jsonl"), "nowhere/log.jsonl: no directory 'nowhere'; create it, or name another"),
    (("--plot", "found.gif"), "found.gif: give a name that ends in .svg, .png or .pdf"),
    (("--bench", "found.txt"), "found.txt: give a name that ends in .toml"),
    (("--motor", "QSH4218-51-10-94"), "motor 'QSH4218-51-10-94'; known: "),
    (("--driver", "24 hamsters"), "driver"),
    (("--load", "torque 3 Nm"), "load: "),
    (("--load", "inertia -1"), "load: inertia"),
    (("--load", "inertia 68"), "inertia '68'; 68 has no unit; allowed 0 or more kg m2, or text with a unit: kg m2, "),
    (("--load", "inertia 68 g cm2 friction 5 mNm"), "a comma is missing before 'friction'"),
    (("--load", "inertia 68 g cm2; friction 5 mNm"), "separate figures with commas, not semicolons"),
    (("--load", "mass 2 kg, lead 5"), "lead '5'; 5 has no unit; allowed 0 or more m, or text with a unit: m, cm, mm"),
    (("--grid", "F=range(3,10) R=8 S=199"), "F 'range(3,10)': write 3..9"),
    (("--grid", "F=3-10 R=8 S=199"), "cy525: F '3-10': write 3..10 for a range"),
    (("--grid", "F=4,6, R=8"), "F '4,6,': a comma without a value; separate parameters with spaces, as in F=4,6 R=8"),
])  # fmt: skip
def test_mistakes(call: Any, arguments: tuple[str, ...], says: str) -> None:
    status, out, err = call("cy525", *QUICK, *arguments)
    assert status == 2 and not out and err.startswith("slewline: ") and says in err


def test_parameters_outside_the_grid_are_refused(call: Any) -> None:
    status, _, err = call("cy525", *QUICK, "F=6", "R=8")
    assert status == 2 and "F=6 R=8: write --grid 'F=6 R=8'" in err


def test_a_bench_file_of_the_user_is_not_replaced(call: Any) -> None:
    Path("own.toml").write_text('[[chip]]\npart = "cy525"\n')
    status, _, err = call("cy525", *QUICK, "--bench", "own.toml")
    assert status == 2
    assert "--bench own.toml: this file exists, and was not written by `slewline tune`; name a new file" in err
    assert Path("own.toml").read_text() == '[[chip]]\npart = "cy525"\n'
    for _ in range(2):  # its own is
        assert call("cy525", *QUICK, "--bench", "new.toml")[0] == 0


def test_more_than_the_rated_current_is_reported(call: Any) -> None:
    _, out, _ = call("cy525", *QUICK, "--driver", "24 V, 10 A averaged")
    assert "note          10 A per phase, but QSH4218-51-10-049 is rated 1 A: it gets hot" in out
    _, out, _ = call("cy525", *QUICK, "--driver", "24 V, 1 A averaged")
    assert "is rated" not in out


@pytest.mark.parametrize("driver", ["L/4R 20 mV", "24 V, 1 mA averaged", "24 V, 1 mA chopper, 36 kHz", "current 1 mA"])
def test_a_driver_with_hardly_any_current_is_the_reason_why_nothing_holds(call: Any, driver: str) -> None:
    free = ("--motor", "QSH4218-51-10-049", "--steps", "40", "--grid", "F=6 R=8 S=199")
    status, _, err = call("cy525", *free, "--driver", driver)
    assert status == 1
    assert "cy525: none of 1 moves holds: 0.001 A per phase, but QSH4218-51-10-049 is rated 1 A: it has 0.1% of" in err


def test_where_nothing_holds(call: Any) -> None:
    fast = ("cy525", *MOTOR, "--steps", "200", "--grid", "F=30 R=60,80 S=250")
    status, out, err = call(*fast)
    assert status == 1 and not out
    _, _, flat = call("cy525", *MOTOR, "--steps", "40", "--grid", "F=50 R=8 S=199")
    assert "try a grid with ramps: here the rate is not above the first one (F 50, R 8), so that the move" in flat
    assert (
        "cy525: none of 2 moves holds; the slowest, F=30 R=60 S=250 Z=1, loses steps under '" in err and "; try " in err
    )
    status, out, _ = call(*fast, "--map", "--jobs", "1", "--plot", "none.svg")
    assert status == 1 and "best          none: every move loses steps" in out and "2 fails nominally" in out
    assert "commands" not in out and not Path("none.svg").exists()


def test_an_interrupt_while_the_picture_is_drawn_reports_that_all_runs_are_kept(
    call: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("slewline.cli.motors.tune.draw", interrupt)
    status, out, err = call("cy525", *QUICK, "--plot", "found.svg", "--store", "log.jsonl", "--jobs", "1")
    says = "interrupted after all runs; log.jsonl has every run: repeat the same command to continue"
    assert (status, out, err.strip()) == (1, "", f"slewline: {says}")
