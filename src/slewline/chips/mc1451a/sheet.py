"""The MC1151A, MC1251A, MC1451A and their -E parts as data, from the chipset's manual (PMD, rev. 12.02, 11/1997).

There is one sheet for six parts, which differ in the number of axes and in the encoder chip (-E).  A part is a set of
packages: I/O chip, CP chip and, with encoders, ENC chip; `where` names a pin's package.  Pins without a signal in the
model, such as the wires between the packages, have the package as a prefix of their name.

The chipset counts clocks: 8192 clocks are a cycle, 2048 a time slice.  Speeds are in 2^-16 steps per cycle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from ...core.datasheet.channel import HostPort
from ...core.datasheet.command_rows import PacketRow
from ...core.datasheet.option import Option
from ...core.datasheet.table import Arg, Bits, InOut, Limit, Pin, Register, Sheet, Table, Timing
from ...language.packets import Packets, Sibling

CRYSTAL_HZ = 25_000_000
CYCLE_TICKS = 8192
SLICE_TICKS = 2048  # the host port is processed once per slice, four times per cycle
RESET_CYCLES = 10  # time for which HostRdy is low after reset
STANDARD_RANGE, HIGH_RANGE = 16, 512  # maximum pulses per cycle
FILTER_TICKS = 12  # three CLKOUT periods
CLKOUT_TICKS = 4

# ------------------------------------------------------------------------------------------------- pin description
_IO, _CP, _ENC = "I/O chip; pin descriptions", "CP chip; pin descriptions", "ENC chip; pin descriptions"
_CYCLE, _FILTERED = "once per cycle", "once per cycle, after a filter of 480 ns"
_STROBE = "at the strobes"


def _wires(
    where: str, numbers: Sequence[int], name: str, in_out: InOut, description: str, first: int = 0
) -> tuple[Pin, ...]:
    """Return numbered pins without a signal in the model; `first` is the number in the name of the first pin."""
    return tuple(
        Pin(number, f"{name}{first + n}", in_out, description, where=where) for n, number in enumerate(numbers)
    )


def _supply(where: str, package: str, vcc: Sequence[int], gnd: Sequence[int]) -> tuple[Pin, ...]:
    return (
        *(Pin(number, f"{package}_vcc{number}", "power", "+5 V", where=where) for number in vcc),
        *(Pin(number, f"{package}_gnd{number}", "power", "ground", where=where) for number in gnd),
    )


# fmt: off
PINS = (
    *(Pin(number, f"pulse{n}", "out", f"axis {n}: a step at every falling edge; a square wave", active=0, reset=0, where=_IO, axis=n, role="step") for n, number in enumerate((28, 26, 40, 39), 1)),
    *(Pin(number, f"dir{n}", "out", f"axis {n}: high: positive direction", active=1, reset=1, where=_IO, axis=n, role="direction") for n, number in enumerate((42, 30, 35, 34), 1)),
    *(Pin(number, f"home{n}", "in", f"axis {n}: low satisfies the external breakpoint", active=0, tie=1, seen=_FILTERED, where=_IO, axis=n, role="home", reflex="mark", transcript=(f"axis {n} at its home position", "")) for n, number in enumerate((13, 23, 11, 10), 1)),
    Pin(41, "hostcmd", "in", "high: a command is written; low: data", active=1, tie=0, seen=_STROBE, where=_IO, role="command"),
    Pin(37, "hostrdy", "out", "high: ready; low after reset, a command or a word", active=1, reset=0, where=_IO, role="ready"),
    Pin(51, "hostread", "in", "low: the chip puts a byte on the host bus", active=0, tie=1, seen="both edges", where=_IO, role="read"),
    Pin(47, "hostwrite", "in", "its rising edge takes a byte from the host bus", active=0, tie=1, seen="rising edge", where=_IO, role="write"),
    Pin(48, "hostslct", "in", "low selects the port; high while it is not used", active=0, tie=1, seen=_STROBE, where=_IO, role="chip_select"),
    Pin(44, "hostintrpt", "out", "low: an axis has an event that its mask enables", active=0, reset=1, where=_IO, role="interrupt", transcript=("an axis has an event for the host", "")),
    *(Pin(number, f"hostdata{bit}", "both", f"host bus, bit {bit}", active=1, where=_IO, role="data") for bit, number in enumerate((50, 61, 53, 65, 67, 62, 64, 60))),
    Pin(46, "io_cpclk", "none", "clock from CLKOUT", where=_IO),
    Pin(52, "io_ioclkin", "none", "shifted clock; wire it to IOCLKOUT", where=_IO),
    Pin(45, "io_ioclkout", "none", "shifted clock", where=_IO),
    *_wires(_IO, (68, 27, 29, 12), "io_cpaddr", "none", "address from the CP chip"),
    Pin(2, "io_cpwrite", "none", "write strobe of the CP chip", active=0, where=_IO),
    *_wires(_IO, (20, 36, 22, 63), "io_cpcntrl", "none", "control between I/O and CP chip"),
    *_wires(_IO, (18, 5, 6, 7, 8, 17, 3, 1), "io_cpdata", "none", "data between I/O and CP chip", first=4),
    Pin(43, "io_cpreset", "none", "wire it to RESET", active=0, where=_IO),
    *_supply(_IO, "io", (4, 21, 25, 38, 55), (14, 15, 32, 49, 54, 66)),
    *(Pin(number, f"atrest{n}", "out", f"axis {n}: high at rest, low in motion", active=1, reset=1, where=_CP, axis=n, role="moving", sense=0) for n, number in enumerate((56, 55, 54, 53), 1)),
    *(Pin(number, f"poslimit{n}", "in", f"axis {n}: end of travel in positive direction; SET_LMT_SENSE inverts its level", active=1, tie=0, seen=_CYCLE, where=_CP, axis=n, role="end_plus", reflex="stop up", transcript=("", "")) for n, number in enumerate((52, 45, 42, 38), 1)),
    *(Pin(number, f"neglimit{n}", "in", f"axis {n}: end of travel in negative direction; SET_LMT_SENSE inverts its level", active=1, tie=0, seen=_CYCLE, where=_CP, axis=n, role="end_minus", reflex="stop down", transcript=("", "")) for n, number in enumerate((51, 44, 41, 37), 1)),
    Pin(24, "clkin", "power", "master clock", where=_CP),
    Pin(19, "clkout", "out", "a quarter of the master clock, for the other chips", where=_CP, role="clock"),
    Pin(17, "reset", "in", "low resets the chipset; must not end within 0.25 s of power-up", active=0, tie=1, seen="level, low for 1 µs", where=_CP, role="reset", transcript=("the chipset is held in reset", "the chipset starts again")),
    *_wires(_CP, (16, 18, 68, 67), "cp_iocntrl", "none", "control between the chips"),
    *_wires(_CP, (58, 57, 50, 49, 46, 43, 40, 39, 36, 35), "cp_data", "none", "data between the chips", first=2),
    *_wires(_CP, (28, 9, 6, 5), "cp_ioaddr", "none", "address to the other chips"),
    Pin(15, "cp_iowrite", "none", "write strobe to the other chips", active=0, where=_CP),
    *_supply(_CP, "cp", (4, 22, 33), (3, 34)),
    *(Pin(number, f"quada{n}", "in", f"axis {n}: encoder channel A, ahead of B in positive direction", tie=0, seen=_FILTERED, where=_ENC, axis=n, role="encoder_a") for n, number in enumerate((30, 17, 27, 5), 1)),
    *(Pin(number, f"quadb{n}", "in", f"axis {n}: encoder channel B", tie=0, seen=_FILTERED, where=_ENC, axis=n, role="encoder_b") for n, number in enumerate((36, 18, 28, 29), 1)),
    Pin(7, "enc_cpclk", "none", "clock from CLKOUT", where=_ENC),
    Pin(33, "enc_encclkin", "none", "shifted clock; wire it to ENCCLKOUT", where=_ENC),
    Pin(6, "enc_encclkout", "none", "shifted clock", where=_ENC),
    Pin(24, "enc_cpaddr0", "none", "address from the CP chip", where=_ENC),
    *_wires(_ENC, (20, 23), "enc_cpaddr", "none", "address from the CP chip", first=2),
    Pin(13, "enc_cpwrite", "none", "write strobe of the CP chip", active=0, where=_ENC),
    Pin(15, "enc_cpcntrl0", "none", "control from the CP chip", where=_ENC),
    *_wires(_ENC, (22, 19, 9, 31, 41, 42, 44, 1, 12, 2), "enc_cpdata", "none", "data between ENC and CP chip", first=2),
    *_supply(_ENC, "enc", (3, 14, 16, 25, 35), (10, 21, 32, 34, 43)),
)
# fmt: on
WIRES = (  # without the names that no package has
    *((f"cp_data{n}", f"io_cpdata{n}", f"enc_cpdata{n}") for n in range(2, 12)),
    *((f"cp_ioaddr{n}", f"io_cpaddr{n}", f"enc_cpaddr{n}") for n in range(4)),
    *((f"cp_iocntrl{n}", f"io_cpcntrl{n}", f"enc_cpcntrl{n}") for n in range(4)),
    ("cp_iowrite", "io_cpwrite", "enc_cpwrite"),
    ("clkout", "io_cpclk", "enc_cpclk"),
    ("reset", "io_cpreset"),
    ("io_ioclkout", "io_ioclkin"),
    ("enc_encclkout", "enc_encclkin"),
)
PER_AXIS = ("pulse", "dir", "home", "atrest", "poslimit", "neglimit", "quada", "quadb")


def _pins(axes: int, encoder: bool) -> tuple[Pin, ...]:
    """Return the pins of a part with `axes` axes."""
    return tuple(
        pin
        for pin in PINS
        if (encoder or pin.where != _ENC) and not (pin.name[:-1] in PER_AXIS and int(pin.name[-1]) > axes)
    )


def _limits(pins: Sequence[Pin]) -> tuple[Limit, ...]:
    """Return the limits on the time between two edges, except limits for pins that the part does not have."""
    names = {pin.name for pin in pins} | {"hostdata"}
    return tuple(limit for limit in LIMITS if names >= {limit.start.split()[0], limit.end.split()[0]})


def _wired(pins: Sequence[Pin]) -> tuple[tuple[str, ...], ...]:
    """Return the wires between the packages of a part, each as the names of the pins that it connects."""
    names = {pin.name for pin in pins}
    wires = (tuple(name for name in wire if name in names) for wire in WIRES)
    return tuple(wire for wire in wires if wire[1:])


# ------------------------------------------------------------------------------------------------- words about an axis
STATUS = (
    Bits("motion_complete", 0, "the profile has ended"),
    Bits("wrap_around", 1, "the target has passed an end of the position range"),
    Bits("breakpoint", 2, "a breakpoint was reached"),
    Bits("capture", 3, "a position was captured"),
    Bits("motion_error", 4, "the position error has exceeded its limit"),
    Bits("positive_limit", 5, "the positive limit switch has become active"),
    Bits("negative_limit", 6, "the negative limit switch has become active"),
    Bits("command_error", 7, "a command was not valid in this state"),
    Bits("motor_on", 8, "pulses are enabled"),
    Bits("axis_on", 9, "the axis is on: always"),
    Bits("in_motion", 10, "the profile is in motion"),
    Bits("axis", 12, "number of the axis", width=2, first=1),
)
EVENTS = STATUS[:8]  # set by the chipset, cleared by the host; each can interrupt
MODE = (
    Bits("auto_stop", 7, "a motion error switches the motor off"),
    Bits("high_speed", 9, "pulse range: up to 512 pulses per cycle, else 16"),
    Bits("auto_update_off", 10, "a breakpoint updates nothing"),
    Bits("profile", 11, "profile mode: 0 trapezoidal, 1 velocity contouring, 2 S-curve, 3 electronic gear", width=2),
    Bits("phase", 13, "phase of the S-curve, 1 to 7; else 0", width=3),
)

# ---------------------------------------------------------------------------------------------- commands, in groups
BUSY_US = 82  # after a command and after every word, typically
TOP = (1 << 30) - 1
POSITION = Arg("position", 4, -TOP - 1, TOP, unit="steps")
VELOCITY = Arg("velocity", 4, 0, TOP, unit="steps/cycle", fraction=16, cycles=1)
ACCELERATION = Arg("acceleration", 4, -TOP - 1, TOP, unit="steps/cycle^2", fraction=16, cycles=2)
MAX_ACCELERATION = Arg("max_acceleration", 2, 0, 32767, unit="steps/cycle^2", fraction=16, cycles=2)
JERK = Arg("jerk", 4, 0, (1 << 31) - 1, unit="steps/cycle^3", fraction=32, cycles=3)
RATIO = Arg("ratio", 4, -TOP - 1, TOP, unit="steps/count", fraction=16)
START_VELOCITY = replace(VELOCITY, name="start_velocity")
TARGET_VELOCITY = Arg("target_velocity", 4, -TOP - 1, TOP, unit="steps/cycle", fraction=16, cycles=1)
COMPARISON = Arg("comparison", 4, -1 << 31, (1 << 32) - 1, unit="cycles, steps or counts")
ACTUAL = replace(POSITION, name="actual_position", unit="counts")
LIMIT = Arg("limit", 2, 0, 32767, unit="counts")
POSITION_ERROR = Arg("position_error", 2, -32768, 32767, unit="counts")
STEP_RATIO = Arg("step_ratio", 2, 0, 32767, unit="counts/step", fraction=8)
STATUS_WORD, MODE_WORD = Arg("status", 2, 0, 0xFFFF), Arg("mode", 2, 0, 0xFFFF)
MASK = Arg("mask", 2, 0, 0xFF, unit="bits of the events")
CLEARING = Arg("mask", 2, 0, 0xFFFF, unit="bits of the events, 0 clears")
AXES = Arg("axes", 2, 0, 0xF, unit="bits of the axes")
SWITCHES = Arg("switches", 2, 0, 0xFF, unit="bits: axis 1 positive, negative, axis 2 ...")
HOMES = Arg("homes", 2, 0, 0xF, unit="bits of the axes")
TIME = Arg("time", 4, 0, (1 << 32) - 1, unit="cycles")
VERSION = Arg("version", 2, 0, 0xFFFF)


@dataclass(frozen=True, slots=True)
class RegisterRow(PacketRow):
    """A command, with its effect on a register; a command that does more has a method in instructions.py.

    `sets` is a register and the fixed value that the command writes to it.  `loads` is the register that
    stores the host's number, in `bits` bits (negative: signed).  `shows` is the register that the command
    reads.

    If `acts` is "current", these are registers of the current axis, or of its buffer if the command is
    buffered.  Otherwise they are registers of the chipset.
    """

    sets: tuple[str, object] | None = None
    loads: str = ""
    bits: int = 0
    shows: str = ""


def _do(name: str, code: int, description: str, *args: Arg, reads: Arg | None = None, acts: str = "current", **more: Any) -> RegisterRow:  # fmt: skip
    """Return the row of a command with arguments `args`; `reads` is the value that the host reads.

    `acts` names the axes on which the command acts.
    """
    found = () if reads is None else (reads,)
    return RegisterRow(name, name, args, BUSY_US, description, "command reference", code=code, acts=acts, reads=found, **more)  # fmt: skip


# fmt: off
ROWS = (
    # axis control
    *(_do(f"SET_{n}", n, f"axis {n} becomes the current axis", reads=STATUS_WORD, acts="set", sets=("current", n), shows="axis.status", role="axis") for n in range(1, 5)),
    _do("SET_I", 0x08, "the interrupting axis becomes the current axis", reads=STATUS_WORD, acts="interrupting"),
    # profile generation
    _do("SET_PRFL_TRAP", 0x09, "profile mode: trapezoidal point to point", sets=("mode", 0)),
    _do("SET_PRFL_VEL", 0x0A, "profile mode: velocity contouring", sets=("mode", 1)),
    _do("SET_PRFL_S_CRV", 0x0B, "profile mode: S-curve point to point", sets=("mode", 2)),
    _do("SET_PRFL_GEAR", 0x0C, "profile mode: electronic gear", encoder=True, sets=("mode", 3)),
    _do("SET_POS", 0x10, "destination position", POSITION, buffered=True, loads="position", bits=-31, role="target"),
    _do("SET_VEL", 0x11, "maximum velocity", VELOCITY, buffered=True, loads="velocity", bits=31, role="top_rate"),
    _do("SET_ACC", 0x12, "acceleration; signed in velocity contouring", ACCELERATION, buffered=True, loads="acceleration", bits=-32, role="ramp"),
    _do("SET_JERK", 0x13, "jerk of the S-curve", JERK, buffered=True, loads="jerk", bits=31),
    _do("SET_RATIO", 0x14, "gear ratio", RATIO, buffered=True, encoder=True, loads="ratio", bits=-32),
    _do("SET_MAX_ACC", 0x15, "greatest acceleration of the S-curve", MAX_ACCELERATION, buffered=True, loads="max_acceleration", bits=15),
    _do("SET_START_VEL", 0x6A, "lowest velocity of the trapezoidal and velocity profiles", START_VELOCITY, loads="start_velocity", bits=31, role="start_rate"),
    _do("STOP", 0x46, "stop immediately", buffered=True, at_once="stop", sets=("stop", True)),
    _do("SMOOTH_STOP", 0x4E, "decelerate and stop", buffered=True, at_once="brake", sets=("smooth_stop", True)),
    _do("SYNCH_PRFL", 0x47, "the target becomes the actual position", buffered=True, encoder=True, sets=("synch_prfl", True)),
    _do("GET_POS", 0x4A, "destination position, as written", reads=POSITION, shows="buffer.position"),
    _do("GET_VEL", 0x4B, "maximum velocity, as written", reads=VELOCITY, shows="buffer.velocity"),
    _do("GET_ACC", 0x4C, "acceleration, as written", reads=ACCELERATION, shows="buffer.acceleration"),
    _do("GET_MAX_ACC", 0x4F, "greatest acceleration of the S-curve, as written", reads=MAX_ACCELERATION, shows="buffer.max_acceleration"),
    _do("GET_JERK", 0x58, "jerk, as written", reads=JERK, shows="buffer.jerk"),
    _do("GET_RATIO", 0x59, "gear ratio, as written", reads=RATIO, encoder=True, shows="buffer.ratio"),
    _do("GET_START_VEL", 0x6B, "start velocity", reads=START_VELOCITY, shows="start_velocity"),
    _do("GET_TRGT_POS", 0x1D, "target position of this cycle", reads=POSITION, shows="steps"),
    _do("GET_TRGT_VEL", 0x1E, "target velocity of this cycle", reads=TARGET_VELOCITY, shows="velocity"),
    # parameter update
    _do("SET_TIME_BRK", 0x17, "breakpoint: the time equals the comparison value", sets=("breakpoint", "time")),
    _do("SET_POS_BRK", 0x18, "breakpoint: the target is at the comparison value or above", sets=("breakpoint", "pos")),
    _do("SET_NEG_BRK", 0x19, "breakpoint: the target is at the comparison value or below", sets=("breakpoint", "neg")),
    _do("SET_ACTL_POS_BRK", 0x1B, "breakpoint: the actual position is at the comparison value or above", encoder=True, sets=("breakpoint", "actl_pos")),
    _do("SET_ACTL_NEG_BRK", 0x1C, "breakpoint: the actual position is at the comparison value or below", encoder=True, sets=("breakpoint", "actl_neg")),
    _do("SET_MTN_CMPLT_BRK", 0x35, "breakpoint: motion complete", sets=("breakpoint", "mtn_cmplt")),
    _do("SET_EXT_BRK", 0x5E, "breakpoint: HOME is low", sets=("breakpoint", "ext")),
    _do("SET_BRK_OFF", 0x6D, "no breakpoint", sets=("breakpoint", "")),
    _do("SET_BRK_PNT", 0x16, "comparison value of breakpoints", COMPARISON, loads="comparison", bits=32),
    _do("UPDATE", 0x1A, "buffered values take effect with the next cycle", role="update"),
    _do("MULTI_UPDATE", 0x5B, "an update of several axes, in the same cycle", AXES, acts="mask"),
    _do("SET_AUTO_UPDATE_ON", 0x5C, "a breakpoint triggers an update", sets=("auto_update", True)),
    _do("SET_AUTO_UPDATE_OFF", 0x5D, "a breakpoint only sets its flag", sets=("auto_update", False)),
    _do("GET_BRK_PNT", 0x57, "comparison value of breakpoints", reads=COMPARISON, shows="comparison"),
    # interrupt processing
    _do("SET_INTRPT_MASK", 0x2F, "events that interrupt the host", MASK, loads="mask", bits=8),
    _do("GET_INTRPT", 0x30, "status word of the interrupting axis", reads=STATUS_WORD, acts="interrupting"),
    _do("RST_INTRPT", 0x32, "clear events of the interrupting axis and end the interrupt", CLEARING, acts="interrupting"),
    _do("GET_INTRPT_MASK", 0x56, "events that interrupt the host", reads=MASK, shows="mask"),
    # status and mode
    _do("CLR_STATUS", 0x33, "clear all events", role="clear_events"),
    _do("RST_STATUS", 0x34, "clear events", CLEARING),
    _do("GET_STATUS", 0x31, "status word", reads=STATUS_WORD, shows="status"),
    _do("GET_MODE", 0x48, "mode word", reads=MODE_WORD, shows="mode_word"),
    # pulse generation
    _do("SET_OUTPUT_STNDRD", 0x3C, "pulse range: up to 48.828 kpulses/s", sets=("high_speed", False)),
    _do("SET_OUTPUT_HIGH", 0x3B, "pulse range: up to 1.5625 Mpulses/s", sets=("high_speed", True)),
    _do("MTR_ON", 0x43, "enable pulses", sets=("motor_on", True)),
    _do("MTR_OFF", 0x42, "stop and disable pulses", at_once="stop"),
    # encoder
    _do("GET_ACTL_POS", 0x37, "actual position", reads=ACTUAL, encoder=True, shows="actual"),
    _do("SET_CAPT_INDEX", 0x64, "capture by the index signal", encoder=True, sets=("capture_home", False)),
    _do("SET_CAPT_HOME", 0x65, "capture by the home signal", encoder=True, sets=("capture_home", True)),
    _do("GET_CAPT", 0x36, "captured position; arms the next capture", reads=replace(ACTUAL, name="captured"), encoder=True),
    _do("SET_STEP_RATIO", 0x68, "encoder counts per step", STEP_RATIO, encoder=True, loads="step_ratio", bits=15),
    _do("GET_STEP_RATIO", 0x6F, "encoder counts per step", reads=STEP_RATIO, encoder=True, shows="step_ratio"),
    _do("SET_AUTO_STOP_ON", 0x45, "a motion error switches the motor off", encoder=True, sets=("auto_stop", True)),
    _do("SET_AUTO_STOP_OFF", 0x44, "a motion error only sets its flag", encoder=True, sets=("auto_stop", False)),
    _do("SET_POS_ERR", 0x29, "limit of the position error", LIMIT, encoder=True, loads="pos_err", bits=15),
    _do("GET_POS_ERR", 0x55, "limit of the position error", reads=LIMIT, encoder=True, shows="pos_err"),
    _do("GET_ACTL_POS_ERR", 0x60, "position error: actual minus target, in counts", reads=POSITION_ERROR, encoder=True, shows="position_error"),
    # miscellaneous
    _do("SET_ACTL_POS", 0x4D, "set actual and target position; the position error becomes 0", POSITION, role="preset"),
    _do("SET_LMT_SENSE", 0x66, "limit inputs that are active low", SWITCHES, acts="global", loads="limit_sense", bits=8),
    _do("GET_LMT_SWTCH", 0x67, "levels of the limit inputs", reads=SWITCHES, acts="global"),
    _do("LMTS_ON", 0x70, "enable the limit switches", acts="global", sets=("limits_on", True)),
    _do("LMTS_OFF", 0x71, "disable the limit switches", acts="global", sets=("limits_on", False)),
    _do("GET_HOME", 0x05, "levels of the home inputs", reads=HOMES, acts="global"),
    _do("RESET", 0x39, "reset the chipset; no checksum follows", acts="global"),
    _do("GET_VRSN", 0x6C, "version word", reads=VERSION, acts="global"),
    _do("GET_TIME", 0x3E, "cycles since reset", reads=TIME, acts="global"),
)

# ----------------------------------------------------------------------------------------------- codes without a row
ILLEGAL = frozenset({0x00, 0x03, 0x04, 0x22, *range(0x80, 0x100)})  # 03 and 04 only where axes 3 and 4 are missing
RESERVED = frozenset({0x49})

# Codes of sister parts: their words are read, and 0 is returned for them, so that a host keeps in step.  A servo does
# nothing without gains, so every program for one sends some; a stepper part has none, so they show such a program.
SERVO = "the MC1401A, a servo chip"


def _sent(name: str, of: str = "a sister part") -> Sibling:
    return Sibling(name, 1, 0, of)


def _asked(name: str, of: str = "a sister part") -> Sibling:
    return Sibling(name, 0, 1, of)


SIBLINGS = MappingProxyType({
    0x40: Sibling("AXIS_OFF", 0, 0, "a sister part"), 0x41: Sibling("AXIS_ON", 0, 0, "a sister part"),
    0x06: _sent("SET_MTR_LMT"), 0x0F: _sent("SET_MTR_BIAS"), 0x38: _sent("SET_SMPL_TIME"), 0x62: _sent("SET_MTR_CMD"),
    0x07: _asked("GET_MTR_LMT"), 0x2D: _asked("GET_MTR_BIAS"), 0x61: _asked("GET_SMPL_TIME"),
    0x3A: _asked("GET_MTR_CMD"), 0x69: _asked("GET_BUF_MTR_CMD"), 0x6E: _asked("GET_OUTPUT_MODE"),
    0x25: _sent("SET_KP", SERVO), 0x26: _sent("SET_KI", SERVO), 0x27: _sent("SET_KD", SERVO),
    0x28: _sent("SET_I_LM", SERVO), 0x2B: _sent("SET_KVFF", SERVO),
    0x50: _asked("GET_KP", SERVO), 0x51: _asked("GET_KI", SERVO), 0x52: _asked("GET_KD", SERVO),
    0x53: _asked("GET_I_LM", SERVO), 0x54: _asked("GET_KVFF", SERVO), 0x2E: _asked("GET_INTGR", SERVO),
})  # fmt: skip

SLIPS = MappingProxyType({
    "SET_ACCEL": "SET_ACC", "SET_POS_ACTL_BRK": "SET_ACTL_POS_BRK", "SET_NEG_ACTL_BRK": "SET_ACTL_NEG_BRK",
    "CLR_PRFL": "STOP", "GET_I": "GET_INTRPT", "ZERO_POS": "SET_ACTL_POS 0",
})  # fmt: skip

# ------------------------------------------------------------------------------------------------ registers and times
_RT = "command reference, reset"
REGISTERS = (  # named like the commands that write and read them
    Register("pos", 31, 0, "destination position", "SET_POS", _RT, unit="steps"),
    Register("vel", 30, 0, "maximum velocity", "SET_VEL", _RT, unit="1/65536 steps/cycle"),
    Register("acc", 31, 0, "acceleration", "SET_ACC", _RT, unit="1/65536 steps/cycle^2"),
    Register("max_acc", 15, 0, "greatest acceleration of the S-curve", "SET_MAX_ACC", _RT, unit="1/65536 steps/cycle^2"),
    Register("jerk", 31, 0, "jerk", "SET_JERK", _RT, unit="2^-32 steps/cycle^3"),
    Register("ratio", 31, 0, "gear ratio", "SET_RATIO", _RT, unit="1/65536 steps/count"),
    Register("start_vel", 30, 0, "start velocity", "SET_START_VEL", _RT, unit="1/65536 steps/cycle"),
    Register("brk_pnt", 32, 0, "comparison value of breakpoints", "SET_BRK_PNT", _RT, unit="cycles, steps or counts"),
    Register("intrpt_mask", 8, 0, "events that interrupt the host", "SET_INTRPT_MASK", _RT, unit="bits of the events"),
    Register("step_ratio", 15, 0, "encoder counts per step; 0: no stall detection", "SET_STEP_RATIO", _RT, unit="1/256 counts/step"),
    Register("pos_err", 15, 32767, "limit of the position error", "SET_POS_ERR", _RT, unit="counts"),
    Register("trgt_pos", 31, 0, "target position", "SET_ACTL_POS", _RT, unit="steps"),
    Register("trgt_vel", 31, 0, "target velocity", "", _RT, unit="1/65536 steps/cycle"),
    Register("actl_pos", 31, 0, "actual position", "SET_ACTL_POS", _RT, unit="counts"),
    Register("actl_pos_err", 16, 0, "position error", "", _RT, unit="counts"),
    Register("capt", 31, 0, "captured position", "", _RT, unit="counts"),
    Register("status", 16, 0x0300, "status word; axes 2 to 4 have their number in bits 12 and 13", "", _RT, unit="bits"),
    Register("mode", 16, 0, "mode word", "", _RT, unit="bits"),
    Register("time", 32, 0, "cycles since reset", "", _RT, unit="cycles"),
)
MHZ = 25
_AC = "AC electrical characteristics"
TIMES = MappingProxyType({
    "cycle": Timing(CYCLE_TICKS / MHZ, MHZ, "between two calculations of all profiles", "operational parameters"),
    "slice": Timing(SLICE_TICKS / MHZ, MHZ, "HostRdy low after a command or a word: a quarter of a cycle", "pin descriptions, hostrdy", "derived"),
    "reset_cycles": Timing(RESET_CYCLES * CYCLE_TICKS / MHZ, MHZ, "HostRdy low after reset", _RT, "chosen"),
    "reset": Timing(1, MHZ, "shortest RESET", _AC),
    "write": Timing(0.05, MHZ, "shortest HostWrite", _AC),
    "read_access": Timing(0.04, MHZ, "HostRead low to the byte on the bus; at most 50 ns", _AC, "chosen"),
    "read_release": Timing(0.04, MHZ, "HostRead high to a free bus; 10 to 50 ns", _AC, "chosen"),
    "release": Timing(2, MHZ, "longest HostSlct low after the last strobe of a word", _AC),
    "filter": Timing(FILTER_TICKS / MHZ, MHZ, "shortest level of HOME, QUADA and QUADB that is detected", "encoder position feedback"),
    "dwell": Timing(0.8, MHZ, "shortest state of an encoder: 1.25 Mcounts/s", _AC),
    "clkout": Timing(CLKOUT_TICKS / MHZ, MHZ, "period of CLKOUT", _AC),
})
# The clock's own times (t4, t5) and that from stable power to reset have no edge on a pin; the index of t3 has no pin.
NS, US = 1000, 1_000_000  # ps
# A strobe is for the chip that is selected at its end; t7 and t8 of a write are set-up times, hence below zero after it.
_SELECTED = (("hostslct", 0),)
_WRITE, _READ = (("hostwrite", 0), *_SELECTED), (("hostread", 0), *_SELECTED)
LIMITS = (
    Limit("reset falls", "reset rises", "~RESET low", _AC, least=US, keeper="host"),
    Limit("hostwrite rises", "hostslct rises", "~HostSlct hold, write", _AC, least=15 * NS, most=2000 * NS, symbol="t6", keeper="host", before=_SELECTED),
    Limit("hostread rises", "hostslct rises", "~HostSlct hold, read", _AC, least=15 * NS, most=2000 * NS, symbol="t6", keeper="host", before=_SELECTED),
    Limit("hostslct falls", "hostwrite falls", "~HostSlct set-up, write", _AC, least=10 * NS, symbol="t7", keeper="host", given=_SELECTED),
    Limit("hostread falls", "hostslct falls", "~HostSlct after ~HostRead", _AC, most=20 * NS, symbol="t7", keeper="host", given=(("hostread", 0),)),
    Limit("hostwrite falls", "hostslct falls", "~HostSlct after ~HostWrite", _AC, most=-10 * NS, symbol="t7", keeper="host", given=_WRITE),
    Limit("hostcmd changes", "hostwrite falls", "HostCmd set-up, write", _AC, least=10 * NS, symbol="t8", keeper="host", given=_SELECTED),
    Limit("hostread falls", "hostcmd changes", "HostCmd after ~HostRead", _AC, most=20 * NS, symbol="t8", keeper="host", given=_READ),
    Limit("hostwrite falls", "hostcmd changes", "HostCmd after ~HostWrite", _AC, most=-10 * NS, symbol="t8", keeper="host", given=_WRITE),
    Limit("hostwrite rises", "hostcmd changes", "HostCmd hold, write", _AC, least=25 * NS, symbol="t9", keeper="host", before=_SELECTED),
    Limit("hostread rises", "hostcmd changes", "HostCmd hold, read", _AC, least=25 * NS, symbol="t9", keeper="host", before=_SELECTED),
    Limit("hostread falls", "hostdata appears", "read data access", _AC, most=50 * NS, symbol="t10", given=_READ),
    Limit("hostread rises", "hostdata changes", "read data hold", _AC, least=10 * NS, symbol="t11", before=_SELECTED),
    Limit("hostread rises", "hostdata vanishes", "~HostRead high to Hi-Z", _AC, most=50 * NS, symbol="t12", before=_SELECTED),
    Limit("hostwrite rises", "hostrdy falls", "HostRdy delay, write", _AC, most=70 * NS, symbol="t13", before=_SELECTED),
    Limit("hostread rises", "hostrdy falls", "HostRdy delay, read", _AC, most=70 * NS, symbol="t13", before=_SELECTED),
    Limit("hostrdy falls", "hostrdy rises", "busy to ready", "pin descriptions", typical=82_500 * NS, mhz=MHZ),
    Limit("hostwrite falls", "hostwrite rises", "~HostWrite low", _AC, least=50 * NS, symbol="t14", keeper="host", given=_SELECTED),
    Limit("hostdata changes", "hostwrite rises", "write data set-up", _AC, least=35 * NS, symbol="t15", keeper="host", given=_SELECTED),
    Limit("hostwrite rises", "hostdata changes", "write data hold", _AC, least=30 * NS, symbol="t16", keeper="host", before=_SELECTED),
    Limit("hostread rises", "hostread falls", "read recovery", _AC, least=60 * NS, symbol="t17", keeper="host", given=_READ, before=_SELECTED),
    Limit("hostwrite rises", "hostwrite falls", "write recovery", _AC, least=60 * NS, symbol="t18", keeper="host", given=_WRITE, before=_SELECTED),
    *(Limit(f"quad{one}{n} changes", f"quad{one}{n} changes", f"axis {n}: a level of encoder channel {one.upper()}", _AC, least=1600 * NS, symbol="t1", keeper="host") for n in range(1, 5) for one in "ab"),
    *(Limit(f"quad{one}{n} changes", f"quad{two}{n} changes", f"axis {n}: a state of the encoder", _AC, least=800 * NS, symbol="t2", keeper="host") for n in range(1, 5) for one, two in ("ab", "ba")),
    *(Limit(f"home{n} changes", f"home{n} changes", f"axis {n}: ~HOME level long enough to be sampled", "encoder position feedback", least=480 * NS, keeper="host") for n in range(1, 5)),
)
# fmt: on
# fmt: off
OPTIONS = (
    Option("stepwise", "bool", False, "process every cycle instead of only those with a decision; slow, with identical edges"),
    Option("cold", "bool", False, "start without supply; `power(True)` powers up the chipset"),
    Option("busy_ticks", "int", SLICE_TICKS, "time of HostRdy low after a command or a word; a slice by default", low=1, unit="clocks"),
    Option("reset_cycles", "int", RESET_CYCLES, "time of HostRdy low after reset", low=1, unit="cycles"),
)
# fmt: on
POWER_UP_RESET_PS = 250_000_000_000  # 0.25 s of stable power before the end of reset, whatever the clock
NOTES = MappingProxyType(
    {
        "pulse range": "16 pulses per cycle (48.828 kpulses/s), or 512 (1.5625 Mpulses/s) after SET_OUTPUT_HIGH",
        "input levels": "high from 2.0 V (CLKIN 3.0 V, RESET 4.0 V), low up to 0.8 V; -0.3 V to VCC + 0.3 V",
        "output levels": "high at least 2.4 V (CP chip at 0.3 mA, I/O chip at 4 mA), low at most 0.33 V (2 mA, 4 mA)",
        "supply": "4.75 to 5.25 V, 100 mA with open outputs; I/O and CP chip together up to 650 mW",
        "limits": "-0.3 to 7 V supply, 0 to 70 degrees C in operation, -55 to 150 in storage",
    }
)


# -------------------------------------------------------------------------------------------------------- the parts
FAMILY, RELEASE, GENERATION = 4, 0x11, 1  # fields of the version word: 1451 series, 2.1, first generation


def _sheet(axes: int, encoder: bool) -> Sheet:
    part = f"mc1{axes}51a{'-e' if encoder else ''}"
    missing = {f"SET_{n}" for n in range(axes + 1, 5)}
    pins = _pins(axes, encoder)
    rows = Table(*(row for row in ROWS if row.name not in missing))
    return Sheet(
        part=part,
        title=f"{part.upper()} step motor control chipset, {axes} {'axis' if axes == 1 else 'axes'}"
        + (", with encoder inputs" if encoder else ""),
        manual="MC1451A manual, doc. rev. 12.02, November 1997",
        behaviour=2,
        crystal_hz=CRYSTAL_HZ,
        crystal_low_hz=6_700_000,
        crystal_high_hz=25_600_000,
        pins=pins,
        wires=_wired(pins),
        commands=rows,
        registers=REGISTERS,
        options=OPTIONS,
        times=TIMES,
        limits=_limits(pins),
        suffix=f".{part}",
        notes=NOTES,
        dialect=Packets(
            illegal=(ILLEGAL | {2}) - set(rows.by_code),
            reserved=RESERVED,
            siblings=SIBLINGS,
            version=GENERATION << 14 | (axes - 1) << 11 | FAMILY << 8 | RELEASE,
            status=STATUS,
            mode=MODE,
            slips=SLIPS,
            where="command reference",
        ),
        channels=(HostPort(),),
        foreign=tuple(sorted(missing)),
        axes=axes,
    )


MC1151A, MC1251A, MC1451A = (_sheet(axes, encoder=False) for axes in (1, 2, 4))
MC1151A_E, MC1251A_E, MC1451A_E = (_sheet(axes, encoder=True) for axes in (1, 2, 4))
