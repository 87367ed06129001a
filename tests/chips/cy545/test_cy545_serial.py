"""The serial side of the CY545: the rate that it finds, its buffer of three characters, CTS."""

from __future__ import annotations

import random
from itertools import pairwise

import pytest
from cy545 import CC10, MS, US, Rig545, S

from slewline.chips.cy545.sheet import BAUDS
from slewline.core.wires.characters import frames_of, transmit
from slewline.core.wires.serial import TTL, CharacterFormat, bit_clock

WORD = CharacterFormat(8, "none", 1)
CTS = "O 0A0H\r"


def line(crystal: str = "12 MHz", baud: int = 9600, **options: object) -> Rig545:
    """A chip with hosts on both sides, and a recorder on the wires of the serial one."""
    rig = Rig545("rxd", "txd", "usrb6", "pulse", "usrb0", crystal=crystal, replies=False, **options)
    rig.serial = rig.bench.host(rig.x, over="serial", baud=baud)
    return rig


def spoken(rig: Rig545, data: bytes, hz: int) -> None:
    """Put characters on RXD, from a clock of sixteen times a rate, beside every host."""
    driver = rig.x.pin("rxd").net.drivers[0]
    rig.bench.kernel.spawn(transmit, driver, frames_of(hz, WORD, TTL), data, name="test")


# ------------------------------------------------------------------------------------------------------ in and out
@pytest.mark.fact("CY545-SER-1", "CY545-UND-SERIAL-FRAME", "CY545-MODE-1")
def test_commands_come_in_on_rxd_and_answers_go_out_on_txd():
    rig = line()
    assert rig.serial.ask("? R") == "R=00100"
    assert rig.serial.received == b"R=00100\r"  # no echo, no prompt
    assert rig.codes == [] and rig.edges("usrb6") == []


@pytest.mark.fact("CY545-SER-2", "CY545-RESET-4", "CY545-UND-BAUD-ADAPT")
@pytest.mark.parametrize("before", [b"G\r", b"? R\r", b"G\rG\r", b"\rG\r", b"UUUU\r"])
def test_nothing_is_received_before_two_consecutive_carriage_returns(before):
    rig = line()
    rig.serial.write(before)
    rig.bench.run("50 ms")
    assert rig.x._serial.rate is None and rig.falls("pulse") == [] and rig.falls("txd") == []
    assert rig.codes == ["not-adapted"]
    rig.serial.write(b"\r\r? R\r")
    rig.bench.run("50 ms")
    assert rig.serial.received == b"R=00100\r"


@pytest.mark.fact("CY545-SER-2", "CY545-UND-SERIAL-SILENT")
def test_a_reply_without_a_receiver_is_lost_and_reported():
    rig = line()
    rig.send("? R\r")
    assert rig.falls("txd") == [] and rig.codes == ["not-adapted"]
    rig.send("Y 65300\r? M,1\r")  # a memory without a return: a line of 236 characters, 944 as they are written
    assert len(rig.codes) == 3 and all(len(found.text) < 500 for found in rig.x.findings)
    assert rig.x.findings[-1].text.endswith("is lost, because no baud rate was known yet")


@pytest.mark.fact("CY545-SER-3", "CY545-UND-BAUD-ADAPT")
@pytest.mark.parametrize("off", [0, 2, -2])
@pytest.mark.parametrize("baud", BAUDS)
def test_at_11_mhz_it_finds_every_standard_rate_with_two_percent_of_error(baud, off):
    rig = line(crystal="11 MHz")
    hz = baud * 16 * (100 + off) // 100
    rig.serial.uart.set_line(f"{hz / 16}", WORD)
    assert rig.serial.ask("? R", "10 s") == "R=00100"
    assert rig.x._serial.rate == pytest.approx(hz / 16, rel=0.002)
    assert rig.codes == []


