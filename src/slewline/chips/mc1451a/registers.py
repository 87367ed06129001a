"""A chipset's registers, as the manual lists them: those of each axis, and the few common to all axes.

An axis has double-buffered registers, registers with immediate effect, and a status.  Commands write to
the registers; the module that processes the cycles (motion.py, or its slow reference model in twin/)
reads them at the start of each cycle and writes its results to them.
"""

from __future__ import annotations

from dataclasses import MISSING, dataclass, field, fields
from operator import attrgetter

from .sheet import REGISTERS, ROWS

ONE = 1 << 16  # a step, and a step per cycle, in the 16.16 numbers of the chipset

TRAPEZOIDAL, VELOCITY, S_CURVE, GEAR = range(4)  # profile modes, as in the mode word

MOTION_COMPLETE, WRAPPED, BREAKPOINT, CAPTURED = 1, 2, 4, 8  # event bits in the status word
MOTION_ERROR, POSITIVE_LIMIT, NEGATIVE_LIMIT, COMMAND_ERROR = 16, 32, 64, 128

LIMIT_NAMES = {POSITIVE_LIMIT: "PosLimit", NEGATIVE_LIMIT: "NegLimit"}
PROFILE_COMMANDS = tuple(row.name for row in ROWS if row.sets and row.sets[0] == "mode")  # by profile mode


@dataclass(slots=True)
class Profile:
    """The double-buffered registers and actions of an axis; each register has the unit of its command."""

    position: int = 0  # steps
    velocity: int = 0  # 1/65536 step per cycle
    acceleration: int = 0  # 1/65536 step per cycle^2, signed
    max_acceleration: int = 0  # the same for S-curves
    jerk: int = 0  # 2^-32 step per cycle^3
    ratio: int = 0  # 1/65536 step per encoder count, signed
    loaded: frozenset[str] = frozenset()  # registers that the host has written since the last update
    stop: bool = False  # actions are done once
    smooth_stop: bool = False
    synch_prfl: bool = False
    cause: str = ""  # the command that caused the update

    def copy(self) -> Profile:
        """Return an independent copy."""
        return Profile(*VALUES(self))


SHOWS = {row.name: row.shows for row in ROWS}
# attribute of each register by its name; None: special case of `by_name`
SHOWN = {row.name: (shows := SHOWS.get(f"GET_{row.name.upper()}")) and attrgetter(shows) for row in REGISTERS}
VALUES = attrgetter(*(row.name for row in fields(Profile)))


