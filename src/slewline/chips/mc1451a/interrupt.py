"""HostIntrpt: one axis at a time asks for the host, and keeps asking until RST_INTRPT."""

from __future__ import annotations

from ...core.wires.net import Driver
from .registers import Registers


class HostInterrupt:
    """The interrupt line.  `axis` is the one whose interrupt is pending; 0: none."""

    def __init__(self, line: Driver, registers: Registers) -> None:
        self.line, self.registers = line, registers
        self.axis = 0

    def look(self) -> None:
        """With no interrupt pending, let the lowest axis with an event that its mask lets through interrupt."""
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
        """Reset: none is pending.  The line goes high with all outputs."""
        self.axis = 0
