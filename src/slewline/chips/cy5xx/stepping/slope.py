"""Rates and slopes of parts whose rate parameter grows by S with each step.  Pure functions, whole clocks.

    rate parameter
      R ........______
              _|      |_          step i of a ramp has the parameter start + (i - 1) * S; the period of a step falls
            _|          |_        with the parameter, so the acceleration increases
    start _|              |_
          |up | slew |down|

Without a slope, every step is made at rate R divided by the factor.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from ....core.motion.ideal_motion import FOREVER, Ideal, IdealPiece
from ....core.motion.motions import MotionParameters
from ....core.motion.plan import Runs
from ....core.motion.train import OPEN


class Law(NamedTuple):
    """The step periods in clocks, by rate parameter from 0 up, and the parameter of a ramp's first step."""

    periods: tuple[int, ...]
    start: int = 1

    @property
    def top(self) -> int:
        """The highest rate parameter; any higher parameter counts as this one."""
        return len(self.periods) - 1

    def period(self, rate: int, factor: int = 1) -> int:
        """Return the clocks of a step at a rate parameter, multiplied by a factor."""
        return self.periods[min(rate, self.top)] * factor

    def up(self, rate: int, slope: int, factor: int = 1) -> Runs:
        """Return the steps of the ramp up to `rate`, each with a parameter below `rate`; none if the slope is 0."""
        ramp = range(self.start, min(rate, self.top), slope) if slope else ()
        return tuple((self.periods[each] * factor, 1) for each in ramp)


class RegistersAtStart(NamedTuple):
    """The parameters at the start of a motion; slope 0 means no slope, and `factor` is the factor in effect."""

    crystal_hz: int
    rate: int
    slope: int
    factor: int
    number: int
    law: Law

    def parameters(self) -> MotionParameters:
        """Return the parameters to show in a picture of the motion: the rate for R, and the values of S, F and N."""
        return MotionParameters(self.rates(), {"S": self.slope, "F": self.factor, "N": self.number})

    def rates(self) -> Mapping[str, float]:
        """Return the rate in steps/s that the motion is to reach, under a name such as "R = 100"."""
        return {f"R = {self.rate}": self.crystal_hz / self.law.period(self.rate, self.factor)}

    def ideal(self, runs: Runs, start: int, position: int, sign: int) -> Ideal:
        """Return the ideal course, which is the plan itself: under this law, the rate changes only from step to step.

        Args:
            runs: the runs of the plan, each an interval in clocks and the number of steps with this interval.
            start: the time of the first step, ps.
            position: the position before the first step.
            sign: 1 clockwise, -1 counter-clockwise.
        """
        lasting = ((interval / self.crystal_hz, n) for interval, n in runs)
        pieces = [IdealPiece(s * n if n < OPEN else FOREVER, 1 / s) for s, n in lasting]
        return Ideal(start, position, pieces or [IdealPiece(0.0, 0.0)], sign)
