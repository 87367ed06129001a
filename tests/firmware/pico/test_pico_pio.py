"""The PIO of the emulator, by programs whose timing the data sheet of the RP2040 gives: a cycle each, and the delay."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from . import needs

pytestmark = pytest.mark.system
HIGH, LOW, AGAIN = 0xE001, 0xE000, 0x0000


def measured(cycles: int, *words: int) -> dict[str, list[list[int]]]:
    """Return the edges that a program makes in both emulators."""
    needs.need()
    script = Path(__file__).with_name("measure.js")
    call = ["node", str(script), str(needs.RP2040JS), str(cycles), *map(str, words)]
    return json.loads(subprocess.run(call, capture_output=True, text=True, check=True).stdout)


def test_a_square_wave_has_its_period_here_and_not_in_rp2040js() -> None:
    found = measured(64, HIGH | 9 << 8, LOW | 4 << 8, AGAIN)  # 10 cycles high, 5 and 1 low
    assert [cycle for cycle, _ in found["ours"]] == [1, 11, 17, 27, 33, 43, 49, 59]
    assert found["theirs"][:3] == [[0, 1], [1, 0], [3, 1]]  # its delays take no time: why there is one of our own


def test_a_loop_that_counts_down_is_passed_in_one_go_and_lasts_as_long() -> None:
    count = 0x0040 | 3 << 8  # jmp x-- to itself, with a delay of 3
    long = measured(400, 0xE020 | 20, HIGH, count | 2, LOW, AGAIN)["ours"]
    assert long[1][0] - long[0][0] == 1 + 21 * 4
    assert long[2][0] - long[0][0] == 1 + 21 * 4 + 3
