"""A measured pin drawn over the model's pin: where the two differ (#), and for how long.

    model     ‾‾‾|_____|‾‾‾‾‾‾‾|_____|‾‾‾      for a late edge, the # stretch is as long as the delay,
    measured  ‾‾‾‾|_____|‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾      for a missing pulse, as long as the pulse
                 #     #       ######

A floating or unknown signal can be measured as either level, so it is not compared.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Protocol

from ...errors import UsageError
from ..recording.recorder import FLOATING
from ..recording.traces import Trace
from ..style import duration
from .compare_edges import compare_edges
from .intervals import rounded

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..recording.recorder import Levels


class LevelTrace(Protocol):
    """A trace or a signal: the times of its edges, the level after each edge, and the level before the first."""

    @property
    def times_ps(self) -> NDArray[np.int64]:
        """The instants of the edges: (n,) int64 ps, ascending."""

    @property
    def levels(self) -> Levels:
        """The level after each edge: (n,)."""

    @property
    def level(self) -> int:
        """The level before the first edge."""


def checked(over: Mapping[str, Trace] | None) -> Mapping[str, Trace]:
    """Return the given traces, which are to be drawn over pins, keyed by pin name; an empty mapping for None.

    Raises:
        UsageError: the argument is not a mapping of pin names to traces.
    """
    if over is not None and not isinstance(over, Mapping):
        raise UsageError(f"over={over!r}: expected pins and traces, such as {{'x.slew': measured.trace('slew')}}")
    for name, trace in (over or {}).items():
        if not isinstance(trace, Trace):
            raise UsageError(f"over: {name!r}: found {trace!r}; expected a trace, such as measured.trace('slew')")
    return over or {}


def fitting(name: str, bus: bool, trace: Trace | None) -> Trace | None:
    """Return the given trace, which is to be drawn over the pin or bus `name`, or None if there is none.

    Raises:
        UsageError: the trace shows a bus but `name` is a single pin, or the reverse.
    """
    if trace is not None and trace.bus != bus:
        kinds = ("a bus", "one pin") if bus else ("one pin", "a bus")
        raise UsageError(
            f"over: {name!r} is {kinds[0]}, but the trace {trace.name!r} is {kinds[1]}; give a trace of the same kind"
        )
    return trace


def differing(model: LevelTrace, measured: Trace, start: int, stop: int) -> NDArray[np.int64]:
    """Return the stretches of a window (ps) in which a measured pin differs from the model: (k, 2) int64 ps.

    Each row is the start and the end of a stretch.
    """
    import numpy as np

    start, stop = max(start, measured.since), min(stop, measured.until)
    both = np.concatenate([model.times_ps, measured.times_ps])
    inside = np.sort(both[(start < both) & (both < stop)], kind="stable")  # two ascending rows are merged quickly
    times = np.concatenate([[start], inside, [max(start, stop)]])
    one, other = (
        np.append(each.level, each.levels)[np.searchsorted(each.times_ps, times[:-1], side="right")]
        for each in (model, measured)
    )
    differ = (one != other) & (one != FLOATING) & (other != FLOATING)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], differ, [False]]).astype(np.int8)))
    stretches: NDArray[np.int64] = times[ends].reshape(-1, 2)
    return stretches


def marked(model: LevelTrace, measured: Trace, start: int, stop: int) -> NDArray[np.int64]:
    """Return the stretches of `differing` that are longer than the tolerance of the measured trace."""
    found = differing(model, measured, start, stop)
    return found[found[:, 1] - found[:, 0] > measured.tolerance_ps]


def differences(pins: Iterable[tuple[str, LevelTrace, Trace | None]], start: int, stop: int) -> list[str]:
    """Return a line, in a list: how well pins agree with their traces in a window (ps); [] without traces."""
    notes = [f"{name} {_agreement(model, over, start, stop)}" for name, model, over in pins if over is not None]
    return [f"Measured (dashed): {'; '.join(notes)}"] if notes else []


def _agreement(model: LevelTrace, measured: Trace, start: int, stop: int) -> str:
    """Return text on how well a measured trace agrees with the model in a window (ps).

    The text states the greatest distance of a measured edge from the model's, late or early, and the numbers
    of missing and extra edges.
    """
    start, stop = max(start, measured.since), min(stop, measured.until)
    if stop <= start:
        return "covers none of this window"
    edges = [
        (each.times_ps[inside], each.levels[inside])
        for each in (model, measured)
        for inside in [(start < each.times_ps) & (each.times_ps < stop)]
    ]
    found = compare_edges(edges[0], edges[1], shift=0, tolerance=measured.tolerance_ps)
    notes = []
    if len(late := found.late_ps):
        most = int(late[abs(late).argmax()])
        much = duration(rounded(abs(most), 3))
        apart = f"up to {much} {'late' if most > 0 else 'early'}"
        notes.append("agrees" if not most else f"within {much}" if found.greatest_ps <= found.tolerance_ps else apart)
    for kind, alone, pairs in (
        ("missing", found.missing, found.pairs[:, 0]),
        ("extra", found.extra, found.pairs[:, 1]),
    ):
        if len(pairs):  # before the first pair and after the last one, the other edge may be outside
            alone = alone[(pairs[0] < alone) & (alone < pairs[-1])]
        if len(alone):
            notes.append(f"{len(alone)} edge{'s' * (len(alone) > 1)} {kind}")
    return ", ".join(notes) or ("differs" if len(marked(model, measured, start, stop)) else "agrees")
