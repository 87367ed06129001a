r"""The law of motion of the GS-C modules: parameters in, a plan out.  Pure functions, whole picoseconds.

    steps/s
      T ..............._______________
                     /|               |\            the interval after step i of n (i from 0) is 1/rate(k),
                   _/ |               | \_          k = min(i, n-2-i, R); these intervals are symmetric
                 _/   |               |   \_
      S ........|     |               |     |       rest: the start-stop interval after the last step
                | up  |     slew      | down|
    intervals      R    n-1-2R, or 0     R

A move that is too short for both ramps begins to decelerate in its middle.  If T is not above S, the whole move is made
at T, without ramps.  The sheet fixes only the ends of a ramp and its length, and that both ramps are identical (command
R); the rate between S and T follows a law that can be replaced.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from math import sqrt
from types import MappingProxyType

from ...core.motion.plan import Plan, Runs, head, mirrored, plan
from ...core.motion.train import OPEN
from ...core.time.timebase import PS_PER_S
from ...errors import UsageError
from .sheet import RAMP_LAWS, RATE_UNIT

Law = Callable[[float, float, int, int], float]
"""A ramp law: steps/s at step k (0 to `ramp`) of a ramp from `start` to `top`: law(start, top, ramp, k)."""


def constant_acceleration(start: float, top: float, ramp: int, k: int) -> float:
    """Return the rate at step k of a constant-torque ramp: the square of the rate grows linearly with k."""
    return sqrt(start * start + (top * top - start * start) * k / ramp)


def linear_in_steps(start: float, top: float, ramp: int, k: int) -> float:
    """Return the rate at step k of a ramp if the rate grows linearly with the steps."""
    return start + (top - start) * k / ramp


LAWS = MappingProxyType(dict(zip(RAMP_LAWS, (constant_acceleration, linear_in_steps), strict=True)))


def period(speed: int) -> int:
    """Return the rounded period of a step in picoseconds, at a speed in units of 10 steps/s."""
    rate = RATE_UNIT * speed
    return (PS_PER_S + rate // 2) // rate


@lru_cache(maxsize=256)
def ramp(start: int, top: int, length: int, law: Law = constant_acceleration) -> Runs:
    """Return the ramp up: the intervals (ps) after steps 0 to length-1; empty unless start < top.

    Args:
        start, top: S and T, in units of 10 steps/s.
        length: R, steps.

    Raises:
        UsageError: the law leaves the range from S to T, or is not monotonic.
    """
    if top <= start:
        return ()
    intervals = [period(start)]
    for k in range(1, length):
        low, high = RATE_UNIT * start, RATE_UNIT * top
        rate = law(float(low), float(high), length, k)
        if not low <= rate <= high:
            raise UsageError(f"ramp law: {rate:g} steps/s at step {k} of {length}; allowed {low}..{high}")
        intervals.append(round(PS_PER_S / rate))
        if intervals[-1] > intervals[-2]:
            raise UsageError(f"ramp law: step {k} of {length} is slower than the step before; rates must not decrease")
    return tuple((interval, 1) for interval in intervals)


@lru_cache(maxsize=64)
def move(number: int, start: int, top: int, length: int, law: Law = constant_acceleration) -> Plan:
    """Return the plan of a move of `number` steps from rest to rest.

    Args:
        number: steps, at least 1.
        start, top, length: S, T and R.
    """
    up = ramp(start, top, length, law)
    if not up or number == 1:
        return plan(("slew", ((period(start if up else top), number),))).verified(number)
    if number > 2 * length + 1:
        slew = ((period(top), number - 1 - 2 * length),)
        return plan(("up", up), ("slew", slew), ("down", down(up, length))).verified(number)
    return plan(("up", head(up, number // 2)), ("down", down(up, (number - 1) // 2))).verified(number)


def down(up: Runs, intervals: int) -> Runs:
    """Return the ramp down: the first `intervals` intervals of `up`, reversed, and then a start-stop interval."""
    return (*mirrored(head(up, intervals)), (up[0][0], 1))


def endless(start: int, top: int, length: int, law: Law = constant_acceleration, limit: int = OPEN) -> Plan:
    """Return the plan of an open-ended motion, which ends without a ramp after `limit` steps (counter's end)."""
    up = head(ramp(start, top, length, law), limit)
    rest = limit - len(up) if limit < OPEN else OPEN
    return plan(("up", up), ("slew", ((period(top), rest),)))


def steady(interval: int) -> Plan:
    """Return the plan of endless steps at one interval (ps), for a homing run."""
    return plan(("slew", ((interval, OPEN),)))


def stopped(of: Plan, step: int) -> Plan:
    """Return the plan that replaces the rest of the plan `of` in order to decelerate to a stop.

    `step` is the number of the next step, with which the new plan begins.  The new plan is a ramp down with
    as many steps as the ramp up has had so far.  If the ramp down has already begun, the new plan has no
    more steps than are left of that ramp.  The new plan is empty if there is no ramp, or if `step` is 0.
    """
    up, leg = of.legs[0], of.leg(step)
    if up.name != "up" or step == 0:
        return Plan(())
    left = min(step, up.count + 1)
    if leg.name == "down":
        left = min(left, leg.end - step)
    return plan(("down", down(up.runs, left - 1))).verified(left)


def within(of: Plan, room: int) -> Plan:
    """Return a plan cut off after `room` steps, where the range of the position counter ends."""
    return of if of.steps <= room else plan(*((leg.name, head(leg.runs, room - leg.first)) for leg in of.legs))
