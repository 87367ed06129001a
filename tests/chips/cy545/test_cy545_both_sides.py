"""Both sides of the CY545 at once: who has the chip, and nothing is lost in between."""

from __future__ import annotations

import random
import re

import pytest
from cy545 import MS, US, Rig545
from cy545_hand import Hand

import slewline
from slewline.core.time.kernel import Kernel
from tests.ensembles import few

BOTH = pytest.mark.parametrize("part", ["cy545", "cy545b"])
CTS = 0x20
COMMANDS = ("B 16", "B 0", "N 77", "R 9", "D 1", "A 5", "B 42H", "? P", "? R", "? N", '"ab"', "+", "-", "Y 9", "S 200")


@pytest.mark.fact("CY545-UND-BUSY-SERIAL")
@BOTH
def test_busy_does_not_move_for_a_command_of_the_serial_side(part):
    rig = Rig545("busy", part=part, serial=True, replies=False)
    rig.serial.send("D 100\rR 5\r"[:6])
    rig.bench.run("80 ms")
    rig.host.send("B 16\r")  # asks while the chip is at work
    rig.bench.run("20 ms")
    assert rig.level("busy") == 1 and rig.edges("busy") == []
    rig.bench.run_until_idle()
    assert rig.level("usrb0") == 0 and rig.codes == []


@pytest.mark.fact("CY545-UND-TWO-SIDES")
@pytest.mark.parametrize("first", ["serial", "parallel"])
@BOTH
def test_the_side_that_begins_a_command_has_the_chip_until_its_end(part, first):
    rig = Rig545(part=part, serial=True, replies=False)
    rig.serial.send("")
    rig.bench.run_until_idle()
    one, other = (rig.serial, rig.host) if first == "serial" else (rig.host, rig.serial)
    one.send("R 1")
    rig.bench.run("20 ms")
    other.send("R 7\r"[:3] if first == "parallel" else "R 7\r")
    rig.bench.run("1 s")
    assert rig.x.registers["rate"] == 100 and rig.x.unfinished == "R 1"
    one.send("3\r")
    rig.bench.run("10 ms")
    if first == "parallel":
        assert rig.x.registers["rate"] == 13
        other.send("\r")
    rig.bench.run("20 ms")
    assert rig.x.registers["rate"] == 7 and rig.codes == []


@pytest.mark.fact("CY545-IMM-12", "CY545-UND-TWO-SIDES")
@pytest.mark.parametrize("side", ["serial", "parallel"])
@BOTH
def test_an_ff_to_an_idle_chip_is_ignored_and_keeps_neither_the_other_side_nor_jog(part, side):
    rig = Rig545("pulse", part=part, serial=True, replies=False)
    rig.serial.send("F 255\rO 0A0H\r")
    rig.bench.run_until_idle()
    for jogs in (False, True):  # at rest, and between two steps of jog
        if jogs:
            rig.drive("jog", 0)
        (rig.serial if side == "serial" else rig.host).send(b"\xff")
        rig.bench.run("3 ms")
        assert rig.level("usrb6") == 0 and rig.level("busy") == 1  # CTS and BUSY: either side may begin
        before = len(rig.falls("pulse"))
        rig.bench.run("10 ms")
        assert len(rig.falls("pulse")) - before >= 9 * jogs
        assert rig.serial.ask("? R") == "R=00100"
    rig.host.prefix(False)
    rig.host.send("R 9\r")
    rig.bench.run("5 ms")
    assert rig.x.registers["rate"] == 9 and rig.codes == []


def test_a_request_that_is_withdrawn_does_not_keep_jog_from_the_next_step():
    h = Hand(record=("pulse",))
    h.say("F 255")
    h.say("\r")
    h.x.pin("jog").drive(0)
    h.run(3000)
    h.bench.run_to(h.falls("pulse")[-1] + 900 * US)
    h.request(0)  # JOG is looked at 20 us before the next step, and BUSY would fall 25 us behind that
    h.run(90)
    h.request(1)
    h.run(20_000)
    assert len(h.falls("pulse")) >= 20 and h.codes == ["short-request"]


@pytest.mark.fact("CY545-IMM-2", "CY545-IMM-14", "CY545-UND-TWO-SIDES")
def test_after_the_empty_handshake_in_a_program_the_bus_has_the_chip():
    rig = Rig545("pulse", serial=True, replies=False)
    rig.serial.send("")
    rig.enter("N 1", "+", "G", "J 0")
    rig.host.send("Y 0\rX\r")
    rig.bench.run("100 ms")
    rig.host.prefix(False)
    rig.host.send(b"\xff\xff")  # one or several: the letter is still to come
    rig.bench.run("100 ms")
    before = len(rig.falls("pulse"))
    rig.serial.send("R 7")
    rig.bench.run("1 s")
    assert rig.x.unfinished == "" and len(rig.falls("pulse")) == before
    rig.host.send("R 9\r")
    rig.bench.run("100 ms")
    assert rig.x.registers["rate"] == 9 and rig.x.unfinished == "R 7" and rig.codes == []


@pytest.mark.fact("CY545-FPL-5", "CY545-UND-TWO-SIDES")
@pytest.mark.parametrize(("prefix", "delay_ms"), [(False, 0), (False, 4), (False, 9), (True, 4), (True, 9)])
@BOTH
def test_a_letter_lets_go_of_the_bus_when_the_answer_to_the_serial_side_comes_over_it(part, prefix, delay_ms):
    rig = Rig545(part=part, serial=True)
    rig.host.prefix(prefix)
    rig.host.delay_ps = delay_ms * MS  # behind an empty handshake that the idle chip ignores, too
    rig.serial.send("")
    rig.bench.run_until_idle()
    rig.serial.send('"ab"\r')
    rig.bench.run(0 if prefix else "2 ms")
    rig.host.send("R 7\r")
    rig.bench.run_until_idle()
    assert rig.answer == "ab" and rig.x.registers["rate"] == 7 and rig.codes == []


