"""Thumbwheels, displays and the jog switch: on a bus driven by hand, and on a line."""

from __future__ import annotations

import pytest

import slewline
from slewline.errors import UsageError
from slewline.parts.front_panel.panel_parts import switch_address
from tests.parts.bus_master import BusMaster
from tests.rows import rows


# ---------------------------------------------------------------------------------------------------------- thumbwheels
def test_each_switch_has_an_address_of_its_own() -> None:
    addresses = {switch_address(chr(letter), digit) for letter in range(ord("A"), ord("Z") + 1) for digit in range(8)}
    assert len(addresses) == 26 * 8 and max(addresses) < 256
    assert switch_address("R", 0) == 0x90 and switch_address("N", 7) == 0x77


def test_a_bank_shows_its_digits_most_significant_first_and_nothing_elsewhere() -> None:
    bus = BusMaster("thumbwheels", letter="N", value="00012345")
    assert [bus.read(switch_address("N", n), upper=False) & 0x0F for n in range(8)] == [0, 0, 0, 1, 2, 3, 4, 5]
    assert bus.read(switch_address("R", 0), upper=False) == 0xFF
    bus.address(switch_address("R", 0), upper=False)
    bus.on_bus(None)
    bus.put("rd", 0)
    bus.pass_time()
    assert bus.floats


def test_a_bank_has_as_many_digits_as_are_set() -> None:
    bus = BusMaster("thumbwheels", letter="R", value="123")
    assert bus.read(switch_address("R", 2), upper=False) == 0xF3
    assert bus.read(switch_address("R", 3), upper=False) == 0xFF and bus.floats
    assert bus.part.picture == "R [1][2][3]"


def test_switches_are_turned_within_their_digits() -> None:
    part = BusMaster("thumbwheels", letter="R", value="123").part
    part.turn(7)
    assert part.value == "007"
    for wrong in (1000, -1, True, "7"):
        with pytest.raises(UsageError, match=f"p: turn to {wrong!r}; allowed 0 to 999, one digit per switch"):
            part.turn(wrong)


@rows(
    ("options", "says"),
    [
        ({"letter": "RR"}, "letter 'RR'; expected one letter, A to Z"),
        ({"letter": "r"}, "letter 'r'; expected one letter, A to Z"),
        ({"value": ""}, "value ''; allowed 1 to 8 digits"),
        ({"value": "12x"}, "value '12x'; allowed 1 to 8 digits"),
        ({"value": "123456789"}, "value '123456789'; allowed 1 to 8 digits"),
    ],
)
def test_wrong_switches_are_refused(options: dict[str, str], says: str) -> None:
    with pytest.raises(UsageError, match=f"p: {says}"):
        BusMaster("thumbwheels", **options)


# ----------------------------------------------------------------------------------------------------------- jog switch
def test_the_jog_switch_has_three_positions() -> None:
    bench = slewline.Bench()
    switch = bench.part("jog_switch")
    levels = [switch.pin("out").level]
    for verb in ("cw", "ccw", "off"):
        getattr(switch, verb)()
        levels.append(switch.pin("out").level)
    assert levels == [None, 0, 1, None]
    assert bench.part("jog_switch", position="ccw").pin("out").level == 1
    with pytest.raises(UsageError, match="position 'up'; allowed off, cw, ccw"):
        bench.part("jog_switch", position="up")


# ------------------------------------------------------------------------------------------------------ the LED display
def typed(bus: BusMaster, text: str) -> None:
    for n, character in enumerate(text):
        bus.write(0x38 + n, ord(character), upper=False)


def test_the_display_shows_eight_characters() -> None:
    bus = BusMaster("hp_display")
    assert bus.part.text == " " * 8 and bus.part.brightness == 100
    typed(bus, "R=00100")
    assert bus.part.text == "R=00100 "
    assert bus.part.picture == "+--------+\n|R=00100 |\n+--------+"
    assert bus.read(0x3A, upper=False) == ord("0")
    bus.write(0x7A, ord("9"), upper=False)  # two address lines are not connected
    assert bus.part.text == "R=90100 "


def test_the_control_word_dims_blanks_flashes_and_clears() -> None:
    bus = BusMaster("hp_display")
    typed(bus, "ABCDEFGH")
    found = []
    for low in range(8):
        bus.write(0x30, low, upper=False)
        found.append(bus.part.brightness)
    assert found == [100, 80, 53, 40, 27, 20, 13, 0]
    assert bus.part.text == " " * 8
    bus.write(0x37, 0, upper=False)  # the same register
    assert bus.part.text == "ABCDEFGH"
    bus.write(0x02, 1, upper=False)
    assert bus.part.flashing == ()
    bus.write(0x30, 0x08, upper=False)
    assert bus.part.flashing == (2,)
    bus.write(0x30, 0x10, upper=False)
    assert bus.part.flashing == tuple(range(8))
    bus.write(0x30, 0x88, upper=False)
    assert bus.part.text == " " * 8 and bus.part.flashing == ()
    assert bus.read(0x30, upper=False) == 0x08


