"""An RS-232 line between host and module: edges pass as they are, faults hit the character they are planned for."""

from __future__ import annotations

import pytest
from modules import C200, C200S, MS, STRAPS, Modules, both

import slewline
from slewline.chips import sheet_of
from slewline.parts.lines.noise import KINDS, RandomSequence
from tests.rows import rows

BIT = 10**12 / 9600


class Lined(Modules):
    """A module behind a line."""

    def __init__(self, part: str = C200S, shuffle: int | None = None, checked: bool = False) -> None:
        super().__init__(part, shuffle=shuffle, chs=int(checked))
        self.line = self.bench.part("rs232_line", name="line")
        self.host = self.bench.host(self.x, line=self.line)
        self.hosts = {"x": self.host}
        self.bench.record("host.txd", "x.rxd", "x.txd", "host.rxd")

    def plan(self, kind: str, way: str = "to_module", **how: object) -> None:
        self.line.plan(way, kind, **how)


def differs(m: Lined, start: int, stop: int) -> set[int]:
    """Bit times, counted from the start bit, in which the two sides of the line to the module differ."""
    begin = min(time for time, _ in m.edges("host.txd", start))
    found = set()
    for n in range(int((stop - begin) / BIT)):
        middle = int(begin + (n + 0.5) * BIT)
        levels = [[level for time, level in m.edges(pin) if time <= middle] for pin in ("host.txd", "x.rxd")]
        if levels[0][-1] != levels[1][-1]:
            found.add(n)
    return found


# ------------------------------------------------------------------------------------------------------------- edges
@both
@pytest.mark.fact("GSC-SYS-ISO-1")
def test_a_faultless_line_changes_nothing(part):
    m = Lined(part)
    m.run("S10", "T100", "R10", "+30")
    assert m.edges("host.txd", 1) == m.edges("x.rxd", 1)
    assert m.edges("x.txd", 1)[-20:] == m.edges("host.rxd", 1)[-20:]
    plain = Modules(part)
    plain.connect()
    plain.run("S10", "T100", "R10", "+30")
    assert plain.pulses() == m.pulses()
    assert m.line.way("to_module").characters == len("P\rS10\rT100\rR10\r+30\rE\r") + (part == C200S)
    assert m.line.way("to_host").characters == 2 * 6


@both
@pytest.mark.fact("GSC-SYS-ISO-1")
def test_three_wires_are_enough(part):
    bench = slewline.Bench()
    bench.add(part, name="x", straps=STRAPS)
    port = bench.part("serial_port", name="port")
    assert set(port.pins) == {"txd", "rxd"}  # and ground
    bench.wire("port.txd", "x.rxd")
    bench.wire("port.rxd", "x.txd")
    bench.run("1 ms")
    port.write("V1\r")
    bench.run("100 ms")
    assert bytes(port.received) == (b"V0\r" if part == C200 else b"V+0\r")
    assert "R2 above 1000 ohm, from a source of 220 to 600 ohm" in sheet_of(part).notes["isolation"]


@pytest.mark.parametrize("shuffle", [1, 2])
def test_the_order_of_tasks_in_an_instant_does_not_matter(shuffle):
    runs = []
    for seed in (None, shuffle):
        m = Lined(shuffle=seed)
        m.plan("garbled", count=1000, chance=0.1, seed=4)
        m.bench.run("1 ms")
        for _ in range(10):
            m.host.send("V1\rF\r")
            m.bench.run("60 ms")
        runs.append((m.edges("x.rxd"), bytes(m.host.received)))
    assert runs[0] == runs[1]


