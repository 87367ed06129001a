"""Numbers, times and curves as text of a given width."""

from __future__ import annotations

from collections.abc import Sequence

from textual.content import Content

from ...core.time.timebase import PS_PER_S

Part = tuple[str, str]  # text, and its style
DOTS = (0x40, 0x04, 0x02, 0x01), (0x80, 0x20, 0x10, 0x08)  # bits of a braille character: left and right, from below
EMPTY = 0x2800
LEVELS = {0: "▁ 0", 1: "▔ 1", None: "· –"}  # a level as on a scope, and as a digit


def line(width: int, *parts: str | Part) -> Content:
    """Return these parts joined into one line, cut or padded to exactly this width."""
    return Content.assemble(*(part for part in parts if part)).truncate(width, ellipsis=True, pad=True)


def pair(width: int, name: str, value: str, name_style: str = "", value_style: str = "") -> list[Part]:
    """Return the parts of a row of this width: a name on the left, and its value on the right."""
    room = max(width - len(value) - 1, 1)
    shown = name if len(name) <= room else f"{name[: room - 1]}…"
    return [(shown.ljust(room), name_style), (" ", ""), (value.rjust(width - room - 1), value_style)]


def clock(ps: int) -> str:
    """Return an instant (ps) as text: in seconds to the microsecond, with the decimals in groups of three."""
    whole, rest = divmod(ps // 10**6, 10**6)
    return f"{whole}.{rest // 1000:03} {rest % 1000:03} s"


def stamp(ps: int) -> str:
    """Return an instant (ps) as text for a column: in seconds to the microsecond, without the unit."""
    return f"{ps // PS_PER_S}.{ps % PS_PER_S // 10**6:06d}"


def figure(value: float) -> str:
    """Return a velocity (steps/s) as text, without its unit."""
    return f"{value:.0f}" if abs(value) >= 1000 or value == int(value) else f"{value:.1f}"


def strip(values: Sequence[float | None], width: int, height: int, top: float) -> list[str]:
    """Return a curve as rows of braille characters, filled from below; a character shows two adjacent values.

    At rest the curve is a line one dot high; a value of magnitude `top` fills the whole height; None is left blank.
    """
    values = spread(values, width * 2)
    steps = height * 4 - 1
    heights = [0 if value is None else 1 + round(abs(value) / (top or 1) * steps) for value in values]
    rows = []
    for row in range(height - 1, -1, -1):
        cells = []
        for at in range(width):
            code = EMPTY
            for side, dots in enumerate(DOTS):
                filled = min(max(heights[2 * at + side] - 4 * row, 0), 4)
                code |= sum(dots[:filled])
            cells.append(chr(code))
        rows.append("".join(cells))
    return rows


def spread(values: Sequence[float | None], count: int) -> list[float | None]:
    """Stretch or compress a list to `count` values; where several values become one, keep the greatest in magnitude."""
    if not values:
        return [None] * count
    found: list[float | None] = []
    for at in range(count):
        first = at * len(values) // count
        last = max((at + 1) * len(values) // count, first + 1)
        some = [value for value in values[first:last] if value is not None]
        found.append(max(some, key=abs) if some else None)
    return found
