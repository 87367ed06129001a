"""Tuning from Python: the fastest of a chip's ramps that a motor can follow.

found = slewline.tune("cy525", motor="QSH4218-51-10-049", driver="L/4R 20 V", load="friction 5 mNm", steps=1000)
print(found.best, found.recommended)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import Executor
from os import PathLike, cpu_count
from typing import Any

from ..bench.circuit import crystal_for
from ..chips import ramps_of
from ..core.messages.calls import answering
from ..core.messages.whole import whole
from ..errors import UsageError
from ..language.ramp_answers import Calculator
from ..parts.motors.choppers import current_note
from ..parts.motors.law import MotorLaw, check_steps, usual_step
from ..parts.motors.laws import read_system
from ..parts.motors.motor_data import DriverData, LoadData, MotorData
from .candidates import Candidates
from .executors import AHEAD, INLINE, Workers
from .grid import Given, read_grid
from .judging import judge
from .perturbations import Perturbation, read_perturbations
from .runs import Judge, Outcome, Runs
from .search import BestFirst, OnProgress, Progress
from .sweep_log import Log, interrupted
from .task import Chosen, MapPlace, Tuned, TuningTask


@answering("tune()")
def tune(
    part: str,
    *,
    motor: str | Mapping[str, Any] | MotorData,
    driver: str | Mapping[str, Any] | DriverData,
    load: str | Mapping[str, Any] | LoadData | None = None,
    steps: int,
    grid: str | Mapping[str, Given] | None = None,
    perturb: str | Iterable[Perturbation] | None = None,
    stepping: str = "full",
    crystal: str | int | None = None,
    options: Mapping[str, Any] | None = None,
    executor: Executor | None = None,
    store: str | PathLike[str] | None = None,
    full_map: bool = False,
    switching: bool = True,
    on_progress: OnProgress = lambda _: None,
) -> Tuned:
    """Return the fastest of a grid's ramps with which a motor loses no steps, and the recommended ramp.

    The step times of each move are those of the part itself.  A move fails if, under any perturbation, the
    rotor is 0.6 full steps or more from its commanded position at rest, or more than 3.9 during the move
    (2.9 for a three-phase reluctance motor); otherwise it holds.  The recommended move is the fastest one
    whose grid neighbours all hold and whose lag never exceeds 1.8 full steps.

    Args:
        part: the part number, "cy525", "gs-c200" ...
        motor, driver, load: for each, the name of a built-in one, a description, a table, or your own data.
        steps: the number of steps of the move, from rest to rest.
        grid: the parameter values to try, such as "F=3..10 R=4..40 S=1..254/8", or a mapping; omitted
            parameters have default values.
        perturb: the perturbations, such as "load 20%, supply -10%", or "none"; by default load, inertia,
            supply, current, friction, drag, and all unfavourable ones together.
        stepping: the motor's step mode: "full", "wave", "half", or "micro 8".
        crystal, options: as for `slewline.ramp`.
        executor: a concurrent.futures executor, to judge several moves at a time; the result is the same.
        store: a file that keeps the verdicts, from which an interrupted sweep is resumed.
        full_map: judge every candidate; the result's `map` then lists all of them.
        switching: if the driver is an averaged chopper, judge the recommended move with the switching
            chopper as well.
        on_progress: a function that is called with a `Progress` after every candidate.

    Raises:
        UnknownName: a part, parameter, motor or perturbation does not exist.
        UsageError: a value is out of range, the store cannot be used, or the executor fails.
        NothingHolds: every candidate loses steps; not raised if `full_map` is True: the result with its map
            is then returned.
        KeyboardInterrupt: Ctrl-C was pressed; the text states the number of runs in the store.
    """
    task, calculator = task_of(part, motor, driver, load, steps, grid, perturb, stepping, crystal, options)
    workers = INLINE if executor is None else Workers(executor, AHEAD * (cpu_count() or 1), "")
    return perform(task, calculator, workers, store, full_map, switching, on_progress)


def task_of(
    part: str,
    motor: str | Mapping[str, Any] | MotorData,
    driver: str | Mapping[str, Any] | DriverData,
    load: str | Mapping[str, Any] | LoadData | None,
    steps: int,
    grid: str | Mapping[str, Given] | None = None,
    perturb: str | Iterable[Perturbation] | None = None,
    stepping: str = "full",
    crystal: str | int | None = None,
    options: Mapping[str, Any] | None = None,
) -> tuple[TuningTask, Calculator]:
    """Return a user's task, and the part's ramp calculator; arguments and exceptions are as for `tune`."""
    calculator = ramps_of(part, options)
    name = calculator.sheet.part
    hz = calculator.sheet.crystal_hz if crystal is None else crystal_for(calculator.sheet, crystal)
    number = whole(steps)
    if number is None or number < 1:
        raise UsageError(f"{name}: a move of {steps!r} steps; allowed 1 or more")
    rows = read_perturbations(perturb)
    used, driven, loaded = read_system(motor, driver, load or "")
    pulse = check_steps(stepping)
    places = read_grid(calculator, grid, hz, used.full_steps * MotorLaw(used, driven, loaded, pulse).micro)
    options_text = {str(key): value for key, value in (options or {}).items()}
    given = {"motor": motor, "driver": driver, "load": load}
    return TuningTask(
        name, hz, options_text, number, pulse, used, driven, loaded, places, rows, usual_step(driven), given
    ), calculator


def perform(
    task: TuningTask,
    calculator: Calculator,
    workers: Workers = INLINE,
    store: str | PathLike[str] | None = None,
    full_map: bool = False,
    switching: bool = True,
    on_progress: OnProgress = lambda _: None,
    judge: Judge = judge,
) -> Tuned:
    """Search the grid of a task, and return the result; arguments and exceptions are as for `tune`."""
    log = None if store is None else Log(str(store), task.as_json())
    most = None
    runs: Runs | None = None
    try:
        size = task.grid.size

        def listed(place: int) -> None:
            on_progress(Progress("listing the moves", place, size, size, None, 0))

        candidates = Candidates(calculator, task.grid, task.crystal_hz, task.steps, listed)
        runs = Runs(judge, candidates, workers, log)
        chopped = task.switching() if switching else ()
        search = BestFirst(runs, task.scenarios(), chopped, full_map, on_progress)
        most = len(candidates) * len(search.scenarios)
        found = search.find()
    except KeyboardInterrupt as interrupt:
        interrupt.args = (interrupted(log, 0 if runs is None else runs.here, most),)
        raise
    finally:
        if log is not None:
            log.close()
    if found.best is None and not full_map:
        raise nothing_holds(search, current_note(task.motor, task.driver, little=True))

    def chosen(outcome: Outcome | None) -> Chosen | None:
        if outcome is None:
            return None
        return Chosen(candidates.values(outcome.place), candidates.time_ps[outcome.place], outcome.worst)

    return Tuned(
        task,
        len(candidates),
        len(candidates.refused),
        chosen(found.best),
        chosen(found.recommended),
        found.switched,
        len(runs.needed),
        runs.here,
        most,
        dict(runs.killed.most_common()),
        tuple(_map(search)) if full_map else (),
    )


def _map(search: BestFirst) -> Iterable[MapPlace]:
    """Yield every grid point with its verdict, in grid order."""
    candidates = search.candidates
    for place in range(candidates.grid.size):
        values = candidates.values(place)
        outcome = search.known.get(place)
        if outcome is None:
            yield MapPlace(values, None, "refused", None, None)
            continue
        killer = outcome.killer
        verdict = "holds" if killer is None else "fails nominally" if killer.nominal else "fails"
        yield MapPlace(values, candidates.time_ps[place], verdict, killer.name if killer else None, outcome.worst)


REMEDIES = {  # remedies, by the first word of the perturbation
    "load": "less torque, or a stronger motor",
    "inertia": "less inertia, or gentler ramps in the grid",
    "supply": "a higher supply, or lower rates in the grid",
    "current": "more current, or a stronger motor",
    "friction": "less friction",
    "drag": "a damper, or another rate: a motor that is hardly damped swings itself out of step near its resonance",
    "all": "slower and gentler ramps in the grid, a stronger motor, or smaller perturbations",
    "nominal": "slower and gentler ramps in the grid, more supply or current, a damper, or a stronger motor",
}


def nothing_holds(search: BestFirst, note: str = "") -> UsageError:
    """Return the error that states why the slowest candidate fails, and a remedy.

    Args:
        note: a text about an error in the motor's current, which explains all failures; if given, it
            replaces the reason and the remedy.
    """
    from .task import NothingHolds

    candidates = search.candidates
    slowest = candidates.order[-1]
    killer = search.known[slowest].killer
    name = "" if killer is None else killer.name
    options_text = candidates.calculator.without_defaults(candidates.values(slowest))
    values = " ".join(f"{key}={value}" for key, value in options_text.items())
    remedy = REMEDIES.get(name.partition(" ")[0].rstrip(","), REMEDIES["nominal"])
    part = candidates.calculator.sheet.part
    if note:
        return NothingHolds(f"{part}: none of {len(candidates)} moves holds: {note}")
    if level := candidates.calculator.level(candidates.ramp(slowest)):
        remedy = f"a grid with ramps: here {level}, so that the move begins at its full rate"
    return NothingHolds(
        f"{part}: none of {len(candidates)} moves holds; the slowest, {values}, loses "
        f"steps under {name!r}; try {remedy}"
    )
