r"""The CY545's motions: ramps, continuous motion, INHIBIT_ABORT and the limits.

    G or P                                                  a step ends
      |  CCW      INHIBIT_ABORT, limit, SLEW                 |
      |__|_____________.........|_____|______________________|______________________|_____
                                 20 µs PULSE                  limit, INHIBIT_ABORT    after the last: 5 ms to STOPPED
                                 STOPPED low

If INHIBIT_ABORT is low at the end of a step made at the first rate, the motion ends.  If INHIBIT_ABORT
is low at the end of a faster step, the motion decelerates to the first rate; there, INHIBIT_ABORT is
sampled again after every step.  If a level
changes at the instant of a sample, the sample reads the old level.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from ....core.context import ChipContext
from ....core.motion.ideal_motion import Ideal
from ....core.motion.motions import MotionParameters, Why
from ....core.motion.plan import Plan
from ....core.motion.train import OPEN
from ....core.wires.net import Net
from ....core.wires.waits import first_of
from ...cy5xx.stepping import motion
from ...cy5xx.stepping.motion import STOP
from .. import profile
from ..ideal import RegistersAtStart
from ..profile import Law
from ..registers import Registers
from .pulse_outputs import StepOutputs


class Stepping(motion.Motion):
    """The common behaviour of motions and HOME: limits, and the direction, which an output on pin CCW may override."""

    registers: Registers
    outputs: StepOutputs
    law: Law
    holder = "no step inhibit"  # the part lacks it

    def __init__(
        self, chip: ChipContext, ticks: Mapping[str, int], registers: Registers, outputs: StepOutputs, law: Law
    ) -> None:
        super().__init__(chip, ticks, registers, outputs, None, law)
        self.ccw = chip.pins["ccw"].net
        self.limits = {1: chip.pins["cw_limit"].net, -1: chip.pins["ccw_limit"].net}
        self.lead = ticks["ccw_lead"]
        self.limited = False  # a limit has ended the motion
        self.sign = 1

    def shows(self, moving: bool) -> None:
        """Drive STOPPED: low while the motor moves, otherwise high."""
        self.outputs.moving(moving)

    def watched(self) -> list[tuple[Net, int]]:
        return [self.limits[self.sign].when_active, (self.ccw, 1 if self.sign > 0 else 0)]

    def refused(self) -> bool:
        """Return whether the limit in the present direction is low; if so, record that this limit ends the motion."""
        sign = self.outputs.sign
        if sign != self.sign:
            self.sign, self.fresh = sign, True
        if self.limits[sign].is_inactive:
            return False
        self.limited = True
        self.mark_deviation("limit", "CW_LIMIT" if sign > 0 else "CCW_LIMIT")
        return True

    async def set_out(self) -> None:
        """Lower STOPPED, and wait for the lead time between its fall and the first step."""
        self.done = 0
        self.shows(True)
        await self.chip.ticks(self.lead)
        self.sign = self.outputs.sign

    async def come_to_rest(self, why: Why | None = None) -> None:
        """End the motion after its last step; STOPPED rises after the hold time."""
        self.settle()
        self.outputs.pulse.deactivate()
        self.outputs.slew.deactivate()
        self.chip.waits(f"waiting for STOPPED high after {self.text}")
        await self.chip.ticks(self.ticks["hold"])
        self.shows(False)
        self.over(why)

    def over(self, why: Why | None = None) -> None:
        """End the motion, and record the reason: "limit" if a limit has ended it, otherwise `why`.

        `why` is None if the motion is complete, or was stopped by a command.
        """
        self.axis.log.end("limit" if self.limited else why)
        self.moving = False

    def stretched(self, leg: str) -> int:
        """Record the leg of the step that begins now; return 0, because no step becomes longer than planned."""
        self.leg = leg
        return 0


class Motion(Stepping):
    """The motions of the commands G and P.  `moving` is True from the command until STOPPED goes high."""

    def __init__(
        self, chip: ChipContext, ticks: Mapping[str, int], registers: Registers, outputs: StepOutputs, law: Law
    ) -> None:
        super().__init__(chip, ticks, registers, outputs, law)
        self.inhibit_abort, self.slew = chip.pins["inhibit_abort"].net, chip.pins["slew"].net

    # -------------------------------------------------------------------------------------------- before the first step
    async def move(self, number: int, sign: int, text: str) -> None:
        """Output `number` steps, or fewer if the motion ends early; return when STOPPED is high again.

        Args:
            number: steps to the target, 0 to 16777215.
            sign: +1 clockwise, -1 counter-clockwise.
            text: the host's command, for the chip's `waiting` text.
        """
        chip, outputs = self.chip, self.outputs
        self.moving, self.number, self.text = True, number, text
        self.aborted = self.limited = False
        outputs.begin(text, self.parameters(number), sign)
        outputs.turn(sign > 0)
        await chip.ticks(max(self.ticks["first_step"] - self.lead, 0))
        await self.released()
        if self.sets_out():
            await self.set_out()
            plan = self.planned()
            self.axis.log.expect(self.expected(plan))
            chip.waits(self.progress)
            await self.play(plan)
            await self.come_to_rest()
        else:
            self.over()
        self.registers.continuous = False

    async def released(self) -> None:
        """Wait, before the first step, until INHIBIT_ABORT is not low."""
        chip = self.chip
        while self.inhibit_abort.is_active:
            chip.waits(f"{self.text} held by inhibit_abort=0")
            await first_of(self.kernel, None, self.inhibit_abort.when_inactive)
            chip.sync()
            await chip.ticks(max(self.ticks["inhibit_release"] - self.lead, 1))

    def sets_out(self) -> bool:
        """Sample the limit and SLEW before the first step; return whether there is a step to output."""
        if self.refused():
            return False
        self.endless = self.registers.continuous or self.slew.is_active
        if not self.number and not self.endless and self.text == "G":
            self.chip.finding("no-steps", "G with N 0 takes no step")
        return self.endless or self.number > 0

    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        """Load the parameters of a motion of `number` steps; return a function that computes them for plots."""
        values = self.registers.values
        first, rate, slope = (values[name] for name in ("firstrate", "rate", "slope"))
        self.at_start = RegistersAtStart(self.chip.crystal_hz, first, rate, slope, number, self.law)
        self.slow = self.law.periods[first]
        return self.at_start.parameters

    def planned(self) -> Plan:
        """Return the plan of this motion."""
        at_start = self.at_start
        if self.endless:
            return profile.endless(at_start.first, at_start.rate, at_start.slope, self.law)
        return profile.move(self.number, at_start.first, at_start.rate, at_start.slope, self.law)

    def expected(self, plan: Plan) -> Callable[[], Ideal]:
        return partial(self.at_start.ideal, self.kernel.now, self.axis.position, self.sign, self.endless)

    # --------------------------------------------------------------------------------------------------------- samples
    def watched(self) -> list[tuple[Net, int]]:
        """Return the inputs whose changes matter now, each with the new level that would matter.

        INHIBIT_ABORT is left out during the ramp down that it has caused.
        """
        pairs = super().watched()
        return pairs if self.aborted and self.leg == "down" else [*pairs, self.inhibit_abort.when_active]

    async def look(self, plan: Plan, step: int) -> Plan:
        """Sample the limit and INHIBIT_ABORT before a step; return the plan to continue with (empty to stop)."""
        if step >= plan.steps:
            return plan  # at the target
        if self.refused():
            return STOP
        if self.inhibit_abort.is_inactive:
            return plan
        again, self.aborted = self.aborted, True
        if not again:
            self.mark_deviation("command", "INHIBIT_ABORT")
        if plan.interval(step - 1) == self.slow:
            return STOP
        if again:
            return plan
        self.chip.waits(self.progress)
        return profile.down(
            plan, step, self.at_start.first, OPEN if self.endless else self.number - self.done, self.law
        )

    @property
    def progress(self) -> str:
        to_target = "to its target unless inhibit_abort=0"
        ends = "until inhibit_abort=0 at the end of a step" if self.endless else to_target
        if self.aborted:
            slows = f"decelerating to rate {self.at_start.first}"
            return f"{self.text}, inhibit_abort=0: {slows} (it then continues {ends})"
        return f"{self.text} in motion (until inhibit_abort=0)" if self.endless else super().progress
