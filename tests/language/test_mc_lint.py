"""What the linter finds in scripts for the MC1451A family, and what it lets pass."""

from __future__ import annotations

import pytest

from slewline.chips import checks_of, sheet_of
from slewline.language.lint import lint
from tests.rows import rows

START = "SET_VEL 65536\nSET_ACC 1024\nSET_POS 1000\nUPDATE\n"  # a move that is in order


def found(text, part="mc1451a"):
    """(line, code) of everything that the linter tells."""
    return [(problem.line, problem.code) for problem in lint(text, sheet_of(part), checks_of(part))]


HOMING = """\
GET_HOME
SET_POS 12345
SET_VEL 23456
SET_ACC 345
UPDATE
SET_EXT_BRK
STOP               ; waits for the breakpoint
wait motion_complete
"""
RECOVERY = """\
SET_STEP_RATIO 80
SET_POS_ERR 100
SET_AUTO_STOP_ON
wait motion_error
SYNCH_PRFL
UPDATE
MTR_ON
"""
TOGETHER = "".join(f"SET_{n}\nSET_VEL 5\nSET_ACC 5\nSET_POS 5\n" for n in (1, 2)) + "MULTI_UPDATE 3\n"


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        ("expect 5", [(1, "nothing-returned")]),
        ("SET_POS 5\n@expect 5\nRESET", [(2, "nothing-returned")]),
        ("GET_POS\nexpect 0\nexpect 0", []),
    ],
)
def test_an_expectation_needs_a_command_above_that_returns_something(text, codes):
    assert found(text) == codes


@rows("text", [START, HOMING, TOGETHER, f"SET_PRFL_TRAP\n{START}", "RESET\n" + START])
def test_scripts_in_order_pass(text):
    assert found(text) == []


def test_the_recovery_from_a_stall_passes_with_an_encoder_and_is_noted_without():
    assert found(RECOVERY, "mc1451a-e") == []
    assert found(RECOVERY) == [(1, "no-encoder"), (2, "no-encoder"), (3, "no-encoder"), (5, "no-encoder")]


@rows(
    ("before", "codes"),
    [
        ("SET_VEL 1048576\n", []),
        ("SET_VEL 1048577\n", [(1, "pulse-range")]),
        ("SET_OUTPUT_HIGH\nSET_VEL 1048577\n", []),
        ("SET_VEL 1048577\nSET_OUTPUT_HIGH\n", []),
        ("SET_OUTPUT_HIGH\nSET_VEL 33554433\n", [(2, "pulse-range")]),
        ("SET_OUTPUT_HIGH\nSET_OUTPUT_STNDRD\nSET_VEL 33554432\n", [(3, "pulse-range")]),
        ("SET_2\nSET_OUTPUT_HIGH\nSET_1\nSET_VEL 33554432\n", [(4, "pulse-range")]),
        ("SET_PRFL_GEAR\nSET_VEL 1048577\n", [(1, "no-encoder"), (2, "no-start"), (2, "unused-parameter")]),
    ],
)
def test_a_velocity_above_the_pulse_range(before, codes):
    assert found(before + "UPDATE") == codes


@rows(("start", "codes"), [(16383, []), (16384, [(2, "no-ramp")]), (99999, [(2, "no-ramp")]), (0, [])])
def test_a_start_velocity_that_leaves_no_ramp(start, codes):
    assert found(f"SET_VEL 16384\nSET_START_VEL {start}\nUPDATE") == codes
    assert found(f"SET_PRFL_S_CRV\nSET_VEL 16384\nSET_START_VEL {start}\nUPDATE") == []


@rows(
    ("text", "codes"),
    [
        (START + "SET_POS 5", [(5, "no-update")]),
        (START + "STOP", [(5, "no-update")]),
        ("SET_POS 5\nSET_2\nUPDATE", [(1, "no-update")]),
        ("SET_POS 5\nMULTI_UPDATE 2", [(1, "no-update")]),
        (START + "SET_POS 5\nSET_MTN_CMPLT_BRK", []),
        (START + "SET_MTN_CMPLT_BRK\nSET_POS 5\nSET_BRK_OFF", [(6, "no-update")]),
        (START + "SET_AUTO_UPDATE_OFF\nSET_EXT_BRK\nSTOP", [(7, "no-update")]),
        ("SET_I\nSTOP\nUPDATE", []),
        ("SET_POS 5\nSET_I\nUPDATE", [(1, "no-update")]),
        ("SET_POS 5\nRESET", []),
    ],
)
def test_buffered_values_never_updated(text, codes):
    assert found(text) == codes


@rows(
    ("mode", "line", "used"),
    [
        ("SET_PRFL_S_CRV", "SET_ACC 5", False),
        ("SET_PRFL_S_CRV", "SET_MAX_ACC 5", True),
        ("SET_PRFL_TRAP", "SET_JERK 5", False),
        ("SET_PRFL_TRAP", "SET_ACC 5", True),
        ("SET_PRFL_VEL", "SET_POS 5", False),
        ("SET_PRFL_VEL", "SMOOTH_STOP", True),
        ("SET_PRFL_GEAR", "SMOOTH_STOP", False),
        ("SET_PRFL_GEAR", "STOP", True),
        ("SET_PRFL_GEAR", "SET_RATIO 5", True),
    ],
)
def test_buffered_values_unused_by_the_mode(mode, line, used):
    assert found(f"{mode}\n{line}\nUPDATE", "mc1451a-e") == ([] if used else [(2, "unused-parameter")])
    assert "unused-parameter" not in dict(map(reversed, found(f"{line}\nUPDATE", "mc1451a-e")))  # which mode is it?


