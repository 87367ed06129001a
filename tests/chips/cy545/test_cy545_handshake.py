"""The parallel side of the CY545, wire by wire: bytes in, messages out, and what a host may do wrong."""

from __future__ import annotations

import pytest
from cy545_hand import MS, US, Hand

from slewline.chips.cy545.sheet import CY545, CY545B
from slewline.parts.boards.parallel_card import ParallelCard

BOTH = pytest.mark.parametrize("part", ["cy545", "cy545b"])
REPLY = b"R=00100\r"


def asked(part: str = "cy545b", query: str | bytes = "? R\r", mode: str = "81H", **options: object) -> Hand:
    """A chip with a message for the host: FPL is low, BUSY is high."""
    h = Hand(part, **options)
    h.say(f"O {mode}\r")
    for byte in query.encode() if isinstance(query, str) else query:
        h.byte(byte)
    h.until("usrb6", 0)
    h.until("busy", 1)
    return h


# --------------------------------------------------------------------------------------------------------- bytes in
@pytest.mark.fact("CY545-HS-1")
@pytest.mark.parametrize("sheet", [CY545, CY545B])
def test_the_port_is_the_bus_a_request_and_two_answers_of_which_one_is_user_bit_6(sheet):
    ways = {role: sheet.role(role).way for role in ("request", "ready")}
    assert ways == {"request": "in", "ready": "out"}
    assert sheet.role("flow").name == "usrb6"
    assert [pin.name for pin in sheet.pins if pin.role == "data"] == [f"db{n}" for n in range(8)]


@pytest.mark.fact("CY545-HS-2")
def test_bytes_on_the_bus_are_ignored_while_io_request_is_high():
    h = Hand()
    before = dict(h.x.registers)
    for number in range(100):
        h.put(b"R 5\rG\r"[number % 6])
        h.run(100)
    assert h.falls("busy") == [] and h.x.registers == before and h.codes == []


