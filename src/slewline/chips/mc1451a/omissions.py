"""What a host forgets most easily: what a motion needs, and the update itself.  The chipset and its linter ask here."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable
from dataclasses import fields

from .registers import GEAR, S_CURVE, TRAPEZOIDAL, VELOCITY, AxisState, Profile
from .sheet import ROWS

_LOADING = {row.loads: row.name for row in ROWS if row.buffered}
# double-buffered, by the command that writes it, and by the command that asks for it
REGISTERS = {_LOADING[row.name]: row.name for row in fields(Profile) if row.name in _LOADING}
ACTIONS = {row.name: row.sets[0] for row in ROWS if row.buffered and row.sets}
NEEDED = {  # by profile mode, to leave rest: how fast, which may be 0 on purpose; then what must not be 0
    TRAPEZOIDAL: ("SET_VEL", "SET_ACC"),
    VELOCITY: ("SET_VEL", "SET_ACC"),
    S_CURVE: ("SET_VEL", "SET_MAX_ACC", "SET_JERK"),
    GEAR: ("SET_RATIO",),
}


def missing(mode: int, value: Callable[[str], int | None], written: Container[str], starts: bool) -> list[str]:
    """Return the commands that must come before an update, to set an axis in motion; none where it is to rest.

    Args:
        mode: the profile mode.
        value: of a command, what an update brings; None: not known, which counts as 0.
        written: the commands that have been given; a velocity of 0 that was given is meant.
        starts: there is a start velocity, with which no acceleration is needed in trapezoidal mode.
    """
    speed, *others = NEEDED[mode]
    found = [] if mode == TRAPEZOIDAL and starts else [name for name in others if not value(name)]
    if value(speed):
        return found
    nothing_asked = mode == VELOCITY and found  # no velocity, no acceleration: and there is no destination
    return [] if speed in written or nothing_asked else [speed, *found]


def missing_of(mode: int, state: AxisState) -> list[str]:
    """Return what is missing in the registers of an axis, as they are in force."""
    active = state.active
    written = {name for name, register in REGISTERS.items() if register in state.written}
    return missing(mode, lambda name: getattr(active, REGISTERS[name]), written, bool(state.start_velocity))


def forgotten(pending: Iterable[str], armed: bool, auto_update: bool) -> list[str]:
    """Return what waits for an update and has none to expect, of all that waits for one."""
    return [] if armed and auto_update else list(pending)


def pending_of(buffer: Profile) -> list[str]:
    """Return the commands that wait for an update, with their values."""
    written = [
        f"{name} {getattr(buffer, register)}" for name, register in REGISTERS.items() if register in buffer.loaded
    ]
    return written + [name for name, action in ACTIONS.items() if getattr(buffer, action)]
