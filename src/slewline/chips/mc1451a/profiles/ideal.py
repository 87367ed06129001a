"""The parameters of an axis's motion, and the ideal motion: the continuous profiles that the cycles approximate.

    trapezoid                              S-curve
      V       .________                      V          . 3|  4  |5 .
            .'         '.                            2.'   |     |   '. 6
      s __.'             '.__                   1_.-'                    '-._7

An update in motion begins a new ideal motion, at the present target and velocity.  The electronic gear
has no ideal motion, because it follows an encoder.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import sqrt
from typing import NamedTuple

from ....core.context import ChipContext
from ....core.motion.ideal_motion import FOREVER, Ideal, IdealPiece, duration
from ....core.motion.motions import MotionParameters
from .. import sheet
from ..registers import GEAR, ONE, S_CURVE, TRAPEZOIDAL, VELOCITY, AxisState
from .profile import UNIT, Phases, s_curve


class RegistersAtStart(NamedTuple):
    """The registers at the start of a motion, in the units of the commands."""

    crystal_hz: int
    start_ps: int
    mode: int
    target: int  # 1/65536 step
    speed: int  # speed in the previous cycle, signed
    position: int
    velocity: int  # limited by the pulse range
    acceleration: int
    max_acceleration: int
    jerk: int
    start_velocity: int
    ratio: int

    @property
    def per_s(self) -> float:
        """The number of cycles per second."""
        return self.crystal_hz / sheet.CYCLE_TICKS

    def parameters(self) -> MotionParameters:
        """Return the parameters for a plot: velocities in steps/s and the other registers used by the profile mode."""
        if self.mode == GEAR:
            return MotionParameters({}, {"RATIO": self.ratio})
        rates = {f"VEL = {self.velocity}": self.velocity / ONE * self.per_s}
        if self.start_velocity and self.mode != S_CURVE:
            rates[f"START_VEL = {self.start_velocity}"] = self.start_velocity / ONE * self.per_s
        if self.mode == VELOCITY:
            return MotionParameters(rates, {"ACC": self.acceleration})
        if self.mode == TRAPEZOIDAL:
            return MotionParameters(rates, {"ACC": self.acceleration, "POS": self.position})
        return MotionParameters(rates, {"MAX_ACC": self.max_acceleration, "JERK": self.jerk, "POS": self.position})

    def ideal(self) -> Ideal | None:
        """Return the ideal motion; None for the electronic gear."""
        if self.mode == GEAR:
            return None
        per_s = self.per_s
        speed, top, start = (number / ONE * per_s for number in (self.speed, self.velocity, self.start_velocity))
        acceleration = self.acceleration / ONE * per_s**2
        distance = self.position * ONE - self.target
        if self.mode == TRAPEZOIDAL:
            pieces = trapezoid(distance / ONE, speed, top, abs(acceleration), start)
        elif self.mode == VELOCITY:
            pieces = contour(speed, top, acceleration, start)
        else:
            phases = s_curve(abs(distance), self.velocity, self.max_acceleration, self.jerk)
            pieces = turned(curve(phases, per_s), distance)
        return Ideal(self.start_ps, self.target / ONE, pieces or [IdealPiece(0, 0)])


def begins(chip: ChipContext, state: AxisState, cause: str, start_velocity: int, pulse_range: int) -> None:
    """Record that the command `cause` begins a motion of an axis now, with the active registers."""
    active, log = state.active, chip.axes[state.number - 1].log
    made = RegistersAtStart(
        chip.crystal_hz,
        chip.kernel.now,
        state.mode,
        state.target,
        state.velocity,
        active.position,
        min(active.velocity, pulse_range),
        active.acceleration,
        active.max_acceleration,
        active.jerk,
        start_velocity,
        active.ratio,
    )
    log.begin(cause, made.parameters)
    log.expect(made.ideal)


def mark_deviation(chip: ChipContext, state: AxisState, kind: str, text: str) -> None:
    """Record an event that makes an axis's motion depart from its plan."""
    log = chip.axes[state.number - 1].log
    log.depart()
    log.mark(kind, text)


# ------------------------------------------------------------------------------------ profiles, in steps and seconds
def turned(pieces: Iterable[IdealPiece], direction: float) -> list[IdealPiece]:
    """Return the pieces of an ideal motion, in the opposite direction if `direction` is negative."""
    sign = -1 if direction < 0 else 1
    return [IdealPiece(t, sign * v, sign * a, sign * j) for t, v, a, j in pieces]


def change(before: float, after: float, acceleration: float) -> list[IdealPiece]:
    """Return the piece from velocity `before` to `after` at constant acceleration, in a list; [] if equal."""
    if before == after:
        return []
    rate = acceleration if after > before else -acceleration
    return [IdealPiece((after - before) / rate, before, rate)]


def trapezoid(distance: float, speed: float, top: float, acceleration: float, start: float) -> list[IdealPiece]:
    """Return the pieces of a point-to-point move with linear ramps; `distance` and present `speed` are signed.

    If the axis is too fast to stop at its destination, or moves away from it, it first decelerates to rest.
    """
    direction = speed or distance
    d, v, s = (-distance, -speed, start) if direction < 0 else (distance, speed, start)
    s = min(s, top)
    if not acceleration:
        rate = v or s
        return turned([IdealPiece(duration(rate, d), rate)], direction) if d > 0 else []
    braking = max(v * v - s * s, 0) / (2 * acceleration)
    if braking > d + 1e-9 or not top:
        down = change(v, s, acceleration) if v > s else []
        left = d - braking
        return turned([*down, *(trapezoid(left, 0, top, acceleration, start) if top and left else [])], direction)
    v = max(v, s)
    slower = change(v, top, acceleration) if v > top else []
    if slower:
        d, v = d - (v * v - top * top) / (2 * acceleration), top
    peak = min(top, sqrt((2 * acceleration * d + v * v + s * s) / 2))
    coast = d - (2 * peak * peak - v * v - s * s) / (2 * acceleration)
    middle = [IdealPiece(coast / peak, peak)] if coast > 0 and peak else []
    return turned([*slower, *change(v, peak, acceleration), *middle, *change(peak, s, acceleration)], direction)


def contour(speed: float, top: float, acceleration: float, start: float) -> list[IdealPiece]:
    """Return the pieces of velocity contouring: the ramp to the maximum velocity, then that velocity forever.

    The sign of `acceleration` is the direction of the maximum velocity.
    """
    if not acceleration:
        return [IdealPiece(FOREVER, speed)]
    a = abs(acceleration)
    down: list[IdealPiece] = []
    if speed * acceleration < 0:  # the wrong direction: to rest first
        if abs(speed) > start:
            down = turned(change(abs(speed), start, a), speed)
        speed = 0
    v = min(max(abs(speed), start), top) if abs(speed) <= top else abs(speed)
    return [*down, *turned([*change(v, top, a), IdealPiece(FOREVER, top)], acceleration)]


def curve(phases: Phases, per_s: float) -> list[IdealPiece]:
    """Return the seven phases of an S-curve as pieces of an ideal motion, including those of zero duration."""
    jerk = phases.jerk / ONE**2 * per_s**3
    pieces, v, a = [], 0.0, 0.0
    for length, bend in zip(phases.lengths, (1, 0, -1, 0, -1, 0, 1), strict=True):
        t, j = length / UNIT / per_s, bend * jerk
        pieces.append(IdealPiece(t, v, a, j))
        v, a = v + (a + j * t / 2) * t, a + j * t
    return pieces
