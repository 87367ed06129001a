"""The picture of a tuning result: map, torque curve and lag."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from ..core.time.timebase import readable
from ..language.ramp_answers import Calculator, Value
from ..record.pictures.tuned import (
    FAILS,
    FAILS_NOMINALLY,
    HOLDS,
    REFUSED,
    Demand,
    GridMap,
    LagCurve,
    TorqueCurve,
    TuningPicture,
    draw,
)
from .judging import engine, law_of
from .search import WORST
from .task import MapPlace, Tuned
from .torque_curves import demand, pull_out, resonance

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

STATES = {"holds": HOLDS, "fails": FAILS, "fails nominally": FAILS_NOMINALLY, "refused": REFUSED}
POINTS, STRETCHES = 200, 500  # of the curve; of the lag, each with its minimum and maximum
AFTER = 60_000_000_000  # ps shown after the last step


def save_tuning(
    path: str | Path, tuned: Tuned, calculator: Calculator, width: str | float = "page", dark: bool = False
) -> None:
    """Draw a tuning result into an SVG, PNG or PDF file.

    Args:
        tuned: the result, including its full map.

    Raises:
        NothingHolds: no move was found.
        UsageError: the suffix is not supported, the path cannot be written, or matplotlib is not installed.
    """
    from ..record.pictures.picture_files import SUFFIXES, save
    from ..record.whole_file import check_suffix

    check_suffix(path, SUFFIXES)
    picture = picture_of(tuned, calculator)
    save(draw(picture, width, dark), path, picture.title, picture.description, dark)


def picture_of(tuned: Tuned, calculator: Calculator) -> TuningPicture:
    """Return the picture of the chosen move: the recommended one or, if there is none, the fastest that holds.

    Raises:
        NothingHolds: no move was found.
    """
    task, chosen = tuned.task, tuned.chosen
    title = f"{task.part}, {task.motor.name}, {task.steps} steps: {_values_text(calculator, chosen.values)}"
    return TuningPicture(title, _map(tuned, calculator), _curve(tuned, calculator), _lag(tuned, calculator))


def _values_text(calculator: Calculator, values: object) -> str:
    return ", ".join(f"{name} {value}" for name, value in calculator.without_defaults(values).items())  # type: ignore[arg-type]


def _map(tuned: Tuned, calculator: Calculator) -> GridMap | None:
    """Return the map over the two parameters with the most values; the other parameters are as in the chosen move.

    Return None if the tuning has no map, or if no parameter has more than one value.
    """
    grid, chosen = tuned.task.grid, tuned.chosen
    sizes = dict(zip(grid.names, map(len, grid.values), strict=True))
    names = sorted(grid.free, key=lambda name: -sizes[name])[:2]
    if not names or not tuned.map:
        return None
    names = sorted(names, key=grid.names.index, reverse=True)
    values = dict(zip(grid.names, grid.values, strict=True))
    columns: Sequence[Value] = values[names[0]]
    rows: Sequence[Value] = values[names[1]] if len(names) > 1 else ("",)
    others = [name for name in grid.free if name not in names]
    shown = [place for place in tuned.map if all(place.values[name] == chosen.values[name] for name in others)]

    def cell(place: MapPlace) -> tuple[int, int]:
        return (rows.index(place.values[names[1]]) if len(names) > 1 else 0), columns.index(place.values[names[0]])

    killers = list(dict.fromkeys(place.killer for place in shown if place.killer is not None))
    states = [[REFUSED] * len(columns) for _ in rows]
    killed = [[0] * len(columns) for _ in rows]
    for place in shown:
        y, x = cell(place)
        states[y][x] = STATES[place.says]
        killed[y][x] = 0 if place.killer is None else killers.index(place.killer) + 1
    y, x = cell(next(place for place in shown if place.values == chosen.values))
    note = ", ".join(f"{name} {chosen.values[name]}" for name in others)
    second = names[1] if len(names) > 1 else ""
    return GridMap((names[0], second), columns, rows, states, killed, killers, (x, y), note)


def _curve(tuned: Tuned, calculator: Calculator) -> TorqueCurve:
    """Return the pull-out curve, and the torque demands of the chosen move and of a faster move that fails.

    If several faster moves fail, the slowest of them is used; if none does, the second demand is omitted.
    """
    import numpy as np

    task, chosen = tuned.task, tuned.chosen
    micro = law_of(task.scenarios()[0]).micro
    failed = [
        place
        for place in tuned.map
        if place.killer is not None and place.time_ps is not None and place.time_ps < chosen.time_ps
    ]
    drawn = [(chosen.values, "the chosen ramp", False)]
    if failed:
        next_faster = max(failed, key=lambda place: place.time_ps or 0)
        drawn.append(
            (
                next_faster.values,
                f"next faster ramp, which fails: {_values_text(calculator, next_faster.values)}",
                True,
            )
        )
    demands = []
    for values, name, fails in drawn:
        times = calculator.ramp(values, task.crystal_hz).move(task.steps).times()
        demands.append(Demand(name, *demand(task.system, times, micro), fails))
    top = max(float(each.rates.max()) for each in demands)
    rates = np.linspace(1.0, 1.3 * top, POINTS)
    curves = [pull_out(row.of(task.system), task.stepping, rates) for row in task.perturbations]
    return TorqueCurve(
        rates, pull_out(task.system, task.stepping, rates), np.min(curves, axis=0), np.max(curves, axis=0),
        resonance(task.system), demands,
    )  # fmt: skip


def _lag(tuned: Tuned, calculator: Calculator) -> LagCurve:
    """Return the lag during the chosen move, without perturbations."""
    import numpy as np

    task, chosen = tuned.task, tuned.chosen
    times = calculator.ramp(chosen.values, task.crystal_hz).move(task.steps).times()
    times = times - times[0] + 1
    scenario = next(each for each in task.scenarios() if each.nominal)
    law = law_of(scenario)
    trace = law.integrate(times, np.arange(1, len(times) + 1), int(times[-1]) + AFTER, engine=engine())
    shown = outline(trace.lag)
    name = f"{_values_text(calculator, chosen.values)}: {readable(chosen.time_ps)}"
    return LagCurve(name, trace.times[shown], trace.lag[shown], WORST)


def outline(values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the indices to be drawn, (n,) ascending: both ends, and the minimum and maximum of each stretch.

    A stretch is one of `STRETCHES` equal parts of the values; if there are few values, all are drawn.
    """
    import numpy as np

    if len(values) <= 2 * STRETCHES:
        return np.arange(len(values), dtype=np.int64)
    ends = np.linspace(0, len(values), STRETCHES + 1).astype(np.int64)
    found = [int(of) + begin for begin, end in pairwise(ends.tolist())
             for of in (np.argmin(values[begin:end]), np.argmax(values[begin:end]))]  # fmt: skip
    return np.unique(np.array([0, *found, len(values) - 1], np.int64))
