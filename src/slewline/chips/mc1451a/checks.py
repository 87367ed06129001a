"""Lint rules that apply to the MC1451A family only: an axis's registers at an update.

A script is followed as the chipset would receive it, packet by packet.  Until the script
has written a register, or RESET has set it, its value is unknown (None), and no rule applies to it.  Three
things are assumed to have their power-up state until the script changes them: the pulse range is the
standard one; an axis is at position 0; and, in a script that sets destination and velocity, the
acceleration is 0.  Problems of an axis in motion are only reported where the motion is certain: the
minimum duration of a move is known, and so is the time for which the script waits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import inf, sqrt

from ...core.datasheet.command_rows import PacketRow
from ...core.datasheet.table import Sheet
from ...core.time.timebase import PS_PER_S, picoseconds
from ...errors import SlewlineError
from ...language.lint import Check
from ...language.problems import Severity
from ...language.rates import cycles_per_s
from ...language.statements import Directive, Source, Statement
from .omissions import IN_MOTION, NEXT_START, REMEDY, REST, STARTING, codes, forgotten, missing, servo
from .registers import PROFILE_COMMANDS, S_CURVE, TRAPEZOIDAL, VELOCITY
from .sheet import HIGH_RANGE, ROWS, STANDARD_RANGE

USES = {  # profile mode: its name, and the values that it uses
    "SET_PRFL_TRAP": ("trapezoidal", ("SET_POS", "SET_VEL", "SET_ACC", "SMOOTH_STOP")),
    "SET_PRFL_VEL": ("velocity contouring", ("SET_VEL", "SET_ACC", "SMOOTH_STOP")),
    "SET_PRFL_S_CRV": ("S-curve", ("SET_POS", "SET_VEL", "SET_MAX_ACC", "SET_JERK", "SMOOTH_STOP")),
    "SET_PRFL_GEAR": ("electronic gear", ("SET_RATIO",)),
}
ALWAYS = ("STOP", "SYNCH_PRFL")
COMPARING = ("SET_TIME_BRK", "SET_POS_BRK", "SET_NEG_BRK", "SET_ACTL_POS_BRK", "SET_ACTL_NEG_BRK")
ARMING = {row.name for row in ROWS if row.sets and row.sets[0] == "breakpoint" and row.sets[1]}
SCALE = 1 << 16
PASSING = ("drive", "release", "pulse", "note", "expect")  # directives without duration
USED = ("SET_VEL", "SET_START_VEL", "SET_ACC", "SET_MAX_ACC", "SET_JERK")
WAIT = "add wait motion_complete before it"


@dataclass(frozen=True)
class KnownMove:
    """A move in progress.

    Attributes:
        begun: the last of the commands that took effect at the update with which the move began.
        left_s: the minimum time that the move still takes, seconds.
        used: the values with which the move began, by command; None for an unknown value.
    """

    begun: Statement
    left_s: float
    used: Mapping[str, int | None]

    def changes(self, name: str, pending: Mapping[str, Statement]) -> bool:
        """Return whether the pending command `name` would change the value with which the move began."""
        return name in pending and self.used[name] is not None and pending[name].values[0] != self.used[name]

    def after(self, seconds: float) -> KnownMove | None:
        """Return the rest of the move after a number of seconds; None if the move may be over by then."""
        return replace(self, left_s=self.left_s - seconds) if self.left_s > seconds else None


def waited_s(directive: Directive) -> float:
    """Return how long (s) a directive makes the host wait; infinite if unknown, as when it waits for an event."""
    if directive.verb != "wait":
        return inf
    try:
        return picoseconds(directive.text.removeprefix("@").removeprefix("wait").strip()) / PS_PER_S
    except SlewlineError:  # a bit of the status word
        return inf


def least_s(sheet: Sheet, mode: int, end: int | None, at: int, used: Mapping[str, int | None]) -> float:
    """Return the minimum duration of a move in seconds; 0 if there is no move, or if the duration is not known.

    Args:
        mode: the profile mode; in velocity contouring the duration is infinite.
        end: the destination of the move; None if unknown.
        at: the position at which the move starts.
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
        cycles = distance / velocity  # only the ramps may be missing
    elif distance > velocity * velocity / acceleration:
        cycles = distance / velocity + velocity / acceleration
    else:
        cycles = 2 * sqrt(distance / acceleration)
    return cycles / float(cycles_per_s(sheet))


