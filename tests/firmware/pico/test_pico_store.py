"""M on a Pico: two sectors of a flash memory in turn, and a supply that fails at any instant."""

from __future__ import annotations

import random
from collections import Counter

import pytest

from tools import pico as tool

from .emulated import US, Emulator, Pico

pytestmark = pytest.mark.system
RATE = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
A, B, SECTOR = 0x1FE000, 0x1FF000, 4096
MS = 1000 * US
ERASE, PROGRAM = 45 * MS, 400 * US  # of the memory in the emulator


def started(boards: Emulator, **straps: int) -> Pico:
    """A board that listens."""
    board = Pico(boards, **(RATE | straps))
    wake(board)
    return board


def wake(board: Pico) -> None:
    """Switch the supply on."""
    board.power_up()
    board.run(board.up + 1 * MS)


def enter(board: Pico, *lines: str) -> None:
    """Enter a program."""
    assert board.ask("Po") == "Y\r"
    for line in lines:
        assert board.ask(line) == "Y\r"


def listed(board: Pico) -> str:
    """Return the program that X brings, or the answer to X."""
    said = board.ask("X")
    return said if said != "Y\r" else board.ask("Q", 40)


def test_a_program_survives_the_supply_and_comes_back_with_x(boards: Emulator) -> None:
    board = started(boards)
    enter(board, "S100", "T500", "R9", "+7")
    assert board.ask("M", 260) == "Y\r"
    board.fail(1)
    wake(board)
    assert board.ask("Q") == "END\r"
    assert listed(board) == "S100\rT500\rR9\r+7\rEND\r"


def test_while_it_is_written_every_line_is_answered_busy(boards: Emulator) -> None:
    board = started(boards)
    enter(board, "S100", "T500")
    end = board.send(b"M\r")
    board.run(end + 3 * MS)
    for _ in range(5):
        assert board.ask("F") == "B\r"
    board.run(board.now + 90 * MS)
    assert board.ask("F") == "R\r"
    assert "".join(character for _, character in board.characters()).count("Y\r") == 4
    assert max(board.edges("rdy"))[1] == 1


def test_the_sectors_are_written_in_turn_and_nothing_else_is(boards: Emulator) -> None:
    board = started(boards)
    for n in range(4):
        enter(board, f"S{n + 1}")
        assert board.ask("M", 80) == "Y\r"
    done = [(name, address) for _, name, address, _ in board.told["operations"]]
    assert done == [(name, address) for address in (A, B, A, B) for name in ("erase", "program")]


@pytest.mark.parametrize(
    ("damage", "answer"),
    [
        ([(A, b"\0"), (B, b"\0")], "E6\r"),  # neither is valid
        ([(A, b"\0")], "S2\rEND\r"),  # the newer one is
        ([(B, b"\0")], "S1\rEND\r"),  # the older one is
        ([(B + 4 + 4 + 1, b"\x11")], "S1\rEND\r"),
        ([(A, b"\xff" * SECTOR), (B, b"\xff" * SECTOR)], "END\r"),  # new from the factory: no program
        ([(A, b"\xff" * SECTOR), (B, b"\0")], "E6\r"),
    ],
)
def test_values_read_from_a_damaged_flash(boards: Emulator, damage: list[tuple[int, bytes]], answer: str) -> None:
    board = started(boards)
    for line in ("S1", "S2"):
        enter(board, line)
        assert board.ask("M", 80) == "Y\r"
    board.fail(1)
    board._ask(flash=[[at, data.hex()] for at, data in damage])
    wake(board)
    assert listed(board) == answer
    enter(board, "S3")  # and it is repaired by the next M
    assert board.ask("M", 80) == "Y\r"
    assert listed(board) == "S3\rEND\r"


def cut(boards: Emulator, times: int, seed: int) -> Counter[str]:
    """Write a program so many times, and let the supply fail in most of them; count what is found then."""
    chance, board = random.Random(seed), started(boards)
    enter(board, "S1000", "A1")
    assert board.ask("M", 80) == "Y\r"
    old, found = "S1000\rA1\rEND\r", Counter[str]()
    for n in range(times):
        board.forget()
        lines = [f"S{n % 999 + 1}", *(f"A{chance.randint(1, 3)}" for _ in range(chance.randint(0, 3)))]
        enter(board, *lines)
        new = "\r".join([*lines, "END"]) + "\r"
        end = board.send(b"M\r")
        begin = end + 1 * MS  # the erase
        at = chance.choice(
            (
                begin + chance.randint(-2000, ERASE),
                begin + ERASE + chance.randint(-2000, PROGRAM + 300 * US),
                begin + ERASE + PROGRAM + chance.randint(-1000, 2 * MS),
            )
        )
        board.run(at)
        board.fail(chance.getrandbits(31))
        board.run(board.now + 10)
        wake(board)
        now = listed(board)
        assert now in (old, new), (n, at - begin, now)
        found["old" if now == old else "new"] += 1
        old = now
    return found


def test_after_a_power_failure_it_is_the_old_program_or_the_new_one(boards: Emulator) -> None:
    found = cut(boards, 40, 56)
    assert found["old"] > 10 and found["new"] > 3


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_a_thousand_power_failures(boards: Emulator) -> None:
    found = cut(boards, 1000, 1956)
    assert found["old"] > 300 and found["new"] > 100


def test_the_rule_of_the_model_is_an_option_of_the_build(boards: Emulator, tmp_path) -> None:
    strict = Emulator(tool.build(tmp_path, "-DSTORE_LIKE_THE_MODEL"))
    try:
        board = started(strict)
        enter(board, "S100")
        assert board.ask("M", 80) == "Y\r"
        enter(board, "S200")
        board.run(board.send(b"M\r") + 20 * MS)
        board.fail(3)
        board.run(board.now + 10)
        wake(board)
        assert listed(board) == "E6\r"
        enter(board, "S300")
        assert board.ask("M", 80) == "Y\r"
        assert listed(board) == "S300\rEND\r"
    finally:
        strict.close()


def test_rec_recalls_homes_and_runs_without_a_host(boards: Emulator) -> None:
    board = started(boards)
    enter(board, "S100", "T500", "R9", "+7")
    assert board.ask("M", 260) == "Y\r"
    board.fail(1)
    board._ask(straps=[[7, 0], [11, 0], [10, 0]])  # REC, and both switches at once: the homing makes no step
    before = len(board.steps())
    wake(board)
    board.run(board.now + 100 * MS)
    assert len(board.steps()) - before == 7
