"""Durations of moves, from the first step to the last, on the source's part and on other controllers."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..chips import sheet_of
from ..core.time.timebase import PS_PER_S as PS
from ..errors import SlewlineError
from .meaning import Profile, Program
from .profiles import profiles_of


def measured(program: Program) -> Callable[[Profile, int], float]:
    """Return a function that calculates the time (s) of a source move from its profile and step count.

    The returned function uses the ramp law of the source's part, or `source_time` if no law is known.
    """
    try:
        law = profiles_of(program.part, sheet_of(program.part).crystal_hz)
    except SlewlineError:
        law = None
    if law is None:
        return source_time

    def time_of(profile: Profile, steps: int) -> float:
        usual = law.read(profile.values)  # with the usual crystal of the part
        ps = law.move_ps(usual, steps) if usual is not None else None
        if usual is None or ps is None or not profile.top:
            return source_time(profile, steps)
        return ps / PS * usual.top / profile.top

    return time_of


def source_time(profile: Profile, steps: int) -> float:
    """Return the time (s) of a move, from first step to last, if the source's ramp law is not known."""
    gaps = max(abs(steps) - 1, 0)
    if not profile.ramped or profile.steps <= 0:
        return gaps / profile.top if profile.top else 0.0
    ramps = 2 * profile.steps
    if gaps >= ramps:
        return 2 * profile.time_ps / PS + (gaps - ramps) / profile.top
    acceleration = (profile.top**2 - profile.start**2) / ramps
    reached = math.sqrt(profile.start**2 + acceleration * gaps)
    return 2 * (reached - profile.start) / acceleration


def standing_time(top: float, acceleration: float, steps: int) -> float:
    """Return the time of a move that begins and ends at standstill, s, with ramps of constant acceleration."""
    steps = abs(steps)
    if acceleration <= 0:
        return max(steps - 1, 0) / top if top else 0.0
    if steps >= top * top / acceleration:
        return steps / top + top / acceleration
    return 2 * math.sqrt(steps / acceleration)


def started_time(profile: Profile, steps: int) -> float:
    """Return the time (s) of a move, from first step to last, with ramps between start rate and top rate.

    The ramps have a constant acceleration.
    """
    gaps = max(abs(steps) - 1, 0)
    acceleration = profile.acceleration
    if not acceleration:
        return gaps / profile.top if profile.top else 0.0
    ramps = (profile.top**2 - profile.start**2) / acceleration  # both
    if gaps >= ramps:
        return 2 * (profile.top - profile.start) / acceleration + (gaps - ramps) / profile.top
    reached = math.sqrt(profile.start**2 + acceleration * gaps)
    return 2 * (reached - profile.start) / acceleration
