"""A rule of the linter: is this text written for a sister part?"""

from __future__ import annotations

from ...language.lint import Source
from .letters import NUMBERED, exchanged

FORMS = ("missing-argument", "extra-argument", "unknown-command", "bad-label")


def written_for(source: Source) -> None:
    """Where commands have the form that a sister part wants, list once all letters that mean something else there."""
    part = source.sheet.part
    letters = {row.name: row.form for row in source.sheet.commands}
    for sister, means in exchanged(part).items():
        for problem in sorted(source.problems):
            words = problem.found.replace(",", " ").split()
            named = [letters.get(word, word) for word in words]
            letter = next((word for word in named if word in means), "$" if problem.code == "bad-label" else "")
            if problem.code not in FORMS or letter not in means:
                continue
            if letter in NUMBERED and (sister in NUMBERED[letter]) != (problem.code == "extra-argument"):
                continue
            if letter not in NUMBERED and problem.code in ("missing-argument", "extra-argument"):
                continue
            found = f"this may be written for the {sister.upper()}, where letters mean something else"
            source.report(problem, "sister-part", "note", found, section="s.3", remedy="; ".join(means.values()))
            break
