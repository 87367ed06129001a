"""What stops a Pico in motion: ENABLE, K, a reset.  No step follows after a microsecond, and the count is right."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest

from .emulated import US, Emulator, Pico

pytestmark = pytest.mark.system
RATE = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
MS = 1000 * US


def in_motion(boards: Emulator, chance: random.Random) -> Pico:
    """A board with an endless run in its memory."""
    board = Pico(boards, **RATE)
    board.power_up()
    board.run(board.up + 1 * MS)
    enter(board, chance)
    return board


def enter(board: Pico, chance: random.Random) -> None:
    """Enter an endless run."""
    start = chance.randint(100, 1000)
    for line in (
        "Po",
        f"S{start}",
        f"T{chance.randint(100, 1000)}",
        f"R{chance.randint(1, 60)}",
        f"g{chance.choice('+-')}",
        "Px",
    ):
        assert board.ask(line, 3) == "Y\r"


def stop(boards: Emulator, times: int, seed: int) -> int:
    """Stop a motion so many times; return how many steps were made in all."""
    chance = random.Random(seed)
    board = in_motion(boards, chance)
    total = 0
    for _ in range(times):
        board.run(board.send(b"E\r") + chance.randint(3 * MS, 20 * MS))
        what = chance.choice(("enable", "K", "reset"))
        # K acts a millisecond after its line: GSC-UND-TURNAROUND
        at = board.send(b"K\r") + 1 * MS if what == "K" else board.now + chance.randint(1, 2 * MS)
        if what == "enable":
            board.drive("enable", 0, at)
        if what == "reset":
            board.run(at)
            board.fail(1)
            board.power_up()
        board.run(board.now + 12 * MS)
        assert not [cycle for cycle in board.steps() if cycle > at + US], what
        made = len(board.steps())
        if what == "reset":
            assert board.ask("V1") == "V+0\r"
            enter(board, chance)
        else:
            board.ask("K")
            assert abs(int(board.ask("V1", 12)[1:])) == made, what
            board.drive("enable", 1, board.now + 1)
            board.ask("I1")
        total += made
        board.forget()
    return total


def test_no_step_follows_enable_k_or_a_reset(boards: Emulator) -> None:
    assert stop(boards, 24, 56) > 200


def test_no_step_of_a_homing_follows_its_switch(boards: Emulator) -> None:
    board = Pico(boards, **RATE)
    board.power_up()
    board.run(board.up + 1 * MS)
    for line in ("Po", "S1000", "T1000", "R1", "+1", "Px"):
        assert board.ask(line, 3) == "Y\r"
    turned = 0
    for tenths in (11, 13, 16, 20, 25, 30, 40, 60, 90):  # of a microsecond, before a step
        board.forget()
        board.run(board.send(b"H+\r") + 3 * MS)
        at = board.steps()[-1] + 300 * US - tenths * US // 10
        assert at > board.now
        board.drive("eot", 0, at)
        board.run(at + 400 * US)
        after = [cycle - at for cycle in board.steps() if cycle > at]
        assert min(after) > 9 * US, tenths  # the way back begins when DIR has been set for 10 us
        turned += len(after)
        board.drive("eot", 1, board.now + 1)
        board.ask("K", 12)
    assert turned > 20


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_no_step_follows_six_hundred_of_them(boards: Emulator) -> None:
    assert stop(boards, 600, 1956) > 5000


def test_a_pulse_that_has_begun_is_completed(boards: Emulator) -> None:
    chance = random.Random(5)
    board = in_motion(boards, chance)
    for _ in range(3):
        board.send(b"E\r")
        board.run(board.now + 30 * MS)
        board.ask("K", 12)
    falls, widths = board.edges("clock"), set()
    for (low, level), (high, _) in pairwise(falls):
        if level == 0:
            widths.add(high - low)
    assert max(widths) <= 5 * US and min(widths) >= 1.6 * US  # 1.7 us, at most 5
