"""S-curves, cycle by cycle: pieces of constant jerk, in which the displacements are summed exactly.

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
    """Successive cycles of an S-curve, with constant jerk; `position` is where the first of them begins.

    From cycle to cycle position += speed, then speed += change, then change += jerk.  These four numbers are
    in 1/65536 step, with PLACES binary places.
    """

    cycle: int  # the first one
    phase: int
    position: int
    speed: int
    change: int
    jerk: int

    def covered(self, k: int) -> int:
        """Return the position at the start of cycle k of the curve, with PLACES binary places."""
        m = k - self.cycle
        pairs = m * (m - 1) // 2
        return self.position + m * self.speed + pairs * self.change + pairs * (m - 2) // 3 * self.jerk

    def displaced(self, k: int) -> int:
        """Return the displacement in cycle k of the curve, with PLACES binary places."""
        m = k - self.cycle
        return self.speed + m * self.change + m * (m - 1) // 2 * self.jerk


class SCurve:
    """An S-curve from its cycle `first` on; its last piece is the state of rest after its end.

    Positions (at most 2^47) and velocities are rounded down independently of each other.  A piece with jerk
    has fewer than 2^21 cycles.
    """

    __slots__ = ("_tables", "cycles", "first", "pieces", "start")
    steady, even = 0, False

    def __init__(self, pieces: list[JerkPiece], first: int = 0) -> None:
        self.pieces, self.first = pieces, first
        self.cycles = [piece.cycle for piece in pieces]
        self._tables: tuple[Any, ...] | None = None
        self.start = self._piece(first).covered(first) >> PLACES

    def _piece(self, k: int) -> JerkPiece:
        """Return the piece that contains cycle k of the curve."""
        return self.pieces[bisect_right(self.cycles, k) - 1]

    def travel(self, i: int) -> int:
        """Return the distance covered in i cycles from `first` on, in 1/65536 step.

        It is the difference of two positions, each rounded down.
        """
        k = self.first + i
        return (self._piece(k).covered(k) >> PLACES) - self.start

    def velocity(self, i: int) -> int:
        """Return the velocity in cycle i, counted from `first`, in 1/65536 step per cycle, rounded down."""
        k = self.first + i
        return self._piece(k).displaced(k) >> PLACES

    def phase(self, i: int) -> int:
        """Return the phase, 1 to 7, of cycle i, counted from `first`."""
        return self._piece(self.first + i).phase

    def travels(self, i: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return `travel` for many cycles, in any order, in 1/65536 step: int64, in the shape of `i`."""
        return self._sums(i, 0) - self.start

    def velocities(self, i: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return `velocity` for many cycles, in any order, in 1/65536 step per cycle: int64, in the shape of `i`."""
        return self._sums(i, 1)

    def phases(self, i: NDArray[np.int64]) -> NDArray[np.int8]:
        """Return `phase` for many cycles, in any order: 1 to 7, in the shape of `i`."""
        import numpy as np

        which = np.searchsorted(self.cycles, i + self.first, side="right") - 1
        return np.array([piece.phase for piece in self.pieces], np.int8).take(which)

    def _sums(self, i: NDArray[np.int64], of: int) -> NDArray[np.int64]:
        """Return the positions (`of` 0) or displacements (`of` 1) of many cycles, in 1/65536 step, rounded down.

        Each is computed twice: as a float, with an error below 1, and as an integer with PLACES binary places
        whose upper bits are lost, so that it is right modulo 64.  The result is exact, as it combines the two.
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
