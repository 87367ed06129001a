"""A CY525 on a port: through the UART of figure 10.16, and through lines of text."""

from __future__ import annotations

import pytest

import slewline
from slewline.links.lines.framing import BACKLOG, LONGEST
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.server import Server

from .conftest import Threaded


class Stand:
    """A chip that is served, without any port."""

    def __init__(self, framing, journal=None, part="cy525"):
        self.bench = slewline.Bench(journal=journal)
        self.x = self.bench.add(part, name="x")
        self.server = Server(self.bench, Lockstep(self.bench))
        self.line = self.server.line(self.x, framing=framing)
        self.got, self.resumed = bytearray(), 0
        self.line.attach("host", lambda data: self.got.extend(data) or 0, self.resume)
        self.bench.run(0)
        self.server.pace.start()

    def resume(self):
        self.resumed += 1

    def send(self, data):
        self.line.take(data)
        while not self.server.pace.pass_time():
            pass

    def ask(self, data):
        self.got.clear()
        self.send(data)
        return bytes(self.got)


@pytest.fixture
def framed():
    stand = Stand(True)
    yield stand
    stand.server.close()


def test_commands_reach_the_chip_through_the_uart():
    stand = Stand(False)
    stand.send(b"A 0\rN 5\rR 80\r")
    stand.bench.run("2 ms")  # what the last command takes: the line itself is quiet
    assert (stand.x.registers["number"], stand.x.registers["rate"]) == (5, 80)
    assert stand.bench.now_ps >= 10**9 + 11 * 10 * 10**12 // 9600  # 8 bits, no parity, 1 stop bit
    assert not stand.got
    stand.server.close()


def test_the_uart_cannot_hold_a_host_up():
    stand = Stand(False)
    stand.send(b"A 0\rR 1\rF 1\rS 255\rN 50\rG\rA\rA\rA\rA\r")
    assert any(found.code in ("uart-lost", "uart-overrun") for found in stand.bench.findings)
    stand.server.close()


def test_with_framing_nothing_is_lost(framed):
    framed.send(b"A 0\nR 20\nZ 1\nF 9\nS 255\nN 50\nG\nN 7\n?\n")
    assert framed.x.registers["number"] == 7
    assert framed.x.travel == 50
    assert not framed.bench.findings


def test_groups_are_read_back(framed):
    direct = slewline.Bench()
    host = direct.host(direct.add("cy525", name="x"))
    host.send("A 0\rR 80\rF 3\rN 7\r")
    framed.send(b"A 0\rR 80\rF 3\rN 7\r")
    for group in range(4):
        assert framed.ask(b"?%d\n" % group) == f"?{group} {host.verify(group).hex(' ').upper()}\r\n".encode()


def test_groups_are_read_back_from_a_running_program(framed):
    framed.send(b"A 0\nR 20\nF 20\nS 255\nZ 1\nN 50\nE\nG\nD 20\nJ 0\nQX\n")
    for group in (0, 3):
        answer = framed.ask(b"?%d\n" % group)
        expected = b"%05d" % framed.x.position if group == 0 else bytes.fromhex("00 32 FF 14 14 01")
        assert answer == f"?{group} {expected.hex(' ').upper()}\r\n".encode()
    assert framed.x.pin("run").level == 0 and framed.x.position % 50 == 0 and not framed.bench.findings


def test_answers_come_in_the_order_of_the_questions(framed):
    assert framed.ask(b"N 5\n?3\nN 6\n?3\n?0\n").count(b"?3 ") == 2
    lines = framed.got.decode().split("\r\n")
    assert [line[:2] for line in lines] == ["?3", "?3", "?0", ""]
    assert lines[0] != lines[1]


def test_busy_ready_and_forget(framed):
    assert framed.ask(b"?\n") == b"? ready\r\n"
    assert framed.ask(b"R 1\nF 1\nS 255\nN 50\nG\nN 7\n?\n") == b"? busy\r\n"
    assert framed.ask(b"?\n") == b"? ready\r\n"
    framed.line.feed(b"N 9\n!\n")
    framed.send(b"\n")
    assert framed.x.registers["number"] == 7


@pytest.mark.parametrize(
    ("line", "says"),
    [
        (b"\xff", b"! byte 0xff at character 1 is not ASCII; not sent"),
        (b"?7", b"! ?7: allowed ?, ?0, ?1, ?2, ?3\r\n"),
        (b"?x", b"! ?x: allowed"),
        (b"N \xb5", b"! byte 0xb5 at character 3 is not ASCII; not sent"),
        (b"x" * (LONGEST + 1), b"! the line has more than 256"),
    ],
)
def test_messages_that_cannot_be_sent_are_reported(framed, line, says):
    assert framed.ask(line + b"\r\n").startswith(says)
    assert framed.ask(b"?\n") == b"? ready\r\n"


