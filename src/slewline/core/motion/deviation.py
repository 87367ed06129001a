"""The deviation of an axis from its ideal motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from .axis import Axis
from .ideal_motion import Ideal

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class Deviation(NamedTuple):
    """The greatest deviations, in magnitude, of a motion from its ideal.

    Each is the actual value minus the ideal value, clockwise positive.

    Attributes:
        position: the greatest deviation of the position, in steps.
        position_ps: the instant of that deviation, ps.
        velocity: the greatest deviation of the velocity, in steps/s.
        velocity_ps: the instant of that deviation, ps.
    """

    position: float
    position_ps: int
    velocity: float
    velocity_ps: int


def deviation(axis: Axis, ideal: Ideal) -> Deviation:
    """Return the greatest deviations, in magnitude, of an axis from an ideal.

    The time compared is from the ideal's start to its stop, or to now if that is earlier.
    """
    import numpy as np

    start, stop = ideal.start, min(ideal.stop, axis.kernel.seen)
    bends = ideal.bends[ideal.bends <= stop]

    def worst(changes: NDArray[np.int64], of: Callable[[NDArray[np.int64]], NDArray[np.float64]]) -> tuple[float, int]:
        """Return the difference (actual minus ideal) that is greatest in magnitude, and its instant (ps).

        `changes` are the instants at which the actual value changes; `of` returns the differences at given
        instants.  Between changes of the actual value and bends of the ideal, both values are monotonic.  So the
        greatest difference is at a change or a bend, or just before it.
        """
        at = np.unique(np.concatenate([changes, changes - 1, bends, bends - 1, [start, stop]]))
        at = at[(at >= start) & (at <= stop)]
        differ = of(at)
        most = int(np.argmax(np.abs(differ)))
        return float(differ[most]), int(at[most])

    def positions(at: NDArray[np.int64]) -> NDArray[np.float64]:
        real, law = axis.low + axis.unwrapped_at(at), ideal.positions(at)
        turns = np.rint((real[0] - law[0]) / axis.modulus)
        return np.asarray(real - turns * axis.modulus - law, np.float64)

    def velocities(at: NDArray[np.int64]) -> NDArray[np.float64]:
        in_progress = at < ideal.stop + ideal.interrupted  # the last step may outlast the ideal
        return np.where(in_progress, axis.velocities_at(at) - ideal.velocities(at), 0.0)

    return Deviation(*worst(axis.times(start, stop), positions), *worst(axis.velocities(start, stop)[0], velocities))
