r"""Figures: the motions of axes in one column of panels, with their pins below, over a common time axis.

title                                                  a `Paper` measures all of it in inches, so that pictures
slope S = 240, number N = 700      (notes)              look the same with any number of panels
── x   ╌╌ y                        (legend)
▾ G            ▾ limit             (flags)
 1  2  3                           (phases)
Velocity, steps/s
|  ________                    R = 80, 5 978 steps/s
|_/        \_______
... further panels, lanes of pins, time
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from ...errors import UsageError
from ..measuring import overlay
from ..recording.traces import Trace
from ..style import DASHES, Palette, TimeAxis, duration, inches, number, palette, styled
from . import lanes, marks, panels, rate_lines
from .tracks import Track, TrackCurve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# inches
HEIGHTS = {"velocity": 2.3, "position": 1.45}
OTHER_HEIGHT, STILL = 1.15, 0.7  # STILL: of constant zero velocities
GAP, HEADING, EDGE, BOTTOM, LINE, LETTER = 0.10, 0.27, 0.16, 0.50, 0.165, 0.0665
MARGIN = 0.006  # fraction of the window left free at each end
LEFT, MAX_LEFT, NARROW_LEFT, BESIDE = 0.92, 1.4, 0.62, 0.1
NARROW = 6.0  # a narrower picture has less space next to its panels


@dataclass(frozen=True, slots=True)
class Contents:
    """The contents of a picture: tracks and traces from `start` to `stop` (ps, in the time of the picture)."""

    title: str
    tracks: Sequence[Track]
    traces: Sequence[Trace]
    start: int
    stop: int
    notes: Sequence[str] = ()
    cursors: Sequence[int] = ()
    zero_is: str = ""  # the meaning of instant 0, if it is not that of the bench
    marks: bool = True


@cache
def _picture_class() -> type[Figure]:
    from matplotlib.figure import Figure

    class Picture(Figure):
        """A figure that is drawn in the style of slewline, regardless of the current matplotlib configuration."""

        dark = False
        description = ""

        def draw(self, renderer: Any) -> None:
            with styled(self.dark):
                super().draw(renderer)

        def _repr_png_(self) -> bytes:
            """Return the picture as PNG for a notebook."""
            from io import BytesIO

            buffer = BytesIO()
            self.savefig(buffer, format="png", dpi=120, facecolor=self.get_facecolor())
            return buffer.getvalue()

    return Picture


def new_picture(width: float, height: float, dark: bool = False) -> Figure:
    """Return an empty figure of the given size (inches) in the style of slewline; call this within `styled`."""
    picture = _picture_class()(figsize=(width, height), facecolor=palette(dark).ground)
    picture.dark = dark  # type: ignore[attr-defined]
    return picture


# ------------------------------------------------------------------------------------------------------------- layout
class Paper:
    """A figure on which positions are in inches: x to the right and y down from the upper left corner."""

    def __init__(self, width: float, height: float, dark: bool) -> None:
        self.width, self.height = width, height
        self.figure = new_picture(width, height, dark)

    def text(self, x: float, y: float, text: str, **style: Any) -> None:
        """Write text with its upper left corner at (x, y)."""
        self.figure.text(x / self.width, 1 - y / self.height, text, va="top", **style)

    def line(self, x: float, y: float, length: float, **style: Any) -> None:
        """Draw a horizontal line of the given length (inches) from (x, y) to the right."""
        from matplotlib.lines import Line2D

        ends, up = [x / self.width, (x + length) / self.width], 1 - y / self.height
        self.figure.add_artist(Line2D(ends, [up, up], transform=self.figure.transFigure, **style))

    def panel(self, x: float, y: float, width: float, height: float, first: Axes | None) -> Axes:
        """Return a panel with its upper left corner at (x, y), sharing the time axis of panel `first`, if any."""
        box = (x / self.width, 1 - (y + height) / self.height, width / self.width, height / self.height)
        return self.figure.add_axes(box, sharex=first)


@dataclass(frozen=True, slots=True)
class Panel:
    """A panel to be drawn: its curves (none if it shows pins), heading, height and room above (inches)."""

    curves: Sequence[TrackCurve]
    heading: str
    height: float
    above: float


class FigureLayout:
    """The positions of all elements in a picture."""

    def __init__(self, contents: Contents, width: float) -> None:
        self.contents, self.width = contents, width
        self.narrow = width < NARROW
        self.axis = TimeAxis(contents.start, contents.stop, 0 if contents.zero_is else None, contents.zero_is)
        self.names = self._names()
        self.left = NARROW_LEFT if self.narrow else max(LEFT, BESIDE + LETTER * self._longest_name())
        self.right = 0.2 if self.narrow else max(0.2, 0.14 + 0.0615 * self._longest_rate())
        self.across = width - self.left - self.right
        curves = panels.curves_of(contents.tracks, self.axis, panels.columns_of(self.across))
        self.flags = marks.flags_of(contents.tracks, self.axis, self.across) if contents.marks else []
        self.phases = marks.phases_of(contents.tracks, self.axis, self.across) if curves else []
        letters = int((width - 2 * EDGE) / LETTER)
        pins = ((trace.name, trace, trace.over) for trace in contents.traces)
        self.compared = overlay.differences(pins, contents.start, contents.stop)
        self.notes = [line for note in (*contents.notes, *self.compared) for line in wrap(note, letters)]
        self.title = wrap(contents.title, int((width - 2 * EDGE) / 0.1)) or [""]
        self.named = panels.named_by_legend(contents.tracks, curves)
        self.legend = self._legend()
        self.panels = self._panels(curves)

    def _longest_rate(self) -> int:
        """Return the number of letters in the longest rate label; names with equal rates share one label."""
        named: dict[float, list[str]] = {}
        in_force = ((track, rates) for track in self.contents.tracks for _, rates in track.rates())
        for track, rates in {id(rates): (track, rates) for track, rates in in_force}.values():  # motions may share them
            for name, rate in rates.items():
                if (called := track.called(name)) not in named.setdefault(-rate, []):
                    named[-rate].append(called)
        return max((len(rate_lines.rate_text(names, rate)) for rate, names in named.items()), default=0)

    def _names(self) -> list[str] | None:
        """Return the pin names, wrapped to fit next to their lanes; None if any of them does not fit there."""
        least, most = (NARROW_LEFT, NARROW_LEFT) if self.narrow else (LEFT, MAX_LEFT)
        for letters in range(int((least - BESIDE) / LETTER), int((most - BESIDE) / LETTER) + 1):
            names = [lanes.wrapped(trace.name, letters) for trace in self.contents.traces]
            if None not in names:
                return [name for name in names if name is not None]
        return None

    def _longest_name(self) -> int:
        """Return the number of letters in the longest line of the pin names."""
        return max((len(line) for name in self.names or () for line in name.split("\n")), default=0)

    def _legend(self) -> list[list[tuple[float, int, str]]]:
        """Return rows of legend entries, each with its position (inches from the left), track number and name."""
        rows: list[list[tuple[float, int, str]]] = []
        at = self.width
        for index in self.named:
            track = self.contents.tracks[index]
            need = 0.55 + LETTER * len(track.name)
            if at + need > self.width - EDGE:
                rows.append([])
                at = EDGE
            rows[-1].append((at, index, track.name))
            at += need
        return rows

    def _panels(self, groups: Sequence[Sequence[TrackCurve]]) -> list[Panel]:
        found: list[Panel] = []
        on_top = marks.FLAG_ROW * marks.rows_of(self.flags) + (marks.PHASE_ROW if self.phases else 0)
        kinds = [group[0].quantity.name for group in groups]
        for group, kind in zip(groups, kinds, strict=True):
            several = kinds.count(kind) > 1
            alone = group[0].track.part and group[0].number not in self.named
            tall = STILL if panels.still(group) else HEIGHTS.get(kind, OTHER_HEIGHT)
            height = tall * (0.7 if several else 1) * (0.85 if self.narrow else 1)
            above = HEADING + (GAP if found else on_top)
            found.append(Panel(group, panels.heading(group, several or alone), height, above))
        if self.contents.traces:
            lane = lanes.LANE if self.names is not None else lanes.NAMED_LANE
            height = lane * len(self.contents.traces) + 0.04
            found.append(Panel((), "", height, GAP + 0.06 if found else HEADING + on_top))
        return found

    @property
    def head(self) -> float:
        """The height of title, notes and legend together, inches."""
        return EDGE + 0.23 * len(self.title) + LINE * (len(self.notes) + len(self.legend)) + 0.04 * bool(self.legend)

    @property
    def height(self) -> float:
        """The height of the whole picture, inches."""
        return self.head + sum(panel.above + panel.height for panel in self.panels) + BOTTOM


# ------------------------------------------------------------------------------------------------------------ drawing
def figure(
    contents: Contents, *, width: str | float = "page", dark: bool = False, ax: Axes | Sequence[Axes] | None = None
) -> Figure:
    """Return a new picture; if `ax` is given, draw into these axes instead, and return their figure.

    `ax` is either a sequence of `Axes`, one for each panel, or a single `Axes`, which shows only the first
    panel.

    Raises:
        UsageError: no matplotlib, an invalid width, an empty window, nothing to show, or a wrong number of
            axes.
    """
    if contents.stop <= contents.start or not (contents.tracks or contents.traces):
        raise UsageError(f"{contents.title}: nothing to draw: the picture spans no time, or has no axis and no pin")
    size = inches(width)
    with styled(dark) as colours:
        layout = FigureLayout(contents, size)
        if ax is not None:
            return _draw_into(layout, ax, colours)
        paper = Paper(size, layout.height, dark)
        curves = [panel.curves for panel in layout.panels]
        described = [_described(contents, curves), *(f"{line}." for line in layout.compared)]
        paper.figure.description = " ".join(described)  # type: ignore[attr-defined]
        _write_head(paper, layout, colours)
        _draw(_make_panels(paper, layout, colours), layout, colours, whole=True)
        return paper.figure


def _write_head(paper: Paper, layout: FigureLayout, colours: Palette) -> None:
    y = EDGE
    for line in layout.title:
        paper.text(EDGE, y, line, fontsize=12, fontweight="bold", color=colours.ink)
        y += 0.23
    for line in layout.notes:
        paper.text(EDGE, y, line, fontsize=8.5, color=colours.soft)
        y += LINE
    for row in layout.legend:
        y += 0.04 * (row is layout.legend[0])
        for x, index, name in row:
            color, dashes = colours.series[index % len(colours.series)], DASHES[index % len(DASHES)]
            paper.line(x, y + 0.075, 0.3, color=color, linestyle=dashes, linewidth=1.8)
            paper.text(x + 0.37, y, name, fontsize=8.5, color=colours.ink)
        y += LINE


def _make_panels(paper: Paper, layout: FigureLayout, colours: Palette) -> list[Axes]:
    made: list[Axes] = []
    y = layout.head
    for panel in layout.panels:
        y += panel.above
        made.append(paper.panel(layout.left, y, layout.across, panel.height, made[0] if made else None))
        y += panel.height
        last = panel is layout.panels[-1]
        made[-1].tick_params(length=0, labelbottom=last, labelsize=8.5 if not layout.narrow else 8)
        made[-1].spines["bottom"].set_visible(last)
        if not last:
            made[-1].xaxis.set_visible(False)
            made[-1].add_collection(panels.time_grid(colours), autolim=False)
        if panel.heading:
            above = (panel.above - HEADING - (GAP if len(made) > 1 else 0) + 0.08) * 72
            made[-1].set_title(
                panel.heading, loc="left", fontsize=9, color=colours.ink, pad=above, y=1.0,
                x=-(layout.left - EDGE) / layout.across,
            )  # fmt: skip
    return made


def _draw_into(layout: FigureLayout, ax: Any, colours: Palette) -> Figure:
    """Draw into the caller's axes, and return their figure."""
    import numpy as np
    from matplotlib.axes import Axes

    given = list(np.atleast_1d(ax).ravel())
    if odd := [each for each in given if not isinstance(each, Axes)]:
        raise UsageError(f"ax: {odd[0]!r}; expected matplotlib axes, such as those of plt.subplots()")
    wanted = [panel.heading or "pins" for panel in layout.panels]
    if len(given) not in (1, len(wanted)):
        raise UsageError(
            f"ax: {len(given)} axes; this picture needs 1, or {len(wanted)} for its panels: {'; '.join(wanted)}"
        )
    for axes, panel in zip(given, layout.panels, strict=False):
        if panel.heading:
            axes.set_ylabel(panel.heading)
    _draw(given, layout, colours, whole=False)
    return given[0].figure  # type: ignore[no-any-return]


