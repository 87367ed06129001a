"""The law of motion of the CY512: parameters in, a plan out.  Pure functions, whole clocks.

    rate parameter
      R ........______               with S the parameter rises by S with every step, from 1, and falls likewise to the
              _|      |_             target (inferred); without S every step is made at R.  A factor multiplies the time
            _|          |_           of every step.
      1   _|              |_
          |up | slew |down|

Where there is no room for both ramps, the whole move is made at the slowest rate (s.3, comparison, item 10).
"""

from __future__ import annotations

from functools import lru_cache

from ...core.plan import Plan, Runs, mirrored, plan, steps
from ..cy5xx.slope import Law
from . import sheet

LAW = Law(sheet.PERIODS)


def slowed(runs: Runs, factor: int) -> Runs:
    """The same steps, each taking `factor` times as long; a factor of 0 counts as 256."""
    return tuple((interval * (factor or 256), count) for interval, count in runs)


@lru_cache(maxsize=64)
def move(number: int, rate: int, slope: int, factor: int, law: Law = LAW) -> Plan:
    """A move of `number` steps from rest to rest.

    Args:
        number: steps, 1 to 65535.
        rate, slope, factor: R, S and F, 0 to 255.
        law: the periods of the rates, and where ramps begin.
    """
    up = law.up(rate, slope)
    slew = number - 2 * steps(up)
    if slew < 0:
        return plan(("crawl", ((law.period(law.start), number),))).verified(number)
    legs = ("up", up), ("slew", ((law.period(rate), slew),) if slew else ()), ("down", mirrored(up))
    return plan(*((name, slowed(runs, factor)) for name, runs in legs)).verified(number)
