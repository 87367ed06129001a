"""Hosts of a chip with two sides: FlowHost on its bus, AdaptiveHost on its serial line."""

from __future__ import annotations

import inspect

import pytest

import slewline
from slewline import Timeout, UsageError, WiringError
from slewline.core.time.timebase import Seconds, Time
from slewline.parts.hosts.adaptive_host import AdaptiveHost
from slewline.parts.hosts.flow_host import FlowHost
from slewline.parts.hosts.host import Host
from tests.rows import rows

SIDES = pytest.mark.parametrize("over", ["parallel", "serial"])
FACE = ("send", "ask", "got", "received", "drop", "clear", "idle", "waiting")


class Desk:
    """A CY545B, and a host over one of its sides, to which answers come."""

    def __init__(self, over: str, journal: object = None, part: str = "cy545b") -> None:
        self.bench = slewline.Bench(journal=journal)
        self.x = self.bench.add(part, name="x")
        self.ram = self.bench.part("ram", name="ram", to=self.x)
        self.host = self.bench.host(self.x, name="host", over=over)
        if over == "parallel":
            self.host.send("O 81H\r")
        self.bench.run_until_idle()

    @property
    def codes(self) -> list[str]:
        return [found.code for found in self.bench.findings]


# ------------------------------------------------------------------------------------------------ the face
@pytest.mark.parametrize("cls", [FlowHost, AdaptiveHost])
def test_both_have_the_face_of_every_host(cls):
    assert issubclass(cls, Host)
    assert [name for name in FACE if name != "received" and not hasattr(cls, name)] == []
    assert [name for name in ("send", "ask", "got") if getattr(cls, name) is getattr(Host, name)] == []
    calls = [call for _, call in inspect.getmembers(cls, inspect.isfunction)]
    told = [inspect.signature(call).parameters.get("timeout") for call in calls]
    assert {each.annotation for each in told if each is not None} == {"Time"} and Time == str | int | Seconds


@SIDES
@pytest.mark.parametrize(
    ("query", "answer"), [("? P", "P=00000000"), ("? R", "R=00100"), ("? N", "N=00000200"), ("?F", "F=00014")]
)
def test_a_query_is_answered(over, query, answer):
    desk = Desk(over)
    assert desk.host.ask(query) == answer
    assert desk.codes == ([] if " " in query else ["spacing"])


@SIDES
def test_memory_is_listed_line_by_line(over):
    desk = Desk(over)
    desk.host.send("Y 10\rE\rN 1\r+\rG\rQY 10\r")
    desk.bench.run_until_idle()
    assert desk.host.ask("? M,2") == "Y=00010\rN 1\r+"
    assert desk.host.ask("? M 1") == "Y=00010\rN 1"


@SIDES
def test_in_binary_an_answer_is_bytes(over):
    desk = Desk(over)
    desk.host.send("O 1\r" if over == "parallel" else "O 0\r")
    assert desk.host.ask("? R") == b"R=\x00\x64"
    assert desk.host.ask("? P") == b"P=\0\0\0"
    desk.host.send(b"O\x01\x81" if over == "parallel" else b"O\x01\x80")
    assert desk.host.ask("? R") == "R=00100"
    assert desk.codes == []


@SIDES
@pytest.mark.parametrize("command", ["R 5", "G", "? Z", "", "? PP", "? M", 5])
def test_commands_without_answer_are_refused_before_they_are_sent(over, command):
    desk = Desk(over)
    with pytest.raises(UsageError, match=r"has no answer; ask\(\) is for \? P"):
        desk.host.ask(command)
    assert desk.host.idle and desk.host.ask("? R") == "R=00100"


@SIDES
def test_a_missing_answer_is_a_timeout_and_the_host_continues(over):
    desk = Desk(over)
    desk.host.send("O 80H\r" if over == "parallel" else "O 81H\r")
    desk.bench.run_until_idle()
    with pytest.raises(Timeout, match="elsewhere" if over == "parallel" else "an answer to"):
        desk.host.ask("? R", "50 ms")
    if over == "parallel":
        desk.host.send("O 81H\r")
        assert desk.host.ask("? R") == "R=00100"


@SIDES
def test_an_invalid_text_is_refused(over):
    desk = Desk(over)
    for wrong in (7, None, "R \u0661\r"):
        with pytest.raises(UsageError, match="host"):
            desk.host.send(wrong)
    assert desk.host.ask("? R") == "R=00100"


@SIDES
@pytest.mark.parametrize("wrong", [1, 0, "on"])
def test_cts_can_be_followed_ignored_or_automatic(over, wrong):
    with pytest.raises(UsageError, match="allowed True, False, None"):
        Desk(over).host.heed(wrong)


def test_prefix_takes_true_and_false():
    with pytest.raises(UsageError, match="allowed True, False"):
        Desk("parallel").host.prefix(None)


