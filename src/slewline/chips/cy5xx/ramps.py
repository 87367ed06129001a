"""Ramp calculation for parts with slopes (slope.py), and for rates that grow with time (unit_ramps.py)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from math import log

from ...core.datasheet.table import Arg, Sheet
from ...core.motion.plan import Plan, Runs, steps
from ...core.motion.train import StepTrain
from ...core.time.timebase import PS_PER_S, Clock
from ...language.ramp_answers import (
    Accelerations,
    Calculator,
    Candidate,
    Move,
    Ramp,
    RampParameter,
    RampSegment,
    Search,
    Values,
    least,
)
from ...language.rates import nearest_rate
from .stepping.slope import Law

PlanMove = Callable[[int, int, int, int, Law], Plan]  # number, rate, slope (0: none), factor, law


class PlannedMove(Move):
    """A whole move, as planned by the part."""

    def __init__(self, ramp: Ramp, plan: Plan, number: int) -> None:
        clock = Clock(ramp.crystal_hz)
        self.train, self.steps = StepTrain(clock, 0, plan.runs), number
        self.time_ps = clock.ps(self.train.length)
        self.top = ramp.crystal_hz / min(interval for interval, _ in plan.runs)
        self.reached = self.top >= ramp.top
        self.legs = [(leg.name, leg.count) for leg in plan.legs]

    def trains(self) -> tuple[StepTrain]:
        """Return the move's step train."""
        return (self.train,)


class SlopeRamp(Ramp):
    """The ramp up to R from the rate parameter at which all ramps begin."""

    def __init__(self, of: SlopeRamps, values: Values, crystal_hz: int) -> None:
        self.of, self.values, self.crystal_hz, self.clock = of, values, crystal_hz, Clock(crystal_hz)
        self.part = of.sheet.part
        self.rate, self.slope = int(values["R"]), int(values["S"])
        self.runs = of.law.up(self.rate, self.slope)
        self.intervals = [interval for interval, _ in self.runs] + [of.law.period(self.rate)]
        self.start, self.top = (crystal_hz / self.intervals[end] for end in (0, -1))
        self.time_ps, self.steps = self.clock.ps(sum(self.intervals[:-1])), steps(self.runs)

    @property
    def accelerations(self) -> Accelerations:
        """The ramp's accelerations, each a rate increase divided by the duration of the step before the increase."""
        rates = [self.crystal_hz / interval for interval in self.intervals]
        rises = [(b - a) * a for a, b in pairwise(rates)]
        return Accelerations(rises[0], self.acceleration, max(rises)) if rises else Accelerations(0, 0, 0)

    def table(self) -> Iterator[RampSegment]:
        """Yield the steps of the ramp, each as one segment with its rate parameter."""
        ticks = 0
        for at, interval in enumerate(self.intervals[:-1]):
            parameter = self.of.law.start + at * self.slope
            yield RampSegment(self.clock.ps(ticks), at, 1, self.crystal_hz / interval, parameter)
            ticks += interval

    @property
    def reached_from(self) -> int | None:
        """The number of steps in the shortest move that reaches the rate of R; None if no move does."""
        return least(lambda number: self.made(number).reached, 1, self.of.number.high)

    @property
    def distances(self) -> tuple[int, int, str]:
        """The minimum and maximum numbers of steps in a move, and a text with the command that sets the number."""
        return self.of.number.low, self.of.number.high, " (N)"

    def made(self, distance: int) -> PlannedMove:
        """Return the move of `distance` steps."""
        return PlannedMove(self, self.of.plan_move(distance, self.rate, self.slope, 1, self.of.law), distance)


