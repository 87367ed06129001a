r"""Motion of the CY500: every input is sampled at the start of each step.

b                              b'
|______________________________|‾‾‾ held ‾‾‾|______     PULSE, high for 16 µs at 6 MHz before each step
|
TRIGGER high delays the step; ABORT low, or XSS high in a jog run (J), ends the motion; XDIR sets the direction
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...core.motion.motions import MotionParameters
from ...core.motion.plan import Plan, plan, tail
from ...core.wires.net import Net
from ..cy5xx.stepping import sloped
from ..cy5xx.stepping.motion import STOP
from . import profile
from .instructions import Registers


def rest(of: Plan, step: int) -> Plan:
    """Return the rest of a plan, beginning with the given step."""
    return plan(*((leg.name, tail(leg.runs, max(step - leg.first, 0))) for leg in of.legs), shortest=of.shortest)


class Motion(sloped.Motion):
    """The player of the plans of profile.py.

    The text of a motion is the command that began it: G, P, O (one step), or J for a jog run.
    """

    registers: Registers
    holder = "trigger"

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.xss, self.xdir = (self.chip.pins[name].net for name in ("xss", "xdir"))

    # -------------------------------------------------------------------------------------------- before the first step
    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        """Load the parameters of this motion (no slope for O and J); return a function that returns them."""
        super().parameters(number)
        if self.text in ("O", "J"):
            self.at_start = self.at_start._replace(slope=0)
        return self.at_start.parameters

    def planned(self) -> Plan:
        """Return the plan of this motion; an empty plan if ABORT is low."""
        if self.abort.is_active:
            return STOP
        self.faces()
        _, rate, slope, factor, number, law = self.at_start
        if self.text == "O":
            return profile.one(law)
        return profile.jog(rate, factor, law) if self.text == "J" else profile.move(number, rate, slope, factor, law)

    # ------------------------------------------------------------------------------------------------- as a step begins
    def watched(self) -> list[tuple[Net, int]]:
        jogs, follows = self.text == "J", self.registers.external
        turned = (self.xdir, 0 if self.sign > 0 else 1)
        return [self.inhibit.when_active, self.abort.when_active, *[self.xss.when_inactive] * jogs, *[turned] * follows]

    def first_sample_after(self, net: Net) -> tuple[int, None]:
        """Return the tick at which the next step starts, and None.

        All inputs are sampled at that tick; None means that no action is taken within a step.
        """
        return self.train.end(self.train.count(self.kernel.now)), None

    async def look(self, plan: Plan, step: int) -> Plan:
        """Sample the inputs before a step begins; return the plan for the rest of the motion (empty to stop)."""
        if step >= plan.steps:
            return plan  # on the target
        if self.inhibit.is_active:
            self.mark_deviation("event", "TRIGGER")
            await self.uninhibited()
            self.chip.waits(self.progress)
        ends = "ABORT" if self.abort.is_active else "XSS" if self.text == "J" and self.xss.is_inactive else ""
        if ends:
            self.mark_deviation("command", ends)
            return STOP
        return rest(plan, step) if self.faces() else plan

    def faces(self) -> bool:
        """If XDIR is in use, set the direction from it; return whether the direction has changed."""
        sign = (1 if self.xdir.level else -1) if self.registers.external else self.sign
        turned = sign != self.sign
        if turned:
            if self.done:
                self.mark_deviation("event", "XDIR")
            self.settle()  # including the steps in the previous direction
            self.sign = sign
        return turned

    @property
    def progress(self) -> str:
        return "in motion (until xss=1)" if self.text == "J" else super().progress
