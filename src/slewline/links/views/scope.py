"""What signals did in a window, thinned to the columns of a picture: an hour is as light as a second.

A pin with few edges is sent edge by edge; one with many as a character a column, of which each costs one question to
the log, however many edges the column has:

    edges     _|‾|_|‾|_|‾|_|‾‾‾‾‾‾‾‾‾‾|___________
    columns   x    x    x    1    1    0    0
"""

from __future__ import annotations

from bisect import bisect_right
from math import isnan
from typing import TYPE_CHECKING, Any

from ...core.motion.quantity import column_edges
from ...errors import NotRecorded, UsageError
from ...record.recording.recorder import Recorder

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ...bench import Bench
    from ...core.chip import Chip
    from ...core.motion.quantity import Quantity
    from ...core.wires.net import Net
    from ...core.wires.pin import Terminal
    from ...parts.base.part import Part

    Probe = Net | Terminal

FEW = 2  # edges a column, up to which each is sent
SIGNS = {0: "0", 1: "1"}
UNKNOWN, BOTH = "-", "x"


def pin_window(recorder: Recorder, probe: Probe, start: int, stop: int, columns: int) -> dict[str, Any]:
    """Return what a recorded pin did in a window (ps): its edges, or a character a column."""
    since = recorder.since(probe)
    first = max(start, since)
    if first > stop:
        return {"kind": "pin", "since_ps": since, "columns": UNKNOWN * columns}
    times, levels = [first], [recorder.level_at(probe, first)]
    for time, level in recorder.each_edge(probe, first + 1, stop):
        times.append(time)
        levels.append(level)
        if len(times) > FEW * columns:
            return {"kind": "pin", "since_ps": since, "columns": drawn(recorder, probe, start, stop, columns, since)}
    return {"kind": "pin", "since_ps": since, "times_ps": times, "levels": [plain(level) for level in levels]}


def plain(level: int) -> int | None:
    """Return a level as a client gets it: None where nothing drives."""
    return None if level < 0 else level


def drawn(recorder: Recorder, probe: Probe, start: int, stop: int, columns: int, since: int) -> str:
    """Return a character a column."""
    edges = [*column_edges(start, stop, columns), stop]
    signs = [UNKNOWN] * columns
    column = max(bisect_right(edges, since) - 1, 0)
    while column < columns:
        begin = max(edges[column], since)
        level = recorder.level_at(probe, begin)
        following = next(recorder.each_edge(probe, begin + 1, stop), None)
        sign = SIGNS.get(level, UNKNOWN)
        if following is None:
            signs[column:] = [sign] * (columns - column)
            break
        busy = min(max(bisect_right(edges, following[0]) - 1, column), columns - 1)
        signs[column:busy] = [sign] * (busy - column)
        signs[busy] = BOTH
        column = busy + 1
    return "".join(signs)


def quantity_window(quantity: Quantity, start: int, stop: int, columns: int) -> dict[str, Any]:
    """Return what a quantity did in a window (ps): a few points a column."""
    times, values = quantity.outline(start, stop, columns)
    return {
        "kind": "quantity",
        "unit": quantity.unit,
        "held": quantity.held,
        "times_ps": times.tolist(),
        "values": [None if isnan(value) else value for value in values.tolist()],
    }