# ------------------------------------------------------------------------------------------------------------ faults
@pytest.mark.parametrize(("kind", "bits"), [("parity", {19}), ("framing", {20}), ("lost", {11, 13, 14, 15, 18, 19})])
def test_a_fault_hits_one_character_where_it_should(kind, bits):
    m = Lined()
    m.bench.run("1 ms")
    m.plan(kind, after=1)
    start, changes = m.bench.now_ps, []
    m.x.pin("rxd").net.watch(lambda net: changes.append(net.level))
    m.host.send("V1F")  # the second character is 0 1000110 0 11
    m.bench.run("50 ms")
    found = differs(m, start, start + int(33 * BIT))
    assert found == bits
    assert m.line.way("to_module").noise.done == {**dict.fromkeys(KINDS, 0), kind: 1}
    assert m.line.way("to_module").characters == 3
    assert changes == [level for _, level in m.edges("x.rxd", start)]  # no spike that lasts no time


def test_a_garbled_character_has_one_wrong_bit_somewhere():
    hit = set()
    for seed in range(30):
        m = Lined()
        m.bench.run("1 ms")
        m.plan("garbled", after=2, seed=seed)
        start = m.bench.now_ps
        m.host.send("V1F")
        m.bench.run("50 ms")
        (bit,) = differs(m, start, start + int(33 * BIT))
        hit.add(bit)
    assert hit == {23, 24, 25, 26, 27, 28, 29}  # the data bits of the third


@both
@pytest.mark.parametrize("kind", ["parity", "framing", "garbled"])
def test_a_faulty_character_costs_the_line_and_no_more(part, kind):
    m = Lined(part)
    for after in (0, 1):  # each of its characters, the carriage return excepted
        m.plan(kind, after=after)
        assert m.ask("V1") == "E1"
        assert m.ask("F") == "R"


def test_a_lost_character_is_not_there_at_all():
    m = Lined()
    m.plan("lost")
    assert m.ask("FF") == "R"
    m.plan("lost", after=1)
    assert m.ask("V1") == "E2"
    assert m.codes("x") == ["E2"]


def test_two_wrong_bits_pass_the_parity_and_are_caught_by_the_checksum():
    for checked, answer in ((False, "Y"), (True, "E1")):
        m = Lined(checked=checked)
        assert m.ask("Po") == "Y"
        way = m.line.way("to_module")
        start = m.bench.now_ps
        clock = way.clock
        begin = start + clock.ps(16 * 11)  # the second character, bits 0 and 1: 1 becomes 2
        way.bend(begin + clock.ps(16 * 1), begin + clock.ps(16 * 3), 2)
        assert m.ask("A1") == answer
        assert m.ask("Q") == ("END" if checked else "A2\rEND")


@both
def test_a_fault_on_the_return_path_is_seen_by_the_host(part):
    m = Lined(part)
    m.plan("parity", "to_host")
    with pytest.raises(slewline.ChecksumError, match="parity or framing error in the answer to 'F'"):
        m.ask("F")
    assert m.ask("F") == "R"
    m.plan("lost", "to_host", count=2)
    with pytest.raises(slewline.Timeout, match="an answer to 'F'"):
        m.ask("F")
    assert m.ask("F") == "R"
    assert m.codes("x") == []


@both
def test_a_break_spoils_the_line_that_follows(part):
    m = Lined(part)
    m.bench.run("1 ms")
    start = m.bench.now_ps
    m.line.send_break("to_module", "20 ms")
    m.bench.run("30 ms")
    assert m.edges("x.rxd", start - 1) == [(start, 1), (start + 20 * MS, 0)]
    assert m.edges("host.txd", start - 1) == []
    assert m.ask("F") == "E1"
    assert m.ask("F") == "R"


# ------------------------------------------------------------------------------------------------------------ chance
def test_chance_is_seeded_and_as_great_as_requested():
    runs = []
    for seed in (1, 1, 2):
        m = Lined()
        m.plan("garbled", count=1000, chance=0.05, seed=seed)
        m.bench.run("1 ms")
        m.host.send("V1" * 500)
        m.bench.run("1.2 s")
        runs.append((m.line.way("to_module").noise.done["garbled"], m.edges("x.rxd")))
    assert runs[0] == runs[1]
    assert runs[0][1] != runs[2][1]
    assert all(25 <= hits <= 75 for hits, _ in runs)  # 50 in the mean, 7 of standard deviation


