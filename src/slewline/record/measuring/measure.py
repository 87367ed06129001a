"""Measurements on arrays of instants: what tests and plots ask of steps and edges.  Pure functions.

Instants are int64 picoseconds, ascending.  A clock whose period is no whole number of picoseconds makes equal
intervals differ by one, so "the same interval" means: the same to a picosecond.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...core.time.timebase import PS_PER_S
from ...errors import UsageError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..recording.recorder import Levels

ROUNDING_PS = 1


def intervals(times_ps: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the time from each instant to the next: (n-1,) int64 ps.

    Raises:
        UsageError: the instants do not ascend.
    """
    import numpy as np

    between = np.diff(times_ps)
    if len(between) and between.min() <= 0:
        raise UsageError(f"instants must ascend; number {int(np.argmin(between)) + 1} is not after the one before")
    return between


def rates(times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the rate from each step to the next: (n-1,) float64 steps/s.

    Raises:
        UsageError: the instants do not ascend.
    """
    return PS_PER_S / intervals(times_ps)


def runs(times_ps: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the runs of steps at a constant rate.

    Returns:
        The step with which each run begins (m,) int64, and its intervals (m,) int64: run i spans the intervals of steps
            first[i] to first[i] + count[i] - 1.

    Raises:
        UsageError: the instants do not ascend.
    """
    import numpy as np

    between = intervals(times_ps)
    if not len(between):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    first = np.append(0, np.flatnonzero(np.abs(np.diff(between)) > ROUNDING_PS) + 1)
    return first, np.diff(np.append(first, len(between)))


def pulse_widths(times_ps: NDArray[np.int64], levels: Levels, level: int = 0) -> NDArray[np.int64]:
    """Return the width of each pulse at a level: (m,) int64 ps; pulses that begin and end within the edges given."""
    import numpy as np

    begins = np.flatnonzero(levels[:-1] == level)
    return times_ps[begins + 1] - times_ps[begins]


def glitches(times_ps: NDArray[np.int64], shorter_than_ps: int) -> NDArray[np.intp]:
    """Return the edges that are too close before the next one: indices (m,)."""
    import numpy as np

    return np.flatnonzero(np.diff(times_ps) < shorter_than_ps)


@dataclass(frozen=True, slots=True)
class MeasuredRamp:
    """A move from rest to rest.  The plateau is the longest stretch at the highest rate."""

    up_ps: int  # from the first step to the first one of the plateau
    plateau_ps: int
    down_ps: int  # from the end of the plateau to the last step
    plateau_first: int  # index of the first step of the plateau
    plateau_steps: int
    peak_sps: float  # steps/s on the plateau


def ramp(times_ps: NDArray[np.int64], rounding_ps: int = ROUNDING_PS) -> MeasuredRamp:
    """Return where a move reaches its highest rate, and for how long.

    Args:
        times_ps: instants of the steps, (n,) int64 ps, ascending.
        rounding_ps: what the instants are rounded to: of a measured recording what its times are multiples of
            (`timescale_ps`); intervals of one rate differ by so much.

    Raises:
        UsageError: fewer than two steps, or instants that do not ascend.
    """
    import numpy as np

    between = intervals(times_ps)
    if not len(between):
        raise UsageError(f"a ramp has two steps or more, not {len(times_ps)}")
    fast = np.concatenate([[False], between <= between.min() + rounding_ps, [False]])
    bounds = np.flatnonzero(fast[1:] != fast[:-1]).reshape(-1, 2)
    begin, end = bounds[np.argmax(bounds[:, 1] - bounds[:, 0])].tolist()
    plateau = int(times_ps[end] - times_ps[begin])
    return MeasuredRamp(
        up_ps=int(times_ps[begin] - times_ps[0]),
        plateau_ps=plateau,
        down_ps=int(times_ps[-1] - times_ps[end]),
        plateau_first=begin,
        plateau_steps=end - begin,
        peak_sps=PS_PER_S * (end - begin) / plateau,
    )
