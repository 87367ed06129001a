"""The CY512's motion, step by step: ramps, ABORT, I/O REQUEST and TERMINATE, each input sampled when it is due."""

from __future__ import annotations

from collections import deque
from typing import Any

from ...core.wires.waits import first_of
from ..cy5xx.stepping.twin import CRAWL, DOWN, SLEW, SlopeStepwise, TwinStep


class Stepwise(SlopeStepwise):
    """The slow twin of `Motion` in motion.py: it plays every motion step by step."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.inferred = self.chip.options.inferred
        self.hold_high = bool(self.inferred["held_pulse"])
        self.terminate = self.chip.pins["terminate"].net

    def prepare(self) -> None:
        self.aborted, up = False, self.ramp_up()
        if 2 * len(up) > self.number:
            self.plan = deque([self.step_of(CRAWL, self.law.start, 1)] * self.number)
            return
        down = [self.step_of(DOWN, step.rate) for step in reversed(up)]
        slew = [self.step_of(SLEW, self.motion_made.rate)] * (self.number - 2 * len(up))
        self.plan = deque([*up, *slew, *down])

    async def time_out(self, end: int) -> None:
        """Wait within a step until PULSE may rise; after a minimum time, the wait also ends if TERMINATE is low."""
        chip, least = self.chip, max(self.ticks["terminated"] - self.ticks["pulse_high"], 1)
        await chip.at_tick(min(chip.tick + least, end))
        while chip.tick < end:
            if self.terminate.level == 0:
                self.axis.log.depart()
                return
            await first_of(self.kernel, self.clock.ps(end), (self.terminate, 0))
            await chip.at_tick(min(self.clock.ticks_until(self.kernel.now) + 1, end))

    async def should_continue(self, just: TwinStep) -> bool:
        if self.coming() is None:
            if self.made < self.number:
                self.axis.log.stop()
            return False
        if self.abort.level == 0 and not self.aborted:
            self.mark_deviation("command", "ABORT")
            if not self.turned_down(just, "abort"):
                return False
        if self.request.level == 0 and not (self.aborted and self.inferred["request"] == "ramp"):
            self.mark_deviation("command", "I/O REQUEST")
            return self.turned_down(just, "request")
        return True

    def turned_down(self, just: TwinStep, option: str) -> bool:
        """Plan the stop ramp of a motion; return False if there is none, so that the motion ends immediately."""
        self.aborted = True
        if self.inferred[option] == "stop":
            return False
        if just.kind != DOWN:
            slope = self.motion_made.slope if just.kind != CRAWL else 0
            rates = range(self.law.start, just.rate, slope) if slope else ()
            self.plan = deque(self.step_of(DOWN, rate) for rate in reversed(rates))
            if not self.plan:
                self.axis.log.stop()
        return bool(self.plan)
