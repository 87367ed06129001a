"""The law of motion of the CY545: parameters in, a plan out.  Pure functions, whole clocks.

    rate parameter
      R ..............._______________           the next rate of the table is due every 256 * (256 - S) machine
                     _|               |_         cycles, counted from the first step; it takes effect as a step begins
                   _|                   |_       (an acceleration of 3906 D / (256 - S) steps/s2 at 12 MHz, 2002 p.77,
      F ..........|                       |      if adjacent rates differ by D)
                  | up  |     slew     | down    a step of the ramp down is as long as its mirror image in the ramp up

Where a step lasts longer than the time per rate, the ramp advances by several rates per step; if `jumps`
is False, it advances by one, which is the law of the CY525.  Slewing has no minimum number of steps.  If
the distance is too short for R, the ramp up ends in the middle of the move; if the number of steps is
odd, the middle step belongs to the ramp up.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

from ...core.datasheet.option import defaults
from ...core.datasheet.table import Sheet
from ...core.motion.plan import Plan, Runs, head, mirrored, plan, steps, tail
from ...core.motion.train import OPEN
from ..cy5xx.stepping.unit_ramps import accelerate


class Law(NamedTuple):
    """The law of ramps: the step periods in clocks, by rate parameter, and how the parameter grows."""

    periods: tuple[int, ...]
    unit: int  # clocks of one rate at S 255
    jumps: bool = True  # take all rates that are due when a step begins, not just one

    @property
    def top(self) -> int:
        """The highest rate parameter."""
        return len(self.periods) - 1

    @property
    def shortest(self) -> int:
        """The clocks of the fastest step."""
        return min(self.periods)

    def unit_ticks(self, slope: int) -> int:
        """Return the clocks per unit of the rate parameter; S = 0 results in 256 times as many as S = 255."""
        return (256 - slope) * self.unit


def law_of(sheet: Sheet) -> Law:
    """Return a sheet's law: its rates, which apply at its crystal frequency, and its ramp options."""
    options = defaults(sheet.options)
    periods = tuple((2 * sheet.crystal_hz + rate) // (2 * rate) for rate in sheet.rates)
    return Law(periods, options["inferred.ramp_unit"], options["ramp_jumps"])


@lru_cache(maxsize=256)
def ramp(first: int, rate: int, slope: int, law: Law) -> Runs:
    """Return the ramp from the first step, at F, to the last step below R; () unless F < R."""
    return accelerate(law.periods, first, rate, law.unit_ticks(slope), law.jumps)


@lru_cache(maxsize=64)
def move(number: int, first: int, rate: int, slope: int, law: Law) -> Plan:
    """Return the plan of a move of `number` steps from rest to rest.

    Args:
        number: steps, 1 to 16777215.
        first, rate, slope: F, R and S, 0 to 255; if R is below F, the whole move is made at F.
        law: the step periods, and the growth of the rate in ramps.
    """
    up = ramp(first, rate, slope, law)
    full = steps(up)
    slew = max(number - 2 * full, 0)
    return plan(
        ("up", head(up, min(full, (number + 1) // 2))),
        ("slew", ((law.periods[max(first, rate)], slew),) if slew else ()),
        ("down", mirrored(head(up, min(full, number // 2)))),
        shortest=law.shortest,
    ).verified(number)


@lru_cache(maxsize=64)
def endless(first: int, rate: int, slope: int, law: Law) -> Plan:
    """Return the plan of a continuous motion: a ramp up to R, then steps at R without end."""
    slew = (law.periods[max(first, rate)], OPEN)
    return plan(("up", ramp(first, rate, slope, law)), ("slew", (slew,)), shortest=law.shortest)


def down(of: Plan, step: int, first: int, left: int, law: Law) -> Plan:
    """Return the rest of a plan when INHIBIT_ABORT is low: a ramp down to the first rate, then steps at that rate.

    The ramp down mirrors the ramp up so far.  INHIBIT_ABORT is sampled at each step at the first rate, so
    these steps form a separate leg.

    Args:
        of, step: the plan, and the number of its next step, at least 1.
        first: F.
        left: steps to the target; OPEN if there is no target.
    """
    over = of.leg(step - 1)
    up = of.legs[0].runs if of.legs[0].name == "up" else ()
    if over.name == "down":
        ramp = tail(over.runs, step - over.first)
    elif over.name == "up":
        ramp = mirrored(head(up, step))
    else:
        ramp = mirrored(up)
    slow = law.periods[first]
    ramp = head(tuple(run for run in ramp if run[0] != slow), left)
    rest = left if left >= OPEN else left - steps(ramp)
    return plan(("down", ramp), ("crawl", ((slow, rest),) if rest else ()), shortest=law.shortest)


def steady(period: int, number: int = OPEN) -> Plan:
    """Return the plan of `number` steps, all with the same period, for jog and HOME, which have no ramps."""
    return plan(("crawl", ((period, number),)))
