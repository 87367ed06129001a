"""Detection of programs that were written for another chip.

A command that a chip refuses, because of its value or the chip's state, is a finding; a run with
findings succeeds unless --strict is given.  But if either no line is a command of the chip, or most
lines are not commands of it and every line is a command of another chip, the program is for another
chip: `slewline run` ends with status 1.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..chips import CATALOGUE, checks_of, sheet_of

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..core.datasheet.table import Sheet

FORM = {"unknown-command", "bad-argument", "bad-number", "extra-argument", "missing-argument", "too-long"}
MOST_NAMED = 3  # chips that a program may be for
FEW = 4  # a program may be for a chip if the chip knows at least three of every four lines


def foreign(text: str, where: str, chip: str | type[Chip], sheet: Sheet) -> str:
    """Return a message if a program is for another chip, naming any likely chips; otherwise return "".

    Args:
        text: the text that a host sends, one command per line.
        where: the name of the program, whose extension may name a chip.
        chip: the chip that received the program.
        sheet: the sheet of that chip.
    """
    if where.lower().endswith(".hex"):
        return ""
    lines = commands(text, sheet)
    wrong = strange(text, sheet, chip) & lines
    if 2 * len(wrong) <= len(lines):
        return ""
    found = meant(text, where, sheet.part)
    if wrong != lines and not any(not strange(text, sheet_of(part), part) for part in found):
        return ""
    count = (
        "none of its lines is a command"
        if wrong == lines
        else f"{len(wrong)} of its {len(lines)} lines are not commands"
    )
    like = f"  It looks like a program for the {' or '.join(found)}." if found else ""
    return f"{where}: {count} of the {sheet.part}.{like}"


def commands(text: str, sheet: Sheet) -> set[int]:
    """Return the line numbers of the commands in a text: the lines that a host would send to the chip."""
    from ..language.dialect import dialect_of
    from ..language.source import host_lines

    directs = dialect_of(sheet).directs
    return {number for number, _, line in host_lines(text) if not line.startswith("@") and not directs(line)}


def strange(text: str, sheet: Sheet, part: str | type[Chip]) -> set[int]:
    """Return the numbers of the lines that are not commands of a part, whatever their values and the chip's state."""
    from ..language.lint import lint

    found = lint(text, sheet, checks_of(part, sheet))
    return {problem.line for problem in found if problem.severity == "error" and problem.code in FORM}


def meant(text: str, where: str, given: str) -> list[str]:
    """Return the parts, except the `given` one, with the fewest unknown lines; at most three parts.

    If one of them is the part that the file extension names, return only that one.  Return [] if more than a
    quarter of the lines are unknown to every part.
    """
    counts = {part: len(strange(text, sheet_of(part), part)) for part in CATALOGUE.ours if part != given}
    least, lines = min(counts.values()), len(commands(text, sheet_of(given)))
    if FEW * least > lines:
        return []
    found = [part for part, count in counts.items() if count == least]
    own = Path(where).suffix[1:].lower()
    return [own] if own in found else found[:MOST_NAMED]
