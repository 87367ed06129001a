r"""Motion of the CY512.  TERMINATE ends a step early, so that an encoder can time the next step.

    b                  t                 b + period
    |__________________|‾‾‾‾|_ _ _ _ _ _      PULSE
    |                       |
    ABORT, I/O REQUEST      the next step, after PULSE has been high for 16 µs at 6 MHz

b is the start of a step, t the instant at which TERMINATE is found low.  TERMINATE is not sampled early
in a step, so that every step, including the time of PULSE high, lasts at least 92 machine cycles.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...core.motion.motions import MotionParameters
from ...core.motion.plan import Plan, mirrored, plan, tail
from ...core.wires.net import Net
from ..cy5xx.stepping import sloped
from ..cy5xx.stepping.motion import STOP, Within
from . import profile


class Motion(sloped.Motion):
    """The player of the plans of profile.py."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.inferred = self.chip.options.inferred
        self.hold_high = bool(self.inferred["held_pulse"])
        self.terminate = self.chip.pins["terminate"].net
        self.least = max(self.ticks["terminated"] - self.high, 1)  # clocks from the start of a step

    # ------------------------------------------------------------------------------------------ before the first step
    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        self.aborted = False
        return super().parameters(number)

    def planned(self) -> Plan:
        return profile.move(self.number, self.at_start.rate, self.at_start.slope, self.at_start.factor, self.law)

    # ----------------------------------------------------------------------------------------------- between two steps
    def watched(self) -> list[tuple[Net, int]]:
        pairs = [*super().watched(), self.terminate.when_active, self.request.when_active]
        return pairs if self.aborted else [*pairs, self.abort.when_active]

    async def look(self, plan: Plan, step: int) -> Plan:
        """Sample ABORT and I/O REQUEST before a step; return the plan of the rest of the motion (empty to stop)."""
        if step >= plan.steps:
            return STOP if self.done < self.number else plan  # an end before or at the target
        if not self.aborted and self.abort.is_active:
            plan, step = self.ended("abort", "ABORT", plan, step), 0
        if plan is not STOP and self.request.is_active:
            self.chip.finding("software-abort", "I/O REQUEST is low at the end of a step: the motion ends")
            if not (self.aborted and self.inferred["request"] == "ramp"):
                return self.ended("request", "I/O REQUEST", plan, step)
        return plan

    def ended(self, option: str, text: str, of: Plan, step: int) -> Plan:
        """Return the plan that ends the motion: the stop ramp if `option` selects it, else an immediate stop."""
        self.aborted = True
        self.mark_deviation("command", text)
        down = self.stop_ramp(of, step) if self.inferred[option] == "ramp" else ()
        return plan(("down", down)) if down else STOP

    def stop_ramp(self, of: Plan, step: int) -> tuple[tuple[int, int], ...]:
        """Return the stop ramp that begins at the end of a step, as runs of equal steps; () if there is none."""
        over = of.leg(step - 1) if step else of.legs[0]
        if over.name == "down":
            return tail(over.runs, step - over.first)
        if over.name == "crawl":
            return ()
        at_start = self.at_start
        rate = at_start.rate if over.name == "slew" else self.law.start + (step - 1) * at_start.slope
        return mirrored(self.law.up(rate, at_start.slope, at_start.factor))

    # -------------------------------------------------------------------------------------------------------- TERMINATE
    def first_sample_after(self, net: Net) -> tuple[int, Within | None]:
        """Return the tick at which a net is sampled next, and the action to take at that tick.

        If the sample is at the end of a step, None is returned instead of an action.
        """
        if net is not self.terminate:
            return super().first_sample_after(net)
        now, train = self.kernel.now, self.train
        step = train.count(now)
        look = max(train.end(step - 1) + self.least, self.clock.ticks_until(now) + 1)
        end = train.end(step)
        return (look, self.terminated) if look < end - self.high else (end, None)

    async def terminated(self) -> bool:
        """End the step now if TERMINATE is low; return whether TERMINATE is low."""
        if self.terminate.is_inactive:
            return False
        self.axis.log.depart()
        if not await self.hold():
            await self.rises()
        return True
