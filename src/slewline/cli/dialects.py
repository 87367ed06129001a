"""Programs that are not for the chip that they were given to: no command in them is one of it, or most are none.

A command that a chip refuses, for its value or at that moment, is a finding, and a run with findings has gone well
unless it is strict.  But where no line of a program is a command of the chip, or most lines are none and another chip
takes them all, the run was not what its user meant: `slewline run` ends with status 1 and says so.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..chips import CATALOGUE, checks_of, sheet_of

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..core.datasheet.table import Sheet

FORM = {"unknown-command", "bad-argument", "bad-number", "extra-argument", "missing-argument", "too-long"}
MOST_NAMED = 3  # chips whose dialect it may be
FEW = 4  # no more than every fourth line is strange to a chip for which a program may be


def foreign(text: str, where: str, chip: str | type[Chip], sheet: Sheet) -> str:
    """Return that a program is not for a chip, and for which it may be; empty: it is.

    Args:
        text: what a host sends, a command a line.
        where: the name of the program, whose ending may name a chip.
        chip: what it was given to.
        sheet: of that chip.
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
        "no line of it is a command" if wrong == lines else f"{len(wrong)} of its {len(lines)} lines are no commands"
    )
    like = f"  It looks like a program for the {' or '.join(found)}." if found else ""
    return f"{where}: {count} of the {sheet.part}.{like}"


def commands(text: str, sheet: Sheet) -> set[int]:
    """Return the lines of a text that a host sends."""
    from ..language.dialect import dialect_of
    from ..language.source import host_lines

    directs = dialect_of(sheet).directs
    return {number for number, _, line in host_lines(text) if not line.startswith("@") and not directs(line)}


def strange(text: str, sheet: Sheet, part: str | type[Chip]) -> set[int]:
    """Return the lines of a text that are no commands of a part, whatever their values and the state of the chip."""
    from ..language.lint import lint

    found = lint(text, sheet, checks_of(part, sheet))
    return {problem.line for problem in found if problem.severity == "error" and problem.code in FORM}


def meant(text: str, where: str, given: str) -> list[str]:
    """Return the parts to which the fewest lines are strange, if these are few; if the file is named for one, that."""
    counts = {part: len(strange(text, sheet_of(part), part)) for part in CATALOGUE.ours if part != given}
    least, lines = min(counts.values()), len(commands(text, sheet_of(given)))
    if FEW * least > lines:
        return []
    found = [part for part, count in counts.items() if count == least]
    own = Path(where).suffix[1:].lower()
    return [own] if own in found else found[:MOST_NAMED]
