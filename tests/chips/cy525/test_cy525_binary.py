"""The CY525 with ASCII/BINARY low: letter, count of data bytes, data."""

from __future__ import annotations

import pytest

from slewline.chips.cy525.sheet import SHEET

US = 1_000_000  # picoseconds
OUT = "programmable_output"
COUNTS = {0: "BCXEGHIUW+-0", 1: "FJORSTVZ", 2: "ALNPD"}


@pytest.fixture
def binary(rig):
    """A rig whose chip is strapped to binary."""
    return lambda **options: rig(straps={"ascii_binary": 0}, **options)


@pytest.mark.fact("BIN-1", "LANG-FORM-3", "BIN-5")
def test_the_level_of_a_pin_chooses_the_mode(rig):
    r = rig()
    for mode, clear, number in ((0, b"C\0", bytes.fromhex("4E 02 E2 02")), (1, b"C\r", b"N 738\r")):
        r.send(b"B\rN 1\r" if r.level("ascii_binary") else b"B\0N\x02\x01\0")
        r.drive("ascii_binary", mode)
        r.send(clear)
        assert r.level(OUT) == 0
        r.send(number)
        assert r.x.registers["number"] == 738 and r.codes == []


@pytest.mark.fact("BIN-2", "LANG-FORM-3")
def test_a_command_begins_when_its_count_is_used_up(binary):
    r = binary(record=(OUT, "ready"))
    r.send(b"C\0")
    r.host.send(b"B")
    r.bench.run("10 ms")
    assert r.level(OUT) == 0 and r.level("ready") == 1
    start = r.bench.now_ps
    r.send(b"\0")
    ((effect, level),) = r.edges(OUT, start)
    assert level == 1 and r.falls("ready", start)[0] < effect < r.rises("ready", start)[0]
    r.send(b"N\x02\x05")
    assert r.x.registers["number"] == 0
    r.send(b"\x01")
    assert r.x.registers["number"] == 0x0105


@pytest.mark.fact("BIN-3", "BIN-4", "BIN-5")
@pytest.mark.parametrize(
    ("count", "letter"), [(count, letter) for count, letters in COUNTS.items() for letter in letters]
)
def test_every_command_has_its_count(binary, count, letter):
    r = binary(position=0, slope=250, divisor=1)
    r.drive("wait", 0 if letter == "U" else 1)
    command = bytes([ord(letter), count]) + bytes([1, 0])[:count]
    if letter != "E":
        r.send(b"E\0" + command + b"Q")
        stored = bytes([0 if letter == "0" else command[0]]) + command[2:]
        assert r.x.program == stored and len(stored) == SHEET.commands[letter].size
    r.send(b"E\0" + b"0\0" * 3 + b"Q")
    before = r.codes
    r.send(command)
    r.bench.run("1 ms")
    r.send((b"Q" if letter == "E" else b"") + bytes.fromhex("4E 02 2C 01"))
    assert r.x.registers["number"] == 300  # the byte behind it was a letter again
    assert set(r.codes[len(before) :]) <= {"uninitialised", "no-steps", "til-command", "unfinished"}


@pytest.mark.fact("BIN-4", "BIN-5", "LANG-PARAM-1")
def test_parameters_reach_their_registers_low_byte_first(binary):
    r = binary()
    r.send(bytes.fromhex("52 01 64 53 01 19 46 01 03 5A 01 07 4E 02 2C 01 41 02 EE 02"))
    assert r.host.verify(3) == bytes.fromhex("01 2C 19 64 03 07")
    assert r.host.verify(0) == bytes.fromhex("02 EE")
    assert r.codes == []


@pytest.mark.fact("BIN-6", "CMD-L-1")
def test_loop_takes_its_count_before_its_address(binary):
    r = binary(number=1, firstrate=50, rate=50)
    r.send(b"E\0" + b"B\0" * 11 + b"G\0" + bytes.fromhex("4C 02 03 0B") + b"0\0Q")
    assert r.host.verify(1, 16)[11:] == bytes.fromhex("47 4C 03 0B 00")
    r.send(b"X\0")
    assert r.x.travel == 3


@pytest.mark.fact("BIN-7")
def test_quit_has_no_count_and_data_that_look_like_it_are_data(binary):
    r = binary(record=("prog",))
    r.send(bytes.fromhex("45 00 52 01 51"))
    assert r.level("prog") == 0 and r.x.program == bytes.fromhex("52 51")
    r.send(b"Q")
    assert r.level("prog") == 1
    r.send(b"C\0")
    assert r.level(OUT) == 0 and r.codes == ["unfinished"]  # before the Q


@pytest.mark.fact("UND-Q-CR", "UND-LETTER")
def test_a_count_after_quit_is_unknown_and_swallows_a_command(binary):
    r = binary()
    r.send(b"E\0B\0Q\0")  # the count of Q: now a letter
    r.send(b"\x02C\0N\x02\x05\0")  # it takes the 2 as its count, C and 0 as its data
    assert r.x.program == b"B" and r.level(OUT) == 1 and r.x.registers["number"] == 5
    assert r.codes == ["unknown-command"]