def test_a_custom_character_is_a_box_and_a_control_code_a_blank() -> None:
    bus = BusMaster("hp_display")
    typed(bus, "A\x83\x05")
    assert bus.part.text == "A\u25a1      "


def test_the_display_is_enabled_by_select_alone_with_a_strobe() -> None:
    bus = BusMaster("hp_display")
    bus.write(0x38, 0x41, upper=False)
    bus.address(0x38, upper=False)
    bus.put("select", 1)
    bus.on_bus(0x42)
    bus.put("wr", 0)
    bus.pass_time()
    bus.put("wr", 1)
    bus.pass_time()
    assert bus.part.text == "A       "


def test_a_change_is_reported_once() -> None:
    bus = BusMaster("hp_display")
    shown: list[str] = []
    bus.part.on_change.add(lambda: shown.append(bus.part.text))
    typed(bus, "AB")
    typed(bus, "AB")
    bus.write(0x20, 0x01, upper=False)
    assert shown == ["A       ", "AB      "]


# ------------------------------------------------------------------------------------------------------------------ LCD
class Line:
    """An LCD, and the line to it."""

    def __init__(self, **options: object) -> None:
        self.bench = slewline.Bench()
        self.lcd = self.bench.part("lcd", name="p", **options)
        self.sender = self.bench.part("serial_sender", name="pc", baud=options.get("baud", 9600))
        self.bench.wire("pc.txd", "p.rxd")

    def send(self, text: str) -> list[str]:
        """Send a text; returns the rows of what is shown then."""
        self.sender.send(text)
        self.bench.run_until_idle()
        self.bench.run("5 ms")
        return [row[1:-1].rstrip() for row in self.lcd.picture.splitlines()[1:-1]]


@pytest.mark.fact("CY545-DISP-8", "CY545-UND-LCD")
def test_parameters_stand_on_the_left_and_texts_on_the_right() -> None:
    line = Line(rows=3, columns=30)
    assert line.send("Hello") == ["           Hello", "", ""]
    assert line.send("R=00100\r") == ["R=00100    Hello", "", ""]
    assert line.send(", world") == ["R=00100    Hello, world", "", ""]
    assert line.send("P=00012345\r") == ["R=00100    Hello, world", "P=00012345", ""]
    assert line.send("R=00007\r") == ["R=00007    Hello, world", "P=00012345", ""]
    assert line.lcd.parameters == {"R": "00007", "P": "00012345"}


def test_a_return_in_a_text_begins_the_next_line_and_a_full_line_too() -> None:
    line = Line(rows=2, columns=16)
    assert line.send("abcdefg") == ["           abcde", "           fg"]
    assert line.send("\rx") == ["           x", "           fg"]


@rows("text", ["RR=0010", "R=0010x", "SPEED", "A=123456789", "r=00100", "R= 00100", "X"])
def test_an_invalid_parameter_is_text(text: str) -> None:
    line = Line(columns=40)
    assert line.send(text) == [f"           {text}", "", "", ""]
    assert line.lcd.parameters == {}


def test_a_parameter_after_a_text_without_return_is_one() -> None:
    line = Line()
    assert line.send("SPEEDR=00100\r")[0] == "R=00100    SPEED"
    assert line.send("RR=00200\r")[0] == "R=00200    SPEEDR"


def test_more_parameters_than_lines_share_them() -> None:
    line = Line(rows=2)
    assert line.send("A=00001\rB=00002\rC=00003\r") == ["C=00003", "B=00002"]


def test_another_rate_is_reported() -> None:
    bench = slewline.Bench()
    lcd = bench.part("lcd", baud=9600)
    driver = lcd.pin("rxd")
    sender = bench.part("serial_sender", baud=1200)
    bench.wire("serial_sender.txd", "lcd.rxd")
    sender.send("\0\0")
    bench.run_until_idle()
    bench.run("20 ms")
    assert driver.level == 1
    assert {found.code for found in lcd.findings} == {"display-garbled"}


def test_every_character_is_reported() -> None:
    line, shown = Line(rows=1, columns=16), []
    line.lcd.on_change.add(lambda: shown.append(line.lcd.picture))
    line.send("ab")
    assert [picture.splitlines()[1] for picture in shown] == ["|           a    |", "|           ab   |"]
