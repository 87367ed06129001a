"""The trajectory generator of one axis: what it decides at the start of a cycle, and how long that holds by itself.

    cycle n      T_n ------------------------------------------ T_n+1
                 | 0 arrive    1 updates   2 limits             |
                 | 3 choose the displacement up to T_n+1        |      position    x(T_n)  ____----  x(T_n+1)
                 | 4 pulses    5 encoder   6 breakpoint         |      moves evenly from T_n to T_n+1

A displacement chosen once often follows a law for thousands of cycles: a run.  While a run lasts and no input departs
nothing is decided, so nothing is worked: `due` is the next cycle that must be.  `sync` says what the registers hold in
between.  The slow twin (stepwise.py) works every cycle, and must come to the same.

Positions and displacements are in 1/65536 step.
"""

from __future__ import annotations

from ...core.curves import SCurve
from ...core.cycles import Law, Linear
from .horizon import Horizon
from .ideal import departs
from .profile import Limits, Run, brake, contour, trapezoid
from .state import (
    BREAKPOINT,
    GEAR,
    LIMIT_NAMES,
    MOTION_COMPLETE,
    MOTION_ERROR,
    NEGATIVE_LIMIT,
    ONE,
    POSITIVE_LIMIT,
    saturated,
    signed,
)


class Trajectory(Horizon):
    """One axis."""

    def work(self, n: int) -> None:
        """Decide cycle n."""
        self.arrive(n)
        self.settings(n)
        if self.state.update is not None:
            self.update(n, self.state.update)
        self.look_at_limits(n)
        self.choose(n)
        self.look_at_encoder(n)
        self.look_at_breakpoint(n)
        self.due = self.horizon(n)

    def arrive(self, n: int) -> None:
        """What the run set out to do until now is done."""
        if n:
            self._read_encoder(n - 1)  # what the cycle before has seen, unless nobody looked then
        if self.law is not None:
            self._move(n)
            self.state.velocity = self.sign * self.law.velocity(n - self.since - 1)  # as it was up to here
            if n - self.since >= self.cycles:
                landing = self.landing
                self.cut(n)
                if landing:
                    self.complete()

    def look_at_limits(self, n: int) -> None:
        """A switch that goes active halts the axis; one over-travel at a time."""
        state, motion = self.state, self.motion
        if not self.chip.limits_on:
            self.armed = {POSITIVE_LIMIT: True, NEGATIVE_LIMIT: True}
            return
        active = {limit: motion.active(state.number, limit) for limit in self.armed}
        for limit, other in ((POSITIVE_LIMIT, NEGATIVE_LIMIT), (NEGATIVE_LIMIT, POSITIVE_LIMIT)):
            if not active[limit]:
                self.armed[limit] = True
            elif self.armed[limit] and not (state.events & other or (active[other] and not self.armed[other])):
                self.armed[limit] = False
                state.events |= limit
                departs(self.chip, state, "limit", LIMIT_NAMES[limit])
                self.axis.log.end("limit")
                self.halt(n)
                self.suspended = True

    def choose(self, n: int) -> None:
        """Choose the displacement of this cycle, unless the run goes on."""
        if self.mode == GEAR:
            self.gear(n)
        elif self.aim and (self.fresh or self.law is None):
            self.fresh = False
            run = self.plan(n)
            if run is None:
                self.halt(n)
            else:
                self.lay(n, run)
        elif self.law is not None:
            self._move(n)
        self.show_rest(not self.state.in_motion)

    def show_rest(self, rest: bool) -> None:
        if self.mode != GEAR and self.atrest.next != rest:
            self.atrest.drive(int(rest))

    def plan(self, n: int) -> tuple[Law, Run] | None:
        """The next run; None: the motion is over."""
        state = self.state
        if self.aim == "curve":
            if self.law is not None:
                self.done += n - self.since
            law = SCurve(self.phases.pieces(), self.done)
            return law, Run(self.phases.cycles - self.done, 0, landing=True)
        velocity = state.velocity
        self.clamp()
        self.limits = Limits(self.top, abs(state.active.acceleration), self.start_velocity)
        if self.aim == "stop" or not self.limits.velocity:
            run = brake(self.limits, abs(velocity))
            if not run.speed:
                return None
        else:
            limits = self.limits
            self.limits = limits = Limits(limits.velocity, limits.acceleration, min(limits.start, limits.velocity))
            if self.aim == "contour":
                run = self.contour(velocity)
            else:
                distance = state.active.position * ONE - state.target
                if not (velocity or distance):
                    return None
                self.sign = 1 if (velocity or distance) > 0 else -1
                run = trapezoid(limits, self.sign * distance, abs(velocity))
        return Linear(run.speed, run.change), run

    def contour(self, velocity: int) -> Run:
        """The next run of velocity contouring."""
        acceleration = self.state.active.acceleration
        if acceleration * velocity < 0:
            return brake(Limits(self.limits.velocity, self.limits.acceleration, self.start_velocity), abs(velocity))
        if not velocity:
            self.sign = 1 if acceleration > 0 else -1
        return contour(self.limits, abs(velocity))

    def gear(self, n: int) -> None:
        """Follow the encoder; what exceeds the pulse range waits."""
        state = self.state
        new, self.followed = self.counts - self.followed, self.counts
        if self.suspended or self.encoder is None:
            self.backlog = displaced = 0
        else:
            waited, range_ = self.backlog, self.range
            self.backlog += new * state.active.ratio
            displaced = max(min(self.backlog, range_), -range_)
            ahead = POSITIVE_LIMIT if displaced > 0 else NEGATIVE_LIMIT
            if displaced and self.chip.limits_on and self.motion.active(state.number, ahead):
                self.backlog = displaced = 0
            self.backlog -= displaced
            if self.backlog and not waited:
                text = f"axis {state.number}: the encoder asks for more than the pulse range; steps follow later"
                self.chip.finding("gear-backlog", text)
        self.cut(n)
        state.velocity = displaced
        if displaced:
            self.sign = 1 if displaced > 0 else -1
            self.lay(n, (Linear(abs(displaced)), Run(1, abs(displaced))))
        stepped = self.sign * self.lead + abs(displaced) >= ONE
        if self.atrest.next != int(not stepped):
            self.atrest.drive(int(not stepped))

    def look_at_encoder(self, n: int) -> None:
        """Stall detection."""
        state = self.state
        if self.encoder is None:
            return
        self._read_encoder(n)
        error = bool(state.step_ratio) and abs(saturated(state.error)) > state.pos_err
        if error:
            state.events |= MOTION_ERROR
            if not state.motion_error:
                self.axis.log.mark("event", "motion error")
                state.reported = False
                if state.auto_stop:
                    state.switch_off()
                    self.was_off = True
        state.motion_error = error

    def look_at_breakpoint(self, n: int) -> None:
        """A condition that is met updates the axis in the next cycle."""
        state = self.state
        if state.breakpoint and self.met(n):
            command, state.breakpoint = state.breakpoint_command, ""
            self.axis.log.mark("event", f"{command} met")
            state.events |= BREAKPOINT
            if state.auto_update:
                state.take(command)

    def met(self, n: int) -> bool:
        """Is the condition of the breakpoint met?"""
        state, value = self.state, signed(self.state.comparison, 32)
        match state.breakpoint:
            case "time":
                return n % (1 << 32) == state.comparison
            case "pos":
                return state.target >= value * ONE
            case "neg":
                return state.target < (value + 1) * ONE
            case "actl_pos":
                return state.actual >= value
            case "actl_neg":
                return state.actual <= value
            case "mtn_cmplt":
                return bool(state.events & MOTION_COMPLETE)
            case _:
                return not self.home.level_before(self.motion.tick(n))
