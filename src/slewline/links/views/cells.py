"""What a signal did in a long window, from cells of the past that are worked out once.

    window    |<------------------------------ an hour ------------------------------>|
    cells     |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   |   2^k ps each

The past does not change, so what a cell shows is kept: of a quantity a few points, of a pin a sign.  A cell is no wider
than a column of the picture, and its edges lie on a grid that is the same for every window: one that rolls along needs
only the newest of them.
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

NARROWEST = 33  # 2^33 ps are 8.6 ms: what is narrower is asked directly
KEPT = 40_000  # cells
SIGNS = {0: "0", 1: "1"}
UNKNOWN, BOTH = "-", "x"
C = TypeVar("C")
Points = tuple[list[int], list[float | None]]


def width_of(start: int, stop: int, columns: int) -> int:
    """Return the exponent of the width of the cells for a window; 0: it is too short for them."""
    exponent = ((stop - start) // columns).bit_length() - 1
    return exponent if exponent >= NARROWEST else 0


class Cells(Generic[C]):
    """Cells of all signals of a kind; the ones that were asked for longest ago are dropped."""

    def __init__(self) -> None:
        self.kept: OrderedDict[tuple[str, int, int], C] = OrderedDict()

    def between(
        self, name: str, start: int, stop: int, exponent: int, work: Callable[[int, int], C]
    ) -> Iterator[tuple[int, C]]:
        """Yield when each cell of a window begins (ps), and what it shows.

        Args:
            work: works a cell out, from its start to its end, both included.
        """
        step = 1 << exponent
        for number in range(start >> exponent, (stop >> exponent) + 1):
            begin, end = number * step, (number + 1) * step - 1
            key = name, exponent, number
            found = self.kept.get(key)
            if found is None:
                found = work(max(begin, 0), min(end, stop))
                if end < stop:  # what has not passed may change
                    self.kept[key] = found
                    if len(self.kept) > KEPT:
                        self.kept.popitem(last=False)
            else:
                self.kept.move_to_end(key)
            yield begin, found


def points(quantity: Quantity, start: int, stop: int) -> Points:
    """Return what a picture shows of a quantity in a column (ps); None is a break."""
    times, values = quantity.outline(start, stop, 1)
    return times.tolist(), [None if isnan(value) else value for value in values.tolist()]


def sign(recorder: Recorder, probe: Net | Terminal, start: int, stop: int, since: int) -> str:
    """Return the level of a pin in a column (ps), or that it has both."""
    first = max(start, since)
    if first > stop:
        return UNKNOWN
    if next(recorder.each_edge(probe, first + 1, stop), None) is not None:
        return BOTH
    return SIGNS.get(recorder.level(probe, first), UNKNOWN)
