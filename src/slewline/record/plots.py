"""Plots of moves: velocity, position and logic traces over one time axis, as SVG or PNG.

The same input gives the same bytes, whatever matplotlib's configuration says: no date, no chance in the names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.axis import Steps
from ..core.timebase import UNITS, readable
from ..errors import UsageError
from . import outlines
from .profiles import HEIGHTS, Profile, draw_profile
from .recorder import FLOATING, Probe, Recorder, width_of
from .whole_file import WholeFile

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from .recorder import Levels

SUFFIXES = (".svg", ".png")
VELOCITY, POSITION, TRACE, BUS, BYTE = "#1f66ad", "#b8561b", "#2b5d4c", "#6a4c93", "#efeaf5"
INK, SOFT, DASHED, ZERO, GRID = "#25303b", "#5f6b77", "#8a94a0", "#aab3bc", "#e4e8ec"
# inches
WIDTH, VELOCITY_HEIGHT, POSITION_HEIGHT, LANE_HEIGHT, GAP = 9.6, 2.5, 1.5, 0.27, 0.18
TOP, NOTES, BOTTOM, RIGHT, LEFT, LETTER = 0.46, 0.16, 0.52, 1.12, 0.92, 0.078
DPI = 144
THIN_SPACE, MINUS = "\u2009", "\u2212"
STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial"],
    "font.size": 9.0,
    "axes.edgecolor": ZERO,
    "axes.linewidth": 0.8,
    "axes.labelcolor": SOFT,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "text.color": INK,
    "xtick.color": ZERO,
    "ytick.color": ZERO,
    "xtick.labelcolor": SOFT,
    "ytick.labelcolor": SOFT,
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "slewline",
}


@dataclass(frozen=True, slots=True)
class Motion:
    """What one axis does: becomes a velocity and a position panel.

    `steps` may reach beyond the window.  `rates` are dashed lines, name -> steps/s ("R = 80" -> 5978); `notes` are
    further parameters, name -> value ("S" -> 200); `before` is the position before the first step, if that one did not
    change it by one.
    """

    name: str
    steps: Steps
    rates: Mapping[str, float] = field(default_factory=dict)
    notes: Mapping[str, object] = field(default_factory=dict)
    before: int | None = None


@dataclass(frozen=True, slots=True)
class Trace:
    """What one pin does: edges as Recorder.edges gives them, and the level before the first; a bus shows its bytes."""

    name: str
    times_ps: NDArray[np.int64]
    levels: Levels
    level: int
    bus: bool = False

    @classmethod
    def of(cls, name: str, probe: Probe, recorder: Recorder, start: int, stop: int) -> Trace:
        """The trace of a recorded net or pin in a window (ps)."""
        times, levels = recorder.edges(probe, start + 1, stop)
        return cls(name, times, levels, recorder.level_at(probe, start), width_of(probe) > 1)


def plot(path: str | Path, title: str, *tracks: Motion | Profile | Trace, start: int, stop: int) -> None:
    """Draw motions and traces of a window (ps) into a file; its suffix, .svg or .png, says in which form.

    Raises:
        UsageError: an unknown suffix, an empty window, no tracks, a path that cannot be written, or no matplotlib.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise UsageError(f"{path}: allowed are file names ending in {' or '.join(SUFFIXES)}")
    if stop <= start or not tracks:
        raise UsageError(f"{path}: nothing to draw from {readable(start)} to {readable(stop)}")
    with _matplotlib(), WholeFile(path) as file, file.refusals():
        figure = _figure(title, tracks, start, stop)
        metadata: dict[str, Any] = {"Date": None} if suffix == ".svg" else {"Software": "slewline"}
        figure.savefig(file.handle, format=suffix[1:], dpi=DPI, metadata=metadata)


@contextmanager
def _matplotlib() -> Iterator[None]:
    """Our style, and nothing of what the user's configuration says."""
    try:
        import matplotlib
    except ImportError as error:
        raise UsageError("plots need matplotlib: pip install slewline[plot]") from error
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        yield


# ------------------------------------------------------------------------------------------------------ the figure
def _figure(title: str, tracks: Sequence[Motion | Profile | Trace], start: int, stop: int) -> Figure:
    motions = [track for track in tracks if not isinstance(track, Trace)]
    traces = [track for track in tracks if isinstance(track, Trace)]
    axis = TimeAxis(start, stop)
    figure, panels = _panels(title, motions, traces)
    left = iter(panels)
    for motion in motions:
        own = [next(left) for _ in _heights(motion)]
        if isinstance(motion, Profile):
            draw_profile(own, motion, axis.scaled, several=len(motions) > 1)
        else:
            _draw_motion(own[0], own[1], motion, axis, several=len(motions) > 1)
    if traces:
        _draw_traces(panels[-1], traces, axis)
    for panel in panels:
        panel.tick_params(length=0, labelbottom=panel is panels[-1])
        panel.spines["bottom"].set_visible(panel is panels[-1])
    panels[-1].set_xlim(*axis.scaled([start, stop]))
    panels[-1].set_xlabel(axis.label)
    return figure


