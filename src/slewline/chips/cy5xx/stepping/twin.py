r"""Motion step by step: the slow and obvious reference for the fast path.

The fast path plans whole moves and promises step trains.  A twin plans a list of single steps, drives
every edge when it is due, and samples the pins when the chip does.  The twin is a second opinion: it
shares no code for these tasks with the fast path.  It reports no findings of a motion, but a part's own
twin may do so.

    move:  I/O REQUEST high? -> direction -> STEP INHIBIT low? -> [step -> samples] ... -> over

    one step (a sample reads the levels just before its instant):

        begin                                       end = start of the next
          |                                           |
          |_________________________________      ____|
        ‾‾|                                 |‾‾‾‾|    PULSE
          |                                 |    |
          phases, position, SLEW            |    samples: the target, and the inputs of the part
                                            STEP INHIBIT
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from itertools import groupby
from typing import Any, NamedTuple

from ....core.context import ChipContext
from ....core.motion.ideal_motion import Ideal
from ....core.motion.motions import MotionParameters
from ....core.motion.plan import Leg, Plan
from ....core.motion.train import Playing, StepTrain
from ..interfaces.command_port import BusPort
from ..interfaces.family_lines import line_in
from ..registers import Registers
from .phase_outputs import StepOutputs
from .slope import Law
from .sloped import Registers as SlopeRegisters

UP, SLEW, DOWN = "up", "slew", "down"
CRAWL = "crawl"  # at the first rate, SLEW high, up to the target
SAME = "same"  # the one step with SLEW high that answers a request for the present rate


class TwinStep(NamedTuple):
    """A planned step: its kind, its rate parameter, and its length in clocks."""

    kind: str
    rate: int
    period: int


class Stepwise:
    """The slow twin, which plays every motion step by step.

    A part defines the steps, and the samples between two steps.

    Args:
        law: the law by which a part plans its motions.
    """

    def __init__(
        self,
        chip: ChipContext,
        ticks: Mapping[str, int],
        registers: Registers,
        outputs: StepOutputs,
        port: BusPort,
        law: Any,
    ) -> None:
        self.chip, self.ticks, self.registers, self.outputs, self.port = chip, ticks, registers, outputs, port
        self.kernel, self.clock, self.axis, self.law = chip.kernel, chip.clock, chip.axes[0], law
        self.inhibit, self.abort = line_in(chip, "step_inhibit", 0), line_in(chip, "abort")
        self.request, self.select = port.request, port.select
        self.moving = False
        self.plan: deque[TwinStep] = deque()  # the remaining steps, one by one
        self.sign = 1
        self.number = self.made = 0  # steps of the move, and steps output so far

    # ------------------------------------------------------------------------------------------- defined by a part
    hold_high = False  # PULSE while STEP INHIBIT delays a step

    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        """Return a function that computes the parameters of a motion that begins now."""
        raise NotImplementedError

    def prepare(self) -> None:
        """Fill `plan` with the steps of an undisturbed motion."""
        raise NotImplementedError

    def expected(self) -> Callable[[], Ideal]:
        """Return a function that computes the ideal course of this motion, whose first step begins now."""
        raise NotImplementedError

    async def ordered(self) -> None:
        """Wait until the inputs, except STEP INHIBIT, allow the first step."""

    def coming(self) -> TwinStep | None:
        """Return the next step; None when the target is reached."""
        return self.plan[0] if self.plan else None

    def stretched(self, step: TwinStep) -> int:
        """Return the number of clocks by which the step that begins now is longer than planned."""
        return 0

    async def time_out(self, end: int) -> None:
        """Wait within a step until PULSE may rise: at tick `end`, unless an event ends the step earlier."""
        await self.chip.at_tick(end)

    async def should_continue(self, just: TwinStep) -> bool:
        """Sample all inputs at the end of step `just`, in the chip's order; return False when the motion is over."""
        return self.coming() is not None

    # ------------------------------------------------------------------------------------------------ a whole motion
    def killed(self) -> None:
        """Handle a reset in mid-motion: end the motion; the steps begun so far count, and no more steps follow."""
        self.axis.log.end("cut")
        self.moving = False

    def mark_deviation(self, kind: str, text: str) -> None:
        """Record an event that makes the motion depart from its plan."""
        self.axis.log.depart()
        self.axis.log.mark(kind, text)

    async def move(self, number: int, sign: int, text: str) -> None:
        """Run a motion, from its command to the moment when READY may return."""
        chip = self.chip
        self.moving = True
        chip.waits(f"{text} in motion")
        self.axis.log.begin(text, self.parameters(number), sign)
        self.port.motion_complete.drive(1)
        self.outputs.turn(sign > 0)
        await chip.ticks(self.ticks["step_lead"])
        await self.ordered()
        if number > 0:
            self.number, self.sign, self.made = number, sign, 0
            self.prepare()
            await chip.polled(self.inhibit, 0, self.ticks["inhibit_poll"])
            self.axis.log.expect(self.expected())
            await self.play()
        self.outputs.pulse.drive(1)
        self.outputs.slew.drive(1)
        self.port.motion_complete.drive(0)
        self.axis.log.end()
        self.over()
        self.moving = False
        await chip.ticks(self.ticks["ready_after_motion"])

    def over(self) -> None:
        """Perform any actions that a part adds at the end of a motion."""

    async def play(self) -> None:
        """Output step after step, until a sample between two steps ends the motion."""
        while (step := self.coming()) is not None:
            if self.plan:
                self.plan.popleft()
            await self.step(step)
            if not await self.should_continue(step):
                if self.coming() is not None:
                    self.axis.log.stop()
                return

    # ------------------------------------------------------------------------------------------------------- one step
    async def step(self, step: TwinStep) -> None:
        """Output one step, from the fall of PULSE to the end of its high time."""
        chip, outputs, high = self.chip, self.outputs, self.ticks["pulse_high"]
        begin = chip.tick
        outputs.slew.drive(0 if step.kind == SLEW else 1)
        period = step.period + self.stretched(step)
        outputs.pulse.drive(0)
        registers = self.registers
        registers.phase = (registers.phase + self.sign) % len(outputs.patterns)
        for driver, level in zip(outputs.phases, outputs.patterns[registers.phase], strict=True):
            driver.drive(level)
        leg = Leg(UP if step.kind == SAME else step.kind, ((period, 1),), 0, 1)
        playing = Playing(StepTrain(self.clock, begin, leg.runs), until=None)
        self.axis.follow(playing, self.sign, plan=Plan((leg,)))
        self.made += 1
        await self.time_out(begin + period - high)
        if self.inhibit.level == 1:
            self.mark_deviation("event", "STEP INHIBIT")
            outputs.pulse.drive(1 if self.hold_high else 0)
        await chip.polled(self.inhibit, 0, self.ticks["inhibit_poll"])
        outputs.pulse.drive(1)
        await chip.ticks(high)


class SlopeStepwise(Stepwise):
    """The twin of parts whose rate parameter grows by S with each step (slope.py)."""

    registers: SlopeRegisters
    law: Law

    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        self.motion_made = self.registers.at_start(self.chip.crystal_hz, number, self.law)
        return self.motion_made.parameters

    def step_of(self, kind: str, rate: int, factor: int | None = None) -> TwinStep:
        """Return a step at a rate parameter, lengthened by a factor; the default is the factor of the motion."""
        rate = min(rate, len(self.law.periods) - 1)
        return TwinStep(kind, rate, self.law.periods[rate] * (factor or self.motion_made.factor))

    def ramp_up(self) -> list[TwinStep]:
        """Return the steps of the ramp up to the motion's rate, one by one."""
        made, ramp, rate = self.motion_made, list[TwinStep](), self.law.start
        while made.slope and rate < min(made.rate, len(self.law.periods) - 1):
            ramp.append(self.step_of(UP, rate))
            rate += made.slope
        return ramp

    def expected(self) -> Callable[[], Ideal]:
        runs = tuple((step.period, len(list(alike))) for step, alike in groupby(self.plan))
        return partial(self.motion_made.ideal, runs, self.kernel.now, self.axis.position, self.sign)
