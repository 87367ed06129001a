"""The linter for the GS-C modules: what it finds, where, and what it leaves in peace."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from slewline.chips import checks_of, sheet_of
from slewline.language.lint import lint
from tests.rows import rows

C200, C200S = "gs-c200", "gs-c200s"
STR = "S10\nT100\nR10\n"


def problems(text, part):
    return lint(text, sheet_of(part), checks_of(part))


def stored(text):
    """The text as a program; P and Px share lines with nothing, so that the lines of the text count from 2."""
    return f"Po\n{text}\nPx"


def found(text, part=C200S):
    return [(problem.line, problem.column, problem.length, problem.code) for problem in problems(text, part)]


@rows(
    ("part", "text"),
    [
        (C200S, f"Po\n{STR}+22\nE\n@until ready\nV1"),
        (C200S, f"Po\n{STR}L0\n+100\nL3\nL0\n-100\nL3\nPx\nE"),
        (C200S, stored(f"{STR}jc1,16\nj12\n+50\nj12")),
        (C200S, f"I1\nPo\n{STR}-50\nE\n@until ready\nPo\n+50\nE"),  # the speeds are still known
        (C200S, f"Po\n{STR}+22\nE\nPo\n+60\nL0\nR50\n+102\nL2\nE"),  # a loop begins behind its L0
        (C200, f"I1\nP\n{STR}G9999999\n-9999\nE"),
        (C200, f"P\n{STR}G-2\nA1\nE"),
        (C200S, f"I1\nPo\n{STR}G-8388608\n-100\nE"),  # this counter wraps
        (C200S, stored("A1\nD1\nC1")),
        (C200S, stored("A1\nC2")),
        (C200S, stored("W1\nU2")),
        (C200, "F\nV1\nK\nZ"),
        (C200S, "Po\nPx"),
    ],
)
def test_no_findings(part, text):
    assert problems(text, part) == []


@rows(
    ("text", "expected"),
    [
        (stored("j4\nA1"), [(2, 2, 1, "branch-outside")]),
        (stored("j3\nA1"), [(2, 2, 1, "branch-middle")]),
        (stored("jc1,1\nA1"), [(2, 5, 1, "branch-middle")]),
        (stored("j4\nA1\nC2"), [(3, 1, 2, "unreachable")]),
        (stored(f"{STR}g+\nA1"), [(6, 1, 2, "unreachable")]),
        (stored(f"{STR}g+1\nA1"), []),
        (stored("L0\nA1\nD1\nL0\nD1\nL2"), [(5, 1, 2, "nested-loop")]),
        (stored("L0\nD1\nL3\nD2\nL2"), [(6, 1, 2, "loop-without-start")]),
        (stored("D1\nL2"), [(3, 1, 2, "loop-without-start")]),
        (stored("L0\nD1\nL1"), [(4, 1, 2, "loop-once")]),
        (stored("L0\nD1"), [(2, 1, 2, "loop-unused")]),
        (stored("U1\nD1"), [(2, 1, 2, "until-first")]),
        (stored("D1\nU1"), []),
        (stored(STR + "U3\n+50"), [(5, 1, 2, "until-early")]),
        (stored("S10\nU3"), [(3, 1, 2, "until-early")]),
        (stored("S10\nA1\nU3"), []),
        (stored(STR + "+50\nU3"), []),
        (stored("A3\nC3"), [(3, 1, 2, "short-pulse")]),
        (stored("+50\n" + STR), [(2, 1, 3, "unset-speed")]),
        (stored("S10\nT100\n+50\n+50\nR10"), [(4, 1, 3, "unset-speed")]),
        (stored("S10\nT10\nR5\n+50"), [(5, 1, 3, "no-ramp")]),
        (stored(STR + "-21"), [(5, 1, 3, "rate-unreached")]),
        (stored("S10\nT100\nR1\n+3"), [(5, 1, 2, "rate-unreached")]),
        (stored("S10\nT100\nR1\n+4"), [(5, 1, 2, "sudden-ramp")]),
        (stored("S10\nT100\nR1\ng+"), [(5, 1, 2, "sudden-ramp")]),
        (stored("S10\nT100\nR2\ng+"), []),
        (stored(STR + "L0\n+50\nR1\nL2\nL0\nD1\nL2"), [(6, 1, 3, "sudden-ramp")]),  # each loop has its own start
        ("S10\nF\nA1", [(1, 1, 3, "not-now"), (3, 1, 2, "not-now")]),  # without P they are commands, and too early
        ("Po\nE", [(2, 1, 1, "empty-program")]),
        ("Po\nD1\nM\nE", [(2, 1, 2, "no-autorun")]),
        (f"Po\n{STR}M\nE", []),
        ("Po\nD1\nE\nA1", [(4, 1, 2, "not-now")]),
        ("Po\nH\nE", [(2, 1, 1, "not-now"), (3, 1, 1, "empty-program")]),
        ("Po\nD1\nP", [(3, 1, 1, "unknown-command")]),
    ],
)
def test_odd_lines(text, expected):
    assert found(text) == expected


@rows(
    ("text", "expected"),
    [
        (f"I1\nP\n{STR}+50\n-51\nE", [(7, 1, 3, "overflow-counter")]),
        (f"P\n{STR}G9999999\n+30\nE", [(6, 1, 3, "overflow-counter")]),
        (f"I2\nP\n{STR}-51\nE", []),  # the position is not known
        (f"I1\nP\n{STR}L0\n+30\n-40\nL2\nE", [(8, 1, 3, "overflow-counter")]),
        (f"I1\nP\n{STR}L0\n+30\nL2\n-40\nE", []),
        (f"I1\nP\n{STR}G-\nE", [(6, 1, 2, "counter-end")]),
        (f"I1\nP\n{STR}G+\nE", [(6, 1, 2, "counter-end")]),
        (f"H\nP\n{STR}G-1\nE", []),
        ("f+1", [(1, 1, 3, "unknown-command")]),
    ],
)
def test_the_counter_of_the_gs_c200_has_ends(text, expected):
    assert found(text, C200) == expected


def test_severities_and_texts():
    (down,) = problems(f"I1\nP\n{STR}G-\nE", C200)
    (up,) = problems(f"I1\nP\n{STR}G+\nE", C200)
    assert (down.severity, up.severity) == ("warning", "note")
    assert up.found == "G+ from 0 ends with E5 after 9999999 steps unless K or Z comes first"
    (short,) = problems(stored(STR + "+15"), C200S)
    assert (short.severity, short.found) == (
        "note",
        "T100 is not reached: each ramp takes 10 steps, but the move has 15",
    )
    assert short.remedy == "the move reaches 777 steps/s; T is reached in moves of 22 steps or more"
    (sudden,) = problems(stored("S10\nT100\nR1\n+9"), C200S)
    assert (sudden.severity, sudden.remedy) == ("note", "use a longer R")
    assert sudden.found == "R1 has no rate between S and T: 100 steps/s, then 1000, and back as abruptly"
    assert [problem.severity for problem in problems(stored("D1\nL2"), C200S)] == ["note"]
    assert [problem.severity for problem in problems(stored("L0\nD1\nL3\nD2\nL2"), C200S)] == ["warning"]
    (inside,) = problems(stored("j3\nA1"), C200S)
    assert (
        inside.message
        == "JUMP to location 3, inside A1 of line 3: allowed 2 or 4 (GS-C200S manual, command descriptions)"
    )


def test_a_motion_is_judged_with_the_speeds_of_every_path_that_leads_to_it():
    text = stored("S10\nT100\nR10\njc1,18\nD1\nR50\n+60")  # 18 is the R50, which one way passes by
    assert found(text) == [(5, 5, 2, "branch-middle"), (8, 1, 3, "rate-unreached")]
    assert found(text.replace("jc1,18", "jc1,20")) == [(8, 1, 3, "rate-unreached")]


@given(st.text(alphabet="PoxESTR+-L0123jcgGAWUZ,\n ;@", max_size=80), st.sampled_from([C200, C200S]))
def test_it_never_gives_up(text, part):
    assert all(problem.line >= 1 for problem in problems(text, part))
