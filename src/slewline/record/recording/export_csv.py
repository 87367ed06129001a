"""Edges and steps as comma-separated values, for spreadsheets and data frames.

    time_ps,net,level                              time_ps,chip,axis,direction,position
    1200000,x.db,z                                 5300000,x,1,1,42
    1200000,x.slew,0                               5300000,y,1,-1,7

Lines end with LF.  A level is 0 or 1, on a bus 0 to 255, and z where the net floats; a direction is 1 or
-1.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Any

from ...core.motion.axis import Steps
from ..whole_file import WholeFile
from .recorder import FLOATING, Probe, Recorder, chunks, net_of

ROWS = 1 << 16  # lines produced at a time


def save_edges(path: str | Path, nets: Mapping[str, Probe], recorder: Recorder, start: int, stop: int) -> None:
    """Write the edges of some nets in start <= t <= stop (ps), sorted by time, then by name.

    The window is expanded in pieces, so a long one needs no more memory than a short one.

    Raises:
        UsageError: the path cannot be written.
        NotRecorded: a net is not recorded, or its past is no longer kept that far back.
    """
    import numpy as np

    names = sorted(nets)
    with WholeFile(path) as file:
        file.write(_lines([("time_ps", "net", "level")]))
        stop = min(stop, *(net_of(net).kernel.seen for net in nets.values())) if nets else start - 1
        for chunk in chunks([partial(recorder.edges, nets[name]) for name in names], start, stop):
            times = np.concatenate([times for times, _ in chunk])
            levels = np.concatenate([levels for _, levels in chunk])
            which = np.repeat(np.arange(len(chunk)), [len(times) for times, _ in chunk])
            order = np.argsort(times, kind="stable")
            columns = (times[order].tolist(), which[order].tolist(), levels[order].tolist())
            file.write(_lines((t, names[n], "z" if v == FLOATING else v) for t, n, v in zip(*columns, strict=True)))


def save_steps(path: str | Path, steps: Iterable[tuple[str, int, Steps]]) -> None:
    """Write steps, sorted by time, then by chip and axis.

    Args:
        path: the file.
        steps: for every axis, the name of its chip, its number (from 1), and its steps.

    Raises:
        UsageError: the path cannot be written.
    """
    import numpy as np

    axes = sorted(steps, key=lambda axis: axis[:2])
    which = np.repeat(np.arange(len(axes)), [len(taken) for _, _, taken in axes])
    columns = [
        np.concatenate([np.empty(0, np.int64), *arrays])
        for arrays in zip(*((s.times_ps, s.directions, s.positions) for _, _, s in axes), strict=True)
    ]
    with WholeFile(path) as file:
        file.write(_lines([("time_ps", "chip", "axis", "direction", "position")]))
        order = np.argsort(columns[0], kind="stable") if axes else which
        for first in range(0, len(order), ROWS):
            rows = order[first : first + ROWS]
            values = zip(which[rows].tolist(), *(column[rows].tolist() for column in columns), strict=True)
            file.write(_lines((t, *axes[n][:2], direction, position) for n, t, direction, position in values))


def _lines(rows: Iterable[Sequence[Any]]) -> bytes:
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()
