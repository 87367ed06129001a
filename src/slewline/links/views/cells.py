"""Signals in a long window, composed of cells: short stretches of the past, each computed only once.

    window    |<------------------------------ an hour ------------------------------>|
    cells     |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   2^k ps each

The past does not change, so cells are cached: a cell is a few points of a quantity, or a character for a
pin.  A cell is at most as wide as a column of the picture, and cell edges are on a grid common to all
windows, so a rolling window needs only the newest cells.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator
from math import isnan
from typing import TYPE_CHECKING, Generic, TypeVar

if TYPE_CHECKING:
    from ...core.motion.quantity import Quantity
    from ...core.wires.net import Net
    from ...core.wires.pin import Terminal
    from ...record.recording.recorder import Recorder

NARROWEST = 33  # 2^33 ps are 8.6 ms: narrower cells are computed directly
KEPT = 40_000  # cells
SIGNS = {0: "0", 1: "1"}
UNKNOWN, BOTH = "-", "x"
C = TypeVar("C")
Points = tuple[list[int], list[float | None]]


def width_of(start: int, stop: int, columns: int) -> int:
    """Return the exponent k of the cell width, 2^k ps, for a window; 0 if the window is too short for cells."""
    exponent = ((stop - start) // columns).bit_length() - 1
    return exponent if exponent >= NARROWEST else 0


class Cells(Generic[C]):
    """Cells of all pins, or of all quantities; the least recently used cells are dropped."""

    def __init__(self) -> None:
        self.kept: OrderedDict[tuple[str, int, int], C] = OrderedDict()

    def between(
        self, name: str, start: int, stop: int, exponent: int, work: Callable[[int, int], C]
    ) -> Iterator[tuple[int, C]]:
        """Yield the start (ps) and the content of each cell of a window, for the signal `name`.

        Args:
            work: computes a cell between two instants, both included.
        """
        step = 1 << exponent
        for number in range(start >> exponent, (stop >> exponent) + 1):
            begin, end = number * step, (number + 1) * step - 1
            key = name, exponent, number
            found = self.kept.get(key)
            if found is None:
                found = work(max(begin, 0), min(end, stop))
                if end < stop:  # the future may change
                    self.kept[key] = found
                    if len(self.kept) > KEPT:
                        self.kept.popitem(last=False)
            else:
                self.kept.move_to_end(key)
            yield begin, found


def points(quantity: Quantity, start: int, stop: int) -> Points:
    """Return the points of a quantity between two instants (ps), as times and values; None marks a break."""
    times, values = quantity.outline(start, stop, 1)
    return times.tolist(), [None if isnan(value) else value for value in values.tolist()]


def sign(recorder: Recorder, probe: Net | Terminal, start: int, stop: int, since: int) -> str:
    """Return a character for a pin between two instants (ps): its level, "x" if it changes, or "-" if unknown."""
    first = max(start, since)
    if first > stop:
        return UNKNOWN
    if next(recorder.each_edge(probe, first + 1, stop), None) is not None:
        return BOTH
    return SIGNS.get(recorder.level(probe, first), UNKNOWN)
