"""Program text: lines in, statements with places out.  The assembler and the linter read the same statements.

A text contains a host's input, one command per line, each in the part's dialect:

    ; weld.txt                   a comment runs to the end of the line
    R 80                         before program entry: command mode
    E                            program entry begins
    A$N 100                      a label is directly before its instruction, or alone on the line above it
    Q                            program entry ends
    @wait 20 ms                  a directive to the host, not for the chip

No function here raises.  Each problem in a text becomes a `Problem` with a place, so that all of them can be shown
together; a statement that the chip would still accept is kept along with its problem, so that the addresses after it
are right.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from ..core.datasheet.table import Sheet
from .dialect import dialect_of, state_remedy
from .problems import Problem
from .statements import Block, Directive, Source, Statement

COMMENT = "comment"  # code of these problems, and of the finding for a host that sends such a text
# start of a comment in other languages; a # at the end of a line may be an argument
MARK = re.compile(r"(?:^\s*(?=[#%])|(?<=\s)(?=[#%]\s+\S)|(?:^|(?<=\s))(?=//|/\*))[#%/]")
BEGINS = "a comment begins with ;"
STILL_COMMANDS = ("range", "spacing")  # problems of text that still is a command


def host_lines(text: str) -> list[tuple[int, int, str]]:
    """Return (line number, column, text) of every line that is neither blank nor only a comment.

    The text excludes the comment at the end of the line, and surrounding spaces.
    """
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        code = line.split(";", 1)[0].rstrip()
        body = code.lstrip()
        if body:
            found.append((number, len(code) - len(body) + 1, body))
    return found


def read(text: str, sheet: Sheet, bare: bool = False) -> Source:
    """Return the whole text, parsed.

    A text without a command that begins program entry is one stored program if `bare` is set; if `bare`
    is not set, it is a host's input in command mode.
    """
    source = Source(sheet)
    dialect = dialect_of(sheet)
    pending: tuple[str, ...] = ()
    line = None
    for number, column, body in host_lines(text):
        if body.startswith("@") or dialect.directs(body):
            source.items.append(Directive(number, column, body))
        else:
            line = dialect.reader(source, number, column, body)
            pending = line.take(pending)
    if line and pending:
        line.end(pending)
    _arrange(source, bare)
    return source


# ------------------------------------------------------------------------------------------------- programs in the text


def _arrange(source: Source, bare: bool) -> None:
    """Separate programs from commands in command mode, and set the address of each instruction in its program."""
    items, source.items = source.items, []
    has_entry = any(isinstance(item, Statement) and item.row.role == "enter" for item in items)
    block = Block() if bare and not has_entry else None
    if block:
        source.blocks.append(block)
    for item in items:
        if isinstance(item, Directive):
            pass
        elif block is not None and item.row.coded:
            item = _place(source, block, item)
        elif item.row.role == "enter":
            block = Block(entry=item, base=dialect_of(source.sheet).start(source.statements))
            source.blocks.append(block)
        elif block is not None and item.row.role == "leave":
            block.quit, block = item, None
        else:
            _outside(source, item, block)
        source.items.append(item)


def _outside(source: Source, item: Statement, block: Block | None) -> None:
    """Report a command that is not stored in a program, if it has a label or is not allowed at that place.

    `block` is the program whose entry the command interrupts; None in command mode.
    """
    row, sheet = item.row, source.sheet
    enter, ends = sheet.enter, " or ".join(row.form for row in sheet.leave)
    if item.labels:
        between = f", between {enter.form} and {ends}" if enter is not None else ""
        remedy = f"labels name instructions of a program{between}"
        section = sheet.sections.get("labels", "")
        source.report(item, "label-outside", "warning", "a label in command mode", section=section, remedy=remedy)
    if block is not None and "p" not in row.when:
        remedy = state_remedy(sheet, entering=True)
        source.report(item, "not-now", "error", f"{item.text} during program entry", section=row.where, remedy=remedy)
    elif block is None and "i" not in row.when and enter is not None:
        remedy = state_remedy(sheet, entering=False)
        source.report(item, "not-now", "error", f"{item.text} outside a program", section=row.where, remedy=remedy)


def _place(source: Source, block: Block, statement: Statement) -> Statement:
    dialect = dialect_of(source.sheet)
    size = len(dialect.stored(statement))
    statement = replace(statement, block=len(source.blocks) - 1, address=block.end, size=size)
    statement = dialect.placed(statement)
    for letter in statement.labels:
        if letter in block.labels:
            found = f"label {dialect.label(letter)} is defined twice; the chip would use the last one"
            section = source.sheet.sections.get("labels", "")
            source.report(statement, "label-twice", "error", found, section=section, remedy="use another letter")
        block.labels[letter] = statement.address
    block.statements.append(statement)
    return statement


# ----------------------------------------------------- comments that look like commands, and those of other languages


def commented(text: str, sheet: Sheet) -> list[Problem]:
    """Return a warning for each line on which a comment after a command contains nothing but commands.

    A line with a comment in the style of another language gets a warning, too.  A line that consists only of
    a comment gets none: the comment is assumed to be a command that was disabled on purpose.
    """
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        code, semicolon, comment = line.partition(";")
        parts = [part.strip() for part in comment.split(";") if part.strip()]
        if found_mark := _mark(code):
            at = found_mark.end() - 1
            place = number, at + 1, len(code.rstrip()) - at
            message = f"{code[at:].rstrip()} is sent to the part"
            found.append(Problem(*place, COMMENT, "warning", message, remedy=BEGINS))
        if not (semicolon and code.strip() and parts and not code.lstrip().startswith("@")):
            continue
        if all(_is_command(part, sheet) for part in parts):
            place = number, len(code) + 1, len(line.rstrip()) - len(code)
            message = f"{'; '.join(parts)} after a semicolon is a comment, and is not sent"
            found.append(Problem(*place, COMMENT, "warning", message, remedy="write one command per line"))
    return found


def mended(problems: Iterable[Problem], text: str) -> list[Problem]:
    """Return the problems; those on lines with a comment in another language's style get another remedy."""
    lines = [line.partition(";")[0] for line in text.splitlines()]
    return [
        replace(problem, remedy=BEGINS)
        if problem.severity == "error" and 0 < problem.line <= len(lines) and _mark(lines[problem.line - 1])
        else problem
        for problem in problems
    ]


def _mark(code: str) -> re.Match[str] | None:
    """Return the mark that starts a comment in the style of another language, or None if there is none.

    A line that contains a quotation mark (for a part that has strings), or begins with @, has no such mark.
    """
    return None if '"' in code or code.lstrip().startswith("@") else MARK.search(code)


def _is_command(text: str, sheet: Sheet) -> bool:
    """Return whether a text consists of commands of a part; commands without arguments must be in upper case."""
    source = Source(sheet)
    labels = dialect_of(sheet).reader(source, 1, 1, text).take(())
    if labels or not all(isinstance(item, Statement) for item in source.items):
        return False
    wrong = any(problem.severity == "error" and problem.code not in STILL_COMMANDS for problem in source.problems)
    operands = any(statement.operands for statement in source.statements)
    return bool(source.statements) and not wrong and (operands or text.isupper())
