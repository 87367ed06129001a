"""The parameters of a CY545 motion, and the ideal motion.

In a ramp, the rate parameter changes by 1 in each unit of time, which depends on S.  In the ideal
motion, straight lines join the rates at the ends of these units.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

from ...core.motion.ideal_motion import Ideal
from ...core.motion.motions import MotionParameters
from ..cy5xx.stepping.unit_ramps import pieces
from . import sheet
from .profile import Law


class RegistersAtStart(NamedTuple):
    """The parameters at the start of a motion."""

    crystal_hz: int
    first: int
    rate: int
    slope: int
    number: int
    law: Law

    def steps_per_s(self, rate: int) -> float:
        """Return the step rate for a rate parameter, in steps/s."""
        return self.crystal_hz / self.law.periods[rate]

    @lru_cache(maxsize=64)  # noqa: B019 (tuples)
    def parameters(self) -> MotionParameters:
        """Return the parameters to show in a picture: the rates for F and R, and the values of S and N."""
        rates = {f"{letter} = {each}": self.steps_per_s(each) for letter, each in (("F", self.first), ("R", self.rate))}
        return MotionParameters(rates, {"S": self.slope, "N": self.number})

    def ideal(self, start: int, position: int, sign: int, endless: bool) -> Ideal:
        """Return the ideal motion for these parameters.

        Args:
            start: the time of the first step, ps.
            position: the position before the first step.
            endless: the motion slews until an event ends it.
        """
        rates = [self.steps_per_s(rate) for rate in range(self.first, max(self.first, self.rate) + 1)]
        unit = self.law.unit_ticks(self.slope) / self.crystal_hz
        return Ideal(start, position, pieces(rates, unit, self.number, True, endless), sign)


class Single(NamedTuple):
    """The rate of jog steps and of HOME: a twentieth of the rate for F."""

    crystal_hz: int
    first: int
    law: Law

    @property
    def period(self) -> int:
        """The clocks per step."""
        return self.law.periods[self.first] * sheet.JOG_DIVISOR

    def parameters(self) -> MotionParameters:
        """Return the parameters to show in a picture: only this rate."""
        return MotionParameters(self.rates(), {})

    def rates(self) -> Mapping[str, float]:
        """Return the rate in steps/s, by its name ("F = 10 / 20")."""
        return {f"F = {self.first} / {sheet.JOG_DIVISOR}": self.crystal_hz / self.period}
