"""The values of all quantities and pins of a picture at its cursors, as a table."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ...core.motion.quantity import Quantity
from ...core.notebook.markup import card, table
from ...core.time.timebase import readable
from ..recording.recorder import FLOATING, Probe, Recorder, width_of
from ..recording.traces import Trace
from ..style import aligned, duration, number

Value = float | int | None


@dataclass(frozen=True, slots=True)
class TraceReading:
    """The values of a pin, a bus or a quantity at some instants.

    Attributes:
        name: the name of the pin, the bus or the quantity.
        unit: the unit of the quantity; "" for a pin or a bus.
        values: the value at each instant; None where the pin or bus floats, or the quantity has no value.
        bits: 1 for a pin, 8 for a bus, 0 for a quantity.
    """

    name: str
    unit: str
    values: tuple[Value, ...]
    bits: int = 0

    @property
    def differences(self) -> tuple[Value, ...]:
        """The change of a quantity from each instant to the next; None for a pin, a bus, or a missing value."""
        pairs = zip(self.values, self.values[1:], strict=False)
        return tuple(None if self.bits or a is None or b is None else b - a for a, b in pairs)


@dataclass(frozen=True, slots=True)
class Readings:
    """The values of quantities and pins at some instants; `print` shows them as a table.

    Attributes:
        instants_ps: the instants, ps.
        rows: a `TraceReading` for each quantity and each pin.
    """

    instants_ps: tuple[int, ...]
    rows: tuple[TraceReading, ...]

    def __repr__(self) -> str:
        return f"<Readings: {len(self.rows)} rows at {', '.join(map(readable, self.instants_ps))}>"

    def _repr_html_(self) -> str:
        """Return the notebook view of the values: a table."""
        head, *lines = self._lines()
        return card(repr(self)[1:-1], table(head, lines, right=range(1, len(head))))

    def __str__(self) -> str:
        return "\n".join(aligned([*self._lines()], left=(0,)))

    def _lines(self) -> Iterator[list[str]]:
        count = len(self.instants_ps)
        yield ["", *(str(n) for n in range(1, count + 1)), *(f"{n + 1} − {n}" for n in range(1, count))]
        apart = [b - a for a, b in zip(self.instants_ps, self.instants_ps[1:], strict=False)]
        yield ["time", *map(duration, self.instants_ps), *map(duration, apart)]
        for row in self.rows:
            name = f"{row.name}, {row.unit}" if row.unit else row.name
            differences = [_text_of(value, row.bits) if value is not None else "" for value in row.differences]
            yield [name, *(_text_of(value, row.bits) for value in row.values), *differences]


def _text_of(value: Value, bits: int) -> str:
    if value is None:
        return "floating" if bits else "–"
    return f"0x{value:02X}" if bits > 1 else number(round(value, 3))


def readings(
    instants: Sequence[int],
    tracks: Sequence[tuple[str, Sequence[Quantity]]],
    probes: Sequence[tuple[str, Probe, Recorder]],
) -> Readings:
    """Return the values of quantities and recorded pins at some instants (ps), after any edges at each instant."""
    import numpy as np

    at = np.array(instants, np.int64)
    rows: list[TraceReading] = []
    for name, quantities in tracks:
        for quantity in quantities:
            whose = f"{quantity.name} of {name}" if len(tracks) > 1 else quantity.name
            values = tuple(None if value != value else value for value in quantity.at(at).tolist())
            rows.append(TraceReading(whose, quantity.unit, values))
    for name, probe, recorder in probes:
        levels = (recorder.level(probe, instant) for instant in instants)
        rows.append(TraceReading(name, "", tuple(None if v == FLOATING else v for v in levels), width_of(probe)))
    return Readings(tuple(instants), tuple(rows))


def measured(name: str, trace: Trace, instants: Sequence[int]) -> TraceReading:
    """Return the measured levels of a pin at some instants (ps); None where the pin floats or is unknown."""
    levels = trace.levels_at(instants)
    values = tuple(None if level == FLOATING else level for level in levels)
    return TraceReading(f"{name} measured", "", values, 8 if trace.bus else 1)
