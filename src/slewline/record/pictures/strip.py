"""The picture of one parameter: the values that hold or fail, and the path of a search among them.

holds   | | | |         | |    | | | | | | | |
fails          | | | | |   | |                 value
                   1
            2                                  the search
search     3
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import log10, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

from ..style import grouped, inches, styled
from ..whole_file import check_suffix
from .picture_files import SUFFIXES, save

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HEIGHT = 1.3  # inches, of the strip
ROW = 0.21  # inches, of one value that was tried


@dataclass(frozen=True, slots=True)
class StripPicture:
    """Ascending values of one parameter, whether each holds, and the indices of the values that a search tried.

    There are at least two values, all of them above 0.  `answer` is the index of the search's result; None
    without a search.
    """

    title: str
    name: str
    values: Sequence[float]
    holds: Sequence[bool]
    tried: Sequence[int] = ()
    answer: int | None = None

    @property
    def description(self) -> str:
        """A description of the picture as text."""
        found = f"{sum(self.holds)} of {len(self.holds)} values of {self.name} hold."
        if self.answer is None:
            return found
        tried = ", ".join(f"{self.values[n]:.0f} {self.outcome(n)}" for n in self.tried)
        return f"{found} Tried: {tried}. Answer: {self.values[self.answer]:.0f}, which {self.outcome(self.answer)}."

    def outcome(self, n: int) -> str:
        """Return the result for the value with index `n`: "holds" or "fails"."""
        return "holds" if self.holds[n] else "fails"


def save_strip(picture: StripPicture, path: str | Path, width: str | float = "page", dark: bool = False) -> None:
    """Draw the picture to a file: SVG, PNG or PDF.

    Raises:
        UsageError: a suffix of another format, a path that cannot be written, or no matplotlib.
    """
    check_suffix(path, SUFFIXES)
    save(draw(picture, width, dark), path, picture.title, picture.description, dark)


def draw(picture: StripPicture, width: str | float = "page", dark: bool = False) -> Figure:
    """Return the picture as a matplotlib Figure.

    Args:
        width: "page", "phone", or inches.

    Raises:
        UsageError: an invalid width, or no matplotlib.
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
        between = [sqrt(one * other) for one, other in pairwise(values)]
        edges = [values[0] ** 2 / between[0], *between, values[-1] ** 2 / between[-1]]
        shades = {True: f"{colours.home}90", False: f"{colours.alarm}a0"}
        for (left, right), holds in zip(pairwise(edges), picture.holds, strict=True):
            axes.axvspan(left, right, ymin=rows / (rows + 3), color=shades[holds], linewidth=0)
            axes.axvline(left, ymin=rows / (rows + 3), color=colours.ground, linewidth=1)
        steps = [
            (n, f"{number}. {'holds: faster' if picture.holds[n] else 'fails: slower'}")
            for number, n in enumerate(picture.tried, 1)
        ]
        if picture.answer is not None:
            untried = "" if picture.answer in picture.tried else "was never tried, and "
            steps.append(
                (picture.answer, f"the answer: {values[picture.answer]:.0f} {untried}{picture.outcome(picture.answer)}")
            )
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
        decades = range(int(log10(edges[0])), int(log10(edges[-1])) + 1)
        ticks = [tick for n in decades for tick in (10**n, 2 * 10**n, 5 * 10**n) if edges[0] <= tick <= edges[-1]]
        axes.set_xticks(ticks, [grouped(tick) for tick in ticks])
        axes.set_xticks([], minor=True)
        axes.set_yticks([])
        axes.grid(False)
        figure.legend(
            handles=[Patch(facecolor=shades[True], label="holds"), Patch(facecolor=shades[False], label="fails")],
            ncols=2, loc="upper right", frameon=False, fontsize=8,
        )  # fmt: skip
        return figure
