"""Events in a picture: commands, findings, limits and home as flags on top, phases as shading, cursors as lines."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..style import Palette, TimeAxis
from .tracks import Track

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FLAG_ROW, PHASE_ROW = 0.155, 0.155  # inches
ROWS = 3  # of flags
LETTER = 0.063  # inches, of a flag's text
LINES = 24  # with more flags, only alarms have lines through the panels
SIDE_BY_SIDE = 0.12  # inches that two flags need
URGENT = {"finding": 0, "limit": 1, "home": 2, "command": 3}


@dataclass(frozen=True, slots=True)
class Flag:
    """A mark above the panels, with its text if there is room for it.

    `at` is in units of the time axis; row 0 is the lowest, and row None means that there is no room for the
    text.  A flag is not `shown` if it would cover the text of another.  At the right end of the panels, the
    text is to the left of its flag (`leftwards`).
    """

    at: float
    kind: str
    text: str
    row: int | None
    shown: bool = True
    leftwards: bool = False


def flags_of(tracks: Sequence[Track], axis: TimeAxis, width: float) -> list[Flag]:
    """Return the flags of events in the window, without any flag that is too close to another of its kind.

    A command that begins a motion takes precedence over a command that does not, such as a command that loads
    a register just before the motion.

    Args:
        width: the width of the panels, inches.
    """
    marks: dict[tuple[int, str, str], bool] = {}  # whether it begins a motion
    for track in tracks:
        start, stop = track.window(axis)
        happened = [(motion.time_ps, "command", motion.text, True) for motion in track.motions]
        happened += [(mark.time_ps, mark.kind, mark.text, False) for mark in track.marks]
        for at_ps, kind, text, begins in happened:
            if start <= at_ps <= stop:
                marks.setdefault((at_ps - track.zero, kind, text), begins)
    per_inch = _per_inch(axis, width)
    first, last = float(axis.scaled(axis.start)), float(axis.scaled(axis.stop)) + 0.2 * per_inch
    placed: list[Flag] = []
    taken: list[list[tuple[float, float]]] = [[] for _ in range(ROWS)]
    kept: dict[str, list[int]] = {}
    side_by_side = SIDE_BY_SIDE * (axis.stop - axis.start) / width
    for at_ps, kind, text in sorted(marks, key=lambda key: (URGENT.get(key[1], 9), not marks[key], key[0])):
        others = kept.setdefault(kind, [])
        place = bisect(others, at_ps)
        if any(abs(at_ps - other) < side_by_side for other in others[max(place - 1, 0) : place + 1]):
            continue
        others.insert(place, at_ps)
        at = float(axis.scaled(at_ps))
        reach = (0.14 + LETTER * len(text)) * per_inch
        leftwards = at + reach > last
        need = (at - reach, at) if leftwards else (at, at + reach)
        free = (row for row in range(ROWS) if all(need[1] <= a or b <= need[0] for a, b in taken[row]))
        row = next(free, None) if text and need[0] >= first else None
        if row is not None:
            taken[row].append(need)
        free_at = row is not None or not any(a - 0.05 * per_inch < at < b for a, b in taken[0])
        placed.append(Flag(at, kind, text, row, free_at, leftwards))
    return placed


def rows_of(flags: Sequence[Flag]) -> int:
    """Return the number of flag rows."""
    return max((1 + (flag.row or 0) for flag in flags), default=0)


def draw_flags(panels: Sequence[Axes], flags: Sequence[Flag], colours: Palette, above: float) -> None:
    """Draw flags above the first panel, and a line from each flag down through all panels.

    With more than LINES flags, flags of commands have no lines.

    Args:
        above: the height of the lowest row of flags above the first panel, inches.
    """
    color = {"command": colours.command, "home": colours.home}
    for flag in flags:
        ink = color.get(flag.kind, colours.alarm)
        if len(flags) <= LINES or flag.kind != "command":
            for panel in panels:
                panel.axvline(flag.at, color=ink, linewidth=0.7, alpha=0.55, linestyle=(0, (1, 2)), zorder=1.4)
        high = (above + FLAG_ROW * (flag.row or 0)) * 72
        at = ("data", "axes fraction")
        if flag.shown:
            panels[0].annotate(
                "▾", (flag.at, 1), (0, high - 0.5), at, "offset points", ha="center", va="bottom", fontsize=8, color=ink
            )
        if flag.row is not None:
            weight = "normal" if flag.kind == "command" else "bold"
            panels[0].annotate(
                flag.text, (flag.at, 1), (-4 if flag.leftwards else 4, high + 1), at, "offset points", fontsize=7.5,
                ha="right" if flag.leftwards else "left", va="bottom", color=ink, weight=weight,
            )  # fmt: skip


# ------------------------------------------------------------------------------------------------------------- phases
def phases_of(tracks: Sequence[Track], axis: TimeAxis, width: float) -> list[tuple[float, float, str]]:
    """Return the start, end and name of each phase in the window, in units of the time axis.

    Return [] if the tracks have different phases, or if most phases are too short for their names in panels
    `width` inches wide: they would only be stripes.
    """
    several = {
        tuple((begin - track.zero, end - track.zero, text) for begin, end, text in track.phases) for track in tracks
    }
    if len(several) != 1:
        return []
    inside = [(max(a, axis.start), min(b, axis.stop), text) for a, b, text in several.pop()]
    scaled = [(float(axis.scaled(a)), float(axis.scaled(b)), text) for a, b, text in inside if b > a]
    named = sum(b - a > _need(text) * _per_inch(axis, width) for a, b, text in scaled)
    return scaled if 2 * named >= len(scaled) else []


def draw_phases(
    panels: Sequence[Axes], phases: Sequence[tuple[float, float, str]], axis: TimeAxis, colours: Palette, width: float
) -> None:
    """Shade every second phase of a motion in all panels; name all phases above the first panel if they fit."""
    per_inch = _per_inch(axis, width)
    index, last = 0, float("nan")
    for begin, end, text in phases:
        index, last = (index + 1 if begin == last else 0), end
        for panel in panels:
            if index % 2 == 0:
                panel.axvspan(begin, end, facecolor=colours.band, linewidth=0, zorder=0)
            for border in {begin, end}:
                panel.axvline(border, color=colours.grid, linewidth=0.7, zorder=1)
        if end - begin > _need(text) * per_inch:
            panels[0].annotate(
                text, ((begin + end) / 2, 1), (0, 2.5), ("data", "axes fraction"), "offset points", ha="center",
                fontsize=8, color=colours.soft,
            )  # fmt: skip


def _need(text: str) -> float:
    """Return the width that a phase name needs, in inches."""
    return 0.04 + LETTER * len(text)


def _per_inch(axis: TimeAxis, width: float) -> float:
    """Return the time that one inch of the panels represents, in units of the time axis."""
    return float(axis.scaled(axis.stop) - axis.scaled(axis.start)) / width


# ------------------------------------------------------------------------------------------------------------ cursors
def draw_cursors(panels: Sequence[Axes], cursors: Sequence[int], axis: TimeAxis, colours: Palette) -> None:
    """Draw cursors, which are instants (ps), as lines through all panels, numbered from 1."""
    for number, cursor in enumerate(cursors, 1):
        at = float(axis.scaled(cursor))
        for panel in panels:
            panel.axvline(at, color=colours.cursor, linewidth=0.9, zorder=3)
        panels[0].annotate(
            str(number), (at, 1), (0, -5), ("data", "axes fraction"), "offset points", ha="center", va="top",
            fontsize=7.5, weight="bold", color=colours.ground, zorder=4,
            bbox={"boxstyle": "round,pad=0.25", "facecolor": colours.cursor, "linewidth": 0},
        )  # fmt: skip
