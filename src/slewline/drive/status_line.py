"""The state of a drive, as one line for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..core.time.timebase import readable
from .board.wire import DriverFlag

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .drive_state import DrivePath, DriveState


def introduction(state: DriveState, estop: bool) -> str:
    """Return a line for the user that names chip, board and driver.

    Args:
        estop: True if an input of the board is an emergency stop.
    """
    if state.enable:
        power = "the driver is enabled" + "; no input is an E-stop (--input A0=estop)" * (not estop)
    elif state.config.driver & DriverFlag.DRY:
        power = "a dry run: no pulses, and the driver stays off, until --enable"
    else:
        power = "a dry run with pulses: the driver stays off, if its ENABLE is wired, until --enable"
    others = [number for number in range(1, len(state.chip.axes) + 1) if number != state.number]
    axis = f", axis {state.number}" if others else ""
    left = f"; not driven: axis {' and '.join(map(str, others))}" if others else ""
    return f"{state.chip.name}{axis} on an {state.board.title}, horizon {readable(state.horizon_ps)}; {power}{left}"


def as_line(state: DriveState, path: DrivePath, on: bool, troubles: Sequence[str]) -> str:
    """Return one line with phase, count, driver, queued time (lead), free slots, round trips and last trouble.

    Args:
        on: whether the driver is enabled.
    """
    trip_ns, worst_ns, _ = path.clock.round_trip_ns
    count = None if state.phase == "unknown" else path.link.counted
    lead = max((path.feeder.base16 >> 16) - path.clock.ticks(path.wall()), 0)
    parts = [
        f"board {state.phase} at {'?' if count is None else count}{'' if state.known else ', position unknown'}",
        f"driver {'on' if on else 'off'}",
        f"lead {lead * 1000 / state.board.hz:.0f} ms",
        f"{path.link.free} of {state.board.slots} slots free",
        f"{trip_ns / 1e6:.1f} ms round trip, worst {worst_ns / 1e6:.1f}",
    ]
    return " | ".join([*parts, *troubles[-1:]])