@pytest.mark.fact("CY545-HS-3", "CY545-HS-5", "CY545-HS-6", "CY545-UND-HS-TIMING", "CY545-UND-HS-SAMPLE")
@BOTH
@pytest.mark.parametrize("mhz", [12, 11, 6, 1])
def test_the_lines_of_one_byte_move_in_order_and_in_time(part, mhz):
    h = Hand(part, crystal=f"{mhz} MHz")
    h.run(100)
    start = h.bench.now_ps
    h.byte(ord("+"), hold=1)
    rose = h.bench.now_ps
    h.run(1000)
    assert h.order(start - 1) == [("io_request", 0), ("busy", 0), ("io_request", 1), ("busy", 1)]
    fell, back = h.falls("busy")[0], h.rises("busy")[0]
    assert abs(fell - start - 25 * US * 12 // mhz) <= US and rose - fell == US
    assert abs(back - rose - 25 * US * 12 // mhz) <= US
    h.byte(0x0D)
    rose = h.bench.now_ps
    h.until("busy", 1)
    assert h.x.pin("ccw").level == 0  # the byte that was gone 1 us behind the fall of BUSY was taken
    assert h.rises("busy")[-1] - rose >= 25 * US * 12 // mhz


@pytest.mark.fact("CY545-HS-3")
def test_within_a_command_busy_rises_25_us_after_io_request():
    h = Hand()
    h.byte(ord("R"), hold=40)
    rose = h.bench.now_ps
    h.request(0)  # the next one is asked for: BUSY comes back first
    h.until("busy", 1)
    assert h.bench.now_ps - rose == 25 * US
    assert h.codes == ["early-request"]


@pytest.mark.fact("CY545-HS-4", "CY545-UND-HS-SAMPLE")
def test_a_byte_that_changes_before_busy_falls_takes_its_later_value_and_is_reported():
    h = Hand()
    for byte in b"R ":
        h.byte(byte)
    h.until("busy", 1)
    h.put(ord("5"))
    h.request(0)
    h.run(10)
    h.put(ord("7"))
    h.until("busy", 0)
    h.request(1)
    h.put(None)
    h.say("\r")
    assert h.x.registers["rate"] == 7 and h.codes == ["byte-changed"]


@pytest.mark.fact("CY545-HS-7")
def test_every_character_has_its_own_handshake():
    h = Hand()
    h.say("N 200\r")
    assert len(h.falls("busy")) == len(h.rises("busy")) == 6


@pytest.mark.fact("CY545-HS-8")
@pytest.mark.parametrize(("command", "least_ms", "most_ms"), [("D 100\r", 98, 102.2), ("N 40\rG\r", 50, 1000)])
def test_the_last_character_of_a_command_takes_as_long_as_the_command(command, least_ms, most_ms):
    h = Hand(record=("stopped",))
    h.say(command)
    widths = [up - down for down, up in zip(h.falls("busy"), h.rises("busy"), strict=True)]
    assert all(width < MS for width in widths[:-1])
    assert least_ms * MS <= widths[-1] <= most_ms * MS
    if "G" in command:
        assert h.rises("busy")[-1] >= h.rises("stopped")[-1] > h.falls("stopped")[-1] > h.falls("busy")[-1]


@pytest.mark.fact("CY545-HS-9")
def test_a_host_with_a_request_of_a_microsecond_loses_its_byte_and_a_latch_keeps_it():
    h = Hand()
    h.put(ord("+"))
    h.request(0)
    h.run(1)
    h.request(1)
    h.put(None)
    h.run(1000)
    assert h.codes == ["short-request"] and h.falls("busy") == []
    bench = h.bench.__class__()
    x = bench.add("cy545b")
    card = bench.part("parallel_card", to=x)
    for byte in b"+\r":
        bench.run_until(x.pin("busy").is_(1))
        card.out(0x340, byte)  # a write cycle of 0.75 us, behind which the card holds byte and request
        card.out(0x342, 3)
        bench.run_until(x.pin("busy").is_(0))
        card.out(0x342, 0)
    bench.run_until_idle()
    assert x.pin("ccw").level == 0 and x.findings == []


# -------------------------------------------------------------------------------------------------------- messages out
@pytest.mark.fact("CY545-HS-10", "CY545-FPL-1", "CY545-MODE-3")
@BOTH
def test_a_reply_comes_by_the_bus_a_handshake_a_byte_with_fpl_low_all_the_time(part):
    h = asked(part)
    start = h.bench.now_ps
    assert h.message() == REPLY
    assert len(h.falls("busy", start)) == len(REPLY)
    assert (len(h.falls("usrb6")), len(h.rises("usrb6"))) == (1, 1)
    assert h.falls("txd") == [] and h.codes == []


@pytest.mark.fact("CY545-HS-11", "CY545-HS-12")
@BOTH
def test_the_lines_of_a_byte_for_the_host_move_in_order(part):
    h = asked(part)
    assert h.x.bus.level is None and h.x.pin("busy").level == 1
    h.run(50)
    start = h.bench.now_ps
    h.request(0)
    h.run(1)
    assert h.x.bus.level == (0xFF, ord("R")) and h.x.pin("busy").level == 1  # on the bus before BUSY says so
    h.until("busy", 0)
    assert h.bench.now_ps - start == pytest.approx(25 * US, abs=US)
    h.run(500)
    assert h.x.bus.level == (0xFF, ord("R"))  # for as long as the host likes
    h.request(1)
    h.run(0.001)
    assert h.x.bus.level is None and h.x.pin("busy").level == 0
    h.until("busy", 1)
    assert h.order(start - 1, ("io_request", "busy")) == [
        ("io_request", 0),
        ("busy", 0),
        ("io_request", 1),
        ("busy", 1),
    ]


@pytest.mark.fact("CY545-HS-13")
def test_the_chip_waits_for_a_silent_host_and_loses_nothing():
    h = asked()
    h.bench.run("100 s")
    assert h.x.pin("usrb6").level == 0
    assert h.message() == REPLY


@pytest.mark.fact("CY545-FPL-2", "CY545-FPL-6", "CY545-FPL-7", "CY545-CON-FPL-EDGE")
@pytest.mark.parametrize(
    ("part", "last"),
    [
        ("cy545b", [("io_request", 0), ("busy", 0), ("io_request", 1), ("usrb6", 1), ("busy", 1)]),
        ("cy545", [("io_request", 0), ("usrb6", 1), ("busy", 0), ("io_request", 1), ("busy", 1)]),
    ],
)
def test_fpl_ends_after_the_request_of_the_last_byte_or_before_busy_answers_it(part, last):
    h = asked(part)
    for byte in REPLY[:-1]:
        assert h.fetch() == byte
        assert h.x.pin("usrb6").level == 0
    h.run(50)
    start = h.bench.now_ps
    assert h.fetch(hold=30) == 0x0D
    h.run(100)
    assert h.order(start - 1) == last


@pytest.mark.fact("CY545-FPL-3", "CY545-CON-BINARY-FPL")
@BOTH
def test_in_binary_every_byte_has_its_own_fpl(part):
    h = asked(part, query=b"\x3f\x01R", mode="1")
    found = bytearray()
    for _ in range(4):
        h.until("usrb6", 0)
        h.until("busy", 1)
        found.append(h.fetch())
        assert h.x.pin("usrb6").level == 1
    assert bytes(found) == b"R=\x00\x64"
    assert len(h.falls("usrb6")) == len(h.rises("usrb6")) == 4


@pytest.mark.fact("CY545-FPL-4")
@pytest.mark.parametrize(("query", "mode", "messages"), [("? R\r", "81H", 1), (b"\x3f\x01R", "1", 4)])
def test_a_network_controller_sends_a_message_for_each_time_that_fpl_is_low(query, mode, messages):
    h = asked(query=query, mode=mode)
    while h.bench.now_ps < 20 * MS:
        if h.x.pin("usrb6").level == 0:
            h.fetch()
        else:
            h.run(100)
    assert len(h.falls("usrb6")) == messages


@pytest.mark.fact("CY545-FPL-5")
@pytest.mark.parametrize("query", ["? R\r", '"some text"\r', "? M,1\r"])
def test_the_chip_drives_the_bus_towards_the_host_only_while_fpl_is_low(query):
    h = asked(query=query, memory="ram")
    found = bytearray()
    for _ in range(30):
        if h.x.pin("usrb6").level == 1:
            break
        h.request(0)
        for _ in range(60):
            h.run(1)
            assert h.x.bus.level is None or h.x.pin("usrb6").level == 0
        found.append(h.x.bus.byte)
        h.request(1)
        h.until("busy", 1)
    assert len(found) > 7


@pytest.mark.fact("CY545-UND-STRING-FPL")
def test_a_string_ends_fpl_with_its_last_character():
    h = asked(query='"Hello"\r')
    assert h.message() == b"Hello"
    assert len(h.falls("usrb6")) == 1 and h.x.pin("usrb6").level == 1


@pytest.mark.fact("CY545-FPL-2", "CY545-UND-STRING-FPL")
@BOTH
def test_each_return_in_a_string_raises_fpl(part):
    h = asked(part, query='"one\rtwo\r\rlast"\r')
    for line in (b"one\r", b"two\r", b"\r", b"last"):
        h.until("usrb6", 0)
        assert h.message() == line
    assert len(h.falls("usrb6")) == 4 and h.x.pin("usrb6").level == 1


@pytest.mark.fact("CY545-FPL-8")
def test_a_controller_is_wired_by_its_request_its_answer_and_fpl():
    h = Hand()
    card = h.bench.part("parallel_card", to=h.x)
    assert isinstance(card, ParallelCard)
    for own, theirs in (("io_request", "io_request"), ("busy", "busy"), ("fpl", "usrb6"), ("db", "db0")):
        assert card.pin(own).net.root is h.x.pin(theirs).net.root


# ------------------------------------------------------------------------------------------------------ mistakes
def test_a_request_that_is_withdrawn_before_a_byte_came_gets_it_offered_again():
    h = asked()
    h.request(0)
    h.run(5)
    h.request(1)
    h.run(100)
    assert h.codes == ["short-request"] and h.x.pin("usrb6").level == 0
    assert h.message() == REPLY


@pytest.mark.fact("CY545-HS-14", "CY545-DER-SHARED-BUS")
def test_a_host_that_drives_the_bus_while_the_chip_reads_memory_is_in_conflict():
    h = Hand(memory="ram")
    h.say("Y 0\rE\rD 1\rJ 0\rQY 0\r")
    h.say("X\r")
    h.bench.run("3 ms")
    assert h.codes == []
    h.put(ord("B"))
    h.bench.run("3 ms")
    assert h.codes.count("conflict") == 1  # though every cycle is one


def test_reset_in_the_middle_of_a_message_ends_it():
    h = asked()
    h.fetch()
    h.x.reset()
    h.bench.run("20 ms")
    assert (h.x.pin("usrb6").level, h.x.pin("busy").level, h.x.bus.level) == (1, 1, None)
    h.say("O 81H\r")
    for byte in b"? R\r":
        h.byte(byte)
    h.until("usrb6", 0)
    h.until("busy", 1)
    assert h.message() == REPLY
