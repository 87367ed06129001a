"""Measurements on arrays of instants, for tests and plots of steps and edges.  All functions are pure.

Instants are int64 picoseconds, ascending.  A clock whose period is not a whole number of picoseconds
makes equal intervals differ by 1 ps, so intervals that differ by no more than 1 ps count as equal.
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
UNKNOWN = -2  # a level of a waveform file


def intervals(times_ps: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the time from each instant to the next: (n-1,) int64 ps.

    Raises:
        UsageError: the instants are not in ascending order.
    """
    import numpy as np

    between = np.diff(times_ps)
    if len(between) and between.min() <= 0:
        number = int(np.argmin(between)) + 1
        raise UsageError(f"instants must be in ascending order; number {number} is not later than its predecessor")
    return between


def rates(times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the rate from each step to the next: (n-1,) float64 steps/s.

    Raises:
        UsageError: the instants are not in ascending order.
    """
    return PS_PER_S / intervals(times_ps)


def runs(times_ps: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the runs of steps at a constant rate.

    Returns:
        Two arrays, (m,) int64: `first`, the index of the step with which each run begins, and `count`, the
            number of intervals in each run; run i spans the intervals that begin with steps first[i] to
            first[i] + count[i] - 1.

    Raises:
        UsageError: the instants are not in ascending order.
    """
    import numpy as np

    between = intervals(times_ps)
    if not len(between):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    first = np.append(0, np.flatnonzero(np.abs(np.diff(between)) > ROUNDING_PS) + 1)
    return first, np.diff(np.append(first, len(between)))


def pulses(times_ps: NDArray[np.int64], levels: Levels, level: int = 0) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the starts and ends, (m,) int64 ps each, of the pulses at `level` between the given edges.

    A pulse that begins or ends where the signal is unknown is left out, as its width is not known.
    """
    import numpy as np

    known = levels != UNKNOWN
    begins = np.flatnonzero((levels[:-1] == level) & known[1:] & np.append(True, known)[: max(len(levels) - 1, 0)])
    return times_ps[begins], times_ps[begins + 1]


def pulse_widths(times_ps: NDArray[np.int64], levels: Levels, level: int = 0) -> NDArray[np.int64]:
    """Return the width of each pulse at a level: (m,) int64 ps, for the pulses that `pulses` returns."""
    begins, ends = pulses(times_ps, levels, level)
    return ends - begins


def glitches(times_ps: NDArray[np.int64], shorter_than_ps: int) -> NDArray[np.intp]:
    """Return the indices, (m,), of the edges after which the next edge follows in less than `shorter_than_ps`."""
    import numpy as np

    return np.flatnonzero(np.diff(times_ps) < shorter_than_ps)


@dataclass(frozen=True, slots=True)
class MeasuredRamp:
    """The measured parts of a move from rest to rest; the plateau is the longest stretch at the highest rate."""

    up_ps: int  # from the first step to the first one of the plateau
    plateau_ps: int
    down_ps: int  # from the end of the plateau to the last step
    plateau_first: int  # index of the first step of the plateau
    plateau_steps: int
    peak_sps: float  # steps/s on the plateau


def ramp(times_ps: NDArray[np.int64], rounding_ps: int = ROUNDING_PS) -> MeasuredRamp:
    """Return the times at which a move reaches and leaves its highest rate, and this rate.

    Args:
        times_ps: the instants of the steps, (n,) int64 ps, ascending.
        rounding_ps: the unit to which the instants are rounded (for a measured recording, its
            `timescale_ps`); intervals at the same rate differ by up to this unit.

    Raises:
        UsageError: there are fewer than two steps, or the instants are not in ascending order.
    """
    import numpy as np

    between = intervals(times_ps)
    if not len(between):
        raise UsageError(f"a ramp needs at least two steps; found {len(times_ps)}")
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


@dataclass(frozen=True, slots=True)
class Jitter:
    """The unevenness of steps at a constant rate.

    Attributes:
        steps: the number of steps in the longest stretch at one rate, in which the jitter is measured.
        rate_sps: the rate of these steps, steps/s.
        rms_ps: the root mean square of the deviations of their instants from an even spacing, ps.
        greatest_ps: the greatest of these deviations, ps.
    """

    steps: int
    rate_sps: float
    rms_ps: float
    greatest_ps: float


STEADY = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3)  # the relative difference of intervals of one rate, tried in order
STRETCH = 12  # minimum number of intervals at that rate
LONGER = 1.5  # a stretch that grows by less with more tolerance is final


def jitter(times_ps: NDArray[np.int64], rounding_ps: int = ROUNDING_PS) -> Jitter | None:
    """Return the jitter of the longest stretch of steps at a constant rate; None if no stretch is long enough.

    Args:
        times_ps: the instants of the steps, (n,) int64 ps, ascending.
        rounding_ps: the unit to which the instants are rounded, as for `ramp`.

    Raises:
        UsageError: the instants are not in ascending order.
    """
    import numpy as np

    between = intervals(times_ps)
    if len(between) < STRETCH:
        return None
    ordered, (first, last) = np.sort(between), (0, 0)
    for part in STEADY:
        reach = np.maximum((part * ordered).astype(np.int64), 2 * rounding_ps)
        alike = np.searchsorted(ordered, ordered + reach, "right") - np.searchsorted(ordered, ordered - reach)
        most = int(np.argmax(alike))
        even = np.concatenate([[False], abs(between - ordered[most]) <= reach[most], [False]])
        bounds = np.flatnonzero(even[1:] != even[:-1]).reshape(-1, 2)
        begin, end = bounds[np.argmax(bounds[:, 1] - bounds[:, 0])].tolist()
        if last - first >= STRETCH and end - begin < LONGER * (last - first):
            break  # otherwise it was a piece of a stretch with more jitter
        first, last = begin, end
    if last - first < STRETCH:
        return None
    some = (times_ps[first : last + 1] - times_ps[first]).astype(np.float64)
    slope, offset = np.polyfit(np.arange(len(some)), some, 1)
    apart = some - (slope * np.arange(len(some)) + offset)
    return Jitter(len(some), PS_PER_S / float(slope), float(np.sqrt((apart**2).mean())), float(abs(apart).max()))


@dataclass(frozen=True, slots=True)
class Skew:
    """The delay between corresponding steps of two axes.

    Attributes:
        pairs: the number of pairs of corresponding steps.
        median_ps: the median delay of the second axis relative to the first, ps; negative if the second is
            earlier.
        greatest_ps: the greatest deviation of a delay from the median, ps.
    """

    pairs: int
    median_ps: int
    greatest_ps: int


def skew(first_ps: NDArray[np.int64], second_ps: NDArray[np.int64]) -> Skew | None:
    """Return the delay of a second axis's steps after the nearest steps of the first; None if none correspond.

    Two steps correspond if the time between them is at most a quarter of the shortest interval of either axis;
    an axis with fewer than two steps has no corresponding steps.
    """
    import numpy as np

    if len(first_ps) < 2 or len(second_ps) < 2:
        return None
    near = int(min(np.diff(first_ps).min(), np.diff(second_ps).min())) // 4
    after = np.clip(np.searchsorted(first_ps, second_ps), 1, len(first_ps) - 1)
    later, earlier = second_ps - first_ps[after - 1], second_ps - first_ps[after]
    apart = np.where(abs(later) <= abs(earlier), later, earlier)
    apart = apart[abs(apart) <= near]
    if not len(apart):
        return None
    median = int(np.median(apart))
    return Skew(len(apart), median, int(abs(apart - median).max()))
