"""The CY545's local bus: cycles to memory, thumbwheels and display, edge by edge, and what they carry."""

from __future__ import annotations

from itertools import pairwise

import pytest
from cy545 import CC10, MS, US, Rig545, S

import slewline
from slewline.parts.front_panel.panel_parts import switch_address

LINES = ("xmem_sel", "sw_sel", "ale", "rd", "wr", "usrb7")


class Traced(Rig545):
    """A rig that notes every change of the lines of the bus, of the bus itself, and of what the chip drives there."""

    def __init__(self, *parts: str, **options: object) -> None:
        super().__init__(**{"memory": "ram", **options})
        self.parts = {kind: self.bench.part(kind, to=self.x) for kind in parts}
        self.trace: list[tuple[int, str, object]] = []
        for pin in LINES:
            self.x.pin(pin).net.watch(lambda net, pin=pin: self.trace.append((self.bench.now_ps, pin, net.level)))
        self.x.bus.watch(lambda net: self.trace.append((self.bench.now_ps, "own", self.x.bus_driver.at(self.now))))
        self.x.bus.watch(lambda net: self.trace.append((self.bench.now_ps, "db", net.byte)))

    @property
    def now(self) -> int:
        return self.bench.now_ps

    def traced(self, data: str) -> list[tuple[int, str, object]]:
        """What changes while something is sent and done."""
        self.trace.clear()
        self.send(data)
        return list(self.trace)

    def lines(self, data: str) -> list[str]:
        """The edges of the lines alone, as "rd-" and "rd+"."""
        return [f"{pin}{'+' if level else '-'}" for _, pin, level in self.traced(data) if pin in LINES]

    def bus_at(self, pin: str, level: int) -> list[int]:
        """The byte on the bus just before each edge of a line to a level."""
        return [self.byte_at(time - 1) for time, name, now in self.trace if (name, now) == (pin, level)]

    def byte_at(self, ps: int) -> int:
        """The byte on the bus at an instant."""
        return next((byte for time, name, byte in reversed(self.trace) if name == "db" and time <= ps), 0xFF)

    def drives_at(self, ps: int) -> bool:
        """Does the chip drive the bus at an instant?"""
        own = next((level for time, name, level in reversed(self.trace) if name == "own" and time <= ps), None)
        return own is not None and own[0] != 0


WRITE = ["xmem_sel-", "ale+", "ale-", "wr-", "wr+", "xmem_sel+"]
READ = ["xmem_sel-", "ale+", "ale-", "rd-", "rd+", "xmem_sel+"]


# --------------------------------------------------------------------------------------------------------------- memory
@pytest.mark.fact("CY545-XMEM-2", "CY545-XMEM-8", "CY545-XMEM-9", "CY545-UND-ENTRY-TIME")
def test_a_byte_is_stored_by_a_write_and_one_read_of_a_ram() -> None:
    rig = Traced()
    rig.send("Y 1234H\rE\r")
    assert rig.lines("A") == WRITE + READ
    times = [time for time, pin, _ in rig.trace if pin == "xmem_sel"]
    assert times[-1] - times[0] < 40 * US
    assert rig.ram.content[0x1234] == ord("A")


@pytest.mark.fact("CY545-XMEM-3", "CY545-XMEM-4", "CY545-XMEM-5", "CY545-XMEM-18", "CY545-CON-XMEM-SEL-LATCH")
def test_the_address_goes_out_high_byte_first_and_the_chip_lets_go_of_the_bus_while_it_reads() -> None:
    rig = Traced()
    rig.send("Y 1234H\rE\r")
    rig.lines("A")
    assert rig.bus_at("xmem_sel", 0) == [0x12, 0x12]  # the write and the read
    assert rig.bus_at("ale", 0) == [0x34, 0x34]
    assert rig.bus_at("wr", 1) == [ord("A")]
    low, high = ([time for time, pin, level in rig.trace if (pin, level) == ("rd", at)] for at in (0, 1))
    assert [rig.byte_at(time - 1) for time in high] == [ord("A")]
    assert not any(rig.drives_at(time) for time in (*low, *(time - 1 for time in high)))
    falls = [time for time, pin, level in rig.trace if (pin, level) == ("wr", 0)]
    assert all(rig.drives_at(time - 1) and rig.drives_at(time) for time in falls)
    assert not rig.drives_at(rig.now)


