"""The registers of one axis, as the manual lists them: double-buffered ones, those that act at once, and the status.

Commands write here; the motion (motion.py, or its slow twin stepwise.py) reads them at the start of the next cycle and
writes what it makes of them.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field

ONE = 1 << 16  # a step, and a step per cycle, in the 16.16 numbers of the chipset

TRAPEZOIDAL, VELOCITY, S_CURVE, GEAR = range(4)  # profile modes, as in the mode word

MOTION_COMPLETE, WRAPPED, BREAKPOINT, CAPTURED = 1, 2, 4, 8  # event bits of the status word
MOTION_ERROR, POSITIVE_LIMIT, NEGATIVE_LIMIT, COMMAND_ERROR = 16, 32, 64, 128

LIMIT_NAMES = {POSITIVE_LIMIT: "PosLimit", NEGATIVE_LIMIT: "NegLimit"}
PROFILE_COMMANDS = ("SET_PRFL_TRAP", "SET_PRFL_VEL", "SET_PRFL_S_CRV", "SET_PRFL_GEAR")  # by profile mode


@dataclass(slots=True)
class Profile:
    """The registers and actions that are double-buffered, registers in the units of their commands."""

    position: int = 0  # steps
    velocity: int = 0  # 1/65536 step per cycle
    acceleration: int = 0  # 1/65536 step per cycle^2, signed
    max_acceleration: int = 0  # the same, of S-curves
    jerk: int = 0  # 2^-32 step per cycle^3
    ratio: int = 0  # 1/65536 step per encoder count, signed
    loaded: frozenset[str] = frozenset()  # which of these the host has written since the last update
    stop: bool = False  # actions are done once
    smooth_stop: bool = False
    synch_prfl: bool = False
    cause: str = ""  # the command that has updated

    def copy(self) -> Profile:
        """The same values, apart."""
        return copy(self)


@dataclass(slots=True)
class AxisState:
    """One axis.  Distances and speeds are in 1/65536 step, and per cycle."""

    number: int  # 1 to 4
    buffer: Profile = field(default_factory=Profile)  # written by the host
    active: Profile = field(default_factory=Profile)  # in force since the last update
    update: Profile | None = None  # what an update has taken from the buffer; it waits for the next cycle
    start_velocity: int = 0

    mode: int = TRAPEZOIDAL
    auto_update: bool = True
    auto_stop: bool = False
    high_speed: bool = False
    motor_on: bool = True
    held: bool = False  # the motor has been off, and no update was commanded since it is on: nothing starts
    breakpoint: str = ""  # what is armed: time, pos, neg, actl_pos, actl_neg, mtn_cmplt, ext
    comparison: int = 0  # of the breakpoint, as written: 32 bits unsigned
    mask: int = 0  # of interrupts
    step_ratio: int = 0  # counts per step * 256
    pos_err: int = 32767  # limit of the position error, in counts
    capture_home: bool = False

    events: int = 0  # bits 0 to 7 of the status word
    in_motion: bool = False
    motion_error: bool = False  # the position error exceeds its limit now
    reported: bool = False  # RST_INTRPT was to clear this motion error: the host knows of it
    target: int = 0  # 1/65536 step, -2^46 to 2^46 - 1
    velocity: int = 0  # displacement of this cycle, signed
    phase: int = 0  # of an S-curve: 1 to 7; else 0
    actual: int = 0  # encoder counts
    error: int = 0  # actual minus converted target, in counts, not limited to 16 bits

    @property
    def status(self) -> int:
        """The status word."""
        return (
            self.events | self.motor_on << 8 | 1 << 9 | self.in_motion << 10 | (self.number - 1) << 12
        )  # bit 9: the axis is always on

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
        """Write a double-buffered register, and note that the host did."""
        setattr(self.buffer, register, value)
        self.buffer.loaded |= {register}

    def take(self, cause: str) -> None:
        """Take an update, which a command or the breakpoint that it has set causes.

        What is buffered takes effect with the next cycle, and so do actions since the last one.

        Whether it may start something is decided now, by the motor: behind MTR_ON the axis stays at rest until a move
        is initiated (pulse generation control), whichever cycle sees that.
        """
        self.held = not self.motor_on
        before, self.update = self.update or Profile(), self.buffer.copy()
        for action in ("stop", "smooth_stop", "synch_prfl"):
            setattr(self.update, action, getattr(before, action) or getattr(self.buffer, action))
            setattr(self.buffer, action, False)
        self.update.cause = cause
        self.update.loaded = before.loaded | self.buffer.loaded
        self.buffer.loaded = frozenset()

    def switch_off(self) -> None:
        """Switch the motor off, by command or by a stall."""
        self.motor_on, self.held = False, True

    @property
    def interrupts(self) -> int:
        """The events that ask for the host."""
        return self.events & self.mask & ~(MOTION_ERROR if self.reported else 0)

    def clear(self, mask: int) -> None:
        """Clear the events whose bit in `mask` is 0; a motion error that lasts is not cleared."""
        self.events &= mask | (MOTION_ERROR if self.motion_error else 0)


def signed(value: int, bits: int) -> int:
    """A number of so many bits in two's complement."""
    half = 1 << (bits - 1)
    return (value + half) % (2 * half) - half


def saturated(error: int) -> int:
    """A position error as it is reported, in 16 bits."""
    return max(-32768, min(error, 32767))
