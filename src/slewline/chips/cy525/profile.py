r"""The law of motion of the CY525: parameters in, a plan out.  Pure functions, whole clocks.

    rate
      R ..............._______________
                     /|              |\            one rate unit every Z * (256 - S) * 452 clocks,
                   _/ |              | \_          sampled when a step begins: at most one unit per step
                 _/   |              |   \_
      F ........|     |              |     |_____
                | up  |     slew     | down|crawl|
      steps       ramp   >= 256 or 0   ramp  rest          (s.8)

The rate parameter, not the rate, grows linearly; Table VII turns it into steps per second.  A rate unit
falls due at regular intervals, and takes effect when the next step begins.  If a step takes longer than
such an interval, rate units fall due faster than steps begin.  Each step still takes only one unit, so
it is one unit faster than its predecessor, and the other units take effect later.  This does not change
the times at which further units fall due.  The ramp down is the mirror of the ramp up.  If fewer than
256 steps would be left for slewing, there is no slewing: the motor decelerates immediately and makes the
remaining steps at F (s.8, special case).  If the travel is too short to reach R, each ramp takes half
of it.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

from ...core.motion.plan import Leg, Plan, Runs, head, mirrored, steps, tail
from ...core.motion.plan import plan as core_plan
from ...core.motion.train import OPEN
from ..cy5xx.stepping.unit_ramps import accelerate
from . import sheet

__all__ = ["Law", "Leg", "Plan", "Runs", "head", "mirrored", "move", "plan", "ramp", "rate", "steady", "steps", "tail"]


class Law(NamedTuple):
    """The law by which the rate parameter changes in a ramp."""

    unit: int = sheet.RAMP_UNIT_TICKS  # clocks of one rate unit at S 255, Z 1
    jumps: bool = False  # take all units that are due when a step begins, not just one


LAW = Law()


def unit_ticks(slope: int, divisor: int, law: Law = LAW) -> int:
    """Return the clocks per unit of the rate parameter; S = 0 and Z = 0 each give a factor of 256 (8 bits)."""
    return (divisor or 256) * (256 - slope) * law.unit


@lru_cache(maxsize=256)
def ramp(low: int, high: int, slope: int, divisor: int, law: Law = LAW) -> Runs:
    """Return the ramp as runs, from the first step, at `low`, to the last step below `high`; () unless low < high."""
    return accelerate(sheet.STEP_TICKS, low, high, unit_ticks(slope, divisor, law), law.jumps)


def plan(*parts: tuple[str, Runs]) -> Plan:
    """Return the plan that consists of the given legs; no step may be faster than one at the highest rate."""
    return core_plan(*parts, shortest=sheet.STEP_TICKS[sheet.RATE_TOP])


@lru_cache(maxsize=1)
def _rates() -> dict[int, int]:
    return {ticks: rate for rate, ticks in enumerate(sheet.STEP_TICKS)}


def rate_of(interval: int) -> int:
    """Return the rate parameter whose step takes `interval` clocks."""
    return _rates()[interval]


def rate(of: Plan, step: int) -> int:
    """Return the rate parameter of a step of a plan."""
    return rate_of(of.interval(step))


@lru_cache(maxsize=64)
def move(number: int, first: int, rate: int, slope: int, divisor: int, law: Law = LAW) -> Plan:
    """Return the plan of a normal move of `number` steps from rest to rest.

    Args:
        number: steps, 1 to 65535.
        first, rate: rate parameters F and R, 0 to 127; if R is below F, the whole move is made at F.
        slope, divisor: S and Z, 0 to 255.
        law: the law by which the rate parameter changes.
    """
    up = ramp(first, rate, slope, divisor, law)
    full = steps(up)
    if 2 * full > number:
        up = head(up, number // 2)
    rest = number - 2 * min(full, number // 2)
    slew = rest if rest >= sheet.SHORT_SLEW_STEPS else 0
    top = max(first, rate)
    return plan(
        ("up", up),
        ("slew", ((sheet.STEP_TICKS[top], slew),) if slew else ()),
        ("down", mirrored(up)),
        ("crawl", ((sheet.STEP_TICKS[first], rest - slew),) if rest > slew else ()),
    ).verified(number)


def steady(rate: int, before: tuple[str, Runs] = ("up", ())) -> Plan:
    """Return the plan of an endless motion at `rate`, which begins with the ramp `before` (by default none)."""
    return plan(before, ("slew", ((sheet.STEP_TICKS[rate], OPEN),)))
