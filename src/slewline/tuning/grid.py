"""The grid: the values of ramp parameters, and the neighbours of each grid point.

F=3..10             every integer
S=1..254/8          eight values, evenly spaced in the parameter's `measure`
R=4..40 by 4        every fourth value
R=4,8,15            these values
R=400 steps/s..4000 steps/s/12      twelve rates, with their unit
R=120 rpm..1200 rpm/12              also in rpm or rev/s, if the motor's steps per revolution are known
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import prod

from ..core.datasheet.units import in_steps
from ..core.messages.whole import whole
from ..errors import UsageError
from ..language.ramp_answers import Calculator, RampParameter, Value, value_of

MOST = 1_000_000  # places
Given = str | int | Iterable[Value]  # the values of a parameter, from Python

_NAME = re.compile(r"(?:^|(?<=[\s;]))\s*([A-Za-z_]\w*)\s*=")
_DASH = re.compile(r"([0-9]+)\s*-\s*([0-9]+)")
_RANGE = re.compile(r"(.*?)\.\.(.*?)(?:\s*/\s*(\d{1,9})|\s+by\s+(\d{1,9}))?")
_UNIT = re.compile(r"[+-]?[\d.eE+-]+\s*([a-zA-Z].*)")
FORMS = "a range such as 3..10, 1..254/8 (eight values) or 4..40 by 4, or a list such as 4,8,15"


@dataclass(frozen=True, slots=True)
class Grid:
    """Parameters with their values in ascending order.

    Points are numbered 0 to `size` - 1; the last parameter varies fastest.
    """

    names: tuple[str, ...]
    values: tuple[tuple[Value, ...], ...]

    @property
    def size(self) -> int:
        """The number of grid points."""
        return prod(map(len, self.values))

    def at(self, place: int) -> dict[str, Value]:
        """Return the values of the parameters at a grid point, by name."""
        return {name: of[digit] for name, of, digit in zip(self.names, self.values, self.digits(place), strict=True)}

    def digits(self, place: int) -> tuple[int, ...]:
        """Return, for each parameter, the index of its value at a grid point."""
        found = []
        for of in reversed(self.values):
            place, digit = divmod(place, len(of))
            found.append(digit)
        return tuple(reversed(found))

    def neighbours(self, place: int) -> Iterator[int]:
        """Yield the grid points at which one parameter has the next lower or higher value: up to two per parameter."""
        apart = 1
        for of, digit in zip(reversed(self.values), reversed(self.digits(place)), strict=True):
            if digit:
                yield place - apart
            if digit + 1 < len(of):
                yield place + apart
            apart *= len(of)

    @property
    def free(self) -> tuple[str, ...]:
        """The names of the parameters with more than one value."""
        return tuple(name for name, of in zip(self.names, self.values, strict=True) if len(of) > 1)

    def __str__(self) -> str:
        return " ".join(f"{name}={_short(of)}" for name, of in zip(self.names, self.values, strict=True))


def _short(values: Sequence[Value]) -> str:
    return ",".join(map(str, values)) if len(values) <= 4 else f"{values[0]}..{values[-1]} ({len(values)} values)"


def read_grid(
    calculator: Calculator, given: str | Mapping[str, Given] | None, crystal_hz: int, per_turn: int | None = None
) -> Grid:
    """Return the grid described by a user; omitted parameters have default values (`RampParameter.tried`).

    Args:
        per_turn: the motor's steps per revolution, for rates in rpm or rev/s; None if there is no motor.

    Raises:
        UnknownName: a parameter does not exist.
        UsageError: a value is not valid for its parameter or is out of range, or the grid has more than a
            million points.
    """
    part = calculator.sheet.part
    texts = _split(part, given) if isinstance(given, str) else dict(given or {})
    named: dict[str, Given] = {}
    for name, text in texts.items():
        known = calculator.quantity(name).name
        if known in named:
            raise UsageError(f"{part}: {name} is given twice; give its values once")
        named[known] = text
    values: dict[str, tuple[Value, ...]] = {}
    for quantity in calculator.quantities:
        if quantity.only is not None and quantity.only[1] not in values.get(quantity.only[0], ()):
            if quantity.name in named:
                raise UsageError(
                    f"{part}: {quantity.name} applies only to {' '.join(quantity.only)}; "
                    f"leave it out, or set {'='.join(quantity.only)}"
                )
            continue
        values[quantity.name] = _values(calculator, quantity, named.get(quantity.name), crystal_hz, per_turn)
    grid = Grid(tuple(values), tuple(values.values()))
    if grid.size > MOST:
        raise UsageError(
            f"{part}: {_sizes(grid)} = {grid.size} points; allowed up to {MOST}; "
            "use fewer values: /12 after a range takes 12 of its values"
        )
    return grid


def _sizes(grid: Grid) -> str:
    return " x ".join(f"{len(of)} {name}" for name, of in zip(grid.names, grid.values, strict=True) if len(of) > 1)


def _split(part: str, text: str) -> dict[str, Given]:
    """Return the text of each parameter's values, by the parameter's name, from the text of a whole grid."""
    found = list(_NAME.finditer(text))
    before = text[: found[0].start()] if found else text
    if before.strip():
        raise UsageError(f"{part}: grid {before.strip()!r}; give parameters and their values, such as S=1..254/8")
    ends = [*(each.start() for each in found[1:]), len(text)][: len(found)]
    texts: dict[str, Given] = {}
    for match, end in zip(found, ends, strict=True):
        if match[1] in texts:
            raise UsageError(f"{part}: {match[1]} is given twice; give its values once")
        texts[match[1]] = text[match.end() : end].strip(" \t\r\n;")
    return texts


def _values(
    calculator: Calculator, quantity: RampParameter, given: Given | None, hz: int, per_turn: int | None
) -> tuple[Value, ...]:
    """Return the values of a parameter in ascending order; if none are given, its default values."""
    where = f"{calculator.sheet.part}: {quantity.name}"
    if given is None:
        if not quantity.tried and quantity.default is None:
            raise UsageError(f"{where} has no values; give {FORMS}")
        given = quantity.tried or str(quantity.default)
    if isinstance(given, str):
        values = _spoken(calculator, quantity, given, hz, per_turn)
    elif (number := whole(given)) is not None:
        values = [value_of(calculator, quantity, number, hz)]
    elif isinstance(given, Iterable):
        values = [_value(calculator, quantity, each, hz, per_turn) for each in given]
    else:
        raise UsageError(f"{where} {given!r}; allowed {FORMS}")
    if not values:
        raise UsageError(f"{where}: no values; allowed {FORMS}")
    if quantity.arg is None:
        if len(values) > 1:
            raise UsageError(f"{where}: {len(values)} values; give one of {quantity.allowed}")
        return tuple(values)
    return tuple(sorted(set(values), key=int))


def _value(calculator: Calculator, quantity: RampParameter, given: object, hz: int, per_turn: int | None) -> Value:
    """Return a given value of a parameter; a rate may be in rpm or rev/s, if `per_turn` is known."""
    if isinstance(given, str) and per_turn is not None:
        given = in_steps(given, per_turn)
    return value_of(calculator, quantity, given, hz)


def _spoken(calculator: Calculator, quantity: RampParameter, text: str, hz: int, per_turn: int | None) -> list[Value]:
    """Return the values of a parameter from their text, such as "4,8,15" or "1..254/8"."""
    where = f"{calculator.sheet.part}: {quantity.name} {text!r}"
    if quantity.arg is None:
        return [value_of(calculator, quantity, each.strip(), hz) for each in text.split(",")]
    if not text:
        raise UsageError(f"{where}: no values; allowed {FORMS}")
    if of_python := re.fullmatch(r"range\(\s*(\d+)\s*,\s*(\d+)\s*\)", text):
        raise UsageError(f"{where}: write {of_python[1]}..{int(of_python[2]) - 1}")
    found: list[Value] = []
    for piece in text.split(","):
        if not piece.strip():
            raise UsageError(f"{where}: a comma without a value; separate parameters with spaces, as in F=4,6 R=8")
        if dash := _DASH.fullmatch(piece.strip()):
            raise UsageError(f"{where}: write {dash[1]}..{dash[2]} for a range")
        if ".." not in piece:
            found.append(_value(calculator, quantity, piece.strip(), hz, per_turn))
            continue
        match = _RANGE.fullmatch(piece.strip())
        if match is None or not (match[1].strip() and match[2].strip()):
            raise UsageError(f"{where}; allowed {FORMS}")
        first, last = match[1].strip(), match[2].strip()
        unit = _UNIT.fullmatch(last)
        if unit and not _UNIT.fullmatch(first):
            first = f"{first} {unit[1]}"
        low, high = (int(_value(calculator, quantity, each, hz, per_turn)) for each in (first, last))
        if high < low:
            raise UsageError(f"{where}: {high} is below {low}; give the lower value first")
        count, by = (None if each is None else int(each) for each in (match[3], match[4]))
        if count == 0 or by == 0:
            raise UsageError(f"{where}: empty range; write 1 or more after {'/' if count == 0 else 'by'!r}")
        among = range(low, high + 1, by or 1)
        if min(len(among), count or len(among)) > MOST:
            raise UsageError(
                f"{where}: {len(among)} values; allowed up to {MOST}; use fewer, such as {first}..{last}/12"
            )
        found += among if count is None else evenly(quantity, low, high, count)
    return found


def evenly(quantity: RampParameter, low: int, high: int, count: int) -> Iterator[int]:
    """Yield up to `count` integers from `low` to `high`, evenly spaced in the parameter's `measure`."""
    every, measure = range(low, high + 1), quantity.measure
    if count >= len(every):
        yield from every
        return
    first, span = measure(low), measure(high) - measure(low)
    last = None
    for number in range(count):
        target = first + span * number / max(count - 1, 1)
        value = min(low + bisect_left(every, target, key=measure), high)
        if value > low and target - measure(value - 1) < measure(value) - target:
            value -= 1
        if value != last:
            yield value
        last = value