@rows(
    ("text", "codes"),
    [
        ("RESET\nSET_VEL 5\nSET_POS 5\nUPDATE", [(3, "no-start")]),
        ("SET_VEL 5\nSET_POS 5\nUPDATE", [(2, "no-start")]),
        ("SET_POS 5\nSET_VEL 5\nMULTI_UPDATE 1", [(2, "no-start")]),
        ("SET_VEL 5\nSET_ACC 0\nSET_POS 5\nUPDATE", [(3, "no-start")]),
        ("SET_VEL 5\nSET_START_VEL 1\nSET_POS 5\nUPDATE", []),
        ("SET_VEL 5\nSET_POS 5\nSET_2\nSET_ACC 5\nUPDATE", [(2, "no-update")]),  # of another axis
        ("SET_VEL 5\nUPDATE", []),  # nobody says that it should move
        ("SET_POS 5\nUPDATE", [(1, "no-start")]),  # nor how fast
        ("SET_VEL 0\nSET_ACC 5\nSET_POS 5\nUPDATE", []),  # on purpose
        ("SET_I\nSET_VEL 5\nSET_POS 5\nUPDATE", []),  # nobody knows which axis
        ("SET_PRFL_S_CRV\nSET_VEL 5\nSET_POS 5\nUPDATE", [(3, "no-start")]),
        ("SET_PRFL_S_CRV\nSET_VEL 5\nSET_ACC 5\nSET_POS 5\nUPDATE", [(3, "unused-parameter"), (4, "no-start")]),
        ("SET_PRFL_S_CRV\nSET_VEL 5\nSET_JERK 5\nSET_POS 5\nUPDATE", [(4, "no-start")]),
        ("SET_PRFL_VEL\nSET_VEL 5\nSET_START_VEL 1\nUPDATE", [(2, "no-start")]),
        ("SET_PRFL_VEL\nSET_VEL 5\nSET_ACC 5\nUPDATE", []),
        ("RESET\nSET_VEL 5\nSET_START_VEL 1\nSET_POS 5\nUPDATE", []),
        ("RESET\nSET_PRFL_S_CRV\nSET_VEL 5\nSET_MAX_ACC 5\nSET_POS 5\nUPDATE", [(5, "no-start")]),
        ("RESET\nSET_PRFL_S_CRV\nSET_VEL 5\nSET_MAX_ACC 5\nSET_JERK 5\nSET_POS 5\nUPDATE", []),
        ("SET_PRFL_TRAP\nSET_ACC -5\nUPDATE", [(2, "acceleration-sign")]),
        ("SET_PRFL_VEL\nSET_VEL 5\nSET_ACC -5\nUPDATE", []),
    ],
)
def test_accelerations_with_which_nothing_starts(text, codes):
    assert found(text) == codes


@rows(
    ("text", "codes"),
    [
        ("SET_POS_BRK\nSET_BRK_PNT 5", [(1, "breakpoint-value")]),
        ("SET_BRK_PNT 5\nSET_POS_BRK", []),
        ("SET_BRK_PNT 5\nSET_2\nSET_TIME_BRK", [(3, "breakpoint-value")]),
        ("SET_EXT_BRK", []),
        ("SET_MTN_CMPLT_BRK", []),
        ("RESET\nSET_POS_BRK", []),
    ],
)
def test_a_breakpoint_that_is_armed_before_its_value(text, codes):
    assert found(text) == codes


def test_axes_that_a_part_does_not_have():
    assert found("MULTI_UPDATE 15", "mc1251a") == [(1, "absent-axis")]
    assert found("MULTI_UPDATE 3", "mc1251a") == []
    assert found("SET_3", "mc1251a") == [(1, "unknown-command")]


def test_auto_stop_without_a_step_ratio():
    assert found("SET_AUTO_STOP_ON", "mc1451a-e") == [(1, "no-step-ratio")]
    assert found("SET_STEP_RATIO 0\nSET_AUTO_STOP_ON", "mc1451a-e") == [(2, "no-step-ratio")]
    assert found("SET_AUTO_STOP_ON\nSET_STEP_RATIO 256", "mc1451a-e") == []
    assert found("SET_AUTO_STOP_ON") == [(1, "no-encoder")]


def test_nothing_is_reported_twice():
    text = "SET_VEL 9999999\nUPDATE\nUPDATE\nUPDATE"
    assert found(text) == [(1, "pulse-range")]


def test_words_that_direct_the_host_are_not_the_linter_s_business():
    assert found("GET_STATUS\nwait 20 ms\nWAIT motion_complete\nexpect 0301\n@wait 5 ms\n") == []


def test_a_mistake_is_shown_with_its_place_and_the_manual():
    (problem,) = lint("  SET_VEL 0x200000\nUPDATE", sheet_of("mc1451a"), checks_of("mc1451a"))
    assert (problem.line, problem.column, problem.length, problem.severity) == (1, 3, 16, "warning")
    assert problem.message == (
        "32 steps/cycle exceeds the pulse range: the axis will run at 16 steps/cycle "
        "(MC1451A manual, command reference)"
    )
    assert problem.remedy == "SET_OUTPUT_HIGH allows 512 steps/cycle"
