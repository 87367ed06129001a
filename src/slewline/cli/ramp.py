"""ramp: the time and steps of a ramp, and the parameters that produce a required ramp."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from ..bench.ramp_calculator import find_ramps
from ..bench.ramp_calculator import ramp as ramp_of
from ..chips import ramps_of
from ..core.messages.decimal_comma import without_comma
from ..core.messages.whole import counted
from ..core.time.timebase import readable
from ..errors import UsageError
from ..language.ramp_answers import Calculator, Move, Ramp
from ..record.pictures.picture_files import SUFFIXES
from ..record.style import aligned
from .files import Outputs, read_options
from .programs import print_json

if TYPE_CHECKING:
    from ..record.pictures.tracks import Track

UNREACHED = 10**18  # ps, steps or steps/s^2: more than any ramp has
BEST = 5  # ramps listed by default
MAX_COMPARED = 8  # ramps compared in one list of values
MAX_DRAWN = 5_000_000  # steps


def ramp(
    chip: str,
    parameters: Sequence[str],
    crystal: str | None,
    distance: int | None,
    time: int | None,
    accel: float | None,
    steps: float | None,
    best: int | None,
    table: bool,
    as_json: bool,
    plot: str | None,
    options: str | None = None,
) -> int:
    """Print the ramps of the given parameters, or the ramps nearest to the requested values; return 0."""
    outputs = Outputs([])
    outputs.claim(plot, SUFFIXES)
    fitting = read_options(options, chip) or None
    calculator = ramps_of(chip, fitting)
    values, *others = several(calculator, parameters)
    wanted = {"time_ps": time, "acceleration_sps2": accel, "steps": steps}
    goal = {name: value for name, value in wanted.items() if value is not None}
    if best is not None and not goal:
        raise UsageError("--best: needs --time, --accel or --steps")
    if goal and others:
        raise UsageError(
            "a list of values cannot be combined with a search; leave out --time, --accel and --steps, or the list"
        )
    if goal:
        found = nearest(chip, crystal, BEST if best is None else best, wanted, values, fitting)
    else:
        found = [ramp_of(chip, crystal=crystal, options=fitting, **each) for each in (values, *others)]
    moves = [None if distance is None else each.move(distance) for each in found]
    outputs.save(plot, lambda path: draw(path, calculator, found[: len(others) + 1], moves))
    free = [name for name in found[0].values if calculator.quantity(name).free and name not in values]
    if as_json:
        objects = [ramp_object(each, move, table) for each, move in zip(found, moves, strict=True)]
        head = {"chip": calculator.sheet.part, "crystal_hz": crystal_hz(calculator, found[0])}
        one = {"wanted": goal, "free": free, "found": objects} if goal else {"ramps": objects} if others else objects[0]
        print_json(head | one)
        return 0
    if goal:
        lines = [*list_of(calculator, found, free), *move_line(moves[0])]
        lines += [*(table_of(calculator, found[0]) if table else ())]
        lines += bound(chip, crystal, wanted, values, fitting, found)
    else:
        lines = []
        for each, move in zip(found, moves, strict=True):
            lines += [*summary(calculator, each), *move_line(move), *(table_of(calculator, each) if table else ())]
    for line in lines:
        click.echo(line)
    for path in outputs.written:
        click.echo(f"wrote {path}")
    return 0


def bound(
    chip: str,
    crystal: str | None,
    wanted: Mapping[str, float | None],
    values: Mapping[str, str],
    options: Mapping[str, Any] | None,
    found: Sequence[Ramp],
) -> Iterator[str]:
    """Yield a line with the limit if the requested value is below the lowest or above the highest possible one."""
    name, goal = next((name, value) for name, value in wanted.items() if value is not None)
    has = [getattr(each, {"acceleration_sps2": "acceleration"}.get(name, name)) for each in found]
    if min(has) <= goal <= max(has):
        return
    least, most = {
        "time_ps": ("shorter", "longer"), "acceleration_sps2": ("slower", "steeper"), "steps": ("shorter", "longer"),
    }[name]  # fmt: skip
    end, word = (1, least) if min(has) > goal else (UNREACHED, most)
    (last,) = nearest(chip, crystal, 1, {each: end if each == name else None for each in wanted}, values, options)
    value = getattr(last, {"acceleration_sps2": "acceleration"}.get(name, name))
    if (value > goal) == (word == least):
        unit = {"acceleration_sps2": " steps/s²", "steps": " steps"}.get(name, "")
        yield f"none is {word} than {readable(value) if name == 'time_ps' else number(value)}{unit}"


def nearest(
    chip: str,
    crystal: str | None,
    best: int,
    wanted: Mapping[str, float | None],
    values: Mapping[str, str],
    options: Mapping[str, Any] | None = None,
) -> list[Ramp]:
    """Return at most `best` ramps, the nearest to the requested values; a requested time is in whole ps."""
    time, accel, steps = wanted.values()
    duration = None if time is None else f"{time} ps"  # a bare number below 1000 would be refused
    goal = {"time": duration, "acceleration": accel, "steps": steps}
    return find_ramps(chip, crystal=crystal, count=best, options=options, **goal, **values)  # type: ignore[arg-type]


def several(calculator: Calculator, parameters: Sequence[str]) -> list[dict[str, str]]:
    """Return the parameters of every requested ramp; a list, S=1,100,200, requests one ramp for each value.

    Raises:
        UnknownName: there is no such parameter.
        UsageError: a parameter is not NAME=VALUE, a name is given twice, there is more than one list, or a
            list is too long.
    """
    values = named(calculator, parameters)
    lists = {name: text.split(",") for name, text in values.items() if "," in text}
    if len(lists) > 1:
        raise UsageError(f"{' and '.join(lists)}: lists of values; give one list, and a single value for the others")
    for name, texts in lists.items():
        if re.search("[a-z]", texts[-1]) and re.fullmatch("[\\d ]+", texts[0]):
            each = "; in a list each value has its unit" if len(texts) > 1 else ""
            raise UsageError(f"{calculator.sheet.part}: {name} {values[name]!r}{without_comma(values[name])}{each}")
        if len(texts) > MAX_COMPARED:
            raise UsageError(f"{name}: {len(texts)} values; allowed up to {MAX_COMPARED}")
        return [{**values, name: text.strip()} for text in texts]
    return [values]


def named(calculator: Calculator, parameters: Sequence[str]) -> dict[str, str]:
    """Return the values of parameters that are given as texts NAME=VALUE, keyed by name.

    Raises:
        UnknownName: there is no such parameter.
        UsageError: a parameter is not NAME=VALUE, or a name is given twice.
    """
    values: dict[str, str] = {}
    for parameter in parameters:
        name, equals, value = (part.strip() for part in parameter.partition("="))
        if "=" in value or "=" in parameters:
            parted = re.sub(r"\s*=\s*", "=", " ".join(parameters)).replace(",", " ").split()
            message = f"{parameter!r}: a parameter is NAME=VALUE without spaces; separate parameters with spaces"
            raise UsageError(f"{message}; write {' '.join(parted)}")
        if not (name and equals and value):
            raise UsageError(f"{parameter!r}: give a parameter and its value, such as R=100")
        known = calculator.quantity(name).name
        if known in values:
            raise UsageError(f"{calculator.sheet.part}: {name} is given twice; give one value")
        values[known] = value
    return values


# ----------------------------------------------------------------------------------------------------------------- text
def summary(calculator: Calculator, ramp: Ramp) -> Iterator[str]:
    """Yield the lines that describe a ramp."""
    shown_values = calculator.without_defaults(ramp.values)
    yield f"{head(calculator, ramp)}: {', '.join(f'{name} {value}' for name, value in shown_values.items())}"
    yield f"rates         {number(ramp.start)} to {number(ramp.top)} steps/s"
    if not ramp.time_ps:
        why = calculator.level(ramp)
        yield f"ramp          none{why and f': {why}'}"
    else:
        yield f"ramp          {readable(ramp.time_ps)}, {number(ramp.steps)} step{'' if ramp.steps == 1 else 's'}"
        yield f"acceleration  {accelerations(ramp)}"
    reached = ramp.reached_from
    moves = "no move" if reached is None else f"moves of {counted(reached, 'step')} or more"
    yield f"full rate     reached in {moves}"


def accelerations(ramp: Ramp) -> str:
    """Return the acceleration as text: one number, or the mean, initial and maximum values."""
    first, mean, greatest = (number(each) for each in ramp.accelerations)
    if first == mean == greatest:
        return f"{mean} steps/s²"
    return f"{mean} steps/s² on average, initially {first}, maximum {greatest}"


def move_line(move: Move | None) -> Iterator[str]:
    """Yield a line that describes a move; yield nothing if the move is None."""
    if move is not None:
        legs = ", ".join(f"{name} {number(steps)}" for name, steps in move.legs)
        reached = "" if move.reached else f"; reaches {number(move.top)} steps/s"
        yield f"{counted(move.steps, 'step'):<13} {readable(move.time_ps)}: {legs}{reached}"


def list_of(calculator: Calculator, found: Sequence[Ramp], free: Sequence[str]) -> Iterator[str]:
    """Yield a heading, then a table with one line for each ramp found."""
    fixed = ", ".join(
        f"{name} {value}" for name, value in calculator.without_defaults(found[0].values).items() if name not in free
    )
    yield f"{head(calculator, found[0])}: {fixed}; {number(found[0].start)} to {number(found[0].top)} steps/s"
    rows = (
        [
            *(str(each.values[name]) for name in free),
            *map(number, (each.steps, each.acceleration)),
            readable(each.time_ps),
        ]
        for each in found
    )
    yield from aligned([[*free, "steps", "steps/s²", "time"], *rows])


def table_of(calculator: Calculator, ramp: Ramp) -> Iterator[str]:
    """Yield a ramp as a table, segment by segment."""
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
    yield from aligned([["time", "position", *parameter, "steps/s", "steps"], *rows])


def head(calculator: Calculator, ramp: Ramp) -> str:
    """Return the part number, with the crystal frequency if the part has one that can be chosen."""
    hz = crystal_hz(calculator, ramp)
    return calculator.sheet.part + (f", {hz / 1e6:g} MHz" if hz else "")


def crystal_hz(calculator: Calculator, ramp: Ramp) -> int | None:
    """Return the crystal frequency, Hz; None if the part has none that can be chosen."""
    return ramp.crystal_hz if calculator.sheet.crystal_high_hz else None


def number(value: float) -> str:
    """Return a number as text: rounded to a whole number from 100 upwards, else to four significant digits."""
    return f"{value:.0f}" if abs(value) >= 100 or value == int(value) else f"{value:.4g}"


# ----------------------------------------------------------------------------------------------------------------- data
def ramp_object(ramp: Ramp, move: Move | None, table: bool) -> dict[str, Any]:
    """Return a ramp and its move, if any, as data for JSON; if `table`, also the segments of the ramp."""
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
    """Return a move as data for JSON."""
    found = {"steps": move.steps, "time_ps": move.time_ps, "top_sps": exact(move.top), "reached": move.reached}
    return found | {"legs": dict(move.legs)}


def exact(value: float) -> float:
    """Return a value rounded to nine significant digits; further digits are rounding errors."""
    return float(f"{value:.9g}")


# -------------------------------------------------------------------------------------------------------------- picture
def draw(path: str, calculator: Calculator, ramps: Sequence[Ramp], moves: Sequence[Move | None]) -> None:
    """Draw a move for every ramp: the requested one, else the shortest that reaches the ramp's top rate.

    If several ramps are compared and no move is requested, each move has as many steps as the longest of
    these shortest moves, so that all cover the same distance.

    Raises:
        UsageError: no move reaches the rate, or the move has too many steps.
    """
    from ..record.pictures.figures import Contents, description_of, figure
    from ..record.pictures.picture_files import save
    from ..record.style import grouped

    reached = [ramp.reached_from for ramp in ramps]
    longest = max((steps for steps in reached if steps is not None), default=0)
    if len(ramps) > 1 and None not in reached:  # compared ramps make moves of the same distance
        moves = [ramp.move(longest) if move is None else move for ramp, move in zip(ramps, moves, strict=True)]
    drawn = [drawable(path, ramp, move) for ramp, move in zip(ramps, moves, strict=False)]
    shown_values = [
        {name: grouped(value) for name, value in calculator.without_defaults(ramp.values).items()} for ramp in ramps
    ]
    alike = [name for name, value in shown_values[0].items() if all(each.get(name) == value for each in shown_values)]
    note = ", ".join(f"{name} = {shown_values[0][name]}" for name in alike)
    names = [", ".join(f"{name} = {each[name]}" for name in each if name not in alike) for each in shown_values]
    steps = ", ".join(dict.fromkeys(grouped(move.steps) for move in drawn))
    title = f"{head(calculator, ramps[0])}: {steps} step{'s' * (steps != '1')}"
    called = zip(names, ramps, drawn, strict=True)
    tracks = [track_of(name or calculator.sheet.part, ramp, move) for name, ramp, move in called]
    contents = Contents(
        title, tracks, [], 0, max(move.time_ps for move in drawn), notes=[note] * bool(note), marks=False
    )
    picture = figure(contents)
    save(picture, path, title, description_of(picture))


def drawable(path: str, ramp: Ramp, move: Move | None) -> Move:
    """Return the given move or, if it is None, the shortest move that reaches the top rate of the ramp.

    Raises:
        UsageError: no move reaches the rate, or the move has too many steps.
    """
    if move is None:
        reached = ramp.reached_from
        if reached is None:
            raise UsageError(f"{path}: no move reaches {number(ramp.top)} steps/s; give a move with --distance")
        move = ramp.move(reached)
    if move.steps > MAX_DRAWN:
        raise UsageError(f"{path}: {move.steps} steps; allowed up to {MAX_DRAWN}; give a shorter --distance")
    return move


def track_of(name: str, ramp: Ramp, move: Move) -> Track:
    """Return the track of an axis (its velocity and position curves) during a move."""
    from ..core.motion.axis import Axis
    from ..core.motion.motions import MotionStart
    from ..core.motion.quantity import Position, Velocity
    from ..core.motion.train import Playing
    from ..core.time.kernel import Kernel
    from ..record.pictures.tracks import Track

    kernel = Kernel()
    axis = Axis(kernel, range(move.steps + 1), 0)
    for train in move.trains():
        kernel.run(train.clock.ps(train.origin))
        axis.follow(Playing(train), 1)
    kernel.run(move.time_ps)
    rates = {"top": ramp.top} | ({"start": ramp.start} if ramp.start else {})
    return Track(name, [Velocity(axis), Position(axis)], [MotionStart(0, "", rates)], until=move.time_ps)
