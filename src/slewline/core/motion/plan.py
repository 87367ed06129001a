r"""A move before it is played: legs of runs of equal intervals, in ticks of a clock.

rate
       _______________
      /|              |\
    _/ |              | \_
   | up|     slew     |down|       legs follow each other step by step; a leg is a few runs (interval, count)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

from ...errors import PlanError

Runs = tuple[tuple[int, int], ...]  # (interval in clocks, count)


def mirrored(runs: Runs) -> Runs:
    """Return the runs backwards: the way down of a way up."""
    return runs[::-1]


def steps(runs: Sequence[tuple[int, int]]) -> int:
    """Return how many steps there are in some runs."""
    return sum([count for _, count in runs])  # of a hundred runs twice as quick as without the list


def head(runs: Runs, count: int) -> Runs:
    """Return the first `count` steps of some runs."""
    out = []
    for interval, n in runs:
        if count <= 0:
            break
        out.append((interval, min(n, count)))
        count -= n
    return tuple(out)


def tail(runs: Runs, first: int) -> Runs:
    """Return the runs from step `first` on, counted from 0."""
    out = []
    for interval, n in runs:
        if first < n:
            out.append((interval, n - max(first, 0)))
        first -= n
    return tuple(out)


@dataclass(frozen=True, slots=True)
class Leg:
    """A named part of a plan: "up", "slew", "down" ..."""

    name: str
    runs: Runs
    first: int
    count: int

    @property
    def end(self) -> int:
        """Index of the step after the last one of this leg."""
        return self.first + self.count


@dataclass(frozen=True, slots=True)
class Plan:
    """Legs that follow each other step by step; no interval is shorter than `shortest`."""

    legs: tuple[Leg, ...]
    shortest: int = 1

    @property
    def runs(self) -> Runs:
        """All runs of intervals, in clocks."""
        return tuple(chain.from_iterable([leg.runs for leg in self.legs]))

    @property
    def steps(self) -> int:
        """How many steps the move takes; OPEN and more for a continuous one."""
        return self.legs[-1].end if self.legs else 0

    def leg(self, step: int) -> Leg:
        """Return the leg that a step, counted from 0, belongs to."""
        return next(leg for leg in self.legs if step < leg.end)

    def interval(self, step: int) -> int:
        """Return the clocks from the start of a step, counted from 0, to its end."""
        leg = self.leg(step)
        left = step - leg.first
        for interval, count in leg.runs:
            if left < count:
                return interval
            left -= count
        raise AssertionError("a leg counts its own runs")

    def verified(self, number: int | None = None) -> Plan:
        """Return the plan itself after checking it: exact number of steps, none faster than allowed.

        Raises:
            PlanError: the planner made a mistake (never the user).
        """
        at = 0
        for leg in self.legs:
            intervals, counts = [interval for interval, _ in leg.runs], [count for _, count in leg.runs]
            if (
                leg.first != at
                or leg.count != sum(counts)
                or min(intervals, default=self.shortest) < self.shortest
                or min(counts, default=1) < 1
            ):
                raise PlanError(f"plan {self} is inconsistent")
            at = leg.end
        if number is not None and at != number:
            raise PlanError(f"plan {self} takes {at} steps instead of {number}")
        return self


def plan(*parts: tuple[str, Runs], shortest: int = 1) -> Plan:
    """Return a plan of named legs, each of runs (interval in clocks, count of steps); empty legs are left out."""
    legs, first = [], 0
    for name, runs in parts:
        count = steps(runs)
        if count:
            legs.append(Leg(name, runs, first, count))
            first += count
    return Plan(tuple(legs), shortest)
