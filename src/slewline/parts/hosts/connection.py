"""What a host is handed of a chip: its sheet, the wires of its board, and what the straps on it say; never the chip."""

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
    """A chip that is reached over a channel, as a host that is wired to its board sees it.

    Attributes:
        name: of the chip.
        sheet: its data sheet.
        channel: over which it is reached.
        pins: the wires, by the names of the pins.
        crystal_hz: of the crystal on its board.
        bus: the wires of the data bus.
        straps: what a chip on a serial line is strapped for.
        up_ps: when it was switched on last, ps; the host is informed when it is again.
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
