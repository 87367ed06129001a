"""The CY525's parameters for the ramp calculator: F, R, S and Z; the manual's own program is in section 8.

The manual's program uses one value of D, the difference between adjacent rates, for all rates; here the
ramp is computed step by step (profile.py), at the frequency of the crystal that is fitted.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache
from heapq import merge
from itertools import accumulate, pairwise
from math import log

from ...core.datasheet.table import Sheet
from ...core.time.timebase import PS_PER_S
from ...language.ramp_answers import Calculator, Candidate, RampParameter, Search, Values
from ...language.rates import nearest_rate
from ..cy5xx.ramps import UnitRamp
from ..cy5xx.sheet import COMMANDS
from . import profile
from .sheet import RAMP_UNIT, STEP_TICKS

NUMBER = COMMANDS["N"].args[0]
SLOPE, DIVISOR = COMMANDS["S"].args[0], COMMANDS["Z"].args[0]


def rate_of(parameter: int) -> float:
    """Return the logarithm of a rate (plus a constant), so that equal ratios of rates give equal differences."""
    return -log(STEP_TICKS[parameter])


def steepness(slope: int) -> float:
    """Return the logarithm of a value that is roughly proportional to the acceleration."""
    return -log(256 - slope)


QUANTITIES = (
    RampParameter("F", COMMANDS["F"].description, COMMANDS["F"].args[0], per_s=1, measure=rate_of, tried="1..12/5"),
    RampParameter("R", COMMANDS["R"].description, COMMANDS["R"].args[0], per_s=1, measure=rate_of, tried="4..80/14"),
    RampParameter("S", COMMANDS["S"].description, SLOPE, free=True, measure=steepness, tried="1..250/12"),
    RampParameter("Z", COMMANDS["Z"].description, DIVISOR, default=1, free=True),
    RampParameter(RAMP_UNIT.name, "chip option: a rate unit at S 255, Z 1", RAMP_UNIT, default=profile.LAW.unit),
    RampParameter("ramp_jumps", "chip option: several units per step", choices=("False", "True"), default="False"),
)


def law_of(values: Values) -> profile.Law:
    """Return the law selected by two of the values, the chip options `ramp_unit` and `ramp_jumps`."""
    return profile.Law(int(values["ramp_unit"]), values["ramp_jumps"] == "True")


class Cy525Ramps(Calculator):
    """The ramp calculator of the CY525."""

    quantities = QUANTITIES
    parameter = "rate"

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet

    def ramp(self, values: Values, crystal_hz: int) -> UnitRamp:
        """Return the ramp for values of F, R, S and Z; `crystal_hz` is the crystal frequency."""
        first, rate, slope, divisor = (int(values[name]) for name in "FRSZ")
        law = first, rate, slope, divisor, law_of(values)
        runs = profile.ramp(*law)
        return UnitRamp(
            self.sheet.part, values, crystal_hz, STEP_TICKS, runs, NUMBER, lambda number: profile.move(number, *law)
        )

    def script(self, values: Values, steps: int) -> list[str]:
        """Return the commands that a host sends for a move of `steps` steps with the given values."""
        return ["A 0", *(f"{form} {values[form]}" for form in "FRSZ"), f"N {steps}", "G"]

    def spoken(self, quantity: RampParameter, text: str, crystal_hz: int) -> int | None:
        """Return the rate parameter nearest to a rate such as "500 steps/s"; None if the text is not a rate."""
        top = len(STEP_TICKS) - 1
        return nearest_rate(
            f"cy525: {quantity.name}", text, lambda each: Fraction(crystal_hz, STEP_TICKS[each]), 0, top, " (T.VII)"
        )

    def candidates(self, search: Search) -> Iterator[Candidate]:
        """Yield one pair of S and Z for every possible duration of a rate unit: the pair with the smallest Z."""
        slopes, divisors = (
            range(arg.low, arg.high + 1) if name in search.free else range(fixed := int(search.fixed[name]), fixed + 1)
            for name, arg in (("S", SLOPE), ("Z", DIVISOR))
        )
        bounds = Bounds(search)
        listed = every_unit(slopes, divisors, law_of(search.fixed))
        rising = listed if search.wanted.goal != "acceleration" else listed[::-1]

        def candidate(index: int) -> Candidate:
            unit, pair = rising[index]
            values = {name: value for name, value in zip("SZ", pair, strict=True) if name in search.free}
            return Candidate(values, bounds.of(unit))

        middle = bisect_left(rising, search.wanted.value, key=lambda each: bounds.of(each[0])[1])
        above, below = range(middle, len(rising)), range(middle - 1, -1, -1)
        return merge(
            *(map(candidate, side) for side in (above, below)), key=lambda each: search.wanted.beyond(each.bounds)
        )


@lru_cache(maxsize=4)
def every_unit(slopes: range, divisors: range, law: profile.Law) -> list[tuple[int, tuple[int, int]]]:
    """Return every possible duration of a rate unit, ascending (clocks), each with one pair of S and Z.

    Of all pairs that give a duration, it is the pair with the lowest Z.
    """
    units: dict[int, tuple[int, int]] = {}
    for divisor in divisors:
        for slope in slopes:
            units.setdefault(profile.unit_ticks(slope, divisor, law), (slope, divisor))
    return sorted(units.items())


class Bounds:
    """Bounds of the searched quantity of a ramp, so that most ramps need not be calculated.

    A unit is an increase of the rate parameter by one.  With u clocks per unit, unit k is due at k * u.  It is
    taken at the start of a step: not before k * u, and not after k * u + (the sum of one step interval at each
    of the k rates before it).  The bounds of the ramp's time follow from its last unit.  The number of steps is
    the sum, over the rates, of (time at the rate) / (step interval at the rate); its bounds follow from all units.
    """

    def __init__(self, search: Search) -> None:
        first, rate = (int(search.fixed[name]) for name in "FR")
        intervals = STEP_TICKS[first:rate]
        self.goal, self.hz = search.wanted.goal, search.crystal_hz
        self.units, self.late = len(intervals), sum(intervals)
        self.gain = self.hz / STEP_TICKS[max(first, rate)] - self.hz / STEP_TICKS[first]
        self.per_tick = sum(1 / interval for interval in intervals)
        late = list(accumulate(intervals))  # of unit k + 1
        self.fewer = sum(
            by * (1 / after - 1 / before) for by, (before, after) in zip(late, pairwise(intervals), strict=False)
        )
        self.more = self.late / intervals[-1] if intervals else 0.0

    def of(self, unit: int) -> tuple[float, float]:
        """Return the least and the greatest possible value of the searched quantity, for `unit` clocks per unit."""
        if self.goal == "steps":
            return self.per_tick * unit - self.fewer - 1, self.per_tick * unit + self.more + 1
        low, high = (ticks * PS_PER_S / self.hz for ticks in (self.units * unit, self.units * unit + self.late))
        if self.goal == "time":
            return low - 1, high + 1
        slack = 1e-9 * self.gain * PS_PER_S / low if low else 0.0
        return (self.gain * PS_PER_S / high - slack, self.gain * PS_PER_S / low + slack) if low else (0.0, 0.0)


ramps = Cy525Ramps  # calculators by sheet
