"""Trapezoids and S-curves of the MC1451A family for the ramp calculator, in the units of their commands.

Both profiles are computed in cycles of the chipset.  The ramp of a trapezoid ends when the first
cycle at the maximum velocity begins; the ramp of an S-curve ends with its phase 3.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, cached_property
from itertools import pairwise
from math import log

from ...core.datasheet.table import Arg, Sheet
from ...core.motion.train import OPEN
from ...core.time.timebase import Clock
from ...errors import UsageError
from ...language import rates
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
from .profiles import profile
from .profiles.cycle_train import CYCLE, ONE, CycleTrain, Law, Linear
from .profiles.s_curves import PLACES, SCurve
from .sheet import ACCELERATION, HIGH_RANGE, JERK, MAX_ACCELERATION, POSITION, STANDARD_RANGE, START_VELOCITY, VELOCITY

TRAPEZOID, S_CURVE = ("profile", "trapezoid"), ("profile", "s-curve")
FAR = 1 << 100  # 1/65536 step; more than any S-curve needs to reach its velocity
TRIED: dict[str, dict[str, object]] = {
    "velocity": {"measure": log, "tried": "300 steps/s..6000 steps/s/14"},
    "acceleration": {"measure": log, "tried": "2000 steps/s2..200000 steps/s2/14"},
    "jerk": {"measure": log, "tried": "1e5 steps/s3..3e7 steps/s3/8"},
}
RANGES = {"standard": STANDARD_RANGE, "high": HIGH_RANGE}


class Units:
    """The conversion of cycles and register values to units of seconds and steps."""

    def __init__(self, sheet: Sheet, crystal_hz: int) -> None:
        self.part, self.clock, self.per_s = sheet.part, Clock(crystal_hz), rates.cycles_per_s(sheet, crystal_hz)

    def ps(self, cycles: int) -> int:
        """Return the duration of `cycles` cycles, in picoseconds."""
        return self.clock.ps(cycles * CYCLE)

    def rate(self, arg: Arg, value: int) -> float:
        """Return a register value converted to steps/s, steps/s^2 or steps/s^3, whichever `arg` implies."""
        return float(rates.per_second(arg, value, self.per_s))


class ChipsetRamp(Ramp):
    """The acceleration ramp of a profile: `cycles` cycles that follow a law, from rest."""

    cycles: int

    def __init__(self, units: Units, values: Values, crystal_hz: int) -> None:
        self.part, self.units, self.values, self.crystal_hz = units.part, units, values, crystal_hz
        self.velocity = min(int(values["SET_VEL"]), RANGES[str(values["output"])] * ONE)

    @property
    @abstractmethod
    def law(self) -> Law:
        """The law that gives the displacement in each cycle."""

    def table(self) -> Iterator[RampSegment]:
        """Yield a segment for each cycle of the ramp, with its rate in steps/s."""
        for cycle in range(self.cycles):
            before, after, speed = self.law.travel(cycle), self.law.travel(cycle + 1), self.law.velocity(cycle)
            rate = self.units.rate(VELOCITY, speed)
            yield RampSegment(self.units.ps(cycle), before / ONE, (after - before) / ONE, rate, speed)

    @property
    def reached_from(self) -> int | None:
        """The minimum distance, in steps, of a move that reaches the maximum velocity; None if no move does."""
        return least(lambda distance: self.made(distance).reached, 1, POSITION.high)

    @property
    def distances(self) -> tuple[int, int, str]:
        """The minimum and maximum distances of a move, in steps, and the command that sets the distance."""
        return 1, POSITION.high, " (SET_POS)"

    @abstractmethod
    def made(self, distance: int) -> ChipsetMove:
        """Return the move over a distance of at least 1 step."""


class ChipsetMove(Move):
    """A whole move: a sequence of laws, each with its number of cycles."""

    def __init__(
        self, ramp: ChipsetRamp, distance: int, parts: Sequence[tuple[Law, int]], top: int, legs: Mapping[str, int]
    ) -> None:
        self.units, self.parts = ramp.units, parts
        self.steps, self.time_ps = distance, ramp.units.ps(sum(cycles for _, cycles in parts))
        self.top, self.reached = ramp.units.rate(VELOCITY, top), top >= ramp.velocity
        self.legs = [(name, travel / ONE) for name, travel in legs.items() if travel]

    def trains(self) -> list[CycleTrain]:
        """Return the pulses of the move, one train for each law."""
        found, cycles, position = [], 0, 0
        for law, count in self.parts:
            found.append(CycleTrain(self.units.clock, cycles * CYCLE, law, count, position % ONE))
            cycles, position = cycles + count, position + law.travel(count)
        return found


# ------------------------------------------------------------------------------------------------------------ profiles
class Trapezoid(ChipsetRamp):
    """The linear acceleration ramp of a trapezoid.

    Its first cycle has the velocity `start`, or the velocity gained in one cycle if that is higher.
    """

    def __init__(self, units: Units, values: Values, crystal_hz: int) -> None:
        super().__init__(units, values, crystal_hz)
        start = min(int(values["SET_START_VEL"]), self.velocity)
        self.limits = profile.MoveLimits(self.velocity, int(values["SET_ACC"]), start)
        run = profile.contour(self.limits, 0)
        self.linear, self.cycles = Linear(run.speed, run.change), run.cycles if run.cycles < OPEN else 0
        self.time_ps, self.steps = units.ps(self.cycles), self.linear.travel(self.cycles) / ONE
        self.start, self.top = (units.rate(VELOCITY, speed) for speed in (start, self.velocity))

    @property
    def law(self) -> Law:
        """The law that gives the displacement in each cycle of the ramp."""
        return self.linear

    @property
    def acceleration(self) -> float:
        """The acceleration, the same in every cycle, in steps/s^2.

        It is limited to the value that reaches the maximum velocity in one cycle.
        """
        return self.units.rate(ACCELERATION, min(self.limits.acceleration, self.velocity))

    @property
    def accelerations(self) -> Accelerations:
        """The first, mean and maximum accelerations, which are equal, in steps/s^2."""
        return Accelerations(*(self.acceleration,) * 3)

    def made(self, distance: int) -> ChipsetMove:
        parts: list[tuple[Law, int]] = []
        legs = dict.fromkeys(("up", "slew", "down"), 0)
        remaining, speed, top, landing = distance * ONE, 0, 0, False
        while not landing:
            run = profile.trapezoid(self.limits, remaining, speed)
            law, travel = Linear(run.speed, run.change), Linear(run.speed, run.change).travel(run.cycles)
            last = law.velocity(run.cycles - 1)
            slewed = travel if not run.change else run.speed if run.speed == self.velocity else last
            slewed *= self.velocity in (run.speed, last)
            legs["slew"] += slewed
            legs["up" if run.speed > speed else "down"] += travel - slewed
            speed, landing = last, run.landing
            remaining, top = remaining - travel, max(top, run.speed, speed)
            parts.append((law, run.cycles))
        return ChipsetMove(self, distance, parts, top, legs)


class SCurvePhases(ChipsetRamp):
    """Phases 1 to 3 of an S-curve that reaches its maximum velocity; each of them may end within a cycle."""

    def __init__(self, units: Units, values: Values, crystal_hz: int) -> None:
        super().__init__(units, values, crystal_hz)
        self.limits = self.velocity, int(values["SET_MAX_ACC"]), int(values["SET_JERK"])
        self.phases = profile.s_curve(FAR, *self.limits)
        fine = 2 * self.phases.jerked + self.phases.steady
        self.cycles = profile.ceil(fine, profile.UNIT)
        self.time_ps = units.ps(fine) >> PLACES
        self.steps = risen(self.phases) / (ONE << 17 + 3 * PLACES)
        self.start, self.top = 0.0, units.rate(VELOCITY, self.velocity)

    @cached_property
    def law(self) -> Law:
        """The law of the S-curve; the last cycle of the ramp may contain a part of phase 4."""
        return SCurve(self.phases.pieces())

    @property
    def accelerations(self) -> Accelerations:
        """The acceleration in the first cycle, the mean acceleration and the maximum, in steps/s^2."""
        speeds = [0, *(self.law.velocity(cycle) for cycle in range(self.cycles + 1))]
        rises = [after - before for before, after in pairwise(speeds)]
        first, greatest = (self.units.rate(ACCELERATION, rise) for rise in (rises[0], max(rises)))
        return Accelerations(first, self.acceleration, greatest)

    def made(self, distance: int) -> ChipsetMove:
        phases = profile.s_curve(distance * ONE, *self.limits)
        up, slew = risen(phases) >> 17 + 3 * PLACES, phases.peak * phases.coasting >> 16 + 3 * PLACES
        legs = {"up": up, "slew": slew, "down": distance * ONE - up - slew}
        peak = phases.peak >> 16 + 2 * PLACES
        return ChipsetMove(self, distance, [(SCurve(phases.pieces()), phases.cycles)], peak, legs)


def risen(phases: profile.Phases) -> int:
    """Return the distance covered in phases 1 to 3, in which the mean velocity is half the peak velocity.

    The unit is 1/65536 step divided by 2^(17 + 3 * PLACES).
    """
    return phases.peak * (2 * phases.jerked + phases.steady)


PROFILES: dict[str, type[Trapezoid | SCurvePhases]] = {"trapezoid": Trapezoid, "s-curve": SCurvePhases}


# ---------------------------------------------------------------------------------------------------------- calculator
class ChipsetRamps(Calculator):
    """The ramp calculator of one part of the MC1451A family."""

    parameter = "velocity"

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet

        def quantity(name: str, arg: Arg, low: int, **more: object) -> RampParameter:
            row = sheet.commands.named(name)
            return RampParameter(name, row.description, replace(arg, low=low), per_s=arg.cycles, **more)  # type: ignore[arg-type]

        self.quantities = (
            RampParameter(TRAPEZOID[0], "profile mode", choices=(TRAPEZOID[1], S_CURVE[1]), default=TRAPEZOID[1]),
            quantity("SET_VEL", VELOCITY, 1, **TRIED["velocity"]),
            quantity("SET_ACC", ACCELERATION, 1, free=True, only=TRAPEZOID, **TRIED["acceleration"]),
            quantity("SET_START_VEL", START_VELOCITY, 0, default=0, only=TRAPEZOID, tried="0 steps/s..600 steps/s/4"),
            quantity("SET_MAX_ACC", MAX_ACCELERATION, 1, free=True, only=S_CURVE, **TRIED["acceleration"]),
            quantity("SET_JERK", JERK, 1, free=True, only=S_CURVE, **TRIED["jerk"]),
            RampParameter("output", "pulse range", choices=tuple(RANGES), default="standard"),
        )

    def ramp(self, values: Values, crystal_hz: int) -> Trapezoid | SCurvePhases:
        """Return the acceleration ramp for a set of parameter values; `crystal_hz` is the crystal frequency."""
        return PROFILES[str(values[TRAPEZOID[0]])](Units(self.sheet, crystal_hz), values, crystal_hz)

    def script(self, values: Values, steps: int) -> list[str]:
        """Return the commands that a host sends for a move of `steps` steps with the given parameter values."""
        modes = ["SET_PRFL_S_CRV"] * (values[TRAPEZOID[0]] == S_CURVE[1]) + ["SET_OUTPUT_HIGH"] * (
            values["output"] == "high"
        )
        registers = [f"{name} {value}" for name, value in values.items() if name.startswith("SET_")]
        return [*modes, *registers, f"SET_POS {steps}", "UPDATE", "wait motion_complete"]

    def spoken(self, quantity: RampParameter, text: str, crystal_hz: int) -> int | None:
        """Return the register value for a rate such as "500 steps/s"; None if the text is not a rate."""
        return rates.spoken(self.arg(quantity.name), text, rates.cycles_per_s(self.sheet, crystal_hz))

    def candidates(self, search: Search) -> Iterable[Candidate]:
        """Return the values of the free parameter whose ramps are nearest to the wanted result.

        Of several values whose ramps have the same result, only the smallest is included.
        """
        if len(search.free) > 1:
            names = " and ".join(search.free)
            raise UsageError(f"{self.sheet.part}: {names} cannot both be searched for; set one of them")
        name, wanted = search.free[0], search.wanted
        arg = self.arg(name)
        sign = -1 if wanted.goal == "acceleration" else 1

        @cache
        def ramp(value: int) -> Trapezoid | SCurvePhases:
            """Return the ramp for a value of the free parameter."""
            return self.ramp({**search.fixed, name: value}, search.crystal_hz)

        if wanted.goal == "steps" and name == "SET_ACC":
            found = sawtooth(lambda each: ramp(each).cycles, lambda each: ramp(each).steps, search, arg)
        else:
            found = levels(
                lambda each: sign * wanted.of(ramp(each)), sign * wanted.value, arg.low, arg.high, search.best
            )
        return (Candidate({name: value}) for value in found)


def sawtooth(cycles: Callable[[int], int], steps: Callable[[int], float], search: Search, arg: Arg) -> Iterator[int]:
    """Yield acceleration values whose ramps have about the wanted number of steps.

    A tooth is a range of accelerations whose ramps have the same number of cycles.  Within a tooth, a higher
    acceleration takes more steps; the ramps of the next tooth have one cycle fewer.  The numbers of steps of
    different teeth hardly overlap, so the best values are in the teeth near the target.
    """
    target, around = search.wanted.value, search.best + 2

    def tooth(value: int) -> tuple[int, int]:
        """Return the lowest and the highest accelerations whose ramps have as many cycles as the ramp of `value`."""
        count = cycles(value)
        low = least(lambda each: cycles(each) <= count, arg.low, arg.high)
        above = least(lambda each: cycles(each) < count, arg.low, arg.high)
        return low or arg.low, arg.high if above is None else above - 1

    def within(low: int, high: int) -> Iterator[int]:
        """Yield the values of the tooth from `low` to `high` whose ramps are nearest to the target."""
        return levels(lambda each: -steps(each), -target, low, high, around)

    middle = tooth(least(lambda each: steps(tooth(each)[0]) <= target, arg.low, arg.high) or arg.high)
    low, high = middle
    for _ in range(around):
        yield from within(low, high)
        if low == arg.low:
            break
        low, high = tooth(low - 1)
    low, high = middle
    for _ in range(around):
        if high == arg.high:
            break
        low, high = tooth(high + 1)
        yield from within(low, high)


ramps = ChipsetRamps  # calculators by sheet
