"""The profile generator of one axis: its aim, and the next run towards that aim.

A run is a series of cycles whose displacements follow one law.  The aim is a destination ("point",
"curve"), a velocity ("contour") or rest ("stop"); it remains the same when a run is interrupted.  The
electronic gear has no aim, and makes one run per cycle (gear.py).
"""

from __future__ import annotations

from ....core.context import ChipContext
from ....errors import PlanError
from .. import sheet
from ..profiles.cycle_train import Law, Linear
from ..profiles.profile import CycleRun, MoveLimits, Phases, brake, contour, s_curve, trapezoid
from ..profiles.s_curves import SCurve
from ..registers import GEAR, MOTION_COMPLETE, ONE, S_CURVE, TRAPEZOIDAL, VELOCITY, AxisState
from .pulses import Pulses
from .verified import fault_of_curve, fault_of_run

AIMS = {TRAPEZOIDAL: "point", VELOCITY: "contour", S_CURVE: "curve"}


class ProfileGenerator:
    """The profile generator of one axis.

    `aim` is empty at rest.  `fresh` is True if a new run must be planned, even while a run is in progress.
    """

    def __init__(self, chip: ChipContext, state: AxisState, pulses: Pulses) -> None:
        self.chip, self.state, self.pulses, self.log = chip, state, pulses, pulses.axis.log
        self.ranges = sheet.STANDARD_RANGE * ONE, sheet.HIGH_RANGE * ONE

    def begin(self) -> None:
        """Begin at rest after reset."""
        self.mode = TRAPEZOIDAL  # active
        self.aim = ""
        self.fresh = False
        self.limits = MoveLimits(0, 0, 0)
        self.start_velocity = 0  # active since the start from rest
        self.phases = Phases(1, 0, 0, 0, 0, 0, 0)
        self.done = 0  # cycles of an S-curve that were over when the run began
        self.clamped = self.high_speed = False

    @property
    def pulse_range(self) -> int:
        """The maximum speed that the selected pulse range allows, in 1/65536 step per cycle."""
        return self.ranges[self.state.high_speed]

    @property
    def top(self) -> int:
        """The active maximum velocity, limited by the pulse range, in 1/65536 step per cycle."""
        return min(self.state.active.velocity, self.pulse_range)

    @property
    def fastest(self) -> int:
        """An upper limit of the displacement in any cycle of the present run, in 1/65536 step; 0 without a run."""
        if self.pulses.law is None:
            return 0
        if self.aim == "curve":
            return min(self.state.active.velocity, self.ranges[1])
        return max(self.limits.velocity, abs(self.state.velocity))

    def clamp(self) -> None:
        """Report a finding if the maximum velocity exceeds the pulse range, at most once per update."""
        velocity = self.state.active.velocity
        if velocity > self.pulse_range and not self.clamped:
            self.clamped = True
            text = f"{velocity / ONE:.2f} steps/cycle exceed the pulse range; allowed {self.pulse_range // ONE}"
            self.chip.finding("clamped", f"axis {self.state.number}: {text}")

    # ---------------------------------------------------------------------------------------------------- begin and end
    def set_out(self, distance: int) -> None:
        """Begin a motion in the present profile mode, or change the aim of a motion in progress to that of the mode.

        `distance`, the signed distance to the destination, is used for an S-curve only.
        """
        state = self.state
        state.in_motion = True
        self.aim = AIMS[self.mode]
        self.fresh = True
        if self.mode == S_CURVE:
            active = state.active
            self.clamp()
            self.pulses.sign = 1 if distance > 0 else -1
            self.phases = s_curve(abs(distance), self.top, active.max_acceleration, active.jerk)
            self.done = 0

    def slow_down(self, n: int) -> None:
        """Begin a smooth stop in cycle `n`: change the aim to "stop" or, in an S-curve, shorten the phases."""
        if self.aim != "curve":
            self.aim, self.fresh = "stop", True
            return
        done = self.done + (n - self.pulses.since if self.pulses.law is not None else 0)
        stopped = self.phases.stopped(done)
        if stopped != self.phases:
            self.phases, self.fresh = stopped, True

    def cut(self, n: int) -> None:
        """End the run at the start of cycle `n`; the next run will continue the motion from there."""
        if self.aim == "curve" and self.pulses.law is not None:
            self.done += n - self.pulses.since
        self.pulses.cut(n)

    def halt(self, n: int, complete: bool = True) -> None:
        """Stop dead at the start of cycle `n`; if `complete` and not in gear mode, set the motion-complete event."""
        self.pulses.cut(n)
        if complete and self.mode != GEAR:
            self.complete()
        else:
            self.rest()

    def complete(self) -> None:
        """End a motion, and set the motion-complete event."""
        self.rest()
        self.state.events |= MOTION_COMPLETE

    def rest(self) -> None:
        """End a motion: the axis is at rest from now on."""
        self.log.end()
        self.state.velocity = self.state.phase = 0
        self.state.in_motion = False
        self.aim = ""

    def wrapped(self) -> None:
        """Request a new plan for a trapezoidal move, because the target position has wrapped around."""
        self.fresh |= self.aim == "point"

    # ------------------------------------------------------------------------------------------------------------- runs
    def go_on(self, n: int) -> None:
        """Begin the next run with cycle `n`; if there is no next run, end the motion."""
        self.fresh = False
        planned = self.plan(n)
        if planned is None:
            self.halt(n)
        else:
            self.schedule(n, *planned)

    def plan(self, n: int) -> tuple[Law, CycleRun] | None:
        """Return the law and the cycles of the next run, which begins with cycle `n`; None if the motion is over."""
        state, pulses = self.state, self.pulses
        if self.aim == "curve":
            if pulses.law is not None:
                self.done += n - pulses.since
            law = SCurve(self.phases.pieces(), self.done)
            return law, CycleRun(self.phases.cycles - self.done, 0, landing=True)
        velocity = state.velocity
        self.clamp()
        self.limits = MoveLimits(self.top, abs(state.active.acceleration), self.start_velocity)
        pulses.acceleration = self.limits.acceleration
        if self.aim == "stop" or not self.limits.velocity:
            run = brake(self.limits, abs(velocity))
            if not run.speed:
                return None
        else:
            limits = self.limits
            self.limits = limits = MoveLimits(limits.velocity, limits.acceleration, min(limits.start, limits.velocity))
            if self.aim == "contour":
                run = self.contour(velocity)
            else:
                distance = state.active.position * ONE - state.target
                if not (velocity or distance):
                    return None
                pulses.sign = 1 if (velocity or distance) > 0 else -1
                run = trapezoid(limits, pulses.sign * distance, abs(velocity))
        return Linear(run.speed, run.change), run

    def contour(self, velocity: int) -> CycleRun:
        """Return the next run of velocity contouring; `velocity` is the signed velocity of the previous cycle."""
        acceleration = self.state.active.acceleration
        if acceleration * velocity < 0:  # it reverses; below s immediately, even if s is above V
            self.limits = MoveLimits(self.limits.velocity, self.limits.acceleration, self.start_velocity)
            return brake(self.limits, abs(velocity))
        if not velocity:
            self.pulses.sign = 1 if acceleration > 0 else -1
        return contour(self.limits, abs(velocity))

    def schedule(self, n: int, law: Law, run: CycleRun) -> None:
        """Check a run, and begin it with cycle `n`."""
        self.verify(n, law, run)
        self.pulses.schedule(n, law, run, self.phases if isinstance(law, SCurve) else None)

    def verify(self, n: int, law: Law, run: CycleRun) -> None:
        """Check a run before its pulses are promised.

        Raises:
            PlanError: the law of motion contains a mistake; the host is never the cause.
        """
        state, before = self.state, abs(self.state.velocity)
        if self.mode == GEAR:  # it follows any motion of another machine
            fault = "" if run.speed <= self.pulse_range else f"displaces {run.speed}; allowed {self.pulse_range}"
        elif isinstance(law, SCurve):
            fault = fault_of_curve(law, run, self.phases, before)
        else:
            remaining = self.pulses.sign * (state.active.position * ONE - state.target)
            fault = fault_of_run(law, run, self.limits, before, remaining)
        if fault:
            raise PlanError(f"{self.chip.name} axis {state.number}, cycle {n}: {run} is inconsistent: {fault}")
