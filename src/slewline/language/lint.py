"""What is odd about a program text, found without running it.  Never raises, however bad the text is.

The rules here hold for every part that stores programs the CY5xx way and read nothing but its sheet; what only one part
knows (can this ramp reach this rate in this distance?) is handed in as `checks`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ..core.table import Sheet
from .assemble import link
from .problems import Problem, render
from .source import LABELS, Block, Operand, Source, Statement, read

__all__ = ["Check", "Problem", "Source", "branches", "lint", "reached", "render", "steps_on"]

Check = Callable[[Source], None]
"""A rule: looks at the text and reports what it finds with `source.report`."""

ENDS = {"COMMAND", "INITIALIZE"}  # the program is over
AWAY = {"JUMP", "EXECUTE"} | ENDS  # the next instruction is not reached
BRANCHES = "s.3"  # the manual's section about instructions that branch


def lint(text: str, sheet: Sheet, checks: Iterable[Check] = ()) -> list[Problem]:
    """Everything odd in a text, in the order of its places.

    A text without E is taken for a stored program if it holds what makes sense in a program only: a label, a branch
    or the command 0; else for commands of a host.
    """
    source = read(text, sheet)
    if not source.blocks and any(_stored_only(statement) for statement in source.statements):
        source = read(text, sheet, bare=True)
    link(source)
    for check in (*RULES, *checks):
        check(source)
    return sorted(set(source.problems))


def _stored_only(statement: Statement) -> bool:
    return bool(statement.labels) or statement.target is not None or statement.row.code == 0


# ------------------------------------------------------------------------------------------------------- where it goes


def steps_on(block: Block, statement: Statement) -> list[int]:
    """The addresses at which a program may go on after an instruction; the end of the program is one of them."""
    name, target = statement.row.name, statement.target
    found = [] if name in AWAY else [statement.end]
    if name == "EXECUTE":
        found.append(0)
    if target is not None:
        address = block.address_of(target)
        found += [] if address is None else [address]
    return found


def branches(source: Source) -> list[tuple[Statement, Operand, Block]]:
    """Every branch, with the program that it goes to; in command mode, the program that was entered before it."""
    found = []
    before = source.blocks[0] if source.blocks and source.blocks[0].entry is None else None
    for statement in source.statements:
        if statement.row.name == "ENTER" and statement.block < 0:
            before = next(block for block in source.blocks if block.entry is statement)
        if statement.target is not None and before is not None:
            found.append((statement, statement.target, before))
    return found


def reached(source: Source, block: Block) -> set[int]:
    """The addresses of all instructions that a run can come to, from byte 0 or from a branch in command mode."""
    at = {statement.address: statement for statement in block.statements}
    starts = [block.address_of(target) for jump, target, goal in branches(source) if goal is block and jump.block < 0]
    todo = [0, *(address for address in starts if address is not None)]
    seen: set[int] = set()
    while todo:
        address = todo.pop()
        if address in at and address not in seen:
            seen.add(address)
            todo += steps_on(block, at[address])
    return seen


# -------------------------------------------------------------------------------------------------------------- rules


def targets(source: Source) -> None:
    """Branches must meet the first byte of an instruction; the chip does not check it (s.3 J)."""
    for statement, target, block in branches(source):
        address = block.address_of(target)
        if address is None or address > source.sheet.buffer_bytes - 1:
            continue  # the assembler's business
        inside = next((other for other in block.statements if other.address <= address < other.end), None)
        if inside is None:
            found = f"{statement.row.name} to byte {address}, but the program has {block.size} bytes"
            source.report(target, "branch-outside", "warning", found, section=BRANCHES)
        elif inside.address != address:
            found = f"{statement.row.name} to byte {address}, inside {inside.text} of line {inside.line}"
            starts = f"{inside.address} or {inside.end}"
            remedy = "let a label count the bytes" if source.sheet.labels else ""
            source.report(target, "branch-middle", "warning", found, allowed=starts, section=BRANCHES, remedy=remedy)


def flow(source: Source) -> None:
    """Every instruction is reached by some run, and no run goes past the last one."""
    for block in source.blocks:
        seen = reached(source, block)
        starts = {statement.address for statement in block.statements}
        stray = any(goal is block and block.address_of(target) not in starts for _, target, goal in branches(source))
        above = True
        for statement in block.statements:
            here = statement.address in seen
            if above and not here and not stray:  # a branch into the middle of an instruction may lead anywhere
                found = f"nothing leads to {statement.text}"
                source.report(statement, "unreachable", "warning", found, section=BRANCHES)
            if here and statement.end == block.size and statement.row.name not in AWAY:
                remedy = "end with 0, or repeat with X or J"
                found = f"the program runs past its last byte, {block.size - 1}"
                source.report(statement, "no-end", "warning", found, section=BRANCHES, remedy=remedy)
            above = here


def loops(source: Source) -> None:
    """One loop at a time: there is a single count (s.3 L)."""
    for block in source.blocks:
        counted = [statement for statement in block.statements if statement.row.name == "LOOP"]
        for outer in counted:
            begin = block.address_of(outer.target) if outer.target else None
            for inner in counted:
                if begin is not None and begin <= inner.address < outer.address:
                    found = f"the loop of line {inner.line} lies inside this one"
                    remedy = "repeat the outer one with T, J or X"
                    source.report(outer, "nested-loop", "warning", found, section="s.3 L", remedy=remedy)
            if outer.values[0] == 1:
                found = "a loop that runs once"
                source.report(outer.operands[0], "loop-once", "warning", found, section="s.3 L")


def misplaced(source: Source) -> None:
    """Commands that mean little where they stand."""
    for statement in source.statements:
        name, inside, row = statement.row.name, statement.block >= 0, statement.row
        if inside and name == "ENTER":
            found, remedy = "E inside a program is stored, and skipped when it is executed", "close the program with Q"
            source.report(statement, "enter-inside", "warning", found, section=row.where, remedy=remedy)
        elif inside and name == "VERIFY":
            found, remedy = "V inside a program only moves the read pointer", "give V in command mode"
            source.report(statement, "verify-inside", "warning", found, section=row.where, remedy=remedy)
        elif not inside and name in ("LOOP", "TIL"):
            found = f"{name} in command mode; it belongs in a program"
            source.report(statement, "branch-in-command-mode", "warning", found, section=row.where)
        elif not row.stored and not any(block.quit is statement for block in source.blocks):
            source.report(statement, "quit-outside", "warning", "Q without E", section=row.where)


def entries(source: Source) -> None:
    """Programs are closed, and their labels are used."""
    used = {(id(block), target.label) for _, target, block in branches(source)}
    for block in source.blocks:
        if block.entry is not None and block.quit is None:
            found, remedy = "a program without Q: all that follows is stored", "write Q behind its last instruction"
            source.report(block.entry, "no-quit", "warning", found, section=block.entry.row.where, remedy=remedy)
        for statement in block.statements:
            for letter in statement.labels:
                if (id(block), letter) not in used:
                    source.report(statement, "unused-label", "note", f"nothing branches to {letter}", section=LABELS)


RULES: tuple[Check, ...] = (targets, flow, loops, misplaced, entries)
