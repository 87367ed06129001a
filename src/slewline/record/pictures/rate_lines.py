"""Rates in a velocity panel: each a named, dashed line that spans the times when the rate was in force."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..style import Palette, TimeAxis, number

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from .tracks import TrackCurve

MAX_DASHED = 300  # dashed lines in a row that can be distinguished
RATE_HEIGHT = 0.165  # inches, of a rate's name


@dataclass(frozen=True, slots=True)
class Rate:
    """A signed rate in a picture, and the times at which it was in force: starts and ends, (n, 2) int64 ps."""

    name: str
    value: float
    spans: NDArray[np.int64]


def rates_of(curve: TrackCurve, axis: TimeAxis) -> Iterator[Rate]:
    """Yield the rates that were in force in the window.

    A rate is in force from the start of its motion until the axis rests or other rates replace it.  Its sign
    is the direction of the motion; a rate that was in force in both directions is yielded once for each.
    """
    import numpy as np

    start, stop = curve.track.window(axis)
    in_force = [(since, rates) for since, rates in curve.track.rates() if since < stop]
    if not in_force:
        return
    times, values = curve.outline.times_ps, np.nan_to_num(curve.outline.values)
    begins = np.maximum([since for since, _ in in_force], start)
    ends = np.append(begins[1:], stop)
    first = np.maximum(np.searchsorted(times, begins, side="right") - 1, 0)
    low, high = np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)
    moved = np.maximum.accumulate(np.where(values != 0, np.arange(len(values)), 0))  # when the axis last moved
    over = moved[np.maximum(np.searchsorted(times, ends) - 1, 0)] + 1
    ends = np.where(over > first, np.minimum(times[np.minimum(over, len(times) - 1)], ends), ends)
    spans, clockwise, counter = np.stack([begins, ends], axis=1) - curve.track.zero, (high > 0) | (low >= 0), low < 0
    shared = np.array([id(rates) for _, rates in in_force])  # motions may share them
    for rates in {id(rates): rates for _, rates in in_force}.values():
        with_them = (shared == id(rates)) & (begins < ends)
        for sign, moved_so in ((1, clockwise & with_them), (-1, counter & with_them)):
            for name, rate in rates.items() if moved_so.any() else ():
                yield Rate(curve.track.called(name), sign * rate, spans[moved_so])


def draw_rates(
    panel: Axes, curves: Sequence[TrackCurve], axis: TimeAxis, colours: Palette, height: float, beside: bool
) -> None:
    """Draw a dashed line at each rate while it was in force.

    If the last argument is True, the name of a rate is written next to the panel, otherwise above its line.
    """
    import numpy as np

    parts: dict[tuple[float, str], list[NDArray[np.int64]]] = {}
    for curve in curves:
        for rate in rates_of(curve, axis):
            parts.setdefault((rate.value, rate.name), []).append(rate.spans)
    apart = (axis.stop - axis.start) // MAX_DASHED
    found = {key: axis.scaled(_joined(np.concatenate(spans), apart)) for key, spans in parts.items()}
    for (value, _), spans in found.items():
        begins, ends = spans.T
        panel.hlines([value] * len(begins), begins, ends, colours.dashed, (0, (4, 3)), lw=0.9, zorder=1.5)
    names: dict[float, list[str]] = {}
    for value, name in found:
        names.setdefault(value, []).append(name)
    if beside:
        _write_beside(panel, names, colours, height)
    else:
        begins_of = {value: float(spans[0, 0]) for (value, _), spans in found.items()}
        _write_over(panel, names, begins_of, colours, height)


def _joined(spans: NDArray[np.int64], apart: int) -> NDArray[np.int64]:
    """Return the spans, (n, 2), sorted, and joined where the gap between two is at most `apart` (ps)."""
    import numpy as np

    begins, ends = spans[np.argsort(spans[:, 0], kind="stable")].T
    ends = np.maximum.accumulate(ends)
    gaps = begins[1:] - ends[:-1] > apart
    return np.stack([begins[np.append(True, gaps)], ends[np.append(gaps, True)]], axis=1)


def _write_beside(panel: Axes, names: dict[float, list[str]], colours: Palette, height: float) -> None:
    """Write the names of rates at the right end of a panel, moved apart so that they do not overlap.

    If there is not enough room for all of them, leave out rates between the slowest and the fastest.
    """
    low, high = panel.get_ylim()
    apart = (high - low) * RATE_HEIGHT / height
    shown = sorted(names)
    while len(shown) * apart > high - low + apart:
        shown.pop(len(shown) // 2)  # the slowest and the fastest rate stay
    places = list(shown)
    for index in range(1, len(places)):
        places[index] = max(places[index], places[index - 1] + apart)
    over = places[-1] - high if places else 0.0
    for index in reversed(range(len(places))):  # and back from the top
        ceiling = high if index == len(places) - 1 else places[index + 1] - apart
        places[index] = min(places[index], ceiling) if over > 0 else places[index]
    for rate, place in zip(shown, places, strict=True):
        text = rate_text(names[rate], rate)
        panel.annotate(
            text, (1, place), (4, 0), ("axes fraction", "data"), "offset points", va="center_baseline",
            fontsize=8, color=colours.soft, annotation_clip=False,
        )  # fmt: skip


def rate_text(names: Sequence[str], rate: float) -> str:
    """Return the text next to a rate, such as "VEL = 65 536, 3 052 steps/s"."""
    return f"{_joint(names)}, {number(round(rate) if abs(rate) >= 100 else rate, 6)} steps/s"


def _joint(names: Iterable[str]) -> str:
    """Return the names of equal rates as one text, with thin spaces between the thousands of their numbers."""
    return re.sub(r"\b\d{5,}\b", lambda digits: number(int(digits[0])), ", ".join(names))


def _write_over(
    panel: Axes, names: dict[float, list[str]], begins: dict[float, float], colours: Palette, height: float
) -> None:
    """Write rate names above the starts of their lines, except where a line is too close to a named line below it."""
    low, high = panel.get_ylim()
    apart, last = (high - low) * RATE_HEIGHT / height, float("-inf")
    for rate in sorted(names):
        if rate - last >= apart:
            last = rate
            text = _joint(name.partition(" (")[0] for name in names[rate])
            panel.annotate(
                text, (begins[rate], rate), (2, 1.5), "data", "offset points", va="bottom", fontsize=7.5,
                color=colours.soft, bbox={"facecolor": colours.ground, "alpha": 0.7, "linewidth": 0, "pad": 0.5},
            )  # fmt: skip
