"""Ramps whose rate parameter grows by one at fixed intervals of time.  Pure functions, whole clocks.

rate parameter
 high .........______      an increase by one (a unit) is due every `unit` clocks, counted from the first
             _/            step.  At the start of each step, either all units due are taken (`jumps`), or
           _/              at most one; a late unit does not delay the units after it.
 low ...../
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from ....core.motion.ideal_motion import FOREVER, IdealPiece, duration, mirrored, there_and_down, travelled
from ....core.motion.plan import Runs


def accelerate(periods: Sequence[int], low: int, high: int, unit: int, jumps: bool) -> Runs:
    """Return the ramp as runs, from the first step at rate `low` to the last step below rate `high`.

    Args:
        periods: the length of a step in clocks, by rate parameter.
        low, high: rate parameters; the ramp is empty unless low < high.
        unit: the number of clocks after which the rate parameter increases by one.
        jumps: take all units that are due when a step begins, not just one.
    """
    runs = []
    elapsed, rate = 0, low
    while rate < high:
        interval = periods[rate]
        left = (rate - low + 1) * unit - elapsed  # clocks until the next unit is due
        count = -(-left // interval) if left > interval else 1  # at least one step, however late the unit is
        runs.append((interval, count))
        elapsed += interval * count
        rate = low + elapsed // unit if jumps else rate + 1
    return tuple(runs)


def pieces(rates: Sequence[float], unit: float, number: int, slews: bool, endless: bool) -> list[IdealPiece]:
    """Return the ideal course of a motion: the rate changes linearly from each of `rates` to the next.

    Args:
        rates: steps/s, from the first rate to the target rate.
        unit: the time from each of `rates` to the next, in seconds.
        number: steps of the motion.
        slews: the motion reaches its slew rate; otherwise any steps left after its ramps are made at the first rate.
        endless: the motion slews until an event ends it.
    """
    up = [IdealPiece(unit, a, (b - a) / unit) for a, b in pairwise(rates)]
    surplus = number - 2 * travelled(up)
    if endless:
        return [*up, IdealPiece(FOREVER, rates[-1])]
    if slews or surplus < 0:
        return there_and_down(up, rates[-1], number)
    return [*up, *mirrored(up), IdealPiece(duration(rates[0], surplus), rates[0])]
