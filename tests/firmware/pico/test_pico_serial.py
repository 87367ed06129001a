"""The line of a Pico: eight rates, checksums, addresses, several modules; each bit on the grid to the cycle."""

from __future__ import annotations

from itertools import pairwise

import pytest

from slewline.language.lines import framed

from .emulated import BAUDS, HZ, US, Emulator, Pico
from .model import MS, PIN_PS, TOLERANCE_PS, Pair

pytestmark = pytest.mark.system


def strapped(rate: int, address: int = 0, **more: int) -> dict[str, int]:
    """Return the straps of a rate and an address."""
    sel = {f"sel{n}": (7 - address) >> (2 - n) & 1 for n in range(3)} if address else {}
    return {"br0": rate & 1, "br1": rate >> 1 & 1, "br2": rate >> 2 & 1, "chs": 0} | sel | more


def agree(pair: Pair) -> str:
    """Compare answers and pins with the model; return the answers."""
    said, worst = pair.answers()
    assert worst <= TOLERANCE_PS
    assert pair.board.off_the_grid() <= 1
    assert (
        pair.pins() <= PIN_PS + 10**12 * pair.board.bit // HZ // 16
    )  # a bit is looked at on a clock of sixteen times the rate
    return said


@pytest.mark.parametrize("rate", BAUDS)
def test_every_rate(boards: Emulator, rate: int) -> None:
    pair = Pair(boards, **strapped(rate))
    assert HZ % BAUDS[rate] == 0  # each bit has a whole number of cycles
    for line in ("F", "Po", "S100", "zoo", "Q", "V2"):
        pair.ask(line)
        pair.wait(11 * 10 * 10**12 // BAUDS[rate])
    assert agree(pair) == "R\rY\rY\rE4\rS100\rEND\rV70\r"


def test_lines_with_checksums(boards: Emulator) -> None:
    pair = Pair(boards, **strapped(0, chs=1))
    for line in (b"F", b"Po", b"S100", b"Px", b"V1"):
        pair.send(framed(line))
        pair.wait(9 * MS)
    pair.send(b"FX\r")
    pair.wait(9 * MS)
    assert agree(pair).count("\r") == 6


def test_chs_is_sampled_with_each_line(boards: Emulator) -> None:
    pair = Pair(boards, **strapped(0))
    for level in (1, 0, 1):
        pair.drive("chs", level)
        pair.wait(MS)
        pair.send(framed(b"V1") if level else b"V1\r")
        pair.wait(9 * MS)
    agree(pair)


def test_a_parity_or_framing_fault_is_e1_and_one_stop_bit_is_enough(boards: Emulator) -> None:
    board = Pico(boards, **strapped(0))
    board.power_up()
    board.run(board.up + 1000 * US)
    for wrong in ({"parity": True}, {"framing": True}, {"stops": 1}):
        end = board.send(b"V2", **wrong)
        end = board.send(b"\r", end)
        board.run(end + 9000 * US)
    assert "".join(character for _, character in board.characters()) == "E1\rE1\rV70\r"


def test_two_lines_in_a_row_are_both_obeyed_and_a_third_is_lost(boards: Emulator) -> None:
    pair = Pair(boards, **strapped(0))
    pair.send(b"F\rV1\rV2\rV2\r")
    pair.wait(60 * MS)
    agree(pair)


def test_three_modules_on_a_line_answer_to_their_own_addresses(boards: Emulator) -> None:
    pairs = {address: Pair(boards, n, **strapped(0, address)) for n, address in enumerate((1, 4, 7))}
    lines = ("1Po", "4Po", "7V1", "1S100", "4S200", "3F", "F", "1Q", "4Q", "7Q", "1", "7F")
    for line in lines:
        for pair in pairs.values():
            pair.send(line.encode() + b"\r")
            pair.wait(14 * MS)
    said = {address: agree(pair) for address, pair in pairs.items()}
    assert said == {1: "Y\rY\rS100\rEND\r", 4: "Y\rY\rS200\rEND\r", 7: "V+0\rEND\rR\r"}
    # only the module that is meant leaves the mark, where the pull-down of the line holds it
    spans = [
        (at, at + 11 * pair.board.bit)
        for pair in pairs.values()
        for at in map(lambda each: each[0] - pair.board.up, pair.board.frames())
    ]
    spans.sort()
    assert all(before[1] <= after[0] + 1 for before, after in pairwise(spans))
