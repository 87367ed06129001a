r"""HOME: seek the edge of a sensor, always from the same side.

    pattern   _________/‾‾‾‾‾‾‾‾‾‾‾     no match at first: clockwise until it matches; that edge is position 0
                  ---->|
              _________/‾‾‾‾‾‾‾‾‾‾‾     a match at first: counter-clockwise until there is none, then as above
                     |<-----------
                     ->|

The pattern (of the pins that H selects) is sampled as each step ends.  The steps are made at a twentieth
of the first rate.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping

from ....core.context import ChipContext
from ....core.motion.plan import Plan
from ....core.wires.net import Net
from ...cy5xx.stepping.motion import STOP
from .. import profile, sheet
from ..ideal import Single
from ..interfaces.user_bits import UserBits
from ..profile import Law
from ..registers import Registers
from .motion import Stepping
from .pulse_outputs import StepOutputs


class Home(Stepping):
    """The homing run of the command H.

    Args:
        shown: a function that writes the position to the display, if the mode register selects this.
        bits: the user bits, to which the sensor is connected.
    """

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
        """Seek the edge at which the pins begin to match an argument; return when STOPPED is high again.

        The position becomes 0 at this edge; if a limit ends the seek, it is the old position plus the steps
        made.
        """
        try:
            await self._seek(argument)
        finally:
            self._step_toward(0)

    def _step_toward(self, direction: int) -> None:
        """Record the direction of the seek: 1 to reach a match, -1 to leave it, 0 when the seek is over.

        Also record the pin and the level that are sought.
        """
        self.axis.homing = direction
        self.axis.sought = self.bits.single(self.argument, direction > 0) if direction else None

    async def _seek(self, argument: int) -> None:
        chip, outputs = self.chip, self.outputs
        self.moving, self.text, self.argument, self.limited = True, f"H {argument}", argument, False
        single = Single(chip.crystal_hz, self.registers.values["firstrate"], self.law)
        inside = self.matches
        outputs.begin(self.text, single.parameters, -1 if inside else 1)
        outputs.turn(not inside)
        self._step_toward(-1 if inside else 1)
        await chip.ticks(max(self.ticks["first_step"] - self.lead, 0))
        if self.refused():
            self.over()
            return
        chip.waits(f"{self.text} seeks its edge")
        self.inside = inside
        await self.set_out()
        await self.play(profile.steady(single.period))
        if inside and not self.limited:
            self.inside = False
            outputs.turn(True)
            self._step_toward(1)
            await self.set_out()
            if not self.refused():
                await self.play(profile.steady(single.period))
        if not self.limited:
            self.axis.load(0)
            self.axis.log.mark("home", self.text)
        await self.come_to_rest("done")

    @property
    def matches(self) -> bool:
        """True while the user bits match the argument of H."""
        return self.bits.matches(self.argument)

    @property
    def each(self) -> bool:
        """True if every step must be processed individually, because the position is shown after each step."""
        return self.registers.has(sheet.MB_SHOW)

    def watched(self) -> list[tuple[Net, int | None]]:  # type: ignore[override]
        """Return the inputs whose changes matter now, each with the new level that would matter.

        The sensor pins are included with None, because any change of them matters.
        """
        return [*super().watched(), *((net, None) for net in self.bits.nets(self.argument))]

    async def look(self, plan: Plan, step: int) -> Plan:
        """Show the position, then sample the sensor and the limit before a step; return the plan (empty to stop)."""
        await self.shown()
        if self.matches is not self.inside:
            return STOP
        return STOP if self.refused() else plan
