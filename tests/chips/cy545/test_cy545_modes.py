"""The CY545: mode register, queries, reset, supply."""

from __future__ import annotations

import pytest
from cy545 import MS, US, Rig545

import slewline
from slewline.chips.cy545 import sheet

HIGH = "pulse ccw stopped slew busy usrb0 usrb1 usrb2 usrb3 usrb4 usrb5 usrb6 usrb7 xmem_sel sw_sel rd wr txd"


@pytest.fixture
def rig() -> Rig545:
    return Rig545("pulse", "busy", "txd", "usrb7")


# --------------------------------------------------------------------------------------------------------------- mode
@pytest.mark.fact("CY545-CMD-O-1", "CY545-UND-QUERY-LETTERS")
def test_o_writes_all_of_the_mode_register_and_nothing_else_does(rig: Rig545) -> None:
    assert rig.say("O 91H", "B 7", "N 3", "G", '"a"', "A 5", "? O") == "aO=00145\r"
    assert rig.say("O 81H", "? O") == "O=00129\r"


@pytest.mark.fact("CY545-MODE-1", "CY545-MODE-3", "CY545-SER-9")
def test_after_power_up_commands_are_text_and_replies_go_out_on_txd() -> None:
    rig = Rig545("txd", replies=False, serial=True, fixed_baud=9600)
    assert rig.x.registers["mode"] == 0x80
    rig.say("? R")
    assert bytes(rig.serial.received) == b"R=00100\r"
    assert rig.answer == ""
    edges = len(rig.edges("txd"))
    assert rig.say("O 81H", "? R") == "R=00100\r"
    assert len(rig.edges("txd")) == edges


@pytest.mark.fact("CY545-DISP-7", "CY545-MODE-4", "CY545-DISP-6")
@pytest.mark.parametrize(
    ("mode", "device"), [("80H", "serial"), ("82H", "lcd"), ("81H", "parallel"), ("85H", "hp"), ("84H", "serial")]
)
def test_the_mode_selects_one_of_four_devices(mode: str, device: str) -> None:
    rig = Rig545("usrb7", serial=True, fixed_baud=9600)
    display = rig.bench.part("hp_display", name="display", to=rig.x)
    rig.say(f"O {mode}")
    start = rig.bench.now_ps
    rig.serial.received.clear()
    parallel = rig.say("? R")
    assert parallel == ("R=00100\r" if device == "parallel" else "")
    assert bytes(rig.serial.received) == (b"R=00100\r" if device in ("serial", "lcd") else b"")
    assert rig.x._display.device == device
    assert bool(rig.falls("usrb7", start)) == (device == "hp")
    assert (display.text == "R=00100 ") == (device == "hp")


@pytest.mark.fact("CY545-UND-MB36")
def test_the_unknown_bits_are_kept_without_effect_and_reported_once(rig: Rig545) -> None:
    assert rig.say("O 0C1H", "O 89H", "? O") == "O=00137\r"
    assert rig.codes == ["mode-bits"]


def test_the_sheet_describes_the_mode_bits() -> None:
    assert sorted(sheet.MODE_BITS) == [1 << bit for bit in range(8)]


# ------------------------------------------------------------------------------------------------------------ queries
@pytest.mark.fact("CY545-QUERY-1", "CY545-QUERY-2", "CY545-RESET-1", "CY545-MODE-1")
def test_queries_after_reset_return_the_values_at_power_up(rig: Rig545) -> None:
    said = rig.say("? R", "? F", "? S", "? N", "? P", "? Y")
    assert said == "R=00100\rF=00014\rS=00220\rN=00000200\rP=00000000\rY=00000\r"


# -------------------------------------------------------------------------------------------------------------- reset
@pytest.mark.fact("CY545-RESET-2")
def test_all_signals_are_high_after_reset(rig: Rig545) -> None:
    rig.say("+", "B 40H", "N 1000")
    rig.host.send("G\r")
    rig.bench.run("50 ms")
    rig.x.reset()
    rig.host.clear()
    rig.bench.run("1 ms")
    assert set(rig.state(HIGH)) == {"1"}
    assert rig.level("ale") == 0
    assert rig.level("jog") is None


@pytest.mark.fact("CY545-RESET-3", "CY545-UND-RESET-DIRECTION")
@pytest.mark.parametrize(("direction", "way"), [("-", -1), ("+", 1)])
def test_the_direction_after_reset_is_counter_clockwise_or_an_option(direction: str, way: int) -> None:
    rig = Rig545(direction=direction)
    rig.say("N 5", "G")
    assert rig.x.position == 5 * way % (1 << 24)
    rig.x.reset()
    rig.host.clear()
    rig.bench.run("1 ms")
    rig.say("N 2", "G")
    assert rig.x.position == 2 * way % (1 << 24)


