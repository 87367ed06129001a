"""Pins in a picture: a lane each; lines, bands where edges are too dense, buses with their bytes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from . import outlines
from .recorder import FLOATING, Probe, Recorder, net_of, width_of
from .style import Palette, TimeAxis

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from .recorder import Levels

HIGH = 0.6  # of a lane: how much higher a 1 lies than a 0
LANE, NAMED_LANE = 0.27, 0.36  # inches; the second with its name above the line
BYTE_SHARE = 0.03  # of the window: what a byte needs to be written
APART = 0.009  # of the window: what must lie between two bands


@dataclass(frozen=True, slots=True)
class Trace:
    """What one pin does: edges as Recorder.edges gives them, and the level before the first; a bus shows its bytes.

    `since` and `until` (ps) are the ends of what is known of it; None: of any picture.
    """

    name: str
    times_ps: NDArray[np.int64]
    levels: Levels
    level: int
    bus: bool = False
    since: int | None = None
    until: int | None = None

    @classmethod
    def of(cls, name: str, probe: Probe, recorder: Recorder, start: int, stop: int) -> Trace:
        """Return the trace of a recorded net or pin in a window (ps), as far as it is recorded and a picture of it
        shows."""
        since, until = max(start, recorder.since(probe)), min(stop, net_of(probe).kernel.seen)
        times, levels = outlines.edges(recorder, probe, start, stop)
        return cls(name, times, levels, recorder.level_at(probe, since), width_of(probe) > 1, since, until)

    def shifted(self, by: int) -> Trace:
        """Return the same so many ps later."""
        since, until = (None if end is None else end + by for end in (self.since, self.until))
        return replace(self, times_ps=self.times_ps + by, since=since, until=until)

    def within(self, start: int, stop: int) -> Trace:
        """Return what of it lies in a window (ps): of a file, which knows no window."""
        import numpy as np

        first, last = np.searchsorted(self.times_ps, (start, stop), side="right").tolist()
        level = int(self.levels[first - 1]) if first else self.level
        return replace(self, times_ps=self.times_ps[first:last], levels=self.levels[first:last], level=level)


def wrapped(name: str, letters: int) -> str | None:
    """Return a name in one or two lines of at most so many letters; None if it does not fit."""
    if len(name) <= letters:
        return name
    breaks = [at + 1 for at, letter in enumerate(name) if letter in "_."]
    fits = [at for at in breaks if at <= letters and len(name) - at <= letters]
    return f"{name[: fits[-1]]}\n{name[fits[-1] :]}" if fits else None


def draw_lanes(
    panel: Axes, traces: Sequence[Trace], axis: TimeAxis, colours: Palette, names: Sequence[str] | None
) -> None:
    """Draw traces into a panel, the first one on top.

    Args:
        names: what stands beside the lanes; None: the names stand in the panel, each over its lane.
    """
    share = 1.0 if names is not None else LANE / NAMED_LANE
    rows = range(len(traces))
    for row, trace in zip(rows, traces, strict=True):
        _draw_lane(panel, trace, axis, colours, len(traces) - 1 - row + 0.16 * share, HIGH * share)
    panel.set_ylim(0, len(traces))
    if names is not None:
        panel.set_yticks([len(traces) - 0.54 - row for row in rows], names)
        panel.tick_params(axis="y", length=0, labelcolor=colours.ink, labelsize=8, pad=4)
        for label in panel.get_yticklabels():
            label.set(linespacing=1.0, fontsize=7 if "\n" in label.get_text() else 8)
    else:
        panel.set_yticks([])
        for row, trace in zip(rows, traces, strict=True):
            at = (0, len(traces) - row - 0.06)
            panel.annotate(trace.name, at, (1, 0), ("axes fraction", "data"), "offset points", va="top", fontsize=7.5)
    panel.grid(axis="y", visible=False)
    panel.spines["left"].set_visible(False)


def _draw_lane(panel: Axes, trace: Trace, axis: TimeAxis, colours: Palette, base: float, high: float) -> None:
    import numpy as np

    outline, bands = outlines.logic(
        trace.times_ps, trace.levels, trace.level, axis.start, axis.stop, trace.since, trace.until
    )
    times, levels = axis.scaled(outline[0]), outline[1]
    color = colours.bus if trace.bus else colours.trace
    if trace.bus:
        span = float(axis.scaled(axis.stop) - axis.scaled(axis.start))
        _draw_bus(panel, times, levels, colours, base, high, span)
    else:
        heights = base + high * np.where(levels == FLOATING, np.nan, levels)
        panel.plot(times, heights, color=color, linewidth=1.1, drawstyle="steps-post", solid_joinstyle="miter")
        _draw_floating(panel, times, levels, color, base + high / 2)
    if len(bands):
        from matplotlib.collections import PolyCollection

        close = bands[1:, 0] - bands[:-1, 1] < APART * (axis.stop - axis.start)
        ends = axis.scaled(np.stack([bands[np.append(True, ~close), 0], bands[np.append(~close, True), 1]], axis=1))
        boxes = [[(a, base), (b, base), (b, base + high), (a, base + high)] for a, b in ends]
        panel.add_collection(PolyCollection(boxes, facecolor=f"{color}60", edgecolor=color, linewidth=0.9))


def _draw_floating(panel: Axes, times: Any, levels: Any, color: str, middle: float) -> None:
    """A line of dashes half way up while nothing drives."""
    import numpy as np

    floating = np.flatnonzero(levels[:-1] == FLOATING)
    if len(floating):
        panel.hlines(np.full(len(floating), middle), times[floating], times[floating + 1], color, "dashed", lw=0.9)


def _draw_bus(panel: Axes, times: Any, levels: Any, colours: Palette, base: float, high: float, span: float) -> None:
    """Boxes with their bytes, as far as these have room; a line in the middle while nothing drives."""
    from matplotlib.collections import PolyCollection

    boxes = []
    for begin, end, level in zip(times[:-1], times[1:], levels[:-1], strict=True):
        if level != level or level == FLOATING or end <= begin:  # NaN: inside a band
            continue
        slant = min(0.002 * span, (end - begin) / 2)
        across = [begin, begin + slant, end - slant, end, end - slant, begin + slant]
        up = [base + high / 2, base + high, base + high, base + high / 2, base, base]
        boxes.append(list(zip(across, up, strict=True)))
        if end - begin > BYTE_SHARE * span:
            middle = (begin + end) / 2, base + high / 2
            panel.text(*middle, f"{int(level):02X}", ha="center", va="center_baseline", fontsize=7.5, color=colours.bus)
    panel.add_collection(PolyCollection(boxes, facecolor=colours.byte, edgecolor=colours.bus, linewidth=0.9))
    _draw_floating(panel, times, levels, colours.bus, base + high / 2)
