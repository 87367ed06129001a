"""An ISA bus cycle as an operation on the host port of a chipset (the timing diagram is in isa.py)."""

from __future__ import annotations

from ...core.wires.wave import Edges
from ..base.operation import Strobed, Strobes
from .board import CLOCK_PS, CYCLE

WRITES, READS = (2, 3), (1, 5)  # clocks at which HostWrite and HostRead fall, and rise
TAKES, LEAVES = 1, 5  # clocks at which a byte to be written is put on the bus, and removed
BUS = Strobes()


class IsaCycle(Strobed):
    """A one-byte operation: a bus cycle that begins at the instant `began` (ps)."""

    __slots__ = ("began",)

    def __init__(self, began: int, reading: bool) -> None:
        super().__init__(began, 1, BUS)
        first, last = READS if reading else WRITES
        self.began = began
        self.start = began + CLOCK_PS // 2  # the address is on the bus from this instant to the end of the cycle
        self.first, self.last, self.end = began + first * CLOCK_PS, began + last * CLOCK_PS, began + CYCLE * CLOCK_PS

    @property
    def falls(self) -> list[int]:
        """Instant at which the strobe falls (ps), in a list."""
        return [self.first]

    @property
    def rises(self) -> list[int]:
        return [self.last]

    def bus(self, data: bytes) -> Edges:
        """Return the edges of the data bus in a cycle that writes a byte."""
        return None, (self.began + TAKES * CLOCK_PS, self.began + LEAVES * CLOCK_PS), ((0xFF, data[0]), None)
