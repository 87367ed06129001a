"""What is wired to a board: drivers, rates, outputs; and which horizon a machine needs."""

from __future__ import annotations

import pytest

import slewline
from slewline.drive.board.boards import UNO
from slewline.drive.promptness import recommended_ms
from slewline.drive.terminals import outputs_of, polarity_of
from slewline.errors import UnknownName, UsageError


def test_a_driver_says_how_it_is_enabled_and_what_its_pulses_must_be():
    assert polarity_of(UNO, "DM542") == polarity_of(UNO, "a4988") == 2  # ENABLE is active low
    assert polarity_of(UNO, "L297") == polarity_of(UNO, None) == 0
    with pytest.raises(UnknownName, match="did you mean DM542"):
        polarity_of(UNO, "DM524")
    for short in ("high", "low", "setup", "hold"):  # 1 us, and a DM542 needs 2.5 and 5
        with pytest.raises(UsageError, match=r"driver DM542: .* 1 µs at least, and it needs"):
            polarity_of(UNO._replace(**{short: 16}), "DM542")


def test_outputs_are_those_that_programs_set_or_those_that_are_wired():
    x = slewline.Bench().add("gs-c200s", "x")
    assert outputs_of(UNO, x, None) == {0: "uo1", 1: "uo2", 2: "uo3"}
    assert outputs_of(UNO, x, {"d12": "mov"}) == {3: "mov"}
    with pytest.raises(UsageError, match="allowed D2, D3, D8, D12"):
        outputs_of(UNO, x, {"D4": "uo1"})


def test_a_horizon_is_three_times_the_worst_that_was_seen():
    assert [recommended_ms(late, 2) for late in (1, 10, 20, 60, 900)] == [20, 50, 100, 250, 1000]
