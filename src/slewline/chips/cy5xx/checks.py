"""The lint rules common to the family.

A program text is followed as a chip would run it, with both outcomes of every branch.  It is also
checked for commands of a sister part, which is another chip of the family.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeVar

from ...core.datasheet.table import Sheet
from ...language.lint import explored
from ...language.problems import Problem, Severity
from ...language.statements import Block, Directive, Source, Statement
from .letters import ALIKE, NUMBERS, exchanged

S = TypeVar("S")
FORMS = (
    "missing-argument",
    "extra-argument",
    "unknown-command",
    "bad-label",
)  # codes of problems that indicate a sister part


class Odd(NamedTuple):
    """A problem found in a command, as it will be reported."""

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
    """Call `step` for each command of a text, in every state in which the command is reached.

    Commands of a program that is never started are included.

    Args:
        states: the possible states at the start; they must be hashable.
        step: returns the state after a command, from the command and the state before it.
        directive: is called with every host directive.
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
                explored(latest, 0, states, step)  # another program may have started it
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
    """Report the problems of the commands in a text, each problem at most once per command.

    Args:
        state: the state at the start.
        remarks: yields the problems found in a command in a given state.
        after: returns the state after a command, from the command and the state before it.
    """
    reported = set()

    def step(statement: Statement, before: S) -> S:
        for each in remarks(statement, before):
            if (statement.line, statement.column, each.code) not in reported:
                reported.add((statement.line, statement.column, each.code))
                found, remedy = each.found, each.remedy
                source.report(statement, each.code, each.severity, found, section=each.section, remedy=remedy)
        return after(statement, before)

    walk(source, [state], step)


def written_for(source: Source) -> None:
    """Report, once, that a text may have been written for a sister part, if faulty commands are correct in that part.

    The remedy lists all letters whose meaning differs in the sister part.  If several sister parts qualify,
    choose the part that makes the largest number of faulty commands correct; in a tie, the part with the
    fewest letters whose meaning differs.
    """
    sheet, problems = source.sheet, sorted(source.problems)
    means = exchanged(sheet.part)
    met = {sister: [p for p in problems if meant(p, sister, means[sister], sheet)] for sister in means}
    sister = max(met, key=lambda each: (len(met[each]), -len(means[each])))
    if met[sister]:
        found = f"this may be written for the {sister.upper()}, where letters have other meanings"
        remedy = "\n".join(means[sister].values())
        source.report(met[sister][0], "sister-part", "note", found, section=sheet.sections["text"], remedy=remedy)


def meant(problem: Problem, sister: str, means: Mapping[str, str], sheet: Sheet) -> bool:
    """Return whether the command in which a problem was found would be correct in a sister part."""
    if problem.code not in FORMS:
        return False
    letters = {row.name: row.form for row in sheet.commands}
    command = problem.found.rpartition(" after ")[2]  # an argument may be a letter as well
    named = [letters.get(word, word) for word in command.replace(",", " ").split()]
    letter = next((word for word in named if word in means), "$" if problem.code == "bad-label" else "")
    if letter not in means or letter not in NUMBERS or problem.code == "unknown-command":
        return letter in means and problem.code not in ("missing-argument", "extra-argument")
    here, there = (NUMBERS[letter].get(part, 0) for part in (ALIKE.get(sheet.part, sheet.part), sister))
    return here < there if problem.code == "extra-argument" else there < here
