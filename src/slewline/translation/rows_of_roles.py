"""Functions that find the commands of a part by their roles, and functions that test single commands."""

from __future__ import annotations

from collections.abc import Iterable

from ..core.datasheet.table import Row, Sheet

PROFILE_ROLES = ("start_rate", "top_rate", "ramp", "ramp_divisor", "rate_divisor")


def takes_part(row: Row, parameters: Iterable[str]) -> bool:
    """Return whether a command sets a rate or ramp value.

    Such a command has an argument, and either the role of a rate or a ramp, or a form in `parameters`.
    """
    return bool(row.args) and (row.role in PROFILE_ROLES or row.form in parameters)


def leads(row: Row) -> bool:
    """Return whether a command can make a program continue at another place: a jump, a loop or a branch."""
    return row.role in ("jump", "loop") or row.role.startswith("branch")


def rows_by_role(sheet: Sheet) -> dict[str, Row]:
    """Return a part's commands by their role; if several commands have the same role, the first of them."""
    return {row.role: row for row in reversed(list(sheet.commands)) if row.role}


def after_reset(sheet: Sheet) -> int:
    """Return the direction of the motor after a reset of the part: 1 clockwise, -1 counterclockwise."""
    pin = sheet.role("direction")
    return 1 if pin is None or pin.reset == pin.sense else -1


def stopping_row(sheet: Sheet, how: str) -> Row | None:
    """Return the command that stops a running motor by "stop" or "brake" (`how`); None if there is none."""
    return next((row for row in sheet.commands if row.at_once == how), None)


def waits_for_update(row: Row) -> bool:
    """Return whether a command stops a motion only when the next update takes effect."""
    return bool(row.at_once) and getattr(row, "buffered", False)
