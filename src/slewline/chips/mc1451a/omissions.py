"""A host's omissions and mistakes: unset registers, missing updates, refused changes, servo chip codes.

Both the chipset and its linter use this file.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator
from dataclasses import fields
from types import MappingProxyType

from ...core.datasheet.table import Sheet
from .registers import GEAR, S_CURVE, TRAPEZOIDAL, VELOCITY, AxisState, Profile
from .sheet import ROWS, SERVO, SIBLINGS

_LOADING = {row.loads: row.name for row in ROWS if row.buffered}
# double-buffered registers and actions, by their command
REGISTERS = {_LOADING[row.name]: row.name for row in fields(Profile) if row.name in _LOADING}
ACTIONS = {row.name: row.sets[0] for row in ROWS if row.buffered and row.sets}
NEEDED = {  # by profile mode, to leave rest: the velocity, which may be 0; then registers that must not be 0
    TRAPEZOIDAL: ("SET_VEL", "SET_ACC"),
    VELOCITY: ("SET_VEL", "SET_ACC"),
    S_CURVE: ("SET_VEL", "SET_MAX_ACC", "SET_JERK"),
    GEAR: ("SET_RATIO",),
}

REST = {  # by profile mode: its name, and the registers that an update may not change in motion
    TRAPEZOIDAL: ("trapezoidal", ("SET_ACC",)),
    S_CURVE: ("S-curve", ("SET_VEL", "SET_MAX_ACC", "SET_JERK")),
}
IN_MOTION = {
    mode: f"an update in motion changes {' or '.join(names)}, in {name} mode: command error, and only a new "
    "destination is applied; wait for motion complete before the update"
    for mode, (name, names) in REST.items()
}
AT_LIMIT = (
    "no motion starts, because the limit switch ahead is active, or the event bit of a switch is set; clear that bit "
    "with RST_STATUS, then move in the other direction"
)
STARTING = TRAPEZOIDAL, VELOCITY  # the profile modes with a start velocity
NEXT_START = "SET_START_VEL in motion takes effect at the next start; send it at rest"
STALL = "the position error exceeds SET_POS_ERR: the motor has lost steps, or the encoder miscounts"


def missing(mode: int, value: Callable[[str], int | None], written: Container[str], starts: bool) -> list[str]:
    """Return the commands missing before an update that is to start an axis; [] if the axis is to stay at rest.

    Args:
        mode: the profile mode.
        value: a function that returns the value set by a command, as the update will use it; None if
            unknown, which counts as 0.
        written: the commands sent so far; a velocity of 0 that was sent explicitly is intended.
        starts: True if there is a start velocity; trapezoidal mode then needs no acceleration.
    """
    speed, *others = NEEDED[mode]
    found = [] if mode == TRAPEZOIDAL and starts else [name for name in others if not value(name)]
    if value(speed):
        return found
    nothing_asked = mode == VELOCITY and found  # no velocity, no acceleration, and no destination
    return [] if speed in written or nothing_asked else [speed, *found]


def missing_of(mode: int, state: AxisState) -> list[str]:
    """Return the commands that are missing before an axis can start, judging from its active registers."""
    active = state.active
    written = {name for name, register in REGISTERS.items() if register in state.written}
    return missing(mode, lambda name: getattr(active, REGISTERS[name]), written, bool(state.start_velocity))


def forgotten(pending: Iterable[str], armed: bool, auto_update: bool) -> list[str]:
    """Return the pending commands, or [] if a breakpoint is armed that will apply them by auto update."""
    return [] if armed and auto_update else list(pending)


def pending_of(buffer: Profile) -> list[str]:
    """Return the commands that wait for an update, with their values."""
    written = [
        f"{name} {getattr(buffer, register)}" for name, register in REGISTERS.items() if register in buffer.loaded
    ]
    return written + [name for name, action in ACTIONS.items() if getattr(buffer, action)]


# -------------------------------------------------------------------------------------------- programs for a servo chip
ELSEWHERE = MappingProxyType({0x3B: "SET_OUTPUT_DAC16", 0x3C: "SET_OUTPUT_PWM"})  # codes with another meaning there
REMEDY = "motion commands are the same in both; omit commands for gains and outputs"


def servo(sheet: Sheet, code: int) -> str:
    """Return a remark on a command code if it belongs to the servo chip but not to this part; "" for any other."""
    sibling = SIBLINGS.get(code)
    if sibling is None or sibling.of != SERVO:
        return ""
    here = {found: row.name for found in ELSEWHERE if (row := sheet.commands.by_code.get(found)) is not None}
    others = ", ".join(f"{found:02x} is {name} here and {ELSEWHERE[found]} there" for found, name in here.items())
    return f"{code:02x} is {sibling.name} of {SERVO}: no effect here; {others}"


def codes(sheet: Sheet, data: bytes) -> Iterator[tuple[int, int]]:
    """Yield the command code of each packet in a host's bytes, and the index at which the packet ends.

    The end of the last packet may be beyond these bytes.
    """
    at = 0
    while at < len(data):
        row, sibling = sheet.commands.by_code.get(data[at]), SIBLINGS.get(data[at])
        size = row.size if row is not None else 1 + 2 * (sibling.writes if sibling is not None else 0)
        yield data[at], at + size
        at += size
