"""The CY512's motion, one step at a time: ramps, ABORT, I/O REQUEST, TERMINATE, each looked at when it is due."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from functools import partial

from ...core.chip import Chip
from ...core.ideal import Ideal
from ...core.motions import Parameters
from ...core.plan import Leg, Plan
from ...core.waits import first_of
from ..cy5xx import twin
from ..cy5xx.lines import line_in
from ..cy5xx.port import BusPort
from ..cy5xx.registers import Registers
from ..cy5xx.slope import Law, Made
from ..cy5xx.steps import StepOutputs
from ..cy5xx.twin import CRAWL, DOWN, SLEW, UP, Step


class Stepwise(twin.Stepwise):
    """Plays every motion step by step."""

    def __init__(
        self,
        chip: Chip,
        ticks: Mapping[str, int],
        registers: Registers,
        outputs: StepOutputs,
        port: BusPort,
        law: Law,
    ) -> None:
        super().__init__(chip, ticks, registers, outputs, port)
        self.law, self.request, self.abort = law, port.request, line_in(chip, "abort")
        self.terminate = line_in(chip, "terminate")
        self.held_high = bool(chip.options.inferred["held_pulse"])
        self.ways: Mapping[str, str] = chip.options.inferred
        self.aborted = False

    def parameters(self, number: int) -> Callable[[], Parameters]:
        """The parameters of a motion that begins now."""
        values = self.registers.values
        self.slope, self.factor, self.aborted = values["slope"], values["factor"] or 256, False
        self.top = values["rate"]
        self.of = Made(self.chip.crystal_hz, self.top, self.slope, self.factor, number, self.law)
        return self.of.parameters

    def step_of(self, kind: str, rate: int, factor: int | None = None) -> Step:
        """Return a step at a rate parameter."""
        return Step(kind, rate, self.law.periods[rate] * (factor or self.factor))

    def prepare(self) -> None:
        """The steps of an undisturbed motion, into `plan`."""
        up: list[Step] = []
        rate = self.law.start
        while self.slope and rate < self.top:
            up.append(self.step_of(UP, rate))
            rate += self.slope
        if 2 * len(up) > self.number:
            self.plan = deque([self.step_of(CRAWL, self.law.start, 1)] * self.number)
            return
        down = [self.step_of(DOWN, step.rate) for step in reversed(up)]
        slew = [self.step_of(SLEW, self.top)] * (self.number - 2 * len(up))
        self.plan = deque([*up, *slew, *down])

    def expected(self) -> Callable[[], Ideal]:
        """What makes the ideal of this motion, whose first step begins now."""
        legs: list[Leg] = []
        for number, step in enumerate(self.plan):
            if legs and legs[-1].name == step.kind:
                last = legs.pop()
                legs.append(Leg(step.kind, (*last.runs, (step.period, 1)), last.first, last.count + 1))
            else:
                legs.append(Leg(step.kind, ((step.period, 1),), number, 1))
        joined = tuple(Leg(leg.name, self.joined(leg), leg.first, leg.count) for leg in legs)
        return partial(self.of.ideal, Plan(joined), self.kernel.now, self.axis.position, self.sign)

    @staticmethod
    def joined(leg: Leg) -> tuple[tuple[int, int], ...]:
        """A steady leg is one run."""
        return ((leg.runs[0][0], leg.count),) if leg.name in (SLEW, CRAWL) else leg.runs

    async def time_out(self, end: int) -> None:
        """A step has begun: wait until PULSE may rise; TERMINATE low ends that, but not at once."""
        chip, least = self.chip, max(self.ticks["terminated"] - self.ticks["pulse_high"], 1)
        await chip.at_tick(min(chip.tick + least, end))
        while chip.tick < end:
            if self.terminate.level == 0:
                self.axis.log.depart()
                return
            await first_of(self.kernel, self.clock.ps(end), (self.terminate, 0))
            await chip.at_tick(min(self.clock.ticks_until(self.kernel.now) + 1, end))

    async def goes_on(self, just: Step) -> bool:
        """Look at everything at the end of a step, in the chip's order; false: the motion is over."""
        if self.coming() is None:
            if self.made < self.number:
                self.axis.log.stop()
            return False
        if self.abort.level == 0 and not self.aborted:
            self.departs("command", "ABORT")
            if not self.turned_down(just, "abort"):
                return False
        if self.request.level == 0 and not (self.aborted and self.ways["request"] == "ramp"):
            self.departs("command", "I/O REQUEST")
            return self.turned_down(just, "request")
        return True

    def turned_down(self, just: Step, option: str) -> bool:
        """The motion is to end: plan the way down; false: there is none."""
        self.aborted = True
        if self.ways[option] == "stop":
            return False
        if just.kind != DOWN:
            rates = range(self.law.start, just.rate, self.slope) if self.slope and just.kind != CRAWL else ()
            self.plan = deque(self.step_of(DOWN, rate) for rate in reversed(rates))
            if not self.plan:
                self.axis.log.stop()
        return bool(self.plan)
