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

from bisect import bisect_left
from typing import TYPE_CHECKING, NamedTuple

from ...core.cycles import CycleTrain, Law, Linear, SCurve, SquareView
from ...core.train import Playing
from .enc import FilteredInput, QuadratureCounter
from .profile import Limits, Phases, Run, brake, contour, s_curve, trapezoid
from .sheet import HIGH_RANGE, STANDARD_RANGE
from .state import (
    BREAKPOINT,
    COMMAND_ERROR,
    GEAR,
    MOTION_COMPLETE,
    MOTION_ERROR,
    NEGATIVE_LIMIT,
    ONE,
    POSITIVE_LIMIT,
    S_CURVE,
    TRAPEZOIDAL,
    VELOCITY,
    WRAPPED,
    AxisState,
    saturated,
    signed,
)

if TYPE_CHECKING:
    from .motion import Motion

NEVER = 1 << 80
HALF = ONE // 2
RANGE = 1 << 47  # of the target: 2^31 steps
COUNTS_PER_CYCLE = 8192 // 12 + 1  # the filter lets no more pass


class Past(NamedTuple):
    """From cycle `first` on the target goes as a law says, from `x0` in cycle `since`; without a law it stays there."""

    first: int
    since: int
    x0: int
    sign: int
    law: Law | None
    phases: Phases | None
    done: int


