"""Verify read-outs: one I/O REQUEST a byte with I/O SELECT high, and what the four groups say.

clock        0       154 165 176       286             u        u+165 u+176     u+286
I/O REQUEST  \\_________________________________________/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾
bus          --------<=============== byte ==========================>-------------
OUTSTROBE    ‾‾‾‾‾‾‾‾‾‾‾\\___/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\\_____/‾‾‾‾‾‾‾‾‾‾‾‾
READY        ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\\__________________________________________/‾‾
"""

from __future__ import annotations

import pytest

STROBE, SAMPLE, BUSY = 165, 176, 286
DRIVEN = STROBE - 11  # the byte is on the bus before OUTSTROBE falls
LINES = ("io_request", "instrobe", "outstrobe", "ready", "db0")


def selected(h):
    """I/O SELECT goes high; the host has let go of the bus."""
    h.until(ready=1)
    h.put(h.now, "io_select", 1)


def deselected(h):
    h.put(h.now, "io_select", 0)


def read(h, number):
    selected(h)
    data = h.fetch(number)
    deselected(h)
    return data


# ----------------------------------------------------------------------------------------------- one byte, on the wires


@pytest.mark.fact("VERIFY-1", "VERIFY-2", "PIN-10", "PIN-DB", "PIN-1", "PIN-39", "UND-HS-WIDTH")
@pytest.mark.parametrize("crystal", ["11 MHz", "6 MHz", "3.579545 MHz"])
def test_the_lines_of_one_verify_byte_move_in_order(hand, crystal):
    h = hand(*LINES, crystal=crystal, number=0x8001)
    h.send("V 3\r")
    selected(h)
    h.run(1000)
    start, up = h.now, 5000
    h.put(start, "io_request", 0)
    h.put(start + up, "io_request", 1)
    h.run_to(start + 20_000)
    assert sorted((clock - start, pin, level) for clock, pin, level in h.trace if clock >= start) == [
        (0, "io_request", 0),
        (DRIVEN, "db0", (0xFF, 0x80)),
        (STROBE, "outstrobe", 0),
        (SAMPLE, "outstrobe", 1),
        (BUSY, "ready", 0),
        (up, "io_request", 1),
        (up + STROBE, "outstrobe", 0),
        (up + SAMPLE, "db0", None),
        (up + SAMPLE, "outstrobe", 1),
        (up + BUSY, "ready", 1),
    ]
    assert h.codes == []


@pytest.mark.fact("VERIFY-2")
def test_the_byte_stays_as_long_as_the_request(hand):
    h = hand(number=0x5500)
    h.send("V 3\r")
    selected(h)
    h.put(h.now, "io_request", 0)
    h.run(1_000_000)
    assert h.x.bus.level == (0xFF, 0x55)
    assert h.x.waiting.startswith("x: waiting for io_request=1 (after a verify byte) since ")
    h.put(h.now, "io_request", 1)
    h.run(SAMPLE - 1)
    assert h.x.bus.level == (0xFF, 0x55)
    h.run(1)
    assert h.x.bus.level is None


@pytest.mark.fact("VERIFY-1")
@pytest.mark.parametrize(
    ("up", "codes"), [(50, ["short-request"]), (BUSY - 1, ["short-request"]), (BUSY, []), (BUSY + 11, [])]
)
def test_a_request_that_ends_before_busy_still_fetches_its_byte(hand, up, codes):
    h = hand("outstrobe", "ready", number=0x5566)
    h.send("V 3\r")
    selected(h)
    start = h.now
    h.put(start, "io_request", 0)
    h.put(start + up, "io_request", 1)
    h.run_to(start + 10_000)
    second = max(up, BUSY + 11) + STROBE  # the chip looks for the end of the request once READY is low
    assert h.falls("outstrobe", start) == [STROBE, second]
    assert h.rises("ready", start)[-1] == second + 11 + 110
    assert h.codes == codes
    assert h.fetch(1) == b"\x66"


@pytest.mark.fact("VERIFY-12", "VERIFY-2")
def test_a_host_that_keeps_driving_the_bus_is_reported_and_reads_the_lower_bits(hand):
    h = hand(number=0x8055)
    h.send("V 3\r")
    h.data(h.now, 0x80)
    selected(h)
    assert h.fetch(1) == b"\x80"  # the same byte: nobody disagrees
    assert h.codes == []
    start = h.now
    h.put(start, "io_request", 0)
    h.run(DRIVEN + 1)
    h.until(ready=0)
    h.run(100)
    assert h.codes == ["conflict"]
    h.put(h.now, "io_request", 1)
    h.until(ready=1)
    assert h.codes == ["conflict"]
    h.data(h.now, None)
    assert h.fetch(1) == b"\xff"  # S
    assert h.codes == ["conflict"]


