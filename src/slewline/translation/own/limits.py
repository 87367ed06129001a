"""Limits of a part, in words, with references to the part's manual."""

from __future__ import annotations

from ...core.datasheet.roles import ROW_ROLES
from ...core.datasheet.table import Arg, Row, Sheet


def no_command(sheet: Sheet, role: str) -> str:
    """Return a text stating that a part has no command with a given role."""
    return f"no command of the {sheet.part.upper()} {ROW_ROLES[role]} ({sheet.manual})"


def no_pin(sheet: Sheet, role: str, number: int) -> str:
    """Return a text stating how many outputs or inputs (by `role`) a part has, for a program that needs more."""
    has = [pin.name for n in (1, 2, 3) if (pin := sheet.role(f"{role}{n}")) is not None]
    named = f": {', '.join(has)}" if has else ""
    return f"the {sheet.part.upper()} has {len(has)} {role}{'s' * (len(has) != 1)} for programs{named} ({sheet.manual})"


def out_of(sheet: Sheet, row: Row, arg: Arg) -> str:
    """Return a text that states the range of an argument of a command."""
    return f"{row.form} {arg.name} {arg.low}..{arg.high} ({sheet.part.upper()} manual, {row.where})"


def memory(sheet: Sheet) -> str:
    """Return a text that states the size of a part's program memory."""
    manual = f"{sheet.part.upper()} manual, {sheet.buffer_where}"
    return f"the program memory has {sheet.buffer_bytes} {sheet.memory_unit}s ({manual})"
