"""The state of a drive, in a line for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..core.time.timebase import PS_PER_S, readable

if TYPE_CHECKING:
    from .drive import Drive


def introduction(drive: Drive) -> str:
    """Return what is driven, for the user."""
    power = "the driver is enabled" if drive.enable else "a dry run: the driver stays off, until --enable"
    return f"{drive.chip.name} on an {drive.board.title}, {readable(drive.horizon_ps)} ahead; {power}"


def lead_ps(drive: Drive) -> int:
    """Return for how long the board has something to do (ps)."""
    return max((drive.feeder.base16 >> 16) - drive.clock.ticks(drive.wall()), 0) * PS_PER_S // drive.board.hz


def as_line(drive: Drive) -> str:
    """Return the state: lead, credit, round trips, and the last trouble."""
    trip_ns, worst_ns, _ = drive.clock.round_trip_ns
    count = None if drive.state == "unknown" else drive.link.counted
    parts = [
        f"board {drive.state} at {'?' if count is None else count}",
        f"lead {lead_ps(drive) / 1e9:.0f} ms",
        f"{drive.link.free} of {drive.board.slots} slots free",
        f"{trip_ns / 1e6:.1f} ms there and back, worst {worst_ns / 1e6:.1f}",
    ]
    return " | ".join([*parts, *drive.troubles[-1:]])
