"""A program for one part of the CY5xx family, given to another one: the linter lists the exchanged letters."""

from __future__ import annotations

import pytest

from slewline.chips import checks_of, sheet_of
from slewline.chips.cy5xx.letters import exchanged
from slewline.language.lint import lint

CY512 = "A\nR 255\nS 5\nN 100\nE\nG\nX 500\nL 3,0\nT\n0\nQD\n"
CY525 = "A 0\nF 3\nR 80\nS 200\nZ 1\nN 100\nE\nA$G\nD 500\nL 3,A\nT A\n0\nQX\n"


def notes(part: str, text: str) -> list[str]:
    """The remedies of the notes about sister parts."""
    return [p.remedy for p in lint(text, sheet_of(part), checks_of(part)) if p.code == "sister-part"]


@pytest.mark.parametrize(("part", "text", "other"), [("cy525", CY512, "cy512"), ("cy512", CY525, "cy525")])
def test_a_program_for_the_other_part_gets_the_list_of_exchanged_letters(part, text, other):
    (listed,) = notes(part, text)
    assert listed == "; ".join(exchanged(part)[other].values())
    for letter in "ADFHORSTX":
        assert f"{letter} " in listed


@pytest.mark.parametrize(("part", "text"), [("cy525", CY525), ("cy512", CY512)])
def test_its_own_program_gets_none(part, text):
    assert notes(part, text) == []
    assert not [p for p in lint(text, sheet_of(part), checks_of(part)) if p.severity == "error"]


@pytest.mark.parametrize(
    ("part", "lines", "count"),
    [
        ("cy525", ["A", "D", "T", "X 500"], 1),
        ("cy525", ["F", "G 3", "K", "O"], 0),
        ("cy512", ["A 5", "D 5", "X", "Z 1", "T 4"], 1),
        ("cy512", ["R", "B 1", "K", "F"], 0),
    ],
)
def test_one_line_tells_where_its_form_is_that_of_the_sister(part, lines, count):
    for line in lines:
        assert len(notes(part, f"{line}\n")) == count, line
