"""The GS-C modules' parameters for the ramp calculator: S, T, R and the ramp law.

The acceleration in a step is the amount by which v²/2 increases in that step, where v is the rate.  With
the ramp law `constant acceleration` it is the same in every step.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import floor, log

from ...core.datasheet.table import Sheet
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
    levels,
)
from ...language.rates import steps_per_s
from . import profile
from .sheet import POSITIONS, RATE_UNIT, TIMES

CLOCK = Clock(PS_PER_S)


class GscRamp(Ramp):
    """The ramp from S up to T in R steps."""

    def __init__(self, part: str, values: Values, crystal_hz: int) -> None:
        self.part, self.values, self.crystal_hz = part, values, crystal_hz
        start, top, length = (int(values[name]) for name in "STR")
        self.law = start, top, length, profile.LAWS[str(values["law"])]
        self.runs = profile.ramp(*self.law)
        self.start, self.top = float(RATE_UNIT * (start if self.runs else top)), float(RATE_UNIT * top)
        self.time_ps = sum(interval for interval, _ in self.runs)
        self.steps = len(self.runs)

    @property
    def acceleration(self) -> float:
        """The mean acceleration of all steps, steps/s^2; 0 without a ramp."""
        return (self.top**2 - self.start**2) / (2 * self.steps) if self.steps else 0.0

    @property
    def accelerations(self) -> Accelerations:
        """The first, mean and maximum accelerations, steps/s²."""
        squares = [(PS_PER_S / interval) ** 2 for interval, _ in self.runs] + [self.top**2]
        rises = [(after - before) / 2 for before, after in pairwise(squares)]
        return Accelerations(rises[0], self.acceleration, max(rises)) if rises else Accelerations(0, 0, 0)

    def table(self) -> Iterator[RampSegment]:
        """Yield the intervals of the ramp, one segment per step."""
        begin = 0
        for position, (interval, _) in enumerate(self.runs):
            yield RampSegment(begin, position, 1, PS_PER_S / interval)
            begin += interval

    @property
    def reached_from(self) -> int | None:
        """The number of steps in the shortest move that reaches the top speed; None if no move reaches it."""
        return least(lambda number: GscMove(self, number).reached, 1, len(POSITIONS[self.part]) - 1)

    @property
    def distances(self) -> tuple[int, int, str]:
        """The minimum and maximum numbers of steps in a move, and the parameter that sets them ("": none)."""
        return 1, len(POSITIONS[self.part]) - 1, ""

    def made(self, distance: int) -> GscMove:
        """Return the move of `distance` steps."""
        return GscMove(self, distance)


class GscMove(Move):
    """A whole move, up to the end of its last pulse, when MOV falls."""

    def __init__(self, ramp: GscRamp, number: int) -> None:
        plan = profile.move(number, *ramp.law)
        self.steps, self.runs = number, plan.runs
        shortest = min(interval for interval, _ in self.runs)
        self.reached = shortest <= profile.period(ramp.law[1])
        self.top = ramp.top if self.reached else PS_PER_S / shortest
        self.legs = [(leg.name, leg.count) for leg in plan.legs]

    @cached_property
    def train(self) -> StepTrain:
        """The step train of the move, computed when it is first needed."""
        return StepTrain(CLOCK, 0, self.runs)

    @cached_property
    def time_ps(self) -> int:  # type: ignore[override]
        """The duration of the move in ps."""
        return self.train.end(self.steps - 1) + TIMES["clock"].ticks

    def trains(self) -> tuple[StepTrain]:
        """Return the pulses of the move, as one train."""
        return (self.train,)


class GscRamps(Calculator):
    """The calculator of a GS-C module."""

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet
        rows = sheet.commands
        start, top, length = rows["S"], rows["T"], rows["R"]
        self.quantities = (
            RampParameter("S", start.description, start.args[0], per_s=1, measure=log, tried="10..80/5"),
            RampParameter("T", top.description, top.args[0], per_s=1, measure=log, tried="30..600/14"),
            RampParameter("R", length.description, length.args[0], free=True, measure=log, tried="1..800/12"),
            RampParameter(
                "law", "law of the rate between S and T", choices=tuple(profile.LAWS), default=next(iter(profile.LAWS))
            ),
        )

    def ramp(self, values: Values, crystal_hz: int) -> GscRamp:
        """Return the ramp for values of S, T, R and the ramp law."""
        return GscRamp(self.sheet.part, values, crystal_hz)

    def script(self, values: Values, steps: int) -> list[str]:
        """Return the lines that a host sends for a move of `steps` steps with the given values."""
        begin = self.sheet.commands.named("PROGRAM").form
        return [begin, *(f"{form}{values[form]}" for form in "STR"), f"+{steps}", "E"]

    def spoken(self, quantity: RampParameter, text: str, crystal_hz: int) -> int | None:
        """Return the value of S or T for a rate such as "500 steps/s"; None if the text is not a rate."""
        rate = steps_per_s(text)
        return None if rate is None else floor(rate / RATE_UNIT + Fraction(1, 2))

    def candidates(self, search: Search) -> Iterable[Candidate]:
        """Return the values of R whose ramps are nearest to the wanted result.

        A ramp with one more step is gentler and takes longer: at no step is its rate higher than at the same
        step of the shorter ramp.
        """
        sign = 1 if search.wanted.goal == "acceleration" else -1

        def measure(length: int) -> float:
            return sign * search.wanted.of(self.ramp({**search.fixed, "R": length}, search.crystal_hz))

        arg = self.arg("R")
        found = levels(measure, sign * search.wanted.value, arg.low, arg.high, search.best)
        return (Candidate({"R": length}) for length in found)


ramps = GscRamps  # calculators by sheet
