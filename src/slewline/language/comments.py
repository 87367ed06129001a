"""Comments that look like commands: a second command on a line, after a semicolon, is not sent."""

from __future__ import annotations

from ..core.datasheet.table import Sheet
from .dialect import dialect_of
from .problems import Problem
from .statements import Source, Statement

COMMENT = "comment"  # the code of these problems, and of the finding of a host that plays such a text
STILL_COMMANDS = ("range", "spacing")  # problems of what is a command all the same


def commented(text: str, sheet: Sheet) -> list[Problem]:
    """Return a warning for each line with a command whose comment is commands of the part, and nothing else.

    A line that is a comment as a whole is a command that somebody has switched off: it is meant.
    """
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        code, semicolon, comment = line.partition(";")
        parts = [part.strip() for part in comment.split(";") if part.strip()]
        if not (semicolon and code.strip() and parts and not code.lstrip().startswith("@")):
            continue
        if all(_is_command(part, sheet) for part in parts):
            place = number, len(code) + 1, len(line.rstrip()) - len(code)
            says = f"{'; '.join(parts)} after a semicolon is a comment, and is not sent"
            found.append(Problem(*place, COMMENT, "warning", says, remedy="write one command a line"))
    return found


def _is_command(text: str, sheet: Sheet) -> bool:
    """Return whether a text is a command of a part, as it is written; a word in small letters is a word."""
    source = Source(sheet)
    labels = dialect_of(sheet).reader(source, 1, 1, text).take(())
    if labels or not all(isinstance(item, Statement) for item in source.items):
        return False
    wrong = any(problem.severity == "error" and problem.code not in STILL_COMMANDS for problem in source.problems)
    operands = any(statement.operands for statement in source.statements)
    return bool(source.statements) and not wrong and (operands or text.isupper())
