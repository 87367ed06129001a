"""What begins and ends the motions of an axis: updates, settings that act at once, stops."""

from __future__ import annotations

from .ideal import begins, departs
from .profile import s_curve
from .pulses import Pulses
from .state import (
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
    Profile,
)

FIXED = {TRAPEZOIDAL: ("acceleration",), S_CURVE: ("velocity", "max_acceleration", "jerk")}  # while in motion


class Updates(Pulses):
    """One axis, and what the host tells it to do."""

    def settings(self, n: int) -> None:
        """What commands have set at once: profile mode, motor, pulse range."""
        state = self.state
        if self.was_off or not state.motor_on:
            self.was_off = False
            if state.in_motion:
                departs(self.chip, state, "event", "motor off")
            self.axis.log.end("cut")
            if state.in_motion or self.law is not None:
                self.halt(n, complete=False)
            self.suspended = True
        if state.mode != self.mode:
            self.enter(n, state.mode)
        if state.high_speed != self.high_speed:
            self.high_speed, self.clamped = state.high_speed, False
            self.fresh |= state.in_motion and self.aim != "curve"

    def enter(self, n: int, mode: int) -> None:
        """Another profile mode."""
        state, before = self.state, self.mode
        if state.in_motion:
            departs(self.chip, state, "command", PROFILE_COMMANDS[mode])
        if mode != VELOCITY or before == GEAR:
            self.axis.log.stop()
        if mode in (TRAPEZOIDAL, S_CURVE) and before != GEAR and state.in_motion:
            self.chip.finding("mode-in-motion", f"axis {state.number}: profile mode changed in motion: stopped at once")
            self.halt(n)
        elif mode == GEAR or before == GEAR:
            self.halt(n, complete=False)
        self.mode, state.phase = mode, 0
        if mode == GEAR:
            self.followed, self.backlog = self.counts, 0
            self.suspended = state.held or self.flagged
            self.begin_gear(PROFILE_COMMANDS[mode])
        elif mode == VELOCITY and state.in_motion and self.aim != "stop":
            self.aim, self.fresh = "contour", True

    def update(self, n: int, taken: Profile) -> None:
        """What an update has taken from the buffer takes effect, in this order."""
        state = self.state
        state.update, self.clamped = None, False
        if taken.synch_prfl:
            self.synchronise(n)
        self.copy(taken)
        if taken.stop:
            if state.in_motion or self.mode == GEAR:
                departs(self.chip, state, "command", "STOP")
                self.axis.log.stop()
            self.halt(n)
            self.suspended = True
        elif self.mode == GEAR:
            self.engage()
            self.begin_gear(taken.cause)
        elif taken.smooth_stop:
            self.slow_down(n)
        elif not state.held:
            self.start(taken.cause)

    def synchronise(self, n: int) -> None:
        """The target becomes the actual position; no pulse, and the speed stays."""
        if self.encoder is not None:
            self._read_encoder(n)
            departs(self.chip, self.state, "command", "SYNCH_PRFL")
            if self.aim == "curve" and self.law is not None:
                self.done += n - self.since
            self.cut(n)
            self.declare(n, self.state.actual)
            self.fresh = self.state.in_motion

    def copy(self, new: Profile) -> None:
        """To the active registers.  To load what may not change in motion is a command error; the destination may.

        What an earlier update has refused waits in the buffer for one at rest, and is no error again (command errors).
        """
        state = self.state
        old = state.active
        kept = {name: getattr(old, name) for name in FIXED.get(self.mode, ()) if state.in_motion}
        if any(name in new.loaded and getattr(new, name) != value for name, value in kept.items()):
            state.events |= COMMAND_ERROR
            old.position = new.position
        else:
            for name, value in kept.items():
                setattr(new, name, value)
            state.active = new

    def begin_gear(self, cause: str) -> None:
        """The gear follows from now on, unless a limit switch or the motor forbids it."""
        begins(self.chip, self.state, cause, 0, self.range)
        if self.suspended:
            self.axis.log.end("limit" if self.flagged else "cut")

    def engage(self) -> None:
        """The gear follows again, from the counts of now on."""
        if self.suspended and not self.state.held and not self.flagged:
            self.suspended = False
            self.followed = self.counts

    def slow_down(self, n: int) -> None:
        """A smooth stop."""
        if not self.state.in_motion:
            self.complete()
            return
        departs(self.chip, self.state, "command", "SMOOTH_STOP")
        self.axis.log.stop()
        if self.aim == "curve":
            done = self.done + (n - self.since if self.law is not None else 0)
            stopped = self.phases.stopped(done)
            if stopped != self.phases:
                self.phases, self.fresh = stopped, True
        else:
            self.aim, self.fresh = "stop", True

    def start(self, cause: str) -> None:
        """An update lets the axis move, or go on."""
        state = self.state
        if self.mode == S_CURVE and state.in_motion:
            return  # the profile in progress ends first
        active = state.active
        acceleration = active.max_acceleration if self.mode == S_CURVE else active.acceleration
        distance = acceleration if self.mode == VELOCITY else active.position * ONE - state.target
        nowhere = self.mode != VELOCITY and not distance
        if not state.in_motion:
            if not active.velocity or nowhere:
                state.events |= MOTION_COMPLETE
                return
            if self.powerless(acceleration):
                text = f"axis {state.number}: without acceleration{' and jerk' * (self.mode == S_CURVE)} nothing starts"
                self.chip.finding("no-start", text)
                return
            if self.refused(distance):
                return
            self.start_velocity = state.start_velocity
            if self.mode != S_CURVE and self.start_velocity >= active.velocity:
                text = f"axis {state.number}: the start velocity is not below the maximum: no ramps"
                self.chip.finding("start-velocity", text)
        begins(self.chip, state, cause, self.start_velocity, self.range)
        state.in_motion = True
        self.aim = {TRAPEZOIDAL: "point", VELOCITY: "contour", S_CURVE: "curve"}[self.mode]
        self.fresh = True
        if self.mode == S_CURVE:
            self.begin_curve(distance)

    def powerless(self, acceleration: int) -> bool:
        """Can nothing set the axis in motion?"""
        if self.mode == S_CURVE:
            return not (acceleration and self.state.active.jerk)
        return not acceleration and (self.mode == VELOCITY or not self.state.start_velocity)

    @property
    def flagged(self) -> bool:
        """Does the event of a limit switch bar the axis?"""
        return bool(self.chip.limits_on and self.state.events & (POSITIVE_LIMIT | NEGATIVE_LIMIT))

    def refused(self, distance: int) -> bool:
        """Does a limit switch forbid the move?  In the point-to-point modes that is a command error."""
        state = self.state
        ahead = POSITIVE_LIMIT if distance > 0 else NEGATIVE_LIMIT
        if not self.flagged and not (self.chip.limits_on and self.motion.active(state.number, ahead)):
            return False
        if self.mode != VELOCITY:
            state.events |= COMMAND_ERROR
        return True

    def begin_curve(self, distance: int) -> None:
        """Plan an S-curve."""
        active = self.state.active
        self.clamp()
        self.sign = 1 if distance > 0 else -1
        self.phases = s_curve(abs(distance), self.top, active.max_acceleration, active.jerk)
        self.done = 0

    @property
    def top(self) -> int:
        """The maximum velocity, as far as the pulse range allows."""
        return min(self.state.active.velocity, self.range)

    def clamp(self) -> None:
        """Report a velocity beyond the pulse range, once for each update."""
        velocity = self.state.active.velocity
        if velocity > self.range and not self.clamped:
            self.clamped = True
            text = f"{velocity / ONE:.2f} steps/cycle; the pulse range ends at {self.range // ONE}"
            self.chip.finding("clamped", f"axis {self.state.number}: {text}")

    def halt(self, n: int, complete: bool = True) -> None:
        """Stop at once, where the axis is."""
        self.cut(n)
        if complete and self.mode != GEAR:
            self.complete()
        else:
            self.rest()

    def complete(self) -> None:
        """A motion has come to its end."""
        self.rest()
        self.state.events |= MOTION_COMPLETE

    def rest(self) -> None:
        """Speed zero from now on."""
        self.axis.log.end()
        self.state.velocity = self.state.phase = 0
        self.state.in_motion = False
        self.aim = ""