def _heights(motion: Motion | Profile) -> tuple[float, ...]:
    """Heights of the panels that a motion takes."""
    return HEIGHTS if isinstance(motion, Profile) else (VELOCITY_HEIGHT, POSITION_HEIGHT)


def _panels(title: str, motions: Sequence[Motion | Profile], traces: Sequence[Trace]) -> tuple[Figure, list[Axes]]:
    """An empty figure with the panels of each motion, then one for all traces."""
    from matplotlib.figure import Figure

    sizes: list[tuple[float, float]] = []  # the space above a panel, and its height
    for motion in motions:
        above = motion.notes or (isinstance(motion, Profile) and motion.spans)
        first, *others = _heights(motion)
        sizes += [((GAP if sizes else TOP) + (NOTES if above else 0), first), *((GAP, height) for height in others)]
    if traces:
        sizes.append((GAP if sizes else TOP, LANE_HEIGHT * len(traces) + 0.08))
    height = sum(space + size for space, size in sizes) + BOTTOM
    left = max(LEFT, 0.3 + LETTER * max((len(trace.name) for trace in traces), default=0))
    right = RIGHT if any(motion.rates for motion in motions) else 0.3
    figure = Figure(figsize=(WIDTH, height), facecolor="white")
    figure.text(left / WIDTH, 1 - 0.16 / height, title, fontsize=12, fontweight="bold", va="top")
    panels: list[Axes] = []
    below = height
    for space, size in sizes:
        below -= space + size
        box = (left / WIDTH, below / height, (WIDTH - left - right) / WIDTH, size / height)
        panels.append(figure.add_axes(box, sharex=panels[0] if panels else None))
    return figure, panels


class TimeAxis:
    """The shared axis: a unit that suits the window; far from time 0 it counts from the begin of the window."""

    def __init__(self, start: int, stop: int) -> None:
        self.start, self.stop = start, stop
        span = stop - start
        name = next((unit for unit in ("s", "ms", "us", "ns") if span >= 2 * UNITS[unit]), "ps")
        self.unit = UNITS[name]
        self.origin = start if start > 10 * span else 0
        self.label = f"Time in {name}".replace("us", "µs") + (f", from {readable(start)} on" if self.origin else "")

    def scaled(self, times: Any) -> NDArray[np.float64]:
        """Instants (ps) in units of the axis, shape as given."""
        import numpy as np

        return (np.asarray(times, np.int64) - self.origin) / self.unit


# ------------------------------------------------------------------------------------------------------- its panels
def _draw_motion(upper: Axes, lower: Axes, motion: Motion, axis: TimeAxis, *, several: bool) -> None:
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    steps, of = motion.steps, f"{motion.name}: " if several else ""
    at, speed = outlines.velocity(steps, axis.start, axis.stop)
    times = axis.scaled(at)
    upper.fill_between(times, speed, step="post", color=VELOCITY, alpha=0.10, linewidth=0)
    upper.plot(times, speed, color=VELOCITY, linewidth=1.5, drawstyle="steps-post", solid_joinstyle="miter")
    upper.set_ylabel(f"{of}Velocity in steps/s")
    top = max([float(speed.max()), *(motion.rates.values() if speed.max() > 0 else ())])
    bottom = min([float(speed.min()), *(-rate for rate in motion.rates.values() if speed.min() < 0)])
    room = 0.08 * (top - bottom) or 1.0
    upper.axhline(0, color=ZERO, linewidth=0.8, zorder=1)
    upper.set_ylim(bottom - (room if bottom < 0 else room / 3), top + (room if top > 0 else room / 3))
    _draw_rates(upper, motion.rates, top, bottom)
    if motion.notes:
        text = "    ".join(f"{name} = {value}" for name, value in motion.notes.items())
        upper.annotate(text, (1, 1), (0, 8), "axes fraction", textcoords="offset points", ha="right", color=SOFT)

    at, where = outlines.position(*_inside(motion, axis), axis.start, axis.stop)
    lower.plot(axis.scaled(at), where, color=POSITION, linewidth=1.5, solid_joinstyle="miter")
    lower.set_ylabel(f"{of}Position in steps")
    lower.margins(y=0.08)
    for panel in (upper, lower):
        panel.yaxis.set_major_locator(MaxNLocator(6, integer=True, steps=[1, 2, 5, 10]))
        panel.yaxis.set_major_formatter(FuncFormatter(lambda number, _: _grouped(number)))


