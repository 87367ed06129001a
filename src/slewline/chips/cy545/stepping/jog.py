r"""JOG: manual single steps between commands.

The line JOG has three states: open (no steps), low (clockwise) and driven high (counter-clockwise).

    JOG?                                                      JOG?
      |  20 µs                                        20 µs    |
    CCW ----- as JOG ------------------------------- | restored | as JOG
           |__|‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾|__|‾‾‾‾   PULSE, at a twentieth of the first rate
           |<-------------------- period ---------------------->|

JOG is sampled at "JOG?".  The chip detects the open state by driving the line high and low in turn; the
emulated net does not show these levels.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping

from ....core.context import ChipContext
from ....core.motion.plan import Plan
from ....core.motion.train import Playing, StepTrain
from ....core.wires.net import Net
from .. import profile
from ..ideal import Single
from ..profile import Law
from ..registers import Registers
from .pulse_outputs import StepOutputs


class Jog:
    """The generator of single jog steps.

    Args:
        shown: a function that writes the position to the display, if the mode register selects this.
    """

    def __init__(
        self,
        chip: ChipContext,
        ticks: Mapping[str, int],
        registers: Registers,
        outputs: StepOutputs,
        law: Law,
        shown: Callable[[], Awaitable[None]],
    ) -> None:
        self.chip, self.ticks, self.registers, self.outputs, self.law = chip, ticks, registers, outputs, law
        self.shown, self.lead, self.axis = shown, ticks["ccw_lead"], chip.axes[0]
        self.net: Net = chip.pins["jog"].net
        self.limits = {1: chip.pins["cw_limit"].net, -1: chip.pins["ccw_limit"].net}
        self.direction_of_motion = self.motion = 0

    @property
    def watched(self) -> tuple[tuple[Net, None], ...]:
        """The inputs that an idle chip must watch, as each may change `direction`; None stands for any change."""
        return tuple((net, None) for net in (self.net, self.outputs.direction_net, *self.limits.values()))

    @property
    def direction(self) -> int | None:
        """The direction selected by JOG, +1 (clockwise) or -1; None if JOG is open or a limit forbids the step.

        A limit input forbids the step if it is low and is the one for the direction in which the step
        would count.  If another output pulls the CCW pin low, every step counts clockwise.
        """
        level = self.net.level
        if level is None:
            return None
        direction = -1 if level else 1
        return direction if self.limits[self.outputs.expected(direction)].is_inactive else None

    async def step(self, direction: int) -> None:
        """Output a step in a direction; wait until one step period after the call, when JOG must be sampled again."""
        chip, outputs = self.chip, self.outputs
        single = Single(chip.crystal_hz, self.registers.values["firstrate"], self.law)
        begin, period = chip.tick + self.lead, single.period
        if self.motion != outputs.motions or not self.axis.log.in_progress or direction != self.direction_of_motion:
            self.motion, self.direction_of_motion = outputs.begin("JOG", single.parameters, direction), direction
        chip.waits(f"taking a jog step (jog={0 if direction > 0 else 1})")
        outputs.point(direction > 0)
        outputs.moving(True)
        await chip.at_tick(begin)
        plan: Plan = profile.steady(period, 1)
        playing = Playing(StepTrain(chip.clock, begin, plan.runs))
        self.axis.follow(playing, outputs.sign, plan=plan)
        outputs.promise(playing, outputs.sign)
        await chip.at_tick(begin + period - 2 * self.lead)
        outputs.point(self.registers.clockwise)
        await chip.at_tick(begin + period - self.lead)
        outputs.stops(begin + period, self.motion)
        await self.shown()
