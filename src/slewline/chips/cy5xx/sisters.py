"""A rule of the linter: is this text written for a sister part?"""

from __future__ import annotations

from collections.abc import Mapping

from ...language.lint import Problem, Source
from .letters import NUMBERED, exchanged

FORMS = ("missing-argument", "extra-argument", "unknown-command", "bad-label")


def written_for(source: Source) -> None:
    """Where commands have the form that a sister part wants, list once all letters that mean something else there.

    Of several sisters it is the one whose forms are met most often, and of those the one that differs least.
    """
    letters = {row.name: row.form for row in source.sheet.commands}
    means = exchanged(source.sheet.part)
    met = {sister: [p for p in sorted(source.problems) if meant(p, sister, means[sister], letters)] for sister in means}
    sister = max(met, key=lambda each: (len(met[each]), -len(means[each])))
    if met[sister]:
        found = f"this may be written for the {sister.upper()}, where letters mean something else"
        remedy = "\n".join(means[sister].values())
        source.report(met[sister][0], "sister-part", "note", found, section="s.3", remedy=remedy)


def meant(problem: Problem, sister: str, means: Mapping[str, str], letters: Mapping[str, str]) -> bool:
    """Is what is wrong with a command right in a sister part?"""
    if problem.code not in FORMS:
        return False
    named = [letters.get(word, word) for word in problem.found.replace(",", " ").split()]
    letter = next((word for word in named if word in means), "$" if problem.code == "bad-label" else "")
    if letter in NUMBERED and problem.code != "unknown-command":
        return letter in means and (sister in NUMBERED[letter]) == (problem.code == "extra-argument")
    return letter in means and problem.code not in ("missing-argument", "extra-argument")
