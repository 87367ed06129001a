"""The reduced trace of a pin for a picture: lines where edges can be distinguished, otherwise bands.

An hour of PULSE has 70 million edges, of which a picture shows a few hundred: in each stripe of the
picture, only the first edges are read from the log, one by one; the log is expanded into arrays only to
find the last edge of a band.
"""

from __future__ import annotations

from itertools import islice, pairwise, zip_longest
from typing import TYPE_CHECKING

from ...core.motion.quantity import column_edges
from .recorder import columns

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .recorder import Edges, Levels, Probe, Recorder

    Outline = tuple[NDArray[np.int64], NDArray[np.float64]]

STRIPES = 300  # of a picture, as wide as a line and the gap next to it
DENSE = 2  # with more edges in a stripe, a trace is a band


def edges(recorder: Recorder, probe: Probe, start: int, stop: int) -> Edges:
    """Return as many of the recorded edges in start < t <= stop (ps) as a picture needs.

    From a stripe with more than DENSE edges, only the first DENSE + 1 are returned.  If a band ends in such
    a stripe, the last edge of the stripe is returned as well.  With these edges, `logic` returns the same
    trace as with all edges.

    Raises:
        NotRecorded, TimeError: as for `Recorder.edges`.
    """
    import numpy as np

    known = max(start, recorder.since(probe)) + 1
    begins = [max(begin, known) for begin in column_edges(start, stop, STRIPES)]
    found: list[tuple[int, int]] = []
    band: tuple[int, int, int] | None = None  # to find the last edge of the previous stripe if that is dense
    for begin, over in pairwise([*begins, stop + 1]):
        ahead = list(islice(recorder.each_edge(probe, begin, over - 1), DENSE + 1))
        dense = len(ahead) > DENSE
        if band is not None and not dense:
            found.append(_last_edge(recorder, probe, *band))
        found += ahead
        band = (begin, over - 1, ahead[1][0] - ahead[0][0]) if dense else None
    if band is not None:
        found.append(_last_edge(recorder, probe, *band))
    found = [edge for edge, following in zip_longest(found, found[1:]) if edge != following]
    return columns(probe, np.array([time for time, _ in found]), np.array([level for _, level in found]))


def _last_edge(recorder: Recorder, probe: Probe, start: int, stop: int, width: int) -> tuple[int, int]:
    """Return the time and level of the last edge in a window (ps) that contains at least one.

    The last `width` ps of the window are searched first, then longer and longer parts.
    """
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
    stripes: int | None = None,
) -> tuple[Outline, NDArray[np.int64]]:
    """Return a trace: a line where single edges can be distinguished, and bands where they cannot.

    Args:
        times, levels: the edges, (n,) int64 ps and (n,).
        level: the level before the first edge.
        start, stop: the window, ps.
        since, until: the known part of the trace (ps), if not all of the window; nothing is drawn outside
            it.
        stripes: the number of stripes into which the window is divided; None for STRIPES, the greatest
            number, which suits a page.

    Returns:
        The line: instants, (m,) int64 ps, and the level from each to the next, (m,) float64, NaN within a
        band; and the starts and ends of the bands, (k, 2) int64 ps.
    """
    import numpy as np

    count = stripes or STRIPES
    stripe = np.searchsorted(column_edges(start, stop, count), times, side="right") - 1
    dense = np.bincount(stripe, minlength=count)[stripe] > DENSE
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
