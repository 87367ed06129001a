"""Signals in a window, reduced to the columns of a picture, at a cost independent of the window's length.

A pin with few edges is sent edge by edge; a pin with many edges as one character per
column.  A single search in the log finds this character, however many edges the column has.  A long
window is cached in cells (`cells.py`):

    edges     _|‾|_|‾|_|‾|_|‾‾‾‾‾‾‾‾‾‾|___________
    columns   x    x    x    1    1    0    0
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import pairwise
from math import isnan
from typing import TYPE_CHECKING, Any

from ...core.motion.quantity import column_edges
from ...errors import NotRecorded
from ...record.recording.recorder import Recorder
from .cells import BOTH, UNKNOWN, Cells, Points, points, sign, width_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ...bench import Bench
    from ...core.chip import Chip
    from ...core.motion.quantity import Quantity
    from ...core.wires.net import Net
    from ...core.wires.pin import Terminal
    from ...parts.base.part import Part

    Probe = Net | Terminal

FEW = 2  # number of edges per column up to which each edge is sent
Data = dict[str, Any]


def plain(level: int) -> int | None:
    """Return a level in the form sent to a client: None if the pin floats."""
    return None if level < 0 else level


class Scope:
    """The history of the signals on a bench."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.recorder = bench, Recorder()
        self.points: Cells[Points] = Cells()
        self.signs: Cells[str] = Cells()

    def move(self, bench: Bench) -> None:
        """Start to show the signals of another bench."""
        self.bench, self.recorder = bench, Recorder()
        self.points, self.signs = Cells(), Cells()

    def signals(self) -> dict[str, Any]:
        """Return the available signals: names of pins, by owner, and full names of quantities."""
        bench = self.bench
        owners: list[Chip | Part] = [*bench.chips.values(), *bench.parts.values()]
        pins = {
            owner.name: [name for name, pin in owner.pins.items() if pin.row.in_out in ("in", "out", "both")]
            for owner in owners
        }
        return {"pins": {name: found for name, found in pins.items() if found}, "quantities": [*self.quantities()]}

    def quantities(self) -> Mapping[str, Quantity]:
        """Return the quantities of axes and parts, by full name."""
        return self.bench.quantities()

    def window(self, names: list[str], start: int, stop: int, columns: int) -> Iterator[Data | None]:
        """Yield None whenever other work may be done; finally, yield the signals' histories in the window (ps).

        A signal that has no history in the window has an `error` instead.
        """
        found: Data = {}
        known = self.quantities()
        for name in names:
            try:
                if name in known:
                    yield from self._quantity(found, name, max(start, self._kept(name)), stop, columns)
                else:
                    yield from self._pin(found, name, start, stop, columns)
            except NotRecorded as error:
                found[name] = {"kind": "quantity" if name in known else "pin", "error": str(error)}
        yield found

    def _quantity(self, found: Data, name: str, start: int, stop: int, columns: int) -> Iterator[Data | None]:
        quantity = self.bench.quantity(name)
        times: list[int] = []
        values: list[float | None] = []
        if exponent := width_of(start, stop, columns):
            for _, (more, shown) in self.points.between(name, start, stop, exponent, partial(points, quantity)):
                times += more
                values += shown
                yield None
        else:
            outline = quantity.outline(start, stop, columns)
            times = outline.times_ps.tolist()
            values = [None if isnan(value) else value for value in outline.values.tolist()]
        shape = {"kind": "quantity", "unit": quantity.unit, "held": quantity.is_staircase}
        found[name] = shape | {"times_ps": times, "values": values}

    def _pin(self, found: Data, name: str, start: int, stop: int, columns: int) -> Iterator[Data | None]:
        probe, recorder = self.probe(name), self.recorder
        since = recorder.since(probe)
        shape: Data = {"kind": "pin", "since_ps": since}
        first = max(start, since)
        if first > stop:
            found[name] = shape | {"columns": UNKNOWN * columns}
            return
        times, levels = [first], [recorder.level(probe, first)]
        for time, level in recorder.each_edge(probe, first + 1, stop):
            times.append(time)
            levels.append(level)
            if len(times) > FEW * columns:
                break
        else:
            found[name] = shape | {"times_ps": times, "levels": [plain(level) for level in levels]}
            return
        yield None
        signs = [UNKNOWN] * columns
        if exponent := width_of(start, stop, columns):
            work = partial(sign, recorder, probe, since=since)
            for begin, shown in self.signs.between(name, start, stop, exponent, work):
                column = min(max((begin - start) * columns // (stop - start), 0), columns - 1)
                signs[column] = shown if signs[column] in (UNKNOWN, shown) else BOTH
                yield None
        else:
            edges = [*column_edges(start, stop, columns), stop + 1]
            for column, (begin, end) in enumerate(pairwise(edges)):
                signs[column] = sign(recorder, probe, begin, end - 1, since)
                yield None
        found[name] = shape | {"columns": "".join(signs)}

    def probe(self, name: str) -> Probe:
        """Return a recorded pin by its full name.

        Raises:
            UnknownName: there is no such pin.
            NotRecorded: the pin is not recorded.
        """
        if name not in self.bench.recorded:
            self.bench.pin(name)
            raise NotRecorded(f"{name} is not recorded; use `record` to record it from now on")
        return self.bench.recorded[name]

    def _kept(self, name: str) -> int:
        """Return the start of the stored history of an axis (ps); 0 for a part."""
        owner, _, rest = name.partition(".")
        if owner not in self.bench.chips:
            return 0
        number = int(rest.partition(".")[0].removeprefix("axis")) if rest.startswith("axis") else 1
        return self.bench.chips[owner].axis(number).motor.since

    def find(self, on: Mapping[str, Any], start: int, stop: int, last: bool) -> int | None:
        """Return the first or, if `last`, the last instant (ps) of an event in a window; None if there is none.

        Raises:
            UsageError: `on` is not a pin with an edge or level, a quantity with a value and slope, or a finding.
            NotRecorded: the pin is not recorded.
        """
        if "level" in on:
            return self._level(on["pin"], on["level"], start, stop, last)
        if "pin" in on:
            return self._edge(on["pin"], on.get("edge", "any"), start, stop, last)
        if "quantity" in on:
            return self._crossing(on["quantity"], on["value"], on.get("slope", "any"), start, stop, last)
        found = self.bench[on["finding"]].findings if on["finding"] else self.bench.findings
        times = [each.time_ps for each in found if start <= each.time_ps <= stop]
        return None if not times else times[-1] if last else times[0]

    def _edge(self, name: str, edge: str, start: int, stop: int, last: bool) -> int | None:
        probe, recorder = self.probe(name), self.recorder
        wanted = {"rises": (1,), "falls": (0,), "any": (0, 1, -1)}[edge]
        first = max(start, recorder.since(probe))
        if not last:
            return next((time for time, level in recorder.each_edge(probe, first, stop) if level in wanted), None)
        width = max((stop - first) // 64, 1)
        while stop >= first:  # windows that grow backwards from the end: most triggers are near
            begin = max(stop - width, first)
            times, levels = recorder.edges(probe, begin, stop)
            fitting = [time for time, level in zip(times.tolist(), levels.tolist(), strict=True) if level in wanted]
            if fitting:
                return int(fitting[-1])
            stop, width = begin - 1, 2 * width
        return None

    def _level(self, name: str, level: Any, start: int, stop: int, last: bool) -> int | None:
        """Return the first or, if `last`, the last instant (ps) at which a pin has a level; None if there is none."""
        probe = self.probe(name)
        start = max(start, self.recorder.since(probe))
        if start > stop:
            return None
        at = stop if last else start
        if self.recorder.level(probe, at) == level:
            return at
        begun = self._edge(name, "rises" if level else "falls", start, stop, last)
        if not last:
            return begun
        if begun is None:  # the pin has the level at the start, or never
            begun = start if self.recorder.level(probe, start) == level else None
        ended = None if begun is None else self._edge(name, "any", begun + 1, stop, False)
        return None if ended is None else ended - 1

    def _crossing(self, name: str, value: Any, slope: str, start: int, stop: int, last: bool) -> int | None:
        times, values = self.bench.quantity(name).outline(max(start, self._kept(name)), stop, 4000)
        found = None
        for before, time, after in zip(values, times[1:], values[1:], strict=False):
            up, down = before < value <= after, before > value >= after
            if (up and slope != "falls") or (down and slope != "rises"):
                found = int(time)
                if not last:
                    break
        return found
