"""What every table of the benchmarks is made of: its rows, and how a time is taken."""

from __future__ import annotations

import gc
import io
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from time import process_time
from typing import TypeVar

from caches import forget

T = TypeVar("T")


@dataclass
class Row:
    """One line of a table."""

    name: str
    figure: float
    unit: str
    goal: float | None
    more_is_better: bool
    bound: str

    @property
    def met(self) -> bool:
        """Is the goal met, if there is one?"""
        return self.goal is None or (self.figure >= self.goal if self.more_is_better else self.figure <= self.goal)


def timed(action: Callable[[], T]) -> tuple[float, T]:
    """Seconds of the processor that an action takes, and what it returns.

    What other programs take meanwhile does not count; what they push out of the caches does.
    """
    start = process_time()
    result = action()
    return process_time() - start, result


def best(action: Callable[[], object], rounds: int = 7) -> float:
    """The least seconds of an action, of some runs after one that loads what it needs; nothing is remembered of it."""
    action()
    times = []
    for _ in range(rounds):
        forget()
        times.append(timed(action)[0])
    return min(times)


def best_of(prepare: Callable[[], Callable[[], T]], rounds: int = 5) -> tuple[float, T]:
    """The least seconds of an action that is prepared anew each time, and what it returned the last time."""
    times = []
    for _ in range(rounds):
        action = prepare()
        forget()
        gc.collect()
        wall, result = timed(action)
        times.append(wall)
    return min(times), result


def shown(number: float) -> str:
    """A number with as many digits as it is worth."""
    return f"{number:,.0f}" if number >= 1000 else f"{number:.3g}"


def table(rows: Iterable[Row]) -> str:
    """The rows as a Markdown table."""
    out = io.StringIO()
    out.write("| what | figure | goal | | what bounds it |\n|---|---:|---:|---|---|\n")
    for row in rows:
        goal = "" if row.goal is None else f"{'>=' if row.more_is_better else '<='} {row.goal:,g}"
        met = "" if row.goal is None else "yes" if row.met else "NO"
        out.write(f"| {row.name} | {shown(row.figure)} {row.unit} | {goal} | {met} | {row.bound} |\n")
    return out.getvalue()
