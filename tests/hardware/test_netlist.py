"""The netlist of a GS-C200S with a Pico: rules that it keeps, and the pins that the firmware has."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from tools import netlist
from tools.netlist import Board

pytestmark = pytest.mark.check
PINS = (netlist.ROOT / "firmware" / "pico" / "pins.h").read_text("ascii")


@pytest.fixture
def board() -> Board:
    """The board as it is."""
    return netlist.read()


def moved(board: Board, pin: str, to: str) -> Board:
    """Return the board with a pin in another net."""
    nets = {name: tuple(each for each in pins if each != pin) for name, pins in board.nets.items()}
    return replace(board, nets=nets | {to: (*nets.get(to, ()), pin)})


def test_no_rule_is_broken(board: Board) -> None:
    assert not netlist.broken(board)


@pytest.mark.parametrize(
    ("pin", "to", "rule", "says"),
    [
        ("J.clock", "nowhere", netlist.every_pin, "net nowhere has one pin"),
        ("J.enable", "GP_enable", netlist.voltages, "net GP_enable has up to 5.5 V, and U1.GP9 takes 3.63"),
        ("U1.VSYS", "VIN", netlist.voltages, "net VIN has up to 42 V, and U1.VSYS takes 5.5"),
        ("U3.VCC", "V5", netlist.voltages, "net V5 has up to 5 V, and U3.VCC takes 3.6"),
        ("U4.VCC", "V3", netlist.voltages, "net V3 has 3.3 V, and U4.VCC needs 4.5"),
        ("U4.Y1", "GP_clock", netlist.voltages, "net GP_clock has up to 5 V, and U1.GP16 takes 3.63"),
        ("U4.Y1", "dir", netlist.levels, "net dir is driven by U4.Y2, U4.Y1"),
        ("U6.VIN", "V3", netlist.currents, "net V3: U1.3V3 gives 250 mA, and"),
        ("J.rdy", "nc", netlist.every_pin, "net rdy has one pin"),
        ("U7.GND", "V3", netlist.voltages, "U7.GND is a ground, and net V3 is none"),
    ],
)
def test_a_wire_that_is_wrong_breaks_a_rule(board: Board, pin: str, to: str, rule, says: str) -> None:
    found = list(rule(moved(board, pin, to)))
    assert any(text.startswith(says) for text in found), found


def test_a_pin_of_the_module_without_a_wire_breaks_a_rule(board: Board) -> None:
    without = replace(board, nets={name: pins for name, pins in board.nets.items() if name != "ui2"})
    assert list(netlist.module_pins(without)) == ["pin 36 (ui2) of the module is in 0 nets"]


def test_a_smaller_resistor_is_too_much_for_a_pin(board: Board) -> None:
    assert any("sinks 12 mA" in text for text in netlist.currents(replace(board, values=board.values | {"R8": 100})))
    assert any("sinks 2 mA" in text for text in netlist.currents(replace(board, values=board.values | {"R7": 1000})))


def test_the_firmware_has_the_same_pins(board: Board) -> None:
    firmware = {name.lower(): int(number) for name, number in re.findall(r"PIN_(\w+) = (\d+)", PINS)}
    wired = {}
    for net, pins in board.nets.items():
        if net.startswith("GP_"):
            (gpio,) = [pin for pin in pins if pin.startswith("U1.GP")]
            wired[net[3:]] = int(gpio[5:])
    assert len(wired) == 26
    assert firmware.pop("led") == 25
    assert firmware.items() <= wired.items()
    order = [
        "sel0",
        "sel1",
        "sel2",
        "br0",
        "br1",
        "br2",
        "chs",
        "rec",
        "rxd",
        "enable",
        "home",
        "eot",
        "ui1",
        "ui2",
        "ui3",
        "test",
    ]
    assert [wired[name] for name in order] == list(range(16))


def test_pins_high_at_rest_are_pulled_up(board: Board) -> None:
    pulled = set(re.findall(r"PIN_(\w+) = \d+,? +/\*[^*]*pulled up", PINS))
    assert {name.lower() for name in pulled} == {
        net[3:]
        for net, pins in board.nets.items()
        if net.startswith("GP_") and net != "GP_rxd" and netlist.pulls(board, net)
    }


def test_each_signal_reaches_the_pin_of_its_name(board: Board) -> None:
    buffers = {
        **{f"U{u}.A{n}": f"U{u}.B{n}" for u in (2, 3) for n in range(1, 9)},
        **{f"U4.Y{n}": f"U4.A{n}" for n in range(1, 9)},
    }
    for net, pins in board.nets.items():
        for pin in pins:
            if f"J.{net}" in pins and pin in buffers:
                assert board.net_of(buffers[pin]) == f"GP_{net}", net


def test_the_list_of_parts_has_each_part_once(board: Board) -> None:
    names = [name for _, _, each in netlist.bill(board) for name in each.split()]
    assert sorted(names) == sorted(board.kinds)
