r"""The local bus of a chip: an address latch, and an output enabled by a strobe.

select  ----\____________________________/----    falling: latches the high byte of an address
ale     _________/--\_______________________      falling: latches the low byte of an address
wr      -----------------\____/-------------      rising: the byte on the bus is written to a writable part
rd      -----------------\________/---------      low: the addressed byte is on the bus
db      ==========|= low =|== data ==|

The latch (a 74LS373) serves whichever part is selected, so memory, display and switches may share one latch.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol

from ...core.memory.image import ERASED

if TYPE_CHECKING:
    from ...core.wires.net import Net
    from ..base.part import Part

BUS_WIRING = MappingProxyType({"db": "data", "ale": "address_latch", "rd": "read_strobe"})
WRITE_WIRING = MappingProxyType({**BUS_WIRING, "wr": "write_strobe"})


class HasBus(Protocol):
    """A part on the local bus."""

    _bus: BusInterface


def start_bus(self: HasBus) -> None:
    """Start to follow the pins, now that the part is wired."""
    self._bus.start()


class BusInterface:
    """The local-bus pins of a part, its address latches, and its bus driver.

    Args:
        part: the part, to which the pins are added.
        selects: a description of the effect of a low `select`.
        read: returns the byte at the address, 0 to 255; None: no byte at this address, and the bus floats.
        write: called with each byte written to the address; None: the part cannot be written.
        on_latch: called when `ale` has changed; its falling edge has latched the low byte of an address.
        on_select: called when `select` has changed, before the part drives or releases the bus.
    """

    def __init__(
        self,
        part: Part,
        selects: str,
        read: Callable[[], int | None],
        write: Callable[[int], None] | None = None,
        *,
        on_latch: Callable[[], None] | None = None,
        on_select: Callable[[], None] | None = None,
    ) -> None:
        self.part, self.read, self.write, self._on_latch, self._on_select = part, read, write, on_latch, on_select
        self.high = self.low = ERASED  # held in the address latches
        part.add_bus("db", "address, then data")
        part.add_pin("select", "in", selects, pull=1, active=0)
        part.add_pin("ale", "in", "falling: latches the low byte of the address", pull=0, active=1)
        part.add_pin("rd", "in", "low, while selected: the part drives the bus", pull=1, active=0)
        self.watches: list[tuple[Net, Callable[[Net], object]]] = [
            (part.net("select"), self._select),
            (part.net("ale"), self._latch),
            (part.net("rd"), self.show),
        ]
        if write is not None:
            part.add_pin("wr", "in", "rising, while selected: the byte on the bus is written", pull=1, active=0)
            self.watches.append((part.net("wr"), self._take))
        self.driver = part.drivers["db"]

    def start(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        for net, observer in self.watches:
            net.watch(observer)
        self.part.net("ale").ends = (self,)

    def changes(self) -> None:
        """Withdraw any exchange on the bus, because it was computed from contents that are about to change."""
        if (exchange := self.part.net("db").exchange) is not None:
            exchange.withdraw()

    @property
    def by_address(self) -> bool:
        """True if neither `on_latch` nor `on_select` was passed, so that only the latched address matters."""
        return self._on_latch is None and self._on_select is None

    @property
    def select(self) -> Net:
        """Net that selects the part."""
        return self.part.net("select")

    @property
    def address(self) -> int:
        """Address in the two latches, 0 to 65535."""
        return self.high << 8 | self.low

    @property
    def selected(self) -> bool:
        """True while the part is selected."""
        return self.select.is_active

    def _latch(self, net: Net) -> None:
        if net.is_inactive:
            self.low = self.part.byte("db")
        if self._on_latch is not None:
            self._on_latch()

    def _select(self, net: Net) -> None:
        self.changes()
        if net.is_active:
            self.high = self.part.byte("db")
        if self._on_select is not None:
            self._on_select()
        self.show()

    def show(self, _net: Net | None = None) -> None:
        """Put the addressed byte on the bus if the part is selected and `rd` is low; otherwise release the bus."""
        byte = self.read() if self.selected and self.part.net("rd").is_active else None
        self.part.drivers["db"].drive(None if byte is None else (0xFF, byte))

    def _take(self, net: Net) -> None:
        self.changes()  # another driver strobes in the middle of a read
        if net.is_inactive and self.selected and self.write is not None:
            self.write(self.part.byte("db"))
