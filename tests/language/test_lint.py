"""The linter's general rules: what it finds, where, and that it never gives up."""

from hypothesis import given
from hypothesis import strategies as st

from slewline.chips.cy525.checks import checks
from slewline.chips.cy525.sheet import SHEET
from slewline.language.lint import lint, render
from tests.rows import rows


def found(text):
    return [(problem.line, problem.column, problem.length, problem.code) for problem in lint(text, SHEET)]


CLEAN = [
    "E\nB\n0\nQ\nX",
    "E\nA$B\nW\nJ A\nQ\nX",
    "E\nA$G\nL 3,A\nB$G\nL 2,B\n0\nQ",
    "E\nU\nX\nQ",
    "E\nB\nI\nQ",
    "E\nG\nT 0\n0\nQ",
    "E\nJ A\nA$0\nQ",
    "E\nJ 3\nB\n0\nQ\nJ 2",
    "E\nQ",
    "R 100\nN 5\nG",
    "E\n0\nQ\nE\n0\nQ\nX",
    "E\nB\nG\nT 0\n0\nQ",
    "E\n0\nQX\n@until run=1\nV 0",
    "E\n0\nQX\n@wait 1 s\nX",
    "E\n0\nQX\n@live R 5 | 0\nV 0",
    "E\n0\nQX\n@live I\nV 0",
    "E\n0\nQX\n@reset\nR 5",
    "E\n0\nQX\n@power off\n@power on\nR 5",
    "E\n0\nQX\n@drive reset=0\n@drive reset=1\nR 5",
    "E\n0\nQX\n@bytes 56 01 00",
    "G\n@read position",
    "E\nG\nX\nQX\n@until run=0\n@read position",
    "@drive abort=0\n@pulse wait=0 20 us\n@drive prog=0",
    "@live R 20 | B",
    "@note X|K",
    "E\nB\n0\nQX",
]

ODD = [
    ("R 200", [(1, 3, 3, "range")]),
    ("E\nJ A\nQ", [(2, 3, 1, "missing-label")]),
    ("E\nA$B\nJ A\nA$0\nQ", [(4, 1, 3, "label-twice")]),
    ("E\nA$B\n0\nQ", [(2, 1, 3, "unused-label")]),
    ("E\nA$B\nC\nQ", [(2, 1, 3, "unused-label"), (3, 1, 1, "no-end")]),
    ("A$B\nC", [(1, 1, 3, "label-outside")]),  # without E these are commands
    ("T 5", [(1, 1, 3, "branch-in-command-mode")]),
    ("L 2,0", [(1, 1, 5, "branch-in-command-mode")]),
    ("E\n0\nQX\nV 0", [(4, 1, 3, "still-running")]),
    ("E\n0\nQ\nX\nX\n@note so\nX", [(5, 1, 1, "still-running"), (7, 1, 1, "still-running")]),
    ("E\n0\nQX\n@live R 5\nV 0\nR 5", [(5, 1, 3, "still-running")]),
    ("E\n0\nQ\nJ 0\nR 5", [(5, 1, 3, "still-running")]),
    ("E\n0\nQX\n@verify 0", [(4, 1, 9, "still-running")]),
    ("E\n0\nQX\n@until run=1\n@verify 0\nX\n@live V 0", []),
    ("X", [(1, 1, 1, "no-program")]),
    ("E\nQ\nX", [(3, 1, 1, "no-program")]),
    ("E\n0\nQI\nX", [(4, 1, 1, "no-program")]),
    ("E\n0\nQ\n@reset\nX", [(5, 1, 1, "no-program")]),
    ("E\n0\nQ\n@power off\n@power on\nX", [(6, 1, 1, "no-program")]),
    ("@read position", [(1, 1, 14, "read-at-rest")]),
    ("G\nR 5\n@read position", [(3, 1, 14, "read-at-rest")]),
    ("G\n@until motion_complete=0\n@read position", [(3, 1, 14, "read-at-rest")]),
    ("E\nG\n0\nQX\n@until run = 1\n@read position", [(6, 1, 14, "read-at-rest")]),
    ("@drive slew=0", [(1, 1, 13, "driven-output")]),
    ("@pulse run = 1 20 us", [(1, 1, 20, "driven-output")]),
    ("@live M 5", [(1, 7, 1, "unknown-command")]),
    ("  @live B |R 200", [(1, 14, 3, "range")]),
    ("E\nT 60\n0\nQ", [(2, 3, 2, "range")]),
    ("E\nJ 3\nN 16962\n0\nQ", [(2, 3, 1, "branch-middle")]),
    ("E\nA$L 2,A\nL 3,A\n0\nQ", [(3, 1, 5, "nested-loop")]),
    ("E\n0\nQ\nA$B", [(4, 1, 3, "label-outside")]),
    ("E\n" + "B\n" * 60 + "0\nQ", [(62, 1, 1, "overflow")]),
    ("E\nN 5\nG\nJ 2\nQ", [(4, 3, 1, "branch-middle")]),
    ("E\nN 5\nG\nT 40\n0\nQ", [(4, 3, 2, "branch-outside")]),
    ("E\nN 5\nG\nT 7\n0\nQ", [(4, 3, 1, "branch-outside")]),
    ("E\nN 5\n0\nQ\nJ 1", [(5, 3, 1, "branch-middle")]),
    ("E\nN 5\n0\nQ\nJ 9", [(5, 3, 1, "branch-outside")]),
    ("E\nJ A\nB\nC\nA$0\nQ", [(3, 1, 1, "unreachable")]),
    ("E\n0\nB\nT 0\nQ", [(3, 1, 1, "unreachable")]),
    ("E\n0\nB\n0\nQ\nJ 1", []),
    ("E\nX\nB\nQ", [(3, 1, 1, "unreachable")]),
    ("E\nB\nQ", [(2, 1, 1, "no-end")]),
    ("E\nG\nT 0\nQ", [(3, 1, 3, "no-end")]),
    ("E\nG\nL 2,0\nQ", [(3, 1, 5, "no-end")]),
    ("E\nA$B\nB$G\nL 3,B\nL 2,A\n0\nQ", [(5, 1, 5, "nested-loop")]),
    ("E\nG\nL 3,0\nL 2,0\n0\nQ", [(4, 1, 5, "nested-loop")]),
    ("E\nG\nL 1,0\n0\nQ", [(3, 3, 1, "loop-once")]),
    ("E\nG\nL 0,0\n0\nQ", [(3, 3, 1, "range")]),
    ("E\nB\nE\n0\nQ", [(3, 1, 1, "enter-inside")]),
    ("E\nV 1\n0\nQ", [(2, 1, 3, "verify-inside")]),
    ("E\n0\nQ\nT 0", [(4, 1, 3, "branch-in-command-mode")]),
    ("E\n0\nQ\nL 2,0", [(4, 1, 5, "branch-in-command-mode")]),
    ("R 5\nQ", [(2, 1, 1, "quit-outside")]),
    ("E\n0\nQQ", [(3, 2, 1, "quit-outside")]),
    ("E\n0\nQ 1", [(3, 3, 1, "extra-argument")]),
    ("R 5\nE\n0\n", [(2, 1, 1, "no-quit")]),
    ("R  5", [(1, 2, 3, "spacing")]),
]


