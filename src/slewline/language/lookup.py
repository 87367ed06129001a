"""The lookup of a part's commands by letter, name, line or packet code."""

from __future__ import annotations

from ..core.datasheet.table import Row, Sheet
from ..core.messages.near import hint
from ..errors import UnknownName
from .dialect import dialect_of

SIGNED = "±"  # used in forms, but not on keyboards


def find(sheet: Sheet, command: str) -> list[Row]:
    """Return the rows of a command in the command table.

    The command is given by its letter (which stands for all its forms), its name, a line that contains it,
    or its packet code.

    Raises:
        UnknownName: the part has no such command; the message lists the commands of the part.
    """
    for wanted in (command, command.upper(), command.replace("+", SIGNED).replace("-", SIGNED)):
        rows = [row for row in sheet.commands if wanted in (row.form, row.name, row.head)]
        if rows:
            return rows
    rows = dialect_of(sheet).meant(sheet, command)
    if rows:
        return rows
    word = command.split(maxsplit=1)[0] if command.strip() else command
    if word != command and any(word in (row.form, row.name, row.head) for row in sheet.commands):
        return find(sheet, word)  # R 100: the command, without its argument
    if command in sheet.slips:
        raise UnknownName(f"{sheet.part} has no command {command!r}; {sheet.slips[command]}")
    letters = ", ".join(f"{row.form} ({row.name})" for row in sheet.commands)
    near = hint(command, [name for row in sheet.commands for name in (row.form, row.name)])
    raise UnknownName(f"{sheet.part} has no command {command!r}; it has {letters}{near}")
