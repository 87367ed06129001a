"""Ramps whose rate parameter grows by one with every unit of time.  Pure functions, whole clocks.

rate parameter
  high .........______      a unit falls due every so many clocks, counted from the first step; it is sampled when a
              _/            step begins.  Either all that are due are taken then (`jumps`), or one at most: one that is
            _/              taken late does not move those after it.
  low ...../
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from ....core.motion.ideal_motion import FOREVER, IdealPiece, duration, mirrored, there_and_down, travelled
from ....core.motion.plan import Runs


def accelerate(periods: Sequence[int], low: int, high: int, unit: int, jumps: bool) -> Runs:
    """Return the way up: runs from the first step at rate `low` to the last one below rate `high`.

    Args:
        periods: clocks of a step by rate parameter.
        low, high: rate parameters; empty unless low < high.
        unit: clocks after which the rate parameter is one higher.
        jumps: take all units that are due when a step begins, not one.
    """
    runs = []
    elapsed, rate = 0, low
    while rate < high:
        interval = periods[rate]
        left = (rate - low + 1) * unit - elapsed  # clocks until the next unit is due
        count = -(-left // interval) if left > interval else 1  # a step at least, however late the unit is
        runs.append((interval, count))
        elapsed += interval * count
        rate = low + elapsed // unit if jumps else rate + 1
    return tuple(runs)


def pieces(rates: Sequence[float], unit: float, number: int, slews: bool, endless: bool) -> list[IdealPiece]:
    """Return the ideal of a motion: a rate every `unit` seconds, and straight lines between them.

    Args:
        rates: steps/s, from the first to the one that is to be reached.
        number: steps of the motion.
        slews: it comes to slewing; else what is left behind the ramps is made at the first rate.
        endless: it slews until something ends it.
    """
    up = [IdealPiece(unit, a, (b - a) / unit) for a, b in pairwise(rates)]
    surplus = number - 2 * travelled(up)
    if endless:
        return [*up, IdealPiece(FOREVER, rates[-1])]
    if slews or surplus < 0:
        return there_and_down(up, rates[-1], number)
    return [*up, *mirrored(up), IdealPiece(duration(rates[0], surplus), rates[0])]
