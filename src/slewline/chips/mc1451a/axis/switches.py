"""The limit switches of one axis: their states, and whether one of them stops the axis."""

from __future__ import annotations

from ....core.context import ChipContext
from ..registers import NEGATIVE_LIMIT, POSITIVE_LIMIT, AxisState, Registers


class LimitSwitches:
    """Both limit switches, each identified by its event bit.  `levels` are those sampled by the present cycle."""

    def __init__(self, chip: ChipContext, registers: Registers, state: AxisState) -> None:
        self.registers, self.state = registers, state
        number = state.number
        self.nets = {
            POSITIVE_LIMIT: chip.pins[f"poslimit{number}"].net,
            NEGATIVE_LIMIT: chip.pins[f"neglimit{number}"].net,
        }
        self.bits = {POSITIVE_LIMIT: 2 * number - 2, NEGATIVE_LIMIT: 2 * number - 1}  # of the sense word
        self.begin()

    def begin(self) -> None:
        """Begin with the levels of this instant, after reset."""
        self.levels = {limit: net.level or 0 for limit, net in self.nets.items()}
        self.armed = {limit: True for limit in self.nets}  # has been inactive since it tripped

    def active(self, limit: int) -> bool:
        """Return whether limit switches are enabled and the given switch is active."""
        registers = self.registers
        return registers.limits_on and bool(self.levels[limit] ^ registers.limit_sense >> self.bits[limit] & 1)

    @property
    def flagged(self) -> bool:
        """True if a switch's event bit is set, which keeps the axis from moving; False if switches are disabled."""
        return self.registers.limits_on and bool(self.state.events & (POSITIVE_LIMIT | NEGATIVE_LIMIT))

    def tripped(self) -> int:
        """Set and return the event bit of a switch that has become active and so stops the axis, or return 0.

        A switch cannot trip while the other switch's event bit is set, or while the other has tripped and is
        active.
        """
        if not self.registers.limits_on:
            self.armed = {POSITIVE_LIMIT: True, NEGATIVE_LIMIT: True}
            return 0
        state, tripped = self.state, 0
        active = {limit: self.active(limit) for limit in self.armed}
        for limit, other in ((POSITIVE_LIMIT, NEGATIVE_LIMIT), (NEGATIVE_LIMIT, POSITIVE_LIMIT)):
            if not active[limit]:
                self.armed[limit] = True
            elif self.armed[limit] and not (state.events & other or (active[other] and not self.armed[other])):
                self.armed[limit] = False
                state.events |= limit
                tripped = limit
        return tripped
