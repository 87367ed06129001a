"""Commands of a host while a program of the CY545B runs, over both sides; and the CY545, which takes none."""

from __future__ import annotations

import pytest
from cy545 import CC10, QUERYPROG, SHUTTLE, Rig545
from cy545_hand import MS, Hand

from tests.ensembles import few

BOTH = pytest.mark.parametrize("part", ["cy545", "cy545b"])
ENDLESS = "Y 0\rE\rN 5\r+\rG\rJ 0\rQY 0\r"
SLOW = "Y 0\rE\rD 500\rJ 0\rQY 0\r"


def running(program: str, run: str = "X\r", **options: object) -> Rig545:
    """A chip whose program has just been started by the parallel host."""
    rig = Rig545("pulse", "busy", "usrb6", "usrb0", "io_request", memory="ram", **options)
    rig.host.send(program)
    rig.bench.run_until_idle()
    rig.host.send(run)
    rig.bench.run_until(lambda: rig.x.program_counter is not None)
    return rig


def in_hand(program: str, part: str = "cy545b") -> Hand:
    """A chip whose program has been started by hand."""
    h = Hand(part, memory="ram", record=("pulse", "usrb0"))
    for line in program.split("\r"):
        h.say(f"{line}\r")
    for byte in b"X\r":
        h.byte(byte)
    h.bench.run("1 ms")
    return h


def to_the_query(h: Hand) -> None:
    """Enter a program with a query, run it, and stop where that is about to be read."""
    for line in ("O 81H", *QUERYPROG.replace('"OK"\r', "").split("\r"), "Y 0"):
        h.say(f"{line}\r")
    for byte in b"X\r":
        h.byte(byte)
    h.bench.run_until(h.x.at_instruction(9), "10 s")


# ------------------------------------------------------------------------------------------------------ the handshake
@pytest.mark.fact("CY545-IMM-1", "CY545-IMM-6")
def test_a_command_is_performed_between_two_of_the_program_which_continues():
    rig = running(ENDLESS)
    rig.bench.run("200 ms")
    before = len(rig.falls("pulse"))
    rig.host.send("B 16\r")
    rig.bench.run_until(rig.x.pin("usrb0").is_(0), "1 s")
    rig.bench.run("500 ms")
    assert len(rig.falls("pulse")) > before + 20
    assert rig.codes == []


@pytest.mark.fact("CY545-IMM-2", "CY545-IMM-4", "CY545-IMM-5")
def test_an_empty_handshake_and_then_the_command_byte_by_byte():
    h = in_hand(ENDLESS)
    h.byte(None)
    for byte in b"\x42\x20\x31\x36\x0d":
        h.byte(byte)
    h.until("usrb0", 0, "1 s")
    h.bench.run("500 ms")
    assert h.x.program_counter is not None and h.codes == []


@pytest.mark.fact("CY545-IMM-3", "CY545-CON-FIRST-HANDSHAKE", "CY545-UND-IMM-POLL")
def test_the_first_handshake_is_answered_when_the_command_of_the_program_is_over():
    h = in_hand(SLOW.replace("J 0\r", "B 16\rB 0\rJ 0\r"))
    began = h.bench.now_ps
    h.bench.run("100 ms")
    h.request(0)
    h.until("busy", 0)
    assert h.bench.now_ps - began == pytest.approx(499 * MS, rel=0.01)
    assert h.x.pin("usrb6").level == 1
    assert h.x.pin("usrb0").level == 1  # the next command of the program has not begun
    h.bench.run("2 s")
    assert h.x.pin("usrb0").level == 1  # nor does it, while the host is there


@pytest.mark.fact("CY545-IMM-6", "CY545-UND-STOP-POINTER")
def test_0_ends_the_program_with_the_pointer_at_the_command_that_was_not_read():
    rig = running(SLOW)
    rig.bench.run("100 ms")
    rig.host.send("0\r")
    rig.bench.run_until_idle()
    assert rig.x.program_counter is None and rig.x.registers["pointer"] == 6  # behind D 500 and its return
    assert rig.x.idle and rig.codes == []