def _inside(motion: Motion, axis: TimeAxis) -> tuple[Steps, int]:
    """The steps inside the window, and the position before them."""
    import numpy as np

    steps = motion.steps
    first = int(np.searchsorted(steps.times_ps, axis.start))
    window = slice(first, int(np.searchsorted(steps.times_ps, axis.stop, side="right")))
    before = motion.before or 0
    if first:
        before = int(steps.positions[first - 1])
    elif motion.before is None and len(steps):
        before = int(steps.positions[0] - steps.directions[0])
    return Steps(steps.times_ps[window], steps.directions[window], steps.positions[window]), before


def _grouped(number: float) -> str:
    """12345 as 12 345."""
    return f"{number:,.10g}".replace(",", THIN_SPACE).replace("-", MINUS)


def _draw_rates(panel: Axes, rates: Mapping[str, float], top: float, bottom: float) -> None:
    """Dashed lines at the rates, their names beside the panel, moved apart where they would meet."""
    low, high = panel.get_ylim()
    apart = (high - low) * 0.30 / VELOCITY_HEIGHT
    place = low - apart
    for name, rate in sorted(rates.items(), key=lambda named: named[1] if top > 0 else -named[1]):
        shown = [signed for signed in (rate, -rate) if bottom <= signed <= top]
        for signed in shown:
            panel.axhline(signed, color=DASHED, linewidth=0.9, dashes=(4, 3), zorder=1)
        if shown:
            place = max(shown[0], place + apart)
            text, at = f"{name}\n{_grouped(float(f'{rate:.4g}'))} steps/s", ("axes fraction", "data")
            panel.annotate(text, (1, place), (6, 0), at, "offset points", va="center", fontsize=8, color=SOFT)


def _draw_traces(panel: Axes, traces: Sequence[Trace], axis: TimeAxis) -> None:
    for row, trace in enumerate(traces):
        base = len(traces) - 1 - row + 0.2
        (at, levels), bands = outlines.logic(trace.times_ps, trace.levels, trace.level, axis.start, axis.stop)
        color = BUS if trace.bus else TRACE
        if trace.bus:
            _draw_bus(panel, axis.scaled(at), levels, base)
        else:
            _draw_line(panel, axis.scaled(at), levels, base)
        for begin, end in axis.scaled(bands):
            across, up = [begin, end, end, begin], [base, base, base + 0.6, base + 0.6]
            panel.fill(across, up, facecolor=f"{color}60", edgecolor=color, linewidth=0.9)
    panel.set_ylim(-0.1, len(traces) + 0.1)
    panel.set_yticks([len(traces) - 0.5 - row for row in range(len(traces))], [trace.name for trace in traces])
    panel.tick_params(axis="y", labelcolor=INK, labelsize=8.5)
    panel.grid(axis="y", visible=False)
    panel.spines["left"].set_visible(False)


def _draw_line(panel: Axes, times: NDArray[np.float64], levels: NDArray[np.float64], base: float) -> None:
    import numpy as np

    heights = base + 0.6 * np.where(levels == FLOATING, 0.5, levels)
    panel.plot(times, heights, color=TRACE, linewidth=1.1, drawstyle="steps-post", solid_joinstyle="miter")
    for number in np.flatnonzero(levels[:-1] == FLOATING):
        panel.plot(times[number : number + 2], [base + 0.3] * 2, color="white", linewidth=1.3, dashes=(2, 2))


def _draw_bus(panel: Axes, times: NDArray[np.float64], levels: NDArray[np.float64], base: float) -> None:
    """Boxes with their bytes, as far as these have room; a line in the middle while nothing drives."""
    span = times[-1] - times[0]
    for begin, end, level in zip(times[:-1], times[1:], levels[:-1], strict=True):
        if level == FLOATING:
            panel.plot([begin, end], [base + 0.3] * 2, color=BUS, linewidth=0.9)
        elif level == level and end > begin:  # not inside a band, where the level is NaN
            slant = min(0.002 * span, (end - begin) / 2)
            across = [begin, begin + slant, end - slant, end, end - slant, begin + slant]
            up = [base + 0.3, base + 0.6, base + 0.6, base + 0.3, base, base]
            panel.fill(across, up, facecolor=BYTE, edgecolor=BUS, linewidth=0.9)
            if end - begin > 0.03 * span:
                text = f"{int(level):02X}"
                panel.text((begin + end) / 2, base + 0.27, text, ha="center", va="center", fontsize=7.5, color=BUS)
