r"""The picture of a tuned ramp: the results in the grid, torque and its limit, and the lag of the rotor.

    v |. . x x        T |\_ pull-out       lag |    _
      |. * x x          | o\_               |  _/ \_ _
      |_______ a        |_o___\__ rate      |_/_____v__ time

The torque curve is only a guide; the points in the grid were simulated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..style import Palette, TimeAxis, grouped, inches, styled

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

HOLDS, FAILS, FAILS_NOMINALLY, REFUSED = range(4)
OUTCOMES = ("holds", "fails when perturbed", "fails unperturbed", "refused by the chip")
PANEL = 2.7  # inches
ROW = 0.19  # inches, of a line in the legend
MOST_CELLS = 500  # with room for a number
CAPTION = "Every move was simulated; some lose steps although they are far below the curve."


@dataclass(frozen=True, slots=True)
class GridMap:
    """A map over two parameters: for each cell (row, column), its outcome and its cause of failure (0 for none)."""

    names: tuple[str, str]
    columns: Sequence[object]
    rows: Sequence[object]
    states: Sequence[Sequence[int]]
    killed: Sequence[Sequence[int]]
    killers: Sequence[str]
    chosen: tuple[int, int] | None
    note: str = ""


@dataclass(frozen=True, slots=True)
class Demand:
    """The torque that a ramp demands: rates, (n,) steps/s, and torques, (n,) N m, one point per step."""

    name: str
    rates: NDArray[np.float64]
    torques: NDArray[np.float64]
    fails: bool = False


@dataclass(frozen=True, slots=True)
class TorqueCurve:
    """The pull-out torque of a motor as a function of the step rate, and its range under perturbations.

    Attributes:
        rates: the step rates, (n,) steps/s.
        torques: the pull-out torque at each rate, (n,) N m.
        least, most: the lowest and the highest pull-out torque under perturbations at each rate, (n,) N m.
        resonance: the resonance frequency, Hz.
        demands: the torques that ramps demand.
    """

    rates: NDArray[np.float64]
    torques: NDArray[np.float64]
    least: NDArray[np.float64]
    most: NDArray[np.float64]
    resonance: float
    demands: Sequence[Demand]


@dataclass(frozen=True, slots=True)
class LagCurve:
    """The lag of a rotor, relative to its command: instants, (n,) int64 ps, and lags, (n,) full steps."""

    name: str
    times_ps: NDArray[np.int64]
    lag: NDArray[np.float64]
    limit: float


@dataclass(frozen=True, slots=True)
class TuningPicture:
    """All elements of the picture; `grid` is None if the grid has only one cell."""

    title: str
    grid: GridMap | None
    curve: TorqueCurve
    lag: LagCurve

    @property
    def description(self) -> str:
        """A description of the picture as text."""
        found = []
        if self.grid is not None:
            states = [state for row in self.grid.states for state in row]
            counts = ", ".join(f'{states.count(n)} "{OUTCOMES[n]}"' for n in range(len(OUTCOMES)) if n in states)
            found.append(f"Map of {' and '.join(filter(None, self.grid.names))}: {counts}.")
        names = " and ".join(each.name for each in self.curve.demands)
        found.append(
            f"Pull-out torque over the rate, with the demand of {names}; resonance {self.curve.resonance:.0f} Hz."
        )
        worst = float(abs(self.lag.lag).max())
        found.append(f"Lag of {self.lag.name} over time, {worst:.2f} full steps at most.")
        return " ".join(found)


def draw(picture: TuningPicture, width: str | float = "page", dark: bool = False) -> Figure:
    """Return the picture as a matplotlib Figure.

    Args:
        width: "page", "phone", or inches.

    Raises:
        UsageError: an invalid width, or no matplotlib.
    """
    with styled(dark) as colours:
        from matplotlib.figure import Figure

        page = inches(width)
        panels: list[tuple[Any, Any]] = [] if picture.grid is None else [(_map, picture.grid)]
        panels += [(_curve, picture.curve), (_lag, picture.lag)]
        more = 0.0 if picture.grid is None else ROW * len(picture.grid.killers)
        figure = Figure(
            figsize=(page, PANEL * len(panels) + more + 0.5), facecolor=colours.ground, layout="constrained"
        )
        figure.suptitle(picture.title, fontsize=11, fontweight="bold", x=0.02, ha="left")
        heights = [PANEL + more * (draws is _map) for draws, _ in panels]
        for axes, (draws, data) in zip(
            figure.subplots(len(panels), 1, squeeze=False, height_ratios=heights)[:, 0], panels, strict=True
        ):
            draws(axes, data, colours)
        return figure


def _map(axes: Axes, grid: GridMap, colours: Palette) -> None:
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    shades = [f"{colours.home}90", f"{colours.alarm}30", f"{colours.alarm}a0", colours.band]
    axes.pcolormesh(
        grid.states, cmap=ListedColormap(shades), vmin=-0.5, vmax=3.5, edgecolors=colours.ground, linewidth=1
    )
    for labels, of in ((axes.set_xticks, grid.columns), (axes.set_yticks, grid.rows)):
        every = max(len(of) // 16, 1)
        labels([n + 0.5 for n in range(len(of))][::every], [grouped(each) for each in of][::every])
    axes.set(xlabel=grid.names[0], ylabel=grid.names[1])
    axes.grid(False)
    if len(grid.columns) * len(grid.rows) <= MOST_CELLS:
        for y, row in enumerate(grid.killed):
            for x, number in enumerate(row):
                if number:
                    axes.text(x + 0.5, y + 0.5, str(number), fontsize=7, ha="center", va="center", color=colours.ink)
    if grid.chosen is not None:
        x, y = grid.chosen
        axes.plot([x, x + 1, x + 1, x, x], [y, y, y + 1, y + 1, y], color=colours.ink, linewidth=2, gid="chosen")
    seen = {state for row in grid.states for state in row}
    patches = [Patch(facecolor=shades[n], label=OUTCOMES[n]) for n in range(len(OUTCOMES)) if n in seen]
    axes.legend(
        handles=patches, ncols=len(patches), loc="lower right", bbox_to_anchor=(1, 1), frameon=False, fontsize=8
    )
    axes.set_title(grid.note, loc="left", fontsize=8, color=colours.soft)
    lines = [f"{number} {name}" for number, name in enumerate(grid.killers, 1)]
    axes.annotate(
        "\n".join(lines), (0, 0), (0, -34), "axes fraction", textcoords="offset points", va="top", fontsize=8,
        color=colours.soft,
    )  # fmt: skip


def _curve(axes: Axes, curve: TorqueCurve, colours: Palette) -> None:
    axes.axvspan(0.6 * curve.resonance, 1.2 * curve.resonance, color=colours.band, label="around the resonance")
    axes.axvline(curve.resonance, color=colours.dashed, linewidth=0.9, linestyle="dashed")
    series = colours.series
    axes.fill_between(curve.rates, curve.least, curve.most, color=f"{series[0]}30", linewidth=0)
    axes.plot(curve.rates, curve.torques, color=series[0], label="pull-out; shaded: its range with perturbations")
    for demand in curve.demands:
        colour = colours.alarm if demand.fails else series[1]
        axes.plot(
            demand.rates, demand.torques, "x" if demand.fails else ".", color=colour, markersize=4, label=demand.name
        )
    axes.set(xlabel="Full steps/s", ylabel="N m")
    axes.set_xlim(left=0)
    axes.set_title(CAPTION, loc="left", fontsize=8, color=colours.soft)
    axes.legend(frameon=False, fontsize=8)


def _lag(axes: Axes, lag: LagCurve, colours: Palette) -> None:
    axis = TimeAxis(int(lag.times_ps[0]), int(lag.times_ps[-1]))
    axes.plot(axis.scaled(lag.times_ps), lag.lag, color=colours.series[0], linewidth=1)
    for limit in (lag.limit, -lag.limit):
        axes.axhline(limit, color=colours.dashed, linewidth=0.9, linestyle="dashed")
    axes.set(xlabel=axis.label, ylabel="Lag, full steps")
    axes.set_title(f"{lag.name}; dashed: limit of {lag.limit:g} steps", loc="left", fontsize=8, color=colours.soft)
