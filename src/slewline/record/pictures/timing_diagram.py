r"""Timing diagrams: a window of recorded pins, drawn in the style of data sheets.

/WRITE  ‾‾‾‾‾‾\_____/‾‾‾‾‾‾‾‾‾ \ \ ‾‾‾‾‾      one lane per pin, measured times under the lower of their two lanes,
              |<--->| 80 ns     / /           long quiet stretches cut short where the zigzag is
DATA    -----<  4A 'J'  >------ \ \ -----
"""

from __future__ import annotations

from itertools import pairwise
from textwrap import wrap
from typing import TYPE_CHECKING, Any, TypeAlias

from ...core.time.timebase import readable
from ...errors import UsageError
from ..measuring.intervals import Interval, SignalEdges, rounded
from ..measuring.overlay import marked
from ..recording.recorder import FLOATING
from ..recording.traces import EVER, Trace
from ..style import Palette, TimeAxis, duration, inches, number, styled
from .diagram import (
    BOTTOM,
    EDGE,
    LARGE,
    LETTER,
    NOTE,
    RIGHT,
    ROW,
    SMALL,
    SWING,
    WORDS,
    Arrow,
    Diagram,
    DiagramLayout,
    Lane,
    TimeScale,
    lanes_of,
)
from .figures import new_picture
from .lanes import MEASURED, boxes

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Runs: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int64], list[tuple[int, int]]]

TAIL, STEEP = 0.08, 0.045  # inches: extension of levels at both ends of the window; the width of an edge
LEVEL = 3  # times the width of an edge: a narrower level would be a triangle
CAPITAL = 0.012  # inches: the width of a letter in a name, per point
DENSE, FEWEST = 0.02, 6  # edges closer than this (inches) are a band, if there are as many
TINY = 6.5  # points
TITLE, NEXT = 0.1, 0.2  # inches: the width of a letter of the title, and from one of its lines to the next
TICK = 0.03  # inches: height of a tick below a stretch in which two signals differ


def draw(diagram: Diagram, width: str | float = "page", dark: bool = False) -> Figure:
    """Return the diagram as a matplotlib Figure.

    Args:
        width: "page", "phone", or inches.

    Raises:
        UsageError: no lanes, an empty window, an invalid width, or no matplotlib.
    """
    if diagram.stop <= diagram.start or not diagram.lanes:
        found = f"nothing to draw from {readable(diagram.start)} to {readable(diagram.stop)}"
        raise UsageError(f"{found}; expected a stop after the start, and at least one pin")
    with styled(dark) as colours:
        page = inches(width)
        left = 0.16 + max(len(lane.label) for lane in diagram.lanes) * CAPITAL * LARGE
        scale = TimeScale(diagram, left + TAIL, page - RIGHT - TAIL)  # the levels extend beyond both ends
        layout = DiagramLayout.of(diagram, scale)
        title = wrap(diagram.title, int((page - 0.24) / TITLE)) or [""]
        height = layout.height + NEXT * (len(title) - 1)
        figure = new_picture(page, height, dark)
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set_axis_off()
        axes.set(xlim=(0, page), ylim=(0, height))
        Drawing(axes, colours, diagram, scale, layout).draw(title)
        return figure


