"""A program for one part of the CY5xx family, given to another one: the linter lists the exchanged letters."""

from __future__ import annotations

from itertools import permutations

from slewline.chips import checks_of, sheet_of
from slewline.chips.cy5xx.letters import exchanged
from slewline.language.lint import lint, render
from tests.rows import rows

PROGRAMS = {
    "cy500": "A\nR 253\nL\nE\nG\nO\nT\n0\nQ\nD\nI\nF 2\nJ\n",
    "cy512": "A\nR 255\nS 5\nN 200\nE\nG\nX 500\nL 3,0\nT\n0\nQD\n",
    "cy525": "A 0\nF 3\nR 80\nS 200\nZ 1\nN 100\nE\nA$G\nD 500\nL 3,A\nT A\n0\nQX\n",
    "cy545": "A 0\nF 30\nR 200\nS 220\nN 100\nE\n+\nG\nB 16\nW 1\nT 5,0\nZ 400,0\n? P\n0\nQ\nY 0\nX\n",
}
OTHER = {  # letters that mean something else, by part and sister
    ("cy500", "cy512"): "JLOPRVWX",
    ("cy500", "cy525"): "ADFHJLOPRSTVWXZ$",
    ("cy512", "cy500"): "JLOPR",
    ("cy512", "cy525"): "ADFHORSTXZ$",
    ("cy500", "cy545"): 'ABCDFHJLOPRSTWXYZ?["',
    ("cy512", "cy545"): 'ABCDFHORSTWXYZ?["',
    ("cy525", "cy500"): "ADFHJLOPRST",
    ("cy525", "cy512"): "ADFHORSTX",
    ("cy525", "cy545"): 'BCHORTWYZ?["',
    ("cy545", "cy500"): "ABCDFHJLOPRSTU",
    ("cy545", "cy512"): "ABCDFHORSTUVWX",
    ("cy545", "cy525"): "BCHORTUVWZ$",
}


def notes(part: str, text: str) -> list[str]:
    """The remedies of the notes about sister parts."""
    return [p.remedy for p in lint(text, sheet_of(part), checks_of(part)) if p.code == "sister-part"]


@rows(("part", "other"), list(permutations(PROGRAMS, 2)))
def test_a_program_for_another_part_gets_the_list_of_exchanged_letters(part, other):
    (listed,) = notes(part, PROGRAMS[other])
    assert "".join(line[0] for line in listed.splitlines()) == OTHER[part, other]
    assert listed.splitlines() == list(exchanged(part)[other].values())
    assert all(f" in the {other.upper()}; here it " in line for line in listed.splitlines())


@rows("part", PROGRAMS)
def test_its_own_program_gets_none(part):
    assert notes(part, PROGRAMS[part]) == []
    assert not [p for p in lint(PROGRAMS[part], sheet_of(part), checks_of(part)) if p.severity == "error"]


def test_the_list_is_shown_a_letter_a_line():
    problems = [p for p in lint("A\n", sheet_of("cy525"), checks_of("cy525")) if p.code == "sister-part"]
    shown = render(problems, "A\n", "p.cy525").splitlines()
    assert "    D runs the program in the CY512; here it waits its number of milliseconds" in shown
    assert max(map(len, shown)) < 130


@rows(
    ("part", "lines", "count"),
    [
        ("cy525", ["A", "D", "T", "X 500", "O", "J", "L"], 1),
        ("cy525", ["B 1", "H 5", "W 1", "Y 0", "? P", "[1,1,65", "Z 4,0", '"hi"'], 1),
        ("cy525", ["F", "G 3", "K", "N"], 0),
        ("cy512", ["A 5", "D 5", "X", "Z 1", "T 4", "O", "J"], 1),
        ("cy512", ["R", "C 1", "K", "F", "P"], 0),
        ("cy500", ["A 5", "D 5", "X 3", "L 3,4", "J 4", "V 1", "Z 1", "O 3"], 1),
        ("cy500", ["R", "C 1", "K", "F", "P", "O"], 0),
        ("cy545", ["A", "B", "D", "H", "O", "T 5", "U", "V 1", "W", "X 500", "Z 1"], 1),
        ("cy545", ["F", "G 3", "K", "N", "R", "QX"], 0),
    ],
)
def test_a_form_of_the_sister_is_reported_once(part, lines, count):
    for line in lines:
        assert len(notes(part, f"{line}\n")) == count, line


def test_the_cy545b_has_the_letters_of_the_cy545():
    for part, program in PROGRAMS.items():
        assert notes("cy545b", program) == notes("cy545", program), part
    assert all("CY545B" not in line for line in notes("cy525", PROGRAMS["cy545"]))
