"""A receiver of characters on a wire that misbehaves: breaks and glitches."""

from __future__ import annotations

import pytest

from slewline.core.time.kernel import Kernel
from slewline.core.wires.characters import frames_of, transmit
from slewline.core.wires.net import Driver, Net
from slewline.core.wires.receiver import Character, Receiver
from slewline.core.wires.serial import RS232, CharacterFormat, bit_clock

WORD = CharacterFormat(7, "odd", 2)
CLOCK = bit_clock(9600, "test")
BIT = CLOCK.ps(16)
SPACE, MARK = 1, 0


class Wire:
    """A driver, and what a receiver at the other end takes."""

    def __init__(self) -> None:
        self.kernel = Kernel()
        self.driver = Driver(Net(self.kernel, "rxd"), "sender")
        self.driver.drive(MARK)
        self.kernel.settle()
        self.found: list[Character] = []
        self.kernel.spawn(self.receive, name="receiver")

    async def receive(self) -> None:
        receiver = Receiver(self.driver.net, CLOCK, WORD, RS232)
        while True:
            self.found.append(await receiver.character())

    def level(self, level: int, ps: int) -> None:
        self.driver.drive(level)
        self.kernel.settle()
        self.kernel.run(self.kernel.now + ps)

    def send(self, data: bytes) -> None:
        self.kernel.spawn(transmit, self.driver, frames_of(CLOCK.hz, WORD, RS232), data, name="sender")
        self.kernel.run(self.kernel.now + CLOCK.ps(WORD.ticks) * len(data))


@pytest.mark.parametrize("characters", [1, 2, 3])
def test_a_break_is_one_character_without_a_stop_bit_however_long_it_lasts(characters: int) -> None:
    wire = Wire()
    wire.level(SPACE, characters * 11 * BIT + 4 * BIT)
    wire.level(MARK, 2 * BIT)
    wire.send(b"K\r")
    assert [(character.byte, character.framing_wrong) for character in wire.found] == [
        (0, True),
        (75, False),
        (13, False),
    ]


@pytest.mark.parametrize(("sixteenths", "found"), [(7, 0), (10, 1)])
def test_a_start_bit_that_is_over_before_its_middle_is_none(sixteenths: int, found: int) -> None:
    wire = Wire()
    wire.level(MARK, BIT)
    wire.level(SPACE, CLOCK.ps(sixteenths))
    wire.level(MARK, 20 * BIT)
    assert len(wire.found) == found
    wire.send(b"K")
    assert wire.found[-1].byte == 75