@rows("text", CLEAN)
def test_no_findings_of_the_linter(text):
    assert found(text) == []


@rows(("text", "problems"), ODD)
def test_odd_lines(text, problems):
    assert found(text) == problems


def test_severities():
    text = "E\nA$B\nR  5\nR 200\nT 0\nQ"
    assert [(problem.code, problem.severity) for problem in lint(text, SHEET)] == [
        ("unused-label", "note"),
        ("spacing", "note"),
        ("range", "error"),
        ("no-end", "warning"),
    ]


def test_render():
    text = "E\n  N 5\nJ 2 ; here\nQ\n"
    assert render(lint(text, SHEET), text, "x").splitlines() == [
        "x, line 3, column 3: warning: JUMP to byte 2, inside N 5 of line 2: allowed 0 or 3 (CY525 manual, s.3)",
        "    J 2 ; here",
        "      ^",
        "    use a label instead of an address",
    ]


def test_render_keeps_problems_apart():
    text = "K\nR 200\n"
    assert render(lint(text, SHEET), text, "x").count("\n\n") == 1
    assert render([], text, "x") == ""


def test_checks_are_handed_in():
    def check(source):
        for statement in source.statements:
            source.report(statement, "mine", "note", statement.text)

    assert [(problem.line, problem.found) for problem in lint("B\nC", SHEET, [check])] == [(1, "B"), (2, "C")]


SCRAPS = """E Q QX B 0 X A$B B$C$G L_3,B J_A L_0,70 T_9 J R_200 k ;_x N_5 H G F_3 S_0 Z_0 P_9 R_0 A_7 I A$ R² V_9
@rate_5 @rate_0 @drive_abort=0"""
LINES = st.sampled_from([scrap.replace("_", " ") for scrap in SCRAPS.split()])


@given(st.lists(LINES, max_size=30).map("\n".join) | st.text(max_size=80))
def test_never_raises(text):
    for problem in lint(text, SHEET, checks(SHEET)):
        assert 1 <= problem.line <= len(text.splitlines())
        assert problem.column >= 1
        assert problem.length >= 1
        render([problem], text, "x")
