r"""The ideal of a motion: its profile in continuous time, without rounding to steps, clocks or cycles.

velocity   ______
          /|    |\        pieces in which the jerk is constant: a trapezoid has three, an S-curve seven, a rate table
        _/ |    | \_      one between consecutive entries
  piece 0  | 1  |  2
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

from ..time.timebase import PS_PER_S, readable

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class IdealPiece(NamedTuple):
    """A period of constant jerk: its duration, its velocity and acceleration at the start, and its jerk.

    The units are seconds and steps.  The position continues from the previous piece; the velocity may jump.
    """

    seconds: float
    velocity: float
    acceleration: float = 0.0
    jerk: float = 0.0


class Ideal:
    """An ideal motion: continuous in time, without rounding to steps; at rest before `start` and after `stop`.

    Args:
        start: when the motion begins, ps.
        position: the position at `start`, in steps, clockwise positive, without wrap-around.
        pieces: pieces of constant jerk, at least one, in chronological order.
        sign: the direction of positive velocities in `pieces`: 1 clockwise, -1 counter-clockwise.

    Attributes:
        start: when the motion begins, ps.
        stop: the instant at which the ideal ends, ps.
        interrupted: True if the motion ceased to follow the ideal at `stop`, before the end of the last
            piece.
    """

    def __init__(self, start: int, position: float, pieces: Iterable[IdealPiece], sign: int = 1) -> None:
        import numpy as np

        self.start = start
        table = np.array([*pieces], np.float64).reshape(-1, 4)
        self._lasts = table[:, 0]
        self._begins = np.append(0.0, np.cumsum(self._lasts))  # seconds since start
        v, a, j = sign * table[:, 1:].T
        t = self._lasts
        self._v, self._a, self._j = v, a, j
        self._x = position + np.append(0.0, np.cumsum(((j * t / 6 + a / 2) * t + v) * t))
        self.stop = start + round(float(self._begins[-1]) * PS_PER_S)
        self.interrupted = False  # the motion left the ideal at `stop`

    def __repr__(self) -> str:
        return f"<Ideal: {readable(self.start)} to {readable(self.stop)}, {self._x[-1] - self._x[0]:+.0f} steps>"

    def until(self, stop: int) -> Ideal:
        """Return a copy cut off at `stop` (ps), marked as interrupted; this ideal itself if it ends by then."""
        if stop >= self.stop:
            return self
        cut: Ideal = object.__new__(type(self))
        cut.__dict__.update(self.__dict__)
        cut.stop, cut.interrupted = max(stop, self.start), True
        return cut

    @property
    def bends(self) -> NDArray[np.int64]:
        """The instants at which acceleration or jerk may change, from `start` to `stop`: (m,) int64 ps, ascending."""
        import numpy as np

        at = self.start + np.rint(self._begins * PS_PER_S).astype(np.int64)
        return np.append(at[at < self.stop], self.stop)

    def _pieces(self, times_ps: NDArray[np.int64]) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """Return the index of the piece at each instant, and the time since the start of that piece, in seconds."""
        import numpy as np

        seconds = (np.clip(np.asarray(times_ps, np.int64), self.start, self.stop) - self.start) / PS_PER_S
        which = np.searchsorted(self._begins[:-1], seconds, side="right") - 1
        which = np.clip(which, 0, len(self._lasts) - 1)
        return which, np.minimum(seconds - self._begins[which], self._lasts[which])

    def positions(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the positions at instants (int64 ps, in any order), in steps: float64, same shape as `times_ps`."""
        import numpy as np

        which, t = self._pieces(times_ps)
        bent = (self._j[which] * t / 6 + self._a[which] / 2) * t
        return np.asarray(self._x[which] + (bent + self._v[which]) * t, np.float64)

    def velocities(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the velocities (steps/s) at instants (int64 ps, in any order): float64, same shape as `times_ps`.

        Before and after the motion, the velocity is 0.
        """
        import numpy as np

        times = np.asarray(times_ps, np.int64)
        which, t = self._pieces(times)
        moving = (times >= self.start) & (times < self.stop + self.interrupted)
        return np.asarray(
            np.where(moving, (self._j[which] * t / 2 + self._a[which]) * t + self._v[which], 0.0), np.float64
        )


# --------------------------------------------------------------------------------------------------- pieces of a motion
FOREVER = 4e6  # seconds: longer than any run


def duration(velocity: float, distance: float) -> float:
    """Return the time in seconds that it takes to cover a distance at a velocity.

    If the velocity is 0, the time is FOREVER, unless the distance is also 0: then the time is 0.
    """
    return distance / velocity if velocity > 0 else 0.0 if not distance else FOREVER


def travelled(pieces: Iterable[IdealPiece]) -> float:
    """Return the total distance of the pieces, in steps."""
    return sum(((j * t / 6 + a / 2) * t + v) * t for t, v, a, j in pieces)


def mirrored(pieces: Sequence[IdealPiece]) -> list[IdealPiece]:
    """Return the pieces reversed in time: those of an acceleration become those of the mirrored deceleration."""
    return [IdealPiece(t, (j * t / 2 + a) * t + v, -(a + j * t), j) for t, v, a, j in reversed(pieces)]


def head(pieces: Iterable[IdealPiece], distance: float) -> list[IdealPiece]:
    """Return the pieces that cover the first `distance` steps; the last of them is shortened if necessary.

    The pieces must have no jerk and must not decelerate.
    """
    found = []
    for piece in pieces:
        covered = travelled([piece])
        if covered >= distance:
            _, v, a, _ = piece
            root = sqrt(v * v + 2 * a * distance)
            found.append(piece._replace(seconds=2 * distance / (v + root) if distance > 0 else 0.0))
            break
        found.append(piece)
        distance -= covered
    return found


def there_and_down(up: Sequence[IdealPiece], top: float, distance: float) -> list[IdealPiece]:
    """Return the acceleration `up`, a piece at the velocity `top` (steps/s), and the mirrored deceleration.

    Together they cover `distance`, in steps; if that is too short to reach `top`, the acceleration ends
    after half the distance.
    """
    rest = distance - 2 * travelled(up)
    if rest < 0:
        up, rest = head(up, distance / 2), 0.0
    return [*up, IdealPiece(duration(top, rest), top), *mirrored(up)]
