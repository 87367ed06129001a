"""The layout of a timing diagram: time as inches, quiet stretches cut short, arrows on separate lines.

Nothing is drawn here.  All positions are in inches from the lower left corner.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from textwrap import wrap
from typing import Any, NamedTuple

from ...core.time.timebase import readable
from ..measuring.intervals import Interval, SignalEdges
from ..measuring.overlay import differences
from ..recording.traces import Trace
from ..style import duration

# inches
LANE, SWING, WORDS, ROW, TOP, BOTTOM, RIGHT = 0.34, 0.2, 0.17, 0.2, 0.42, 0.42, 0.2
LETTER = 0.0088  # width of a letter, per point
QUIET = 8  # a stretch is quiet if it is this many times as long as most gaps between edges
EDGE, NOTE = 0.12, 0.17  # where titles begin; a line of notes
SMALL, LARGE = 7.5, 8.5  # points


class LaneText(NamedTuple):
    """Text over a lane, such as a character, from one instant to another (ps); `wrong` marks faulty text."""

    start: int
    end: int
    text: str
    wrong: bool = False


@dataclass(frozen=True, slots=True)
class Lane:
    """A pin or a bus in a diagram, with its measured trace if there is one.

    `pin` is the full name of the pin or bus, and `label` the text next to the lane; `words` are texts over
    the lane; `describe` returns the meaning of a bus value, given the value and the instant (ps) at which
    the value ends.
    """

    pin: str
    label: str
    signal: SignalEdges
    words: Sequence[LaneText] = ()
    describe: Callable[[int, int], str] | None = None
    over: Trace | None = None


@dataclass(frozen=True, slots=True)
class Diagram:
    """The contents of a timing diagram in a window (ps).

    `measured` are the times drawn as arrows; `causes` are drawn as curved arrows from an edge to the edge
    that it causes.  Stretches without edges are cut short if they are longer than `quiet` (ps); with None,
    a suitable length is chosen, and with 0, no stretch is cut.
    """

    title: str
    start: int
    stop: int
    lanes: Sequence[Lane]
    measured: Sequence[Interval] = ()
    causes: Sequence[Interval] = ()
    quiet: int | None = None

    @property
    def description(self) -> str:
        """A description of the diagram as text."""
        names = ", ".join(lane.label for lane in self.lanes)
        times = "".join(f" From {each.start} to {each.end}: {each}." for each in self.measured)
        compared = "".join(f" {line}." for line in self.compared)
        return f"Timing diagram of {names}, from {readable(self.start)} to {readable(self.stop)}.{times}{compared}"

    @property
    def compared(self) -> list[str]:
        """A line of text, in a list: how well lanes agree with the traces drawn over them; [] without traces."""
        return differences(((lane.label, lane.signal, lane.over) for lane in self.lanes), self.start, self.stop)


class TimeScale:
    """The conversion of time to inches: linear, except for the stretches in `cuts`, each drawn as if `room` ps long."""

    def __init__(self, diagram: Diagram, left: float, right: float) -> None:
        import numpy as np

        start, stop = diagram.start, diagram.stop
        self.start, self.stop, self.left, self.right = start, stop, left, right
        busy = [times for lane in diagram.lanes for times in (lane.signal.times_ps, _ends(lane.words))]
        busy += [lane.over.times_ps for lane in diagram.lanes if lane.over is not None]
        instants = np.unique(np.concatenate([[start, stop], *busy])).astype(np.int64)
        instants = instants[(instants >= start) & (instants <= stop)]
        gaps = np.diff(instants)
        quiet = diagram.quiet
        if quiet is None:
            quiet = int(QUIET * np.quantile(gaps, 0.75))
            if 2 * gaps[gaps > quiet].sum() < stop - start:
                quiet = 0
        self.cuts: list[tuple[int, int]] = []
        points, shown = [(start, 0)], 0
        self.room = room = quiet // 4
        for n in np.flatnonzero(gaps > quiet).tolist() if quiet else ():
            begin, end = int(instants[n]), int(instants[n + 1])
            first = begin + room if begin > start else begin
            last = end - room if end < stop else end
            self.cuts.append((first, last))
            shown += first - points[-1][0]
            points += [(first, shown), (last, shown + room)]
            shown += room
        shown += stop - points[-1][0]
        points.append((stop, shown))
        self._times = np.array([at - start for at, _ in points], np.float64)
        self._places = np.array([place for _, place in points]) * ((right - left) / shown) + left
        self.ps_per_inch = shown / (right - left)

    def __call__(self, times: Any) -> Any:
        """Return the positions of instants (ps): float64 inches, in the same shape as `times`."""
        import numpy as np

        return np.interp(np.asarray(times, np.int64) - self.start, self._times, self._places)


def _ends(words: Sequence[LaneText]) -> list[int]:
    return [at for word in words for at in (word.start, word.end)]


# -------------------------------------------------------------------------------------------------------------- layout
class Arrow(NamedTuple):
    """A measured time in the picture: from `first` to `second` (inches), on line `row` under lane `under`."""

    interval: Interval
    lanes: tuple[int, int]
    first: float
    second: float
    text: str
    place: float  # the middle of the text, or its start next to the arrow
    beside: str  # "left", "right", or "" for above it
    row: int

    @property
    def under(self) -> int:
        """The number of the lower of the two lanes that the arrow connects."""
        return max(self.lanes)


@dataclass(frozen=True, slots=True)
class DiagramLayout:
    """The positions of all elements: the top of the lanes, the foot of each lane, the arrows, and the notes."""

    height: float
    top: float
    feet: tuple[float, ...]
    arrows: tuple[Arrow, ...] = field(default=())
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, diagram: Diagram, scale: TimeScale) -> DiagramLayout:
        """Return the layout of a diagram, all in inches."""
        arrows: list[Arrow] = []
        taken: dict[tuple[int, int], list[tuple[float, float]]] = {}
        order = sorted(diagram.measured, key=lambda each: (each.ps, each.start_ps))
        for interval in order:
            arrows.append(_placed(interval, lanes_of(interval, diagram.lanes), scale, taken))
        rows = [
            1 + max((arrow.row for arrow in arrows if arrow.under == n), default=-1) for n in range(len(diagram.lanes))
        ]
        heights = [
            LANE + ROW * count + (0.06 if count else 0) + (WORDS if lane.words else 0)
            for lane, count in zip(diagram.lanes, rows, strict=True)
        ]
        letters = int((scale.right + RIGHT - EDGE) / (LETTER * LARGE))
        notes = tuple(line for note in diagram.compared for line in wrap(note, letters))
        top = sum(heights) + BOTTOM
        feet, below = [], top
        for lane, tall in zip(diagram.lanes, heights, strict=True):
            feet.append(below - LANE + 0.05 - (WORDS if lane.words else 0))
            below -= tall
        return cls(top + TOP + NOTE * len(notes), top, tuple(feet), tuple(arrows), notes)


def lanes_of(interval: Interval, lanes: Sequence[Lane]) -> tuple[int, int]:
    """Return the numbers of two lanes: those of an interval's start edge and of its end edge."""
    names = [lane.pin for lane in lanes]
    return names.index(interval.start.split()[0]), names.index(interval.end.split()[0])


