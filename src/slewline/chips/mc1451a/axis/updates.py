"""The host's commands to an axis: immediate settings, updates, stops."""

from __future__ import annotations

from ....core.context import ChipContext
from ..omissions import AT_LIMIT, IN_MOTION, REGISTERS, REST, missing_of
from ..profiles.ideal import begins, mark_deviation
from ..registers import (
    COMMAND_ERROR,
    GEAR,
    MOTION_COMPLETE,
    NEGATIVE_LIMIT,
    ONE,
    POSITIVE_LIMIT,
    PROFILE_COMMANDS,
    S_CURVE,
    TRAPEZOIDAL,
    VELOCITY,
    AxisState,
    Profile,
)
from .feedback import Feedback
from .gear import ElectronicGear
from .generator import ProfileGenerator
from .switches import LimitSwitches

FIXED = {mode: tuple(REGISTERS[name] for name in names) for mode, (_, names) in REST.items()}  # while in motion


class Updates:
    """The part of an axis that applies the values written by commands, and begins and ends motions."""

    def __init__(
        self,
        chip: ChipContext,
        state: AxisState,
        generator: ProfileGenerator,
        feedback: Feedback,
        switches: LimitSwitches,
        gear: ElectronicGear,
    ) -> None:
        self.chip, self.state, self.generator, self.pulses = chip, state, generator, generator.pulses
        self.feedback, self.switches, self.gear, self.log = feedback, switches, gear, generator.log

    def begin(self) -> None:
        """Handle a reset: forget which unset registers have been reported (see `omit`)."""
        self.omitted: list[str] = []  # registers named in the finding, without which the axis does not start

    def settings(self, n: int) -> None:
        """Apply the settings that need no update: profile mode, motor on or off, pulse range."""
        state, generator = self.state, self.generator
        if state.was_off or not state.motor_on:
            state.was_off = False
            if state.in_motion:
                mark_deviation(self.chip, state, "event", "motor off")
            self.log.end("cut")
            if state.in_motion or self.pulses.law is not None:
                generator.halt(n, complete=False)
            self.gear.suspended = True
        if state.mode != generator.mode:
            self.enter(n, state.mode)
        if state.high_speed != generator.high_speed:
            generator.high_speed, generator.clamped = state.high_speed, False
            generator.fresh |= state.in_motion and generator.aim != "curve"

    def enter(self, n: int, mode: int) -> None:
        """Change to another profile mode; any motion stops, unless it continues as velocity contouring."""
        state, generator, before = self.state, self.generator, self.generator.mode
        if state.in_motion:
            mark_deviation(self.chip, state, "command", PROFILE_COMMANDS[mode])
        if mode != VELOCITY or before == GEAR:
            self.log.stop()
        if mode in (TRAPEZOIDAL, S_CURVE) and before != GEAR and state.in_motion:
            self.chip.finding(
                "mode-in-motion",
                f"axis {state.number}: the profile mode was changed in motion: the axis stops immediately",
            )
            generator.halt(n)
        elif mode == GEAR or before == GEAR:
            generator.halt(n, complete=False)
        generator.mode, state.phase = mode, 0
        self.pulses.acceleration = 0 if mode == GEAR else generator.limits.acceleration
        if mode == GEAR:
            self.gear.enter(PROFILE_COMMANDS[mode])
        elif mode == VELOCITY and state.in_motion and generator.aim != "stop":
            generator.aim, generator.fresh = "contour", True

    def update(self, n: int, taken: Profile) -> None:
        """Apply the values that an update took from the buffer: synchronise, copy registers, then stop or start."""
        state, generator = self.state, self.generator
        state.update, generator.clamped = None, False
        if taken.synch_prfl:
            self.synchronise(n)
        self.copy(taken)
        if taken.stop:
            if state.in_motion or generator.mode == GEAR:
                mark_deviation(self.chip, state, "command", "STOP")
                self.log.stop()
            generator.halt(n)
            self.gear.suspended = True
        elif generator.mode == GEAR:
            self.gear.update(taken.cause)
            if not state.active.ratio and not state.awaits_update:
                self.omit(taken.cause)
        elif taken.smooth_stop:
            self.slow_down(n)
        elif not state.awaits_update:
            self.start(taken.cause)

    def synchronise(self, n: int) -> None:
        """Set the target to the actual position, without a pulse and at unchanged speed, if there is an encoder."""
        if self.feedback.encoder is not None:
            self.feedback.read(n)
            mark_deviation(self.chip, self.state, "command", "SYNCH_PRFL")
            self.generator.cut(n)
            self.declare(n, self.state.actual)
            self.generator.fresh = self.state.in_motion

    def declare(self, n: int, position: int) -> None:
        """Set target and actual position to `position`, and the error to 0, immediately; cycle n's pulses continue."""
        self.generator.fresh |= self.pulses.law is not None
        self.pulses.declare(n, position)
        self.feedback.declare(n, position)

    def copy(self, new: Profile) -> None:
        """Copy the buffer to the active registers; changing a register that is fixed in motion is a command error.

        After this error only the destination is copied.  Refused values wait in the buffer for an update that
        comes when the axis is at rest, without a second error (manual, command errors).
        """
        state = self.state
        old = state.active
        kept = {name: getattr(old, name) for name in FIXED.get(self.generator.mode, ()) if state.in_motion}
        if any(name in new.loaded and getattr(new, name) != value for name, value in kept.items()):
            state.events |= COMMAND_ERROR
            old.position = new.position
            self.chip.finding("command-error", f"axis {state.number}: {IN_MOTION[self.generator.mode]}")
        else:
            for name, value in kept.items():
                setattr(new, name, value)
            state.active = new

    def slow_down(self, n: int) -> None:
        """Begin a smooth stop; if the axis is at rest, set the motion-complete event."""
        if not self.state.in_motion:
            self.generator.complete()
            return
        mark_deviation(self.chip, self.state, "command", "SMOOTH_STOP")
        self.log.stop()
        self.generator.slow_down(n)

    def start(self, cause: str) -> None:
        """Start the axis, or continue its motion, after an update."""
        state, generator = self.state, self.generator
        if generator.mode == S_CURVE and state.in_motion:
            return  # the profile in progress ends first
        active = state.active
        acceleration = active.max_acceleration if generator.mode == S_CURVE else active.acceleration
        distance = acceleration if generator.mode == VELOCITY else active.position * ONE - state.target
        nowhere = generator.mode != VELOCITY and not distance
        if not state.in_motion:
            if not active.velocity or nowhere:
                if not nowhere:
                    self.omit(cause)
                state.events |= MOTION_COMPLETE
                return
            if self.powerless(acceleration):
                self.omit(cause)
                return
            if self.refused(distance):
                return
            generator.start_velocity = state.start_velocity
            if generator.mode != S_CURVE and generator.start_velocity >= active.velocity:
                text = f"axis {state.number}: the start velocity is not below the maximum: there are no ramps"
                self.chip.finding("start-velocity", text)
            self.omitted = []
        begins(self.chip, state, cause, generator.start_velocity, generator.pulse_range)
        generator.set_out(distance)

    def powerless(self, acceleration: int) -> bool:
        """Return whether the axis cannot start from rest, because the active acceleration or jerk is 0."""
        if self.generator.mode == S_CURVE:
            return not (acceleration and self.state.active.jerk)
        return not acceleration and (self.generator.mode == VELOCITY or not self.state.start_velocity)

    def omit(self, cause: str) -> None:
        """Report the registers that are 0 and that the host must set before a motion can start.

        If the last report named the same registers, nothing is reported.
        """
        names, reported = missing_of(self.generator.mode, self.state), self.omitted
        if names and names != reported:
            zero = " and ".join(REGISTERS[name].replace("_", " ") for name in names)
            text = f"axis {self.state.number}: {cause} while {zero} {'are' if names[1:] else 'is'} 0: no motion starts"
            self.chip.finding("no-start", f"{text}; send {' and '.join(names)} before it")
            self.omitted = names

    def refused(self, distance: int) -> bool:
        """Return whether a limit switch prevents the move; a refusal is a command error in point-to-point modes."""
        switches = self.switches
        if not switches.flagged and not switches.active(POSITIVE_LIMIT if distance > 0 else NEGATIVE_LIMIT):
            return False
        text = f"axis {self.state.number}: {AT_LIMIT}"
        if self.generator.mode == VELOCITY:
            self.chip.finding("no-start", text)
        else:
            self.state.events |= COMMAND_ERROR
            self.chip.finding("command-error", text)
        return True
