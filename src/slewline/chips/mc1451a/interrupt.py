"""HostIntrpt: one axis at a time interrupts the host, until RST_INTRPT."""

from __future__ import annotations

from ...core.wires.net import Driver
from .registers import Registers


class HostInterrupt:
    """The interrupt line.  `axis` is the axis whose interrupt is pending; 0 for none."""

    def __init__(self, line: Driver, registers: Registers) -> None:
        self.line, self.registers = line, registers
        self.axis = 0

    def look(self) -> None:
        """If no interrupt is pending, start one for the lowest-numbered axis with an event that its mask enables."""
        if not self.axis:
            for state in self.registers.states:
                if state.interrupts:
                    self.axis = state.number
                    self.line.activate()
                    return

    def end(self) -> None:
        """End the pending interrupt."""
        self.axis = 0
        self.line.deactivate()

    def clear(self) -> None:
        """Handle a reset: clear a pending interrupt.  The line goes high together with all outputs."""
        self.axis = 0