class Drawing:
    """A diagram in progress; time runs to the right, and all positions are in inches."""

    def __init__(self, axes: Axes, colours: Palette, diagram: Diagram, scale: TimeScale, layout: DiagramLayout) -> None:
        self.axes, self.colours, self.diagram, self.scale, self.layout = axes, colours, diagram, scale, layout
        self.slant = STEEP * min((scale.right - scale.left) / 8, 1)
        self.centres = [float(scale(list(cut)).mean()) for cut in scale.cuts]

    def draw(self, title: Sequence[str]) -> None:
        """Draw the whole diagram; each element of `title` is one line of the title."""
        above = self.layout.height - 0.2
        for row, line in enumerate(reversed(title)):
            self._text(EDGE, above + NEXT * row, line, size=11, weight="bold", ha="left")
        for row, note in enumerate(self.layout.notes):
            self._text(EDGE, above - 0.2 - NOTE * row, note, LARGE, color=self.colours.soft, ha="left")
        for lane, foot in zip(self.diagram.lanes, self.layout.feet, strict=True):
            self._text(self.scale.left - TAIL - 0.08, foot + SWING / 2, lane.label, size=LARGE, ha="right")
            (self._bus if lane.signal.bus else self._pin)(lane, foot)
            if lane.over is not None:
                self._over(lane, lane.over, foot)
            self._words(lane, foot + SWING + 0.03)
        self._time()
        for place, (begin, end) in zip(self.centres, self.scale.cuts, strict=True):
            self._cut(place, end - begin - self.scale.room)
        for arrow in self.layout.arrows:
            self._arrow(arrow)
        for cause in self.diagram.causes:
            self._cause(cause)

    def _text(self, x: float, y: float, text: str, size: float = SMALL, **how: Any) -> None:
        settings: dict[str, Any] = {"va": "center_baseline", "ha": "center", "color": self.colours.ink} | how
        self.axes.text(x, y, text, fontsize=size, **settings)

    def _line(self, across: Any, up: Any, color: str, width: float = 1.1, **how: Any) -> None:
        self.axes.plot(across, up, color=color, linewidth=width, solid_joinstyle="miter", **how)

    # ----------------------------------------------------------------------------------------------------------- lanes
    def _runs(self, signal: SignalEdges, since: int, until: int) -> Runs:
        """Return positions, levels and bands of a signal in its known part, from `since` to `until` (ps).

        The positions are those of the start, of each edge and of the end; each level holds from one position to
        the next.  A band is given by the indices of the first and the last position in a group of dense edges.
        """
        import numpy as np

        start, stop = max(self.diagram.start, since), min(self.diagram.stop, until)
        inside = (signal.times_ps > start) & (signal.times_ps <= stop)
        times = np.concatenate([[start], signal.times_ps[inside], [stop]])
        level = signal.levels_at(np.array([start]))
        levels = np.concatenate([level, signal.levels[inside]]).astype(np.int64)
        places = self.scale(times)
        places[0] -= TAIL * (start == self.diagram.start)
        places[-1] += TAIL * (stop == self.diagram.stop)
        far = np.flatnonzero(np.diff(places[1:-1]) > DENSE)
        firsts, lasts = np.append(1, far + 2), np.append(far + 1, len(places) - 2)
        bands = [(a, b) for a, b in zip(firsts.tolist(), lasts.tolist(), strict=True) if b - a + 1 >= FEWEST]
        return places, levels, bands

    def _pin(self, lane: Lane, foot: float) -> None:
        trace = self.colours.trace
        self._levels(self._runs(lane.signal, -EVER, EVER), foot, trace, f"{trace}60")

    def _levels(self, runs: Runs, foot: float, color: str, band: str, **how: Any) -> None:
        """Draw levels and the edges between them, and bands where the edges are dense."""
        places, levels, bands = runs
        begin = 0
        for first, last in [*bands, (len(places) - 1, len(places) - 1)]:
            self._edges(places[begin : first + 1], levels[begin:first], foot, color, **how)
            if last > first:
                across = [places[first], places[last], places[last], places[first]]
                self.axes.fill(across, _box(foot), facecolor=band, edgecolor=color, linewidth=0.9, **how)
            begin = last

    def _edges(
        self, places: NDArray[np.float64], levels: NDArray[np.int64], foot: float, color: str, **how: Any
    ) -> None:
        """Draw levels as one line, with slanted edges or, if any level is narrow, with vertical edges only."""
        import numpy as np

        heights = foot + SWING * np.where(levels == FLOATING, 0.5, levels)
        wide = np.diff(places).min(initial=np.inf) >= LEVEL * self.slant
        half = self.slant / 2 if wide else 0.0
        across = np.concatenate([places[:1], np.stack([places[1:-1] - half, places[1:-1] + half], 1).ravel()])
        across = np.append(across, places[-1])
        self._line(across, np.repeat(heights, 2), color, **how)

    def _over(self, lane: Lane, trace: Trace, foot: float) -> None:
        """Draw a measured trace over a lane; shade the stretches in which the two differ, with a tick below each."""
        from matplotlib.collections import PolyCollection

        start, stop, alarm = self.diagram.start, self.diagram.stop, self.colours.alarm
        if min(stop, trace.until) <= max(start, trace.since):
            return
        ends = self.scale(marked(lane.signal, trace, start, stop)).tolist()
        shade, ticks = boxes(ends, foot, SWING), boxes(ends, foot - 2 * TICK, TICK)
        self.axes.add_collection(PolyCollection(shade, facecolor=f"{alarm}40", linewidth=0, zorder=0.5))
        gid = f"where {lane.pin} differs"
        self.axes.add_collection(PolyCollection(ticks, facecolor=alarm, edgecolor=alarm, linewidth=0.8, gid=gid))
        signal = SignalEdges(trace.times_ps, trace.levels, trace.level, trace.bus)
        runs = self._runs(signal, trace.since, trace.until)
        how: dict[str, Any] = {"linestyle": MEASURED, "zorder": 2.2, "gid": f"measured {lane.pin}"}
        if not trace.bus:
            self._levels(runs, foot, self.colours.measured, "none", **how)
            return
        places, levels, _ = runs
        for (a, b), level in zip(pairwise(places.tolist()), levels.tolist(), strict=True):
            low, high = (foot + SWING / 2,) * 2 if level == FLOATING else (foot, foot + SWING)
            self._line([a, a, b, b, a], [low, high, high, low, low], self.colours.measured, 0.9, **how)

    def _bus(self, lane: Lane, foot: float) -> None:
        """Draw hexagons with values, a line at mid-height where the bus floats, and bands where changes are dense."""
        places, levels, bands = self._runs(lane.signal, -EVER, EVER)
        hidden = {n for first, last in bands for n in range(first, last)}
        color = self.colours.bus
        times = [*lane.signal.times_ps[lane.signal.times_ps > self.diagram.start].tolist(), self.diagram.stop]
        for n, (a, b) in enumerate(pairwise(places.tolist())):
            if n in hidden:
                continue
            if levels[n] == FLOATING:
                self._line([a, b], [foot + SWING / 2] * 2, color)
                continue
            slant = min(self.slant, b - a) / 2
            left, right = (slant if n else 0), (slant if n + 2 < len(places) else 0)  # open at the ends of the window
            middle, across = foot + SWING / 2, [a, a + left, b - right, b]
            low, high = ([middle if left else y, y, y, middle if right else y] for y in (foot, foot + SWING))
            self.axes.fill_between(across, low, high, color=self.colours.byte, linewidth=0)
            for side in (low, high):
                self._line(across, side, color, 0.9)
            self._value(lane, int(levels[n]), times[n], a, b, foot)
        for first, last in bands:
            across = [places[first], places[last], places[last], places[first]]
            self.axes.fill(across, _box(foot), facecolor=f"{color}60", edgecolor=color, linewidth=0.9)

    def _value(self, lane: Lane, value: int, end: int, a: float, b: float, foot: float) -> None:
        """Write a bus value between `a` and `b`, with its meaning, as space permits; the value ends at `end` (ps)."""
        plain = f"{value:02X}"
        meant = lane.describe(value, end) if lane.describe else ""
        a, b = max(pairwise([a, *(at for at in self.centres if a < at < b), b]), key=lambda piece: piece[1] - piece[0])
        room = b - a - 0.04
        for text in (f"{plain} {meant}".rstrip(), plain):
            if len(text) * LETTER * SMALL < room:
                box = {"facecolor": self.colours.byte, "edgecolor": "none", "pad": 0.4}
                self._text((a + b) / 2, foot + SWING / 2 - 0.005, text, color=self.colours.bus, bbox=box, zorder=6)
                break
        if len(meant) > 3 and len(f"{plain} {meant}") * LETTER * SMALL >= room:
            box = {"facecolor": self.colours.ground, "edgecolor": "none", "pad": 0.2}
            self._text(a, foot + SWING + 0.06, meant, TINY, color=self.colours.bus, ha="left", bbox=box, zorder=6)

    def _words(self, lane: Lane, foot: float) -> None:
        """Write decoded characters above a serial line, each in a box as wide as the duration of the character."""
        for word in lane.words:
            a, b = self.scale([word.start, word.end]).tolist()
            a, b = max(a, self.scale.left - TAIL), min(b, self.scale.right + TAIL)
            if b - a < 0.03:
                continue
            color = self.colours.alarm if word.wrong else self.colours.bus
            tall = WORDS - 0.04
            across, up = [a + 0.005, b - 0.005, b - 0.005, a + 0.005], [foot, foot, foot + tall, foot + tall]
            self.axes.fill(across, up, facecolor=self.colours.byte, edgecolor=color, linewidth=0.6)
            if len(word.text) * LETTER * SMALL + 0.02 < b - a:
                self._text((a + b) / 2, foot + tall / 2, word.text, color=color)

    # ------------------------------------------------------------------------------------------------------------ time
    def _time(self) -> None:
        """Draw time ticks below the lanes or, if stretches are cut short, a time scale bar."""
        from matplotlib.ticker import MaxNLocator

        colours, scale, diagram = self.colours, self.scale, self.diagram
        top = self.layout.top + 0.08
        if not scale.cuts:
            axis = TimeAxis(diagram.start, diagram.stop)
            ends = axis.scaled([diagram.start, diagram.stop])
            ticks = MaxNLocator(max(int(scale.right - scale.left), 3), steps=[1, 2, 5, 10]).tick_values(*ends)
            for tick in ticks[(ticks >= ends[0] - 1e-9) & (ticks <= ends[1] + 1e-9)].tolist():
                place = scale.left + (tick - ends[0]) / (ends[1] - ends[0]) * (scale.right - scale.left)
                self._line([place] * 2, [BOTTOM - 0.02, top], colours.grid, 0.8, zorder=0)
                self._text(place, BOTTOM - 0.12, number(tick), color=colours.soft)
            self._text((scale.left + scale.right) / 2, 0.11, axis.label, size=LARGE, color=colours.soft)
            return
        piece = _round(int(scale.ps_per_inch))
        long = piece / scale.ps_per_inch
        a, y = scale.left, BOTTOM - 0.26
        self._line(
            [a, a, a, a + long, a + long, a + long], [y + d for d in (-0.03, 0.03, 0, 0, 0.03, -0.03)], colours.soft
        )
        room = int((scale.right + RIGHT - a - long - 0.1) / (LETTER * SMALL))
        short = f"{duration(piece)}; zigzag: time omitted"
        whole = f"{duration(piece)}; begins at {duration(diagram.start)}; a zigzag marks omitted time"
        note = next((text for text in (whole, short) if len(text) < room), duration(piece))
        self._text(a + long + 0.08, y, note, color=colours.soft, ha="left")

    def _cut(self, place: float, ps: int) -> None:
        """Draw a zigzag from top to bottom where a stretch is cut short, with the duration that is cut out (`ps`)."""
        import numpy as np

        top, foot = self.layout.top + 0.05, BOTTOM - 0.04
        count = max(int((top - foot) / 0.09), 2)
        up = np.linspace(foot, top, count)
        bend = np.where(np.arange(count) % 2, 0.025, -0.025)
        left, right = place - 0.03 + bend, place + 0.03 + bend
        self.axes.fill_betweenx(up, left, right, color=self.colours.ground, linewidth=0, zorder=3)
        for side in (left, right):
            self._line(side, up, self.colours.edge, 0.8, zorder=3)
        self._text(place, BOTTOM - 0.12, duration(rounded(ps, 3)), TINY, color=self.colours.soft)

    # ---------------------------------------------------------------------------------------------------------- arrows
    def _arrow(self, arrow: Arrow) -> None:
        """Draw a dimension line with its text, and thin lines up to the two edges."""
        colours, feet = self.colours, self.layout.feet
        kept = arrow.interval.kept
        color = colours.soft if kept is None else colours.home if kept else colours.alarm
        y = feet[arrow.under] - 0.13 - ROW * arrow.row
        for place, lane in zip((arrow.first, arrow.second), arrow.lanes, strict=True):
            self._line([place] * 2, [y - 0.05, feet[lane] + SWING / 2], color, 0.7, linestyle=(0, (2, 1.5)), zorder=4)
        how = {"arrowstyle": "<|-|>", "mutation_scale": 6, "color": color, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
        spans = [(arrow.first, arrow.second)]
        if arrow.beside:  # arrows from outside
            how["arrowstyle"] = "-|>"
            spans = [(arrow.first - 0.16, arrow.first), (arrow.second + 0.16, arrow.second)]
            self._line([arrow.first, arrow.second], [y, y], color, 0.9, zorder=4)
        for a, b in spans:
            self.axes.annotate("", (b, y), (a, y), arrowprops=how, zorder=5)
        box = {"facecolor": colours.ground, "edgecolor": "none", "pad": 0.8}
        align = {"right": "left", "left": "right"}.get(arrow.beside, "center")
        self._text(arrow.place, y, arrow.text, color=color, ha=align, bbox=box, zorder=6)

    def _cause(self, cause: Interval) -> None:
        """Draw a curved arrow from an edge to its effect."""
        first, second = (self.layout.feet[n] + SWING / 2 for n in lanes_of(cause, self.diagram.lanes))
        a, b = self.scale([cause.start_ps, cause.end_ps]).tolist()
        bent = f"arc3,rad={0.25 if first > second else -0.25}"
        how = {"arrowstyle": "-|>", "mutation_scale": 7, "color": self.colours.cursor, "connectionstyle": bent}
        how |= {"linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
        self.axes.annotate("", (b, second), (a, first), arrowprops=how, zorder=5)


def _box(foot: float) -> list[float]:
    return [foot, foot, foot + SWING, foot + SWING]


def _round(ps: int) -> int:
    """Return the longest of 1, 2, 5, 10, 20, 50 ... ps that is not longer than `ps`."""
    power = int(10 ** (len(str(ps)) - 1))
    return next(n * power for n in (5, 2, 1) if n * power <= ps)
