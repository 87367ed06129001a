"""The CY500's motion, step by step.  It shares only the step periods with motion.py and profile.py."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

from ...core.motion.ideal_motion import Ideal
from ...core.motion.motions import MotionParameters
from ...core.motion.train import OPEN
from ..cy5xx.stepping.twin import DOWN, SLEW, SlopeStepwise, TwinStep
from .instructions import Registers


class Stepwise(SlopeStepwise):
    """The slow twin of `Motion` in motion.py: it plays every motion step by step."""

    registers: Registers

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.text, self.goes, self.endless = "", False, False
        self.trigger, self.xss, self.xdir = (self.chip.pins[name].net for name in ("trigger", "xss", "xdir"))

    async def move(self, number: int, sign: int, text: str) -> None:
        """Output a number of steps in a direction, +1 or -1, for the command `text`."""
        self.text, self.goes = text, number > 0
        await super().move(number, sign, text)

    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        """Return a function that computes the parameters of a motion; motions of O and J have no slope."""
        super().parameters(number)
        if self.text in ("O", "J"):
            self.motion_made = self.motion_made._replace(slope=0)
        return self.motion_made.parameters

    async def ordered(self) -> None:
        """Wait until TRIGGER is low, which lets the motion begin; a motion without steps does not wait."""
        if self.goes:
            await self.chip.polled(self.trigger, 0, self.ticks["inhibit_poll"])

    def expected(self) -> Callable[[], Ideal]:
        """Return a function that computes the ideal motion, which is endless in jog mode."""
        if not self.endless:
            return super().expected()
        runs = ((self.top.period, OPEN),)
        return partial(self.motion_made.ideal, runs, self.kernel.now, self.axis.position, self.sign)

    # ------------------------------------------------------------------------------------------------------- the steps
    def prepare(self) -> None:
        """List the steps one by one: the ramp up, the steps at rate R, and as much of the ramp down as still fits."""
        self.endless, self.plan = self.text == "J", deque()
        if self.abort.level == 0:
            self.endless = False
            self.axis.log.stop()
            return
        self.face()
        if self.text == "O":
            self.plan.append(self.step_of(SLEW, len(self.law.periods) - 1, 1))
        elif not self.endless:
            up = self.ramp_up()[: self.number]
            down = [self.step_of(DOWN, step.rate) for step in reversed(up)][: self.number - len(up)]
            self.plan.extend([*up, *[self.top] * (self.number - len(up) - len(down)), *down])

    @property
    def top(self) -> TwinStep:
        """A step at rate R."""
        return self.step_of(SLEW, self.motion_made.rate)

    def coming(self) -> TwinStep | None:
        """Return the next step; None when the motion is over."""
        return self.top if self.endless else super().coming()

    async def should_continue(self, just: TwinStep) -> bool:
        """Return whether the motion continues, which depends on the target, TRIGGER, ABORT, XSS and XDIR."""
        if self.coming() is None:
            return False
        if self.trigger.level == 1:
            self.mark_deviation("event", "TRIGGER")
            await self.chip.polled(self.trigger, 0, self.ticks["inhibit_poll"])
        if self.abort.level == 0:
            self.mark_deviation("command", "ABORT")
            return False
        if self.endless and self.xss.level == 1:
            self.mark_deviation("command", "XSS")
            return False
        if self.face():
            self.mark_deviation("event", "XDIR")
        return True

    def face(self) -> bool:
        """If XDIR is in use, set the direction from it; return whether the direction has changed."""
        before = self.sign
        if self.registers.external:
            self.sign = 1 if self.xdir.level == 1 else -1
        return self.sign != before