@pytest.mark.fact("CY545-IMM-7", "CY545-IMM-8")
def test_a_message_that_comes_first_is_read_and_then_the_command_is_taken():
    h = Hand(memory="ram", record=("usrb0",))
    to_the_query(h)
    h.request(0)  # the first handshake, with an open bus
    h.until("usrb6", 0, "10 s")
    assert h.x.pin("busy").level == 1  # FPL fell first: there is a message
    h.until("busy", 0)
    found = bytearray([h.x.bus.byte])
    h.request(1)
    h.until("busy", 1)
    found += h.message()
    assert found == b"P=00000050\r"
    h.byte(None)
    assert h.x.pin("usrb6").level == 1
    for byte in b"B 16\r":
        h.byte(byte)
    h.until("usrb0", 0, "1 s")
    assert h.codes == []


@pytest.mark.fact("CY545-IMM-7", "CY545-IMM-8")
@pytest.mark.parametrize("part", ["cy545b"])
@pytest.mark.parametrize("count", few([30, 100], 1))
def test_passes_with_messages_and_a_command_in_each(part, count):
    rig = running(QUERYPROG.replace("N 50", "N 5") + "Y 0\r", part=part)
    for number in range(count):
        rig.host.send(f"B {16 if number % 2 == 0 else 0}\r")
        rig.bench.run_until(lambda n=number: rig.host.received.count(b"OK") > n and rig.host.idle, "10 s")
    rig.host.send("0\r")
    rig.bench.run_until_idle()
    said = bytes(rig.host.received)
    passes = said.count(b"OK")
    assert passes >= count
    expected = b"".join(b"P=%08d\rOK" % (5 * n) for n in range(1, passes + 2))
    assert expected.startswith(said) or said + b"OK" in expected + b"OK"
    assert len(rig.edges("usrb0")) == count and rig.codes == []


@pytest.mark.fact("CY545-IMM-7", "CY545-IMM-8")
def test_a_host_with_a_request_just_before_a_message_reads_it_first():
    rig = running(QUERYPROG + "Y 0\r")
    rig.bench.run_until(rig.x.at_instruction(9), "10 s")  # ? P is being read
    rig.host.send("B 16\r")
    rig.bench.run_until(rig.x.pin("usrb0").is_(0), "1 s")
    assert bytes(rig.host.received).startswith(b"P=00000050\r")
    flow = rig.falls("usrb6")[0]
    assert [level for time, level in rig.edges("io_request") if time < flow][-1] == 0  # in the first handshake
    assert rig.codes == []


@pytest.mark.fact("CY545-DER-IMM-DEADLOCK")
def test_a_host_that_ignores_fpl_takes_a_byte_of_a_message_for_its_answer():
    h = Hand(memory="ram", record=("usrb0",))
    to_the_query(h)
    h.byte(None)  # answered with the P of the message
    h.until("busy", 1)
    h.put(ord("B"))
    h.request(0)
    h.until("busy", 0)
    assert "conflict" in h.codes and h.x.pin("usrb0").level == 1


@pytest.mark.fact("CY545-IMM-9")
def test_without_messages_fpl_stays_high_in_the_first_handshake():
    rig = running(SHUTTLE + "Y 0\r")
    for _ in range(5):
        rig.bench.run("100 ms")
        rig.host.send("B 16\rB 0\r")
    rig.bench.run_until_idle("20 s")
    assert len(rig.falls("pulse")) == 600 and rig.edges("usrb6") == [] and rig.codes == []


@pytest.mark.fact("CY545-IMM-10")
def test_a_byte_on_the_bus_in_the_first_handshake_is_in_conflict_with_the_memory():
    h = in_hand("Y 0\rE\rB 0\rJ 0\rQY 0")
    h.bench.run_until(h.x.at_instruction(0), "1 s")
    h.put(0x42)
    h.request(0)
    h.bench.run("2 ms")
    assert "conflict" in h.codes


@pytest.mark.fact("CY545-UND-IMM-DRIVEN")
def test_a_letter_in_the_first_handshake_is_taken_and_reported():
    h = in_hand("Y 0\rE\rD 100\rJ 0\rQY 0")
    h.bench.run("10 ms")
    h.byte(ord("B"))  # in the middle of D: memory is not read
    for byte in b" 16\r":
        h.byte(byte)
    h.until("usrb0", 0, "1 s")
    assert [code for code in h.codes if code != "conflict"] == ["missing-ff"]


@pytest.mark.fact("CY545-IMM-11", "CY545-IMM-12")
@BOTH
def test_in_direct_mode_the_empty_handshake_is_ignored_and_not_needed(part):
    h = Hand(part, record=("usrb0",))
    h.say("B 16\r")
    assert h.x.pin("usrb0").level == 0
    for byte in (None, *b"B 0\r"):
        h.byte(byte)
    h.until("busy", 1)
    assert h.x.pin("usrb0").level == 1 and h.codes == []


