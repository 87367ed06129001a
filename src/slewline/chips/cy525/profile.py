"""The law of motion of the CY525: parameters in, a plan out.  Pure functions, whole clocks.

    rate
      R ..............._______________
                     /|              |\\            one rate unit every Z * (256 - S) * 479 clocks,
                   _/ |              | \\_          looked at when a step begins; several units may be due at once
                 _/   |              |   \\_
      F ........|     |              |     |_____
                | up  |     slew     | down|crawl|
      steps       ramp   >= 256 or 0   ramp  rest          (s.8)

The rate parameter, not the rate, grows linearly; Table VII turns it into steps per second.  The way down is the mirror
of the way up.  Where fewer than 256 steps would be left for slewing, none is slewed: the way down begins at once and
the surplus is made at F (s.8, special case).  Where the travel is too short to reach R, both ramps get half of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from ...core.train import OPEN
from ...errors import SlewlineError
from .sheet import RAMP_UNIT_TICKS, RATE_TOP, SHORT_SLEW_STEPS, STEP_TICKS

Runs = tuple[tuple[int, int], ...]  # (interval in clocks, count)
RATE_OF = {ticks: rate for rate, ticks in enumerate(STEP_TICKS)}


def unit_ticks(slope: int, divisor: int) -> int:
    """Clocks that one rate unit takes.  S = 0 counts as 256 - 0; Z = 0 is an 8-bit counter run through: 256."""
    return (divisor or 256) * (256 - slope) * RAMP_UNIT_TICKS


@lru_cache(maxsize=256)
def ramp(low: int, high: int, slope: int, divisor: int) -> Runs:
    """The way up: runs from the first step at rate `low` to the last one below rate `high`; empty unless low < high."""
    unit = unit_ticks(slope, divisor)
    runs = []
    elapsed, rate = 0, low
    while rate < high:
        interval = STEP_TICKS[rate]
        count = -((elapsed - (rate - low + 1) * unit) // interval)  # steps until the next unit is due, rounded up
        runs.append((interval, count))
        elapsed += interval * count
        rate = low + elapsed // unit
    return tuple(runs)


def mirrored(runs: Runs) -> Runs:
    """The same runs backwards: the way down."""
    return runs[::-1]


def steps(runs: Sequence[tuple[int, int]]) -> int:
    """How many steps there are in some runs."""
    return sum(count for _, count in runs)


def head(runs: Runs, count: int) -> Runs:
    """The first `count` steps of some runs."""
    out = []
    for interval, n in runs:
        if count <= 0:
            break
        out.append((interval, min(n, count)))
        count -= n
    return tuple(out)


def tail(runs: Runs, first: int) -> Runs:
    """What is left of some runs when the first steps are over."""
    out = []
    for interval, n in runs:
        if first < n:
            out.append((interval, n - max(first, 0)))
        first -= n
    return tuple(out)


@dataclass(frozen=True, slots=True)
class Leg:
    """A part of a plan: "up", "slew", "down" or "crawl".  The SLEW pin is low in a slew and high elsewhere."""

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
    """A move before it is played: legs that follow each other step by step."""

    legs: tuple[Leg, ...]

    @property
    def runs(self) -> Runs:
        """All runs of intervals, in clocks."""
        return tuple(run for leg in self.legs for run in leg.runs)

    @property
    def steps(self) -> int:
        """How many steps the move takes; OPEN and more for a continuous one."""
        return self.legs[-1].end if self.legs else 0

    def leg(self, step: int) -> Leg:
        """The leg that a step belongs to."""
        return next(leg for leg in self.legs if step < leg.end)

    def rate(self, step: int) -> int:
        """The rate parameter of a step."""
        leg = self.leg(step)
        left = step - leg.first
        for interval, count in leg.runs:
            if left < count:
                return RATE_OF[interval]
            left -= count
        raise AssertionError("a leg counts its own runs")

    def verified(self, number: int | None = None) -> Plan:
        """The plan itself, after one check of what every plan must keep: exact count, no step faster than the table.

        Raises:
            SlewlineError: the planner made a mistake (never the user).
        """
        at = 0
        for leg in self.legs:
            if (
                leg.first != at
                or leg.count != steps(leg.runs)
                or any(interval < STEP_TICKS[RATE_TOP] or n < 1 for interval, n in leg.runs)
            ):
                raise SlewlineError(f"plan {self} does not hold together")
            at = leg.end
        if number is not None and at != number:
            raise SlewlineError(f"plan {self} takes {at} steps instead of {number}")
        return self


def plan(*parts: tuple[str, Runs]) -> Plan:
    """A plan from named parts; empty ones fall out."""
    legs, first = [], 0
    for name, runs in parts:
        count = steps(runs)
        if count:
            legs.append(Leg(name, runs, first, count))
            first += count
    return Plan(tuple(legs))


def move(number: int, first: int, rate: int, slope: int, divisor: int) -> Plan:
    """A normal move of `number` steps from rest to rest.

    Args:
        number: steps, 1 to 65535.
        first, rate: rate parameters F and R, 0 to 127; R below F runs at F.
        slope, divisor: S and Z, 0 to 255.
    """
    up = ramp(first, rate, slope, divisor)
    full = steps(up)
    if 2 * full > number:
        up = head(up, number // 2)
    rest = number - 2 * min(full, number // 2)
    slew = rest if rest >= SHORT_SLEW_STEPS else 0
    top = max(first, rate)
    return plan(
        ("up", up),
        ("slew", ((STEP_TICKS[top], slew),) if slew else ()),
        ("down", mirrored(up)),
        ("crawl", ((STEP_TICKS[first], rest - slew),) if rest > slew else ()),
    ).verified(number)


def steady(rate: int, before: tuple[str, Runs] = ("up", ())) -> Plan:
    """A change of rate in a continuous motion: a ramp, then steps at `rate` without end."""
    return plan(before, ("slew", ((STEP_TICKS[rate], OPEN),)))