class Trajectory:
    """One axis."""

    def __init__(self, motion: Motion, state: AxisState) -> None:
        self.motion, self.chip = motion, motion.chip
        self.kernel, self.state = motion.kernel, state
        chip = self.chip
        n = state.number
        self.axis = chip.axes[n - 1]
        self.pulse, self.dir, self.atrest = (chip.drivers[f"{name}{n}"] for name in ("pulse", "dir", "atrest"))
        self.home = FilteredInput(chip.pins[f"home{n}"], chip.clock)
        self.encoder: QuadratureCounter | None = None
        if chip.encoder:
            a, b = chip.pins[f"quada{n}"], chip.pins[f"quadb{n}"]
            self.encoder = QuadratureCounter(a, b, chip.clock, chip.finding)

    def begin(self, state: AxisState) -> None:
        """Reset is over: cycle 0 is due."""
        self.state = state
        self.home.begin()
        if self.encoder is not None:
            self.encoder.begin()
        self.mode = TRAPEZOIDAL  # in force
        self.aim = ""  # what moves the axis: point, curve, contour, stop; empty at rest
        self.limits = Limits(0, 0, 0)
        self.start_velocity = 0  # in force since the start from rest
        self.phases = Phases(1, 0, 0, 0, 1)
        self.done = 0  # cycles of an S-curve that were over when the run began
        self.since, self.cycles, self.landing = 0, 0, False
        self.law: Law | None = None  # the run, if there is one: its displacements
        self.sign = 1
        self.x0 = 0  # target at the start of the run; not wrapped within it
        self.turn = 0  # how often the run has wrapped
        self.lead, self.high = 0, False  # target minus emitted position, and PULSE, at the start of the run
        self.past = [Past(0, 0, 0, 1, None, None, 0)]
        self.surplus = 0  # of the lead: what the pulses of this cycle have, but the target no longer
        self.playing: Playing | None = None
        self.fresh = False  # decide anew in step 3, run or no run
        self.was_off = False
        self.clamped = False
        self.armed = {POSITIVE_LIMIT: True, NEGATIVE_LIMIT: True}
        self.counts = self.error8 = self.whole = 0  # encoder; error * 256; whole steps that it knows of
        self.offset = 0  # actual position minus counts
        self.followed = self.backlog = 0  # gear: counts followed so far, displacement that waits
        self.suspended = False
        self.due = 0

    # ---------------------------------------------------------------------------------------------- between decisions
    def sync(self, n: int) -> None:
        """Let the registers show cycle n, in which nothing is decided."""
        self._move(n)
        self._read_encoder(n)

    def _move(self, n: int) -> None:
        """Where the run has come to at the start of a cycle, and how fast: behind its end, how fast it was."""
        state, law = self.state, self.law
        if law is None:
            return
        i = n - self.since
        going = min(i, self.cycles - 1)
        state.velocity = self.sign * law.velocity(going)
        if isinstance(law, SCurve):
            state.phase = self.phases.phase(self.done + going)
        self._show(self.x0 + self.sign * law.travel(i))

    def _show(self, x: int) -> None:
        """The target, and whether it has wrapped."""
        turn = (x + RANGE // 2) // RANGE
        if turn != self.turn:
            self.turn = turn
            self.state.events |= WRAPPED
        self.state.target = x - turn * RANGE

    def _read_encoder(self, n: int) -> None:
        """Counts up to the start of a cycle, and the position error."""
        state, encoder = self.state, self.encoder
        if encoder is None:
            return
        counts = encoder.counts_before(self.motion.tick(n))
        whole = (self.state.target + self.turn * RANGE) // ONE
        self.error8 += (counts - self.counts) * 256 - state.step_ratio * (whole - self.whole)
        self.counts, self.whole = counts, whole
        state.actual = signed(counts + self.offset, 31)
        state.error = self.error8 >> 8

    # --------------------------------------------------------------------------------------------------- cycle by cycle
    def work(self, n: int) -> None:
        """Decide cycle n."""
        self.arrive(n)
        self.settings(n)
        if self.state.update:
            self.update(n)
        self.look_at_limits(n)
        self.choose(n)
        self.look_at_encoder(n)
        self.look_at_breakpoint(n)
        self.due = self.horizon(n)

    # step 0
    def arrive(self, n: int) -> None:
        """What the run set out to do until now is done."""
        if n:
            self._read_encoder(n - 1)  # what the cycle before has seen, unless nobody looked then
        self._move(n)
        if self.law is not None and n - self.since >= self.cycles:
            landing = self.landing
            self.cut(n)
            if landing:
                self.complete()

    def complete(self) -> None:
        """A motion has come to its end."""
        self.rest()
        self.state.events |= MOTION_COMPLETE

    def rest(self) -> None:
        """Speed zero from now on."""
        self.state.velocity = self.state.phase = 0
        self.state.in_motion = False
        self.aim = ""

    def halt(self, n: int, complete: bool = True) -> None:
        """Stop at once, where the axis is."""
        self.cut(n)
        if complete and self.mode != GEAR:
            self.complete()
        else:
            self.rest()

    def cut(self, n: int) -> None:
        """End the run here: note where it has come to."""
        if self.law is None:
            return
        y = self.sign * self.lead + self.law.travel(n - self.since)
        steps = max(y // ONE, 0)
        rest = y - steps * ONE
        self.high = rest >= HALF or (self.high and not steps)
        self.lead = self.sign * rest - self.surplus
        self.law, self.surplus = None, 0
        self._base()
        self.remember(n)
        if self.playing is not None:
            self.playing.until = self.kernel.now + 1
            self.pulse.renew()
            self.playing = None

    def remember(self, n: int) -> None:
        """Keep what begins with cycle n, for who asks later."""
        curve = self.law is not None and self.aim == "curve"
        entry = Past(n, self.since, self.x0, self.sign, self.law, self.phases if curve else None, self.done)
        if self.past[-1].first == n:
            self.past[-1] = entry
        else:
            self.past.append(entry)

    def _base(self) -> None:
        """Count from the target as it is, which lies within its range."""
        self.whole -= self.turn * (RANGE // ONE)
        self.x0, self.turn = self.state.target, 0

    def end(self) -> None:
        """Reset: whatever is promised ends with this instant."""
        self.law = None
        if self.playing is not None:
            self.playing.until = self.kernel.now + 1
            self.pulse.renew()
            self.playing = None

    # step 1
    def settings(self, n: int) -> None:
        """What commands have set at once: profile mode, motor, pulse range."""
        state = self.state
        if self.was_off or not state.motor_on:
            self.was_off = False
            if state.in_motion or self.law is not None:
                self.halt(n, complete=False)
            self.suspended = True
        if state.mode != self.mode:
            self.enter(n, state.mode)
        if state.in_motion and self.top != self.limits.velocity and self.aim != "curve":
            self.fresh = True

    def enter(self, n: int, mode: int) -> None:
        """Another profile mode."""
        state, before = self.state, self.mode
        if mode in (TRAPEZOIDAL, S_CURVE) and before != GEAR and state.in_motion:
            self.chip.finding("mode-in-motion", f"axis {state.number}: profile mode changed in motion: stopped at once")
            self.halt(n)
        elif mode == GEAR or before == GEAR:
            self.halt(n, complete=False)
        self.mode = mode
        if mode == GEAR:
            self.followed, self.backlog, self.suspended = self.counts, 0, not state.motor_on
        elif mode == VELOCITY and state.in_motion:
            self.aim, self.fresh = "contour", True

    def update(self, n: int) -> None:
        """The buffered registers and actions take effect, in this order."""
        state = self.state
        state.update = self.clamped = False
        if state.synch_prfl:
            self.synchronise(n)
        self.copy()
        stop, smooth_stop = state.stop, state.smooth_stop
        state.stop = state.smooth_stop = state.synch_prfl = False
        self.suspended = not state.motor_on
        if stop:
            self.halt(n)
            self.suspended = True
            self.followed, self.backlog = self.counts, 0
        elif self.mode == GEAR:
            if self.chip.limits_on and state.events & (POSITIVE_LIMIT | NEGATIVE_LIMIT):
                self.suspended = True
        elif smooth_stop:
            self.slow_down(n)
        elif state.motor_on:
            self.start()

    def synchronise(self, n: int) -> None:
        """The target becomes the actual position; no pulse, and the speed stays."""
        if self.encoder is not None:
            if self.aim == "curve" and self.law is not None:
                self.done += n - self.since
            self.cut(n)
            self.declare(n, self.state.actual)
            self.fresh = self.state.in_motion

    def declare(self, n: int, value: int) -> None:
        """The target is a whole number of steps from now on, the position error zero; the pulses of cycle n go on."""
        state, law = self.state, self.law
        state.target = value * ONE
        if law is None:
            self.lead = 0
            self._base()
        else:
            travelled = law.travel(n - self.since)
            y = self.sign * self.lead + travelled
            self.surplus = self.sign * (y - max(y // ONE, 0) * ONE)
            self.x0, self.turn = value * ONE - self.sign * travelled, 0
            self.fresh = True
        self.remember(n)
        self.whole, self.error8, self.state.error = value, 0, 0
        if self.encoder is not None:
            self.offset += value - state.actual
            state.actual = value
        self.kernel.call_at(self.kernel.now, lambda: self._load(n, value))

    def _load(self, n: int, value: int) -> None:
        """The emitted position becomes this, and what has been emitted since cycle n began."""
        if self.playing is not None:
            begun = self.playing.begun(self.kernel.now) - self.playing.begun(self.chip.clock.ps(self.motion.tick(n)))
            value += self.sign * begun
        self.axis.load(signed(value, 31))

    def copy(self) -> None:
        """Buffer to active registers.  What may not change in motion is a command error; the destination may."""
        state = self.state
        new, old = state.buffer, state.active
        wrong = state.in_motion and (
            (self.mode == TRAPEZOIDAL and new.acceleration != old.acceleration)
            or (
                self.mode == S_CURVE
                and (new.velocity, new.max_acceleration, new.jerk) != (old.velocity, old.max_acceleration, old.jerk)
            )
        )
        if wrong:
            state.events |= COMMAND_ERROR
            old.position = new.position
        else:
            state.active = new.copy()

    def slow_down(self, n: int) -> None:
        """A smooth stop."""
        if not self.state.in_motion:
            self.complete()
        elif self.aim == "curve":
            done = self.done + n - self.since
            stopped = self.phases.stopped(done)
            if stopped != self.phases:
                self.phases, self.fresh = stopped, True
        else:
            self.aim, self.fresh = "stop", True

    def start(self) -> None:
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

    def refused(self, distance: int) -> bool:
        """Does a limit switch forbid the move?  In the point-to-point modes that is a command error."""
        state = self.state
        tripped = state.events & (POSITIVE_LIMIT | NEGATIVE_LIMIT)
        ahead = POSITIVE_LIMIT if distance > 0 else NEGATIVE_LIMIT
        if not self.chip.limits_on or not (tripped or self.motion.active(state.number, ahead)):
            return False
        if self.mode != VELOCITY:
            state.events |= COMMAND_ERROR
        return True

    def begin_curve(self, distance: int) -> None:
        """Plan an S-curve."""
        active = self.state.active
        self.sign = 1 if distance > 0 else -1
        self.phases = s_curve(abs(distance), self.top, active.max_acceleration, active.jerk)
        self.done = 0

    # step 2
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
                self.halt(n)
                self.suspended = True

    # steps 3 and 4
    @property
    def top(self) -> int:
        """The maximum velocity, as far as the pulse range allows."""
        range_ = (HIGH_RANGE if self.state.high_speed else STANDARD_RANGE) * ONE
        velocity = self.state.active.velocity
        if velocity > range_ and not self.clamped:
            self.clamped = True
            text = (
                f"axis {self.state.number}: {velocity / ONE:.2f} steps/cycle; the pulse range ends at {range_ // ONE}"
            )
            self.chip.finding("clamped", text)
        return min(velocity, range_)

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
            phases = self.phases
            law = SCurve(phases.distance, phases.whole, phases.lengths, self.done)
            return law, Run(phases.cycles - self.done, 0, landing=True)
        velocity = state.velocity
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

    def lay(self, n: int, planned: tuple[Law, Run]) -> None:
        """Begin a run with cycle n; its pulses follow when whatever belongs to this instant is over."""
        law, run = planned
        sign = self.sign
        self.cut(n)
        self.sign, self.law = sign, law
        self.since, self.cycles, self.landing = n, run.cycles, run.landing
        self._move(n)
        self.remember(n)
        if run.speed or isinstance(law, SCurve):
            self.kernel.call_at(self.kernel.now, self.play)

    def play(self) -> None:
        """Promise the pulses of the run."""
        assert self.law is not None
        train = CycleTrain(self.chip.clock, self.motion.tick(self.since), self.law, self.cycles, self.sign * self.lead)
        self.playing = Playing(train)
        self.axis.follow(self.playing, self.sign)
        if self.dir.next != int(self.sign > 0):
            self.dir.drive(int(self.sign > 0))
        self.pulse.play(SquareView(self.playing, self.high))

    def gear(self, n: int) -> None:
        """Follow the encoder; what exceeds the pulse range waits."""
        state = self.state
        new, self.followed = self.counts - self.followed, self.counts
        if self.suspended or self.encoder is None:
            self.backlog = displaced = 0
        else:
            waited, range_ = self.backlog, (HIGH_RANGE if state.high_speed else STANDARD_RANGE) * ONE
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

    # step 5
    def look_at_encoder(self, n: int) -> None:
        """Stall detection."""
        state = self.state
        if self.encoder is None:
            return
        self._read_encoder(n)
        error = bool(state.step_ratio) and abs(saturated(state.error)) > state.pos_err
        if error:
            state.events |= MOTION_ERROR
            if state.auto_stop and not state.motion_error:
                state.motor_on = False
        state.motion_error = error

    # step 6
    def look_at_breakpoint(self, n: int) -> None:
        """A condition that is met updates the axis in the next cycle."""
        state = self.state
        if state.breakpoint and self.met(n):
            state.breakpoint = ""
            state.events |= BREAKPOINT
            state.update |= state.auto_update

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

    # ------------------------------------------------------------------------------------------- how long that holds
    def horizon(self, n: int) -> int:
        """The next cycle in which something is to be decided, if no input departs and no command comes."""
        state = self.state
        if state.update or (not state.motor_on and self.law is not None):
            return n + 1
        due = NEVER if self.law is None else self.since + self.cycles
        if self.law is not None:
            due = min(due, self.passes(RANGE // 2 if self.sign > 0 else RANGE // 2 + 1, self.turn * self.sign))
        if self.mode == GEAR and self.encoder is not None and not self.encoder.quiet:
            return n + 1
        if self.mode == GEAR and (self.backlog or self.followed != self.counts):
            return n + 1
        return min(due, self.breakpoint_due(n), self.error_due(n))

    def passes(self, distance: int, turns: int = 0) -> int:
        """The cycle at which the run comes to lie so far from zero in its direction, `turns` ranges further."""
        assert self.law is not None
        missing = distance + turns * RANGE - self.sign * self.x0
        if missing <= 0:
            return NEVER
        if self.law.steady:
            return self.since - (-missing // self.law.steady)
        if self.law.travel(self.cycles) < missing:
            return NEVER
        return self.since + bisect_left(range(self.cycles + 1), missing, key=self.law.travel)

    def breakpoint_due(self, n: int) -> int:
        """When the breakpoint may be met."""
        state, value = self.state, signed(self.state.comparison, 32)
        match state.breakpoint:
            case "time":
                return n + ((state.comparison - n - 1) % (1 << 32)) + 1
            case "pos" | "neg" if self.law is not None:
                if (state.breakpoint == "pos") is not (self.sign > 0):
                    return NEVER  # moving away: it is met only behind the end of the range, where work is due
                edge = value * ONE if self.sign > 0 else -((value + 1) * ONE) + 1
                return max(self.passes(edge, self.turn * self.sign), n + 1)
            case "actl_pos" | "actl_neg" if self.encoder is not None and not self.encoder.quiet:
                return n + max(abs(value - state.actual) // COUNTS_PER_CYCLE, 1)
            case "ext" if not self.home.quiet:
                return n + 1
        return NEVER

    def error_due(self, n: int) -> int:
        """When the position error may pass its limit, one way or the other."""
        state = self.state
        if self.encoder is None or not state.step_ratio:
            return NEVER
        fastest = 0 if self.law is None else (self.limits.velocity if self.aim != "curve" else RANGE_TOP) // ONE + 1
        fastest = max(fastest, abs(state.velocity) // ONE + 1) if self.law is not None else 0
        rate = fastest * state.step_ratio // 256 + 1 if fastest else 0
        rate += 0 if self.encoder.quiet else COUNTS_PER_CYCLE
        if not rate:
            return NEVER
        return n + max(abs(state.pos_err - abs(saturated(state.error))) // rate, 1)


RANGE_TOP = HIGH_RANGE * ONE
