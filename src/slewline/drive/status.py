"""The state of a drive, in a line for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..core.time.timebase import PS_PER_S, readable
from .board.wire import DriverFlag

if TYPE_CHECKING:
    from .drive import Drive


def introduction(drive: Drive) -> str:
    """Return what is driven, for the user."""
    if drive.enable:
        power = "the driver is enabled"
    elif drive.config.driver & DriverFlag.DRY:
        power = "a dry run: no pulses, and the driver stays off, until --enable"
    else:
        power = "a dry run with pulses: the driver stays off, if its ENABLE is wired, until --enable"
    others = [number for number in range(1, len(drive.chip.axes) + 1) if number != drive.axis_number]
    axis = f", axis {drive.axis_number}" if others else ""
    left = f"; not driven: axis {' and '.join(map(str, others))}" if others else ""
    return f"{drive.chip.name}{axis} on an {drive.board.title}, {readable(drive.horizon_ps)} ahead; {power}{left}"


def lead_ps(drive: Drive) -> int:
    """Return for how long the board has something to do (ps)."""
    return max((drive.feeder.base16 >> 16) - drive.clock.ticks(drive.wall()), 0) * PS_PER_S // drive.board.hz


def as_line(drive: Drive) -> str:
    """Return the state: lead, credit, round trips, and the last trouble."""
    trip_ns, worst_ns, _ = drive.clock.round_trip_ns
    count = None if drive.state == "unknown" else drive.link.counted
    parts = [
        f"board {drive.state} at {'?' if count is None else count}{'' if drive.power.known else ', position unknown'}",
        f"driver {'on' if drive.power.on else 'off'}",
        f"lead {lead_ps(drive) / 1e9:.0f} ms",
        f"{drive.link.free} of {drive.board.slots} slots free",
        f"{trip_ns / 1e6:.1f} ms there and back, worst {worst_ns / 1e6:.1f}",
    ]
    return " | ".join([*parts, *drive.troubles[-1:]])
