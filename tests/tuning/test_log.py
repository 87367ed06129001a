"""The log: a sweep that was killed goes on, nothing is judged twice, and no other task's log is taken for its own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest

from slewline.chips import ramps_of
from slewline.errors import UsageError
from slewline.tuning.executors import INLINE, Workers
from slewline.tuning.judging import Trial, Verdict
from slewline.tuning.task import Tuned, TuningTask
from slewline.tuning.tune_ramp import perform

from .stand_in import LOAD, hits, task

ROOT = Path(__file__).parents[2]
SWEEP = """
import sys
from slewline.chips import ramps_of
from slewline.tuning.tune_ramp import perform
from tests.tuning.stand_in import counted, task
made = task("cy500")
perform(made, ramps_of(made.part), store=sys.argv[1], full_map=True, judge=counted)
"""


def sweep(path: Path, made: TuningTask | None = None, judge: Any = hits, workers: Workers = INLINE) -> Tuned:
    made = made or task("cy500")
    return perform(made, ramps_of(made.part), workers, path, full_map=True, judge=judge)


def lines(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


def same(one: Tuned, other: Tuned) -> bool:
    return replace(one, runs_here=0) == replace(other, runs_here=0)


@pytest.fixture
def path(tmp_path: Path) -> Iterator[Path]:
    yield tmp_path / "tune.jsonl"


def test_a_log_has_its_task_and_a_line_for_every_run(path: Path) -> None:
    found = sweep(path)
    head, *runs = lines(path)
    assert head["tune"] == 1 and head["task"]["motor"]["name"] == "stand-in" and len(head["digest"]) == 32
    assert head["task"]["grid"]["S"] == [1, 41, 81, 120, 160, 200] and head["task"]["step_ps"] == 20_000_000
    assert len(runs) == found.runs == found.runs_here
    assert set(runs[0]) == {"move", "values", "run", "lost", "error", "worst"}
    assert max(Counter((each["move"], each["run"]) for each in runs).values()) == 1


def test_a_finished_sweep_judges_nothing_again(path: Path) -> None:
    found, data = sweep(path), path.read_bytes()

    def never(run: Trial) -> Verdict:
        raise AssertionError(run)

    again = sweep(path, judge=never)
    assert same(found, again) and again.runs_here == 0 and path.read_bytes() == data


@pytest.mark.system
@pytest.mark.posix
def test_a_sweep_that_was_killed_continues(path: Path, tmp_path: Path) -> None:
    counts, after = tmp_path / "counts", 100
    environment = os.environ | {"STAND_IN_COUNTS": str(counts), "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    process = subprocess.Popen([sys.executable, "-c", SWEEP, str(path)], env=environment, cwd=ROOT)
    until = monotonic() + 30
    while not (path.exists() and path.read_bytes().count(b"\n") > after) and monotonic() < until:
        sleep(0.002)
    process.send_signal(signal.SIGKILL)
    process.wait()
    left = path.read_bytes()
    whole = left[: left.rfind(b"\n") + 1]
    logged = {(each["move"], each["run"]) for each in map(json.loads, whole.splitlines()[1:])}
    assert len(logged) >= after
    begun = len(counts.read_text().splitlines())
    subprocess.run([sys.executable, "-c", SWEEP, str(path)], env=environment, cwd=ROOT, check=True)
    runs = lines(path)[1:]
    assert path.read_bytes().startswith(whole)
    assert max(Counter((each["move"], each["run"]) for each in runs).values()) == 1
    assert len(counts.read_text().splitlines()) - begun == len(runs) - len(logged)
    fresh = sweep(tmp_path / "fresh.jsonl")
    again = sweep(path)
    assert same(again, fresh) and again.runs_here == 0 and len(runs) == fresh.runs


@pytest.mark.parametrize("stored", [True, False])
def test_an_interrupt_reports_the_kept_runs(path: Path, stored: bool) -> None:
    made, left = task("cy500"), iter(range(30))
    most = sweep(path.with_name("whole.jsonl")).exhaustive

    def until_interrupted(run: Trial) -> Verdict:
        if next(left, None) is None:
            raise KeyboardInterrupt
        return hits(run)

    with pytest.raises(KeyboardInterrupt) as caught:
        perform(made, ramps_of(made.part), store=path if stored else None, full_map=True, judge=until_interrupted)
    if stored:
        says = f"interrupted; {path} has 30 of up to {most:,} runs: run the same command again to continue"
        assert len(lines(path)) == 31
    else:
        says = (
            f"interrupted after 30 of up to {most:,} runs, which are lost; with --store F.jsonl (store=) every run is "
            "kept, and the same command resumes from there"
        )
    assert str(caught.value) == says


def test_an_interrupt_while_the_moves_are_listed_reports_the_kept_runs(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs = sweep(path).runs

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("slewline.tuning.tune_ramp.Candidates", interrupt)
    with pytest.raises(KeyboardInterrupt, match=f"has {runs:,} runs: run the same command again to continue"):
        sweep(path)


def test_a_torn_last_line_is_cut_off(path: Path) -> None:
    found, data = sweep(path), path.read_bytes()
    rows = data.splitlines(keepends=True)
    for torn in (rows[40][:30], rows[40][:-1], b'{"move": \xff'):
        path.write_bytes(b"".join(rows[:40]) + torn)
        again = sweep(path)
        assert same(found, again) and again.runs_here == found.runs - 39
        assert path.read_bytes().splitlines()[:40] == data.splitlines()[:40]
    path.write_bytes(rows[0][:50])  # killed while it wrote the first one
    assert same(found, sweep(path)) and path.read_bytes() == data


@pytest.mark.parametrize(("change", "says"), [
    ({"load": replace(LOAD, torque=0.05)}, "load.torque was 0.03, is now 0.05"),
    ({"steps": 199}, "steps was 200, is now 199"),
    ({"step_ps": 50_000_000}, "step_ps was 20000000, is now 50000000"),
    ({"grid": task("cy500", "R=20,240 S=1").grid}, "is now [20, 240]; grid.S was"),
    ({"perturbations": ()}, r"perturbations.worst case was {"),
])  # fmt: skip
def test_the_log_of_another_task_is_refused_with_the_differences(path: Path, change: dict[str, Any], says: str) -> None:
    sweep(path)
    data = path.read_bytes()
    with pytest.raises(UsageError) as caught:
        sweep(path, replace(task("cy500"), **change))
    assert says in str(caught.value) and "name another file" in str(caught.value)
    assert path.read_bytes() == data


def test_the_log_of_another_version_is_refused(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sweep(path)
    monkeypatch.setattr("slewline.tuning.sweep_log.__version__", "9.9")
    with pytest.raises(UsageError, match=r"is the log of another task: slewline was .*, is now \"9.9\""):
        sweep(path)


@pytest.mark.parametrize("content", [b"a text\n", b"notes", b"{}\n", b"[1]\n", b'{"do":"journal"}\n', b"\x00\xff\n"])
def test_a_file_other_than_a_log_is_left_unchanged(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with pytest.raises(UsageError, match=r"tune.jsonl is not the log of a sweep; name a new file"):
        sweep(path)
    assert path.read_bytes() == content


def test_a_line_that_is_not_a_run_is_named(path: Path) -> None:
    sweep(path)
    rows = path.read_bytes().splitlines(keepends=True)
    for wrong in (b"{}\n", b"nonsense\n", b'{"move": "a", "run": "b", "lost": 0, "error": "x", "worst": 1}\n'):
        path.write_bytes(b"".join([*rows[:4], wrong, *rows[4:]]))
        with pytest.raises(UsageError, match=r"tune.jsonl, line 5: .* is not a run record; remove the line"):
            sweep(path)


def test_places_where_no_log_can_be(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no directory .*nowhere'; create it, or name another file"):
        sweep(tmp_path / "nowhere" / "tune.jsonl")
    with pytest.raises(UsageError, match="is not a file; name"):
        sweep(tmp_path)
    with pytest.raises(UsageError, match="is not a file; name"):
        sweep(Path(os.devnull))
    (tmp_path / "empty").touch()
    assert sweep(tmp_path / "empty").runs_here


@pytest.mark.system
@pytest.mark.posix
def test_a_full_disk_ends_the_sweep_and_judged_runs_are_kept(path: Path) -> None:
    limited = "import resource as r, signal as s; s.signal(s.SIGXFSZ, s.SIG_IGN)\n"
    limited += "r.setrlimit(r.RLIMIT_FSIZE, (9000, 9000))\n"
    environment = os.environ | {"STAND_IN_COUNTS": os.devnull, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    ended = subprocess.run(
        [sys.executable, "-c", limited + SWEEP, str(path)],
        env=environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "tune.jsonl: File too large; earlier verdicts are kept; name a" in ended.stderr
    kept = path.read_bytes().count(b"\n") - 1
    again = sweep(path)
    assert kept > 20 and again.runs_here == again.runs - kept


def test_runs_before_a_failing_judge_are_kept(path: Path) -> None:
    judged = 0

    def fails(run: Trial) -> Verdict:
        nonlocal judged
        judged += 1
        if judged > 50:
            raise ZeroDivisionError
        return hits(run)

    with pytest.raises(ZeroDivisionError):
        sweep(path, judge=fails)
    assert len(lines(path)) == 51
    again = sweep(path)
    assert again.runs_here == again.runs - 50


def test_threads_write_whole_lines(path: Path) -> None:
    with ThreadPoolExecutor(8) as pool:
        found = sweep(path, workers=Workers(pool, 32, ""))
    assert len(lines(path)) == 1 + found.runs_here


HOLDS = """
import sys
from slewline.tuning.sweep_log import Log
from tests.tuning.stand_in import task
log = Log(sys.argv[1], task("cy500").as_json())
print("begun", flush=True)
sys.stdin.read()
"""


@pytest.mark.system
def test_two_sweeps_together_are_refused(path: Path) -> None:
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDS, str(path)],
        env=environment, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdin is not None and process.stdout is not None
    try:
        assert process.stdout.readline() == "begun\n"
        data = path.read_bytes()
        for _ in range(2):  # what was refused lets go of the file
            with pytest.raises(UsageError, match=r"tune.jsonl: another sweep is writing to it; wait until it"):
                sweep(path)
        ended = subprocess.run(
            [sys.executable, "-c", SWEEP, str(path)],
            env=environment | {"STAND_IN_COUNTS": os.devnull}, cwd=ROOT, capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert "another sweep is writing to it" in ended.stderr and ended.returncode
        assert path.read_bytes() == data
    finally:
        process.stdin.close()
        process.stdout.close()
        process.wait(20)
    assert sweep(path).runs_here
