"""What lint says of the CY545's motions, from the values after reset on."""

from __future__ import annotations

import pytest

from slewline.chips import checks_of, sheet_of
from slewline.language.lint import lint
from tests.rows import rows


def codes(*lines: str) -> list[tuple[int, str]]:
    """Line and code of everything odd about a text."""
    return [(each.line, each.code) for each in lint("\n".join(lines), sheet_of("cy545b"), checks_of("cy545b"))]


def test_a_correct_text_has_no_findings() -> None:
    assert codes("+", "F 14", "R 100", "S 220", "N 3199", "G", "P 10000", "H 0", "P 4000", "-", "G") == []


@pytest.mark.fact("CY545-UND-RESET-DIRECTION")
@rows("before", ["+", "-", "P 5000", "H 0"])
def test_the_first_g_after_reset_needs_a_direction(before: str) -> None:
    assert codes("N 5000", "G") == [(2, "no-direction")]
    assert codes("N 5000", before, "G") == []
    assert codes("+", "N 5000", "G", "I", "N 5000", "G") == [(6, "no-direction")]


@pytest.mark.fact("CY545-DER-RAMP-STEPS")
def test_a_move_of_exactly_two_ramps_does_not_reach_its_rate() -> None:
    assert codes("+", "N 3198", "G") == [(3, "short-move")]
    assert codes("+", "N 3199", "G") == []
    assert codes("A 100", "P 3298", "P 100") == [(2, "short-move"), (3, "short-move")]
    assert codes("A 100", "P 3299") == []
    assert codes("S 250", "+", "N 600", "G") == []


def test_values_of_switches_are_not_guessed() -> None:
    assert codes("+", "N #", "G", "P #", "P 10") == []
    assert codes("+", "R #", "N 5", "G") == []


def test_a_continuous_motion_is_never_too_short_and_leaves_no_position() -> None:
    assert codes("+", "C", "N 0", "G", "P 5") == []
    assert codes("+", "N 0", "G") == [(3, "no-steps")]
    assert codes("+", "C", "G", "N 5", "G") == [(5, "short-move")]


def test_r_below_f_is_a_warning_and_a_program_is_walked_too() -> None:
    assert codes("+", "R 10", "N 20", "G") == [(4, "rate-below-first")]
    assert codes("E", "+", "N 20", "G", "0", "Q", "Y 0", "X") == [(4, "short-move")]
