"""Lint rules for programs: their start and end, loops, labels and pages."""

from __future__ import annotations

from collections.abc import Iterator

from ..assemble import units
from ..dialect import Check, spoken_as
from ..lint import branches, reached, section
from ..statements import Source, Statement
from . import live_rules
from .forms import TextDialect
from .live_rules import listed

FURTHEST = ("nt", "n0", "t", "0")  # branches, in the order of remedies: conditional ones first


def ends(source: Source) -> None:
    """Report a program that may run past its last instruction."""
    rows = source.sheet.commands
    stop = listed(source.sheet.acting("stop"))
    again = listed(sorted((row for row in rows if row.stored and row.flow in ("0", "t")), key=lambda row: row.flow))
    remedy = ", or ".join([*([f"end with {stop}"] if stop else []), *([f"repeat with {again}"] if again else [])])
    for block in source.blocks:
        last = block.statements[-1] if block.statements else None
        if last is not None and "n" in last.row.flow and last.address in reached(source, block):
            unit = units(source.sheet).removesuffix("s")
            found = f"the program runs past its last {unit}, at address {block.end - 1}"
            source.report(last, "no-end", "warning", found, section=section(last.row), remedy=remedy)


def nested(source: Source) -> Iterator[tuple[Statement, Statement]]:
    """Yield pairs of loops, outer and inner: every loop, with each of the loops inside it."""
    for block in source.blocks:
        counted = [statement for statement in block.statements if statement.row.role == "loop"]
        for outer in counted:
            begin = block.address_of(outer.target) if outer.target else None
            if begin is not None:
                yield from ((outer, inner) for inner in counted if begin <= inner.address < outer.address)


def loops(source: Source) -> None:
    """Report loops that run only once, and nested loops, since the part has only one loop count."""
    others = [row for row in source.sheet.commands if row.stored and row.flow in FURTHEST and row.role != "loop"]
    alternatives = listed(sorted(others, key=lambda row: FURTHEST.index(row.flow)))
    for outer, inner in nested(source):
        found, remedy = f"the loop of line {inner.line} is inside this one", f"repeat the outer one with {alternatives}"
        about = f"{section(outer.row)} {outer.row.form}"
        source.report(outer, "nested-loop", "warning", found, section=about, remedy=remedy)
    for block in source.blocks:
        for loop in block.statements:
            if loop.row.role == "loop" and loop.values[0] == 1:
                about = f"{section(loop.row)} {loop.row.form}"
                source.report(loop.operands[0], "loop-once", "warning", "this loop runs only once", section=about)


def kinds_of_loops(source: Source) -> None:
    """Report a loop inside a loop of the same kind, since the part has only one count for each kind."""
    for outer, inner in nested(source):
        if inner.row is outer.row:
            found = f"the loop of line {inner.line} is inside this one, and has the same count"
            remedy = "repeat one of the two with the other kind of loop"
            source.report(outer, "nested-loop", "warning", found, section=section(outer.row), remedy=remedy)


def pages(source: Source) -> None:
    """Report branches at the end of a page, if they have a one-byte address: they branch into the next page."""
    page = spoken_as(source.sheet, TextDialect).page
    for block in source.blocks:
        for statement in block.statements:
            near = statement.target is not None and statement.row.args[-1].size == 1
            if near and statement.address // page != statement.end // page:
                found = f"{statement.text} ends at the end of a page: it branches into page {statement.end // page}"
                remedy, about = "a branch with an address of two bytes reaches any page", section(statement.row)
                source.report(statement, "page-crossed", "warning", found, section=about, remedy=remedy)


def misplaced(source: Source) -> None:
    """Report commands that have little effect where they are."""
    enter, leave = source.sheet.enter, listed(source.sheet.leave)
    for statement in source.statements:
        inside, row = statement.block >= 0, statement.row
        if inside and row.role == "enter":
            found = f"{row.form} inside a program is stored, and skipped when it is executed"
            remedy = f"close the program with {leave}"
            source.report(statement, "enter-inside", "warning", found, section=row.where, remedy=remedy)
        elif inside and row.role == "read":
            found = f"{row.form} inside a program only moves the read pointer"
            remedy = f"send {row.form} in command mode"
            source.report(statement, "verify-inside", "warning", found, section=row.where, remedy=remedy)
        elif not inside and row.flow in ("nt", "n0"):
            found = f"{row.name} is in command mode, but belongs in a program"
            source.report(statement, "branch-in-command-mode", "warning", found, section=row.where)
        elif row.role == "leave" and not any(block.quit is statement for block in source.blocks) and enter is not None:
            found = f"{row.form} without {enter.form} before it"
            source.report(statement, "quit-outside", "warning", found, section=row.where)


def entries(source: Source) -> None:
    """Report unused labels, and programs without a command that ends their entry."""
    used = {(id(block), target.label) for _, target, block in branches(source)}
    leave, about_labels = listed(source.sheet.leave), source.sheet.sections.get("labels", "")
    for block in source.blocks:
        if block.quit is None and block.entry is not None:
            found = f"a program without {leave}: all lines after it are stored"
            remedy = f"write {leave} after its last instruction"
            source.report(block.entry, "no-quit", "warning", found, section=block.entry.row.where, remedy=remedy)
        for statement in block.statements:
            for letter in statement.labels:
                if (id(block), letter) not in used:
                    found = f"nothing branches to {letter}"
                    source.report(statement, "unused-label", "note", found, section=about_labels)


FOR_TOKENS: tuple[Check, ...] = (ends, loops, misplaced, entries, live_rules.live, live_rules.course)
FOR_TEXT: tuple[Check, ...] = (ends, kinds_of_loops, pages, misplaced, entries)
