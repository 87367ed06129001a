"""A rule of the linter: is this text written for a sister part?"""

from __future__ import annotations

from collections.abc import Mapping

from ...core.datasheet.table import Sheet
from ...language.lint import Problem, Source
from .letters import ALIKE, NUMBERS, exchanged

FORMS = ("missing-argument", "extra-argument", "unknown-command", "bad-label")


def written_for(source: Source) -> None:
    """Where commands have the form that a sister part wants, list once all letters that mean something else there.

    Of several sisters it is the one whose forms are met most often, and of those the one that differs least.
    """
    sheet, problems = source.sheet, sorted(source.problems)
    means = exchanged(sheet.part)
    met = {sister: [p for p in problems if meant(p, sister, means[sister], sheet)] for sister in means}
    sister = max(met, key=lambda each: (len(met[each]), -len(means[each])))
    if met[sister]:
        found = f"this may be written for the {sister.upper()}, where letters mean something else"
        remedy = "\n".join(means[sister].values())
        source.report(met[sister][0], "sister-part", "note", found, section=sheet.sections["text"], remedy=remedy)


def meant(problem: Problem, sister: str, means: Mapping[str, str], sheet: Sheet) -> bool:
    """Is what is wrong with a command right in a sister part?"""
    if problem.code not in FORMS:
        return False
    letters = {row.name: row.form for row in sheet.commands}
    command = problem.found.rpartition(" behind ")[2]  # an argument may be a letter as well
    named = [letters.get(word, word) for word in command.replace(",", " ").split()]
    letter = next((word for word in named if word in means), "$" if problem.code == "bad-label" else "")
    if letter not in means or letter not in NUMBERS or problem.code == "unknown-command":
        return letter in means and problem.code not in ("missing-argument", "extra-argument")
    here, there = (NUMBERS[letter].get(part, 0) for part in (ALIKE.get(sheet.part, sheet.part), sister))
    return here < there if problem.code == "extra-argument" else there < here