@pytest.mark.fact("VERIFY-12")
@pytest.mark.parametrize("looked", [False, True])
def test_a_conflict_is_found_on_a_watched_or_unwatched_bus(hand, looked):
    h = hand(*["db0"] * looked, number=0x5555)
    h.send("V 3\r")
    h.data(h.now, 0x00)
    selected(h)
    h.put(h.now, "io_request", 0)
    h.run(BUSY + 50)
    h.data(h.now, None)
    h.run(100)
    h.put(h.now, "io_request", 1)
    h.run(5000)
    assert h.codes == ["conflict"]


# ------------------------------------------------------------------------------------------------------------ groups


@pytest.mark.fact("VERIFY-3", "VERIFY-10")
def test_parameters_come_in_their_order_one_by_one(hand):
    h = hand("outstrobe")
    h.send("N 513\rS 25\rR 127\rF 3\rZ 1\rV 3\r")
    assert h.falls("outstrobe") == []  # V itself puts nothing out
    assert read(h, 2) == b"\x02\x01"
    h.run(100_000)
    assert read(h, 4) == b"\x19\x7f\x03\x01"
    assert len(h.falls("outstrobe")) == 12


@pytest.mark.fact("VERIFY-4", "VERIFY-5", "VERIFY-6")
@pytest.mark.parametrize(
    ("position", "digits", "data"), [(750, b"00750", "02 EE"), (0, b"00000", "00 00"), (65535, b"65535", "FF FF")]
)
@pytest.mark.parametrize("later", [0, 1])
def test_the_position_has_the_form_of_the_mode_in_which_v_was_given(hand, position, digits, data, later):
    h = hand(position=position)
    h.send("V 0\r")
    h.put(h.now, "ascii_binary", later)
    assert read(h, 5) == digits
    h.put(h.now, "ascii_binary", 0)
    h.send(b"V\x01\x00")
    h.put(h.now, "ascii_binary", later)
    assert read(h, 2) == bytes.fromhex(data)
    assert h.codes == []


@pytest.mark.fact("UND-HS-MODE", "VERIFY-4")
def test_the_mode_in_which_v_was_given_is_that_of_its_letter(hand):
    h = hand(position=750)
    h.send("V")
    h.put(h.now, "ascii_binary", 0)
    h.send(" 0\r")
    assert read(h, 5) == b"00750"


@pytest.mark.fact("VERIFY-6", "VERIFY-14")
def test_the_other_groups_are_binary_in_both_modes(hand):
    h = hand()
    h.send("N 300\rV 3\r")
    assert read(h, 2) == b"\x01\x2c"
    h.put(h.now, "ascii_binary", 0)
    h.send(b"V\x01\x03")
    assert read(h, 2) == b"\x01\x2c"
    h.put(h.now, "ascii_binary", 1)
    h.send("E\rN 300\rQV 1\r")
    assert read(h, 3) == bytes.fromhex("4E 2C 01")  # in the program the low byte is first


@pytest.mark.fact("VERIFY-7", "CON-VERIFY-BYTES")
def test_the_program_is_read_back_exactly_as_stored(hand):
    h = hand()
    h.send("E\rR 127\rN 300\r+\rG\rN 750\r-\rG\r0\rQV 1\r")
    assert read(h, 13) == bytes.fromhex("52 7F 4E 2C 01 2B 47 4E EE 02 2D 47 00")


@pytest.mark.fact("VERIFY-15")
def test_the_first_four_bytes_of_a_program(hand):
    h = hand()
    h.send("E\rB\rG\rD 500\rL 3,1\rC\r0\rQV 1\r")
    assert read(h, 4) == bytes.fromhex("42 47 44 F4")


@pytest.mark.fact("VERIFY-8", "UND-PROG-STALE", "CON-BUFFER-48")
def test_the_whole_buffer_can_be_read_and_a_note_begins_at_byte_48(hand):
    h = hand()
    h.send("E\rB\rC\r0\rQV 1\r")
    selected(h)
    assert h.fetch(48)[:3] == bytes.fromhex("42 43 00")
    assert h.codes == []
    assert h.fetch(1) == b"\0"
    assert h.codes == ["verify-48"]
    assert h.fetch(11) == bytes(11)
    assert h.codes == ["verify-48"]
    assert h.fetch(2) == b"\xff\xff"
    assert h.codes == ["verify-48", "verify-overrun", "verify-overrun"]