@pytest.mark.fact("CY545-XMEM-1")
@pytest.mark.parametrize("address", [0, 0xFF, 0x100, 0x7FFF, 0x8000, 0xFFFF])
def test_every_address_can_be_written_and_executed(address: int) -> None:
    rig = Rig545()
    rig.send(f"Y {address}\rE\r0\rQ")
    assert rig.ram.content[address] == ord("0")
    assert rig.ram.content[(address + 1) % 65536] == ord("\r")
    rig.run_program(address)
    assert rig.say("? Y") == f"Y={(address + 2) % 65536:05}\r"
    assert not rig.codes


@pytest.mark.fact("CY545-XMEM-15", "CY545-XMEM-17", "CY545-EXAMPLE-CC10-1", "CY545-CMD-E-1")
def test_the_printed_program_is_in_memory_byte_for_byte() -> None:
    rig = Rig545("pulse")
    rig.send(CC10)
    assert rig.ram.content[10:33] == b"N 1\r+\rG\rD 2000\rL 50,16\r"
    assert rig.ram.content[:10] == b"\xff" * 10
    assert rig.ram.content[33:] == b"\xff" * (65536 - 33)
    assert rig.say("? Y") == "Y=00033\r"
    assert not rig.falls("pulse")


@pytest.mark.fact("CY545-EXAMPLE-CC10-1")
def test_the_printed_program_takes_fifty_steps_two_seconds_apart() -> None:
    rig = Rig545("pulse")
    rig.send(CC10 + "Y 33\rE\r0\rQ")
    rig.run_program(10, "200 s")
    falls = rig.falls("pulse")
    assert len(falls) == 50 and rig.x.position == 50
    assert all(abs(two - one - 2000 * MS) < 40 * MS for one, two in pairwise(falls))


@pytest.mark.fact("CY545-UND-MEM-NONE", "CY545-UND-TIMEOUT")
def test_without_a_memory_a_byte_takes_the_full_timeout_and_is_reported() -> None:
    rig = Rig545("busy", "rd", memory=None)
    rig.send("E\r")
    start = rig.bench.now_ps
    rig.send("A")
    low = [two - one for (one, level), (two, _) in pairwise(rig.edges("busy", start)) if level == 0]
    assert 20 * MS <= low[0] < 20 * MS + 300 * US
    assert rig.codes == ["unfinished", "verify-timeout"]  # no Q has come
    assert "address 0: 41 was written, but FF was read back" in rig.x.findings[1].text
    assert len(rig.falls("rd", start)) == 201
    rig.send("\rQ? Y\r")
    assert rig.answer == "Y=00002\r" and rig.codes == ["unfinished", *["verify-timeout"] * 2]


@pytest.mark.fact("CY545-XMEM-14", "CY545-UND-TIMEOUT")
def test_an_eprom_is_executed_and_cannot_be_written() -> None:
    rig = Rig545(memory=None)
    eprom = rig.bench.part("eprom", to=rig.x, image="N 5\r+\rG\r0\r")
    rig.run_program(0)
    assert rig.x.position == 5 and not rig.codes
    before = eprom.content
    rig.send("Y 0\rE\rA\rQ")
    assert rig.codes == ["verify-timeout"] * 2
    assert [found.code for found in eprom.findings] == ["read-only"]
    assert eprom.content == before


# --------------------------------------------------------------------------------------------------------------- EEPROM
def with_eeprom(*record: str, **options: object) -> tuple[Rig545, object]:
    rig = Rig545(*record, memory=None, **options)
    return rig, rig.bench.part("eeprom", to=rig.x)


@pytest.mark.fact("CY545-XMEM-9", "CY545-XMEM-10", "CY545-XMEM-12")
def test_an_eeprom_is_waited_for_byte_by_byte() -> None:
    rig, eeprom = with_eeprom("busy", "rd", "wr")
    rig.send("E\r")
    start = rig.bench.now_ps
    rig.send("P 100\r")
    assert eeprom.content[:6] == b"P 100\r"
    low = [two - one for (one, level), (two, _) in pairwise(rig.edges("busy", start)) if level == 0]
    assert len(low) == 6 and all(5 * MS < length < 5.3 * MS for length in low)
    assert len(rig.falls("wr", start)) == 6
    assert 6 * 49 <= len(rig.falls("rd", start)) <= 6 * 53
    assert rig.codes == ["unfinished"] and not eeprom.findings  # no Q has come


@pytest.mark.fact("CY545-XMEM-10")
def test_an_eeprom_that_polls_no_data_would_be_believed_too_early() -> None:
    """The oracle of the test above: without the inverted bit the next write comes while the part is busy."""
    rig, eeprom = with_eeprom()
    eeprom._bus.read = lambda: eeprom.writing[1] if eeprom.writing else eeprom._core.byte
    rig.send("E\rP 100\rQ")
    assert "memory-busy" in [found.code for found in eeprom.findings]
    assert eeprom.content[:6] != b"P 100\r"


