"""What every table of the benchmarks is made of: its rows, how a time is taken, and how two are compared."""

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
    """What a clock has counted in this run.

    Arithmetic turns it into a plain float, which no ratio accepts: a yardstick is what was measured, neither a constant
    nor something else times a constant.
    """


Sides = Sequence[tuple[Measured, Measured]]


@dataclass
class Row:
    """One line of a table; a figure that could not be measured is None, and `absent` says why.

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
            raise TypeError(f"{self.name}: a ratio takes what was measured in this run, unchanged")
        if self.sides:
            self.figure = median(self.ratios)
        elif self.unit.startswith("x ") and self.unit != REAL and not (self.absent or self.when):
            raise TypeError(f"{self.name}: {self.unit} was not measured in this run")
        if (self.figure is None) is not bool(self.absent):
            raise TypeError(f"{self.name}: needs a figure, or the reason why there is none")

    @property
    def ratios(self) -> list[float]:
        """Ours beside the yardstick, turn by turn, in order of size."""
        return sorted(theirs / ours if self.more_is_better else ours / theirs for theirs, ours in self.sides)

    @property
    def met(self) -> bool:
        """Whether the goal, if there is one and it could be measured, is met."""
        if self.goal is None or self.figure is None:
            return True
        return self.figure >= self.goal if self.more_is_better else self.figure <= self.goal

    @property
    def verdict(self) -> str:
        """Yes, NO, at the limit, no verdict; nothing without a goal."""
        if self.goal is None:
            return ""
        if self.figure is None:
            return "no verdict"
        close = self.met and self.goal and abs(self.figure - self.goal) < LIMIT * abs(self.goal)
        word = "NO" if not self.met else "at the limit" if close else "yes"
        return f"{word}, as measured on {self.when}" if self.when else word

    @property
    def shown(self) -> str:
        """The figure with its unit, and of a ratio the range of half of the turns."""
        if self.figure is None:
            return self.absent
        half = ""
        if len(self.sides) > 2:
            quarter = len(self.sides) // 4
            half = f" ({shown(self.ratios[quarter])} to {shown(self.ratios[-1 - quarter])})"
        return f"{shown(self.figure)}{half} {self.unit}".rstrip()

    @property
    def wanted(self) -> str:
        """The goal, as the table shows it."""
        return "" if self.goal is None else f"{'>=' if self.more_is_better else '<='} {self.goal:,g}"


def timed(action: Callable[[], T]) -> tuple[Measured, T]:
    """Seconds of the processor that an action takes, and what it returns.

    What other programs take meanwhile does not count; what they push out of the caches does.
    """
    start = process_time()
    result = action()
    return Measured(process_time() - start), result


def best(action: Callable[[], object], rounds: int = 7) -> Measured:
    """The least seconds of an action, of some runs after one that loads what it needs; nothing is remembered of it."""
    action()
    times = []
    for _ in range(rounds):
        forget()
        times.append(timed(action)[0])
    return min(times)


def best_of(prepare: Callable[[], Callable[[], T]], rounds: int = 5) -> tuple[Measured, T]:
    """The least seconds of an action that is prepared anew each time, and what it returned the last time."""
    times = []
    for _ in range(rounds):
        action = prepare()
        forget()
        gc.collect()
        wall, result = timed(action)
        times.append(wall)
    return min(times), result


def by_turns(theirs: Callable[[], object], ours: Callable[[], object], turns: int = 7) -> Sides:
    """The seconds of two actions, turn by turn; each runs once before, to load what it needs."""
    return prepared_by_turns(lambda: theirs, lambda: ours, turns)


def prepared_by_turns(
    theirs: Callable[[], Callable[[], object]], ours: Callable[[], Callable[[], object]], turns: int = 7
) -> Sides:
    """The seconds of two actions that are prepared anew each turn; the one that begins changes with each turn."""
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
    """A number with as many digits as it is worth."""
    return f"{number:,.0f}" if number >= 1000 else f"{number:.3g}"


def table(rows: Iterable[Row]) -> str:
    """The rows as a Markdown table."""
    out = io.StringIO()
    out.write("| what | figure | goal | | what bounds it |\n|---|---:|---:|---|---|\n")
    for row in rows:
        out.write(f"| {row.name} | {row.shown} | {row.wanted} | {row.verdict} | {row.bound} |\n")
    return out.getvalue()


def spelled_out(rows: Iterable[Row]) -> Iterator[tuple[str, str, Row]]:
    """Each row with its name and bound as they are read without the rows above: "the same" is replaced."""
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
