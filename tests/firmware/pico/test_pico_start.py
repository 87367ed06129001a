"""A Pico from its supply to its first answer, and what it does with a damaged flash, or a processor that hangs."""

from __future__ import annotations

from itertools import pairwise

import pytest

from tools import pico as tool

from .emulated import HZ, PINS, US, Emulator, Pico

pytestmark = pytest.mark.system
RATE = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
RING = 6.5e6  # Hz, typical, of the oscillator that a RP2040 starts with
DRIVEN = ("clock", "dir", "mov", "ramp", "reset", "rdy", "uo1", "uo2", "uo3", "txd")


def started(boards: Emulator, **straps: int) -> Pico:
    """A board that listens."""
    board = Pico(boards, **(RATE | straps))
    board.power_up()
    board.run(board.up + 1000 * US)
    return board


def test_it_wakes_in_milliseconds_and_resets_the_driver_as_specified(boards: Emulator) -> None:
    board = started(boards)
    assert board.told["clk"] == HZ
    slow = board.told["fast"]  # cycles on the ring oscillator
    assert slow < 200
    assert board.boot / HZ + slow / RING < 6e-3  # and a millisecond in which the crystal starts
    (low, _), (high, _) = [edge for edge in board.edges("reset") if edge[0] >= board.up]
    assert 395 <= (high - low) / US <= 405
    assert board.ask("F") == "R\r"


def test_no_output_has_a_spurious_edge_at_start(boards: Emulator) -> None:
    board = started(boards)
    for pin in DRIVEN:
        levels = [level for _, level in board.edges(pin)]
        assert levels == {"reset": [1, 0, 1], "rdy": [0, 1], "dir": [1], "clock": [1], "txd": [0]}.get(pin, [0]), pin


def test_it_starts_at_its_second_stage_which_the_rom_checks(boards: Emulator, pico) -> None:
    image = bytearray(pico.image.read_bytes())
    image[4] ^= 1
    board = Pico(boards, **RATE)
    board._ask(flash=[[0, bytes(image[:256]).hex()]])
    board._ask(power=True, run=board.now + 20_000 * US)
    assert board.told["refused"]  # the ROM goes on to BOOTSEL
    assert not board.changes


def damaged(boards: Emulator, pico, where: int, ms: int) -> Pico:
    """Run a board with one wrong bit in its image for some milliseconds."""
    at = pico.symbols["image_stored"] - 0x10000000 + where
    board = Pico(boards, **RATE)
    board._ask(flash=[[at, bytes([pico.image.read_bytes()[at] ^ 0x10]).hex()]])
    board._ask(power=True, run=board.now + ms * 1000 * US)
    assert {pin for _, pin, level in board.changes if level < 2} == {PINS["led"]}
    return board


@pytest.mark.parametrize("where", [0, 5000, 20_000])
def test_an_image_that_is_not_whole_is_not_run_and_every_pin_stays_an_input(boards: Emulator, pico, where: int) -> None:
    damaged(boards, pico, where, 200)


def test_the_light_flashes_in_pairs_then(boards: Emulator, pico) -> None:
    board = damaged(boards, pico, 300, 1300)
    light = [(cycle, level) for cycle, level in board.edges("led") if level in (0, 1)]
    times = [after - before for (before, _), (after, _) in pairwise(light[1:])]
    assert max(times) > 3 * min(times)


def test_a_processor_that_hangs_is_reset_and_begins_as_at_power_up(boards: Emulator, pico) -> None:
    board = started(boards)
    for line in ("Po", "S100", "T500", "R9", "A1", "g+"):
        assert board.ask(line) == "Y\r"
    board.ask("E")
    board.run(board.now + 20_000 * US)
    loop = 0xE7FE  # a jump to itself
    at = pico.symbols["part_round"]
    word = board._ask(words=[at & ~3])["words"][0]
    word = (word & ~(0xFFFF << 8 * (at & 2))) | loop << 8 * (at & 2)
    hung = board.now
    board._ask(write=[[at & ~3, word]], run=hung + 150_000 * US)
    assert [why for _, why in board.resets] == ["watchdog"]
    (when, _), *_ = board.resets
    assert when - hung <= 101_000 * US
    assert [cycle for cycle in board.steps() if cycle > when] == []
    # the flash is not damaged: it starts again, without program
    assert [level for cycle, level in board.edges("reset") if cycle > when] == [1, 0, 1][1:]
    assert board.ask("F") == "R\r"
    assert board.ask("E") == "E4\r"
    assert board.edges("uo1")[-1][1] == 0


def test_its_version_can_be_queried_while_test_is_open(boards: Emulator) -> None:
    board = started(boards, test=1)
    end = board.send(b"\x05")
    board.run(end + 60_000 * US)
    assert "".join(character for _, character in board.characters()) == tool.version() + "\r"
    assert board.ask("F") == "R\r"


def test_with_test_at_its_pin_8_it_knows_no_version(boards: Emulator) -> None:
    board = started(boards)
    end = board.send(b"\x05\r")
    board.run(end + 60_000 * US)
    assert "".join(character for _, character in board.characters()) == "E4\r"