@pytest.mark.fact("CY545-UND-BAUD-ADAPT")
@pytest.mark.parametrize(
    ("crystal", "baud", "found"),
    [
        ("11 MHz", 450, False),  # no standard rate
        ("11 MHz", 38400, False),
        ("11 MHz", 150, False),
        ("11 MHz", 9984, False),  # 4 % off
        ("11 MHz", 9792, True),  # 2 % off
        ("12 MHz", 19200, True),  # what other crystals give follows from 11 MHz: inferred
        ("12 MHz", 300, False),
        ("6 MHz", 19200, False),
        ("6 MHz", 9600, True),
        ("5.5 MHz", 300, True),
    ],
)
def test_which_rates_it_finds_at_which_crystal(crystal, baud, found):
    rig = line(crystal=crystal, baud=baud)
    rig.serial.write(b"\r\r")
    rig.bench.run("200 ms")
    assert (rig.x._serial.rate is not None) is found
    assert rig.codes == ([] if found else ["wrong-rate"])
    if not found:
        assert f"at {crystal}" in rig.x.findings[0].text


@pytest.mark.fact("CY545-UND-BAUD-ADAPT")
def test_two_carriage_returns_of_different_rates_do_not_count():
    rig = line(crystal="11 MHz", baud=9600)
    rig.serial.write(b"\r")
    rig.bench.run("5 ms")
    rig.serial.uart.set_line(4800, WORD)
    rig.serial.write(b"\r")
    rig.bench.run("5 ms")
    assert rig.x._serial.rate is None and rig.codes == []
    rig.serial.write(b"\r")
    rig.bench.run("5 ms")
    assert rig.x._serial.rate == pytest.approx(4800, rel=0.001)


@pytest.mark.fact("CY545-RESET-4", "CY545-SER-2")
@pytest.mark.parametrize("how", ["I", "reset"])
def test_after_a_reset_the_rate_is_detected_again(how):
    rig = line(baud=9600)
    assert rig.serial.ask("? R") == "R=00100"
    if how == "I":
        rig.serial.send("I\r")
        rig.bench.run_until_idle()
    else:
        rig.x.reset()
        rig.bench.run("20 ms")
    assert rig.x._serial.rate is None
    rig.serial.uart.set_line(4800, WORD)
    assert rig.serial.ask("? R") == "R=00100"
    assert rig.x._serial.rate == pytest.approx(4800, rel=0.001) and rig.codes == []


@pytest.mark.fact("CY545-SER-4", "CY545-SER-5", "CY545-UND-BAUD-STRAP")
@pytest.mark.parametrize("baud", [300, 9600, 19200])
def test_a_fixed_rate_needs_no_carriage_returns(baud):
    rig = line(fixed_baud=baud, baud=baud)
    rig.serial.write(b"? R\r")
    rig.bench.run("1 s")
    assert rig.serial.received == b"R=00100\r" and rig.codes == []


@pytest.mark.fact("CY545-SER-9", "CY545-DISP-6")
def test_an_answer_goes_to_txd_also_if_the_question_came_over_the_bus():
    rig = line()
    rig.serial.send("")
    rig.bench.run_until_idle()
    rig.send("? R\r")
    rig.bench.run_until_idle()
    rig.bench.run("20 ms")
    assert rig.serial.received == b"R=00100\r" and rig.host.received == b"" and rig.edges("usrb6") == []


@pytest.mark.fact("CY545-SER-10")
@pytest.mark.parametrize("baud", [600, 19200])
def test_an_answer_begins_after_the_stop_bit_of_the_question(baud):
    rig = line(baud=baud)
    rig.serial.send("? R\r")
    rig.bench.run_until(lambda: bool(rig.falls("txd")), "2 s")
    last = rig.rises("rxd")[-1]  # the stop bit of the carriage return begins
    assert rig.falls("txd")[0] >= last + S // baud * 0.99