@pytest.mark.fact("UND-LETTER", "LANG-SET-1", "UND-BIN-LABEL")
@pytest.mark.parametrize("letter", [b"K", b"M", b"Y", b"b", b"$", b"\r", b"\n"])
def test_an_unknown_command_takes_its_count_and_data_along(binary, letter):
    r = binary(record=("instrobe",))
    r.send(letter + b"\x02C\0" + b"N\x02\x05\0")
    assert r.level(OUT) == 1 and r.x.registers["number"] == 5
    assert r.codes == ["unknown-command"] and len(r.falls("instrobe")) == 8
    r.send(b"E\0" + letter + b"\0B\0Q")
    assert r.x.program == b"B"


@pytest.mark.fact("LABEL-5", "UND-JUMP-RANGE")
def test_binary_has_no_labels(binary):
    r = binary()
    r.send(b"C\0" + b"E\0" + bytes.fromhex("4A 01 41") + b"B\x000\0Q")
    assert r.codes == ["range"] and r.x.program == bytes.fromhex("4A 41 42 00")
    r.start(b"X\0")
    r.bench.run("1 s")
    assert r.level("run") == 0 and r.level(OUT) == 0 and r.codes[-1] == "bad-target"


@pytest.mark.fact("BIN-8", "UND-PROG-30", "PROG-3")
def test_a_block_under_one_count_is_kept_unchanged(binary):
    r = binary(record=(OUT,))
    r.send(b"C\0N\x02\x01\0" + b"E\0" + bytes.fromhex("4E 08 05 00 51 30 42 0D 43 00") + b"Q")
    assert r.codes == []
    assert r.host.verify(1, 10) == bytes.fromhex("4E 05 00 51 30 42 0D 43 00 00")
    start = r.bench.now_ps
    r.send(b"X\0")  # 51, 30 and 0D are no opcodes
    assert r.codes == ["unknown-opcode"] * 3 and r.level("run") == 1
    assert [level for _, level in r.edges(OUT, start)] == [1, 0]
    assert r.x.registers["number"] == 5


@pytest.mark.fact("PROG-3")
def test_the_0_command_is_stored_as_00_in_either_form(rig):
    for mode, entry in ((1, b"E\r0\rB\rQ"), (0, b"E\x000\0B\0Q"), (0, b"E\0G\x02\0BQ")):
        r = rig(straps={"ascii_binary": mode})
        r.send(entry)
        assert r.x.program[-2:] == b"\0B"


@pytest.mark.fact("UND-BIN-COUNT")
def test_a_wrong_count_in_command_mode(binary):
    r = binary()
    r.send(bytes.fromhex("4E 02 02 03 4E 01 05"))
    assert r.x.registers["number"] == 5  # what is missing counts as 0
    r.send(bytes.fromhex("52 03 64 46 03 5A 00"))
    assert r.x.registers["rate"] == 100 and (r.x.registers["firstrate"], r.x.registers["divisor"]) == (3, 0)
    r.send(bytes.fromhex("43 01 42"))
    assert r.level(OUT) == 0  # what is too much is ignored
    assert [code for code in r.codes if code != "range"] == ["count"] * 4


@pytest.mark.fact("UND-BIN-COUNT")
def test_a_wrong_count_in_program_entry_is_stored_unchanged(binary):
    r = binary()
    r.send(b"E\0B\0" + bytes.fromhex("4E 01 05 43 02 47 48") + b"Q")
    assert r.host.verify(1, 7) == bytes.fromhex("42 4E 05 43 47 48 00")
    assert r.codes == ["count"] * 2


@pytest.mark.fact("BIN-10", "UND-CONV-TIME")
def test_binary_numbers_need_no_conversion(rig):
    busy = []
    for mode, data in ((1, b"R 100\r"), (1, b"R 8\r"), (0, b"R\x01\x64")):
        r = rig(straps={"ascii_binary": mode}, record=("ready",))
        r.send(data)
        busy.append(r.rises("ready")[-1] - r.falls("ready")[-1])
    assert busy == [200 * US, 120 * US, 80 * US]


@pytest.mark.fact("BIN-12")
def test_rates_on_the_fly_are_bytes_whatever_the_mode(rig):
    r = rig(record=("slew",))
    r.host.send("F 3\rR 60\rS 255\rZ 1\rN 60000\rA 0\rH\rG\r")
    r.bench.run_until(r.x.pin("slew").is_(0))
    assert r.level("ascii_binary") == 1
    r.host.change_rate(0x50)
    r.bench.run_until(r.x.pin("slew").is_(0))
    start = r.bench.now_ps
    r.bench.run("10 ms")
    times = r.x.steps(start).times_ps
    assert {round(int(gap) * 11 / US) for gap in times[1:] - times[:-1]} == {1840}  # R 80: 5978 steps/s
    assert r.codes == []
