"""The linter: finds the problems in a program text without running it.

It never raises, however bad the text.  The rules in this module hold for every part that stores
programs, and read only the part's data sheet.  The part's dialect has further rules.  The rules of a
single part, for example whether a move is long enough for its ramp to reach the rate, are passed in as
`checks`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from ..core.datasheet.table import Row, Sheet
from . import host_rules
from .assemble import link, units
from .dialect import Check, dialect_of
from .problems import Problem, render
from .source import BEGINS, commented, mended, read
from .statements import Block, Operand, Source, Statement

__all__ = ["Check", "Problem", "Source", "branches", "explored", "lint", "reached", "render", "steps_on"]

STATES = 4096  # a program with more register states than this is checked only with the first ones
S = TypeVar("S")


def lint(text: str, sheet: Sheet, checks: Iterable[Check] = ()) -> list[Problem]:
    """Return the problems of a text, both errors and warnings, in the order of their places.

    The text is a host's input, as for `slewline run`: only the lines after a command that begins program
    entry are a program.

    Args:
        text: the text, one command per line.
        sheet: the data sheet of the part.
        checks: further rules, for example those returned by `checks_of`.
    """
    source = read(text, sheet)
    link(source)
    for check in (*RULES, *dialect_of(sheet).rules, *checks):
        check(source)
    found = mended(source.problems, text)
    marked = {problem.line for problem in found if problem.remedy == BEGINS}
    return sorted({*found, *(problem for problem in commented(text, sheet) if problem.line not in marked)})


# -------------------------------------------------------------------------------------------------------- control flow


def steps_on(block: Block, statement: Statement) -> list[int]:
    """Return the addresses where a program may continue after an instruction; one may be the program's end."""
    target = statement.target
    successors = {
        "n": statement.end,
        "0": 0,
        "l": block.loop_start(statement),
        "t": None if target is None else block.address_of(target),
    }
    found = [successors[flow] for flow in statement.row.flow]
    return [address for address in found if address is not None]


def explored(block: Block, address: int, states: Sequence[S], step: Callable[[Statement, S], S]) -> list[S]:
    """Follow a program from an address, with both outcomes of every branch.

    Args:
        states: the possible register states at the start, which must be hashable.
        step: returns the register state after an instruction, given the state before it.

    Returns:
        The states in which the program may end or, if it never ends, all states that occur in it.
    """
    at = {statement.address: statement for statement in block.statements}
    todo = [(address, state) for state in states]
    seen, ends = dict.fromkeys(todo), dict[S, None]()  # in order, so that the same text has the same result
    while todo and len(seen) < STATES:
        here, state = todo.pop()
        statement = at.get(here)
        if statement is None:
            ends[state] = None
            continue
        after = step(statement, state)
        if not statement.row.flow:
            ends[after] = None
        ahead = [(there, after) for there in steps_on(block, statement) if (there, after) not in seen]
        seen |= dict.fromkeys(ahead)
        todo += ahead
    return list(ends) or list(dict.fromkeys(state for _, state in seen))


def branches(source: Source) -> list[tuple[Statement, Operand, Block]]:
    """Return every branch with its target, and the program that contains the target.

    For a branch outside programs, the program is the last one entered before the branch; if there is none, the
    branch is omitted.
    """
    found = []
    before = None
    for statement in source.statements:
        if statement.row.role == "enter" and statement.block < 0:
            before = next(block for block in source.blocks if block.entry is statement)
        if statement.target is not None and before is not None:
            found.append((statement, statement.target, before))
    return found


def reached(source: Source, block: Block) -> set[int]:
    """Return the addresses of the program's instructions that are reached in a run.

    A run starts at the first byte, or at the target of a branch in command mode.
    """
    at = {statement.address: statement for statement in block.statements}
    starts = [block.address_of(target) for jump, target, goal in branches(source) if goal is block and jump.block < 0]
    todo = [block.base, *(address for address in starts if address is not None)]
    seen: set[int] = set()
    while todo:
        address = todo.pop()
        if address in at and address not in seen:
            seen.add(address)
            todo += steps_on(block, at[address])
    return seen


def section(row: Row) -> str:
    """Return the section of the manual that describes a command."""
    return row.where.split("; ")[0]


# ------------------------------------------------------------------------------------------------- rules for all parts


def targets(source: Source) -> None:
    """Report branches whose target is within an instruction or outside the program; the chip checks neither."""
    unit = units(source.sheet).removesuffix("s")
    for statement, target, block in branches(source):
        address = block.address_of(target)
        if address is None or address > source.sheet.buffer_bytes - 1:
            continue  # reported by the assembler
        if statement.block < 0 and statement.row.role == "pointer":
            continue  # the next program may be anywhere
        inside = next((other for other in block.statements if other.address <= address < other.end), None)
        others = (other for other in source.blocks if other.base != block.base)
        if inside is None and any(other.base <= address < other.end for other in others):
            continue  # into another program of the same memory
        if inside is None:
            found = f"{statement.row.name} to {unit} {address}, but the program has {block.size} {unit}s"
            source.report(target, "branch-outside", "warning", found, section=section(statement.row))
        elif inside.address != address:
            found = f"{statement.row.name} to {unit} {address}, inside {inside.text} of line {inside.line}"
            starts = f"{inside.address} or {inside.end}"
            remedy = "use a label instead of an address" if source.sheet.labels else ""
            where = section(statement.row)
            source.report(target, "branch-middle", "warning", found, allowed=starts, section=where, remedy=remedy)


def flow(source: Source) -> None:
    """Report instructions that no run reaches; of consecutive ones, only the first is reported."""
    for block in source.blocks:
        seen = reached(source, block)
        starts = {statement.address for statement in block.statements}
        stray = any(goal is block and block.address_of(target) not in starts for _, target, goal in branches(source))
        above = True
        for statement in block.statements:
            here = statement.address in seen
            if above and not here and not stray:  # a branch into the middle of an instruction may lead anywhere
                found = f"{statement.text} is never reached"
                source.report(statement, "unreachable", "warning", found, section=section(statement.row))
            above = here


RULES: tuple[Check, ...] = (targets, flow, host_rules.driven)
