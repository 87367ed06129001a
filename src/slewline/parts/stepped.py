"""A part that steps edge by edge: the base of those that do something at each step."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING

from ..core.kernel import Kernel
from ..core.net import Net
from .part import Part

if TYPE_CHECKING:
    from ..core.table import Pin


class Stepped(Part):
    """A step at each fall of PULSE, the way that DIRECTION says."""

    wiring = MappingProxyType({"pulse": "step", "direction": "direction"})
    edge = 0  # the level of PULSE with which a step begins

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("pulse", "in", f"step at each {'rise' if self.edge else 'fall'}", pull=1)
        self.add_pin("direction", "in", "high: clockwise", pull=1)
        self.position = 0  # steps clockwise since the beginning

    def attached(self, own: str, row: Pin) -> None:
        if own == "pulse" and row.active is not None:
            self.edge = row.active

    def rewired(self) -> None:
        self.pin("pulse").net.watch(self._pulsed)

    def _pulsed(self, net: Net) -> None:
        if net.level == self.edge:
            self.stepped(1 if self.high("direction") else -1)

    def stepped(self, sign: int) -> None:
        """The motor takes a step."""
        self.position += sign