@pytest.mark.fact("CY545-IMM-12")
@BOTH
def test_an_ff_on_the_serial_side_is_ignored_too(part):
    rig = Rig545(part=part, replies=False, serial=True)
    rig.serial.send(b"\xffB 16\r")
    rig.bench.run_until_idle()
    assert rig.level("usrb0") == 0 and rig.codes == []


@pytest.mark.fact("CY545-IMM-16", "CY545-UND-BUSY-PROGRAM")
def test_busy_is_high_while_a_program_of_the_cy545b_runs():
    rig = running(CC10 + "Y 10\r")
    rig.bench.run("1 ms")
    start = rig.bench.now_ps
    rig.bench.run("10 s")
    assert rig.level("busy") == 1 and rig.edges("busy", start) == []


@pytest.mark.fact("CY545-IMM-15", "CY545-UND-BUSY-PROGRAM")
def test_busy_is_low_while_a_program_of_the_cy545_runs_and_no_host_is_served():
    rig = running("Y 0\rE\rD 500\r0\rQY 0\r", part="cy545", serial=True)
    rig.serial.write("\r\r")
    rig.bench.run("100 ms")
    assert rig.level("busy") == 0
    rig.host.send("B 16\r")
    rig.serial.write("B 1")
    rig.bench.run("300 ms")
    assert (rig.level("usrb0"), rig.level("usrb1"), rig.x.program_counter) == (1, 1, 0)
    rig.bench.run("200 ms")
    rig.serial.write("7\r")
    rig.bench.run("100 ms")
    assert (rig.level("usrb0"), rig.level("usrb1")) == (0, 0) and rig.x.program_counter is None
    assert rig.codes == []


def test_a_cy545_whose_program_was_started_over_the_serial_side_does_not_answer_the_bus_before_it_stops():
    rig = Rig545(part="cy545", serial=True, replies=False)
    rig.enter("D 500", "0")
    rig.serial.send("Y 0\rX\r")
    rig.bench.run("100 ms")
    assert rig.x.program_counter == 0 and rig.level("busy") == 1
    rig.host.send("B 16\r")
    rig.bench.run("300 ms")
    assert rig.level("usrb0") == 1
    rig.bench.run_until_idle()
    assert rig.level("usrb0") == 0 and rig.codes == []


# --------------------------------------------------------------------------------------------------- the serial side
@pytest.mark.fact("CY545-IMM-11", "CY545-IMM-13")
def test_a_serial_command_needs_no_prefix_and_is_taken_between_two_of_the_program():
    rig = running(CC10 + "Y 10\r", serial=True)
    rig.serial.send("")
    rig.bench.run("1 s")  # in D 2000
    rig.serial.send("B 1")
    rig.bench.run("1200 ms")
    assert rig.level("usrb0") == 1 and rig.x.unfinished == "B 1"  # read behind D, and not complete
    rig.serial.send("6\r")
    rig.bench.run("100 ms")
    assert rig.level("usrb0") == 0
    before = len(rig.falls("pulse"))
    rig.bench.run("5 s")
    assert len(rig.falls("pulse")) >= before + 2 and rig.codes == []


@pytest.mark.fact("CY545-IMM-14")
@pytest.mark.parametrize("over", ["serial", "parallel"])
def test_a_command_that_has_begun_holds_the_program_until_its_end(over):
    rig = running(ENDLESS, serial=True)
    host = rig.serial if over == "serial" else rig.host
    host.send("B")
    rig.bench.run("1 s")
    steps = len(rig.falls("pulse"))
    rig.bench.run("5 s")
    assert len(rig.falls("pulse")) == steps
    host.send(" 16\r")
    rig.bench.run("1 s")
    assert rig.level("usrb0") == 0 and len(rig.falls("pulse")) > steps and rig.codes == []


@pytest.mark.fact("CY545-UND-IMM-POLL")
def test_of_two_requesting_sides_the_parallel_one_is_served_first():
    rig = running(SLOW, serial=True)
    done = []
    rig.x.on_command.add(lambda text: done.append(text) if text.startswith("B") else None)
    rig.serial.send("B 1")  # three characters wait, and more may come
    rig.bench.run("50 ms")
    rig.host.send("B 17\r")
    rig.bench.run_until(lambda: len(done) == 1, "1 s")
    rig.serial.send("6\r")
    rig.bench.run("200 ms")
    assert done == ["B 17", "B 16"] and rig.codes == []
