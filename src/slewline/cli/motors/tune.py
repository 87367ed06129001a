"""tune: the fastest ramp, among those of a chip, that a motor can follow."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

import click

from ...core.messages.whole import counted
from ...core.time.timebase import readable
from ...errors import UsageError
from ...gate import read_text
from ...language.ramp_answers import Calculator, Value
from ...record.pictures.picture_files import SUFFIXES
from ...record.style import aligned
from ...tuning.executors import MOST_JOBS, Workers, dask, processes
from ...tuning.grid import Grid
from ...tuning.search import OnProgress, Progress
from ...tuning.task import Chosen, MapPlace, NothingHolds, Tuned
from ...tuning.tune_ramp import perform, task_of
from ...tuning.tuned_bench_file import is_tuned
from .. import FOUND
from ..files import Outputs, read_options
from ..programs import print_json
from .own import motor_value

MOST_ROWS = 60  # moves of a map shown as text


def tune(
    chip: str,
    motor: str,
    driver: str,
    load: str | None,
    steps: int,
    stepping: str,
    grid: str | None,
    perturb: str | None,
    jobs: int | None,
    cluster: str | None,
    store: str | None,
    full_map: bool,
    switching: bool,
    crystal: str | None,
    as_json: bool,
    plot: str | None,
    bench: str | None,
    options: str | None = None,
) -> int:
    """Find the best move, and print the result; return the exit status, 1 if every candidate loses steps."""
    outputs = Outputs([])
    outputs.claim(plot, SUFFIXES)
    outputs.claim(bench, (".toml",))
    if bench is not None and os.path.isfile(bench) and not is_tuned(read_text(bench)):
        raise UsageError(f"--bench {bench}: this file exists, and was not written by `slewline tune`; name a new file")
    fitting = read_options(options, chip) or None
    task, calculator = task_of(chip, motor_value(motor), driver, load, steps, grid, perturb, stepping, crystal, fitting)
    if bench is not None:
        calculator.script(task.grid.at(0), steps)
    with workers_of(jobs, cluster, full_map) as workers, progress() as shown:
        try:
            found = perform(task, calculator, workers, store, full_map or plot is not None, switching, shown)
        except NothingHolds as failure:
            click.echo(f"slewline: {failure}", err=True)
            return FOUND
    try:
        write(outputs, found, calculator, plot, bench)
    except KeyboardInterrupt as interrupt:
        kept = f"; {store} has every run: repeat the same command to continue" if store else ""
        interrupt.args = (f"interrupted after all runs{kept}",)
        raise
    if as_json:
        print_json(found.as_json())
    else:
        for line in report(found, calculator, full_map):
            click.echo(line)
        for path in outputs.written:
            click.echo(f"wrote {path}")
    return 0 if found.best is not None else FOUND


def write(outputs: Outputs, found: Tuned, calculator: Calculator, plot: str | None, bench: str | None) -> None:
    """Write the requested picture and bench file, if there is a best move."""
    if found.best is None:
        return
    outputs.save(plot, lambda path: draw(path, found, calculator))
    if bench is not None:
        from ...tuning.tuned_bench_file import bench_file

        outputs.write(bench, bench_file(found, calculator))


def workers_of(jobs: int | None, cluster: str | None, full_map: bool) -> AbstractContextManager[Workers]:
    """Return the workers that simulate the candidates.

    Raises:
        UsageError: both a number of processes (`jobs`) and a cluster are given.
    """
    if cluster is not None:
        if jobs is not None:
            raise UsageError("--jobs and --dask: give one of the two")
        return dask(cluster)
    if jobs is None:
        jobs = min(os.cpu_count() or 1, MOST_JOBS) if full_map else 1
    return processes(jobs)


def draw(path: str, found: Tuned, calculator: Calculator) -> None:
    """Draw the map of candidates, the pull-out curve and the lag, in a file."""
    from ...tuning.tuning_picture import save_tuning

    save_tuning(path, found, calculator)


# ----------------------------------------------------------------------------------------------------------------- text
def report(found: Tuned, calculator: Calculator, full_map: bool) -> Iterator[str]:
    """Yield the result as lines of text, with the map only if `full_map`."""
    task = found.task
    refused = f", {found.refused} refused by the chip" if found.refused else ""
    yield f"{task.part}, {task.motor.name}: {counted(task.steps, 'step')}, {grid_text(task.grid, calculator)}"
    if found.assumed:
        yield f"assumed       {', '.join(found.assumed)}"
    yield from (f"note          {note}" for note in found.notes)
    yield f"candidates    {found.candidates}{refused}; {len(task.scenarios())} runs each"
    yield f"best          {chosen_line(found.best, calculator) if found.best else 'none: every move loses steps'}"
    if found.best is not None:
        none = "none: every move without lost steps has neighbours that lose steps, or a lag of more than 1.8 steps"
        yield f"recommended   {chosen_line(found.recommended, calculator) if found.recommended else none}"
    if found.recommended is not None:
        yield "              its neighbours lose no steps" + (
            ", even with the switching chopper" if found.switched else ""
        )
    here = "" if found.runs_here == found.runs else f", {found.runs_here} of them now" * (found.runs_here < found.runs)
    full = f" of {found.exhaustive}" if found.runs <= found.exhaustive else ""  # a switching chopper adds lag
    yield f"runs          {found.runs}{full}{here}"
    killers = sorted(found.killers.items(), key=lambda each: -each[1])[:4]
    if killers:
        cases = [f'{counted(count, "candidate")} under "{name}"' for name, count in killers]
        yield f"failed        {', '.join(cases)}"
    if full_map:
        yield from map_lines(found, calculator)
    if found.best is not None:
        first, *others = calculator.script(found.chosen.values, task.steps)
        yield f"commands      {first}"
        yield from (f"              {each}" for each in others)


def grid_text(grid: Grid, calculator: Calculator) -> str:
    """Return a grid as text, without the parameters whose only value is the default."""
    shown = [
        *grid.free,
        *calculator.without_defaults({name: of for name, of in grid.at(0).items() if name not in grid.free}),
    ]
    places = [(name, of) for name, of in zip(grid.names, grid.values, strict=True) if name in shown]
    return str(Grid(*zip(*places, strict=True)))


def chosen_line(chosen: Chosen, calculator: Calculator) -> str:
    """Return a line with the parameters, the time and the worst lag of a move."""
    return f"{values_text(calculator, chosen.values)}: {readable(chosen.time_ps)}, worst lag {chosen.worst:.2f} steps"


def values_text(calculator: Calculator, values: Any) -> str:
    """Return parameter values as text, without those equal to their defaults."""
    named: dict[str, Value] = calculator.without_defaults(values)
    return ", ".join(f"{name} {value}" for name, value in named.items())


def map_lines(found: Tuned, calculator: Calculator) -> Iterator[str]:
    """Yield the map as lines, fastest move first; a failed move's line names the perturbation it failed under."""
    counts = Counter(place.says for place in found.map)
    yield f"map           {', '.join(f'{count} {verdict}' for verdict, count in counts.most_common())}"
    names = found.task.grid.free or found.task.grid.names[:1]
    rows = sorted(found.map, key=lambda place: (place.time_ps is None, place.time_ps or 0))
    cells = [[*(str(place.values[name]) for name in names), *_verdict(place)] for place in rows[:MOST_ROWS]]
    yield from aligned([[*names, "time", "worst lag", "verdict"], *cells], left=(len(names) + 2,))
    if len(rows) > MOST_ROWS:
        yield f"... and {len(rows) - MOST_ROWS} more; --json lists all, --plot draws them"


def _verdict(place: MapPlace) -> tuple[str, str, str]:
    time = "" if place.time_ps is None else readable(place.time_ps)
    lag = "" if place.worst is None or place.killer else f"{place.worst:.2f}"
    return time, lag, place.says if place.killer is None else f"lost: {place.killer}"


# ------------------------------------------------------------------------------------------------------------- progress
@contextmanager
def progress() -> Iterator[OnProgress]:
    """Yield a function that shows on a terminal the best time so far, and how many faster candidates are left."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[left]}"), TimeElapsedColumn())
    with Bars(*columns, console=Console(stderr=True), transient=True) as shown:
        bar = shown.add_task("", left="")

        def show_progress(now: Progress) -> None:
            best = "" if now.time_ps is None else f" below {readable(now.time_ps)}, the best so far"
            remaining = f"{now.left} left{best}, {now.runs} runs"
            shown.update(bar, description=now.doing, completed=now.done, total=now.total, left=remaining)

        yield show_progress