def test_reset_in_the_middle_of_a_cycle_leaves_all_lines_at_rest() -> None:
    rig = Traced()
    rig.send("Y 1234H\rE\r")
    rig.host.send("A")
    rig.bench.run_until(rig.x.pin("wr").is_(0))
    rig.x.reset()
    rig.bench.run("5 us")  # XMEM_SEL would be low for 8
    assert rig.state("xmem_sel sw_sel ale rd wr usrb7") == "110111"
    assert rig.x.bus.byte == 0xFF
    assert not rig.drives_at(rig.now)


def handed(x: object, bench: slewline.Bench, byte: int, held: str) -> None:
    """Give a byte by hand, and keep it on the bus for so long behind the fall of BUSY."""
    bits = [x.pin(f"db{bit}") for bit in range(8)]
    for bit, pin in enumerate(bits):
        pin.drive(byte >> bit & 1)
    x.pin("io_request").drive(0)
    bench.run_until(x.pin("busy").is_(0))
    bench.run(held)
    for pin in bits:
        pin.release()
    x.pin("io_request").drive(1)
    bench.run_until(x.pin("busy").is_(1))


@pytest.mark.fact("CY545-HS-14")
def test_no_cycle_begins_while_the_host_has_its_byte_on_the_bus() -> None:
    bench = slewline.Bench()
    x, ram = bench.add("cy545b", name="x"), bench.part("ram", to="x")
    bench.record("x.xmem_sel", "x.io_request")
    bench.run("20 ms")
    for byte in b"E\rA":
        handed(x, bench, byte, "3 ms")  # a host that takes its time
    times, levels = bench.edges("x.xmem_sel")
    rises = [time for time, level in zip(*bench.edges("x.io_request"), strict=True) if level == 1]
    assert levels.tolist() == [0, 1, 0, 1] and times[0] > rises[-1]
    assert ram.content[0] == ord("A") and not x.findings


# ---------------------------------------------------------------------------------------------------------- thumbwheels
THUMB = ["sw_sel-", *["ale+", "ale-", "rd-", "rd+"] * 3, "sw_sel+"]


@pytest.mark.fact("CY545-THUMB-1", "CY545-THUMB-2", "CY545-THUMB-3", "CY545-THUMB-4", "CY545-XMEM-7")
def test_a_parameter_is_read_from_the_switches_in_one_phase_of_sw_sel() -> None:
    rig = Traced("thumbwheels")
    assert rig.lines("R #\r") == THUMB
    low = [time for time, pin, level in rig.trace if (pin, level) == ("rd", 0)]
    assert not any(rig.drives_at(time) for time in low)


@pytest.mark.fact("CY545-THUMB-4", "CY545-THUMB-9", "CY545-THUMB-5", "CY545-UND-THUMB-ADDRESS")
@pytest.mark.parametrize(("command", "digits"), [("R", 3), ("F", 3), ("D", 5), ("Y", 5), ("N", 8), ("A", 8)])
def test_each_digit_of_the_width_has_its_own_address(command: str, digits: int) -> None:
    rig = Traced()
    wheels = rig.bench.part("thumbwheels", to=rig.x, letter=command, value=f"{7:0{digits}}")
    assert rig.lines(f"{command} #\r").count("rd-") == digits
    addresses = rig.bus_at("ale", 0)
    assert addresses == [switch_address(command, n) for n in range(digits)] and len(set(addresses)) == digits
    assert wheels.value.endswith("7")


@pytest.mark.fact("CY545-THUMB-6")
def test_the_parameter_is_the_value_of_the_switches() -> None:
    rig = Rig545()
    rig.bench.part("thumbwheels", name="rate", to=rig.x, letter="R", value="123")
    rig.bench.part("thumbwheels", name="number", to=rig.x, letter="N", value="00012345")
    assert rig.say("R #", "N #", "? R", "? N") == "R=00123\rN=00012345\r"
    rig.bench["rate"].turn(7)
    assert rig.say("R #", "? R") == "R=00007\r"
    assert not rig.codes