def test_chance_is_even():
    source = RandomSequence(1)
    counts = [0] * 7
    for _ in range(70_000):
        counts[source.below(7)] += 1
    assert all(9_600 < count < 10_400 for count in counts)
    assert [RandomSequence(0).below(1 << 64) for _ in range(2)] == [0xE220A8397B1DCDAF] * 2  # the published first value


def test_plans_queue_up_and_can_be_cleared():
    m = Lined()
    m.plan("parity", count=2)
    m.plan("framing", after=2)
    m.plan("lost", count=5)
    m.bench.run("1 ms")
    m.host.send("V1V1")
    m.bench.run("10 ms")
    assert m.line.way("to_module").noise.done["framing"] == 0
    m.host.send("V")
    m.bench.run("10 ms")
    assert m.line.way("to_module").noise.done == {"parity": 2, "framing": 1, "lost": 0, "garbled": 0}
    m.line.clear()
    m.host.send("\r")
    m.bench.run("10 ms")
    assert m.ask("F") == "R"


def test_a_journal_repeats_the_faults(tmp_path):
    path = tmp_path / "run.jsonl"
    bench = slewline.Bench(journal=path)
    x = bench.add(C200S, name="x", straps=STRAPS)
    line = bench.part("rs232_line", name="line")
    host = bench.host(x, line=line)
    line.plan("to_module", "garbled", count=3, chance=0.3, seed=5)
    bench.run("1 ms")
    for _ in range(5):
        host.send("V1\r")
        bench.run("40 ms")
    line.send_break("to_host", "3 ms")
    host.send("V1\r")
    bench.run("40 ms")
    again = slewline.replay(path)
    assert bytes(again["host"].received) == bytes(host.received)
    assert again["line"].way("to_module").noise.done == line.way("to_module").noise.done
    assert [str(found) for found in again.findings] == [str(found) for found in bench.findings] != []


# ----------------------------------------------------------------------------------------------------- user's mistakes
@rows(
    ("arguments", "says"),
    [
        (("to_moon", "lost"), r"line: direction 'to_moon'; allowed to_module, to_host"),
        (("to_host", "late"), r"fault 'late'; allowed lost, garbled, parity, framing"),
        (("to_host", "lost", 0), r"count 0; allowed 1 or more"),
        (("to_host", "lost", 1, 0), r"chance 0; allowed above 0 and up to 1"),
        (("to_host", "lost", 1, 1, 0, -1), r"after -1; allowed 0 or more"),
    ],
)
def test_a_malformed_plan_is_refused(arguments, says):
    line = slewline.Bench().part("rs232_line", "line")
    with pytest.raises(slewline.UsageError, match=says):
        line.plan(*arguments)
    assert line.way("to_host").noise.plans == []


def test_a_format_without_parity_has_no_parity_fault():
    line = slewline.Bench().part("rs232_line", "line", bits=8, parity="none")
    with pytest.raises(slewline.UsageError, match="line: fault 'parity'; 8N2 has no parity bit"):
        line.plan("to_host", "parity")
    line.plan("to_host", "framing")


def test_a_bus_has_no_line():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    with pytest.raises(slewline.UsageError, match="host: line=; x has no serial line"):
        bench.host(x, line=bench.part("rs232_line"))


def test_several_modules_share_a_line_with_faults():
    bench = slewline.Bench()
    chips = [bench.add(C200, name=name, straps=STRAPS, address=n) for n, name in ((1, "x"), (2, "y"))]
    line = bench.part("rs232_line", name="line")
    host = bench.host(*chips, line=line)
    assert [host.to(name).ask("F") for name in ("x", "y")] == ["R", "R"]
    line.plan("to_module", "parity", after=1)
    assert [host.to(name).ask("F") for name in ("x", "y")] == ["E1", "R"]
