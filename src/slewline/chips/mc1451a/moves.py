"""How long a move of a script takes at least: what the linter knows of an axis in motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, sqrt

from ...core.datasheet.table import Sheet
from ...core.time.timebase import PS_PER_S, picoseconds
from ...errors import SlewlineError
from ...language.rates import cycles_per_s
from ...language.statements import Directive, Statement
from .registers import S_CURVE, VELOCITY

PASSING = ("drive", "release", "pulse", "note", "expect")  # directives that take no time
USED = ("SET_VEL", "SET_START_VEL", "SET_ACC", "SET_MAX_ACC", "SET_JERK")
SCALE = 1 << 16


@dataclass(frozen=True)
class KnownMove:
    """A move in progress.

    Attributes:
        begun: the last command before the update that began it.
        left_s: it takes at least so many seconds more.
        used: the values with which it began, by command; None: not known.
    """

    begun: Statement
    left_s: float
    used: Mapping[str, int | None]

    def changes(self, name: str, pending: Mapping[str, Statement]) -> bool:
        """Return whether an update would change one of its values."""
        return name in pending and self.used[name] is not None and pending[name].values[0] != self.used[name]

    def after(self, seconds: float) -> KnownMove | None:
        """Return the move after some seconds; None: it may be over."""
        return replace(self, left_s=self.left_s - seconds) if self.left_s > seconds else None


def waited_s(directive: Directive) -> float:
    """Return the seconds for which a host waits; without end where it waits for something to happen."""
    if directive.verb != "wait":
        return inf
    try:
        return picoseconds(directive.text.removeprefix("@").removeprefix("wait").strip()) / PS_PER_S
    except SlewlineError:  # a bit of the status word
        return inf


def least_s(sheet: Sheet, mode: int, end: int | None, at: int, used: Mapping[str, int | None]) -> float:
    """Return the seconds that a move takes at least; 0: it does not move, or that is not known.

    Args:
        mode: the profile mode.
        end: its destination.
        at: where it begins.
        used: velocities, acceleration and jerk, by command.
    """
    velocity = (used["SET_VEL"] or 0) / SCALE
    acceleration = abs(used["SET_MAX_ACC" if mode == S_CURVE else "SET_ACC"] or 0) / SCALE
    if not velocity or not acceleration or (mode == S_CURVE and not used["SET_JERK"]):
        return 0
    if mode == VELOCITY:
        return inf
    if end is None:
        return 0
    distance = abs(end - at)
    if used["SET_START_VEL"] != 0:
        cycles = distance / velocity  # at most the ramps are missing
    elif distance > velocity * velocity / acceleration:
        cycles = distance / velocity + velocity / acceleration
    else:
        cycles = 2 * sqrt(distance / acceleration)
    return cycles / float(cycles_per_s(sheet))