@pytest.mark.fact("CY545-THUMB-7")
@pytest.mark.parametrize("command", ["L 3,#", "T 1,#", "[#,1,65", "B #"])
def test_only_a_first_parameter_comes_from_the_switches(command: str) -> None:
    rig = Rig545("sw_sel", replies=False)
    rig.bench.part("thumbwheels", to=rig.x, letter=command[0] if command[0].isalpha() else "R", value="012")
    rig.send(f"{command}\r")
    assert (len(rig.falls("sw_sel")) == 1) is (command == "B #")
    assert (rig.codes == []) is (command == "B #")


@pytest.mark.fact("CY545-THUMB-8")
def test_in_a_program_the_switches_are_read_at_each_execution() -> None:
    rig = Rig545()
    wheels = rig.bench.part("thumbwheels", to=rig.x, letter="N", value="00000003")
    rig.enter("+", "N #", "G", "D 100", "J 2")
    assert b"N #\r" in rig.ram.content
    rig.start("Y 0\rX\r")
    rig.bench.run_until(rig.x.reaches(3))
    wheels.turn(20)
    rig.bench.run_until(rig.x.reaches(23))
    wheels.turn(1)
    rig.bench.run_until(rig.x.reaches(24))
    assert rig.x.position == 24


@pytest.mark.fact("CY545-UND-THUMB-RANGE")
def test_switches_above_the_range_keep_the_low_bits_and_are_reported() -> None:
    rig = Rig545()
    rig.bench.part("thumbwheels", to=rig.x, letter="R", value="300")
    assert rig.say("R #", "? R") == "R=00044\r"
    assert rig.codes == ["range"]


@pytest.mark.parametrize(
    ("value", "rate", "says"),
    [("12", 135, "reads 15"), ("0123", 12, "the other switches have no effect"), ("012", 12, "")],
)
def test_a_bank_of_the_wrong_number_of_digits_is_reported_once(value: str, rate: int, says: str) -> None:
    rig = Rig545()
    wheels = rig.bench.part("thumbwheels", to=rig.x, letter="R", value=value)
    rig.bench.part("thumbwheels", name="other", to=rig.x, letter="N", value="1")  # nobody asks for it
    rig.say("R #", "R #")
    assert rig.x.registers["rate"] == rate
    assert [found.code for found in rig.bench.findings] == ["digit-count"] * bool(says)
    assert all(f"3 digits for R, but the bank has {len(value)}: " in found.text for found in wheels.findings)
    assert all(says in found.text for found in wheels.findings)


@pytest.mark.fact("CY545-UND-THUMB-RANGE")
def test_a_digit_above_nine_counts_with_its_value() -> None:
    rig = Rig545()
    rig.bench.part("thumbwheels", to=rig.x, letter="R", value="0A5")
    assert rig.say("R #", "? R") == "R=00105\r"


# -------------------------------------------------------------------------------------------------------------- display
SHOW = ["usrb7-", "ale+", "ale-", "wr-", "wr+", "usrb7+"]


@pytest.mark.fact("CY545-CMD-HP-1", "CY545-DISP-2", "CY545-DISP-3", "CY545-XMEM-7")
def test_the_command_for_the_display_makes_a_write_cycle_a_value() -> None:
    rig = Traced("hp_display")
    assert rig.lines("[38H,2,65,66\r") == SHOW * 2
    assert rig.bus_at("ale", 0) == [0x38, 0x39]
    assert rig.bus_at("wr", 1) == [0x41, 0x42]
    assert rig.parts["hp_display"].text == "AB      "


@pytest.mark.fact("CY545-UND-HP-COMMAND")
@pytest.mark.parametrize(
    ("written", "shown", "code"),
    [
        ("[56 2 65 66", "AB", ""),
        ("[38H,2,65,66]", "AB", ""),
        ("[38H,3,65,66", "AB", "count"),
        ("[38H,1,65,66", "A", "count"),
        ("[38H", "", "bad-number"),
        ("[38H,1,321", "A", "range"),
        ("[138H,1,65", "A", "range"),
    ],
)
def test_data_for_the_display_may_end_in_a_bracket_and_the_fewer_count(written: str, shown: str, code: str) -> None:
    rig = Rig545()
    display = rig.bench.part("hp_display", to=rig.x)
    rig.send(f"{written}\r")
    assert display.text.rstrip() == shown
    assert rig.codes == ([code] if code else [])


@pytest.mark.fact("CY545-XMEM-6")
def test_other_cycles_leave_the_memory_alone() -> None:
    rig = Traced("hp_display", "thumbwheels")
    before = rig.ram.content
    edges = rig.lines("R #\r[38H,2,65,66\r")
    assert "xmem_sel-" not in edges
    assert rig.ram.content == before


