"""A cluster of Dask: a real scheduler and two workers on loopback; the same result; what is said when it is gone."""

from __future__ import annotations

from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from time import monotonic, sleep

import pytest

from slewline.chips import ramps_of
from slewline.cli.main import invoke
from slewline.errors import UsageError
from slewline.tuning.executors import INLINE, dask
from slewline.tuning.judging import Trial, Verdict
from slewline.tuning.task import Tuned
from slewline.tuning.tune_ramp import perform
from slewline.version import __version__
from tests.ensembles import few

from .cluster import Cluster
from .stand_in import hits, task

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed"),
    pytest.mark.filterwarnings("ignore"),  # those of Dask are not ours
]
NOBODY = "tcp://127.0.0.1:9"


def slowly(run: Trial) -> Verdict:
    """Judge in 5 ms."""
    sleep(0.005)
    return hits(run)


@pytest.mark.parametrize("full_map", [False, pytest.param(True, marks=pytest.mark.long)])
def test_the_result_of_a_cluster_is_the_same(cluster: Cluster, full_map: bool) -> None:
    made = task("cy525", "F=3,6 R=4..24/5 S=1..250/3", steps=200)

    def found(workers: object) -> Tuned:
        return perform(made, ramps_of(made.part), workers, full_map=full_map, judge=hits)  # type: ignore[arg-type]

    with dask(cluster.address) as workers:
        assert workers.window == 4
        together = found(workers)
    assert replace(together, runs_here=0) == replace(found(INLINE), runs_here=0)


def test_workers_with_another_version_are_refused(cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("slewline.tuning.executors.__version__", "9.9")
    with pytest.raises(UsageError) as caught, dask(cluster.address):
        pass
    says = str(caught.value)
    assert says.startswith(f"Dask cluster {cluster.address!r}: the worker tcp://127.0.0.1:"), says
    assert f" has slewline {__version__}, this computer has 9.9; install 9.9 on the workers, and restart them" in says


def test_workers_without_slewline_are_refused(cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    def version_here() -> str:
        raise ImportError("No module named 'slewline'")

    monkeypatch.setattr("slewline.tuning.executors.version_here", version_here)
    with (
        pytest.raises(UsageError, match=r"has no slewline \(No module named 'slewline'\), this computer"),
        dask(cluster.address),
    ):
        pass


@pytest.mark.long
def test_a_cluster_that_dies_costs_no_run_of_the_log(tmp_path: Path) -> None:
    made, path = task("gs-c200s"), tmp_path / "tune.jsonl"
    cluster = Cluster(tmp_path)
    killed: list[float] = []

    def kill(now: object) -> None:
        if path.read_bytes().count(b"\n") > 40 and not killed:
            killed.append(monotonic())
            cluster.kill()

    try:
        with pytest.raises(UsageError) as caught, dask(cluster.address) as workers:
            perform(made, ramps_of(made.part), workers, path, full_map=True, judge=slowly, on_progress=kill)
    finally:
        cluster.close()
    says = str(caught.value)
    assert f"Dask cluster {cluster.address!r} is gone; start a scheduler and a worker again" in says
    assert "tune.jsonl has all verdicts so far: run the same command again to continue" in says
    assert monotonic() - killed[0] < 20
    kept = path.read_bytes().count(b"\n") - 1
    assert kept >= 40
    again = perform(made, ramps_of(made.part), INLINE, path, full_map=True, judge=hits)
    assert again.runs_here == again.runs - kept


@pytest.mark.parametrize("address", few([NOBODY, "nonsense://x", "tcp://"], 1))
def test_where_there_is_no_cluster(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("slewline.tuning.executors.ANSWER_TIMEOUT", "500 ms")
    with pytest.raises(UsageError) as caught, dask(address):
        pass
    says = str(caught.value)
    assert says.startswith(f"Dask cluster {address!r}: ") and "such as tcp://127.0.0.1:8786" in says, says


@pytest.mark.long
def test_the_command_reports_it_too(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("slewline.tuning.executors.ANSWER_TIMEOUT", "500 ms")
    motor = ["--motor", "QSH4218-51-10-049", "--driver", "L/4R 20 V"]
    status = invoke(["tune", "cy525", *motor, "--steps", "100", "--dask", NOBODY])
    assert status == 2 and f"slewline: Dask cluster '{NOBODY}': " in capsys.readouterr().err