@dataclass
class KnownAxis:
    """The state of an axis, as far as the text determines it; statements are stored by command name."""

    written: dict[str, Statement] = field(default_factory=dict)  # the last values
    pending: dict[str, Statement] = field(default_factory=dict)  # commands that wait for an update
    known: bool = True  # False if the number of the axis is not known
    is_reset: bool = False  # parameters that were never written are 0
    mode: str = ""
    high_speed: bool = False
    armed: bool = False
    auto_update: bool = True
    move: KnownMove | None = None  # the move that is certainly in progress
    at: int | None = 0  # position, or destination

    def value(self, name: str) -> int | None:
        """Return the value last written by the command `name`; if none, return 0 after RESET, else None (unknown)."""
        if name in self.written:
            return self.written[name].values[0]
        return 0 if self.is_reset else None

    @property
    def profile(self) -> int:
        """The number of the profile mode; as long as the mode is unknown, that of the power-up mode."""
        return PROFILE_COMMANDS.index(self.mode or "SET_PRFL_TRAP")


class KnownChipset:
    """The state of the chipset in the course of a script, as far as it is known."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.rows = source.sheet.rows(PacketRow)
        self.axes = [KnownAxis() for _ in range(source.sheet.axes)]
        self.current = self.axes[0]
        self.begun = b""  # start of a packet whose bytes are on several lines
        self.is_for_servo = False  # True once it was reported

    def warn(self, statement: Statement, code: str, found: str, remedy: str = "", note: bool = False) -> None:
        """Report a problem in a statement, as a warning or, if `note`, as a note."""
        severity: Severity = "note" if note else "warning"
        self.source.report(statement, code, severity, found, section=statement.row.where, remedy=remedy)

    def take(self, statement: Statement) -> None:
        """Process one packet."""
        row, name, axis = self.rows[statement.row.form], statement.row.name, self.current
        self.begun = b""
        if row.encoder and not self.source.sheet.encoder:
            self.warn(
                statement,
                "no-encoder",
                f"{name} needs an encoder: this part accepts the command, but ignores it",
                note=True,
            )
        if row.acts == "set":
            self.current = self.axes[row.code - 1]
        elif name == "SET_I":
            self.current = KnownAxis(known=False)  # its number is not known
        elif name == "RESET":
            self.axes = [KnownAxis(is_reset=True, mode="SET_PRFL_TRAP") for _ in self.axes]
            self.current = self.axes[0]
        elif name == "MULTI_UPDATE":
            self.multi_update(statement)
        elif name == "UPDATE":
            self.update(axis)
        else:
            self.set(statement, axis)

    def set(self, statement: Statement, axis: KnownAxis) -> None:
        """Record the parameter, mode or breakpoint that a statement sets on an axis."""
        name = statement.row.name
        self.in_motion(statement, axis)
        if name in COMPARING and axis.value("SET_BRK_PNT") is None:
            found = f"{name} comes before SET_BRK_PNT: it compares with the previous value"
            self.warn(statement, "breakpoint-value", found, "write the value first")
        axis.written[name] = statement
        if self.rows[statement.row.form].buffered:
            axis.pending[name] = statement
        if name in USES:
            axis.mode = name
        axis.high_speed = name == "SET_OUTPUT_HIGH" or (axis.high_speed and name != "SET_OUTPUT_STNDRD")
        axis.armed = name in ARMING or (axis.armed and name != "SET_BRK_OFF")
        axis.auto_update = name == "SET_AUTO_UPDATE_ON" or (axis.auto_update and name != "SET_AUTO_UPDATE_OFF")

    def multi_update(self, statement: Statement) -> None:
        """Follow an update of the axes whose bits in the mask are set; report bits of axes that do not exist."""
        mask = statement.values[0]
        for number, axis in enumerate(self.axes):
            if mask >> number & 1:
                self.update(axis)
        if mask >> len(self.axes):
            axes = len(self.axes)
            found = f"the mask has bits for axes above {axes}, which this part does not have"
            self.warn(statement, "absent-axis", found, f"use 0..{(1 << axes) - 1}", note=True)

    # ------------------------------------------------------------------------------------------------------- updates
    def update(self, axis: KnownAxis) -> None:
        """Apply the pending values of an axis, and check that they fit together."""
        self.velocities(axis)
        mode, uses = USES.get(axis.mode, ("", ()))
        for name, statement in axis.pending.items():
            if mode and name not in (*uses, *ALWAYS):
                found = f"{statement.text} has no effect in {mode} mode"
                self.warn(statement, "unused-parameter", found, f"{mode} mode uses {', '.join(uses)}")
        self.accelerations(axis)
        self.move(axis)
        axis.pending.clear()

    def in_motion(self, statement: Statement, axis: KnownAxis) -> None:
        """Report a command that is not allowed while the axis moves, and record its effect on the motion."""
        name, before = statement.row.name, axis.written.get("SET_START_VEL")
        if name == "SET_ACTL_POS":
            axis.at = statement.values[0]
        if name in ARMING or name in ("MTR_OFF", "SYNCH_PRFL"):
            axis.move = axis.at = None  # the effect and the position of the breakpoint are not known
        if axis.move is None:
            return
        since = f"the move that line {axis.move.begun.line} begins is in progress"
        new_start = name == "SET_START_VEL" and statement.values != (before.values if before else (0,))
        if new_start and axis.profile in STARTING:
            self.warn(statement, "start-velocity", f"{NEXT_START.partition(';')[0]}; {since}", WAIT)
        elif name in ("SET_PRFL_TRAP", "SET_PRFL_S_CRV") and PROFILE_COMMANDS.index(name) != axis.profile:
            self.warn(statement, "mode-in-motion", f"{name} in motion stops the axis dead; {since}", WAIT)
            axis.move = axis.at = None

    def move(self, axis: KnownAxis) -> None:
        """Record the move that an update begins, changes or ends; report changes that are refused in motion."""
        pending, move = axis.pending, axis.move
        if pending.keys() & {"STOP", "SMOOTH_STOP", "SYNCH_PRFL"} or axis.mode == "SET_PRFL_GEAR" or not axis.known:
            axis.move = axis.at = None
            return
        if move is not None:
            changed = [name for name in REST.get(axis.profile, ("", ()))[1] if move.changes(name, pending)]
            if changed:
                since = f"the move that line {move.begun.line} begins is in progress"
                found = f"{IN_MOTION[axis.profile].partition(';')[0]}; {since}"
                self.warn(pending[changed[0]], "command-error", found, WAIT)
            if "SET_POS" in pending or "SET_VEL" in pending:
                axis.move = axis.at = None  # its new duration is not known
            return
        end = axis.value("SET_POS")
        used = {name: axis.value(name) for name in USED}
        if pending and axis.at is not None:
            seconds = least_s(self.source.sheet, axis.profile, end, axis.at, used)
            axis.move = KnownMove(list(pending.values())[-1], seconds, used) if seconds else None
        axis.at = end if axis.profile in REST else None

    def sent(self, directive: Directive) -> None:
        """Report host bytes that are meant for a servo chip."""
        try:
            self.begun += bytes.fromhex(directive.text.partition("bytes")[2])
        except ValueError:
            return  # another rule reports it
        packets = list(codes(self.source.sheet, self.begun))
        shown = next((text for code, _ in packets if (text := servo(self.source.sheet, code))), "")
        if shown and not self.is_for_servo:
            self.is_for_servo = True
            self.source.report(directive, "servo-command", "warning", shown, section="command reference", remedy=REMEDY)
        ends = [0, *(end for _, end in packets if end <= len(self.begun))]
        self.begun = self.begun[ends[-1] :]

    def direct(self, directive: Directive) -> None:
        """Follow a directive to the host: bytes sent, time passed, or a wait for an event."""
        if directive.verb == "bytes":
            self.sent(directive)
        seconds = waited_s(directive)
        for axis in self.axes:
            if axis.move is not None and directive.verb not in PASSING:
                axis.move = axis.move.after(seconds)

    def velocities(self, axis: KnownAxis) -> None:
        """Check the maximum velocity against the pulse range, and the start velocity against the maximum velocity."""
        velocity, start = axis.value("SET_VEL"), axis.value("SET_START_VEL")
        if not velocity or axis.mode == "SET_PRFL_GEAR":
            return
        most = HIGH_RANGE if axis.high_speed else STANDARD_RANGE
        if velocity > most * SCALE:
            found = (
                f"{velocity / SCALE:.6g} steps/cycle exceeds the pulse range: the axis will run at {most} steps/cycle"
            )
            remedy = "" if axis.high_speed else f"SET_OUTPUT_HIGH allows {HIGH_RANGE} steps/cycle"
            self.warn(axis.written["SET_VEL"], "pulse-range", found, remedy)
        if start is not None and start >= velocity and axis.mode != "SET_PRFL_S_CRV":
            found = f"start velocity {start} is not below velocity {velocity}: the whole move is made at {velocity}"
            self.warn(axis.written["SET_START_VEL"], "no-ramp", f"{found}, without ramps")

    def starts(self, axis: KnownAxis) -> None:
        """Report an update that cannot start the axis, because commands are missing before it."""
        mode = axis.profile
        absent = missing(mode, axis.value, axis.written, bool(axis.value("SET_START_VEL")))
        wanted = axis.value("SET_POS") if mode in (TRAPEZOIDAL, S_CURVE) else axis.pending
        if absent and wanted and axis.pending and not axis.pending.keys() & {"STOP", "SMOOTH_STOP"}:
            last = list(axis.pending.values())[-1]
            found = f"{last.text} is updated without {' and '.join(absent)}: the move does not start"
            self.warn(
                last, "no-start", found, f"set {' and '.join(absent)} before the update: after RESET the value is 0"
            )

    def accelerations(self, axis: KnownAxis) -> None:
        """Report an update that cannot start the axis, and an acceleration whose sign has no effect."""
        if axis.known:
            self.starts(axis)
        acceleration = axis.value("SET_ACC") or 0
        if axis.mode == "SET_PRFL_TRAP" and acceleration < 0:
            found = f"acceleration {acceleration}: its sign has an effect in velocity contouring only"
            self.warn(axis.written["SET_ACC"], "acceleration-sign", found, note=True)

    def end(self) -> None:
        """Report commands that still wait for an update at the end of the script, and an auto stop without effect."""
        for axis in self.axes:
            if pending := forgotten(axis.pending, axis.armed, axis.auto_update):
                last = axis.pending[pending[-1]]
                found = f"{last.text} has no effect until an update, but no update follows in the script"
                self.warn(last, "no-update", found, "add UPDATE, MULTI_UPDATE or a breakpoint")
            auto_stop = axis.written.get("SET_AUTO_STOP_ON")
            if auto_stop is not None and self.source.sheet.encoder and not axis.value("SET_STEP_RATIO"):
                found = "auto stop without SET_STEP_RATIO: while the ratio is 0 no stall is detected"
                self.warn(auto_stop, "no-step-ratio", found, note=True)


def script(source: Source) -> None:
    """Check every packet and host directive of a script in turn."""
    chipset, returned = KnownChipset(source), False
    for item in source.items:
        if isinstance(item, Statement):
            chipset.take(item)
            returned = returned or bool(chipset.rows[item.row.form].reads)
            continue
        chipset.direct(item)
        if item.verb == "expect" and not returned:
            found, remedy = "no command above returns a value", "such as GET_STATUS"
            remedy = f"add such a command above this line, {remedy}"
            source.report(item, "nothing-returned", "error", found, remedy=remedy)
    chipset.end()


def checks(sheet: Sheet) -> tuple[Check, ...]:
    """Return the lint rules of the MC1451A family for `language.lint.lint`; `sheet` names the part."""
    return (script,)
