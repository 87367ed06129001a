"""Rates and slopes where the rate parameter grows by S with each step.  Pure functions, whole clocks.

    rate parameter
      R ........______
              _|      |_          step i of a ramp has the parameter start + (i - 1) * S; the period of a step falls
            _|          |_        with the parameter, so the speed grows steeper and steeper
    start _|              |_
          |up | slew |down|

Without a slope every step is made at R, divided by the factor.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from ...core.ideal import FOREVER, Ideal, IdealPiece
from ...core.motions import Parameters
from ...core.plan import Plan, Runs, steps
from ...core.table import Sheet
from ...core.timebase import Clock
from ...core.train import OPEN, StepTrain
from ...errors import UsageError
from ...language.ramps import Accelerations, Calculator, Candidate, Move, Quantity, Ramp, Search, Stretch, Values, least
from ...language.rates import steps_per_s


class Law(NamedTuple):
    """The periods of steps, in clocks, by rate parameter from 0 on, and the parameter of the first step of a ramp."""

    periods: tuple[int, ...]
    start: int = 1

    @property
    def top(self) -> int:
        """The highest rate parameter; those above it count as this one."""
        return len(self.periods) - 1

    def period(self, rate: int, factor: int = 1) -> int:
        """Return the clocks of a step at a rate parameter."""
        return self.periods[min(rate, self.top)] * factor

    def up(self, rate: int, slope: int, factor: int = 1) -> Runs:
        """Return the way up to a rate, the steps whose parameter is below it; a slope of 0 has none."""
        ramp = range(self.start, min(rate, self.top), slope) if slope else ()
        return tuple((self.periods[each] * factor, 1) for each in ramp)


PlanMove = Callable[[int, int, int, int, Law], Plan]  # number, rate, slope (0: none), factor, law


class Made(NamedTuple):
    """The parameters of a motion, as they were when it began; a slope of 0 is none, `factor` the one that counts."""

    crystal_hz: int
    rate: int
    slope: int
    factor: int
    number: int
    law: Law

    def parameters(self) -> Parameters:
        """What a picture names: the rate of R, and S, F, N."""
        return Parameters(self.rates(), {"S": self.slope, "F": self.factor, "N": self.number})

    def rates(self) -> Mapping[str, float]:
        """The rate that the motion is to reach, by name."""
        return {f"R = {self.rate}": self.crystal_hz / self.law.period(self.rate, self.factor)}

    def ideal(self, runs: Runs, start: int, position: int, sign: int) -> Ideal:
        """Return the ideal of a plan: its rates one after the other, since the law itself goes from step to step.

        Args:
            runs: of the plan.
            start: of the first step, ps.
            position: before it.
            sign: 1 clockwise, -1 counter-clockwise.
        """
        lasting = ((interval / self.crystal_hz, n) for interval, n in runs)
        pieces = [IdealPiece(s * n if n < OPEN else FOREVER, 1 / s) for s, n in lasting]
        return Ideal(start, position, pieces or [IdealPiece(0.0, 0.0)], sign)


# ----------------------------------------------------------------------------------------------- the ramp calculator
class SlopeRamp(Ramp):
    """The way up from the first parameter to R."""

    def __init__(self, of: SlopeRamps, values: Values, crystal_hz: int) -> None:
        self.of, self.values, self.crystal_hz, self.clock = of, values, crystal_hz, Clock(crystal_hz)
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

    def table(self) -> Iterator[Stretch]:
        ticks = 0
        for at, interval in enumerate(self.intervals[:-1]):
            parameter = self.of.law.start + at * self.slope
            yield Stretch(self.clock.ps(ticks), at, 1, self.crystal_hz / interval, parameter)
            ticks += interval

    @property
    def reached_from(self) -> int | None:
        return least(lambda number: self.move(number).reached, 1, self.of.number.high)

    def move(self, distance: int) -> SlopeMove:
        if not self.of.number.allows(distance):
            allowed = f"{self.of.number.low}..{self.of.number.high} (N)"
            raise UsageError(f"{self.of.sheet.part}: a move of {distance} steps; allowed {allowed}")
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
            Quantity("R", sheet.commands["R"].says, rate, per_s=1),
            Quantity("S", sheet.commands["S"].says, slope, free=True),
            *[Quantity("F", sheet.commands["F"].says, factor, default=1)] * divides,
        )

    def ramp(self, values: Values, crystal_hz: int) -> SlopeRamp:
        return SlopeRamp(self, values, crystal_hz)

    def spoken(self, quantity: Quantity, text: str, crystal_hz: int) -> int | None:
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
