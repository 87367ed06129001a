"""Commands of a part by letter, name, line or code."""

from __future__ import annotations

import re

from ..core.table import Row, Sheet
from ..errors import UnknownName
from . import lines, packets
from .dialects import Command

MARK = "$"  # behind the letter of a label


def find(sheet: Sheet, command: str) -> list[Row]:
    """Return the rows of a command, by letter (all forms of it), name, a line that is one, or the code of a packet.

    Raises:
        UnknownName: the part has no such command; the message says which it has.
    """
    for wanted in (command, command.upper()):
        rows = [row for row in sheet.commands if wanted in (row.form, row.name, row.head)]
        if rows:
            return rows
    line = lines.parse(sheet, command) if sheet.in_lines else None
    if isinstance(line, Command):
        return [line.row]
    if sheet.in_packets:
        coded = re.fullmatch(r"(?:0x|\$)?([0-9a-f]{2})", command.lower())
        row = sheet.commands.by_code.get(int(coded[1], 16)) if coded else None
        return [row or packets.row(sheet, "".join(command.split()[:1]))]
    if command in sheet.slips:
        raise UnknownName(f"{sheet.part} has no command {command!r}; {sheet.slips[command]}")
    letters = ", ".join(f"{row.form} ({row.name})" for row in sheet.commands)
    raise UnknownName(f"{sheet.part} has no command {command!r}; it has {letters}")
