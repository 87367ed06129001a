"""Pins in a picture, one lane each: lines, bands where edges are too dense, and buses with their bytes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from ..measuring.overlay import marked
from ..recording import outlines
from ..recording.recorder import FLOATING
from ..recording.traces import Trace
from ..style import Palette, TimeAxis

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

HIGH = 0.6  # of a lane: height of a 1 above a 0
LANE, NAMED_LANE = 0.27, 0.36  # inches; the second with its name above the line
BYTE_SHARE = 0.03  # of the window: width for the text of a byte
APART = 0.009  # of the window: minimum distance between bands
STRIPES_PER_INCH = 40
TICK = 0.09  # of a lane: height of a tick below a stretch in which two traces differ
MARKS = 2000  # stretches in a row that can be distinguished
MEASURED: Any = (0, (3, 2))  # dashes of a trace over another


def wrapped(name: str, letters: int) -> str | None:
    """Return a name in one or two lines of at most `letters` letters each; None if it does not fit."""
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
        names: the names to write next to the lanes; None to write the name of each trace in the panel, above
            its lane.
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
            label.set(linespacing=1.15, fontsize=6.5 if "\n" in label.get_text() else 8)
    else:
        panel.set_yticks([])
        for row, trace in zip(rows, traces, strict=True):
            at = (0, len(traces) - row - 0.06)
            panel.annotate(trace.name, at, (1, 0), ("axes fraction", "data"), "offset points", va="top", fontsize=7.5)
    panel.grid(axis="y", visible=False)
    panel.spines["left"].set_visible(False)


def _draw_lane(panel: Axes, trace: Trace, axis: TimeAxis, colours: Palette, base: float, high: float) -> None:
    _draw_trace(panel, trace, axis, colours, base, high)
    if trace.over is not None:
        start, stop = max(axis.start, trace.since), min(axis.stop, trace.until)
        _draw_differing(panel, trace.name, marked(trace, trace.over, start, stop), axis, colours, base, high)
        _draw_trace(panel, trace.over, axis, colours, base, high, over=True)


def _draw_trace(
    panel: Axes, trace: Trace, axis: TimeAxis, colours: Palette, base: float, high: float, over: bool = False
) -> None:
    """Draw the known part of a trace; with `over`, in the style of a trace that is drawn over another one."""
    import numpy as np
    from matplotlib.collections import PolyCollection

    start, stop = max(axis.start, trace.since), min(axis.stop, trace.until)
    if stop <= start:
        return
    known = trace.within(start, stop)
    outline, bands = outlines.logic(
        known.times_ps, known.levels, known.level, axis.start, axis.stop, start, stop, _stripes(panel)
    )
    times, levels = axis.scaled(outline[0]), outline[1]
    color = colours.measured if over else colours.bus if trace.bus else colours.trace
    dashes: Any = MEASURED if over else "solid"
    if trace.bus:
        span = float(axis.scaled(axis.stop) - axis.scaled(axis.start))
        _draw_bus(panel, times, levels, colours, base, high, span, over)
    else:
        heights = base + high * np.where(levels == FLOATING, np.nan, levels)
        panel.plot(
            times, heights, color=color, linewidth=1.1, linestyle=dashes, drawstyle="steps-post",
            solid_joinstyle="miter", gid=f"measured {trace.name}" if over else None,
        )  # fmt: skip
        _draw_floating(panel, times, levels, color, base + high / 2)
    if len(bands):
        close = bands[1:, 0] - bands[:-1, 1] < APART * (axis.stop - axis.start)
        ends = axis.scaled(np.stack([bands[np.append(True, ~close), 0], bands[np.append(~close, True), 1]], axis=1))
        face = "none" if over else f"{color}60"
        shown = boxes(ends, base, high)
        panel.add_collection(PolyCollection(shown, facecolor=face, edgecolor=color, linewidth=0.9, linestyle=dashes))


def _stripes(panel: Axes) -> int:
    """Return the number of vertical lines that can be distinguished in a panel; at most STRIPES."""
    across = panel.get_position().width * panel.get_figure(root=True).get_figwidth()  # type: ignore[union-attr]
    return min(max(int(STRIPES_PER_INCH * across), 1), outlines.STRIPES)


def _draw_differing(
    panel: Axes, name: str, stretches: NDArray[np.int64], axis: TimeAxis, colours: Palette, base: float, high: float
) -> None:
    """Mark stretches with shading and with ticks below the lane; the ticks show even the shortest stretch."""
    import numpy as np
    from matplotlib.collections import PolyCollection

    if not len(stretches):
        return
    least = (axis.stop - axis.start) // MARKS
    wide = stretches[stretches[:, 1] - stretches[:, 0] > least]
    apart = np.diff(stretches.ravel())[1::2] > least
    ends = np.stack([stretches[np.append(True, apart), 0], stretches[np.append(apart, True), 1]], axis=1)
    shade, ticks = boxes(axis.scaled(wide), base, high), boxes(axis.scaled(ends), base - TICK - 0.05, TICK)
    panel.add_collection(PolyCollection(shade, facecolor=f"{colours.alarm}40", linewidth=0, zorder=0.5))
    alarm, gid = colours.alarm, f"where {name} differs"
    panel.add_collection(PolyCollection(ticks, facecolor=alarm, edgecolor=alarm, linewidth=0.8, gid=gid))


def boxes(ends: Any, base: float, high: float) -> list[list[tuple[float, float]]]:
    """Return the corners of a box for each row (start, end) of `ends`, (n, 2), from `base` to `base + high`."""
    return [[(a, base), (b, base), (b, base + high), (a, base + high)] for a, b in ends]


def _draw_floating(panel: Axes, times: Any, levels: Any, color: str, middle: float) -> None:
    """Draw a dashed line at half height wherever the pin floats."""
    import numpy as np

    floating = np.flatnonzero(levels[:-1] == FLOATING)
    if len(floating):
        panel.hlines(np.full(len(floating), middle), times[floating], times[floating + 1], color, "dashed", lw=0.9)


def _draw_bus(
    panel: Axes, times: Any, levels: Any, colours: Palette, base: float, high: float, span: float, over: bool = False
) -> None:
    """Draw hexagons, with their bytes where there is room, and a line at mid-height where the bus floats.

    For a trace that is drawn over another one (`over`), draw only the outlines.
    """
    from matplotlib.collections import PolyCollection

    hexagons = []
    for begin, end, level in zip(times[:-1], times[1:], levels[:-1], strict=True):
        if level != level or level == FLOATING or end <= begin:  # NaN: inside a band
            continue
        slant = min(0.002 * span, (end - begin) / 2)
        across = [begin, begin + slant, end - slant, end, end - slant, begin + slant]
        up = [base + high / 2, base + high, base + high, base + high / 2, base, base]
        hexagons.append(list(zip(across, up, strict=True)))
        if end - begin > BYTE_SHARE * span and not over:
            middle = (begin + end) / 2, base + high / 2
            panel.text(*middle, f"{int(level):02X}", ha="center", va="center_baseline", fontsize=7.5, color=colours.bus)
    color, face, dashes = (colours.measured, "none", MEASURED) if over else (colours.bus, colours.byte, "solid")
    panel.add_collection(PolyCollection(hexagons, facecolor=face, edgecolor=color, linewidth=0.9, linestyle=dashes))
    _draw_floating(panel, times, levels, color, base + high / 2)
