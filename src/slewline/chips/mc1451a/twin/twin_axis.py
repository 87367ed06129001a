"""One axis of the slow twin; its methods follow the order in which `cycle` calls them.

    T_n               T_n+1             T_n+2
     |<-- 8192 clocks->|                 |
    _|_________________|_________________|_      target: x at T_n; the `velocity` chosen at T_n is
     x                 x + velocity              its movement until T_n+1, spread evenly over the cycle

PULSE follows the target: it rises when the target is half a step past the last step made, and falls when
the target is a whole step past it; the falling edge is the next step.  `lead` is the distance from the
steps made so far to the target.
"""

from __future__ import annotations

from collections.abc import Callable

from ....core.context import ChipContext
from ....core.motion.train import Playing
from ....core.wires.net import Wave
from .. import sheet
from ..profiles.ideal import begins, mark_deviation
from ..registers import (
    BREAKPOINT,
    COMMAND_ERROR,
    GEAR,
    MOTION_COMPLETE,
    MOTION_ERROR,
    ONE,
    PROFILE_COMMANDS,
    S_CURVE,
    TRAPEZOIDAL,
    VELOCITY,
    WRAPPED,
    AxisState,
    Profile,
    Registers,
)  # fmt: skip
from .cycle import OneCycle
from .twin_inputs import LIMITS, Switches, TwinEncoder, TwinFilter
from .twin_profile import TwinSCurve, braked, contour, sign, trapezoid

REPORTED = range(-32768, 32768)  # position errors


def signed(number: int, bits: int) -> int:
    """Return a number wrapped into the range of `bits`-bit two's complement."""
    half = 1 << (bits - 1)
    return (number + half) % (2 * half) - half


