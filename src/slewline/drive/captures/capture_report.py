"""The results for a recording: limits, steps, glitches, jitter and skew, with a picture of the worst case."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...core.messages.whole import counted
from ...errors import UsageError
from ...record.measuring.intervals import Checked, Interval, SignalEdges, TimingTable, intervals, rounded
from ...record.measuring.measure import Jitter, Skew
from ...record.style import duration

if TYPE_CHECKING:
    from pathlib import Path

    from ...core.motion.axis import Steps

AROUND = 3  # margin on both sides of a picture, as a multiple of the time shown


@dataclass(frozen=True)
class AxisCapture:
    """The recording of an axis.

    Attributes:
        name: the name of the axis.
        steps: the steps of the axis, as `Waveforms.steps` returns them.
        signals: the signals of the axis, under the names "step" and "direction".
        glitches: the starts of the pulses and gaps of STEP or DIR that are too short to be intended, ps.
        glitch_ps: the length below which a pulse or gap of STEP is a glitch, ps.
        jitter: the jitter of the steps in the longest stretch at one rate; None if there is no such stretch.
    """

    name: str
    steps: Steps
    signals: dict[str, SignalEdges]
    glitches: tuple[int, ...]
    glitch_ps: int
    jitter: Jitter | None

    def __str__(self) -> str:
        there = int((self.steps.directions > 0).sum())
        count = len(self.steps.times_ps)
        end = int(self.steps.positions[-1]) if count else 0
        lines = [f"{self.name}: {counted(count, 'step')}, {there} forward and {count - there} back, ends at {end}"]
        if self.glitches:
            first = duration(self.glitches[0])
            lines.append(f"  GLITCHES: {len(self.glitches)}, first at {first}")
        if self.jitter is not None:
            rms, most = (duration(rounded(round(ps), 3)) for ps in (self.jitter.rms_ps, self.jitter.greatest_ps))
            rate = f"{self.jitter.steps} steps at {self.jitter.rate_sps:.1f} steps/s"
            lines.append(f"  jitter {rms} rms, {most} at most, of {rate}")
        return "\n".join(lines)


@dataclass(frozen=True)
class CaptureReport:
    """A checked recording; `print` shows it.

    Attributes:
        axes: an `AxisCapture` for each axis.
        limits: a `TimingTable` of the data sheet limits, each with the measured times.
        skews: for each pair of axes, keyed by both names, the `Skew` of the second axis's steps relative
            to the first axis's steps; None if no steps of the two axes are close in time.
        resolution_ps: the timing error caused by sampling, ps.
        notes: remarks that restrict the result, one per line.
    """

    axes: tuple[AxisCapture, ...]
    limits: TimingTable
    skews: dict[tuple[str, str], Skew | None]
    resolution_ps: int
    notes: tuple[str, ...] = ()

    @property
    def good(self) -> bool:
        """True if no limit is violated, there is no glitch, and every axis has steps."""
        moved = all(len(axis.steps.times_ps) for axis in self.axes)
        return moved and not self.limits.violated and not any(axis.glitches for axis in self.axes)

    def __repr__(self) -> str:
        return f"<CaptureReport: {len(self.axes)} axes, {len(self.limits.violated)} limits violated>"

    def __str__(self) -> str:
        lines = [str(axis) for axis in self.axes]
        for (first, second), found in self.skews.items():
            if found is None:
                lines.append(f"{second} after {first}: no steps are close in time")
            else:
                later = "after" if found.median_ps >= 0 else "before"
                by, most = duration(abs(found.median_ps)), duration(found.greatest_ps)
                lines.append(f"{second} {later} {first}: {by}, ±{most}, in {counted(found.pairs, 'pair')}")
        lines += [str(self.limits)] if len(self.limits) else []
        return "\n".join([*lines, *self.notes])

    def plot(self, path: str | Path, width: str | float = "page", dark: bool = False) -> None:
        """Draw the signals at the worst violation or, if there is none, where a time is closest to its limit.

        Args:
            path: the file; its suffix selects SVG, PNG or PDF.
            width: "page", "phone", or a number of inches.
            dark: draw in light colours on a dark background.

        Raises:
            UsageError: the suffix is unknown, the path cannot be written, or no limit has a measured time.
        """
        from ...record.pictures.diagram import Diagram, Lane
        from ...record.pictures.picture_files import SUFFIXES, save
        from ...record.pictures.timing_diagram import draw
        from ...record.whole_file import check_suffix

        check_suffix(path, SUFFIXES)
        axis, shown, named = self._worst()
        reach = AROUND * max(shown.ps, 2 * self.resolution_ps)
        start, stop = shown.start_ps - reach, shown.end_ps + reach
        lanes = [
            Lane(f"{axis.name}.{name}", f"{axis.name}: {name}", _cut(signal, start, stop))
            for name, signal in axis.signals.items()
        ]
        diagram = Diagram(f"{axis.name}: {named}", start, stop, lanes, [shown], (), 0)
        save(draw(diagram, width, dark), path, diagram.title, diagram.description, dark)

    def _worst(self) -> tuple[AxisCapture, Interval, str]:
        """Return the axis, interval and title for a picture of the worst violation or, if none, the least margin."""
        of_axis = {axis.name: axis.signals for axis in self.axes}
        rows = [
            row for row in self.limits if row.count and row.bound.limit.start.split()[0] in of_axis.get(row.chip, ())
        ]
        if not rows:
            raise UsageError("plot: no limit was measured; give a driver, and a recording with steps")
        row = min(rows, key=lambda row: (row.kept is not False, _room(row)))
        axis = next(axis for axis in self.axes if axis.name == row.chip)
        limit = row.bound.limit
        begins, ends = intervals(limit, lambda pin: axis.signals[pin])
        lasts = ends - begins
        n = int(lasts.argmin() if limit.least is not None else lasts.argmax())
        start, end = int(begins[n]), int(ends[n])
        first, second = (f"{axis.name}.{edge}" for edge in (limit.start, limit.end))
        shown = row.kept is False or row.bound.kept(end - start, end - start)  # otherwise sampling alone explains it
        bounds = (row.bound,) if shown else ()
        return axis, Interval(first, second, start, end, bounds), limit.description


def _room(row: Checked) -> float:
    """Return the shortest measured time minus the least allowed time, as a fraction of the least allowed time."""
    return ((row.shortest_ps or 0) - (row.bound.least or 0)) / max(row.bound.least or 1, 1)


def _cut(signal: SignalEdges, start: int, stop: int) -> SignalEdges:
    """Return the edges of a signal in start < t <= stop (ps)."""
    import numpy as np

    first, last = np.searchsorted(signal.times_ps, (start, stop), side="right").tolist()
    level = int(signal.levels[first - 1]) if first else signal.level
    return SignalEdges(signal.times_ps[first:last], signal.levels[first:last], level, signal.bus)