def _draw(made: Sequence[Axes], layout: FigureLayout, colours: Palette, whole: bool) -> None:
    """Draw all panels into the axes `made`, or only the first panel if `made` has only one element.

    `whole` is False if the axes are the caller's.
    """
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    contents, axis = layout.contents, layout.axis
    beside = whole and not layout.narrow
    for axes, panel in zip(made, layout.panels, strict=False):
        if panel.curves:
            panels.draw_curves(axes, panel.curves, axis, colours, panel.height, layout.named, beside)
            if panel.curves[0].quantity.name == "velocity":
                rate_lines.draw_rates(axes, panel.curves, axis, colours, panel.height, beside)
            if any(curve.track.ideals for curve in panel.curves):
                panels.draw_ideals(axes, panel.curves, axis, colours)
        else:
            lanes.draw_lanes(axes, contents.traces, axis, colours, layout.names)
    curved = [axes for axes, panel in zip(made, layout.panels, strict=False) if panel.curves]
    if curved and layout.phases:
        marks.draw_phases(curved, layout.phases, axis, colours, layout.across)
    if layout.flags:
        marks.draw_flags(made, layout.flags, colours, marks.PHASE_ROW if layout.phases else 0.0)
    marks.draw_cursors(made, contents.cursors, axis, colours)
    if layout.named and not whole:
        made[0].legend(fontsize=8, frameon=False)
    last = made[-1]
    first, end = axis.scaled([axis.start, axis.stop])
    last.set_xlim(first - MARGIN * (end - first), end + MARGIN * (end - first))
    last.set_xlabel(axis.label)
    last.xaxis.set_major_locator(MaxNLocator(max(3, round(layout.across / 0.9)), steps=[1, 2, 5, 10]))
    last.xaxis.set_major_formatter(FuncFormatter(lambda value, _: number(round(value, 9))))


