r"""The law of motion of the CY500: parameters in, a plan out.  For rates and slopes see chips/cy5xx/stepping/slope.py.

    rate   R .......___           R ....../|          R ..
                   /   \                 / |               /|
                  /     \               /  |              / |
                 |       |             |   |             |  |
           N: ramp + slew + ramp      2 ramps > N       ramp >= N

Until R is reached, the chip does not know where to decelerate: a move too short for both ramps ends
abruptly, during the ramp down or, if R is never reached, at full speed.  The user must make sure that
N > 2 R (art. T.2 S).
"""

from __future__ import annotations

from ...core.motion.plan import Plan, head, mirrored, plan, steps
from ...core.motion.train import OPEN
from ..cy5xx.stepping.slope import Law


def move(number: int, rate: int, slope: int, factor: int, law: Law) -> Plan:
    """Return the plan of a move of 1 to 65535 steps.

    If `slope` is 0, the move has no ramps, and every step period is multiplied by `factor`.  Otherwise
    `factor` has no effect.
    """
    up = law.up(rate, slope)
    if not up:
        return plan(("slew", ((law.period(rate) * (1 if slope else factor), number),))).verified(number)
    rest = number - steps(up)
    down = head(mirrored(up), rest)
    slew = ((law.period(rate), rest - steps(down)),) if rest > steps(down) else ()
    return plan(("up", head(up, number)), ("slew", slew), ("down", down), shortest=law.period(rate)).verified(number)


def jog(rate: int, factor: int, law: Law) -> Plan:
    """Return the plan of an endless run at a constant rate."""
    return plan(("slew", ((law.period(rate) * factor, OPEN),)))


def one(law: Law) -> Plan:
    """Return the plan of a single step, with the period of the shortest step."""
    return plan(("slew", ((law.period(law.top), 1),)))