# ------------------------------------------------------------------------------------------------------- the buffer
@pytest.mark.fact("CY545-SER-6", "CY545-UND-SERIAL-OVERRUN")
@pytest.mark.parametrize(("sent", "lost"), [("B 1", 0), ("B 16", 1), ("B 16\r", 2)])
def test_three_characters_wait_while_the_chip_is_at_work_and_the_newest_is_lost(sent, lost):
    rig = line()
    rig.serial.send("D 1000\r")
    rig.bench.run("50 ms")
    rig.serial.write(sent)
    rig.bench.run("1 s")
    assert rig.codes == ["serial-overrun"] * lost
    rig.serial.write("6\r")
    rig.bench.run("50 ms")
    assert rig.level("usrb0") == 0  # B 1 and 6


@pytest.mark.fact("CY545-SER-7")
@pytest.mark.parametrize("baud", [300, 19200])
def test_characters_may_follow_each_other_without_a_gap_up_to_the_end_of_a_command(baud):
    rig = line(crystal="11 MHz", baud=baud)
    rig.serial.send("N 16777215\r")
    rig.bench.run_until_idle()
    rig.bench.run("10 ms")
    assert rig.x.registers["number"] == 16777215 and rig.codes == []


@pytest.mark.fact("CY545-SER-8")
def test_of_the_characters_within_a_long_motion_three_are_left():
    rig = line()
    rig.serial.send("-\rN 3000\rG\r")
    rig.bench.run("100 ms")
    rig.serial.write("B 16\rB 17\rB 18\rB 19\r")
    rig.bench.run("3 s")
    assert rig.codes == ["serial-overrun"] * 17
    assert rig.x.waiting.startswith("x: waiting for the rest of a command on RXD") and rig.x.unfinished == "B 1"


def test_a_character_without_a_stop_bit_is_lost_and_reported():
    rig = line(baud=19200)
    rig.serial.send("")
    rig.bench.run_until_idle()
    rig.serial.write("R", fault="framing")
    rig.bench.run("10 ms")
    assert rig.codes == ["serial-framing"] and rig.x.unfinished == ""


# ------------------------------------------------------------------------------------------------------------- CTS
@pytest.mark.fact("CY545-CTS-1")
def test_cts_is_on_user_bit_6_while_the_mode_selects_it():
    rig = line()
    rig.serial.send("")
    rig.send("B 22\r")
    assert rig.level("usrb6") == 0  # a user bit
    rig.send("B 6\r" + CTS)
    assert rig.level("usrb6") == 0  # CTS: the host may send
    rig.send("O 80H\r")
    assert rig.level("usrb6") == 1


@pytest.mark.fact("CY545-CTS-2", "CY545-CON-CTS-IDLE")
def test_cts_is_high_while_a_command_is_executed():
    rig = line()
    rig.serial.send(CTS)
    rig.bench.run_until_idle()
    rig.bench.run("10 ms")
    assert rig.level("usrb6") == 0
    start = rig.bench.now_ps
    rig.serial.send("D 300\r")
    rig.bench.run("1 s")
    (up,), (down,) = rig.rises("usrb6", start), rig.falls("usrb6", start)
    assert down - up == pytest.approx(300 * MS, rel=0.02)


@pytest.mark.fact("CY545-CTS-3")
def test_within_a_program_cts_is_low_while_a_command_is_read_and_high_while_it_is_executed():
    rig = line()
    rig.send(CC10 + CTS + "Y 10\r")
    start = rig.bench.now_ps
    rig.start("X\r")
    rig.bench.run("7 s")
    ups, downs = rig.rises("usrb6", start), rig.falls("usrb6", start)
    edges = sorted([(time, 1) for time in ups] + [(time, 0) for time in downs])
    widths = [(level, after - time) for (time, level), (after, _) in pairwise(edges)]
    high, low = ([width for level, width in widths if level == wanted] for wanted in (1, 0))
    assert sum(width > 1.99 * S for width in high) == 3  # D 2000
    assert len(low) >= 10 and all(20 * US <= width <= 500 * US for width in low)


