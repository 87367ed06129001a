"""What a plot draws of steps and edges: a few thousand points, however many there are.  Pure functions.

A stretch of equal intervals is one line.  What is still too dense keeps, in each column of the picture, the points
that show: first, lowest, highest, last.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..core.axis import Steps
from ..core.timebase import PS_PER_S
from .measure import ROUNDING_PS, intervals

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .recorder import Levels

    Outline = tuple[NDArray[np.int64], NDArray[np.float64]]

COLUMNS = 900  # of a picture, about a pixel each
STRIPES = 300  # of a picture, as wide as a line and the gap beside it
DENSE = 2  # edges in a stripe, above which a trace is a band
STAIRS = 120  # steps that can still be told apart
PAUSE = 4  # so many times longer than both its neighbours: no step interval but a pause


def pauses(between: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which intervals are pauses between moves: (n,) bool."""
    import numpy as np

    out = np.zeros(len(between), np.bool_)
    if len(between) > 2:
        out[1:-1] = between[1:-1] > PAUSE * np.maximum(between[:-2], between[2:])
    return out


def velocity(steps: Steps, start: int, stop: int) -> Outline:
    """Velocity over time: instants (m,) int64 ps, and the steps/s from there to the next, negative for direction -1.

    The last step of a move has no interval of its own; it counts as long as the one before.  Steps beyond the window
    are welcome: they say what the velocity is at its edges.
    """
    import numpy as np

    times, signs = steps.times_ps, steps.directions.astype(np.float64)
    between = intervals(times)
    if not len(between):
        return np.array([start, stop]), np.zeros(2)
    ends = np.append(pauses(between), True)  # last steps of moves; no two in succession
    lasts = np.append(between, 0)
    lasts[1:][ends[1:]] = between[ends[1:]]
    speed = PS_PER_S * signs / lasts
    other = (np.abs(np.diff(lasts)) > ROUNDING_PS) | (signs[1:] != signs[:-1])
    changed = np.append(True, other | ends[:-1])
    stops = (times + lasts)[ends]
    at = np.concatenate([[min(start, times[0] - 1)], times[changed], stops])
    what = np.concatenate([[0.0], speed[changed], np.zeros(len(stops))])
    order = np.argsort(at, kind="stable")
    at, what = at[order], what[order]
    inside = at <= stop
    at, what = np.append(at[inside], stop), np.append(what[inside], what[inside][-1])
    return thinned(at, what, start, stop)


def position(steps: Steps, before: int, start: int, stop: int) -> Outline:
    """Position over time: corners (m,) of a line that is a staircase where steps are few, and straight in each run.

    `before` is the position before the first step.
    """
    import numpy as np

    times, after = steps.times_ps, steps.positions
    came_from = np.append(before, after[:-1])
    if len(times) <= STAIRS:
        jump = corner = np.ones(len(times), np.bool_)
    else:
        between, rise = intervals(times), after - came_from
        # level up to a step: after a pause, and where the position was set rather than reached
        jump = np.append(True, pauses(between)) | (np.abs(rise) != 1)
        corner = jump | np.append(jump[1:], True)
        corner[1:-1] |= (np.abs(np.diff(between)) > ROUNDING_PS) | (rise[1:-1] != rise[2:])
    chosen = np.flatnonzero(corner)
    points = np.repeat(chosen, 1 + jump[chosen])
    foot = jump[points] & np.append(True, points[1:] != points[:-1])[: len(points)]  # the first of a pair
    what = np.where(foot, came_from[points], after[points])
    at = np.concatenate([[start], times[points], [stop]])
    return thinned(
        at, np.concatenate([[before], what, after[-1:] if len(after) else [before]]).astype(np.float64), start, stop
    )


def logic(
    times: NDArray[np.int64], levels: Levels, level: int, start: int, stop: int
) -> tuple[Outline, NDArray[np.int64]]:
    """A trace: the line where single edges can be told apart, and bands where they cannot.

    Args:
        times, levels: edges, (n,).
        level: before the first edge.
        start, stop: the window, ps.

    Returns:
        Instants (m,) int64 and levels (m,) float64 from there to the next, NaN inside a band; the bands, (k, 2) int64.
    """
    import numpy as np

    stripe = _columns(times, start, stop, STRIPES)
    dense = np.bincount(stripe, minlength=STRIPES)[stripe] > DENSE
    apart = np.append(True, (np.diff(stripe) > 1) | (dense[1:] != dense[:-1]))[: len(times)]
    first = dense & apart
    last = dense & np.append(apart[1:], True)[: len(times)]
    what = np.where(first, np.nan, levels)
    shown = ~dense | first | last
    at = np.concatenate([[start], times[shown], [stop]])
    after = np.concatenate([[level], what[shown], [levels[-1] if len(levels) else level]])
    return (at, after), np.stack([times[first], times[last]], axis=1)


def thinned(at: NDArray[np.int64], what: NDArray[np.float64], start: int, stop: int) -> Outline:
    """Points that look the same in a picture of the window: in each column the first, lowest, highest and last one."""
    import numpy as np

    if len(at) <= 4 * COLUMNS:
        return at, what
    column = _columns(at, start, stop, COLUMNS)
    last = np.flatnonzero(np.append(column[1:] != column[:-1], True))
    first = np.append(0, last[:-1] + 1)
    by_height = np.lexsort((what, column))
    kept = np.unique(np.concatenate([first, last, by_height[first], by_height[last]]))
    return at[kept], what[kept]


def _columns(times: NDArray[np.int64], start: int, stop: int, columns: int) -> NDArray[np.int64]:
    """In which column of a picture each instant lies: (n,) int64, 0 to columns - 1."""
    import numpy as np

    return np.clip(((times - start) * (columns / max(stop - start, 1))).astype(np.int64), 0, columns - 1)