# --------------------------------------------------------------------------------------- clear, drop, messages
def test_clear_drops_the_queue_and_the_host_still_receives():
    desk = Desk("parallel")
    desk.host.send("D 500\rR 1\rR 2\r")
    desk.bench.run("20 ms")
    desk.host.clear()
    desk.bench.run_until_idle()
    assert desk.host.idle and desk.x.registers["rate"] == 100
    desk.host.send('"news"\r')
    desk.bench.run_until(desk.host.got("news"), "1 s")
    assert desk.host.ask("? R") == "R=00100" and desk.codes == []


def test_clear_in_the_middle_of_a_message_gives_the_lines_back():
    desk = Desk("parallel")
    desk.host.send('"a long message"\r')
    desk.bench.run_until(desk.host.got("a lo"), "1 s")
    assert not desk.host.idle
    desk.host.clear()
    desk.bench.run_until(desk.host.got("message"), "1 s")
    desk.bench.run_until_idle()
    assert desk.host.ask("? R") == "R=00100"


def test_drop_leaves_what_has_begun():
    desk = Desk("parallel")
    desk.host.send("R 55\r")
    desk.host.send("R 66\r")
    before = desk.host.sent
    desk.bench.run_until(lambda: desk.host.sent == before + 2, "1 s")
    desk.host.drop()
    desk.bench.run_until_idle()
    assert desk.x.registers["rate"] == 55


def test_an_unsolicited_message_is_read_while_the_host_does_nothing():
    desk = Desk("parallel")
    desk.host.send('Y 0\rE\r"tick"\rD 20\rJ 0\rQY 0\rX\r')
    desk.bench.run("210 ms")
    assert 9 <= desk.host.received.count(b"tick") <= 11
    desk.host.send("0\r")
    desk.bench.run_until_idle("10 s")
    assert desk.codes == []


def test_while_fpl_is_not_in_use_a_low_user_bit_6_is_not_a_message():
    desk = Desk("parallel")
    desk.host.send("O 80H\rB 22\rR 7\r")
    desk.bench.run_until_idle()
    assert desk.x.pin("usrb6").level == 0 and desk.x.registers["rate"] == 7 and desk.host.received == b""


def test_following_cts_reports_the_settings_of_another_host():
    desk = Desk("parallel")
    desk.host.send("O 80H\r")
    desk.bench.run_until_idle()
    other = desk.bench.host(desk.x, over="serial")
    other.send('O 81H\r"hello"\r')
    desk.bench.run("50 ms")
    assert desk.host.received == b"" and desk.x.pin("usrb6").level == 0
    desk.host.heed(True)
    desk.bench.run_until_idle()
    assert desk.host.received == b"hello"


def test_a_host_that_takes_cts_for_fpl_is_notified_and_ignores_it_from_then_on():
    desk = Desk("parallel")
    other = desk.bench.host(desk.x, over="serial")
    other.send("O 0A0H\rR 5\r")
    desk.bench.run("100 ms")
    assert desk.codes == ["no-message"] and desk.host.received == b""
    assert desk.x.registers["rate"] == 5  # to the chip it was an empty handshake, and it goes on
    desk.host.send("R 6\rO 81H\r")
    desk.bench.run_until_idle()
    desk.host.heed(None)
    assert desk.host.ask("? R") == "R=00006"


def test_the_empty_handshake_goes_before_every_command_but_not_into_a_program():
    desk = Desk("parallel")
    desk.bench.record("x.busy")
    desk.host.send("R 7\r+\r")
    desk.bench.run_until_idle()
    assert len(desk.bench.edges("x.busy")[0]) == 2 * (1 + 4 + 1 + 2)
    desk.host.send("Y 0\rE\rR 7\r+\rQ")
    desk.bench.run_until_idle()
    assert desk.ram.content[:6] == b"R 7\r+\r"
    desk.host.prefix(False)
    before = len(desk.bench.edges("x.busy")[0])
    desk.host.send("R 9\r")
    desk.bench.run_until_idle()
    assert len(desk.bench.edges("x.busy")[0]) == before + 2 * 4
    assert desk.codes == []


def test_a_host_without_the_prefix_is_notified_while_a_program_runs():
    desk = Desk("parallel")
    desk.host.send("Y 0\rE\rD 50\rJ 0\rQY 0\rX\r")
    desk.bench.run("100 ms")
    desk.host.prefix(False)
    desk.host.send("R 9\r")
    desk.bench.run("100 ms")
    assert "missing-ff" in desk.codes and desk.x.registers["rate"] == 9


