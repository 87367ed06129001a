"""The trajectory generator of one axis: its decisions at the start of a cycle, and how long they remain valid.

    cycle n      T_n ------------------------------------------ T_n+1
                 | 0 arrive    1 updates   2 limits             |
                 | 3 choose the displacement up to T_n+1        |      position    x(T_n)  ____----  x(T_n+1)
                 | 4 pulses    5 encoder   6 breakpoint         |      moves evenly from T_n to T_n+1

The displacements often follow one law for thousands of cycles; such a series of cycles is a run.  While
a run lasts and no input changes, there is no decision to make, so no cycle is processed; `due` is the
next cycle that must be processed.  `sync` sets the registers in between.  The slow twin (twin/)
processes every cycle; its results must be the same.

Each object refers only to those above it in this picture:

    LimitSwitches   Pulses      the active switches; the run, and its promised pulses
      Feedback                  the position from the encoder
        ProfileGenerator        the axis's aim, and the next run towards it
          ElectronicGear        one run per cycle, following the encoder
            Updates  Horizon    the values written by commands; the next cycle that is due
      Trajectory                creates them, and calls them in the order of a cycle

Positions and displacements are in 1/65536 step.
"""

from __future__ import annotations

from ....core.context import ChipContext
from ..cycle_clock import CycleClock
from ..omissions import STALL
from ..profiles.ideal import mark_deviation
from ..registers import BREAKPOINT, GEAR, LIMIT_NAMES, MOTION_COMPLETE, MOTION_ERROR, ONE, AxisState, Registers, signed
from .enc import FilteredInput
from .feedback import Feedback
from .gear import ElectronicGear
from .generator import ProfileGenerator
from .horizon import Horizon
from .pulses import Pulses
from .switches import LimitSwitches
from .updates import Updates


class Trajectory:
    """One axis: its objects, and the order of their work.  `due` is the next cycle that must be processed."""

    def __init__(self, chip: ChipContext, registers: Registers, state: AxisState, cycle_clock: CycleClock) -> None:
        self.chip, self.state, self.cycle_clock = chip, state, cycle_clock
        self.home = FilteredInput(chip.pins[f"home{state.number}"], chip.clock)
        self.at_rest = chip.drivers[f"atrest{state.number}"]
        self.switches = LimitSwitches(chip, registers, state)
        self.pulses = Pulses(chip, state, cycle_clock)
        self.log = self.pulses.axis.log
        self.feedback = Feedback(chip, state, cycle_clock, self.pulses)
        self.generator = ProfileGenerator(chip, state, self.pulses)
        self.gear = ElectronicGear(chip, state, self.generator, self.feedback, self.switches)
        self.updates = Updates(chip, state, self.generator, self.feedback, self.switches, self.gear)
        self.horizon = Horizon(state, self.generator, self.feedback, self.gear, self.home)
        self.due = 0

    def begin(self) -> None:
        """Begin at rest after reset, with cycle 0 due."""
        for each in (self.home, self.switches, self.pulses, self.feedback, self.generator, self.gear, self.updates):
            each.begin()
        self.due = 0

    def sync(self, n: int) -> None:
        """Set the registers to their values in cycle n, which needs no decision."""
        if self.pulses.move(n):
            self.generator.wrapped()
        self.feedback.read(n)

    def work(self, n: int) -> None:
        """Make the decisions of cycle n."""
        self.arrive(n)
        self.updates.settings(n)
        if self.state.update is not None:
            self.updates.update(n, self.state.update)
        self.look_at_limits(n)
        self.choose(n)
        self.look_at_encoder(n)
        self.look_at_breakpoint(n)
        self.due = self.horizon.after(n)

    def arrive(self, n: int) -> None:
        """Set the registers for the start of cycle n, and end a run that is over.

        If that run has reached the destination, the motion ends too.
        """
        if n:
            self.feedback.read(n - 1)  # level in the previous cycle, if it was read then
        pulses = self.pulses
        if pulses.law is not None:
            if pulses.move(n):
                self.generator.wrapped()
            i = n - pulses.since
            self.state.velocity = pulses.sign * pulses.law.velocity(i - 1)  # position error up to this cycle
            if i >= pulses.cycles:
                landing = pulses.landing
                pulses.cut(n)
                if landing:
                    self.generator.complete()

    def look_at_limits(self, n: int) -> None:
        """Stop the axis immediately if a limit switch trips."""
        limit = self.switches.tripped()
        if limit:
            mark_deviation(self.chip, self.state, "limit", LIMIT_NAMES[limit])
            self.log.end("limit")
            self.generator.halt(n)
            self.gear.suspended = True

    def choose(self, n: int) -> None:
        """Choose the displacement of cycle n, unless the present run continues."""
        generator, pulses = self.generator, self.pulses
        if generator.mode == GEAR:
            self.gear.follow(n)
            return
        if generator.aim and (generator.fresh or pulses.law is None):
            generator.go_on(n)
        elif pulses.law is not None:
            pulses.move(n)
        rest = self.at_rest.level_when(not self.state.in_motion)
        if self.at_rest.next != rest:
            self.at_rest.drive(rest)

    def look_at_encoder(self, n: int) -> None:
        """Read the encoder, and report a stall, which is a position error above its limit.

        If auto stop is on, a stall also switches off the motor.
        """
        state, feedback = self.state, self.feedback
        if feedback.encoder is None:
            return
        feedback.read(n)
        error = bool(state.step_ratio) and abs(state.position_error) > state.pos_err
        if error:
            state.events |= MOTION_ERROR
            if not state.motion_error:
                self.log.mark("event", "motion error")
                self.chip.finding("motion-error", f"axis {state.number}: {STALL}")
                state.reported = False
                if state.auto_stop:
                    state.switch_off()
        state.motion_error = error

    def look_at_breakpoint(self, n: int) -> None:
        """Set the breakpoint event if the breakpoint's condition is met.

        If auto update is on, the axis is then updated in the next cycle.
        """
        state = self.state
        if state.breakpoint and self.met(n):
            command, state.breakpoint = state.breakpoint_command, ""
            self.log.mark("event", f"{command} met")
            state.events |= BREAKPOINT
            if state.auto_update:
                state.take(command)

    def met(self, n: int) -> bool:
        """Return whether the condition of the breakpoint is met in cycle n."""
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
                return not self.home.level_before(self.cycle_clock.tick(n))
