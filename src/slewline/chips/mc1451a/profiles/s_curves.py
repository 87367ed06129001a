"""S-curves, cycle by cycle: pieces in which the displacement changes with constant jerk, added up exactly.

    displacement     3 . 4 . 5           a cycle within one phase of the curve belongs to the piece of that phase;
                   .           .         a cycle in which a phase ends is a piece by itself
               2 .               . 6
               .                   .
    ____ 1 . '                       ' . 7 ____

A curve is a law of a cycle train (cycle_train.py).
"""

from __future__ import annotations

from bisect import bisect_right
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

PLACES = 58  # binary places of an S-curve: of positions in 1/65536 step, and of times in cycles
HALF_WORD = 1 << 63


class JerkPiece(NamedTuple):
    """Cycles of an S-curve with constant jerk; `position` is the position at the start of the first one.

    From cycle to cycle position += speed, then speed += change, then change += jerk.  All four numbers have
    PLACES binary places.
    """

    cycle: int  # the first one
    phase: int
    position: int
    speed: int
    change: int
    jerk: int

    def covered(self, k: int) -> int:
        """Return the position when cycle k of the curve begins."""
        m = k - self.cycle
        pairs = m * (m - 1) // 2
        return self.position + m * self.speed + pairs * self.change + pairs * (m - 2) // 3 * self.jerk

    def displaced(self, k: int) -> int:
        """Return the displacement of cycle k of the curve."""
        m = k - self.cycle
        return self.speed + m * self.change + m * (m - 1) // 2 * self.jerk


class SCurve:
    """The cycles of an S-curve, starting with its cycle `first`; the last piece is the curve's end, at rest.

    Positions, at most 2^47, and velocities are each rounded down independently.  A piece with jerk has fewer
    than 2^21 cycles.
    """

    __slots__ = ("_tables", "cycles", "first", "pieces", "start")
    steady, even = 0, False

    def __init__(self, pieces: list[JerkPiece], first: int = 0) -> None:
        self.pieces, self.first = pieces, first
        self.cycles = [piece.cycle for piece in pieces]
        self._tables: tuple[Any, ...] | None = None
        self.start = self._piece(first).covered(first) >> PLACES

    def _piece(self, k: int) -> JerkPiece:
        """Return the piece that contains a cycle of the curve."""
        return self.pieces[bisect_right(self.cycles, k) - 1]

    def travel(self, i: int) -> int:
        """Return the distance covered before cycle i, in 1/65536 step, rounded down."""
        k = self.first + i
        return (self._piece(k).covered(k) >> PLACES) - self.start

    def velocity(self, i: int) -> int:
        """Return the velocity in cycle i, in 1/65536 step per cycle, rounded down."""
        k = self.first + i
        return self._piece(k).displaced(k) >> PLACES

    def phase(self, i: int) -> int:
        """Return the phase, 1 to 7, of cycle i."""
        return self._piece(self.first + i).phase

    def travels(self, i: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the distances covered before many cycles, in any order, in 1/65536 step: int64, shaped like `i`."""
        return self._sums(i, 0) - self.start

    def velocities(self, i: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the velocities in many cycles, in any order, in 1/65536 step per cycle: int64, in the shape of `i`."""
        return self._sums(i, 1)

    def phases(self, i: NDArray[np.int64]) -> NDArray[np.int8]:
        """Return the phases, 1 to 7, of many cycles in any order, in the shape of `i`."""
        import numpy as np

        which = np.searchsorted(self.cycles, i + self.first, side="right") - 1
        return np.array([piece.phase for piece in self.pieces], np.int8).take(which)

    def _sums(self, i: NDArray[np.int64], of: int) -> NDArray[np.int64]:
        """Return the positions (`of` 0) or displacements (`of` 1) of many cycles, in 1/65536 step.

        Each is computed twice: as a float, with an error below 1, and as an integer with PLACES binary places
        whose upper bits are lost, so that the integer is right modulo 64.
        """
        import numpy as np

        if self._tables is None:
            numbers = [*zip(*self.pieces, strict=True)]
            wrapped = [[(number + HALF_WORD) % (2 * HALF_WORD) - HALF_WORD for number in row] for row in numbers[2:]]
            floats = [[number / (1 << PLACES) for number in row] for row in numbers[2:]]
            self._tables = np.array(self.cycles, np.int64), np.array(wrapped, np.int64), np.array(floats)
        cycles, integers, floats = self._tables
        k = i + self.first
        which = np.searchsorted(cycles, k, side="right") - 1
        m = k - cycles.take(which)
        exact, about = integers[of].take(which), floats[of].take(which)
        for order in range(1, 4 - of):
            times = m if order == 1 else m * (m - 1) // 2 if order == 2 else m * (m - 1) * (m - 2) // 6
            exact += times * integers[of + order].take(which)
            about += times * floats[of + order].take(which)
        guess: NDArray[np.int64] = about.astype(np.int64)
        guess += (exact - (guess << PLACES)) >> PLACES
        return guess
