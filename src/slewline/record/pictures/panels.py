"""Curves in a picture: quantities of several axes and runs in one panel, over a common time axis.

The curves of one quantity, from all tracks (tracks.py), share a panel.  A curve is moved to another panel
if, in the shared one, it or any curve next to it would appear as a flat line.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, cast

from ...core.motion.quantity import Outline
from ..style import DASHES, Palette, TimeAxis, number
from .rate_lines import RATE_HEIGHT, rates_of
from .tracks import Track, TrackCurve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import LineCollection
    from matplotlib.lines import Line2D

FLAT = 25  # a curve that is this many times smaller than the panel is not legible
SCALED_FROM = 1_000_000  # numbers next to a panel that are shown in millions ...
POWERS = {6: "10⁶ ", 9: "10⁹ ", 12: "10¹² ", 15: "10¹⁵ "}
IDEAL_POINTS = 300
DENSE = 1000  # points with peaks thinner than a line: round joins keep their height
PIECE = 250  # points of such a line, or of the area below it, drawn at a time


def curves_of(tracks: Sequence[Track], axis: TimeAxis, columns: int) -> list[list[TrackCurve]]:
    """Return the curves of each panel: curves of one quantity, none of which would be flat next to the others."""
    kinds: dict[tuple[str, str], list[TrackCurve]] = {}
    for number_, track in enumerate(tracks):
        start, stop = track.window(axis)
        for quantity in track.quantities:
            curve = TrackCurve(number_, track, quantity, _to_the_end(quantity.outline(start, stop, columns), stop))
            kinds.setdefault((quantity.name, quantity.unit), []).append(curve)
    order = {name: place for place, name in enumerate(("velocity", "position"))}
    named = sorted(kinds.items(), key=lambda item: order.get(item[0][0], len(order)))
    return [panel for _, curves in named for panel in _apart(curves)]


def _to_the_end(outline: Outline, stop: int) -> Outline:
    """Return the outline, extended with its last value to the end of the window."""
    import numpy as np

    if not len(outline.times_ps) or outline.times_ps[-1] >= stop:
        return outline
    return Outline(np.append(outline.times_ps, stop), np.append(outline.values, outline.values[-1]))


def _apart(curves: Sequence[TrackCurve]) -> list[list[TrackCurve]]:
    """Return the curves in groups, each of which is legible in one panel."""
    groups: list[list[TrackCurve]] = []
    for curve in curves:
        for group in groups:
            reaches = [each.reach for each in (*group, curve)]
            whole = max(high for _, high in reaches) - min(low for low, _ in reaches)
            own = [high - low for low, high in reaches if high > low]
            if not own or whole <= FLAT * min(own):
                group.append(curve)
                break
        else:
            groups.append([curve])
    return groups


def named_by_legend(tracks: Sequence[Track], panels: Iterable[Sequence[TrackCurve]]) -> list[int]:
    """Return the numbers of the tracks that the legend names: all axes, and all parts that share a panel.

    Return [] if there are fewer than two such tracks.
    """
    shared = {curve.number for curves in panels for curve in curves if len(curves) > 1}
    named = [number for number, track in enumerate(tracks) if not track.part or number in shared]
    return named if len(named) > 1 else []


def heading(curves: Sequence[TrackCurve], several: bool) -> str:
    """Return the heading of a panel: its quantity and unit and, if `several`, also the names of its tracks."""
    quantity = curves[0].quantity
    whose = f" of {', '.join(curve.track.name for curve in curves)}" if several else ""
    return f"{quantity.name.capitalize().replace('_', ' ')}{whose}, {POWERS.get(_power(curves), '')}{quantity.unit}"


def still(curves: Sequence[TrackCurve]) -> bool:
    """Return whether the curves of a panel are velocities that are always zero."""
    return curves[0].quantity.name == "velocity" and all(curve.reach == (0, 0) for curve in curves)


def _power(curves: Sequence[TrackCurve]) -> int:
    highest = max(max(-curve.reach[0], curve.reach[1]) for curve in curves)
    return next((power for power in (15, 12, 9, 6) if highest >= max(10**power, SCALED_FROM)), 0)


# ------------------------------------------------------------------------------------------------------------ drawing
def draw_curves(
    panel: Axes,
    curves: Sequence[TrackCurve],
    axis: TimeAxis,
    colours: Palette,
    height: float,
    named: Collection[int],
    beside: bool,
) -> None:
    """Draw the curves of a panel, with the first track's curve on top.

    Args:
        height: the height of the panel, inches.
        named: the numbers of the tracks in the legend; the curves of these tracks are distinguished by line
            style and colour.  Empty if there is no legend.
        beside: where the marked rates have their names: True for next to the panel, False for above the line
            that marks the rate.
    """
    for curve in reversed(curves):
        _draw_curve(panel, curve, axis, colours, curve.number in named, filled=len(curves) == 1)
    low, high = _limits(curves, axis, 0.0 if beside else RATE_HEIGHT / height)
    panel.set_ylim(low, high)
    for curve in curves:
        _mark_outside(panel, curve, axis, colours, low, high)
    if low <= 0 <= high and curves[0].from_zero:
        panel.axhline(0, color=colours.edge, linewidth=0.8, zorder=1)
    _draw_scale(panel, _power(curves), height, whole=high - low >= 2 or curves[0].reach == (0, 0))
    if still(curves):
        panel.set_yticks([0])
        panel.text(0.5, 0.5, "no motion", transform=panel.transAxes, ha="center", va="center", color=colours.soft)


def _draw_curve(panel: Axes, curve: TrackCurve, axis: TimeAxis, colours: Palette, named: bool, filled: bool) -> None:
    from matplotlib.lines import Line2D

    color = colours.series[curve.number % len(colours.series)]
    dashes: Any = DASHES[curve.number % len(DASHES)] if named else "solid"
    times, values = axis.scaled(curve.outline.times_ps - curve.track.zero), curve.outline.values
    is_staircase = curve.quantity.is_staircase
    style: Any = "steps-post" if is_staircase else "default"
    dense = len(times) >= DENSE
    line = (dense_line() if dense else Line2D)(
        times,
        values,
        color=color,
        linewidth=1.2 if curve.track.over else 1.5,
        linestyle=dashes,
        zorder=2.2 if curve.track.over else 2,
        drawstyle=style,
        solid_joinstyle="round" if dense else "miter",
        solid_capstyle="round" if dense else "projecting",
        label=curve.track.name,
        gid=f"{curve.quantity.name} of {curve.track.name}",
    )
    panel.add_line(line)
    if filled and curve.quantity.name == "velocity":
        size = PIECE if dense else len(times)  # one polygon with 12,000 corners takes 200 ms
        for first in range(0, len(times), size):
            part = slice(first, first + size + 1)
            panel.fill_between(
                times[part], values[part], step="post" if is_staircase else None, color=color, alpha=0.10, linewidth=0
            )


def _limits(curves: Sequence[TrackCurve], axis: TimeAxis, above: float) -> tuple[float, float]:
    """Return the lowest and the highest value on the value axis of a panel.

    The range includes all curves, the lines that mark rates, and a margin.  `above` is the part of the
    panel's height (0 to 1) that is needed for a name above the line of the highest rate.
    """
    low, high = min(curve.reach[0] for curve in curves), max(curve.reach[1] for curve in curves)
    if curves[0].quantity.name == "velocity":
        rates = [rate.value for curve in curves for rate in rates_of(curve, axis)]
        low, high = min([low, *rates]), max([high, *rates])
        high += above * (high - low) * (max(rates, default=low) == high)
    if low == high:
        return (low - 1, high + 1) if not curves[0].from_zero else (low - (low < 0), high + 1)
    room = 0.08 * (high - low)
    if curves[0].from_zero:
        return low - (room if low < 0 else room / 3), high + (room if high > 0 else room / 3)
    return low - room, high + room


def _mark_outside(panel: Axes, curve: TrackCurve, axis: TimeAxis, colours: Palette, low: float, high: float) -> None:
    """Mark the value that a register has before it is first loaded, if this value is outside the panel."""
    value = float(curve.outline.values[0])
    if curve.rest_before() and not low <= value <= high:
        up = value > high
        at = (float(axis.scaled(curve.outline.times_ps[0] - curve.track.zero)), 0.99 if up else 0.03)
        panel.annotate(
            f"{'↑' if up else '↓'} {number(value)}", at, (3, 0), ("data", "axes fraction"), "offset points",
            va="top" if up else "bottom", fontsize=7.5, color=colours.soft,
        )  # fmt: skip


def _draw_scale(panel: Axes, power: int, height: float, whole: bool) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    panel.yaxis.set_major_locator(MaxNLocator(max(4, round(height / 0.38)), steps=[1, 2, 5, 10], integer=whole))
    panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: number(value / 10**power)))


# -------------------------------------------------------------------------------------------------------- kinds of line
@cache
def dense_line() -> type[Line2D]:
    """Return a class for lines that have thousands of points.

    Such a line is drawn in short pieces, because the renderer is slow with a single long path.  Each piece
    ends at the point where the next begins; round ends avoid gaps between them.
    """
    import numpy as np
    from matplotlib.lines import Line2D

    class DenseLine(Line2D):
        def draw(self, renderer: Any) -> None:
            points = np.asarray(self.get_xydata())
            renderer.open_group("line2d", self.get_gid())
            for first in range(0, len(points), PIECE):
                piece = Line2D(*points[first : first + PIECE + 1].T)
                piece.update_from(self)
                piece.axes = self.axes
                piece.set_figure(self.get_figure())  # type: ignore[arg-type]
                piece.draw(renderer)
            renderer.close_group("line2d")
            self.stale = False

    return DenseLine


def time_grid(colours: Palette) -> LineCollection:
    """Return grid lines at the ticks of the time axis, for a panel that does not show these ticks itself.

    Ticks are the most expensive element of a picture: each consists of five artists and takes 2 ms.
    """
    from matplotlib.collections import LineCollection

    class TimeGrid(LineCollection):
        def draw(self, renderer: Any) -> None:
            panel = cast("Axes", self.axes)  # it is drawn as a whole
            self.set_segments([[(place, 0), (place, 1)] for place in panel.xaxis.get_majorticklocs()])
            self.set_transform(panel.get_xaxis_transform())
            super().draw(renderer)

    return TimeGrid([], colors=colours.grid, linewidths=0.8, zorder=0.5)


# ------------------------------------------------------------------------------------------------------------- ideals
def draw_ideals(panel: Axes, curves: Sequence[TrackCurve], axis: TimeAxis, colours: Palette) -> None:
    """Draw the ideal velocities and positions, unquantized by steps, clocks and cycles, over the real ones."""
    import numpy as np

    for curve in curves:
        start, stop = curve.track.window(axis)
        for ideal, _ in curve.track.ideals:
            first, last = max(ideal.start, start), min(ideal.stop, stop)
            if curve.quantity.name not in ("velocity", "position") or first >= last:
                continue
            times = np.union1d(np.linspace(first, last, IDEAL_POINTS).astype(np.int64), ideal.bends)
            times = times[(first <= times) & (times <= last)]
            law = ideal.velocities if curve.quantity.name == "velocity" else ideal.positions
            at = axis.scaled(times - curve.track.zero)
            panel.plot(at, law(times), color=colours.ink, linewidth=0.9, linestyle=(0, (1, 1)), zorder=2.5)


def columns_of(width: float) -> int:
    """Return the number of columns to which curves are reduced for a panel that is `width` inches wide."""
    return round(width * 110)