@pytest.mark.fact("CY545-CTS-4", "CY545-CTS-5")
def test_a_letter_sent_while_cts_is_low_is_kept_and_cts_stays_low_until_the_command_is_complete():
    rig = line(baud=19200)
    rig.serial.send("")
    rig.send(CC10 + CTS + "Y 10\r")
    rig.start("X\r")
    rig.bench.run("500 ms")  # in D 2000
    rig.serial.heed(True)
    rig.serial.write("D")
    rig.bench.run_until(lambda: rig.x.unfinished == "D", "3 s")
    start = rig.bench.now_ps
    rig.bench.run("300 ms")
    assert rig.level("usrb6") == 0
    rig.serial.write(" 200\r")
    rig.bench.run("190 ms")
    assert rig.level("usrb6") == 1
    (up,) = rig.rises("usrb6", start)
    steps = len(rig.falls("pulse"))
    rig.bench.run("100 ms")
    down = next(fall for fall in rig.falls("usrb6", start) if fall > up)
    assert down - up == pytest.approx(200 * MS, rel=0.02)
    rig.bench.run("5 s")
    assert len(rig.falls("pulse")) > steps and rig.codes == []  # the program goes on


@pytest.mark.fact("CY545-CTS-6", "CY545-XMEM-11")
@pytest.mark.parametrize("baud", [600, 9600, 19200])
def test_a_host_that_obeys_cts_loses_nothing(baud):
    chance = random.Random(baud)
    commands = ["D 3", "B 16", "B 0", "N 20", "+", "-", "G", "R 200", "F 200", "? P", "W 1"]
    rig = line(baud=baud)
    rig.serial.send(CTS + "-\rF 200\rR 200\rN 5\r")
    done = []
    rig.x.on_command.add(lambda text: done.append(text) if text else None)
    said = chance.choices(commands, k=200 if baud > 600 else 40)
    rig.serial.send("".join(f"{each}\r" for each in said))
    rig.bench.run_until_idle("1000 s")
    assert done[-len(said) :] == said and rig.codes == []


@pytest.mark.fact("CY545-CTS-6")
def test_the_same_host_loses_characters_if_it_ignores_cts():
    rig = line(baud=19200)
    rig.serial.send(CTS)
    rig.serial.heed(False)
    rig.serial.send("D 100\rB 16\rB 17\rB 18\r")
    rig.bench.run("1 s")
    assert rig.codes == ["serial-overrun"] * 12


@pytest.mark.fact("CY545-XMEM-11", "CY545-CTS-6")
@pytest.mark.parametrize("obeys", [True, False])
def test_a_program_entered_into_an_eeprom_needs_cts(obeys):
    rig = line(baud=19200, memory="eeprom")
    rig.serial.send(CTS + "Y 0\r")
    rig.serial.heed(None if obeys else False)
    rig.serial.send("E\r" + "R 100\r" * 8 + "Q")
    rig.bench.run_until_idle("10 s")
    rig.bench.run("200 ms")
    lost = "serial-overrun" in rig.codes
    assert lost is not obeys
    if obeys:
        assert rig.x.registers["pointer"] == 48 and rig.codes == []


@pytest.mark.fact("CY545-UND-RESET-I-BUSY")
def test_i_keeps_the_chip_busy_for_a_millisecond():
    rig = Rig545("busy")
    rig.send("I\r")
    fell, rose = rig.falls("busy")[-1], rig.rises("busy")[-1]
    assert rose - fell == pytest.approx(1.1 * MS, rel=0.05)


def test_the_rate_is_used_as_measured():
    rig = line(crystal="11 MHz")
    hz = bit_clock(9600, "test").hz + 2345
    spoken(rig, b"\r\r? R\r", hz)
    rig.bench.run("50 ms")
    (
        start,
        *_,
    ) = rig.falls("txd")
    first_data = next(time for time in rig.rises("txd") if time > start)
    assert first_data - start == pytest.approx(2 * 16 * S / hz, rel=0.001)  # R is 0x52: d0 is 0, d1 is 1
