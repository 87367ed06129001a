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

__all__ = ["Check", "Problem", "Source", "lint", "render", "steps_on"]

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


def _entries(source: Source) -> list[tuple[Statement, Block]]:
    """The branches given in command mode: they start the program that was entered before them."""
    found = []
    for statement in source.statements:
        before = [block for block in source.blocks if block.entry is not None and block.entry.line <= statement.line]
        if statement.block < 0 and statement.target is not None and before:
            found.append((statement, before[-1]))
    return found


def _branches(source: Source) -> list[tuple[Statement, Operand, Block]]:
    inside = [(statement, block) for block in source.blocks for statement in block.statements]
    pairs = inside + _entries(source)
    return [(statement, statement.target, block) for statement, block in pairs if statement.target is not None]


def _reached(source: Source, block: Block) -> set[int]:
    at = {statement.address: statement for statement in block.statements}
    todo = [0] + [block.address_of(target) for _, target, other in _branches(source) if other is block and _.block < 0]
    seen: set[int] = set()
    while todo:
        address = todo.pop()
        if address in at and address not in seen:
            seen.add(address)
            todo += steps_on(block, at[address])
    return seen
