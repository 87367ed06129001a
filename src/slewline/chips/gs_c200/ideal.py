"""The parameters of a GS-C module's motion, and the ideal motion.

steps/s                                  the rate at each whole step of a ramp follows the ramp law;
  T ..............._______________       between two steps, the square of the rate changes linearly
                 .'               '.     (constant acceleration).  With the law `constant acceleration`,
               .'                   '.   position over time is a parabola, from S to T in R steps
  S ........ .'                       '.__
             |<-R->|             |<-R->|1|      the last step, the start-stop interval, is made at S
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

from ...core.motion.ideal_motion import FOREVER, Ideal, IdealPiece, duration, there_and_down
from ...core.motion.motions import MotionParameters
from ...core.motion.train import OPEN
from .profile import Law
from .sheet import RATE_UNIT


class RegistersAtStart(NamedTuple):
    """The parameters at the start of a motion."""

    start_stop: int
    top_speed: int
    ramp: int
    law: Law

    @lru_cache(maxsize=64)  # noqa: B019 (tuples)
    def parameters(self) -> MotionParameters:
        """Return the parameters to show in a picture of the motion: the rates of S and T, and the ramp length R."""
        speeds = (("S", self.start_stop), ("T", self.top_speed))
        rates = {f"{letter} = {speed}": float(RATE_UNIT * speed) for letter, speed in speeds if speed}
        return MotionParameters(rates, {"R": self.ramp})

    def homing(self) -> MotionParameters:
        """Return the parameters to show in a picture of a homing run: the rate of S."""
        return MotionParameters({f"S = {self.start_stop}": float(RATE_UNIT * self.start_stop)})

    @property
    def ramp_up(self) -> list[IdealPiece]:
        """The ideal ramp from S up to T, one piece per step; empty unless S < T."""
        low, high = float(RATE_UNIT * self.start_stop), float(RATE_UNIT * self.top_speed)
        if high <= low:
            return []
        rates = [self.law(low, high, self.ramp, k) for k in range(self.ramp)] + [high]
        return [IdealPiece(2 / (a + b), a, (b - a) * (a + b) / 2) for a, b in pairwise(rates)]

    def ideal(self, start: int, position: int, sign: int, number: int | None, limit: int) -> Ideal:
        """Return the ideal motion.

        Args:
            start: the time of the first step, ps.
            position: the position before the first step.
            sign: 1 clockwise, -1 counter-clockwise.
            number: the number of steps; None if the motion lasts until an event ends it, or for `limit` steps.
            limit: the maximum number of steps if `number` is None; OPEN for no maximum.
        """
        low, high = float(RATE_UNIT * self.start_stop), float(RATE_UNIT * self.top_speed)
        up = self.ramp_up
        if number is None:
            rest = FOREVER if limit >= OPEN else max(limit - len(up), 0) / high
            pieces = [*up[:limit], IdealPiece(rest, high)]
        elif number == 1 or not up:
            pieces = [IdealPiece(duration(low if up else high, number), low if up else high)]
        else:
            pieces = [*there_and_down(up, high, number - 1), IdealPiece(1 / low, low)]
        return Ideal(start, position, pieces, sign)
