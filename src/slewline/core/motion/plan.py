r"""A planned move: legs that consist of runs of equal intervals, in clock ticks.

rate
       _______________
      /|              |\
    _/ |              | \_
   | up|     slew     |down|       there is no gap between legs; a leg has a few runs (interval, count)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain

from ...errors import PlanError

Runs = tuple[tuple[int, int], ...]  # (interval in clocks, count)


def mirrored(runs: Runs) -> Runs:
    """Return the runs in reverse order: the deceleration that mirrors an acceleration."""
    return runs[::-1]


def steps(runs: Sequence[tuple[int, int]]) -> int:
    """Return the total number of steps in the runs."""
    return sum([count for _, count in runs])  # for a hundred runs, the list makes this twice as fast


def head(runs: Runs, count: int) -> Runs:
    """Return the runs that make up the first `count` steps; the last run is shortened if necessary."""
    out = []
    for interval, n in runs:
        if count <= 0:
            break
        out.append((interval, min(n, count)))
        count -= n
    return tuple(out)


def tail(runs: Runs, first: int) -> Runs:
    """Return the runs from step `first` on; steps are counted from 0."""
    out = []
    for interval, n in runs:
        if first < n:
            out.append((interval, n - max(first, 0)))
        first -= n
    return tuple(out)


@dataclass(frozen=True, slots=True)
class Leg:
    """A named segment of a plan.

    Attributes:
        name: "up", "slew", "down" ...
        runs: pairs (interval in clocks, number of steps).
        first: the index in the plan of the leg's first step, from 0.
        count: the number of steps.
        end: the index, in the plan, of the step that follows the last step of this leg.
    """

    name: str
    runs: Runs
    first: int
    count: int
    end: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "end", self.first + self.count)


@dataclass(frozen=True, slots=True)
class Plan:
    """A planned motion: legs that follow one another.

    Attributes:
        legs: the legs, in chronological order.
        shortest: the shortest interval allowed, in clocks.
        steps: the number of steps; for a motion without end, OPEN (train.py) or more.
    """

    legs: tuple[Leg, ...]
    shortest: int = 1
    steps: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "steps", self.legs[-1].end if self.legs else 0)

    @property
    def runs(self) -> Runs:
        """The runs of all legs: pairs (interval in clocks, number of steps)."""
        return tuple(chain.from_iterable([leg.runs for leg in self.legs]))

    def leg(self, step: int) -> Leg:
        """Return the leg to which a step of the plan belongs; steps are counted from 0."""
        for leg in self.legs:
            if step < leg.end:
                return leg
        raise IndexError(f"step {step} of a plan of {self.steps}")

    def interval(self, step: int) -> int:
        """Return the duration of a step, in clocks; steps are counted from 0."""
        leg = self.leg(step)
        left = step - leg.first
        for interval, count in leg.runs:
            if left < count:
                return interval
            left -= count
        raise AssertionError("the runs of a leg do not cover all of its steps")

    def verified(self, number: int | None = None) -> Plan:
        """Check the plan, and return it.

        Args:
            number: the number of steps that the plan must have; None for any number.

        Raises:
            PlanError: legs that do not follow one another, an interval shorter than allowed, or a wrong number
                of steps: a fault in a planner, never a user error.
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
    """Return a plan made up of legs, each given as a name and runs; legs without steps are left out.

    Args:
        parts: pairs (name, runs); runs are pairs (interval in clocks, number of steps).
        shortest: the shortest interval allowed, in clocks, which `Plan.verified` checks.
    """
    legs, first = [], 0
    for name, runs in parts:
        count = steps(runs)
        if count:
            legs.append(Leg(name, runs, first, count))
            first += count
    return Plan(tuple(legs), shortest)
