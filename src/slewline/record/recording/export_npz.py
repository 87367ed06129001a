"""Columns of numbers in NumPy's own file format: `numpy.load(path)["x.slew.times_ps"]`, `["x.axis1.positions"]`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...core.motion.axis import Steps
from ..whole_file import WholeFile
from .recorder import Probe, Recorder

if TYPE_CHECKING:
    from numpy.typing import NDArray


def edge_columns(nets: Mapping[str, Probe], recorder: Recorder, start: int, stop: int) -> dict[str, NDArray[Any]]:
    """Return the edges of some nets in start <= t <= stop (ps), keyed as "x.slew.times_ps" and "x.slew.levels".

    Returns:
        For each net, times, (n,) int64 ps, ascending; and levels, (n,), as from `Recorder.edges`.

    Raises:
        NotRecorded: a net is not recorded, or its past is no longer kept that far back.
    """
    columns: dict[str, NDArray[Any]] = {}
    for name, probe in nets.items():
        columns[f"{name}.times_ps"], columns[f"{name}.levels"] = recorder.edges(probe, start, stop)
    return columns


def step_columns(steps: Iterable[tuple[str, int, Steps]]) -> dict[str, NDArray[Any]]:
    """Return the steps of each axis, keyed as "x.axis1.times_ps", "x.axis1.directions" and "x.axis1.positions".

    Args:
        steps: for every axis, the name of its chip, its number (from 1), and its steps.
    """
    return {
        f"{chip}.axis{number}.{name}": getattr(taken, name)
        for chip, number, taken in steps
        for name in ("times_ps", "directions", "positions")
    }


def save_npz(path: str | Path, columns: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays under their names, uncompressed, because compression takes too long for the space it saves.

    Raises:
        UsageError: the path cannot be written.
    """
    import numpy as np

    arrays: dict[str, Any] = dict(columns)
    with WholeFile(path) as file, file.refusals():
        np.savez(file.handle, **arrays)  # columns of numbers; NumPy 2.0 takes `allow_pickle` for one of them
