"""The ramp calculator of parts with slopes (slope.py)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import pairwise

from ...core.datasheet.table import Sheet
from ...core.motion.plan import Plan, steps
from ...core.motion.train import StepTrain
from ...core.time.timebase import Clock
from ...errors import UsageError
from ...language.ramps import (
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
from ...language.rates import steps_per_s
from .slope import Law

PlanMove = Callable[[int, int, int, int, Law], Plan]  # number, rate, slope (0: none), factor, law


class SlopeRamp(Ramp):
    """The way up from the first parameter to R."""

    def __init__(self, of: SlopeRamps, values: Values, crystal_hz: int) -> None:
        self.of, self.values, self.crystal_hz, self.clock = of, values, crystal_hz, Clock(crystal_hz)
        self.part = of.sheet.part
        self.rate, self.slope, self.factor = int(values["R"]), int(values["S"]), int(values.get("F", 1))
        self.runs = of.law.up(self.rate, self.slope, self.factor)
        self.intervals = [interval for interval, _ in self.runs] + [of.law.period(self.rate, self.factor)]
        self.start, self.top = (crystal_hz / self.intervals[end] for end in (0, -1))
        self.time_ps, self.steps = self.clock.ps(sum(self.intervals[:-1])), steps(self.runs)

    @property
    def accelerations(self) -> Accelerations:
        """Every rise of the rate over the step that it takes."""
        rates = [self.crystal_hz / interval for interval in self.intervals]
        rises = [(b - a) * a for a, b in pairwise(rates)]
        return Accelerations(rises[0], self.acceleration, max(rises)) if rises else Accelerations(0, 0, 0)

    def table(self) -> Iterator[RampSegment]:
        ticks = 0
        for at, interval in enumerate(self.intervals[:-1]):
            parameter = self.of.law.start + at * self.slope
            yield RampSegment(self.clock.ps(ticks), at, 1, self.crystal_hz / interval, parameter)
            ticks += interval

    @property
    def reached_from(self) -> int | None:
        return least(lambda number: self.made(number).reached, 1, self.of.number.high)

    @property
    def distances(self) -> tuple[int, int, str]:
        return self.of.number.low, self.of.number.high, " (N)"

    def made(self, distance: int) -> SlopeMove:
        return SlopeMove(self, distance)


class SlopeMove(Move):
    """A whole move, as the part plans it."""

    def __init__(self, ramp: SlopeRamp, number: int) -> None:
        plan = ramp.of.plan_move(number, ramp.rate, ramp.slope, ramp.factor, ramp.of.law)
        self.train, self.steps = StepTrain(ramp.clock, 0, plan.runs), number
        self.time_ps = ramp.clock.ps(self.train.length)
        self.top = ramp.crystal_hz / min(interval for interval, _ in plan.runs)
        self.reached = self.top >= ramp.top
        self.legs = [(leg.name, leg.count) for leg in plan.legs]

    def trains(self) -> tuple[StepTrain]:
        return (self.train,)


class SlopeRamps(Calculator):
    """The calculator of a part with such slopes: R, S, and F where it `divides` a slope, too.

    A move is as `plan_move` plans it.
    """

    parameter = "rate"

    def __init__(self, sheet: Sheet, law: Law, plan_move: PlanMove, divides: bool = False) -> None:
        self.sheet, self.law, self.plan_move = sheet, law, plan_move
        self.number, rate, slope, factor = (sheet.commands[form].args[0] for form in "NRSF")
        self.slopes = range(max(slope.low, 1), slope.high + 1)
        self.quantities = (
            RampParameter("R", sheet.commands["R"].says, rate, per_s=1),
            RampParameter("S", sheet.commands["S"].says, slope, free=True),
            *[RampParameter("F", sheet.commands["F"].says, factor, default=1)] * divides,
        )

    def ramp(self, values: Values, crystal_hz: int) -> SlopeRamp:
        return SlopeRamp(self, values, crystal_hz)

    def spoken(self, quantity: RampParameter, text: str, crystal_hz: int) -> int | None:
        rate = steps_per_s(text)
        if rate is None:
            return None
        arg = self.arg(quantity.name)
        slowest, fastest = (Fraction(crystal_hz, self.law.period(end)) for end in (arg.low, arg.high))
        if not slowest / 2 <= rate <= fastest * 2:
            found = f"{self.sheet.part}: {quantity.name} {text.strip()}"
            raise UsageError(f"{found}; allowed {float(slowest):.0f}..{float(fastest):.0f} steps/s")
        every = range(arg.low, arg.high + 1)
        return min(every, key=lambda each: abs(Fraction(crystal_hz, self.law.period(each)) - rate))

    def candidates(self, search: Search) -> Iterator[Candidate]:
        """Yield every S: there are few, and none is costly."""
        for slope in self.slopes if "S" in search.free else (None,):
            yield Candidate({} if slope is None else {"S": slope})
