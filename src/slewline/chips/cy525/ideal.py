r"""The parameters of a CY525 motion, and the ideal motion.

    steps/s                                  a rate of Table VII every Z * (256 - S) * 452 clocks, straight lines
      R ..............._______________       between them: the piecewise linear curve from which section 8 calculates
                     /                \      ramp times and accelerations
                 . '                   ' .
      F .....'                             '
             |<- (R - F) units ->|

The real motion reads its rate as each step begins; the ideal one has no steps.  Whether a short motion slews, or makes
its remaining steps at F, is decided as in the real motion.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

from ...core.motion.ideal_motion import Ideal
from ...core.motion.motions import MotionParameters
from ..cy5xx.stepping.unit_ramps import pieces
from . import sheet
from .profile import Law, unit_ticks


class RegistersAtStart(NamedTuple):
    """The parameters at the start of a motion."""

    crystal_hz: int
    first: int
    rate: int
    slope: int
    divisor: int
    number: int
    law: Law

    def steps_per_s(self, rate: int) -> float:
        """Return the step rate for a rate parameter, in steps/s."""
        return self.crystal_hz / int(sheet.STEP_TICKS[min(rate, sheet.RATE_TOP)])

    @lru_cache(maxsize=64)  # noqa: B019 (tuples)
    def parameters(self) -> MotionParameters:
        """Return the parameters to show in a picture: the rates for F and R, and the values of S, Z and N."""
        return MotionParameters(
            self.rates(self.first, self.rate), {"S": self.slope, "Z": self.divisor, "N": self.number}
        )

    def rates(self, first: int, rate: int) -> Mapping[str, float]:
        """Return the rates (steps/s) for two rate parameters, F and R, by name ("F = 10")."""
        return {f"{letter} = {each}": self.steps_per_s(each) for letter, each in (("F", first), ("R", rate))}

    def ideal(self, start: int, position: int, sign: int, slews: bool, endless: bool) -> Ideal:
        """Return the ideal motion for these parameters.

        Args:
            start: the time of the first step, ps.
            position: the position before the first step.
            slews: the motion reaches the slew rate; otherwise, after the ramps, the remaining steps are made at F.
            endless: the motion slews until an event ends it.
        """
        first = min(self.first, sheet.RATE_TOP)
        last = max(first, min(self.rate, sheet.RATE_TOP))
        unit = unit_ticks(self.slope, self.divisor, self.law) / self.crystal_hz
        rates = [self.steps_per_s(rate) for rate in range(first, last + 1)]
        return Ideal(start, position, pieces(rates, unit, self.number, slews, endless), sign)


def at_start(crystal_hz: int, values: Mapping[str, int], number: int, law: Law) -> RegistersAtStart:
    """Return the parameters of a motion of `number` steps that begins now; `values` are the registers by name."""
    first, rate, slope, divisor = (values[name] for name in ("firstrate", "rate", "slope", "divisor"))
    return RegistersAtStart(crystal_hz, first, rate, slope, divisor, number, law)
