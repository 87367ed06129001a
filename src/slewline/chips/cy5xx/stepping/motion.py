r"""The plan player: promises the edges of a plan in advance, samples inputs, and withdraws promises.

Sampling points of a step, from its start b to the start b' of the next step; PULSE rises at r:

    b                                   r    b'
    |___________________________________|‾‾‾‾|      PULSE
    |                                   |
    inputs                              STEP INHIBIT: while it is high here, PULSE stays low

Inputs are sampled as the manual requires.  Edges are promised up to the next sample that matters.  When
a watched input changes, the promise is cut short at the first sample strictly after the change; at
this sample the firmware reads the levels just before its instant and decides: continue, replan from the
step that is about to begin, or stop.

A part defines its plans, the inputs that it watches, and its reaction to them at a sample.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any, cast

from ....core.context import ChipContext
from ....core.motion.ideal_motion import Ideal
from ....core.motion.motions import MotionParameters
from ....core.motion.plan import Plan, Runs, tail
from ....core.motion.train import OPEN, Playing, StepTrain
from ....core.wires.net import Net
from ....core.wires.waits import first_of
from ..interfaces.command_port import BusPort
from ..interfaces.family_lines import line_in
from ..registers import Registers
from .phase_outputs import StepOutputs

STOP = Plan(())
Within = Callable[[], Awaitable[bool]]  # the action at a sample within a step; returns whether its length has changed


class Motion:
    """The player of motions, which steps the motor.

    `moving` is True from the command until MOTION COMPLETE falls.

    Args:
        port: drives MOTION COMPLETE; a part without that line overrides `shows`.
        law: the law by which a part plans its motions.
    """

    port: BusPort
    holder = "step_inhibit"  # the pin that delays the next step
    hold_high = False  # STEP INHIBIT delays a step with PULSE high

    def __init__(
        self,
        chip: ChipContext,
        ticks: Mapping[str, int],
        registers: Registers,
        outputs: StepOutputs,
        port: BusPort | None,
        law: Any,
    ) -> None:
        self.chip, self.ticks, self.registers, self.outputs = chip, ticks, registers, outputs
        self.kernel, self.clock, self.axis, self.law = chip.kernel, chip.clock, chip.axes[0], law
        self.inhibit, self.abort = line_in(chip, self.holder, 0), line_in(chip, "abort")
        if port is not None:
            self.port, self.request, self.select = port, port.request, port.select
        self.high = ticks.get("pulse_high", 0)
        self.moving = False
        self.fresh = False  # a sample requires a new train
        self.playing: Playing | None = None

    # -------------------------------------------------------------------------------------- defined by a part
    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        """Return a function that computes the parameters of a motion that begins now."""
        raise NotImplementedError

    def planned(self) -> Plan:
        """Return the plan of this motion, whose first step begins now."""
        raise NotImplementedError

    def expected(self, plan: Plan) -> Callable[[], Ideal]:
        """Return a function that computes the ideal course of this motion, whose first step begins now."""
        raise NotImplementedError

    async def ordered(self) -> None:
        """Wait until the inputs, except STEP INHIBIT, allow the first step; the motion's outputs are already set."""

    def watched(self) -> list[tuple[Net, int]]:
        """Return the inputs to watch now, each with a level: only a change to this level matters."""
        return [self.inhibit.when_active]

    async def look(self, plan: Plan, step: int) -> Plan:
        """Sample the inputs before a step begins, and wait while one of them delays it.

        Returns `plan` itself to continue with `step`, a new plan to be played from its first step, or an empty
        plan to stop the motion.
        """
        return plan

    def stretched(self, leg: str) -> int:
        """Return the number of clocks by which the step that begins now is longer than planned."""
        return 0

    @property
    def each(self) -> bool:
        """True if every step must be processed individually."""
        return False

    @property
    def progress(self) -> str:
        """The text that describes a running motion in the chip's `waiting`."""
        return f"{self.text} in motion ({self.number} steps)"

    # ------------------------------------------------------------------------------------------------- a whole motion
    async def move(self, number: int, sign: int, text: str) -> None:
        """Output `number` steps, or fewer if the motion ends early.

        Args:
            number: steps to the target, 0 to 65535.
            sign: +1 clockwise, -1 counter-clockwise.
            text: the host's command, for the chip's `waiting` text.
        """
        chip = self.chip
        self.begin(number, sign, text)
        self.outputs.turn(sign > 0)
        await chip.ticks(self.ticks["step_lead"])
        await self.ordered()
        if number:
            await self.uninhibited()
            plan = self.planned()
            self.axis.log.expect(self.expected(plan))
            chip.waits(self.progress)
            await self.play(plan)
        elif text == "G":
            chip.finding("no-steps", "G with N 0 takes no step")
        await self.end()

    def begin(self, number: int, sign: int, text: str) -> None:
        """Begin a motion: record it with its parameters, and show that it is in progress."""
        self.moving = True
        self.number, self.sign, self.text = number, sign, text
        self.done = 0  # completed steps of this motion
        self.axis.log.begin(text, self.parameters(number), sign)
        self.shows(True)

    def shows(self, moving: bool) -> None:
        """Drive MOTION COMPLETE: high while a motion is in progress, low when it is complete."""
        self.port.motion_complete.activate(not moving)

    def mark_deviation(self, kind: str, text: str) -> None:
        """Record an event that makes the motion depart from its plan."""
        self.axis.log.depart()
        self.axis.log.mark(kind, text)

    async def uninhibited(self) -> None:
        """Wait, before the first step and with PULSE high, while STEP INHIBIT is high."""
        if self.inhibit.is_active:
            self.chip.waits(f"{self.text} held by {self.holder}=1")
            await self.chip.polled(*self.inhibit.when_inactive, self.ticks["inhibit_poll"])

    async def end(self) -> None:
        """End the motion after its last step: idle the outputs, lower MOTION COMPLETE; return when READY may rise."""
        self.settle()
        self.outputs.pulse.deactivate()
        self.outputs.slew.deactivate()
        self.shows(False)
        self.axis.log.end()
        self.moving = False
        self.chip.waits(f"waiting for READY after {self.text}")
        await self.chip.ticks(self.ticks["ready_after_motion"])

    def killed(self) -> None:
        """Handle a reset in mid-motion: count the steps begun up to and including this instant; drop later steps."""
        if self.playing is not None and self.moving:
            bound = self.kernel.now + 1
            if self.playing.until is None or bound < self.playing.until:
                self.playing.until = bound
            self.settle()
        self.axis.log.end("cut")
        self.moving = False

    # ------------------------------------------------------------------------------------------------- playing a plan
    async def play(self, plan: Plan) -> None:
        """Play a plan, and the plans that replace it, until the motion is over."""
        step, fresh = 0, True  # `step` of the plan is about to begin at this tick
        while True:
            if self.done:
                begin = self.chip.tick
                changed = await self.look(plan, step)
                fresh |= self.chip.tick != begin or self.fresh
                self.fresh = False
                if changed is not plan:
                    plan, step, fresh = changed, 0, True
            if step >= plan.steps:
                if plan is STOP:
                    self.axis.log.stop()
                return
            leg = plan.leg(step)
            self.outputs.slew.activate(leg.name == "slew")
            stretch = self.stretched(leg.name)
            if fresh or stretch:
                self.schedule(plan, step, stretch)
                self.base = step
            stop = step + 1 if self.each else leg.end
            over = step
            step, fresh = await self.until_sample(stop)
            self.done += step - over

    def schedule(self, plan: Plan, step: int, stretch: int = 0) -> None:
        """Promise a train that begins now with step `step` of a plan, and make this step `stretch` clocks longer."""
        runs: Runs = tail(plan.runs, step)
        self.settle()
        if stretch:
            runs = ((runs[0][0] + stretch, 1), *tail(runs, 1))
        self.train = StepTrain(self.clock, self.chip.tick, runs)
        self.playing = Playing(self.train)
        self.axis.follow(self.playing, self.sign, plan=plan, step=step)
        self.outputs.promise(self.playing, self.sign)

    def settle(self) -> None:
        """End the train after the steps made so far; the phases keep the pattern that they have reached."""
        if self.playing is not None:
            steps = self.playing.count(self.kernel.seen)
            if steps:
                self.outputs.step(self.sign * steps)
            self.playing = None

    # ----------------------------------------------------------------------------------------------- until a decision
    async def until_sample(self, stop: int) -> tuple[int, bool]:
        """Let the promised train run until a decision: at the start of step `stop`, or at an earlier sample.

        Returns the step of the plan that is about to begin, and whether this step needs a new train, because a
        sample within a step has changed the length of that step.
        """
        train, playing, clock = self.train, cast("Playing", self.playing), self.clock
        departures = self.watched()
        while True:
            last = None if stop >= OPEN else train.end(stop - self.base)
            within: Within | None = None
            watched = departures
            while True:
                bound = None if last is None else clock.ps(last)
                playing.until = bound
                self.outputs.renew()
                departed = await first_of(self.kernel, bound, *watched)
                if departed is None:
                    break
                watched = [pair for pair in watched if pair[0] is not departed]
                look, later = self.first_sample_after(departed)
                if last is None or look < last:
                    last, within = look, later
            self.chip.tick = last = cast("int", last)  # otherwise the wait would not have ended
            if within is None:
                return self.base + train.step_at(last - 1), False
            step = self.base + train.step_at(last)
            if await within():
                return step, True

    def first_sample_after(self, net: Net) -> tuple[int, Within | None]:
        """Return the tick of a net's first sample strictly after this instant, and the action to perform there.

        The action is None if the sample is at the start of a step, but not if the sample is within a step.
        """
        train, now = self.train, self.kernel.now
        step = train.count(now)  # steps begun; the running one is step - 1
        end = train.end(step)
        if net is not self.inhibit:
            return end, None
        if self.clock.ps(end - self.high) > now:
            return end - self.high, self.hold
        return (train.end(step + 1) - self.high, self.hold) if step < train.steps else (end, None)

    async def hold(self) -> bool:
        """Delay the end of a step while STEP INHIBIT is high; PULSE stays low meanwhile.

        Returns whether the step has become longer.
        """
        if not self.inhibit.is_active:
            return False
        self.chip.waits(f"{self.text} held by {self.holder}=1")
        self.mark_deviation("event", "STEP INHIBIT")
        if self.hold_high:
            self.outputs.pulse.deactivate()
        await self.chip.polled(*self.inhibit.when_inactive, self.ticks["inhibit_poll"])
        await self.rises()
        return True

    async def rises(self) -> None:
        """End the step: PULSE rises now; return `high` clocks later, when the next step begins."""
        self.outputs.pulse.deactivate()
        await self.chip.ticks(self.high)
        self.chip.waits(self.progress)