def _placed(
    interval: Interval,
    lanes: tuple[int, int],
    scale: TimeScale,
    taken: dict[tuple[int, int], list[tuple[float, float]]],
) -> Arrow:
    """Return the arrow of an interval, on the first line with enough room under the lower of its two lanes.

    The extent of the arrow is added to `taken`, which is keyed by lane and line.
    """
    first, second = (float(place) for place in scale([interval.start_ps, interval.end_ps]))
    for text in _labels(interval):
        wide = len(text) * LETTER * SMALL
        if second - first > wide + 0.3:
            beside, place, extent = "", (first + second) / 2, (first, second)
        elif second + 0.2 + wide < scale.right + RIGHT:
            beside, place, extent = "right", second + 0.2, (first - 0.2, second + 0.25 + wide)
        else:
            beside, place, extent = "left", first - 0.2, (first - 0.25 - wide, second + 0.2)
            if first - 0.2 - wide < scale.left:
                continue
        break
    row = 0
    while any(a < extent[1] and extent[0] < b for a, b in taken.get((max(lanes), row), ())):
        row += 1
    taken.setdefault((max(lanes), row), []).append(extent)
    return Arrow(interval, lanes, first, second, text, place, beside, row)


def _labels(interval: Interval) -> tuple[str, ...]:
    """Return possible texts for an arrow, longest first: time, limit, verdict; time and verdict; only the time.

    The verdict states whether the limit is kept.  Without a limit, the only text is the time.
    """
    text = f"{interval.symbol} = {duration(interval.ps) if interval.ps else 0}"
    limits = "; ".join(str(bound) for bound in interval.bounds)
    verdict = "" if interval.kept is None else ": met" if interval.kept else ": violated"
    return (f"{text}  ({limits}{verdict})", text + verdict, text) if limits else (text,)
