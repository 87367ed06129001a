"""How the linters of the family read a text: as a chip would run it, through every branch both ways."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeVar

from ...language.lint import explored
from ...language.problems import Severity
from ...language.statements import Block, Directive, Source, Statement

S = TypeVar("S")


class Odd(NamedTuple):
    """Something odd about a command, in the state in which it is met."""

    code: str
    severity: Severity
    found: str
    section: str
    remedy: str = ""


def walk(
    source: Source,
    states: Sequence[S],
    step: Callable[[Statement, S], S],
    directive: Callable[[Directive], None] = lambda item: None,
) -> None:
    """Take each command of a text in every state in which it can be met; a program that nothing starts, too.

    Args:
        states: what may hold at first; anything that can be hashed.
        step: the state behind a command.
        directive: is told of every line that is the host's.
    """
    blocks = iter(source.blocks)
    latest: Block | None = None
    started = False
    for item in source.items:
        if isinstance(item, Directive):
            directive(item)
        elif item.block >= 0:
            continue
        elif item.row.role == "enter":
            if latest and not started:
                explored(latest, 0, states, step)  # somebody else may have started it
            latest, started = next(blocks), False
        elif latest and (item.row.role == "run" or item.target):
            started = True
            address = latest.address_of(item.target) if item.target else 0
            states = states if address is None else explored(latest, address, states, step)
        else:
            states = [step(item, state) for state in states]
    if latest and not started:
        explored(latest, 0, states, step)


def judged(
    source: Source, state: S, remarks: Callable[[Statement, S], Iterator[Odd]], after: Callable[[Statement, S], S]
) -> None:
    """Report what is odd about the commands of a text, each thing once.

    Args:
        state: what holds at first.
        remarks: what is odd about a command in a state.
        after: the state behind a command.
    """
    told = set()

    def step(statement: Statement, before: S) -> S:
        for each in remarks(statement, before):
            if (statement.line, statement.column, each.code) not in told:
                told.add((statement.line, statement.column, each.code))
                found, remedy = each.found, each.remedy
                source.report(statement, each.code, each.severity, found, section=each.section, remedy=remedy)
        return after(statement, before)

    walk(source, [state], step)
