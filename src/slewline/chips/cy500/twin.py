"""The CY500's motion, one step at a time.  It shares nothing with motion.py and profile.py but the law's periods."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from itertools import groupby

from ...core.chip import Chip
from ...core.ideal import Ideal
from ...core.motions import Parameters
from ...core.plan import Leg, Plan
from ...core.train import OPEN
from ..cy5xx import twin
from ..cy5xx.lines import line_in
from ..cy5xx.port import BusPort
from ..cy5xx.slope import Law, Made
from ..cy5xx.steps import StepOutputs
from ..cy5xx.twin import DOWN, SLEW, UP, Step
from .instructions import Registers


class Stepwise(twin.Stepwise):
    """Plays every motion step by step."""

    registers: Registers

    def __init__(
        self, chip: Chip, ticks: Mapping[str, int], registers: Registers, outputs: StepOutputs, port: BusPort, law: Law
    ) -> None:
        super().__init__(chip, ticks, registers, outputs, port)
        self.law, self.text, self.goes, self.endless = law, "", False, False
        self.trigger, self.abort, self.xss, self.xdir = (
            line_in(chip, name) for name in ("trigger", "abort", "xss", "xdir")
        )

    async def move(self, number: int, sign: int, text: str) -> None:
        self.text, self.goes = text, number > 0
        await super().move(number, sign, text)

    def parameters(self, number: int) -> Callable[[], Parameters]:
        registers = self.registers
        slope = registers.values["slope"] if registers.sloped and self.text not in ("O", "J") else 0
        factor = 1 if registers.sloped else registers.values["factor"] or 256
        self.motion_made = Made(self.chip.crystal_hz, registers.values["rate"], slope, factor, number, self.law)
        return self.motion_made.parameters

    async def ordered(self) -> None:
        if self.goes:
            await self.chip.polled(self.trigger, 0, self.ticks["inhibit_poll"])

    def expected(self) -> Callable[[], Ideal]:
        alike = [(step, len(list(steps))) for step, steps in groupby(self.plan)]
        runs = [(self.top, OPEN)] if self.endless else alike
        plan = Plan(tuple(Leg(step.kind, ((step.period, count),), 0, count) for step, count in runs))
        return partial(self.motion_made.ideal, plan, self.kernel.now, self.axis.position, self.sign)

    # ------------------------------------------------------------------------------------------------------- the steps
    def prepare(self) -> None:
        """The steps one by one: up until the rate is reached, and down as far as the number goes."""
        self.endless = self.text == "J"
        self.plan = deque()
        if self.abort.level == 0:
            self.endless = False
            self.axis.log.stop()
            return
        self.face()
        if self.text == "O":
            self.plan.append(self.steady(len(self.law.periods) - 1, 1))
        elif not self.endless:
            self.plan.extend(self.sloped(self.number) if self.motion_made.slope else [self.top] * self.number)

    def steady(self, rate: int, factor: int) -> Step:
        """A step at a rate."""
        rate = min(rate, len(self.law.periods) - 1)
        return Step(SLEW, rate, self.law.periods[rate] * factor)

    @property
    def top(self) -> Step:
        """A step at the rate of R."""
        return self.steady(self.motion_made.rate, self.motion_made.factor)

    def sloped(self, number: int) -> list[Step]:
        """The steps of a slope: the chip turns when R is reached, or when just the way down is left."""
        slope, top = self.motion_made.slope, self.top
        parameter, ups = self.law.start, []
        way: list[Step] = []
        while len(way) < number and parameter < top.rate:
            way.append(Step(UP, parameter, self.law.periods[parameter]))
            ups.append(parameter)
            parameter += slope
        while number - len(way) > len(ups):
            way.append(top)
        while len(way) < number:
            parameter = ups.pop()
            way.append(Step(DOWN, parameter, self.law.periods[parameter]))
        return way

    def coming(self) -> Step | None:
        return self.top if self.endless else super().coming()

    async def goes_on(self, just: Step) -> bool:
        """Look at the target, TRIGGER, ABORT, XSS, XDIR."""
        if self.coming() is None:
            return False
        if self.trigger.level == 1:
            self.departs("event", "TRIGGER")
            await self.chip.polled(self.trigger, 0, self.ticks["inhibit_poll"])
        if self.abort.level == 0:
            self.departs("command", "ABORT")
            return False
        if self.endless and self.xss.level == 1:
            self.departs("command", "XSS")
            return False
        if self.face():
            self.departs("event", "XDIR")
        return True

    def face(self) -> bool:
        """In external direction, turn as XDIR says; true: it is another direction than before."""
        before = self.sign
        if self.registers.external:
            self.sign = 1 if self.xdir.level == 1 else -1
        return self.sign != before
