"""Quantities with a value at every instant, by name: "x.velocity", "m.axis2.position", "driver.current"."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from ...core.chip import Chip
from ...core.messages.near import hint
from ...core.motion.one_axis import OneAxis
from ...core.motion.quantity import Quantity
from ...core.time.timebase import Time, moment
from ...errors import UnknownName
from ...parts.base.part import Part


def axes_of(chip: Chip) -> Iterator[tuple[str, OneAxis]]:
    """Yield the axes of a chip, each with the prefix of its quantities: "m.axis2", or "x" for a one-axis chip."""
    for number in range(1, chip.sheet.axes + 1):
        yield chip.name if chip.sheet.axes == 1 else f"{chip.name}.axis{number}", chip.axis(number)


Chosen = tuple[Part, tuple[Quantity, ...]]  # a part, and its quantities shown


def chosen(parts: Mapping[str, Part], wanted: Sequence[str] | str | None, chips: Sequence[Chip]) -> list[Chosen]:
    """Return the selected parts, each with its selected quantities.

    Args:
        wanted: names of parts, or of single quantities, "m.position"; None: all parts that have quantities and are
            connected to one of the chips, directly or through other parts.

    Raises:
        UnknownName: there is no such part or quantity, or a part without quantities is named.
    """
    if wanted is None:
        around = attached(parts.values(), chips)
        return [(part, found) for part in around if (found := part.quantities())]
    shown: dict[str, list[Quantity]] = {}
    for name in [wanted] if isinstance(wanted, str) else wanted:
        owner, dot, what = name.partition(".")
        quantities = parts[owner].quantities() if owner in parts else ()
        named = [quantity for quantity in quantities if not dot or quantity.name == what]
        if not named:
            known = [f"{part.name}.{each.name}" for part in parts.values() for each in part.quantities()]
            message = f"parts: no quantity {name!r}; available: {', '.join(known) or 'none'}"
            raise UnknownName(message + hint(name, known))
        own = shown.setdefault(owner, [])
        own += [quantity for quantity in named if quantity.name not in {each.name for each in own}]
    return [(parts[owner], tuple(quantities)) for owner, quantities in shown.items()]


def attached(parts: Iterable[Part], chips: Iterable[Chip]) -> list[Part]:
    """Return the parts connected to one of the chips by wires or shafts, directly or through other parts."""
    reached: set[object] = {terminal.net.root for chip in chips for terminal in chip.pins.values()}
    every = rest = list(parts)
    found: list[Part] = []
    while near := [part for part in rest if not reached.isdisjoint(joints_of(part))]:
        found += near
        rest = [part for part in rest if part not in near]
        reached.update(*map(joints_of, near))
    return [part for part in every if part in found]


def joints_of(part: Part) -> set[object]:
    """Return the connections of a part to others: the wires on its pins, and the source that drives its shaft."""
    source = getattr(getattr(part, "shaft", None), "source", None)
    return {*(pin.net.root for pin in part.pins.values()), *([source] if source is not None else [])}


def moving_from_to(axis: OneAxis, start: int, stop: int) -> tuple[int, int] | None:
    """Return the first and the last instant (ps) at which an axis moves in a window; None if there is no step."""
    played = [(train, a, b) for _, train, a, b in axis.motor.played(start, stop)]
    if not played:
        return None
    train, a, _ = played[0]
    begin = max(train.clock.ps(train.end(a) if a else train.origin), start)
    train, _, b = played[-1]
    last = train.clock.ps(train.end(b - 1))
    times, values = axis.quantities()[0].outline(last, stop, 100)
    rests = times[values == 0]
    return begin, int(rests[0]) if len(rests) else stop


def first_step(axis: OneAxis, stop: int) -> int | None:
    """Return the instant (ps) of the first step of an axis up to `stop`; None if it takes no step by then."""
    return next((train.clock.ps(train.end(a)) for _, train, a, _ in axis.motor.played(0, stop)), None)


def moments_of(times: Time | Iterable[Time]) -> list[int]:
    """Return one time, or several, as a list of instants in picoseconds."""
    return [moment(time) for time in ([times] if isinstance(times, Time) else times)]