class TwinAxis:
    """One axis, cycle by cycle."""

    def __init__(
        self, chip: ChipContext, registers: Registers, state: AxisState, home: TwinFilter, encoder: TwinEncoder | None
    ) -> None:
        self.chip, self.state = chip, state
        self.home, self.encoder, self.switches = home, encoder, Switches(chip, registers, state)
        self.axis = self.chip.axes[state.number - 1]
        # the settings read by the last cycle, and their changes since
        self.mode, self.high_speed = state.mode, state.high_speed
        self.was_off = False
        # the motion
        self.landing = self.stopping = self.clamped = False
        self.why: set[str] = set()  # registers of value 0 for which a missing start was reported
        self.start = 0  # the active start velocity
        self.displacement = 0  # of this cycle: the velocity without the rounding of an S-curve
        self.curve: TwinSCurve | None = None
        # electronic gear
        self.suspended = self.backlogged = False
        self.count = self.counts_used = 0  # encoder counts since reset
        self.owed = 0  # of the gear: remaining displacement
        # pulses
        self.lead = 0  # distance of the target ahead of the steps made
        self.pulse, self.direction = 0, 1  # the levels that have been output or promised
        self.steps: list[int] = []  # ticks of this cycle's steps
        self.playing: Playing | None = None
        self.deferred: list[Callable[[], object]] = []  # work for the axis
        self.declared: int | None = None  # position to load
        # position error, in 1/256 count, and whole steps of the target not yet included
        self.error = self.gone = 0

    def cycle(self, number: int, tick: int) -> None:
        """Make all decisions for cycle `number`, which begins at `tick`."""
        self.arrive()
        self.see_settings()
        if self.state.update is not None:
            self.update(tick, self.state.update)
        self.look_at_limits()
        self.choose_velocity()
        self.make_pulses(tick)
        self.compare_positions(tick)
        self.test_breakpoint(number, tick)
        self.show()

    def event(self, bit: int) -> None:
        """Set an event in the status word; in gear mode there is no motion complete event."""
        if bit != MOTION_COMPLETE or self.mode != GEAR:
            self.state.events |= bit

    def defer(self, what: Callable[[], object]) -> None:
        """Call a function later within this instant, after any step due at this instant has been counted."""
        if not self.deferred:
            self.chip.kernel.call_at(self.chip.kernel.now, self.apply_deferred)
        self.deferred.append(what)

    def apply_deferred(self) -> None:
        """Call the deferred functions, in order."""
        deferred, self.deferred = self.deferred, []
        for what in deferred:
            what()

    def finding(self, code: str, text: str) -> None:
        """Record a mistake that the host has made with this axis."""
        self.chip.finding(code, f"axis {self.state.number}: {text}")

    # ------------------------------------------------------------------------------------------------------ 0: arrive
    def arrive(self) -> None:
        """Add the last cycle's displacement to the target; if this completes the motion, end the motion."""
        state = self.state
        self.lead += self.displacement - self.direction * ONE * len(self.steps)
        self.steps = []
        target = state.target + self.displacement
        self.gone += (target >> 16) - (state.target >> 16)
        state.target = signed(target, 47)
        if state.target != target:
            self.event(WRAPPED)
        if self.landing:
            self.rest(complete=True)

    def rest(self, complete: bool) -> None:
        """End the motion; if it is `complete`, set the motion complete event."""
        self.axis.log.end()
        state = self.state
        self.displacement = state.velocity = state.phase = 0
        state.in_motion = self.landing = self.stopping = False
        if complete:
            self.event(MOTION_COMPLETE)

    # ----------------------------------------------------------------------------------------------------- 1: updates
    def see_settings(self) -> None:
        """Apply the settings that need no update: the motor, the pulse range, the profile mode."""
        state = self.state
        if self.was_off or not state.motor_on:
            if state.in_motion:
                mark_deviation(self.chip, state, "event", "motor off")
            self.axis.log.end("cut")
            self.rest(complete=False)
            self.suspended = True
        self.was_off = False
        if state.high_speed != self.high_speed:
            self.high_speed = state.high_speed
            self.clamped = False
        if state.mode != self.mode:
            self.change_mode()

    def change_mode(self) -> None:
        """Change the profile mode.

        Any change ends a motion, except a change to velocity contouring from a mode other than gear mode.  In
        gear mode the axis follows the encoder from the encoder's present count.
        """
        state = self.state
        if state.in_motion:
            mark_deviation(self.chip, state, "command", PROFILE_COMMANDS[state.mode])
        if state.mode != VELOCITY or self.mode == GEAR:
            self.axis.log.stop()
        if self.mode == GEAR or state.mode == GEAR:
            self.rest(complete=False)
            self.counts_used, self.owed = self.count, 0
            self.suspended = state.awaits_update or self.switches.flagged
            if state.mode == GEAR:
                self.gear_begins(PROFILE_COMMANDS[GEAR])
        elif state.in_motion and state.mode != VELOCITY:
            self.rest(complete=True)
            self.finding("mode-in-motion", "profile mode changed in motion: the axis stops immediately")
        self.mode = state.mode
        state.phase = 0

    def update(self, tick: int, taken: Profile) -> None:
        """Apply the values that an update has taken from the buffer."""
        state = self.state
        if taken.synch_prfl and self.encoder is not None:
            self.read_encoder(self.encoder, tick)
            mark_deviation(self.chip, state, "command", "SYNCH_PRFL")
            self.relocate(state.actual)
        self.copy_registers(taken)
        state.update = None
        self.stopping = self.clamped = False
        if taken.stop:
            if state.in_motion or state.mode == GEAR:
                mark_deviation(self.chip, state, "command", "STOP")
                self.axis.log.stop()
            self.rest(complete=True)
            self.suspended = True
        elif state.mode == GEAR:
            self.engage()
            self.gear_begins(taken.cause)
            if state.active.ratio == 0 and "ratio" not in state.written and not state.awaits_update:
                self.does_not_start({"ratio"})
        elif taken.smooth_stop:
            self.stop_smoothly()
        elif state.in_motion:
            if not state.awaits_update and state.mode != S_CURVE:
                begins(self.chip, state, taken.cause, self.start, self.pulse_range())
        elif not state.awaits_update:
            self.set_out(taken.cause)

    def relocate(self, position: int) -> None:
        """Set the target to a position, without pulses and without a position error."""
        self.state.target, self.lead = position * ONE, 0
        self.error = self.gone = self.state.error = 0
        self.state.motion_error = False
        now = self.chip.kernel.now
        made = sum(self.chip.clock.ps(step) <= now for step in self.steps)  # of this cycle, which began at `position`
        self.declared = position + self.direction * made
        self.defer(self.load)

    def load(self) -> None:
        """Load the position declared by `relocate`, if any, into the axis."""
        if self.declared is not None:
            self.axis.load(self.declared)
            self.declared = None

    def copy_registers(self, new: Profile) -> None:
        """Activate the new registers, except registers that are fixed during a motion.

        An attempt to change a fixed register is a command error; then only the new destination becomes active.
        """
        active = self.state.active
        fixed: tuple[str, ...] = ()
        if self.state.in_motion:
            fixed = {TRAPEZOIDAL: ("acceleration",), S_CURVE: ("velocity", "max_acceleration", "jerk")}.get(
                self.mode, ()
            )
        active.position = new.position
        if any(name in new.loaded and getattr(new, name) != getattr(active, name) for name in fixed):
            self.event(COMMAND_ERROR)
            self.finding("command-error", "an update changes a parameter that must not change in motion")
            return
        for name in ("velocity", "acceleration", "max_acceleration", "jerk", "ratio"):
            if name not in fixed:
                setattr(active, name, getattr(new, name))

    def gear_begins(self, cause: str) -> None:
        """Record that a motion with the gear begins and, if the gear is suspended, that it ends immediately."""
        begins(self.chip, self.state, cause, 0, self.pulse_range())
        if self.suspended:
            self.axis.log.end("limit" if self.switches.flagged else "cut")

    def engage(self) -> None:
        """Resume a suspended gear from the present encoder count, if the motor and the limit switches allow it."""
        if self.suspended and not self.state.awaits_update and not self.switches.flagged:
            self.suspended = False
            self.counts_used = self.count

    def stop_smoothly(self) -> None:
        """Decelerate; the stop is complete when the axis is at rest."""
        if not self.state.in_motion:
            self.rest(complete=True)
            return
        mark_deviation(self.chip, self.state, "command", "SMOOTH_STOP")
        self.axis.log.stop()
        if self.mode == S_CURVE and self.curve is not None:
            self.curve.smooth_stop()
        else:
            self.stopping = True

    def set_out(self, cause: str) -> None:
        """Start a motion from rest, unless there is none to make or a limit switch prevents it."""
        state, active = self.state, self.state.active
        velocity = self.greatest_velocity()
        distance = active.position * ONE - state.target
        if self.mode == VELOCITY:
            distance = active.acceleration
        needed = ("velocity", "max_acceleration", "jerk") if self.mode == S_CURVE else ("velocity", "acceleration")
        zero = {register for register in needed if getattr(active, register) == 0}
        if self.mode == TRAPEZOIDAL and state.start_velocity:
            zero.discard("acceleration")
        if velocity == 0 or (distance == 0 and self.mode != VELOCITY):
            if distance != 0 and "velocity" not in state.written:
                self.does_not_start(zero)
            self.rest(complete=True)
        elif zero:
            self.does_not_start(zero)
        elif self.switches.flagged or self.switches.active(sign(distance)):
            if self.mode == VELOCITY:
                self.finding("no-start", "a move into a limit switch")
            else:
                self.event(COMMAND_ERROR)
                self.finding("command-error", "a move into a limit switch")
        else:
            state.in_motion, self.why = True, set()
            self.start = state.start_velocity
            begins(self.chip, state, cause, self.start, self.pulse_range())
            if self.mode == S_CURVE:
                self.clamp()
                self.curve = TwinSCurve(distance, velocity, active.max_acceleration, active.jerk)
            elif self.start >= active.velocity:
                self.finding("start-velocity", "the start velocity is not below the maximum: no ramps")

    def does_not_start(self, zero: set[str]) -> None:
        """Report that no motion starts because the registers `zero` are 0, unless the last report was the same."""
        if zero != self.why:
            self.finding("no-start", f"no motion starts while {', '.join(sorted(zero))} is 0")
        self.why = zero

    def greatest_velocity(self) -> int:
        """Return the maximum velocity, limited by the pulse range."""
        return min(self.state.active.velocity, self.pulse_range())

    def pulse_range(self) -> int:
        """Return the maximum displacement in a cycle, in 1/65536 step."""
        return ONE * (sheet.HIGH_RANGE if self.high_speed else sheet.STANDARD_RANGE)

    def clamp(self) -> None:
        """Report a maximum velocity above the pulse range, once per update."""
        if self.state.active.velocity > self.pulse_range() and not self.clamped:
            self.finding("clamped", "the velocity is above the pulse range")
            self.clamped = True

    # ------------------------------------------------------------------------------------------------------ 2: limits
    def look_at_limits(self) -> None:
        """Stop the axis if a limit switch becomes active."""
        for direction in self.switches.tripped():
            self.event(LIMITS[direction])
            mark_deviation(self.chip, self.state, "limit", "PosLimit" if direction > 0 else "NegLimit")
            self.axis.log.end("limit")
            self.rest(complete=True)
            self.suspended = True

    # -------------------------------------------------------------------------------------------------- 3: trajectory
    def choose_velocity(self) -> None:
        """Choose the displacement of this cycle, from its start to the start of the next cycle."""
        state = self.state
        if self.mode == GEAR:
            state.velocity = self.geared()
        elif not state.in_motion:
            state.velocity = 0
        elif self.mode == S_CURVE and self.curve is not None:
            self.displacement, state.velocity, state.phase = self.curve.step()
            self.landing = self.curve.over
            return
        else:
            self.clamp()
            state.velocity = self.trapezoidal() if self.mode == TRAPEZOIDAL else self.contoured()
        self.displacement = state.velocity

    def trapezoidal(self) -> int:
        """Return the velocity of this cycle on the way to the destination."""
        state = self.state
        most, acceleration = self.greatest_velocity(), abs(state.active.acceleration)
        distance = state.active.position * ONE - state.target
        direction = sign(state.velocity or distance)
        speed = abs(state.velocity)
        if self.stopping or most == 0 or speed == distance == 0:
            return direction * self.ended(braked(speed, acceleration, self.start))
        speed, self.landing = trapezoid(speed, direction * distance, most, acceleration, min(self.start, most))
        return direction * speed

    def contoured(self) -> int:
        """Return the velocity of this cycle on the way to the maximum, in the direction of the acceleration."""
        state = self.state
        most, acceleration = self.greatest_velocity(), abs(state.active.acceleration)
        direction, wanted = sign(state.velocity or state.active.acceleration), sign(state.active.acceleration)
        speed = abs(state.velocity)
        if self.stopping or most == 0:
            return direction * self.ended(braked(speed, acceleration, self.start))
        if acceleration and direction != wanted:
            return direction * braked(speed, acceleration, self.start)
        return direction * contour(speed, most, acceleration, min(self.start, most))

    def ended(self, speed: int) -> int:
        """Return `speed`; if it is 0, complete the motion."""
        if speed == 0:
            self.rest(complete=True)
        return speed

    def geared(self) -> int:
        """Return the velocity of the gear, limited by the pulse range.

        Before this limit, it is the encoder movement since the last cycle times the ratio, plus the movement
        owed from earlier cycles.
        """
        active = self.state.active
        moved, self.counts_used = self.count - self.counts_used, self.count
        self.owed += moved * active.ratio
        if self.suspended or (self.owed and self.switches.active(sign(self.owed))):
            self.owed = 0
        most = self.pulse_range()
        velocity = max(-most, min(self.owed, most))
        self.owed -= velocity
        if self.owed and not self.backlogged:
            self.finding("gear-backlog", "the encoder is faster than the pulse range; the remaining steps follow later")
        self.backlogged = self.owed != 0
        return velocity

    # ------------------------------------------------------------------------------------------------------ 4: pulses
    def make_pulses(self, tick: int) -> None:
        """Promise the edges of PULSE in this cycle: PULSE changes at every half step of the target."""
        velocity, drivers, number = self.displacement, self.chip.drivers, self.state.number
        self.steps = []
        curve = self.curve if self.mode == S_CURVE and self.state.in_motion else None
        if velocity == 0 and curve is None:
            return
        heading = sign(velocity if curve is None else curve.distance)  # a curve begins slower than the minimum velocity
        if heading != self.direction:
            self.direction = heading
            self.defer(lambda: drivers[f"dir{number}"].drive(1 if heading > 0 else 0))
        before, edges = self.pulse, []
        half = 1  # in half steps from the last step made
        while (distance := half * ONE // 2 - heading * self.lead) <= abs(velocity):
            level = half % 2
            at = tick + max(-(-distance * sheet.CYCLE_TICKS // (abs(velocity) or 1)), 0)
            if level != self.pulse:
                edges.append((at, level))
                self.pulse = level
            if level == 0:
                self.steps.append(at)
            half += 1
        if edges:
            times = tuple(self.chip.clock.ps(at) for at, _ in edges)
            drivers[f"pulse{number}"].play(Wave(before, times, tuple(level for _, level in edges)))
        self.defer(lambda: self.follow(tick, heading, abs(velocity)))

    def follow(self, tick: int, direction: int, displaced: int) -> None:
        """Make the position of the axis follow the steps of this cycle."""
        self.playing = Playing(OneCycle(self.chip.clock, tick, self.steps, displaced))
        self.axis.follow(self.playing, direction)

    # --------------------------------------------------------------------------------------------- 5: actual position
    def compare_positions(self, tick: int) -> None:
        """Read the encoder, and compare the actual position with the target."""
        state = self.state
        if self.encoder is None:
            return
        self.read_encoder(self.encoder, tick)
        self.error -= state.step_ratio * self.gone
        self.gone = 0
        state.error = self.error >> 8
        reported = max(REPORTED[0], min(state.error, REPORTED[-1]))
        was_wrong, state.motion_error = state.motion_error, state.step_ratio != 0 and abs(reported) > state.pos_err
        if state.motion_error:
            self.event(MOTION_ERROR)
            state.reported &= was_wrong
            if not was_wrong:
                self.axis.log.mark("event", "motion error")
                self.finding("motion-error", "the position error is beyond its limit")
            if state.auto_stop and not was_wrong:
                state.switch_off()
                self.was_off = True

    def read_encoder(self, encoder: TwinEncoder, tick: int) -> None:
        """Count the encoder's edges since the last call, up to but excluding a tick."""
        moved = encoder.counts(tick)
        self.count += moved
        self.state.actual = signed(self.state.actual + moved, 31)
        self.error += 256 * moved

    # -------------------------------------------------------------------------------------------------- 6: breakpoint
    def test_breakpoint(self, number: int, tick: int) -> None:
        """Clear a breakpoint whose condition is met; if auto-update is on, request an update in the next cycle."""
        state = self.state
        value = signed(state.comparison, 32)
        self.home.look(tick)
        met = {
            "": False,
            "time": number % (1 << 32) == state.comparison,
            "pos": state.target >> 16 >= value,
            "neg": state.target >> 16 <= value,
            "actl_pos": state.actual >= value,
            "actl_neg": state.actual <= value,
            "mtn_cmplt": bool(state.events & MOTION_COMPLETE),
            "ext": self.home.level == 0,
        }
        if met[state.breakpoint]:
            command, state.breakpoint = state.breakpoint_command, ""
            self.axis.log.mark("event", f"{command} met")
            self.event(BREAKPOINT)
            if state.auto_update:
                state.take(command)

    # ------------------------------------------------------------------------------------------------------- 7: show
    def show(self) -> None:
        """Drive AtRest; in gear mode AtRest is low in every cycle with steps."""
        rest = not self.steps if self.mode == GEAR else not self.state.in_motion
        self.chip.drivers[f"atrest{self.state.number}"].drive(int(rest))

    def cut(self) -> None:
        """Output no step after this instant; a position declared at this instant still takes effect."""
        self.deferred.clear()
        self.load()
        if self.playing is not None:
            self.playing.until = self.chip.kernel.now + 1
