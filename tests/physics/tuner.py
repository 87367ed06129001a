"""The tuner with the physics: its best is that of the exhaustive map, a killed sweep goes on, a rate that is known."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep
from typing import NamedTuple

from slewline.chips import ramps_of
from slewline.parts.motors.integration import numba_is_there
from slewline.parts.motors.motor_data import LoadData
from slewline.tuning.candidates import Candidates
from slewline.tuning.judging import Trial, Verdict, judge
from slewline.tuning.search import WORST
from slewline.tuning.task import Tuned, TuningTask
from slewline.tuning.tune_ramp import perform, task_of

from .runs import F0, HELD, A, J, damped
from .table import Reading, at_least, at_most, check, near, same

ROOT = Path(__file__).parents[2]


class Grid(NamedTuple):
    """A chip with a motor, a coarse grid and a fine one."""

    part: str
    motor: str
    driver: str
    load: str
    steps: int
    coarse: str
    fine: str

    def task(self, fine: bool) -> TuningTask:
        """Return the task; the coarse grid with fewer perturbations."""
        perturb = None if fine else "load 20%, inertia +20%, current -20%"
        grid = self.fine if fine else self.coarse
        return task_of(self.part, self.motor, self.driver, self.load, self.steps, grid, perturb)[0]


LOAD = "inertia 68 g cm2, friction 5 mNm, torque 30 mNm"
GRIDS = {
    "CY525": Grid(
        "cy525", "QSH4218-51-10-049", "L/4R 20 V", LOAD, 200,
        "F=4,8 R=8..40/5 S=1..250/4", "F=4,6,8 R=4..44/11 S=1..250/9",
    ),
    "GS-C200S": Grid(
        "gs-c200s", "QSH4218-51-10-049", "24 V, 1 A averaged", "inertia 68 g cm2, friction 5 mNm", 200,
        "S=40,60 T=100..300/5 R=10..80/4", "S=10,30,60 T=60..400/10 R=5..300/9",
    ),
    "MC1451A, trapezoid": Grid(
        "mc1451a", "QSH4218-47-28-040", "24 V, 2.8 A averaged", LOAD, 200,
        "SET_VEL=500 steps/s..5000 steps/s/5 SET_ACC=3e3 steps/s2..3e5 steps/s2/6 SET_START_VEL=0",
        "SET_VEL=300 steps/s..6000 steps/s/12 SET_ACC=2e3 steps/s2..1e6 steps/s2/12 SET_START_VEL=0,300 steps/s",
    ),
    "MC1451A, S-curve": Grid(
        "mc1451a", "QSH4218-51-10-049", "24 V, 1 A averaged", LOAD, 200,
        "profile=s-curve SET_VEL=500 steps/s..4000 steps/s/4 SET_MAX_ACC=3e3 steps/s2..3e5 steps/s2/4 "
        "SET_JERK=3e5 steps/s3..3e7 steps/s3/3",
        "profile=s-curve SET_VEL=300 steps/s..6000 steps/s/8 SET_MAX_ACC=2e3 steps/s2..6e5 steps/s2/7 "
        "SET_JERK=1e5 steps/s3..1e8 steps/s3/5",
    ),
}  # fmt: skip


def candidates_of(task: TuningTask) -> Candidates:
    """Return the moves of a task."""
    return Candidates(ramps_of(task.part), task.grid, task.crystal_hz, task.steps)


def exhausted(task: TuningTask) -> tuple[int | None, int | None]:
    """Return the times (ps) of the fastest move that holds and of the recommended one, every move being judged."""
    every = candidates_of(task)
    worst: dict[int, float | None] = {}  # of what holds under every scenario
    for place in every.order:
        times, greatest = every.times(place), 0.0
        for scenario in task.scenarios():
            verdict = judge(Trial(times, scenario))
            greatest = max(greatest, verdict.worst)
            if verdict.lost:
                break
        else:
            worst[place] = greatest
    good = [
        every.time_ps[place]
        for place, greatest in worst.items()
        if greatest is not None and greatest <= WORST
        and all(each in worst for each in every.grid.neighbours(place) if each in every.time_ps)
    ]  # fmt: skip
    return min((every.time_ps[place] for place in worst), default=None), min(good, default=None)


def compared(fine: bool) -> Iterator[Reading]:
    """Yield what the search finds beside the exhaustive map, and how many runs it needs."""
    if not numba_is_there():
        return
    for name, grid in GRIDS.items():
        task = grid.task(fine)
        best, recommended = exhausted(task)
        found = perform(task, ramps_of(task.part), switching=False)
        yield same(f"{name}: best, ms", milliseconds(found.best and found.best.time_ps), milliseconds(best))
        chosen = found.recommended and found.recommended.time_ps
        yield same(f"{name}: recommended, ms", milliseconds(chosen), milliseconds(recommended))
        yield at_most(f"{name}: runs, of those of all", found.runs, found.exhaustive)


def milliseconds(ps: int | None) -> float:
    """Return ps in ms; none is 0."""
    return (ps or 0) / 1e9


@check(45, "tuner, coarse grid", long=True)
def best_of_the_map() -> Iterator[Reading]:
    yield from compared(False)


@check(45, "tuner, fine grid", long=True)
def best_of_the_fine_map() -> Iterator[Reading]:
    yield from compared(True)


@check(46, "tuner, highest start-stop rate of a held motor")
def start_stop_by_the_tuner() -> Iterator[Reading]:
    # Every move is at one rate from its first step to its last: the start velocity is not below the greatest one.
    if not numba_is_there():
        return
    rates = [f"{5.5 * F0 * 1.01**n} steps/s" for n in range(45)]
    motor = replace(A, iron=damped(0.039, J))
    for steps in (40, 200):
        task, calculator = task_of(
            "mc1451a", motor, HELD, LoadData(), steps,
            {"SET_START_VEL": [rates[-1]], "SET_VEL": rates, "SET_ACC": ["1e6 steps/s2"]}, "none",
        )  # fmt: skip
        found = perform(task, calculator)
        rate = calculator.ramp(found.best.values, task.crystal_hz).top if found.best else 0.0
        yield near(f"{steps} steps, of f0", rate / F0, 6.99, 0.02)


SWEEP = """
import sys
from slewline.chips import ramps_of
from slewline.tuning.tune_ramp import perform
from tests.physics.tuner import GRIDS
task = GRIDS["GS-C200S"].task(False)
perform(task, ramps_of(task.part), store=sys.argv[1], switching=False)
"""


@check(47, "sweep that was killed")
def resumed() -> Iterator[Reading]:
    if not numba_is_there() or not hasattr(signal, "SIGKILL"):
        return
    task = GRIDS["GS-C200S"].task(False)
    fresh = perform(task, ramps_of(task.part), switching=False)
    judged: list[tuple[bytes, str]] = []

    def noted(run: Trial) -> Verdict:
        judged.append((run.times.tobytes(), run.scenario.name))
        return judge(run)

    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "tune.jsonl"
        kept = killed(log, 20)
        again: Tuned = perform(task, ramps_of(task.part), store=log, switching=False, judge=noted)
        rows = log.read_bytes().splitlines()[1:]
    keys = {row.split(b'"lost"')[0].partition(b'"run"')[::2] for row in rows}
    yield at_least("runs before it was killed", kept, 20)
    yield same(
        "the result is that of one that was not", float(replace(again, runs_here=0) == replace(fresh, runs_here=0)), 1
    )
    yield same("runs before and after", kept + len(judged), fresh.runs)
    yield same("runs twice", len(rows) - len(keys) + len(judged) - len({*judged}), 0)


def killed(log: Path, runs: int) -> int:
    """Sweep in a process of its own, and kill that after so many runs; return how many it has written down."""
    paths = os.pathsep.join([str(ROOT), *sys.path])
    process = subprocess.Popen(
        [sys.executable, "-c", SWEEP, str(log)], env=os.environ | {"PYTHONPATH": paths}, cwd=ROOT
    )
    until = monotonic() + 60
    while not (log.exists() and log.read_bytes().count(b"\n") > runs) and monotonic() < until:
        sleep(0.001)
    process.send_signal(signal.SIGKILL)
    process.wait()
    return log.read_bytes().count(b"\n") - 1
