"""Comments that look like commands, and are not sent; and comments of other languages, which are sent."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from ..core.datasheet.table import Sheet
from .dialect import dialect_of
from .problems import Problem
from .statements import Source, Statement

COMMENT = "comment"  # the code of these problems, and of the finding of a host that plays such a text
# with which comments of other languages begin; a # alone is an argument of the CY545
MARK = re.compile(r"(?:^\s*(?=[#%])|(?<=\s)(?=[#%]\s+\S)|(?:^|(?<=\s))(?=//|/\*))[#%/]")
BEGINS = "a comment begins with ;"
STILL_COMMANDS = ("range", "spacing")  # problems of what is a command all the same


def commented(text: str, sheet: Sheet) -> list[Problem]:
    """Return a warning for each line with a command whose comment is commands of the part, and nothing else.

    Another one for each line with what is a comment in other languages.

    A line that is a comment as a whole is a command that somebody has switched off: it is meant.
    """
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        code, semicolon, comment = line.partition(";")
        parts = [part.strip() for part in comment.split(";") if part.strip()]
        if found_mark := _mark(code):
            at = found_mark.end() - 1
            place = number, at + 1, len(code.rstrip()) - at
            says = f"{code[at:].rstrip()} is sent to the part"
            found.append(Problem(*place, COMMENT, "warning", says, remedy=BEGINS))
        if not (semicolon and code.strip() and parts and not code.lstrip().startswith("@")):
            continue
        if all(_is_command(part, sheet) for part in parts):
            place = number, len(code) + 1, len(line.rstrip()) - len(code)
            says = f"{'; '.join(parts)} after a semicolon is a comment, and is not sent"
            found.append(Problem(*place, COMMENT, "warning", says, remedy="write one command a line"))
    return found


def mended(problems: Iterable[Problem], text: str) -> list[Problem]:
    """Return problems with the remedy of those lines that have a comment of another language."""
    lines = [line.partition(";")[0] for line in text.splitlines()]
    return [
        replace(problem, remedy=BEGINS)
        if problem.severity == "error" and 0 < problem.line <= len(lines) and _mark(lines[problem.line - 1])
        else problem
        for problem in problems
    ]


def _mark(code: str) -> re.Match[str] | None:
    """Return where a comment of another language begins; in a string of a part, and after @, it is none."""
    return None if '"' in code or code.lstrip().startswith("@") else MARK.search(code)


def _is_command(text: str, sheet: Sheet) -> bool:
    """Return whether a text is a command of a part, as it is written; a word in small letters is a word."""
    source = Source(sheet)
    labels = dialect_of(sheet).reader(source, 1, 1, text).take(())
    if labels or not all(isinstance(item, Statement) for item in source.items):
        return False
    wrong = any(problem.severity == "error" and problem.code not in STILL_COMMANDS for problem in source.problems)
    operands = any(statement.operands for statement in source.statements)
    return bool(source.statements) and not wrong and (operands or text.isupper())
