"""Building blocks of every benchmark table: rows, timing, and comparisons of two times."""

from __future__ import annotations

import gc
import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from statistics import median
from time import process_time
from typing import TypeVar

from caches import forget

T = TypeVar("T")
REAL = "x real time"
LIMIT = 0.05  # a goal that is met by less is one that the next run may miss


class Measured(float):
    """A time measured in this run.

    Arithmetic turns it into a plain float, which no ratio accepts: a yardstick must be measured, and cannot be a
    constant or a multiple of another time.
    """


Sides = Sequence[tuple[Measured, Measured]]


@dataclass
class Row:
    """One line of a table; a figure that could not be measured is None, and `absent` has the reason.

    A ratio has its two sides, the yardstick and ours, turn by turn, and its figure is computed from them.  `when` is
    the date and the processor of a figure that was measured once, by hand.
    """

    name: str
    figure: float | None
    unit: str
    goal: float | None
    more_is_better: bool
    bound: str
    sides: Sides = ()
    absent: str = ""
    when: str = ""

    def __post_init__(self) -> None:
        if any(type(side) is not Measured for turn in self.sides for side in turn):
            raise TypeError(f"{self.name}: a ratio needs times measured in this run, unchanged")
        if self.sides:
            self.figure = median(self.ratios)
        elif self.unit.startswith("x ") and self.unit != REAL and not (self.absent or self.when):
            raise TypeError(f"{self.name}: {self.unit} was not measured in this run")
        if (self.figure is None) is not bool(self.absent):
            raise TypeError(f"{self.name}: needs a figure, or the reason for its absence")

    @property
    def ratios(self) -> list[float]:
        """Our times relative to the yardstick, turn by turn, sorted."""
        return sorted(theirs / ours if self.more_is_better else ours / theirs for theirs, ours in self.sides)

    @property
    def met(self) -> bool:
        """Whether the goal is met, if there is one and it could be measured."""
        if self.goal is None or self.figure is None:
            return True
        return self.figure >= self.goal if self.more_is_better else self.figure <= self.goal

    @property
    def verdict(self) -> str:
        """The verdict: "yes", "NO", "at the limit" or "no verdict"; empty without a goal."""
        if self.goal is None:
            return ""
        if self.figure is None:
            return "no verdict"
        close = self.met and self.goal and abs(self.figure - self.goal) < LIMIT * abs(self.goal)
        word = "NO" if not self.met else "at the limit" if close else "yes"
        return f"{word}, as measured on {self.when}" if self.when else word

    @property
    def shown(self) -> str:
        """The figure with its unit, and for a ratio the range of half of the turns."""
        if self.figure is None:
            return self.absent
        half = ""
        if len(self.sides) > 2:
            quarter = len(self.sides) // 4
            half = f" ({shown(self.ratios[quarter])} to {shown(self.ratios[-1 - quarter])})"
        return f"{shown(self.figure)}{half} {self.unit}".rstrip()

    @property
    def wanted(self) -> str:
        """The goal, in the format of the table."""
        return "" if self.goal is None else f"{'>=' if self.more_is_better else '<='} {self.goal:,g}"


def timed(action: Callable[[], T]) -> tuple[Measured, T]:
    """Return the CPU seconds of an action, and its result.

    The time of other programs is not included; their effect on the caches is.
    """
    start = process_time()
    result = action()
    return Measured(process_time() - start), result


def best(action: Callable[[], object], rounds: int = 7) -> Measured:
    """Return the least seconds of an action, from some runs after one that loads modules; caches are emptied."""
    action()
    times = []
    for _ in range(rounds):
        forget()
        times.append(timed(action)[0])
    return min(times)


def best_of(prepare: Callable[[], Callable[[], T]], rounds: int = 5) -> tuple[Measured, T]:
    """Return the least seconds of an action that is prepared each time, and its last result."""
    times = []
    for _ in range(rounds):
        action = prepare()
        forget()
        gc.collect()
        wall, result = timed(action)
        times.append(wall)
    return min(times), result


def by_turns(theirs: Callable[[], object], ours: Callable[[], object], turns: int = 7) -> Sides:
    """Return the seconds of two actions, turn by turn; each runs once before, to load modules."""
    return prepared_by_turns(lambda: theirs, lambda: ours, turns)


def prepared_by_turns(
    theirs: Callable[[], Callable[[], object]], ours: Callable[[], Callable[[], object]], turns: int = 7
) -> Sides:
    """Return the seconds of two actions, prepared for each turn; the order alternates."""
    theirs()(), ours()()
    sides = []
    for turn in range(turns):
        took = {}
        for prepare in (theirs, ours) if turn % 2 else (ours, theirs):
            action = prepare()
            forget()
            gc.collect()
            took[prepare] = timed(action)[0]
        sides.append((took[theirs], took[ours]))
    return sides


def shown(number: float) -> str:
    """Return a number with its significant digits."""
    return f"{number:,.0f}" if number >= 1000 else f"{number:.3g}"


def table(rows: Iterable[Row]) -> str:
    """Return the rows as a Markdown table."""
    out = io.StringIO()
    out.write("| workload | figure | goal | met | bottleneck |\n|---|---:|---:|---|---|\n")
    for name, bound, row in spelled_out(rows):
        out.write(f"| {name} | {row.shown} | {row.wanted} | {row.verdict} | {bound} |\n")
    return out.getvalue()


def spelled_out(rows: Iterable[Row]) -> Iterator[tuple[str, str, Row]]:
    """Yield each row with a name and bottleneck that are complete without the rows above: "the same" is replaced."""
    name = bound = ""
    for row in rows:
        if row.name.startswith("the same"):
            full = name.partition(": ")[0] + row.name.removeprefix("the same")
        else:
            full = name = row.name
        if row.bound.startswith("the same"):
            yield full, bound + row.bound.removeprefix("the same"), row
        else:
            bound = row.bound
            yield full, bound, row
