"""ramp: what a ramp does, and which parameters give the ramp that is wanted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import click

from ..bench.ramps import find_ramps
from ..bench.ramps import ramp as ramp_of
from ..chips import ramps_of
from ..core.timebase import readable
from ..errors import UsageError
from ..language.ramps import Calculator, Move, Ramp
from .files import Outputs
from .programs import print_json
from .transcript import counted

MOST_DRAWN = 5_000_000  # steps


def ramp(
    chip: str,
    parameters: Sequence[str],
    crystal: str | None,
    distance: int | None,
    time: int | None,
    accel: float | None,
    steps: float | None,
    best: int,
    table: bool,
    as_json: bool,
    plot: str | None,
) -> int:
    """Print a ramp, or the ramps that come nearest to what is wanted."""
    outputs = Outputs([])
    outputs.claim(plot, (".svg", ".png"))
    calculator = ramps_of(chip)
    values = named(calculator, parameters)
    wanted = {"time": time, "acceleration": accel, "steps": steps}
    search = any(value is not None for value in wanted.values())
    found = (
        find_ramps(chip, crystal=crystal, count=best, **wanted, **values)  # type: ignore[arg-type]
        if search
        else [ramp_of(chip, crystal=crystal, **values)]
    )
    moves = [None if distance is None else each.move(distance) for each in found]
    outputs.save(plot, lambda path: draw(path, calculator, found[0], moves[0]))
    free = [name for name in found[0].values if calculator.quantity(name).free and name not in values]
    if as_json:
        objects = [ramp_object(each, move, table) for each, move in zip(found, moves, strict=True)]
        head = {"chip": calculator.sheet.part, "crystal_hz": crystal_hz(calculator, found[0])}
        goal = {UNITS[goal]: value for goal, value in wanted.items() if value is not None}
        print_json(head | ({"wanted": goal, "free": free, "found": objects} if search else objects[0]))
        return 0
    lines = [*(list_of(calculator, found, free) if search else summary(calculator, found[0])), *move_line(moves[0])]
    for line in (*lines, *(table_of(calculator, found[0]) if table else ())):
        click.echo(line)
    for path in outputs.written:
        click.echo(f"wrote {path}")
    return 0


def named(calculator: Calculator, parameters: Iterable[str]) -> dict[str, str]:
    """Parameters by name.

    Raises:
        UnknownName: no such parameter.
        UsageError: no NAME=VALUE, or a name twice.
    """
    values: dict[str, str] = {}
    for parameter in parameters:
        name, equals, value = (part.strip() for part in parameter.partition("="))
        if not (name and equals and value):
            raise UsageError(f"{parameter!r}: give a parameter and its value, such as R=100")
        known = calculator.quantity(name).name
        if known in values:
            raise UsageError(f"{calculator.sheet.part}: {name} twice; give one value")
        values[known] = value
    return values


UNITS = {"time": "time_ps", "acceleration": "acceleration_sps2", "steps": "steps"}


# ----------------------------------------------------------------------------------------------------------------- text
def summary(calculator: Calculator, ramp: Ramp) -> Iterator[str]:
    """A ramp in a few lines."""
    told = calculator.told(ramp.values)
    yield f"{head(calculator, ramp)}: {', '.join(f'{name} {value}' for name, value in told.items())}"
    yield f"rates         {number(ramp.start)} to {number(ramp.top)} steps/s"
    if not ramp.time_ps:
        yield "ramp          none"
    else:
        yield f"ramp          {readable(ramp.time_ps)}, {number(ramp.steps)} step{'' if ramp.steps == 1 else 's'}"
        yield f"acceleration  {accelerations(ramp)}"
    reached = ramp.reached_from
    yield "reached       " + ("by no move" if reached is None else f"from {counted(reached, 'step')} on")


def accelerations(ramp: Ramp) -> str:
    """One number, or the first, the mean and the greatest."""
    first, mean, greatest = (number(each) for each in ramp.accelerations)
    if first == mean == greatest:
        return f"{mean} steps/s²"
    return f"{mean} steps/s² in the mean, {first} at first, {greatest} at most"


def move_line(move: Move | None) -> Iterator[str]:
    """A move in a line."""
    if move is not None:
        legs = ", ".join(f"{name} {number(steps)}" for name, steps in move.legs)
        reached = "" if move.reached else f"; gets as far as {number(move.top)} steps/s"
        yield f"{counted(move.steps, 'step'):<13} {readable(move.time_ps)}: {legs}{reached}"


def list_of(calculator: Calculator, found: Sequence[Ramp], free: Sequence[str]) -> Iterator[str]:
    """The ramps that come nearest, a line each."""
    fixed = ", ".join(f"{name} {value}" for name, value in calculator.told(found[0].values).items() if name not in free)
    yield f"{head(calculator, found[0])}: {fixed}; {number(found[0].start)} to {number(found[0].top)} steps/s"
    rows = (
        [
            *(str(each.values[name]) for name in free),
            *map(number, (each.steps, each.acceleration)),
            readable(each.time_ps),
        ]
        for each in found
    )
    yield from columns([*free, "steps", "steps/s²", "time"], rows)


def table_of(calculator: Calculator, ramp: Ramp) -> Iterator[str]:
    """The ramp, stretch by stretch."""
    parameter = [calculator.parameter] if calculator.parameter else []
    rows = (
        [
            readable(each.begin_ps),
            number(each.position),
            *([str(each.parameter)] if parameter else []),
            number(each.rate),
            number(each.steps),
        ]
        for each in ramp.table()
    )
    yield from columns(["time", "position", *parameter, "steps/s", "steps"], rows)


def columns(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """A table, numbers to the right."""
    lines = [heads, *rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        yield "  ".join(f"{cell:>{width}}" for cell, width in zip(line, widths, strict=True))


def head(calculator: Calculator, ramp: Ramp) -> str:
    """The part, and its crystal if it has one."""
    hz = crystal_hz(calculator, ramp)
    return calculator.sheet.part + (f", {hz / 1e6:g} MHz" if hz else "")


def crystal_hz(calculator: Calculator, ramp: Ramp) -> int | None:
    """The crystal, if there is one to choose."""
    return ramp.crystal_hz if calculator.sheet.crystal_high_hz else None


def number(value: float) -> str:
    """A number as people want it: whole from 100 on, else with up to four digits that count."""
    return f"{value:.0f}" if abs(value) >= 100 or value == int(value) else f"{value:.4g}"


# ----------------------------------------------------------------------------------------------------------------- data
def ramp_object(ramp: Ramp, move: Move | None, table: bool) -> dict[str, Any]:
    """A ramp as data."""
    found: dict[str, Any] = {
        "parameters": dict(ramp.values),
        "start_sps": exact(ramp.start),
        "top_sps": exact(ramp.top),
        "time_ps": ramp.time_ps,
        "steps": ramp.steps,
        "acceleration_sps2": {name: exact(value) for name, value in ramp.accelerations._asdict().items()},
        "reached_from": ramp.reached_from,
        "move": None if move is None else move_object(move),
    }
    if table:
        found["table"] = [each._asdict() | {"rate": exact(each.rate)} for each in ramp.table()]
    return found


def move_object(move: Move) -> dict[str, Any]:
    """A move as data."""
    found = {"steps": move.steps, "time_ps": move.time_ps, "top_sps": exact(move.top), "reached": move.reached}
    return found | {"legs": dict(move.legs)}


def exact(value: float) -> float:
    """Nine digits: what is left behind them is rounding."""
    return float(f"{value:.9g}")


# -------------------------------------------------------------------------------------------------------------- picture
def draw(path: str, calculator: Calculator, ramp: Ramp, move: Move | None) -> None:
    """Draw a move: the one that is asked for, or the shortest one that comes to the rate.

    Raises:
        UsageError: no move comes to the rate, or one of too many steps.
    """
    import numpy as np

    from ..core.axis import Steps
    from ..record.plots import Motion, plot

    if move is None:
        reached = ramp.reached_from
        if reached is None:
            raise UsageError(f"{path}: no move comes to {number(ramp.top)} steps/s; give --distance")
        move = ramp.move(reached)
    if move.steps > MOST_DRAWN:
        raise UsageError(f"{path}: {move.steps} steps; allowed up to {MOST_DRAWN}; give --distance")
    count = np.arange(1, move.steps + 1)
    steps = Steps(move.times(), np.ones(move.steps, np.int8), count)
    rates = {"top": ramp.top} | ({"start": ramp.start} if ramp.start else {})
    motion = Motion(calculator.sheet.part, steps, rates, calculator.told(ramp.values))
    plot(path, f"{head(calculator, ramp)}: {move.steps} steps", motion, start=0, stop=move.time_ps)