@pytest.mark.fact("CY545-CMD-I-1", "CY545-RESET-1", "CY545-UND-RESET-POINTER", "CY545-UND-RESET-I-BUSY")
def test_i_is_like_a_reset_and_takes_a_millisecond(rig: Rig545) -> None:
    rig.enter("L 3,0", at=4)
    rig.say("R 5", "F 6", "S 7", "N 8", "A 9", "+", "B 16", "C", "Y 77")
    start = rig.bench.now_ps
    rig.say("I")
    assert rig.x.registers == {
        "number": 200, "rate": 100, "firstrate": 14, "slope": 220, "mode": 0x80, "pointer": 0, "position": 0,
    }  # fmt: skip
    assert set(rig.state(HIGH)) == {"1"}
    assert not rig.x.state.continuous and not rig.x._stored.loops
    assert (rig.rises("busy", start)[-1] - rig.falls("busy", start)[-1]) / MS == pytest.approx(1.1, abs=0.01)
    assert rig.ram.content[4:10] == b"L 3,0\r"


@pytest.mark.fact("CY545-RESET-4")
@pytest.mark.parametrize("how", ["I", "reset"])
def test_a_reset_makes_the_serial_side_look_for_its_rate_again(how: str) -> None:
    rig = Rig545(serial=True)
    rig.say("O 80H")
    assert rig.serial.ask("? R") == "R=00100"
    assert rig.x._serial.rate is not None
    if how == "I":
        rig.say("I")
    else:
        rig.x.reset()
        rig.bench.run("1 ms")
    assert rig.x._serial.rate is None


@pytest.mark.fact("CY545-UND-RESET-PIN")
@pytest.mark.parametrize(("clocks", "seen"), [(20, False), (30, True)])
def test_reset_is_active_high_and_takes_24_clocks(rig: Rig545, clocks: int, seen: bool) -> None:
    rig.say("R 5")
    rig.x.pin("reset").pulse(1, f"{clocks * 1000 // 12} ns")
    rig.bench.run("1 ms")
    assert (rig.x.registers["rate"] == 100) is seen
    assert rig.codes == ([] if seen else ["reset-short"])


@pytest.mark.fact("CY545-UND-RESET-PIN")
def test_power_up_is_a_reset() -> None:
    bench = slewline.Bench()
    x = bench.add("cy545b", name="x", cold=True)
    bench.run("1 ms")
    assert not x.powered and x.pin("busy").level is None
    x.power(True)
    bench.run("20 ms")
    assert x.registers["rate"] == 100
    assert x.pin("busy").level == 1
    host = bench.host(x)
    host.send("-\rN 3\rG\rR 7\r")
    bench.run_until_idle()
    x.power(False)
    bench.run("1 ms")
    assert x.pin("pulse").level is None
    x.power(True)
    bench.run("20 ms")
    assert x.registers["rate"] == 100 and x.position == 0
    host.send("+\rN 3\rG\r")
    bench.run_until_idle()
    assert len(x.steps()) == 6
    assert not x.findings


def test_a_lasting_reset_stops_the_chip(rig: Rig545) -> None:
    rig.drive("reset", 1)
    rig.host.send("B 16\r")
    rig.bench.run("1 s")
    assert rig.user == "111111"
    rig.host.clear()
    rig.drive("reset", 0)
    rig.bench.run("1 ms")
    rig.host.send("B 16\r")
    rig.bench.run_until_idle()
    assert rig.user == "111110"


def test_reset_in_the_middle_of_anything_leads_back_to_the_same_state() -> None:
    rig = Rig545("pulse", serial=True)
    rig.enter("N 30", "G", "? P", "W 3", "D 5", "H 13H", "J 0")
    rig.drive("usrb3", 0)
    seen = set()
    for at in range(1, 60):
        rig.host.send("O 81H\rY 0\rX\r")
        rig.bench.run(at * 3 * MS + at * 37 * US)
        seen.add(rig.x.waiting.split(" since")[0])
        rig.x.reset()
        rig.host.clear()
        rig.bench.run("1 ms")
        assert set(rig.state(HIGH.replace("usrb3 ", ""))) == {"1"}
        assert rig.x.registers["rate"] == 100 and rig.x.program_counter is None
        assert rig.x.idle
    assert len(seen) > 2
