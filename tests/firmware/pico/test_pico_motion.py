"""Steps of a Pico beside those of the model: at its pins, to the cycle."""

from __future__ import annotations

import random

import pytest

from .emulated import STACK, Emulator, Pico
from .model import MS, PIN_PS, STEP_PS, TOLERANCE_PS, US, Pair

pytestmark = pytest.mark.system
RATE = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}


def entered(boards: Emulator, *lines: str, **straps: int) -> Pair:
    """A board and a module that have a program."""
    pair = Pair(boards, **(RATE | straps))
    for line in ("Po", *lines, "Px"):
        pair.ask(line)
    return pair


def agree(pair: Pair) -> int:
    """Compare all that a board shows with the model; return the number of steps."""
    steps = pair.steps()
    assert abs(steps.first) <= TOLERANCE_PS and steps.later <= STEP_PS, steps
    assert pair.answers()[1] <= TOLERANCE_PS
    assert pair.pins() <= PIN_PS
    assert pair.board.off_the_grid() <= 1
    return steps.count


def test_moves_with_questions_in_between_are_those_of_the_model(boards: Emulator) -> None:
    pair = entered(boards, "S100", "T1000", "R200", "+1000", "-300", "A1", "+1", "C1", "+2", "-3")
    pair.ask("Q", 60)
    pair.ask("E")
    for _ in range(6):
        pair.ask("F")
        pair.wait(37 * MS)
    pair.ask("V1")
    pair.wait(1200 * MS)
    pair.ask("V1")
    assert agree(pair) == 1306


@pytest.mark.parametrize(
    ("start", "top", "ramp"), [(100, 1000, 1), (1000, 1000, 9), (1, 1000, 999), (990, 1000, 999), (500, 20, 3)]
)
def test_ramps_of_every_kind(boards: Emulator, start: int, top: int, ramp: int) -> None:
    pair = entered(boards, f"S{start}", f"T{top}", f"R{ramp}", "g+")
    pair.ask("E")
    pair.wait(300 * MS)
    pair.ask("Z")
    pair.wait(400 * MS)
    pair.ask("V1")
    pair.wait(3000 * MS)
    pair.ask("F")
    assert agree(pair) > 3


def test_an_inhibited_step_comes_five_microseconds_after_the_release_and_none_is_lost(boards: Emulator) -> None:
    pair = entered(boards, "S100", "T1000", "R60", "+1500")
    chance = random.Random(56)
    pair.ask("E")
    for _ in range(12):
        at = pair.now + chance.randint(0, 6 * MS)
        pair.drive("enable", 0, at)
        pair.drive("enable", 1, at + chance.randint(1, 5 * MS))
        pair.wait(12 * MS)
    pair.wait(200 * MS)
    assert agree(pair) == 1500


def test_a_hold_of_seconds_and_kill_and_zero_during_it(boards: Emulator) -> None:
    pair = entered(boards, "S100", "T900", "R60", "g+")
    for command in ("F", "K", "Z"):
        pair.ask("E")
        pair.wait(150 * MS)
        pair.drive("enable", 0)
        pair.wait(2500 * MS)
        pair.ask("F")
        pair.ask(command)
        pair.wait(300 * MS)
        pair.drive("enable", 1)
        pair.wait(300 * MS)
        pair.ask("K")
        pair.ask("V1")
    agree(pair)


def test_a_homing_goes_to_the_end_and_back(boards: Emulator) -> None:
    pair = entered(boards, "S800", "T1000", "R60", "+1")
    for eot, home in ((23_456, 61_234), (5_000, 5_001), (40_000, 40_700)):
        begin = pair.now
        pair.ask("H+")
        pair.drive("eot", 0, begin + eot * US)
        pair.drive("eot", 1, begin + eot * US + MS)
        pair.drive("home", 0, begin + home * US)
        pair.wait(90 * MS)
        pair.drive("home", 1)
        pair.ask("F")
        pair.ask("K")
    agree(pair)


def test_a_run_that_an_input_ends_and_loops_and_jumps(boards: Emulator) -> None:
    pair = entered(boards, "S50", "T800", "R20", "L0", "g+1", "A2", "g-2", "C2", "L3", "jc5,0", "W3", "+7")
    pair.ask("E")
    for n in range(6):
        pair.wait(61 * MS + n * 137 * US)
        pair.drive("ui1" if n % 2 == 0 else "ui2", 0)
        pair.wait(80 * MS)
        pair.drive("ui1" if n % 2 == 0 else "ui2", 1)
    pair.drive("ui2", 0)
    pair.wait(300 * MS)
    pair.ask("V2")
    pair.ask("K")
    agree(pair)


def test_kill_stops_at_its_instant_and_the_count_is_that_of_the_edges(boards: Emulator) -> None:
    pair = entered(boards, "S300", "T1000", "R9", "g+")
    chance = random.Random(7)
    for _ in range(12):
        pair.ask("E")
        pair.wait(chance.randint(5 * MS, 30 * MS))
        pair.ask(chance.choice("KKZ"))
        pair.wait(20 * MS)
        pair.ask("K")
        pair.ask("V1")
    agree(pair)
    said, _ = pair.answers()
    assert int(said.rsplit("V", 1)[1]) == len(pair.board.steps())


def test_a_third_of_the_processor_is_free_at_ten_thousand_steps_a_second(boards: Emulator) -> None:
    board = Pico(boards, **RATE)
    board.power_up()
    board.run(board.up + 132_000)
    for line in ("Po", "S900", "T1000", "R99", "g+"):
        assert board.ask(line) == "Y\r"
    board.ask("E", 0)
    shares = []
    for _ in range(40):
        asleep, begin = board.told["asleep"], board.now
        board.run(begin + 132_000)
        shares.append((board.told["asleep"] - asleep) / (board.now - begin))
    assert len(board.steps()) > 350
    assert min(shares) > 0.25  # on the last steps of the ramp
    assert min(shares[-20:]) > 0.6  # at 10,000 steps/s
    assert board._ask(stack=STACK)["stack"] < 2048


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_a_million_steps_do_not_drift(boards: Emulator) -> None:
    pair = entered(boards, "S100", "T1000", "R999", "+999999")
    pair.ask("E")
    for _ in range(106):
        pair.wait(1000 * MS)
    pair.ask("V1")
    steps = pair.steps()
    assert steps.count == 999_999
    assert abs(steps.first) <= TOLERANCE_PS and steps.later <= STEP_PS, steps
