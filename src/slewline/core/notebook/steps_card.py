"""The notebook view of steps: a table of the first and the last steps, and a thumbnail of the positions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..time.timebase import readable
from .markup import ACCENT, Markup, card, element, table

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

FIRST, LAST = 3, 2  # rows of the table
POINTS = 120  # steps of the thumbnail, at most
WIDE, HIGH, MARGIN = 240, 90, 4


def steps_card(
    caption: str, times_ps: NDArray[np.int64], directions: NDArray[np.int8], positions: NDArray[np.int64]
) -> Markup:
    """Return a card, as HTML, that shows a sequence of steps.

    Args:
        caption: the number of steps, as text.
        times_ps, directions, positions: the time, direction and position of each step, (n,).
    """
    count = len(times_ps)
    if not count:
        return card(caption)
    shown = range(count) if count <= FIRST + LAST + 1 else [*range(FIRST), None, *range(count - LAST, count)]
    lines = [
        ["\u22ee", "", "", ""] if n is None else
        [str(n), readable(int(times_ps[n])), f"{int(directions[n]):+d}", str(int(positions[n]))]
        for n in shown
    ]  # fmt: skip
    rows = table(["step", "time", "direction", "position"], lines, right=range(4))
    return card(caption, rows, _thumbnail(times_ps, positions))


def _thumbnail(times_ps: NDArray[np.int64], positions: NDArray[np.int64]) -> Markup:
    """Return a plot of position against time: a staircase, or a line if there are too many steps to show each."""
    import numpy as np

    which = np.unique(np.linspace(0, len(times_ps) - 1, POINTS).astype(np.int64))
    x, y = _within(times_ps[which], WIDE), HIGH - _within(positions[which], HIGH)
    points = [(float(a), float(b)) for a, b in zip(x, y, strict=True)]
    lines = [f"H{a:.1f}V{b:.1f}" if len(which) == len(times_ps) else f"L{a:.1f} {b:.1f}" for a, b in points[1:]]
    path = f"M{points[0][0]:.1f} {points[0][1]:.1f}{''.join(lines)}"
    return element(
        "svg",
        element("path", d=f"M0 0V{HIGH}H{WIDE}", fill="none", stroke="currentColor", opacity=0.4),
        element("path", d=path, fill="none", stroke=ACCENT, stroke_width=2, stroke_linejoin="round"),
        viewBox=f"{-MARGIN} {-MARGIN} {WIDE + 2 * MARGIN} {HIGH + 2 * MARGIN}",
        width=WIDE + 2 * MARGIN, height=HIGH + 2 * MARGIN, role="img", aria_label="Position over time",
    )  # fmt: skip


def _within(values: NDArray[np.int64], size: int) -> NDArray[np.float64]:
    """Return the values scaled linearly: the lowest becomes 0, the highest `size`; equal values all become 0."""
    least, most = int(values.min()), int(values.max())
    return (values - least) / max(most - least, 1) * size