@pytest.mark.fact("CY545-CON-CTS-IDLE", "CY545-UND-TWO-SIDES")
def test_cts_is_high_while_the_bus_has_the_chip():
    rig = Rig545(serial=True, replies=False)
    rig.host.send("O 0A0H\rR 1")
    rig.bench.run("5 ms")
    assert rig.level("usrb6") == 1
    rig.host.send("\r")
    rig.bench.run_until_idle()
    assert rig.level("usrb6") == 0


# -------------------------------------------------------------------------------------------------- one of many at once
class Both:
    """A chip with a host on each side, what each of them has sent, and what the chip has carried out."""

    def __init__(self, seed: int, part: str, mode: int, baud: int, shuffle: bool) -> None:
        self.chance, self.on_the_bus = random.Random(seed), bool(mode & 0x01)
        self.bench = slewline.Bench(shuffle=seed if shuffle else None)
        self.x = self.bench.add(part, name="x", crystal="11 MHz")
        self.hosts = [self.bench.host(self.x), self.bench.host(self.x, over="serial", baud=baud)]
        self.hosts[0].send(f"O {0x80 | mode}\r")
        self.bench.run_until_idle()
        for host in self.hosts:
            host.heed(None if host is self.hosts[0] else bool(mode & CTS))
        self.hosts[1].send("")
        self.bench.run_until_idle()
        self.sent: list[list[str]] = [[], []]
        self.done: list[str] = []
        self.x.on_command.add(self._begun)

    def _begun(self, text: str) -> None:
        if text:
            self.done.append(text)

    def play(self, number: int, burst: int) -> None:
        """Let both hosts send, one or the other by chance, and time pass by chance; all is idle behind each burst.

        The bus goes first, so without CTS it must leave the serial side some time: three characters long.
        """
        for turn in range(number):
            side = self.chance.randrange(2)
            command = f"{self.chance.choice(COMMANDS)}"
            command = f"A {turn * 2 + side}" if command == "A 5" else command
            self.sent[side].append(command)
            self.hosts[side].send(f"{command}\r")
            if self.chance.random() < 0.2:
                self.bench.run(self.chance.randrange(10 * MS))
            if turn % burst == burst - 1:
                self.bench.run_until_idle("10000 s")
        self.bench.run_until_idle("10000 s")

    def check(self) -> None:
        """Every command of both has been carried out once, in the order of its host, and every answer has come."""
        merged = [*self.done]
        assert sorted(merged) == sorted(self.sent[0] + self.sent[1])
        assert in_order(merged, *self.sent)
        said = b"".join(bytes(host.received) for host in self.hosts)
        wanted = {"ab": '"ab"', "P=": "? P", "R=": "? R", "N=": "? N"}
        for text, command in wanted.items():
            assert said.count(text.encode()) == merged.count(command)
        assert re.fullmatch(rb"(ab|P=[0-9]{8}\r|[RN]=[0-9]{5,8}\r)*", said)
        elsewhere = ["answer-elsewhere"] if self.on_the_bus else []  # told once: the serial host asks, too
        assert [found.code for found in self.x.findings] == elsewhere
        assert self.x.idle


def in_order(merged: list[str], one: list[str], other: list[str]) -> bool:
    """Is a list made of two others, each in its own order?  All ways to split it are followed at once."""
    at = {0}
    for count, each in enumerate(merged):
        following = set()
        for taken in at:
            if taken < len(one) and one[taken] == each:
                following.add(taken + 1)
            if count - taken < len(other) and other[count - taken] == each:
                following.add(taken)
        at = following
    return len(one) in at


def test_a_valid_interleaving_is_distinguished_from_a_disorder():
    assert in_order(list("abxcyd"), list("abcd"), list("xy")) and not in_order(list("bax"), list("ab"), list("x"))


@pytest.mark.fact("CY545-CTS-6", "CY545-UND-TWO-SIDES")
@pytest.mark.parametrize("shuffle", [False, True])
@pytest.mark.parametrize("number", few([300, 600], 1))
@BOTH
def test_both_hosts_together_with_cts_lose_nothing_and_never_deadlock(part, number, shuffle):
    both = Both(1 + shuffle, part, CTS, 19200, shuffle)
    both.play(number, 200)
    both.check()


@pytest.mark.fact("CY545-IMM-12", "CY545-UND-TWO-SIDES")
@pytest.mark.parametrize("number", few([150, 300], 1))
@BOTH
def test_both_hosts_together_with_answers_on_the_bus_lose_nothing(part, number):
    both = Both(3, part, 0x01, 1200, False)  # FPL has the pin of CTS: the serial host goes slowly, by the clock
    both.play(number, 8)
    both.check()


@pytest.mark.long
@pytest.mark.parametrize(("part", "mode", "baud", "burst"), [("cy545b", CTS, 19200, 200), ("cy545b", 0x01, 1200, 8)])
def test_a_hundred_thousand_commands_of_both_hosts(part, mode, baud, burst):
    both = Both(545, part, mode, baud, True)
    for _ in range(100):
        both.play(1000, burst)
        both.check()
        both.sent, both.done = [[], []], []
        for host in both.hosts:
            host.received.clear()


def test_the_same_seed_gives_the_same_run():
    found = []
    for _ in range(2):
        both = Both(7, "cy545b", CTS, 9600, False)
        both.play(100, 50)
        found.append((both.bench.now_ps, both.done, bytes(both.hosts[1].received)))
    assert found[0] == found[1] and isinstance(both.bench.kernel, Kernel)