class SlopeRamps(Calculator):
    """The ramp calculator of a part with slopes (slope.py), for the parameters R and S.

    `plan_move` plans the moves of the part.
    """

    parameter = "rate"

    def __init__(self, sheet: Sheet, law: Law, plan_move: PlanMove) -> None:
        self.sheet, self.law, self.plan_move = sheet, law, plan_move
        self.number, rate, slope = (sheet.commands[form].args[0] for form in "NRS")
        self.slopes = range(max(slope.low, 1), slope.high + 1)
        self.quantities = (
            RampParameter(
                "R",
                sheet.commands["R"].description,
                rate,
                per_s=1,
                measure=lambda value: -log(law.period(value)),
                tried=f"{rate.low}..{rate.high}/16",
            ),
            RampParameter(
                "S", sheet.commands["S"].description, slope, free=True, tried=f"{self.slopes[0]}..{slope.high}/12"
            ),
        )

    def ramp(self, values: Values, crystal_hz: int) -> SlopeRamp:
        """Return the ramp for a set of values; `crystal_hz` is the crystal frequency."""
        return SlopeRamp(self, values, crystal_hz)

    def script(self, values: Values, steps: int) -> list[str]:
        """Return the commands that a host sends for a move of `steps` steps with the given values."""
        return ["A", *(f"{form} {values[form]}" for form in "RS"), f"N {steps}", "G"]

    def spoken(self, quantity: RampParameter, text: str, crystal_hz: int) -> int | None:
        """Return the parameter nearest to a rate in a text such as "500 steps/s"; None if the text is not a rate."""
        arg, where = self.arg(quantity.name), f"{self.sheet.part}: {quantity.name}"
        return nearest_rate(where, text, lambda each: Fraction(crystal_hz, self.law.period(each)), arg.low, arg.high)

    def candidates(self, search: Search) -> Iterator[Candidate]:
        """Yield one candidate for each S or, if S is fixed, a single candidate without values."""
        for slope in self.slopes if "S" in search.free else (None,):
            yield Candidate({} if slope is None else {"S": slope})


class UnitRamp(Ramp):
    """The ramp from rate parameter F up to rate parameter R.

    Args:
        part: the part's name, for messages.
        periods: clocks of a step by rate parameter; all periods differ.
        runs: the acceleration ramp.
        number: the range of N.
        plan: returns the plan of a move, given its number of steps.
    """

    def __init__(
        self,
        part: str,
        values: Values,
        crystal_hz: int,
        periods: Sequence[int],
        runs: Runs,
        number: Arg,
        plan: Callable[[int], Plan],
    ) -> None:
        self.part, self.values, self.crystal_hz, self.clock = part, values, crystal_hz, Clock(crystal_hz)
        self.periods, self.runs, self.number, self.plan = periods, runs, number, plan
        first, rate = int(values["F"]), int(values["R"])
        self.start, self.top = (crystal_hz / periods[each] for each in (first, max(first, rate)))
        self.time_ps = self.clock.ps(sum(interval * count for interval, count in runs))
        self.steps = steps(runs)

    @property
    def accelerations(self) -> Accelerations:
        """The ramp's accelerations, each a rate increase divided by the time spent at the rate before the increase."""
        stretches = [*self.table(), RampSegment(self.time_ps, self.steps, 0, self.top)]
        rises = [(b.rate - a.rate) * PS_PER_S / (b.begin_ps - a.begin_ps) for a, b in pairwise(stretches)]
        return Accelerations(rises[0], self.acceleration, max(rises)) if rises else Accelerations(0, 0, 0)

    def table(self) -> Iterator[RampSegment]:
        """Yield the ramp, one segment per rate."""
        ticks = position = 0
        rate = int(self.values["F"])
        for interval, count in self.runs:
            rate = self.periods.index(interval, rate)  # of rates with the same period, the first one above the last
            yield RampSegment(self.clock.ps(ticks), position, count, self.crystal_hz / interval, rate)
            ticks, position = ticks + interval * count, position + count

    @property
    def reached_from(self) -> int | None:
        """The number of steps in the shortest move that reaches the rate of R; None if no move does."""
        return least(lambda number: self.made(number).reached, 1, self.number.high)

    @property
    def distances(self) -> tuple[int, int, str]:
        """The minimum and maximum numbers of steps in a move, and a text with the command that sets the number."""
        return max(self.number.low, 1), self.number.high, f" ({self.number.name}, N)"

    def made(self, distance: int) -> PlannedMove:
        """Return the move of `distance` steps."""
        return PlannedMove(self, self.plan(distance), distance)
