"""Program text: lines in, statements with places out.  Assembler and linter read the same statements.

A text holds what a host would send, a command a line, each as the dialect of the part has it:

    ; weld.txt                   a comment runs to the end of the line
    R 80                         before program entry: command mode
    E                            program entry begins
    A$N 100                      a label stands directly in front of its instruction, or alone on the line above
    Q                            program entry ends
    @wait 20 ms                  a directive to the host, none of the chip's business

Nothing here raises.  What is wrong with a text becomes a `Problem` with a place, so that all of them can be shown at
once; a statement that the chip would still take is kept beside its problem, so that the
addresses after it are right.
"""

from __future__ import annotations

from dataclasses import replace

from ..core.datasheet.table import Sheet
from .dialect import dialect_of, state_remedy
from .statements import Block, Directive, Source, Statement


def host_lines(text: str) -> list[tuple[int, int, str]]:
    """(line, column, text) of every line that says something, without comment and surrounding blanks."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        code = line.split(";", 1)[0].rstrip()
        body = code.lstrip()
        if body:
            found.append((number, len(code) - len(body) + 1, body))
    return found


def read(text: str, sheet: Sheet, bare: bool = False) -> Source:
    """The whole text, taken apart.

    A text that never enters a program is one stored program if `bare` is set, else it is what a host sends in command
    mode.
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
    _lay_out(source, bare)
    return source


# --------------------------------------------------------------------------------------------------- the programs in it


def _lay_out(source: Source, bare: bool) -> None:
    """Separate programs from command mode, and give the instructions of each program their addresses."""
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
    """A command that does not become part of a program: may it come here?"""
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
            found = f"label {dialect.label(letter)} a second time; the chip would take the last one"
            section = source.sheet.sections.get("labels", "")
            source.report(statement, "label-twice", "error", found, section=section, remedy="use another letter")
        block.labels[letter] = statement.address
    block.statements.append(statement)
    return statement
