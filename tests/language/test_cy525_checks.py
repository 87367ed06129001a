"""What the linter knows about the CY525: ramps, H, rates on the fly.  The planner is the judge of its arithmetic."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slewline.chips.cy525.checks import checks
from slewline.chips.cy525.profile import move, rate
from slewline.chips.cy525.sheet import SHEET
from slewline.language.lint import lint
from tests.rows import rows

SET = "F 3\nR 127\nS 100\nZ 1\n"  # ramp: 4039 steps


def problems(text):
    return lint(text, SHEET, checks(SHEET))


def found(text):
    """What is told of a text, but that a motion without end is never stopped: that has a test of its own."""
    return [(problem.line, problem.code) for problem in problems(text) if problem.code != "no-abort"]


@rows(
    ("text", "codes"),
    [
        (SET + "N 8077\nG", [(6, "rate-unreached")]),
        (SET + "N 8078\nG", []),
        (SET + "N 8079\nG", [(6, "short-slew")]),
        (SET + "N 8333\nG", [(6, "short-slew")]),
        (SET + "N 8334\nG", []),
        (SET + "N 8333\nH\nG", [(7, "halt-too-short")]),
        (SET + "N 8334\nH\nG", []),
        (SET + "A 100\nP 8178\nP 100\nP 101", [(8, "rate-unreached")]),
        (SET + "A 100\nP 100\nN 5\nP 100", []),  # no step, no ramp
        (SET + "P 101", []),  # nobody knows from where
        (SET + "A 0\nN 9000\nG\nP 9", []),  # nor here
        (SET + "N 9000\nG\nH", [(7, "halt-unused")]),
        (SET + "N 9000\nH\nG\nG", []),
        (SET + "N 9000\nH\nG\nN 8218\nG", [(9, "short-slew")]),
        (SET + "N 9000\nH\nI\nG", [(6, "halt-unused")]),
        (SET + "A 0\nH\nP 100", [(7, "halt-too-short")]),
        ("F 3\nR 127\nS 1\nZ 4\nN 65000\nH\nG", []),
        ("F 3\nR 127\nS 1\nZ 5\nN 65000\nH\nG", [(7, "ramp-too-long")]),
        ("F 3\nR 112\nS 79\nZ 9\nN 65535\nH\nG", []),  # a ramp of 32639 steps
        ("F 4\nR 117\nS 72\nZ 8\nN 65535\nH\nG", [(7, "ramp-too-long")]),  # and of 32640
        ("F 10\nR 10\nN 100\nG", []),
        ("F 10\nR 10\nN 255\nH\nG", [(5, "halt-too-short")]),
        ("F 10\nR 10\nN 256\nH\nG", []),
        ("F 10\nR 9\nN 100\nG", [(4, "rate-below-first")]),
        ("F 3\nR 200\nS 100\nZ 1\nN 8077\nG", [(2, "range"), (6, "rate-unreached")]),
        ("R 2\nF 0", [(1, "rate-uncertain"), (2, "rate-uncertain")]),
        ("R 3\nF 3", []),
        ("F 10", []),
        ("F 11", [(1, "brisk-start")]),
        ("N 5\nG", [(2, "unset-register")]),
        ("N 5\nG\nG", [(2, "unset-register")]),
        ("F 3\nR 3\nN 5\nG", []),
        ("F 3\nR 3\nG", [(3, "unset-register")]),
        ("F 3\nR 4\nN 5\nZ 1\nG", [(5, "unset-register")]),
        ("F 3\nR 3\nA 0\nP 5", []),
        ("F 300\nR 300\nN 300\nG", [(1, "range"), (2, "range"), (1, "brisk-start")]),
    ],
)
def test_motions(text, codes):
    assert sorted(found(text)) == sorted(codes)


@rows(
    ("text", "codes"),
    [
        # registers set before the program, in it, and by the last pass of a loop
        (SET + "N 9000\nE\nG\n0\nQ\nX", []),
        (SET + "E\nN 100\nG\n0\nQ\nX", [(7, "rate-unreached")]),
        (SET + "N 9000\nE\nG\nN 100\nX\nQ\nX", [(7, "rate-unreached")]),
        (SET + "E\nG\n0\nQ\nN 100\nX", [(6, "rate-unreached")]),
        (SET + "E\nG\n0\nQ\nN 100", [(6, "rate-unreached")]),
        ("E\nG\n0\nQ\n" + SET + "N 100\nJ 0", [(2, "rate-unreached")]),
        ("E\nN 9000\nG\n0\nQ\n" + SET + "N 100\nJ 3", [(3, "rate-unreached")]),
        (SET + "E\nN 9000\nG\nN 100\n0\nQ\nX\n@until run=1\nG", [(13, "rate-unreached")]),
        (SET + "N 100\nE\nT A\nN 9000\nA$G\n0\nQ\nX", [(9, "rate-unreached")]),
        (SET + "N 9000\nE\nH\nT A\nG\nA$0\nQ\nX", []),
        (SET + "N 9000\nE\nH\n0\nQ\nX\n@until run=1\nG", []),
        (SET + "N 9000\nE\nH\n0\nQ\nX", [(7, "halt-unused")]),
        (SET + "N 100\nA 0\nE\nG\nX\nQ\nX", [(8, "rate-unreached")]),
        (SET + "N 100\nE\nG\n0\nQ\nE\nN 9000\nG\n0\nQ\nX", [(7, "rate-unreached")]),
        (SET + "N 9000\nE\nG\n0\nQ\nE\nN 100\nG\n0\nQ\nX", [(12, "rate-unreached")]),
    ],
)
def test_programs(text, codes):
    assert found(text) == codes


HALT = "F 3\nR 80\nS 200\nZ 1\nN 65000\nH\nG\n"


@rows(
    ("directives", "codes"),
    [
        ("@drive abort=0", []),
        ("@rate 60\n@drive abort=0", [(9, "crash-stop")]),
        ("@rate 60\n@rate 100\n@drive abort=0", [(10, "crash-stop")]),
        ("@rate 127\n@drive abort=0", []),
        ("@rate 80\n@drive abort=0", []),
        ("@rate 3\n@wait 1 s\n@drive abort=0", []),
        ("@rate 60\n@rate 3\n@drive abort=0", []),
        ("@rate 60\n@drive abort=1", []),
        ("@rate 0", [(8, "zero-rate")]),
        ("@rate 3\n@rate 0", []),
        ("@rate 128", [(8, "range")]),
        ("@drive abort=0\n@rate 5", [(9, "rate-without-halt")]),
        ("@wait 2 ms", []),
    ],
)
def test_rates_on_the_fly(directives, codes):
    assert found(HALT + directives) == codes


def test_rate_without_halt():
    assert found("F 3\nR 3\nN 500\nG\n@rate 5") == [(5, "rate-without-halt")]


def test_rates_on_the_fly_of_a_program():
    assert found(HALT.replace("H\nG\n", "E\nH\nG\n0\nQX\n") + "@rate 60\n@drive abort=0") == [(12, "crash-stop")]


@rows(
    ("behind", "told"),
    [
        ("", True),
        ("@wait 1 s\n@rate 0", True),  # not at an end: another rate may come
        ("@drive abort=1", True),
        ("@drive abort=0@1 s", False),
        ("@pulse abort=0 20 us", False),
        ("@reset", False),
        ("@drive reset=0", False),
        ("@power off", False),
        ("@tell switch close", False),
    ],
)
def test_an_unstoppable_endless_motion_is_reported_once(behind, told):
    text = HALT.removesuffix("H\nG\n") + "H\nG\nH\nG\n" + behind
    lines = [(problem.line, problem.severity) for problem in problems(text) if problem.code == "no-abort"]
    assert lines == ([(7, "note")] if told else [])


def test_a_halt_that_has_no_effect_needs_no_abort():
    assert [problem.code for problem in problems(SET + "N 8333\nH\nG")] == ["halt-too-short"]
    assert [problem.code for problem in problems(SET + "H\nP 5")] == []  # nobody knows how far it is


def test_an_unreached_rate_is_reported_once_with_the_lines_of_all_such_moves():
    (problem,) = problems(SET + "A 0\nP 100\nE\nN 10\nA$G\nN 20\nT A\n0\nQX\n@until run=1\nP 300")
    assert (problem.line, problem.code) == (6, "rate-unreached")
    assert "the move has 100" in problem.found
    assert problem.remedy.endswith(" steps/s; it is not reached in line 9 either")
    (problem,) = problems(SET + "N 10\nG\nG\nG")
    assert problem.remedy.endswith(" steps/s; it is not reached in lines 7, 8 either")


def test_the_ramp_is_reported():
    (problem,) = problems(SET + "N 8218\nG")
    left = "its two ramps take 8078 of its 8218 steps; the remaining 140 are output at F 3, which takes 467 ms"
    assert problem.found == f"the move does not slew: {left}"
    assert (problem.remedy, problem.severity) == ("use a move of 8078 steps, or of at least 8334", "warning")


@pytest.mark.parametrize(("number", "severity"), [(8107, "note"), (8108, "warning")])
def test_a_short_crawl_is_only_a_note(number, severity):
    (problem,) = problems(SET + f"N {number}\nG")
    assert (problem.code, problem.severity) == ("short-slew", severity)


def test_the_top_rate_is_reported():
    (problem,) = problems(SET + "N 1000\nG")
    top = max(rate(move(1000, 3, 127, 100, 1), step) for step in range(1000))
    assert problem.remedy.startswith(f"the move reaches rate {top}, ")
    (problem,) = problems(SET + "N 1\nG")
    assert problem.remedy == "the move reaches rate 3, 300 steps/s"


@given(st.integers(0, 127), st.integers(0, 127), st.integers(1, 255), st.integers(1, 255), st.integers(1, 65535))
def test_the_planner_agrees(first, rate, slope, divisor, number):
    text = f"F {first}\nR {rate}\nS {slope}\nZ {divisor}\nN {number}\n"
    legs = {leg.name: leg.count for leg in move(number, first, rate, slope, divisor).legs}
    if rate > first:
        codes = {code for _, code in found(text + "G")}
        assert ("short-slew" in codes) == (
            "crawl" in legs and number - legs["crawl"] == 2 * full_ramp(first, rate, slope, divisor)
        )
    halted = {code for _, code in found(text + "H\nG")}
    assert bool(halted & {"ramp-too-long", "halt-too-short"}) == ("slew" not in legs)


def full_ramp(first, rate, slope, divisor):
    """Steps of a ramp that has all the room it needs."""
    return move(10**9, first, rate, slope, divisor).legs[0].count


@pytest.mark.parametrize(("size", "codes"), [(48, []), (49, [(50, "not-verifiable")]), (60, [(50, "not-verifiable")])])
def test_read_out_of_long_programs(size, codes):
    assert found("E\n" + "B\n" * (size - 1) + "0\nQ") == codes


def test_an_overflow_suppresses_other_findings():
    assert found("E\n" + "B\n" * 60 + "0\nQ") == [(62, "overflow")]
