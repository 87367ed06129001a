"""The axis parameters of a module with TMCL, and what its labels may be called."""

from __future__ import annotations

import re

from ..meaning import Profile

MANUAL = "TMCM-1290 TMCL firmware manual V1.01"
TOP, ACCELERATION, DECELERATION, START, STOP = 4, 5, 17, 19, 20  # axis parameters
SLOWEST_STOP = 10
MOST = {TOP: 7_999_774, ACCELERATION: 7_629_278, DECELERATION: 7_629_278, START: 249_999, STOP: 249_999}
LEAST_ACCELERATION = 117
NAMES = {TOP: "top rate", ACCELERATION: "acceleration", DECELERATION: "", START: "start rate", STOP: ""}


def parameters(profile: Profile) -> dict[int, float]:
    """Return the axis parameters of a profile, with their values."""
    start = profile.start if profile.ramped else profile.top
    wanted = {TOP: profile.top, START: start, STOP: max(start, SLOWEST_STOP)}
    if profile.ramped:
        wanted |= {ACCELERATION: profile.acceleration, DECELERATION: profile.acceleration}
    return wanted


def label(name: str) -> str:
    """Return a label as TMCL has it: a letter, then letters and digits."""
    plain = re.sub(r"\W", "", name)
    return plain[0].upper() + plain[1:] if plain.startswith(("line", "start", "end")) else f"Label{plain}"