def test_a_host_that_writes_without_end_is_refused(framed):
    framed.line.feed(b"N 5\n" * BACKLOG)
    assert not framed.got
    framed.line.feed(b"N 6\n?3\n")
    refused = f"%s: not sent, because {BACKLOG} lines are waiting; wait until the reply to '?' is 'ready'\r\n"
    assert framed.got.decode() == f"! {refused}! {refused}" % ("N 6", "?3")
    assert len(framed.line.computer.queue) == 2 * BACKLOG
    framed.bench.run("5 ms")
    framed.got.clear()
    framed.line.feed(b"N 7\n")  # there would be room, but what came in front of it was refused
    assert framed.got.startswith(b"! N 7: not sent, because 40")
    framed.line.feed(b"!\nN 8\n")
    framed.bench.run("5 ms")
    assert framed.x.registers["number"] == 8


def test_questions_and_forget_are_received_however_much_is_to_be_sent(client):
    bench = slewline.Bench()
    server = Server(bench, Paced(bench, "0.0001"))
    line = server.line(bench.add("cy525", name="x"), framing=True)
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server) as running:
        host = client(port.where)
        host.send(b"N 2000\nG\n" * 500 + b"?\n")
        assert host.read(b"\n") == b"? busy\r\n"
        assert running.do(lambda: len(line.computer.queue)) == 2000
        host.send(b"!\n")
        assert host.read(b"\n") == b"!\r\n"
        assert running.do(lambda: len(line.computer.queue)) <= 1


@pytest.mark.parametrize("sent", range(1, 6))
def test_a_command_that_has_begun_is_not_cut_in_two(sent, tmp_path):
    stand = Stand(True, tmp_path / "journal")
    stand.line.feed(b"N 400\nN 500\nG\n")
    stand.bench.run_until(lambda: stand.line.computer.sent == sent)
    stand.line.feed(b"!\n")
    assert stand.got == b"!\r\n"
    assert stand.ask(b"?3\n").startswith(b"?3 01 90 ")  # 400: it went out to its end, and nothing behind it
    stand.send(b"N 7\n")
    stand.server.close()
    assert (stand.x.registers["number"], stand.x.travel) == (7, 0)
    assert not stand.bench.findings
    again = slewline.replay(tmp_path / "journal")
    assert (again.now_ps, again["x"].registers) == (stand.bench.now_ps, stand.x.registers)


def test_messages_waiting_for_the_end_of_a_motion_are_forgotten(framed):
    framed.line.feed(b"A 0\nR 80\nF 9\nS 255\nN 50\nG\nN 7\nG\n")
    framed.bench.run("20 ms")
    assert framed.x.moving
    assert framed.ask(b"!\n") == b"!\r\n"
    framed.bench.run("10 s")
    assert (framed.x.registers["number"], framed.x.travel) == (50, 50)


def test_forgetting_twice_lets_go_of_the_bus(framed):
    computer = framed.line.computer
    framed.line.feed(b"N 400\n")
    framed.bench.run_until(lambda: computer.sent == 2)
    framed.x.power(False)  # it takes no more
    framed.line.feed(b"!\n")
    framed.bench.run("1 s")
    assert not computer.idle
    framed.line.feed(b"!\n")
    assert computer.idle
    assert framed.bench.pin("x.io_request").level == 1


def test_a_framed_session_replays(tmp_path):
    stand = Stand(True, tmp_path / "journal")
    stand.send(b"A 0\nR 100\nF 10\nS 250\nN 40\nG\n?0\nN 9\n")
    stand.server.close()
    again = slewline.replay(tmp_path / "journal")
    assert (again.now_ps, again["x"].position, again["x"].registers) == (
        stand.bench.now_ps,
        stand.x.position,
        stand.x.registers,
    )
    assert bytes(again["x_host"].received) == bytes(stand.bench["x_host"].received)


OLDER = {  # a program that takes 12 steps; what group 3 answers behind it
    "cy500": (b"A\nR 253\nE\nN 12\nG\n0\nQD\n", b"! ?3: allowed ?\r\n"),
    "cy512": (b"A\nR 255\nS 0\nF 1\nE\nN 12\nG\n0\nQD\n", b"?3 00 0C 00 FF 01\r\n"),
}


@pytest.mark.parametrize("part", OLDER)
def test_a_part_without_live_commands_is_busy_while_its_program_runs(part):
    stand = Stand(True, part=part)
    stand.send(OLDER[part][0])
    run, ready = (stand.x.pins[name].net for name in ("run", "ready"))
    stand.bench.run_until(lambda: run.level == 0 and ready.level == 1, "10 ms")
    assert stand.ask(b"?\n") == b"? busy\r\n"
    stand.bench.run_until(lambda: run.level == 1, "1 s")
    assert stand.ask(b"?\n") == b"? ready\r\n"
    assert stand.x.travel == 12
    stand.server.close()


@pytest.mark.system
@pytest.mark.parametrize("part", OLDER)
def test_older_parts_of_the_family_are_served_over_a_socket(serve, client, tmp_path, part):
    journal = tmp_path / "journal"
    server = serve(part, "--tcp", "127.0.0.1:0", "--framing", "--journal", journal)
    host = client(server.where)
    program, answer = OLDER[part]
    host.send(program + b"?\n")
    while (state := host.read(b"\n")) == b"? busy\r\n":
        host.send(b"?\n")
    assert state == b"? ready\r\n"
    host.send(b"?3\n")
    assert host.read(b"\n") == answer
    assert server.end() == (0, "")
    played = slewline.replay(journal)[part]
    assert (played.travel, played.findings) == (12, [])
