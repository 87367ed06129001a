"""The common style of all pictures: colours for light and dark pages, sizes, formats of numbers and times.

`styled()` applies the style while a picture is created, and `Picture` applies it while the picture is
drawn; the user's matplotlib configuration has no effect on our pictures, and is not changed by them.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from ..core.time.timebase import UNITS, readable
from ..errors import UsageError
from ..extras import needs

THIN_SPACE, MINUS = "\u2009", "\u2212"
DPI = 144  # of a PNG
FONTS = ("DejaVu Sans", "sans-serif")  # the first comes with matplotlib; the second is for readers of an SVG
DASHES: tuple[Any, ...] = ("solid", (0, (5, 1.6)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)))  # of the 1st, 2nd ... line
WIDTHS = {"page": 9.6, "phone": 4.2}  # inches


@dataclass(frozen=True, slots=True)
class Palette:
    """The colours of a picture.

    The colours in `series` also differ in greyscale, and for people with colour blindness.
    """

    ground: str  # background
    ink: str  # titles, names
    soft: str  # numbers, units, notes
    dashed: str  # curves for comparison: rates, ideals
    edge: str  # spines, the line at zero
    grid: str
    band: str  # every second phase
    series: tuple[str, ...]  # lines of axes and runs
    trace: str  # a pin
    bus: str  # outline and text of the values of a bus
    byte: str  # under these values
    command: str
    alarm: str  # findings, limits that are hit, times that are out of range
    home: str
    cursor: str
    measured: str  # a pin over the model's


LIGHT = Palette(
    ground="#ffffff",
    ink="#25303b",
    soft="#5a6672",
    dashed="#7f8a95",
    edge="#aab3bc",
    grid="#e4e8ec",
    band="#f0f3f6",
    series=("#1763aa", "#dd7414", "#4a1d6b", "#0b8a6f"),
    trace="#2b5d4c",
    bus="#6a4c93",
    byte="#efeaf5",
    command="#5a6672",
    alarm="#c0262d",
    home="#0b7a4b",
    cursor="#a3258a",
    measured="#dd7414",
)
DARK = Palette(
    ground="#14191f",
    ink="#e6eaee",
    soft="#a9b4bf",
    dashed="#8793a0",
    edge="#53606d",
    grid="#28313a",
    band="#1c242c",
    series=("#58a6ff", "#ffb454", "#e3d3ff", "#2fa583"),
    trace="#7fd1b3",
    bus="#c3a6ee",
    byte="#2d2540",
    command="#a9b4bf",
    alarm="#ff7b72",
    home="#56d394",
    cursor="#f778c9",
    measured="#ffb454",
)


def palette(dark: bool = False) -> Palette:
    """Return the colours for a light or a dark picture."""
    return DARK if dark else LIGHT


def inches(width: str | float) -> float:
    """Return the width of a picture, in inches.

    Raises:
        UsageError: the width is neither "page" nor "phone" nor 3 to 40 inches.
    """
    if isinstance(width, str) and width in WIDTHS:
        return WIDTHS[width]
    if isinstance(width, int | float) and not isinstance(width, bool) and 3 <= width <= 40:
        return float(width)
    raise UsageError(f'width={width!r}; allowed "page", "phone", or 3 to 40 inches')


@contextmanager
def styled(dark: bool = False) -> Iterator[Palette]:
    """Apply our style within a `with` block, instead of the user's matplotlib configuration; yield the colours.

    Raises:
        UsageError: matplotlib is not installed.
    """
    try:
        import matplotlib
    except ImportError as error:
        raise UsageError(needs("plots need", "plot")) from error
    colours = palette(dark)
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_settings(colours))
        yield colours


def _settings(colours: Palette) -> dict[Any, Any]:
    return {
        "font.family": list(FONTS),
        "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial"],
        "font.size": 9.0,
        "figure.facecolor": colours.ground,
        "axes.facecolor": "none",
        "axes.edgecolor": colours.edge,
        "axes.linewidth": 0.8,
        "axes.labelcolor": colours.soft,
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": colours.grid,
        "grid.linewidth": 0.8,
        "text.color": colours.ink,
        "text.parse_math": False,  # a name may contain a dollar sign
        "xtick.color": colours.edge,
        "ytick.color": colours.edge,
        "xtick.labelcolor": colours.soft,
        "ytick.labelcolor": colours.soft,
        "svg.fonttype": "none",  # text stays text
        "svg.hashsalt": "slewline",
        "pdf.fonttype": 42,
    }


# ------------------------------------------------------------------------------------------------- numbers and times
def number(value: float, digits: int = 10) -> str:
    """Return a number as text: `digits` significant digits, thin spaces, a true minus: 12345 as 12 345."""
    return f"{value:,.{digits}g}".replace(",", THIN_SPACE).replace("-", MINUS)


def few(value: float) -> str:
    """Return a measured number: whole if it is 100 or more, otherwise with up to three significant digits."""
    return number(round(value) if abs(value) >= 100 else value, 10 if abs(value) >= 100 else 3)


def grouped(value: object) -> str:
    """Return a number formatted as by `number`, and anything else as text."""
    return number(value) if isinstance(value, int | float) else str(value)


def duration(ps: int) -> str:
    """Return a time as text for a picture: "3.2 ms", "25 µs"."""
    return readable(ps).replace("-", MINUS)


class TimeAxis:
    """The common time axis of all panels, in a suitable unit; far from time 0, it counts from the window start.

    Args:
        zero: the instant that counts as 0, such as the start of a motion; by default, the start of the
            window if that is far from time 0, otherwise time 0.
    """

    def __init__(self, start: int, stop: int, zero: int | None = None, zero_is: str = "") -> None:
        self.start, self.stop = start, stop
        span = stop - start
        name = next((unit for unit in ("s", "ms", "µs", "ns") if span >= 2 * UNITS[unit]), "ps")
        self.unit = UNITS[name]
        far = start > 10 * span
        self.origin = zero if zero is not None else start if far else 0
        from_where = zero_is or (f"from {duration(start)} on" if far and zero is None else "")
        self.label = f"Time in {name}" + (f", {from_where}" if from_where else "")

    def scaled(self, times: Any) -> Any:
        """Return instants (ps) in units of the axis: float64, in the same shape as `times`."""
        import numpy as np

        return (np.asarray(times, np.int64) - self.origin) / self.unit


def aligned(lines: Sequence[Sequence[str]], left: Container[int] = ()) -> list[str]:
    """Return the lines of a table; columns are right-aligned, except those with indices (from 0) in `left`."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    sides = ["<" if n in left else ">" for n in range(len(widths))]
    cells = ([f"{cell:{side}{width}}" for cell, side, width in zip(line, sides, widths, strict=True)] for line in lines)
    return ["  ".join(line).rstrip() for line in cells]
