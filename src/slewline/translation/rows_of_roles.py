"""The commands of a part, by their roles."""

from __future__ import annotations

from collections.abc import Iterable

from ..core.datasheet.table import Row, Sheet

PROFILE_ROLES = ("start_rate", "top_rate", "ramp", "ramp_divisor", "rate_divisor")


def takes_part(row: Row, parameters: Iterable[str]) -> bool:
    """Return whether a command sets a parameter of a ramp, by its role or as one of `parameters`."""
    return bool(row.args) and (row.role in PROFILE_ROLES or row.form in parameters)


def leads(row: Row) -> bool:
    """Return whether a command can make a program continue at another place: a jump, a loop or a branch."""
    return row.role in ("jump", "loop") or row.role.startswith("branch")


def rows_by_role(sheet: Sheet) -> dict[str, Row]:
    """Return the command for each role; if several commands share a role, the first of them."""
    return {row.role: row for row in reversed(list(sheet.commands)) if row.role}


def after_reset(sheet: Sheet) -> int:
    """Return the direction after a reset: 1 clockwise, -1 counterclockwise."""
    pin = sheet.role("direction")
    return 1 if pin is None or pin.reset == pin.sense else -1


def stopping_row(sheet: Sheet, how: str) -> Row | None:
    """Return the command that stops a running motor in the way `how`, "stop" or "brake"; None: there is none."""
    return next((row for row in sheet.commands if row.at_once == how), None)


def waits_for_update(row: Row) -> bool:
    """Return whether a command stops a motion only when the next update takes effect."""
    return bool(row.at_once) and getattr(row, "buffered", False)
