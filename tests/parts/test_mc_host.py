"""The host of a chipset that takes packets: its timing at the pins, its packets, and what it makes of wrong answers."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline
from slewline.errors import UnknownName
from slewline.parts.hosts.ends.packet_port import Packet
from tests.rows import rows

NS, US, MS = 10**3, 10**6, 10**9  # picoseconds
BUSY = 81_920 * NS
CYCLE = 4 * BUSY
STROBE = 120 * NS  # from HostRdy high to the end of the first strobe: the host settles and sets up, and strobes
SECOND = 160 * NS  # from there to the end of the second one: gap and strobe
MOVE = "SET_POS 50\nSET_VEL 65536\nSET_ACC 8192\nUPDATE"
PINS = ("hostslct", "hostcmd", "hostread", "hostwrite", "hostrdy", "hostdata")


class Desk:
    """A chipset x and its host, at the first instant at which HostRdy is high.  Times are picoseconds."""

    def __init__(self, part="mc1451a", record=False, delay=0, **options):
        self.bench = slewline.Bench(**options)
        self.x = self.bench.add(part, name="x")
        self.host = self.bench.host(self.x, delay=delay)
        if record:
            self.bench.record(*(f"x.{pin}" for pin in PINS))
        self.bench.run_until(self.x.pin("hostrdy").is_(1))

    def took(self, call, *arguments, **options):
        """How long a call lasts."""
        before = self.bench.now_ps
        call(*arguments, **options)
        return self.bench.now_ps - before

    def edges(self, pin, since=0):
        times, levels = self.bench.edges(f"x.{pin}")
        return [(int(time), level) for time, level in zip(times, levels.tolist(), strict=True) if time >= since]

    def falls(self, pin, since=0):
        return [time for time, level in self.edges(pin, since) if level == 0]

    def rises(self, pin, since=0):
        return [time for time, level in self.edges(pin, since) if level == 1]

    def level(self, pin, time):
        """The level just before an instant."""
        before = [level for at, level in self.edges(pin) if at < time]
        return before[-1] if before else None


@pytest.fixture
def desk():
    return Desk()


# -------------------------------------------------------------------------------------------------------- at the pins
def test_every_strobe_keeps_the_times_of_the_data_sheet():
    desk = Desk(record=True)
    since = desk.bench.now_ps
    desk.host.command("SET_POS", 0x2345678)
    assert desk.host.query("GET_POS") == 0x2345678
    rows = [(fall, rise, "hostwrite") for fall, rise in zip(*strobes(desk, "hostwrite", since), strict=True)]
    rows += [(fall, rise, "hostread") for fall, rise in zip(*strobes(desk, "hostread", since), strict=True)]
    assert len(rows) == (1 + 4 + 2) + (1 + 4 + 2)
    changes = {pin: [time for time, _ in desk.edges(pin)] for pin in PINS}
    for fall, rise, pin in sorted(rows):
        assert rise - fall >= 50 * NS  # t14
        assert quiet(changes["hostslct"], fall - 20 * NS, rise + 15 * NS)  # t7, t6
        assert quiet(changes["hostcmd"], fall - 20 * NS, rise + 25 * NS)  # t8, t9
        assert desk.level("hostslct", fall) == 0
        if pin == "hostwrite":
            assert quiet(changes["hostdata"], rise - 35 * NS, rise + 30 * NS)  # t15, t16
    rows.sort()
    for (_, rise, _), (fall, *_) in pairwise(rows):
        assert fall - rise >= 60 * NS  # t17, t18
    assert max(changes["hostslct"]) - rows[-1][1] < 2 * US  # note 3


def strobes(desk, pin, since):
    return desk.falls(pin, since), desk.rises(pin, since)


def quiet(changes, start, stop):
    return not any(start < time < stop for time in changes)


@pytest.mark.fact("PMD-HOST-12", "PMD-PKT-13")
def test_bytes_go_over_the_bus_high_word_and_high_byte_first():
    desk = Desk(record=True)
    since = desk.bench.now_ps
    desk.host.command("SET_RATIO", -746455)
    desk.host.command("SET_POS", 1234567)
    sent = [(desk.level("hostcmd", rise), desk.level("hostdata", rise)) for rise in desk.rises("hostwrite", since)]
    command, *words = sent
    assert (command, words[:4]) == ((1, 0x14), [(0, byte) for byte in bytes.fromhex("fff49c29")])
    assert sent[5:] == [(1, 0x10), *((0, byte) for byte in bytes.fromhex("0012d687"))]
    assert desk.host.received == [0x9C31, 0xD6A9]


def test_an_operation_begins_only_while_hostrdy_is_high_and_each_word_is_low_once():
    desk = Desk(record=True)
    since = desk.bench.now_ps
    desk.host.command("SET_VEL", 0x2C000)
    falls, rises = strobes(desk, "hostrdy", since + 1)
    assert len(falls) == len(rises) == 4  # command, two words, checksum
    assert [rise - fall for fall, rise in zip(falls, rises, strict=True)] == [BUSY] * 4
    first = sorted(desk.falls("hostwrite", since) + desk.falls("hostread", since))
    assert all(desk.level("hostrdy", fall) == 1 for fall in first)


@pytest.mark.fact("PMD-HOST-13")
@pytest.mark.parametrize(
    ("command", "words"), [(("UPDATE",), 0), (("SET_MAX_ACC", 7), 1), (("SET_POS", 7), 2), (("GET_VRSN",), 1)]
)
def test_a_packet_lasts_a_busy_period_for_the_command_and_each_word(desk, command, words):
    strobed = STROBE + (words + 1) * (STROBE + SECOND)
    assert desk.took(desk.host.command, *command) == (words + 2) * BUSY + strobed
    assert strobed - 40 * NS < US  # from the first strobe on


def test_a_host_takes_its_own_time_before_each_operation():
    slow, fast = Desk(delay="7 us"), Desk()
    assert slow.took(slow.host.command, "SET_POS", 5) - fast.took(fast.host.command, "SET_POS", 5) == 4 * 7 * US


def test_lines_rest_between_packets(desk):
    desk.host.command("SET_POS", 5)
    desk.bench.run("1 us")
    assert {pin: desk.x.pin(pin).level for pin in ("hostslct", "hostread", "hostwrite", "hostcmd", "hostdata0")} == {
        "hostslct": 1,
        "hostread": 1,
        "hostwrite": 1,
        "hostcmd": 0,
        "hostdata0": None,
    }


# ------------------------------------------------------------------------------------------------------------ packets
def test_a_command_returns_its_signed_value(desk):
    host = desk.host
    assert host.command("set_ratio", -127795) is None
    assert host.query("get_ratio") == host.command("GET_RATIO") == -127795
    assert host.query("GET_VRSN") == 0x5C11
    assert host.packet(0x6C, reads=1) == (0x5C11,)
    assert host.packet(0x10, 0, 100, checksum=False) == ()
    assert host.query("GET_POS") == 100
    assert ([found.code for found in desk.x.findings], host.findings) == (["no-encoder"] * 2, [])


def test_an_illegal_code_is_a_checksum_error(desk):
    with pytest.raises(slewline.ChecksumError) as raised:
        desk.host.packet(0x80, 5)
    text = "packet 80 0005 to x: checksum 0000, expected 0085; 0 is the answer to an illegal command"
    assert str(raised.value) == f"host: {text}"
    (found,) = desk.host.findings
    assert (found.code, found.text) == ("checksum", text)
    assert desk.host.query("GET_STATUS") == 0x0300  # and the host goes on


@pytest.mark.fact("PMD-PKT-15")
def test_a_garbled_word_is_a_checksum_error_and_a_second_packet_repairs_it(desk):
    begun = desk.bench.now_ps
    line = desk.x.pin("hostdata3")
    desk.bench.at(begun + 2 * BUSY, lambda: line.drive(0))  # before the low word of SET_POS
    desk.bench.at(begun + 3 * BUSY, line.release)
    with pytest.raises(slewline.ChecksumError) as raised:
        desk.host.command("SET_POS", 0x0012FFFF)
    assert "SET_POS (10 0012 ffff) to x: checksum f819, expected 0021; a byte was garbled" in str(raised.value)
    assert desk.host.query("GET_POS") == 0x0012F7F7
    desk.host.command("SET_POS", 0x0012FFFF)
    assert desk.host.query("GET_POS") == 0x0012FFFF


def test_returned_values_are_in_the_message(desk):
    line = desk.x.pin("hostdata0")
    desk.bench.at(desk.bench.now_ps + BUSY, lambda: line.drive(0))  # before the word of GET_VRSN
    desk.bench.at(desk.bench.now_ps + 2 * BUSY, line.release)
    with pytest.raises(slewline.ChecksumError, match=r"GET_VRSN \(6c\) to x: returned 5c10, checksum 5c7d, exp"):
        desk.host.query("GET_VRSN")


def test_reset_leaves_no_checksum_and_is_over_when_the_chipset_is_ready(desk):
    desk.host.command("SET_2")
    received = len(desk.host.received)
    took = desk.took(desk.host.command, "RESET")
    assert 10 * CYCLE < took < 12 * CYCLE
    assert len(desk.host.received) == received and desk.x.pin("hostrdy").level == 1
    assert desk.host.query("GET_STATUS") == 0x0300


# --------------------------------------------------------------------------------------------------------------- axes
def commands(desk):
    """The codes of the packets that go out from now on."""
    port, codes = desk.host.port, []
    exchange = port.exchange

    async def noted(packet, axis=0):
        found = await exchange(packet, axis)
        codes.append(packet.code)
        return found

    port.exchange = noted
    return codes


def test_a_view_selects_its_axis_only_if_another_one_is_current(desk):
    codes = commands(desk)
    two = desk.host.axis(2)
    two.command("SET_POS", 22)
    two.command("SET_VEL", 5)
    assert two.query("GET_POS") == 22
    assert desk.host.query("GET_POS") == 22  # it is the current axis
    assert desk.host.axis(1).query("GET_POS") == 0
    assert [code for code in codes if code < 5] == [2, 1]
    assert [desk.x.axis(n).registers["pos"] for n in (1, 2)] == [0, 22]


def test_a_view_sends_waits_and_takes_packets(desk):
    desk.host.axis(3).send("SET_POS 3\nSET_VEL 3")
    assert desk.host.axis(3).packet(0x4A, reads=2) == (0, 3)
    assert desk.host.axis(4).wait("motor_on") == 0x3300


@pytest.mark.parametrize(
    "change",
    [
        lambda desk: desk.host.command("SET_1"),
        lambda desk: desk.host.command("RESET"),
        lambda desk: desk.host.packet(0x01, checksum=False),
        lambda desk: desk.host.write_command(0x01),
        lambda desk: desk.host.send(b"\x01"),
        lambda desk: desk.x.reset(),
        lambda desk: desk.x.pin("reset").pulse(0, "5 us"),
        lambda desk: (desk.x.power(False), desk.bench.run("1 ms"), desk.x.power(True)),
    ],
)
def test_the_host_knows_the_commands_that_change_the_current_axis(desk, change):
    desk.host.axis(2).command("SET_POS", 2)
    change(desk)
    desk.host.axis(2).command("SET_POS", 22)
    assert [desk.x.axis(n).registers["pos"] for n in (1, 2)] == [0, 22]


def test_the_host_knows_the_axis_that_single_operations_have_set(desk):
    codes = commands(desk)
    desk.host.write_command(0x03)
    desk.host.axis(3).command("SET_POS", 3)
    desk.host.write_command(0x01, ready=False)  # perhaps not taken
    desk.host.axis(3).command("SET_VEL", 3)
    assert codes == [0x10, 0x03, 0x11]
    registers = desk.x.axis(3).registers
    assert (registers["pos"], registers["vel"]) == (3, 3)


def test_the_interrupting_axis_becomes_the_current_one(desk):
    host = desk.host
    host.axis(3).command("SET_INTRPT_MASK", 1)
    host.axis(3).command("STOP")
    host.axis(3).command("UPDATE")
    host.axis(1).wait("motor_on")
    desk.bench.run(2 * CYCLE)
    codes = commands(desk)
    assert host.command("SET_I") & 0x3001 == 0x2001
    host.axis(3).command("RST_INTRPT", 0)
    assert codes == [0x08, 0x32]


# -------------------------------------------------------------------------------------------------------------- queue
def test_text_is_queued_and_comments_are_not(desk):
    desk.host.send("SET_POS 0x3039  ; a comment\n\n  set_vel $2C000\nSET_ACC -5")
    assert desk.host.idle is False and desk.x.registers["pos"] == 0
    desk.bench.run_until_idle()
    registers = desk.x.registers
    assert (registers["pos"], registers["vel"], registers["acc"]) == (12345, 0x2C000, -5)


def test_a_wrong_line_is_refused_before_anything_is_queued(desk):
    with pytest.raises(slewline.UsageError, match="SET_VLE is not a command of the MC1451A; write SET_VEL"):
        desk.host.send("SET_POS 5\nSET_VLE 7")
    assert desk.host.idle


def test_bytes_are_a_command_and_its_arguments(desk):
    desk.host.send(b"\x11\x00\x02\xc0\x00")
    desk.bench.run_until_idle()
    assert desk.x.registers["vel"] == 0x2C000 and desk.host.received == []


def test_a_packet_that_nobody_waits_for_leaves_a_finding(desk):
    desk.host.send("SET_POS 5")
    desk.x.pin("hostdata2").drive(0)
    desk.bench.run_until_idle()
    assert [found.code for found in desk.host.findings] == ["checksum"]


# -------------------------------------------------------------------------------------------------- single operations
@pytest.mark.fact("PMD-HOST-3", "PMD-HOST-4", "PMD-HOST-6", "PMD-HOST-18")
def test_words_may_go_in_halves_with_hostslct_high_between_them():
    desk = Desk(record=True)
    host, since = desk.host, desk.bench.now_ps + 1
    host.write_command(0x11)
    for byte in (0x00, 0x02, 0xC0, 0x00):
        host.write_byte(byte)
    assert host.read_word() == 0x11 + 0x2 + 0xC000
    host.write_command(0x6C)
    assert (host.read_byte(), host.read_byte()) == (0x5C, 0x11)
    assert desk.x.registers["vel"] == 0x2C000 and desk.x.findings == []
    assert host.received == [0xC013]  # whole words
    assert len(desk.falls("hostslct", since)) == 9  # one for each byte, but only one for the word that was read whole
    assert len(desk.falls("hostrdy", since)) == 6  # two commands and four words


@pytest.mark.fact("PMD-HOST-15")
def test_an_operation_that_does_not_look_at_hostrdy_is_ignored(desk):
    host = desk.host
    host.send(MOVE.removesuffix("UPDATE"))
    desk.bench.run_until_idle()
    host.write_command(0x31)
    took = desk.took(host.write_command, 0x1A, ready=False)
    assert took == STROBE + 80 * NS  # at once
    assert host.read_word() == 0x0300 and host.read_word() == 0x0331
    desk.bench.run(3 * CYCLE)
    assert desk.x.idle and desk.x.position == 0  # UPDATE was not taken
    assert [found.code for found in desk.x.findings] == ["no-update", "busy-access"]


def test_strobes_have_the_requested_length():
    desk = Desk(record=True)
    since = desk.bench.now_ps
    desk.host.write_command(0x11, low="55 ns")
    desk.host.write_word(0x1234, low="60 ns", gap="70 ns")
    falls, rises = strobes(desk, "hostwrite", since)
    assert [rise - fall for fall, rise in zip(falls, rises, strict=True)] == [55 * NS, 60 * NS, 60 * NS]
    assert falls[2] - rises[1] == 70 * NS


@pytest.mark.fact("PMD-HOST-11")
@pytest.mark.parametrize(
    ("how", "code"),
    [({"low": "45 ns"}, "short-strobe"), ({"gap": "59 ns"}, "short-recovery"), ({"low": "50 ns"}, None)],
)
def test_strobes_that_are_too_short_are_found(desk, how, code):
    desk.host.write_command(0x11)
    desk.host.write_word(0x0002, **how)
    desk.host.write_word(0xC000)
    assert desk.host.read_word() == 0xC013
    assert {found.code for found in desk.x.findings} == {code} - {None}


# ------------------------------------------------------------------------------------------------------------ waiting
def test_wait_polls_the_status_word_until_the_bit_is_set(desk):
    desk.host.send(MOVE)
    word = desk.host.wait("motion_complete")
    assert word == 0x0301 and desk.x.position == 50
    asked = len(desk.host.received)
    assert desk.host.wait("!in_motion", every="5 ms") == 0x0301  # at once
    assert len(desk.host.received) - asked == 2


@rows("update", ["UPDATE", "MULTI_UPDATE 1"])
@rows("phase", range(0, 328, 41))
def test_after_an_update_not_in_motion_waits_for_the_cycle_that_processes_it(update, phase):
    desk = Desk()
    desk.bench.run(f"{phase} us")
    desk.host.send(MOVE.replace("UPDATE", update))
    assert desk.host.wait("!in_motion", every=0) == 0x0301 and desk.x.position == 50


def test_a_rate_may_be_text_and_goes_by_the_crystal_of_the_board(desk):
    desk.host.command("SET_VEL", "12345 steps/s")
    assert desk.host.query("GET_VEL") == 265107
    bench = slewline.Bench()
    host = bench.host(bench.add("mc1151a", crystal="12.5 MHz"))
    host.axis(1).command("SET_VEL", "12345 steps/s")
    host.send("SET_START_VEL 12345 steps/s")
    assert host.query("GET_VEL") == host.query("GET_START_VEL") == 530214


@pytest.mark.parametrize("every", [3 * MS, "250 us", 0])
def test_wait_pauses_between_two_questions(desk, every):
    desk.host.send(MOVE)
    times = []
    desk.bench.run_until(lambda: desk.host.idle)
    desk.x.pin("hostcmd").net.watch(lambda net: times.append(desk.bench.now_ps) if net.level else None)
    desk.host.wait("motion_complete", every=every)
    question = 3 * BUSY + STROBE + 2 * (STROBE + SECOND)
    assert {then - now for now, then in pairwise(times)} == {question + {"250 us": 250 * US}.get(every, every)}


def test_wait_gives_up_and_the_host_continues(desk):
    with pytest.raises(slewline.Timeout, match="waited 20 ms for host: motion_complete of x"):
        desk.host.wait("motion_complete", timeout="20 ms")
    assert desk.host.query("GET_STATUS") == 0x0300


def test_a_chipset_that_is_never_ready_is_a_timeout_and_later_the_host_continues(desk):
    reset = desk.x.pin("reset")
    reset.drive(0)
    with pytest.raises(slewline.Timeout) as raised:
        desk.host.command("SET_POS", 5, timeout="20 ms")
    assert "host: sending SET_POS (10 0000 0005) to x since" in str(raised.value)
    reset.drive(1)
    desk.host.command("SET_POS", 6)
    assert desk.x.registers["pos"] == 6


def test_a_call_that_gives_up_in_a_strobe_lets_go_of_the_lines(desk):
    with pytest.raises(slewline.Timeout):
        desk.host.write_word(0, low="20 us", timeout="10 us")
    desk.bench.run(0)
    lines = ("hostslct", "hostwrite", "hostdata0")
    assert [desk.x.pin(line).level for line in lines] == [1, 1, None]


def test_a_call_that_gives_up_leaves_what_was_queued_before_it(desk):
    reset = desk.x.pin("reset")
    reset.drive(0)
    desk.host.send("SET_POS 5")
    with pytest.raises(slewline.Timeout):
        desk.host.command("SET_VEL", 7, timeout="20 ms")
    reset.drive(1)
    desk.bench.run_until_idle()
    assert (desk.x.registers["pos"], desk.x.registers["vel"]) == (5, 0)


# ---------------------------------------------------------------------------------------------------- several, mistakes
def test_two_chipsets_share_a_data_bus():
    bench = slewline.Bench()
    x, y = bench.add("mc1451a", name="x"), bench.add("mc1151a", name="y")
    host = bench.host(x, y)
    assert host.query("GET_VRSN") == 0x5C11
    assert host.to("y").query("GET_VRSN") == 0x4411
    host.command("SET_POS", 7)
    assert (x.registers["pos"], y.registers["pos"]) == (0, 7)
    host.to(x).axis(2).command("SET_POS", 9)
    host.to(y).command("SET_VEL", 3)
    assert (x.axis(2).registers["pos"], y.registers["vel"]) == (9, 3)
    assert bench.findings == []


@rows(
    ("call", "kind", "text"),
    [
        (lambda host: host.command("SET_PO", 1), UnknownName, "SET_PO is not a command of the MC1451A; write SET_POS"),
        (lambda host: host.command("SET_POS"), slewline.UsageError, "SET_POS takes position, not 0 values"),
        (lambda host: host.command("SET_VEL", 1 << 30), slewline.UsageError, "allowed 0..1073741823"),
        (lambda host: host.command("SET_VEL", 1.5), slewline.UsageError, "; 1.5 steps/cycle is 98304"),
        (lambda host: host.command("SET_VEL", "fast"), slewline.UsageError, "a rate in steps/s or steps/cycle"),
        (lambda host: host.command("SET_POS", "5 steps/s"), slewline.UsageError, "SET_POS '5 steps/s': expected a n"),
        (lambda host: host.command("UPDATE", "5 steps/s"), slewline.UsageError, "UPDATE '5 steps/s'"),
        (lambda host: host.query("UPDATE"), slewline.UsageError, "host: UPDATE returns nothing"),
        (lambda host: host.axis(5), slewline.UsageError, "host: axis 5; allowed 1..4 for x (mc1451a)"),
        (lambda host: host.command("SET_POS", 1, axis=7), slewline.UsageError, "host: axis 7"),
        (lambda host: host.wait("moving"), UnknownName, "'moving'"),
        (lambda host: host.packet(0x100), slewline.UsageError, "256; allowed 0..255"),
        (lambda host: host.packet(0x10, 0x10000), slewline.UsageError, "65536; allowed 0..65535"),
        (lambda host: host.write_word(-1), slewline.UsageError, "-1; allowed 0..65535"),
        (lambda host: host.write_byte(0, low=0), slewline.UsageError, "low=0, gap=80000; allowed more than 0"),
        (lambda host: host.to("y"), UnknownName, "host has no chip 'y'; it serves x"),
    ],
)
def test_mistakes_of_the_user_are_reported_and_nothing_is_queued(call, kind, text):
    desk = Desk()
    with pytest.raises(kind) as raised:
        call(desk.host)
    assert text in str(raised.value)
    assert desk.host.idle


def test_a_host_commands_one_kind_of_chips():
    bench = slewline.Bench()
    x, y = bench.add("mc1451a", name="x"), bench.add("cy525", name="y")
    with pytest.raises(slewline.UsageError, match="some of these chips have a bus, some a port for packets"):
        bench.host(x, y)
    with pytest.raises(slewline.UsageError, match="baud 9600; x has no serial line"):
        bench.host(x, baud=9600)


def test_a_packet_for_people():
    sheet = slewline.Bench().add("mc1451a").sheet
    assert Packet(0x10, (0, 5)).spelled(sheet) == "SET_POS (10 0000 0005)"
    assert Packet(0x22).spelled(sheet) == "packet 22"


# ------------------------------------------------------------------------------------------------------------ journal
def dialogue(bench, x, host):
    host.send(MOVE)
    host.wait("motion_complete")
    with pytest.raises(slewline.ChecksumError):
        host.packet(0x80)
    host.axis(2).command("SET_POS", 9)
    host.write_command(0x31)
    host.write_command(0x1A, ready=False)
    host.read_word()
    x.pin("reset").drive(0)
    with pytest.raises(slewline.Timeout):
        host.command("SET_VEL", 7, timeout="5 ms")
    x.pin("reset").drive(1)
    host.send(b"\x11\x00\x02\xc0\x00")
    host.axis(2).wait("motor_on")
    bench.run("1 ms")


@pytest.mark.parametrize("shuffle", [None, 1, 2])
def test_a_journal_plays_the_same_again(tmp_path, shuffle):
    path = tmp_path / "run.jsonl"
    desk = Desk(journal=path)
    dialogue(desk.bench, desk.x, desk.host)
    again = slewline.replay(path, shuffle=shuffle)
    assert again["host"].received == desk.host.received
    assert again.findings == desk.bench.findings and len(again.findings) > 1
    assert again["x"].registers == desk.x.registers
    assert again.now_ps == desk.bench.now_ps
