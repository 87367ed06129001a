r"""The CY545's motions and HOME, step by step: the slow and obvious reference for the fast path.

The fast path is motion.py and home.py.  The twin shares the outputs and the step periods with it, but
none of the code that plans, promises or samples: the twin computes the length of a step at the start of
the step, and samples the pins at the end of the step.  It reports no findings.

    one step (if a level changes at the instant of a sample, the sample reads the old level):

        begin                                       end = start of the next
          |__|‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾|__   PULSE
          position, SLEW                              samples: the target, the limit, INHIBIT_ABORT
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from functools import partial

from ...core.context import ChipContext
from ...core.motion.motions import Why
from ...core.motion.plan import Leg, Plan
from ...core.motion.train import Playing, StepTrain
from ...core.wires.waits import first_of
from .ideal import RegistersAtStart, Single
from .interfaces.user_bits import UserBits
from .profile import Law
from .registers import Registers
from .stepping.pulse_outputs import StepOutputs

UP, SLEW, DOWN, CRAWL = "up", "slew", "down", "crawl"


class TwinSteps:
    """The common base of the slow twins of motions and HOME."""

    def __init__(
        self, chip: ChipContext, ticks: Mapping[str, int], registers: Registers, outputs: StepOutputs, law: Law
    ) -> None:
        self.chip, self.ticks, self.registers, self.outputs, self.law = chip, ticks, registers, outputs, law
        self.axis, self.log = chip.axes[0], chip.axes[0].log
        self.cw_limit, self.ccw_limit = chip.pins["cw_limit"].net, chip.pins["ccw_limit"].net
        self.moving = False

    def killed(self) -> None:
        """Handle a reset in mid-motion: end the motion; the steps begun so far count, and no more steps follow."""
        self.log.end("cut")
        self.moving = False

    def mark_deviation(self, kind: str, text: str) -> None:
        """Record an event that makes the motion depart from its plan."""
        self.log.depart()
        self.log.mark(kind, text)

    def limit_low(self) -> bool:
        """Return whether the limit in the direction shown on CCW is low; if so, record a deviation from the plan."""
        if self.outputs.sign > 0:
            if self.cw_limit.level == 0:
                self.mark_deviation("limit", "CW_LIMIT")
                return True
        elif self.ccw_limit.level == 0:
            self.mark_deviation("limit", "CCW_LIMIT")
            return True
        return False

    def start(self, text: str, parameters: Callable[..., object], sign: int) -> None:
        """Begin the motion of a command, and set its direction."""
        self.moving = True
        self.chip.waits(f"{text} in motion")
        self.outputs.begin(text, parameters, sign)  # type: ignore[arg-type]
        self.outputs.turn(sign > 0)

    async def lead(self) -> None:
        """Lower STOPPED, and wait until the first step is due."""
        self.outputs.moving(True)
        await self.chip.ticks(self.ticks["ccw_lead"])

    async def step(self, kind: str, period: int) -> None:
        """Output one step, from the fall of PULSE to the end of the step."""
        chip, outputs = self.chip, self.outputs
        begin = chip.tick
        outputs.slew.drive(0 if kind == SLEW else 1)
        outputs.pulse.drive(0)
        leg = Leg(kind, ((period, 1),), 0, 1)
        self.axis.follow(Playing(StepTrain(chip.clock, begin, leg.runs)), outputs.sign, plan=Plan((leg,)))
        await chip.ticks(self.ticks["pulse_low"])
        outputs.pulse.drive(1)
        await chip.at_tick(begin + period)

    async def rest(self, why: Why | None) -> None:
        """Raise STOPPED 5 ms after the last step, and end the motion."""
        self.outputs.slew.drive(1)
        await self.chip.ticks(self.ticks["hold"])
        self.outputs.moving(False)
        self.end(why)

    def end(self, why: Why | None) -> None:
        """End the motion; `why` is the reason, None if the motion is complete or was stopped by a command."""
        self.log.end(why)
        self.moving = False


class Stepwise(TwinSteps):
    """The slow twin of the motions of G and P."""

    def __init__(
        self, chip: ChipContext, ticks: Mapping[str, int], registers: Registers, outputs: StepOutputs, law: Law
    ) -> None:
        super().__init__(chip, ticks, registers, outputs, law)
        self.inhibit, self.slew = chip.pins["inhibit_abort"].net, chip.pins["slew"].net

    async def move(self, number: int, sign: int, text: str) -> None:
        """Run a motion, from its command until STOPPED goes high."""
        chip, ticks, values = self.chip, self.ticks, self.registers.values
        at_start = RegistersAtStart(
            chip.crystal_hz, values["firstrate"], values["rate"], values["slope"], number, self.law
        )
        self.start(text, at_start.parameters, sign)
        await chip.ticks(max(ticks["first_step"] - ticks["ccw_lead"], 0))
        while self.inhibit.level == 0:
            await first_of(chip.kernel, None, (self.inhibit, 1))
            chip.sync()
            await chip.ticks(max(ticks["inhibit_release"] - ticks["ccw_lead"], 1))
        limited = self.limit_low()
        self.endless = self.registers.continuous or self.slew.level == 0
        if limited or not (number or self.endless):
            self.end("limit" if limited else None)
        else:
            await self.lead()
            ideal = partial(at_start.ideal, chip.kernel.now, self.axis.position, self.outputs.sign, self.endless)
            self.log.expect(ideal)
            await self.rest(await self.steps(at_start))
        self.registers.continuous = False

    async def steps(self, at_start: RegistersAtStart) -> Why | None:
        """Output steps until the motion is over; return "limit" if a limit has ended it, otherwise None."""
        periods, first = self.law.periods, at_start.first
        start, slow, fast = self.chip.tick, periods[first], periods[max(first, at_start.rate)]
        up: list[int] = []  # the steps of the ramp up, one by one
        back: list[int] | None = None  # the steps of the stop ramp of INHIBIT_ABORT; None while it has not been low
        taken, index = 0, first
        while True:
            left = at_start.number - taken
            if back is not None:
                slows = bool(back) and back[-1] != slow
                kind, period = (DOWN, back.pop()) if slows else (CRAWL, slow)
            elif not self.endless and left <= len(up):
                kind, period = DOWN, up[left - 1]
            else:
                due = first + (self.chip.tick - start) // ((256 - at_start.slope) * self.law.unit)
                index = due if self.law.jumps or not taken else min(index + 1, due)
                kind, period = (UP, periods[index]) if index < at_start.rate else (SLEW, fast)
                up += [period] if kind == UP else []
            await self.step(kind, period)
            taken += 1
            if taken == at_start.number and not self.endless:
                return None
            if self.limit_low():
                self.log.stop()
                return "limit"
            if self.inhibit.level == 0:
                if back is None:
                    self.mark_deviation("command", "INHIBIT_ABORT")
                    back = up[: at_start.number - taken] if kind == DOWN else up[:]
                if period == slow:
                    self.log.stop()
                    return None


class Homewise(TwinSteps):
    """The slow twin of the homing run of H."""

    def __init__(
        self,
        chip: ChipContext,
        ticks: Mapping[str, int],
        registers: Registers,
        outputs: StepOutputs,
        law: Law,
        shown: Callable[[], Awaitable[None]],
        bits: UserBits,
    ) -> None:
        super().__init__(chip, ticks, registers, outputs, law)
        self.shown, self.bits = shown, bits

    async def seek(self, argument: int) -> None:
        """Run H, from its command until STOPPED goes high."""
        chip, ticks, matches = self.chip, self.ticks, partial(self.bits.matches, argument)
        at_start = Single(chip.crystal_hz, self.registers.values["firstrate"], self.law)
        inside = matches()
        self.start(f"H {argument}", at_start.parameters, -1 if inside else 1)
        await chip.ticks(max(ticks["first_step"] - ticks["ccw_lead"], 0))
        if self.limit_low():
            self.end("limit")
            return
        await self.lead()
        found = True
        if inside and (found := await self.until(False, at_start.period, matches)):
            self.outputs.turn(True)
            await self.lead()
            found = not self.limit_low()
        found = found and await self.until(True, at_start.period, matches)
        if found:
            self.axis.load(0)
            self.log.mark("home", f"H {argument}")
        await self.rest("done" if found else "limit")

    async def until(self, wanted: bool, period: int, matches: Callable[[], bool]) -> bool:
        """Make steps until `matches` returns `wanted` (return True), or until a limit is reached (return False)."""
        while True:
            await self.single(period)
            if matches() is wanted:
                return True
            if self.limit_low():
                return False

    async def single(self, period: int) -> None:
        """Output a step, then show the position if the mode register selects this."""
        await self.step(CRAWL, period)
        await self.shown()
