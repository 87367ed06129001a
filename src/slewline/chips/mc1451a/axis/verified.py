r"""The check of every run before its pulses are promised: the conditions that a run of cycles must meet.

    speed        ______  limit                          joins:    from the previous cycle to the run's first, the
          before/      \                                           speed changes by no more than the law allows
           ----/        \____                          keeps:    no cycle exceeds the limit, or `before` if higher
                          landing: exactly there        lands:    the last run of a move ends at the destination

A fault is a mistake in a law of motion; the host and the user are never its cause.
"""

from __future__ import annotations

from itertools import pairwise

from ....core.motion.train import OPEN
from ..profiles.cycle_train import Law
from ..profiles.profile import CycleRun, MoveLimits, Phases
from ..profiles.s_curves import PLACES, SCurve


def fault_of_run(law: Law, run: CycleRun, limits: MoveLimits, before: int, remaining: int) -> str:
    """Return a description of the fault in a run with a constant change of speed; "" if there is none.

    Args:
        before: the speed of the previous cycle, 1/65536 step per cycle, in the direction of the run.
        remaining: the distance from the start of the run to the destination, for a run that lands.
    """
    first, change, cycles = run.speed, run.change, run.cycles
    last = first + (cycles - 1) * change if change else first
    if cycles < 1 or (change and cycles >= OPEN):
        return f"{cycles} cycles"
    if abs(first - before) > max(limits.acceleration, limits.start):
        return f"from speed {before} to {first}; the acceleration is {limits.acceleration}"
    if abs(change) > limits.acceleration:
        return f"accelerates by {change} per cycle; allowed {limits.acceleration}"
    if min(first, last) < 0 or max(first, last) > max(limits.velocity, before):
        return f"from speed {first} to {last}; allowed 0 to {max(limits.velocity, before)}"
    if run.landing and law.travel(cycles) != remaining:
        return f"lands after {law.travel(cycles)}; the destination is {remaining} away"
    return ""


def fault_of_curve(law: SCurve, run: CycleRun, curve: Phases, before: int) -> str:
    """Return a description of the fault in a run that follows a whole S-curve; "" if there is none.

    `curve` is the whole S-curve; the other arguments are those of `fault_of_run`.
    """
    if run.cycles < 1:
        return f"{run.cycles} cycles"
    one, too_fast = 1 << PLACES, curve.velocity + 1 << PLACES
    for piece in law.pieces:
        if not 0 <= piece.speed < too_fast:
            return f"phase {piece.phase}: speed {piece.speed >> PLACES}; allowed 0 to {curve.velocity}"
    for piece, following in pairwise(law.pieces):
        if not -one < piece.covered(following.cycle) - following.position < one:
            return f"phase {piece.phase} does not end where the next one begins"
    if abs(law.velocity(0) - before) > curve.acceleration + 1:
        return f"from speed {before} to {law.velocity(0)}; the acceleration is {curve.acceleration}"
    if law.start + law.travel(run.cycles) != curve.distance >> PLACES:
        return f"lands at {law.start + law.travel(run.cycles)} instead of {curve.distance >> PLACES}"
    return ""
