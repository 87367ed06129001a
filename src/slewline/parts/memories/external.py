r"""What a chip reads and writes on a bus of its own: an address latch, and an output that a strobe enables.

select  ----\____________________________/----
ale     _________/--\_______________________      its fall latches the byte on the bus as an address
wr      -----------------\____/-------------      its rise: the byte on the bus is taken, by parts that can be written
rd      -----------------\________/---------      low: what the address selects stands on the bus
db      ==========|= low =|== data ==|

The latch (a 74LS373) listens whoever is selected: one may serve memory, display and switches.
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.memory.image import ERASED
from ...core.time.kernel import Kernel
from ...core.wires.net import Net
from ..base.part import Part

BUS_WIRING = MappingProxyType({"db": "data", "ale": "address_latch", "rd": "read_strobe"})
WRITE_WIRING = MappingProxyType({**BUS_WIRING, "wr": "write_strobe"})


class External(Part):
    """A part that is selected by `select`, and read at the address in its latch."""

    def __init__(self, kernel: Kernel, name: str, selects: str) -> None:
        super().__init__(kernel, name)
        self.low = ERASED  # in the address latch
        self.add_bus("db", "address, then data")
        self.add_pin("select", "in", selects, pull=1, active=0)
        self.add_pin("ale", "in", "its fall latches the low byte of the address", pull=0, active=1)
        self.add_pin("rd", "in", "low, while selected: the part drives the bus", pull=1, active=0)

    def rewired(self) -> None:
        """Start to watch the pins: the part is wired, and time is about to pass."""
        self.pin("select").net.watch(self._select)
        self.pin("ale").net.watch(self._latch)
        self.pin("rd").net.watch(self._show)

    @property
    def selected(self) -> bool:
        """Is the part selected?"""
        return not self.high("select")

    def _latch(self, net: Net) -> None:
        if net.level == 0:
            self.low = self.byte("db")

    def _select(self, net: Net) -> None:
        self._show(net)

    def _show(self, _net: Net) -> None:
        """Drive the bus, or let go of it."""
        byte = self.shown() if self.selected and not self.high("rd") else None
        self.drivers["db"].drive(None if byte is None else (0xFF, byte))

    def shown(self) -> int | None:
        """Return the byte at the address, 0 to 255; None: nobody is at this address, and the bus floats."""
        raise NotImplementedError


class Writable(External):
    """One that takes a byte as well: that on the bus, as `wr` rises."""

    def __init__(self, kernel: Kernel, name: str, selects: str) -> None:
        super().__init__(kernel, name, selects)
        self.add_pin("wr", "in", "its rise, while selected: the byte on the bus is taken", pull=1, active=0)

    def rewired(self) -> None:
        """Start to watch the pins: the part is wired, and time is about to pass."""
        super().rewired()
        self.pin("wr").net.watch(self._write)

    def _write(self, net: Net) -> None:
        if net.level == 1 and self.selected:
            self.written(self.byte("db"))

    def written(self, byte: int) -> None:
        """Take a byte at the address in the latch."""
        raise NotImplementedError