# -------------------------------------------------------------------------------------------------------- description
def description_of(picture: Figure) -> str:
    """Return the description of a picture, for readers who cannot see it: a sentence or two.

    Return "" if the picture has no description.
    """
    return str(getattr(picture, "description", ""))


def _described(contents: Contents, curves: Sequence[Sequence[TrackCurve]]) -> str:
    sentences = [f"{contents.title}, from {duration(contents.start)} to {duration(contents.stop)}."]
    for track in contents.tracks:
        own = [curve for group in curves for curve in group if curve.track is track]
        start, stop = contents.start + track.zero, contents.stop + track.zero
        begun = sum(start <= motion.time_ps <= stop for motion in track.motions)
        notes = [f"{begun} motion{'s' * (begun != 1)}"] if track.motions else []
        notes += [_reach_of(curve) for curve in own if track.part or curve.quantity.name in ("velocity", "position")]
        sentences.append(f"{track.name}: {', '.join(notes)}.")
    if contents.traces:
        sentences.append(f"Pins: {', '.join(trace.name for trace in contents.traces)}.")
    return " ".join(sentences)


def _reach_of(curve: TrackCurve) -> str:
    low, high = (number(value, 6) for value in (curve.ends if curve.track.part else curve.reach))
    what, unit = curve.quantity.name, curve.quantity.unit
    return f"{what} {low} {unit}" if low == high else f"{what} from {low} to {high} {unit}"
