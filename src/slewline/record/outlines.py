"""What a picture draws of a pin: lines where edges can be told apart, bands where they cannot.

An hour of PULSE has 70 million edges, of which a picture shows a few hundred: promises are asked for the first ones in
each column of the picture, and expanded nowhere but at the end of a band.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import TYPE_CHECKING, Any

from ..core.quantity import column_edges

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .recorder import Edges, Levels, Probe, Recorder

    Outline = tuple[NDArray[np.int64], NDArray[np.float64]]

STRIPES = 300  # of a picture, as wide as a line and the gap beside it
DENSE = 2  # edges in a stripe, above which a trace is a band


def edges(recorder: Recorder, probe: Probe, start: int, stop: int) -> Edges:
    """Return edges at start < t <= stop (ps), as far as they are recorded, of which `logic` makes the same as of all:
    of a stripe with more than DENSE edges the first ones, and where a band ends the last one.

    Raises:
        NotRecorded, TimeError: as `Recorder.edges`.
    """
    import numpy as np

    begins = column_edges(start, stop, STRIPES)
    cut: set[int] = set()  # stripes of which edges are left out

    def first_ones(promise: Any, after: int, end: int) -> tuple[list[int], list[Any]]:
        times: list[int] = []
        levels: list[Any] = []
        before = promise.level(after)
        time = promise.after(after)
        while time is not None and time <= end:
            stripe = bisect_right(begins, time) - 1
            last = min(begins[stripe + 1] - 1, end) if stripe + 1 < STRIPES else end
            enough, at_last = len(times) + DENSE + 1, promise.level(last)
            while time is not None and time <= last:
                level = promise.level(time)
                if level != before:
                    times.append(time)
                    levels.append(level)
                    before = level
                if len(times) >= enough and level == at_last:  # what follows finds the level that it changes
                    cut.add(stripe)
                    time = last
                time = promise.after(time)
        return times, levels

    times, levels = recorder.edges(probe, max(start, recorder.since(probe)) + 1, stop, first_ones)
    dense = np.bincount(np.searchsorted(begins, times, side="right") - 1, minlength=STRIPES) > DENSE
    ends = [stripe for stripe in sorted(cut) if stripe + 1 == STRIPES or not dense[stripe + 1]]
    for stripe in ends:
        first, second = times[np.searchsorted(times, begins[stripe]) :][:2].tolist()
        over = begins[stripe + 1] if stripe + 1 < STRIPES else stop + 1
        time, level = _last_edge(recorder, probe, first, over - 1, second - first)
        at = np.searchsorted(times, time)
        if at == len(times) or times[at] != time:
            times, levels = np.insert(times, at, time), np.insert(levels, at, level)  # type: ignore[assignment]
    return times, levels


def _last_edge(recorder: Recorder, probe: Probe, start: int, stop: int, width: int) -> tuple[int, int]:
    """The last edge of a window, which has one; it is looked for so far before the end, then farther."""
    times, levels = recorder.edges(probe, max(start, stop - width), stop)
    while not len(times):
        width *= 4
        times, levels = recorder.edges(probe, max(start, stop - width), stop)
    return int(times[-1]), int(levels[-1])


def logic(
    times: NDArray[np.int64],
    levels: Levels,
    level: int,
    start: int,
    stop: int,
    since: int | None = None,
    until: int | None = None,
) -> tuple[Outline, NDArray[np.int64]]:
    """A trace: the line where single edges can be told apart, and bands where they cannot.

    Args:
        times, levels: edges, (n,).
        level: before the first edge.
        start, stop: the window, ps.
        since, until: what is known of the trace, if not all of the window; nothing is drawn outside.

    Returns:
        Instants (m,) int64 and levels (m,) float64 from there to the next, NaN inside a band; the bands, (k, 2) int64.
    """
    import numpy as np

    stripe = np.searchsorted(column_edges(start, stop, STRIPES), times, side="right") - 1
    dense = np.bincount(stripe, minlength=STRIPES)[stripe] > DENSE
    apart = np.append(True, (np.diff(stripe) > 1) | (dense[1:] != dense[:-1]))[: len(times)]
    first = dense & apart
    last = dense & np.append(apart[1:], True)[: len(times)]
    what = np.where(first, np.nan, levels)
    shown = ~dense | first | last
    first_known = start if since is None else max(start, since)
    last_known = stop if until is None else min(stop, until)
    if last_known < first_known:
        return (times[:0], what[:0]), np.empty((0, 2), np.int64)
    at = np.concatenate([[first_known], times[shown], [last_known]])
    after = np.concatenate([[level], what[shown], [levels[-1] if len(levels) else level]])
    return (at, after), np.stack([times[first], times[last]], axis=1)
