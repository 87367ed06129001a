"""What the linters of CY500 and CY512 say of programs, each where a run of the text comes upon it."""

from __future__ import annotations

import pytest

from slewline.chips import checks_of, sheet_of
from slewline.language.lint import lint
from tests.rows import rows


def told(part: str, *lines: str) -> list[tuple[int, str]]:
    """Line and code of what only the linter of a part knows."""
    own = lint("\n".join(lines) + "\n", sheet_of(part), checks_of(part))
    return [(problem.line, problem.code) for problem in own if problem.severity != "error"]


@rows(
    ("lines", "expected"),
    [
        (["A", "N 10"], [(2, "n-after-a")]),
        (["A", "B", "N 10"], []),
        (["-", "A"], [(2, "a-after-direction")]),
        (["-", "B", "A"], []),
        (["A", "B", "A"], [(3, "a-twice")]),
        (["A", "I", "A"], []),
        (["S 5", "F 2"], [(2, "factor-in-slope")]),
        (["S 5", "S 0", "F 2"], [(2, "range")]),
        (["J", "G"], [(2, "go-in-jog")]),
        (["J", "I", "G"], []),
        (["J", "E", "T", "0", "Q", "D"], [(3, "til-and-jog")]),
        (["R 253", "S 50", "N 11", "G"], [(4, "short-slope")]),
        (["R 253", "S 50", "N 12", "G"], []),
        (["R 253", "S 50", "A", "B", "N 12", "G"], []),
        (["R 253", "S 50", "N 5", "I", "G"], []),
        (["R 253", "S 50", "N 5", "P 9", "G"], []),
        (["R 253", "S 50", "A", "N 12", "G"], [(4, "n-after-a"), (5, "short-slope")]),
        (["E", "A", "N 10", "G", "T", "0", "QD"], [(2, "a-twice"), (3, "n-after-a")]),
    ],
)
def test_the_warnings_of_the_article_are_those_of_the_cy500s_linter(lines, expected):
    assert [each for each in told("cy500", *lines) if each[1] != "range"] == [e for e in expected if e[1] != "range"]


@rows(
    ("lines", "expected"),
    [
        (["S 5", "F 2"], [(2, "factor-in-slope")]),
        (["S 0", "F 2"], []),
        (["R 255", "S 5", "N 101", "G"], [(4, "short-move")]),
        (["R 255", "S 5", "N 102", "G"], []),
        (["R 255", "S 0", "N 1", "G"], []),
        (["R 255", "S 5", "A", "P 101", "P 203"], [(4, "short-move")]),
        (["R 255", "S 5", "P 101"], []),
        (["R 255", "S 5", "E", "G", "0", "Q", "N 9", "D", "N 11", "D"], [(4, "short-move"), (9, "still-running")]),
        (["R 255", "S 5", "N 9", "E", "G", "L 3,0", "0", "QD"], [(5, "short-move")]),
    ],
)
def test_the_cy512s_linter_knows_its_ramps(lines, expected):
    assert told("cy512", *lines) == expected


@pytest.mark.parametrize("part", ["cy500", "cy512"])
def test_the_chip_reports_the_same_as_the_linter(part):
    """The codes of findings and of problems agree."""
    import slewline

    bench = slewline.Bench()
    x = bench.add(part, name="x")
    bench.host(x).send("R 200\rS 5\rF 2\r")
    bench.run_until_idle()
    assert [found.code for found in x.findings] == [code for _, code in told(part, "R 200", "S 5", "F 2")]