# ----------------------------------------------------------------------------------------------------- the serial host
def test_the_first_command_begins_with_two_returns_and_the_next_ones_do_not():
    desk = Desk("serial")
    heard = []
    desk.x.pin("rxd").net.watch(lambda net: heard.append(net.level))
    desk.host.send("R 7\r")
    desk.bench.run_until_idle()
    first = len(heard)
    desk.host.send("R 7\r")
    desk.bench.run_until_idle()
    assert len(heard) - first == first - 2 * 6  # a return has six edges
    assert desk.codes == []


@pytest.mark.parametrize("baud", [300, 19200])
def test_a_host_sends_at_the_fixed_rate(baud):
    bench = slewline.Bench()
    host = bench.host(bench.add("cy545b", fixed_baud=baud), over="serial")
    assert host.baud == baud and host.ask("? R") == "R=00100"
    assert bench.findings == []


def test_after_i_the_host_waits_and_repeats_its_greeting():
    desk = Desk("serial")
    assert desk.host.ask("? R") == "R=00100"
    desk.host.send("R 7\rI\r")
    assert desk.host.ask("? R") == "R=00100" and desk.codes == []


def test_after_the_supply_was_off_both_hosts_start_again():
    desk = Desk("parallel")
    other = desk.bench.host(desk.x, over="serial")
    assert desk.host.ask("? R") == "R=00100"
    desk.host.send("O 80H\r")
    assert other.ask("? R") == "R=00100"
    desk.x.power(False)
    desk.bench.run("10 ms")
    desk.x.power(True)
    desk.bench.run("20 ms")
    assert other.ask("? R") == "R=00100"
    desk.host.send("O 81H\r")
    assert desk.host.ask("? R") == "R=00100" and desk.codes == []


def test_a_host_that_waits_for_cts_can_be_released():
    desk = Desk("serial")
    desk.host.heed(True)
    desk.host.send("R 9\r")  # user bit 6 is high, and no CTS
    desk.bench.run("100 ms")
    assert desk.x.registers["rate"] == 100 and not desk.host.idle
    desk.host.heed(None)
    desk.bench.run_until_idle()
    assert desk.x.registers["rate"] == 9


def test_characters_that_wait_for_cts_can_be_dropped():
    desk = Desk("serial")
    desk.host.send("O 0A0H\rD 500\rR 1\rR 2\r")
    desk.bench.run("100 ms")
    desk.host.drop()
    desk.bench.run_until_idle()
    assert desk.x.registers["rate"] == 100
    desk.host.clear()
    desk.host.send("\rR 3\r")
    desk.bench.run_until_idle()
    assert desk.x.registers["rate"] == 3


# ------------------------------------------------------------------------------------------------ furnishing
def test_one_host_a_side_and_one_side_a_host():
    bench = slewline.Bench()
    x, y = bench.add("cy545b"), bench.add("cy545")
    assert type(bench.host(x)) is FlowHost and type(bench.host(x, over="serial")) is AdaptiveHost
    for over in ("parallel", "serial"):
        with pytest.raises(WiringError, match="cy545b has a host on this channel already"):
            bench.host(x, over=over)
        with pytest.raises(UsageError, match="give each chip a host of its own"):
            bench.host(x, y, over=over)


@rows(
    ("how", "text"),
    [
        ({"baud": 9600}, "has no serial line here; over='serial' selects one"),
        ({"over": "bus"}, "these channels: parallel, serial"),
        ({"over": "serial", "delay": "1 us"}, "let the host's program pause"),
        ({"over": "serial", "baud": 0}, "baud"),
    ],
)
def test_unsuitable_commands_for_a_side_are_refused(how, text):
    bench = slewline.Bench()
    with pytest.raises(UsageError, match=text):
        bench.host(bench.add("cy545b"), **how)


def test_a_line_of_rs232_does_not_fit_ttl_levels():
    bench = slewline.Bench()
    with pytest.raises(UsageError, match="TTL levels"):
        bench.host(bench.add("cy545b"), over="serial", line=bench.part("rs232_line"))


# ------------------------------------------------------------------------------------------------ journal
def test_a_journal_plays_both_hosts_again(tmp_path):
    path = tmp_path / "run.jsonl"
    desk = Desk("parallel", journal=path)
    other = desk.bench.host(desk.x, name="other", over="serial", baud=4800)
    other.heed(False)
    desk.host.prefix(False)
    desk.host.prefix(True)
    other.send("R 9\r")
    desk.bench.run("50 ms")
    assert desk.host.ask("? R") == "R=00009"
    desk.host.heed(True)
    desk.host.send("D 100\r")
    desk.host.send("S 1\r")
    desk.bench.run("20 ms")
    desk.host.drop()
    other.send("? P\r")
    desk.bench.run("500 ms")
    again = slewline.replay(path)
    assert again.now_ps == desk.bench.now_ps
    assert again.parts["host"].received == desk.host.received
    assert again.parts["other"].received == other.received
    assert again.chips["x"].registers == desk.x.registers
