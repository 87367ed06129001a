"""The law of motion of the CY512: parameters in, a plan out.  Pure functions, whole clocks.

    rate parameter
      R ........______               unless S is 0, the parameter rises by S at every step, from 1,
              _|      |_             and falls likewise before the target (inferred); if S is 0, every
            _|          |_           step is made at R.  A factor multiplies the time of every step.
      1   _|              |_
          |up | slew |down|

If the ramps do not both fit, the whole move is made at the slowest rate (s.3, comparison, item 10).
"""

from __future__ import annotations

from functools import lru_cache

from ...core.motion.plan import Plan, mirrored, plan, steps
from ..cy5xx.stepping.slope import Law
from . import sheet

LAW = Law(sheet.PERIODS)


@lru_cache(maxsize=64)
def move(number: int, rate: int, slope: int, factor: int, law: Law = LAW) -> Plan:
    """Return the plan of a move of `number` steps from rest to rest.

    Args:
        number: steps, 1 to 65535.
        rate, slope: R and S, 0 to 255.
        factor: F, 1 to 256.
        law: the step periods by rate parameter, and the parameter at which ramps start.
    """
    up = law.up(rate, slope, factor)
    slew = number - 2 * steps(up)
    if slew < 0:
        return plan(("crawl", ((law.period(law.start), number),))).verified(number)
    top = ((law.period(rate, factor), slew),) if slew else ()
    return plan(("up", up), ("slew", top), ("down", mirrored(up))).verified(number)
