"""The search with the physics: the same best, recommendation and map from one process, threads, a pool and Dask."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache

import pytest

from slewline.parts.motors.integration import numba_is_there
from slewline.tuning.executors import INLINE, Workers, dask, processes
from slewline.tuning.task import Tuned
from slewline.tuning.tune_ramp import perform, task_of

from .cluster import Cluster

pytestmark = [pytest.mark.system, pytest.mark.skipif(not numba_is_there(), reason="Numba is not installed")]


def found(workers: Workers) -> Tuned:
    """Tune on a small grid; what was judged in this session is left out."""
    task, calculator = task_of(
        "gs-c200s", "QSH4218-51-10-049", "24 V, 1 A averaged", "inertia 68 g cm2, friction 5 mNm", 100,
        "S=60 T=100..300/4 R=10..80/4", "inertia +20%, current -20%",
    )  # fmt: skip
    return replace(perform(task, calculator, workers, full_map=True, switching=False), runs_here=0)


@cache
def alone() -> Tuned:
    """What one process finds."""
    result = found(INLINE)
    assert result.best is not None and result.recommended is not None and result.best != result.recommended
    assert {place.says for place in result.map} == {"holds", "fails nominally"}
    return result


def test_threads_find_the_same() -> None:
    with ThreadPoolExecutor(4) as pool:
        assert found(Workers(pool, 16, "")) == alone()


@pytest.mark.long  # each process of the pool compiles the motor
def test_a_pool_of_processes_finds_the_same() -> None:
    with processes(2) as pool:
        assert found(pool) == alone()


@pytest.mark.long  # so does each worker of a cluster
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_finds_the_same(cluster: Cluster) -> None:
    with dask(cluster.address) as workers:
        assert found(workers) == alone()