@pytest.mark.fact("CY545-DISP-1", "CY545-DISP-4", "CY545-DISP-5", "CY545-DISP-6", "CY545-MODE-4")
@pytest.mark.parametrize("address", [0x38, 0x78, 0xB8, 0xF8])
def test_six_address_lines_reach_the_display(address: int) -> None:
    rig = Rig545()
    display = rig.bench.part("hp_display", to=rig.x)
    rig.send(f"[{address},3,65,66,67\r")
    assert display.text == "ABC     "


@pytest.mark.fact("CY545-UND-HP-OUTPUT", "CY545-DISP-6")
def test_strings_and_replies_on_the_display() -> None:
    rig = Rig545(replies=False)
    display = rig.bench.part("hp_display", to=rig.x)
    shown: list[str] = []
    display.on_change.add(lambda: shown.append(display.text))
    rig.send('O 85H\r"Hello"\r')
    assert display.text == "Hello   "
    rig.send("? R\r")
    assert display.text == "R=00100 "
    rig.send('"a longer text"\r')
    assert display.text == "ger text"
    rig.send("A 12345\r? P\r")
    assert display.text == "00012345"
    assert not rig.host.received and shown[-1] == "00012345"


@pytest.mark.fact("CY545-UND-HP-OUTPUT", "CY545-QUERY-3")
@pytest.mark.parametrize(
    ("command", "query", "shown"),
    [("R 13", b"R", b"R=\x00\r    "), ("N 3341", b"N", b"N=\x00\r\r   "), ("A 0D0D0DH", b"P", b"P=\r\r\r   ")],
)
def test_in_binary_the_display_gets_a_value_with_returns_in_it(command: str, query: bytes, shown: bytes) -> None:
    rig = Rig545(replies=False)
    display = rig.bench.part("hp_display", to=rig.x)
    rig.send(f"{command}\rO 5\r")
    rig.host.send(b"?\x01" + query)
    rig.bench.run_until_idle()
    assert bytes(display._cells[0x38:0x40]) == shown


@pytest.mark.fact("CY545-DISP-7")
def test_the_mode_routes_a_reply_to_one_of_four_devices() -> None:
    rig = Rig545("txd", replies=False, serial=True)
    rig.bench.run_until_idle()
    rig.host.heed(True)
    display, lcd = rig.bench.part("hp_display", to=rig.x), rig.bench.part("lcd", to=rig.x)
    found = []
    for mode in ("80H", "82H", "81H", "85H"):
        before = (len(rig.falls("txd")), len(rig.host.received), display.text)
        rig.serial.send(f"O {mode}\r? R\r")
        rig.bench.run_until_idle()
        after = (len(rig.falls("txd")), len(rig.host.received), display.text)
        found.append([one != two for one, two in zip(before, after, strict=True)])
    assert found == [[True, False, False], [True, False, False], [False, True, False], [False, False, True]]
    assert lcd.parameters == {"R": "00100"}


# ------------------------------------------------------------------------------------------- the serial side and EEPROM
@pytest.mark.fact("CY545-XMEM-11")
@pytest.mark.parametrize("cts", [True, False], ids=["CTS honoured", "CTS ignored"])
def test_a_serial_host_is_faster_than_an_eeprom(cts: bool) -> None:
    bench = slewline.Bench()
    x = bench.add("cy545b", name="x")
    eeprom = bench.part("eeprom", to=x)
    host = bench.host(x, over="serial", baud=19200)
    if not cts:
        host.heed(False)
    host.send("O 0A0H\r")
    bench.run_until_idle()
    host.send("E\rP 100\rP 0\rL 3,0\r0\rQ")
    bench.run("2 s")
    lost = eeprom.content[:18] != b"P 100\rP 0\rL 3,0\r0\r"
    assert lost is not cts
    assert ("serial-overrun" in [found.code for found in x.findings]) is not cts


@pytest.mark.fact("CY545-XMEM-2")
def test_a_listing_reads_its_memory_after_the_pointer_has_gone_out_on_txd() -> None:
    rig = Rig545("txd", "xmem_sel", replies=False, serial=True)
    rig.serial.send("Y 10\rE\rN 1\r+\rQY 10\r")
    rig.bench.run_until_idle()
    begin = rig.bench.now_ps
    rig.serial.send("? M,1\r")
    rig.bench.run_until_idle()
    sent = rig.falls("txd", begin)[0] + len("Y=00010\r") * 10 * S // 9600
    assert rig.serial.received.endswith(b"Y=00010\rN 1\r")
    assert rig.falls("xmem_sel", begin)[0] >= sent
