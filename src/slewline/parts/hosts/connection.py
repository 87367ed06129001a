"""A host's view of a chip: its data sheet, the wires on its board, and its strap settings; never the chip itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...core.time.timebase import Clock

if TYPE_CHECKING:
    from ...core.datasheet.channel import Channel
    from ...core.datasheet.table import Sheet
    from ...core.wires.net import Bus
    from ...core.wires.pin import Terminal
    from ...core.wires.serial import Straps


@dataclass(frozen=True, slots=True, kw_only=True)
class Connection:
    """A chip as seen by a host that is wired to it over a channel.

    Attributes:
        name: the name of the chip.
        sheet: its data sheet.
        channel: the channel between host and chip.
        pins: its pins, by name.
        crystal_hz: the frequency of its crystal, Hz.
        bus: its data bus.
        straps: the straps of a chip on a serial line; None on other channels.
        up_ps: the instant at which its supply was last switched on, ps.
    """

    name: str
    sheet: Sheet
    channel: Channel
    pins: Mapping[str, Terminal]
    crystal_hz: int
    bus: Bus
    straps: Straps | None = None
    up_ps: int = 0

    @property
    def clock(self) -> Clock:
        """The clock of the crystal."""
        return Clock(self.crystal_hz)