@dataclass(slots=True)
class AxisState:
    """The state of one axis.  Distances are in 1/65536 step, speeds in that unit per cycle."""

    number: int  # 1 to 4
    buffer: Profile = field(default_factory=Profile)  # written by the host
    active: Profile = field(default_factory=Profile)  # active since the last update
    update: Profile | None = None  # values that an update has taken from the buffer, for the next cycle
    written: frozenset[str] = frozenset()  # its registers that updates have written since reset
    start_velocity: int = 0

    mode: int = TRAPEZOIDAL
    auto_update: bool = True
    auto_stop: bool = False
    high_speed: bool = False
    motor_on: bool = True
    was_off: bool = False  # the motor state since the last cycle that was processed
    awaits_update: bool = False  # no update was commanded since the motor was switched on: no motion starts
    breakpoint: str = ""  # armed condition: time, pos, neg, actl_pos, actl_neg, mtn_cmplt, ext
    comparison: int = 0  # of the breakpoint, as written: 32 bits unsigned
    mask: int = 0  # of interrupts
    step_ratio: int = 0  # counts per step * 256
    pos_err: int = 32767  # limit of the position error, in counts
    capture_home: bool = False

    events: int = 0  # bits 0 to 7 of the status word
    in_motion: bool = False
    motion_error: bool = False  # the position error exceeds its limit now
    reported: bool = False  # RST_INTRPT has tried to clear this motion error, so the host knows of it
    target: int = 0  # 1/65536 step, -2^46 to 2^46 - 1
    velocity: int = 0  # displacement of this cycle, signed
    phase: int = 0  # phase of an S-curve, 1 to 7; otherwise 0
    actual: int = 0  # encoder counts
    error: int = 0  # actual minus converted target, in counts, not limited to 16 bits

    def reset(self) -> None:
        """Set every register to its value after reset."""
        for each in fields(self):
            if each.name != "number":
                setattr(self, each.name, Profile() if each.default is MISSING else each.default)

    @property
    def status(self) -> int:
        """The status word."""
        return (
            self.events | self.motor_on << 8 | 1 << 9 | self.in_motion << 10 | (self.number - 1) << 12
        )  # bit 9: the axis is always on

    @property
    def steps(self) -> int:
        """The target position in whole steps, rounded down."""
        return self.target // ONE

    @property
    def position_error(self) -> int:
        """The position error as reported, limited to 16 bits."""
        return max(-32768, min(self.error, 32767))

    @property
    def breakpoint_command(self) -> str:
        """The command that has set the breakpoint."""
        return f"SET_{self.breakpoint.upper()}_BRK"

    @property
    def mode_word(self) -> int:
        """The mode word."""
        return (
            self.auto_stop << 7
            | self.high_speed << 9
            | (not self.auto_update) << 10
            | self.mode << 11
            | self.phase << 13
        )

    def load(self, register: str, value: int) -> None:
        """Write a double-buffered register, and record the write."""
        setattr(self.buffer, register, value)
        self.buffer.loaded |= {register}

    def take(self, cause: str) -> None:
        """Begin an update; `cause` is the command that requested it, or that set the breakpoint which triggers it.

        The buffered values, and the actions commanded since the last update, take effect in the next cycle.

        A motion may start only if the motor is on during this call: after MTR_ON the axis stays at rest until a
        move is initiated (manual, pulse generation control).  This is so even if MTR_ON and the update fall in
        the same cycle.
        """
        self.awaits_update = not self.motor_on
        buffer, waiting = self.buffer, self.update
        update = self.update = buffer.copy()
        update.cause = cause
        if waiting is not None:
            update.stop |= waiting.stop
            update.smooth_stop |= waiting.smooth_stop
            update.synch_prfl |= waiting.synch_prfl
            update.loaded |= waiting.loaded
        self.written |= buffer.loaded
        buffer.stop = buffer.smooth_stop = buffer.synch_prfl = False
        buffer.loaded = frozenset()

    def switch_off(self) -> None:
        """Switch the motor off, by command or after a stall.

        The next cycle ends the motion, even if the motor is on again by then.
        """
        self.motor_on, self.awaits_update = False, True
        self.was_off = True

    @property
    def interrupts(self) -> int:
        """The events that interrupt the host, as bits of the status word."""
        return self.events & self.mask & ~(MOTION_ERROR if self.reported else 0)

    def clear(self, mask: int) -> None:
        """Clear the events whose bits in `mask` are 0, except a motion error that still persists."""
        self.events &= mask | (MOTION_ERROR if self.motion_error else 0)


class Registers:
    """The axes of a chipset (`states`), one of which is current, and the registers common to all axes."""

    def __init__(self, axes: int) -> None:
        self.states = [AxisState(number) for number in range(1, axes + 1)]
        self.clear()

    def clear(self) -> None:
        """Set every register to its value after reset."""
        for state in self.states:
            state.reset()
        self.current = 1
        self.limit_sense = 0
        self.limits_on = True

    @property
    def axis(self) -> AxisState:
        """The registers of the current axis."""
        return self.states[self.current - 1]

    def by_name(self, number: int, cycle: int) -> dict[str, int]:
        """Return the present registers of axis `number` as {name: value}; `cycle` is the present cycle's number.

        The names are those of the commands that write and read the registers, in lower case without SET_ or
        GET_.
        """
        apart = {"capt": 0, "time": cycle % (1 << 32)}
        state = self.states[number - 1]
        return {name: show(state) if show else apart[name] for name, show in SHOWN.items()}


def signed(value: int, bits: int) -> int:
    """Return the lowest `bits` bits of a number, interpreted as two's complement."""
    half = 1 << (bits - 1)
    return (value + half) % (2 * half) - half