class Scope:
    """Answers what signals of a bench did."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.recorder = bench, Recorder()

    def signals(self) -> dict[str, Any]:
        """Return what can be shown: pins by owner, and quantities."""
        bench = self.bench
        owners: list[Chip | Part] = [*bench.chips.values(), *bench.parts.values()]
        pins = {
            owner.name: [name for name, pin in owner.pins.items() if pin.row.way in ("in", "out", "both")]
            for owner in owners
        }
        return {"pins": {name: found for name, found in pins.items() if found}, "quantities": [*self.quantities()]}

    def quantities(self) -> Mapping[str, Quantity]:
        """Return the quantities of axes and parts, by full name."""
        return self.bench.quantities()

    def window(self, names: list[str], start: int, stop: int, columns: int) -> dict[str, Any]:
        """Return what each signal did; one that cannot be shown there has an `error` instead."""
        found, known = {}, self.quantities()
        for name in names:
            try:
                found[name] = self._window(name, known, start, stop, columns)
            except NotRecorded as error:
                found[name] = {"kind": "quantity" if name in known else "pin", "error": str(error)}
        return found

    def _window(self, name: str, known: Mapping[str, Quantity], start: int, stop: int, columns: int) -> dict[str, Any]:
        if name in known:
            return quantity_window(self.bench.quantity(name), max(start, self._kept(name)), stop, columns)
        return pin_window(self.recorder, self.probe(name), start, stop, columns)

    def probe(self, name: str) -> Probe:
        """Return a recorded pin by its full name.

        Raises:
            UnknownName: no such pin.
            NotRecorded: it is not recorded.
        """
        if name not in self.bench.recorded:
            self.bench.pin(name)
            raise NotRecorded(f"{name} is not recorded; `record` keeps what it does from then on")
        return self.bench.recorded[name]

    def _kept(self, name: str) -> int:
        """The instant from which on an axis is kept (ps); 0 of a part."""
        owner, _, rest = name.partition(".")
        if owner not in self.bench.chips:
            return 0
        number = int(rest.partition(".")[0].removeprefix("axis")) if rest.startswith("axis") else 1
        return self.bench.chips[owner].axis(number).motor.since

    def find(self, on: Mapping[str, Any], start: int, stop: int, last: bool) -> int | None:
        """Return the first, or the last, instant (ps) at which something happens in a window; None: it does not.

        Raises:
            UsageError: not a pin and its edge, nor a quantity, a value and its slope, nor a finding.
            NotRecorded: the pin is not recorded.
        """
        if "pin" in on:
            return self._edge(on["pin"], on.get("edge", "any"), start, stop, last)
        if "quantity" in on and "value" in on:
            return self._crossing(on["quantity"], on["value"], on.get("slope", "any"), start, stop, last)
        if "finding" in on:
            found = self.bench[on["finding"]].findings if on["finding"] else self.bench.findings
            times = [each.time_ps for each in found if start <= each.time_ps <= stop]
            return None if not times else times[-1] if last else times[0]
        raise UsageError(f"find on {dict(on)!r}; allowed pin and edge; quantity, value and slope; finding")

    def _edge(self, name: str, edge: str, start: int, stop: int, last: bool) -> int | None:
        probe, recorder = self.probe(name), self.recorder
        wanted = {"rises": (1,), "falls": (0,), "any": (0, 1, -1)}.get(edge)
        if wanted is None:
            raise UsageError(f"edge {edge!r}; allowed rises, falls, any")
        first = max(start, recorder.since(probe))
        if not last:
            return next((time for time, level in recorder.each_edge(probe, first, stop) if level in wanted), None)
        width = max((stop - first) // 64, 1)
        while stop >= first:  # windows that grow, from the end on: most triggers are near
            begin = max(stop - width, first)
            times, levels = recorder.edges(probe, begin, stop)
            fitting = [time for time, level in zip(times.tolist(), levels.tolist(), strict=True) if level in wanted]
            if fitting:
                return int(fitting[-1])
            stop, width = begin - 1, 2 * width
        return None

    def _crossing(self, name: str, value: Any, slope: str, start: int, stop: int, last: bool) -> int | None:
        if not isinstance(value, int | float) or slope not in ("rises", "falls", "any"):
            raise UsageError(f"find {name}: value {value!r}, slope {slope!r}; allowed a number; rises, falls, any")
        times, values = self.bench.quantity(name).outline(max(start, self._kept(name)), stop, 4000)
        found = None
        for before, time, after in zip(values, times[1:], values[1:], strict=False):
            up, down = before < value <= after, before > value >= after
            if (up and slope != "falls") or (down and slope != "rises"):
                found = int(time)
                if not last:
                    break
        return found
