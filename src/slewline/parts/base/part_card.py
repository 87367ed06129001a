r"""A part in a notebook: its shaft with a replay of its past motion, its state, and its pin levels.

    angle  ____/‾‾‾\___/‾‾‾‾‾‾‾‾‾‾‾‾‾
               |<- window ->|            from the first to the last change, at most the last ten turns

A turn of a real shaft may be too fast or too slow to be seen, so the window is played slower or faster by a round
factor.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import floor, log10
from typing import TYPE_CHECKING, Any, NamedTuple

from ...core.notebook.markup import Markup, card, element, table
from ...core.notebook.shaft_dial import shaft_dial
from ...core.time.timebase import PS_PER_S

if TYPE_CHECKING:
    from ...core.motion.quantity import Quantity

MOST_TURNS = 10
COLUMNS = 400  # window in which changes are searched
PICTURES = 80  # positions between which the shaft turns at a constant rate
PLAY_S = 6.0  # approximate duration of the playback
STILL = 1 / 3600  # turns; smaller changes do not count as motion


class Turned(NamedTuple):
    """The positions of a shaft, in turns, at equal intervals of time, and the total duration in ps."""

    turns: list[float]
    ps: int


def part_card(
    caption: str, shows: Mapping[str, Any], levels: Mapping[str, object], places: Quantity | None, first: int, now: int
) -> Markup:
    """Return the notebook card of a part as HTML.

    Args:
        caption: the part's description, in one line.
        shows: its state apart from its pins, as plain data.
        levels: the levels of its pins, by name; None: the pin floats.
        places: the position of its shaft over time, in steps; None: it has no shaft.
        first, now: the start of the kept past, and the present instant (ps).
    """
    dial = Markup()
    if "per_turn" in shows:
        per_turn = shows["per_turn"]
        turned = None if places is None else _lately(places, per_turn, first, now)
        dial = _dial(turned or Turned([float(shows.get("angle", shows.get("position", 0))) / per_turn], 0))
    shown = table([], [[name, *_cell(value)] for name, value in shows.items() if value is not None])
    pins = table(["pin", "level"], [[name, "z" if level is None else str(level)] for name, level in levels.items()])
    return card(caption, dial, shown, pins if levels else Markup())


def _cell(value: object) -> list[str]:
    if isinstance(value, list):
        return [element("pre", "\n".join(map(str, value)))]
    return [f"{value:.6g}" if isinstance(value, float) else str(value)]


def _lately(places: Quantity, per_turn: float, first: int, now: int) -> Turned | None:
    """Return the last motion of a shaft, at most ten turns, ending with the last change of its position.

    Return None if the shaft has not turned since `first` (ps).
    """
    import numpy as np

    outline = places.outline(first, now, COLUMNS)
    known = ~np.isnan(outline.values)
    times, turns = outline.times_ps[known], outline.values[known] / per_turn
    moved = np.flatnonzero(np.abs(np.diff(turns)) > STILL)
    if not len(moved):
        return None
    far = np.flatnonzero(np.abs(turns - turns[-1]) > MOST_TURNS)
    begin = int(times[max(int(moved[0]), int(far[-1]) + 1 if len(far) else 0)])
    end = min(int(times[moved[-1] + 1]) + 1, now)
    at = np.linspace(begin, end, PICTURES + 1).astype(np.int64)
    return Turned((places.values_at(at) / per_turn).tolist(), end - begin)


def _dial(turned: Turned) -> Markup:
    """Return a picture of a shaft; if it has turned, with the number of turns and the playback speed."""
    turns, seconds = turned.turns, turned.ps / PS_PER_S
    if len(turns) == 1:
        return element("div", shaft_dial(turns, 0))
    slower = _round(PLAY_S / seconds)
    speed = "real time" if slower == 1 else f"{slower:g} times slower" if slower > 1 else f"{1 / slower:g} times faster"
    moved = f"{abs(turns[-1] - turns[0]):.3g}"
    caption = f"{moved} turn{'s' * (moved != '1')} in {seconds:.3g} s, {speed}"
    return element("div", shaft_dial(turns, seconds * slower), element("div", caption, class_="quiet"))


def _round(factor: float) -> float:
    """Return the largest number, not above `factor`, that is a power of ten multiplied by 1, 2 or 5."""
    power = 10.0 ** floor(log10(factor))
    return power * next(digit for digit in (5, 2, 1) if digit * power <= factor * (1 + 1e-9))
