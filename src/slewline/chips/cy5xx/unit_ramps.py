"""Ramps and moves of a calculator where the rate parameter grows with time (units.py)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

from ...core.datasheet.table import Arg
from ...core.motion.plan import Plan, Runs, steps
from ...core.motion.train import StepTrain
from ...core.time.timebase import PS_PER_S, Clock
from ...language.ramps import Accelerations, Move, Ramp, RampSegment, Values, least


class UnitRamp(Ramp):
    """The way up from F to R.

    Args:
        part: its name, for messages.
        periods: clocks of a step by rate parameter; none of two rates is the same.
        runs: the way up.
        number: what N may be.
        plan: a move of so many steps.
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
        """Every rise of the rate over the time for which the lower rate lasted."""
        stretches = [*self.table(), RampSegment(self.time_ps, self.steps, 0, self.top)]
        rises = [(b.rate - a.rate) * PS_PER_S / (b.begin_ps - a.begin_ps) for a, b in pairwise(stretches)]
        return Accelerations(rises[0], self.acceleration, max(rises)) if rises else Accelerations(0, 0, 0)

    def table(self) -> Iterator[RampSegment]:
        """Yield the ramp rate by rate."""
        ticks = position = 0
        rate = int(self.values["F"])
        for interval, count in self.runs:
            rate = self.periods.index(interval, rate)  # of rates with one period the first one above the last
            yield RampSegment(self.clock.ps(ticks), position, count, self.crystal_hz / interval, rate)
            ticks, position = ticks + interval * count, position + count

    @property
    def reached_from(self) -> int | None:
        """The steps of the shortest move that reaches the rate."""
        return least(lambda number: UnitMove(self, number).reached, 1, self.number.high)

    @property
    def distances(self) -> tuple[int, int, str]:
        return max(self.number.low, 1), self.number.high, f" ({self.number.name}, N)"

    def made(self, distance: int) -> UnitMove:
        return UnitMove(self, distance)


class UnitMove(Move):
    """A whole move, as the part plans it."""

    def __init__(self, ramp: UnitRamp, number: int) -> None:
        plan = ramp.plan(number)
        self.train, self.steps = StepTrain(ramp.clock, 0, plan.runs), number
        self.time_ps = ramp.clock.ps(self.train.length)
        self.top = ramp.crystal_hz / min(interval for interval, _ in plan.runs)
        self.reached = self.top >= ramp.top
        self.legs = [(leg.name, leg.count) for leg in plan.legs]

    def trains(self) -> tuple[StepTrain]:
        """Return the train of its steps."""
        return (self.train,)
