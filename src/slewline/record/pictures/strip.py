"""The picture of one parameter: which values hold, which fail, and the way of a search among them.

    holds   | | | |         | |    | | | | | | | |
    fails          | | | | |   | |                 value
                       1
                2                                  the search
    search     3
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..style import inches, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 1.3  # inches, of the strip
ROW = 0.21  # inches, of one value that was tried


@dataclass(frozen=True, slots=True)
class StripPicture:
    """Values of one parameter, ascending, whether each holds, and a search: the indices it tried, and its answer."""

    title: str
    name: str
    values: Sequence[float]
    holds: Sequence[bool]
    tried: Sequence[int] = ()
    answer: int | None = None

    @property
    def description(self) -> str:
        """What is to be seen, in words."""
        found = f"{sum(self.holds)} of {len(self.holds)} values of {self.name} hold."
        if self.answer is None:
            return found
        tried = ", ".join(f"{self.values[n]:.0f} {self._says(n)}" for n in self.tried)
        return f"{found} Tried: {tried}. Answer: {self.values[self.answer]:.0f}, which {self._says(self.answer)}."

    def _says(self, n: int) -> str:
        return "holds" if self.holds[n] else "fails"


def draw(picture: StripPicture, width: str | float = "page", dark: bool = False) -> Figure:
    """Return the picture as a matplotlib Figure.

    Args:
        width: "page", "phone", or inches.

    Raises:
        UsageError: a width that is none, or no matplotlib.
    """
    with styled(dark) as colours:
        from matplotlib.figure import Figure
        from matplotlib.patches import Patch

        rows = len(picture.tried) + (picture.answer is not None)
        figure = Figure(
            figsize=(inches(width), HEIGHT + ROW * rows + 0.5), facecolor=colours.ground, layout="constrained"
        )
        figure.suptitle(picture.title, fontsize=11, fontweight="bold", x=0.02, ha="left")
        axes = figure.subplots()
        values = [*picture.values]
        between = [(one * other) ** 0.5 for one, other in zip(values, values[1:], strict=False)]
        edges = [values[0] ** 1.5 / values[1] ** 0.5, *between, values[-1] ** 1.5 / values[-2] ** 0.5]
        shades = {True: f"{colours.home}90", False: f"{colours.alarm}a0"}
        for left, right, holds in zip(edges, edges[1:], picture.holds, strict=False):
            axes.axvspan(left, right, ymin=rows / (rows + 3), color=shades[holds], linewidth=0)
            axes.axvline(left, ymin=rows / (rows + 3), color=colours.ground, linewidth=1)
        steps = [(n, f"{number}. {'holds: faster' if picture.holds[n] else 'fails: slower'}")
                 for number, n in enumerate(picture.tried, 1)]  # fmt: skip
        if picture.answer is not None:
            says = "holds" if picture.holds[picture.answer] else "was never tried, and fails" if (
                picture.answer not in picture.tried) else "fails"  # fmt: skip
            steps.append((picture.answer, f"the answer: {values[picture.answer]:.0f} {says}"))
        for row, (n, text) in enumerate(steps):
            y = rows - row - 0.5
            last = row == rows - 1 and picture.answer is not None
            colour = colours.home if picture.holds[n] else colours.alarm
            axes.plot([values[n]] * 2, [y, rows], color=colours.dashed, linewidth=0.7, zorder=1)
            axes.plot(values[n], y, "D" if last else "o", color=colour, markersize=7 if last else 5)
            axes.annotate(
                text, (values[n], y), (9, 0), textcoords="offset points", va="center", fontsize=8,
                fontweight="bold" if last else "normal", color=colours.ink,
            )  # fmt: skip
        axes.set(xscale="log", xlim=(edges[0], edges[-1]), ylim=(0, rows + 3), xlabel=picture.name)
        axes.set_yticks([])
        axes.grid(False)
        figure.legend(
            handles=[Patch(facecolor=shades[True], label="holds"), Patch(facecolor=shades[False], label="fails")],
            ncols=2, loc="upper right", frameon=False, fontsize=8,
        )  # fmt: skip
        return figure