@pytest.mark.fact("UND-PROG-STALE")
def test_no_older_program_shows_after_a_shorter_one(hand):
    h = hand()
    h.send("E\rN 300\rN 300\rN 300\rQE\rB\rQV 1\r")
    assert read(h, 10) == b"B" + bytes(9)


@pytest.mark.fact("VERIFY-9", "UND-VERIFY-STATUS")
@pytest.mark.parametrize(("letters", "sixth"), [("-\r", 0x10), ("-\r+\r", 0x00), ("", 0x00), ("-\rI\r", 0x00)])
def test_the_sixth_status_byte_reports_the_direction(hand, letters, sixth):
    h = hand()
    h.send(letters + "V 2\r")
    assert read(h, 6) == bytes([0, 0, 0, 0, 0, sixth])
    assert h.x.pin("direction").level == (0 if sixth else 1)


@pytest.mark.fact("VERIFY-11")
def test_after_a_read_out_commands_continue(hand):
    h = hand()
    h.send("V 3\r")
    assert len(read(h, 6)) == 6
    h.send("C\r")
    assert h.x.pin("programmable_output").level == 0
    assert h.codes == []


# ------------------------------------------------------------------------------------------- where the manual is silent


@pytest.mark.fact("VERIFY-13", "UND-VERIFY-NOV")
def test_a_read_without_v_brings_ff_and_a_finding(hand):
    h = hand("outstrobe", "ready")
    assert read(h, 2) == b"\xff\xff"
    assert len(h.falls("outstrobe")) == 4  # the handshake is complete
    assert h.codes == ["verify-without-v"] * 2
    h.send("V 3\rI\r")
    assert read(h, 1) == b"\xff"  # I takes the pointer away


@pytest.mark.fact("UND-VERIFY-END")
@pytest.mark.parametrize(("group", "size"), [(0, 5), (2, 6), (3, 6)])
def test_after_the_end_of_a_group_there_is_ff(hand, group, size):
    h = hand("outstrobe")
    h.send(f"V {group}\r")
    selected(h)
    h.fetch(size)
    assert h.codes == []
    assert h.fetch(2) == b"\xff\xff"
    assert h.codes == ["verify-overrun"] * 2
    assert len(h.falls("outstrobe")) == 2 * (size + 2)


@pytest.mark.fact("UND-VERIFY-ARG")
@pytest.mark.parametrize("group", [4, 255])
def test_an_unknown_group_leaves_the_pointer_unchanged(hand, group):
    h = hand(number=0x1234)
    h.send("V 3\r")
    assert read(h, 1) == b"\x12"
    h.send(f"V {group}\r")
    assert h.codes[-1] == "verify-group"
    assert read(h, 1) == b"\x34"


@pytest.mark.fact("UND-VERIFY-SNAPSHOT")
def test_a_group_is_captured_at_its_first_byte(hand):
    h = hand(number=0x1234)
    h.send("V 3\rN 43981\r")
    assert read(h, 1) == b"\xab"  # as it is now, not as it was at V
    h.send("N 1\r")
    assert read(h, 2) == b"\xcd\xff"
    h.send("V 3\r")
    assert read(h, 2) == b"\x00\x01"


@pytest.mark.fact("VERIFY-3")
def test_v_again_restarts_the_read_out(hand):
    h = hand(number=0x1234)
    for _ in range(3):
        h.send("V 3\r")
        assert read(h, 1) == b"\x12"


@pytest.mark.fact("VERIFY-11")
def test_the_host_reads_all_groups(rig):
    r = rig(number=513, slope=25, rate=127, firstrate=3, divisor=1, position=750)
    assert r.host.verify(0) == b"00750"
    assert r.host.verify(3) == bytes.fromhex("02 01 19 7F 03 01")
    assert r.host.verify(2) == bytes(6)
    assert r.host.verify(1) == bytes(48)
    r.drive("ascii_binary", 0)
    assert r.host.verify(0) == b"\x02\xee"
    assert r.host.received == b"00750" + bytes.fromhex("02 01 19 7F 03 01") + bytes(54) + b"\x02\xee"
    assert r.codes == []
