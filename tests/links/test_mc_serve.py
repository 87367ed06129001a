"""A chipset on a TCP port: requests for registers, byte by byte, and what time passes for them."""

from __future__ import annotations

import json
import os
import random
import re
import signal
import socket
import threading
from pathlib import Path

import pytest

import slewline
from slewline.chips import PARTS, sheet_of
from slewline.cli.main import invoke
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.lines.request_line import BACKLOG
from slewline.links.server import Server
from slewline.links.views.server_status import as_line

from .conftest import Asks, Threaded

NS, US, MS = 10**3, 10**6, 10**9  # picoseconds
CYCLE = 750 * NS  # of the bus
TICK, SLICE = 40 * NS, 81_920 * NS  # of the chipset: a clock; how long HostRdy is low
VERSION = "2464 126c 2464 0000 0000 2464 0000 0000"  # GET_VRSN and its checksum, in one go
CHIPSETS = [part for part, row in PARTS.items() if row.folder == "mc1451a"]
ONE = ("mc1451a", "--tcp", "127.0.0.1:0")


def packet(code, *words, reads=1):
    """The requests of a packet."""
    requests = f"2464 12{code:02x}"
    for word in words:
        requests += f"2464 10{word >> 8:02x} 10{word & 0xFF:02x}"
    return bytes.fromhex(requests + "2464 0000 0000" * reads)


def words(answers):
    """The words at the end of the answers to a packet: those behind its last write."""
    return [answers[at] << 8 | answers[at + 1] for at in range(1, len(answers), 3)]


def ready_at(ps):
    """When HostRdy is high again, behind a strobe that ends then."""
    return -(-ps // TICK) * TICK + SLICE


class Registers:
    """A host on a chipset's port; requests in hexadecimal."""

    def __init__(self, client):
        self.client = client
        self.greeting = client.read(b"\n")

    def ask(self, requests):
        data = bytes.fromhex(requests) if isinstance(requests, str) else requests
        self.client.send(data)
        return self.answers(len(data) // 2)

    def answers(self, number):
        found = b""
        while len(found) < number:
            more = self.client.socket.recv(number - len(found))
            assert more, "the server has closed the connection"
            found += more
        return found

    def packet(self, code, *values, reads=1):
        return words(self.ask(packet(code, *values, reads=reads))[-3 * reads :])


@pytest.fixture
def make():
    """A chipset x on a bench of its own, and a server with its line."""

    def make(part="mc1451a", rate=None, **options):
        log = options.pop("log", None)
        bench = slewline.Bench(**options)
        x = bench.add(part, name="x")
        server = Server(bench, Lockstep(bench) if rate is None else Paced(bench, rate), log)
        return server, server.line(x)

    return make


@pytest.fixture
def stand(make, client):
    """One in lockstep: the running server, a host, a client of the control port."""
    server, line = make()
    port, control = server.tcp(line, "127.0.0.1:0"), server.control("127.0.0.1:0")
    with Threaded(server) as running:
        yield running, Registers(client(port.where)), Asks(client(control.where))


class Still:
    """A chipset in lockstep without a port: what is asked is played at once, up to the last bit."""

    def __init__(self, server, line):
        self.server, self.line, self.bench = server, line, server.bench
        self.got = bytearray()
        self.bench.run(0)
        server.pace.start()
        self.attach(self.got)

    def attach(self, got):
        self.line.attach("a host", lambda data: got.extend(data) or 0, lambda: None)

    def play(self):
        while not self.server.pace.pass_time():
            pass

    def ask(self, requests):
        """Returns the answers, and how much time they took."""
        before, had = self.bench.now_ps, len(self.got)
        self.line.take(bytes.fromhex(requests) if isinstance(requests, str) else requests)
        self.play()
        return bytes(self.got[had:]), self.bench.now_ps - before


@pytest.fixture
def still(make):
    server, line = make()
    yield Still(server, line)
    server.close()


# ----------------------------------------------------------------------------------------------------------- messages
@pytest.mark.parametrize("part", CHIPSETS)
def test_the_greeting_names_the_part_and_the_chipset_answers(part, make, client):
    server, line = make(part)
    port = server.tcp(line, "127.0.0.1:0")
    sheet = sheet_of(part)
    with Threaded(server):
        assert port.where.startswith("registers://127.0.0.1:")
        host = Registers(client(port.where))
        assert host.greeting == f"slewline registers 1 {part} {sheet.axes}\r\n".encode()
        version = sheet.dialect.version
        assert host.ask(VERSION) == bytes.fromhex(f"ff6c ff{version:04x} ff{version + 0x6C:04x}")


def test_an_access_is_one_bus_cycle(still):
    still.bench.run("10 ms")
    begun = still.bench.now_ps
    assert still.ask("0400") == (b"\xff", CYCLE)  # the status: ready
    assert still.ask("1231") == (b"\x31", CYCLE)  # GET_STATUS
    assert still.ask("2400") == (b"\x7f", CYCLE)  # the status, without waiting
    ready = ready_at(begun + 3 * CYCLE // 2)  # HostWrite rises in mid-cycle
    assert still.ask("2464") == (b"\xff", ready + CYCLE - (begun + 3 * CYCLE))
    assert still.ask("00ff 0000") == (b"\x03\x00", 2 * CYCLE)
    assert still.ask("0100 0200 0f00") == (b"\xff\xff\xff", 3 * CYCLE)  # addresses without a function


def test_ready_waits_for_the_requested_time(still):
    still.bench.run("10 ms")
    still.bench["x"].pin("reset").drive(0)
    assert still.ask("2464") == (b"\x7f", 100 * MS + CYCLE)
    assert still.ask("24ff") == (b"\x7f", 255 * MS + CYCLE)
    begun = still.bench.now_ps
    still.bench["x"].pin("reset").release()
    answers, took = still.ask("24ff")
    assert answers == b"\xff"
    assert 0 <= took - 40 * SLICE - CYCLE < TICK, begun  # ten cycles, from the first clock behind the reset on


def test_a_poll_that_finds_it_busy_lets_time_pass_in_lockstep(still):
    still.bench.run("10 ms")
    begun = still.bench.now_ps
    still.ask("1231")
    assert still.ask("0400") == (b"\x7f", ready_at(begun + CYCLE // 2) - (begun + CYCLE))  # until HostRdy rises
    assert still.ask("0400") == (b"\xff", CYCLE)
    still.bench["x"].pin("reset").drive(0)
    assert still.ask("0400") == (b"\x7f", 100 * US + CYCLE)  # and no longer than that
    assert still.ask("0400 0400") == (b"\x7f\x7f", 2 * (100 * US + CYCLE))


def test_an_invalid_request_is_answered_and_does_nothing(still):
    still.bench.run("10 ms")
    assert still.ask("2000 2564 4747 ffff 1fff") == (b"\xff\xff\xff\xff\xff", CYCLE)  # the last one writes to nobody
    assert still.ask("0400")[0] == b"\xff"
    found, nobody = still.bench.findings  # once for each host
    assert (found.source, found.code) == ("x_isa", "no-request")
    assert "b' \\x00' is not a request, and reads FF: this is a port for registers" in found.text
    assert nobody.code == "no-register" and nobody.text.startswith(
        "OUT 0x34f has no effect: for OUT, x_isa at 0x340 has data"
    )


def test_requests_may_come_in_any_pieces(still):
    still.bench.run("10 ms")
    whole = still.ask(VERSION)
    still.bench.run_to("20 ms")
    begun, had = still.bench.now_ps, len(still.got)
    for byte in bytes.fromhex(VERSION):
        still.line.take(bytes([byte]))
    still.play()
    assert (bytes(still.got[had:]), still.bench.now_ps - begun) == whole


def test_answers_come_when_the_access_is_over(still):
    still.bench.run("10 ms")
    seen = []
    still.line.host = lambda data: seen.append((still.bench.now_ps, data)) or 0
    begun = still.bench.now_ps
    still.ask("1231 2464 0000")
    ready = ready_at(begun + CYCLE // 2)
    assert seen == [(begun + CYCLE, b"\x31"), (ready + CYCLE, b"\xff"), (ready + 2 * CYCLE, b"\x03")]


def test_a_packet_is_faster_in_one_go_and_the_same(still):
    still.bench.run("10 ms")
    (answers, took) = still.ask(packet(0x10, 0, 12345))
    assert words(answers[-3:]) == [0x10 + 12345]
    assert took < 4 * SLICE + 20 * CYCLE
    assert still.ask(packet(0x4A, reads=3))[0][-8:] == bytes.fromhex("0000 ff3039 ff3083")


def test_an_endless_motion_is_as_far_as_the_host_has_come(make):
    def moved():
        still = Still(*make())
        still.bench.run("10 ms")
        for request in (packet(0x0A), packet(0x11, 1, 0), packet(0x12, 1, 0), packet(0x1A)):
            still.ask(request)
        for _ in range(100):
            still.ask(packet(0x31, reads=2))
        here = still.bench["x"].position, still.bench.now_ps
        still.play()
        assert (still.bench["x"].position, still.bench.now_ps) == here
        still.server.close()
        return here

    position, now_ps = moved()
    assert 70 < position < 100  # 100 questions of three slices each, a step per cycle
    assert moved() == (position, now_ps)


def test_the_exchange_on_the_reference_page(still):
    still.bench.run("10 ms")
    page = (Path(__file__).parents[2] / "docs/reference/registers.md").read_text("utf-8")
    lines = re.findall(r"^    ([<>])((?: [0-9a-f]{2})+)", page, re.MULTILINE)
    assert len(lines) == 10
    for (way, request), (back, answer) in zip(lines[::2], lines[1::2], strict=True):
        assert (way, back) == (">", "<")
        assert still.ask(request)[0] == bytes.fromhex(answer)


# -------------------------------------------------------------------------------------------------------------- hosts
def test_the_next_host_gets_the_reason_and_the_first_one_stays(make, client, tmp_path):
    server, line = make(log=tmp_path / "log")
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server) as running:
        first = Registers(client(port.where))
        assert first.ask(VERSION)[-5:-2] == b"\x5c\x11\xff"
        name = "{}:{}".format(*first.client.socket.getsockname())
        says = f"slewline: {name} has this port; one host at a time\r\n".encode()
        watched = running.do(lambda: len(server.loop.calls))
        second = client(port.where)
        assert second.read(end=b"") == says
        second.close()
        running.until(lambda: len(server.loop.calls) == watched)
        assert first.ask(VERSION)[-5:-2] == b"\x5c\x11\xff"
    assert f"was refused: {name} is connected" in (tmp_path / "log").read_text()


def test_a_host_that_vanishes_in_mid_packet_makes_room(make, client):
    server, line = make()
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server) as running:
        first = Registers(client(port.where))
        assert first.ask("2464 1210 2464 1012 24") == bytes.fromhex("ff10 ff12")  # SET_POS, a byte, half a request
        first.client.close()
        running.until(lambda: line.host is None)
        second = Registers(client(port.where))
        assert second.ask(VERSION) == bytes.fromhex("ff6c ff5c11 ff5c7d")
        found = [found.code for found in running.do(lambda: running.bench.findings)]
    assert found == ["odd-byte", "aborted-packet"]


def test_answers_for_a_host_that_has_gone_are_not_those_of_the_next_one(still):
    still.bench.run("10 ms")
    still.line.take(bytes.fromhex("126c 2464 0000"))
    still.line.detach("hung up")
    got = bytearray()
    still.attach(got)
    still.line.take(b"\x00\x00")
    still.play()
    assert (bytes(still.got), bytes(got)) == (b"", b"\x11")  # what the first one has sent is played


def test_a_host_that_closes_its_sending_side_gets_its_answers(make, client):
    server, line = make(rate="1")
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server):
        host = client(port.where)
        host.send(bytes.fromhex(VERSION))
        host.socket.shutdown(socket.SHUT_WR)
        assert host.read(end=b"") == b"slewline registers 1 mc1451a 4\r\n" + bytes.fromhex("ff6c ff5c11 ff5c7d")


@pytest.mark.system
def test_a_host_that_does_not_read_loses_no_answer(make, client):
    server, line = make()
    port = server.tcp(line, "127.0.0.1:0")
    number = 40_000
    with Threaded(server) as running:
        host = Registers(client(port.where, room=4096))

        def narrow():
            port.session.connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
            port.session.stream.queue = 1500

        running.do(narrow)
        sender = threading.Thread(target=host.client.send, args=(b"\x01\x00" * number,))
        sender.start()
        # what the system holds for both sides is its own affair: it may take some more after the first refusal
        running.until(lambda: port.session.stream.blocked)
        assert running.standing(lambda: line.taken) < 2 * number  # nothing is read on
        assert host.answers(number) == b"\xff" * number
        sender.join()
        assert running.do(lambda: (line.taken, line.given, line.dropped)) == (2 * number, number, 0)
        assert host.ask("0100") == b"\xff"


def test_a_host_with_too_many_requests_waits_its_turn(make, client):
    server, line = make(rate="0.0001")  # a request takes seconds
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server) as running:
        host = Registers(client(port.where))
        host.client.send(b"\x01\x00" * 5 * BACKLOG)
        running.until(lambda: line.room() <= 0)
        assert running.do(lambda: line.taken) <= 2 * BACKLOG


def test_no_input_brings_it_down(stand):
    running, host, _ = stand
    chance = random.Random(7)
    for _ in range(50):
        data = bytes(byte & 0xBF if byte in (0xC0, 0xC1) else byte for byte in chance.randbytes(400))
        assert len(host.ask(data)) == 200
    for _ in range(50):
        steps = chance.randbytes(2 * chance.randrange(1, 60))
        host.client.send(bytes([chance.choice((0xC0, 0xC1)), len(steps) // 2]) + steps)
        assert len(host.answers(len(steps) // 2)) == len(steps) // 2
    host.ask("1800 2464")  # reset
    host.ask(VERSION)  # the first byte of a word may have been read
    assert host.ask(VERSION) == bytes.fromhex("ff6c ff5c11 ff5c7d")
    assert running.do(lambda: len(running.bench.findings)) > 10


# ------------------------------------------------------------------------------------------------- around the registers
def test_a_journal_of_a_served_host_replays_without_a_port(make, tmp_path):
    path = tmp_path / "journal"
    server, line = make(journal=path)
    still = Still(server, line)
    for request in (packet(0x10, 0, 5000), packet(0x11, 8, 0), packet(0x12, 0, 0x800), packet(0x1A)):
        still.ask("0400" * 3)  # polls, of which some find it busy
        still.ask(request)
    still.ask("126c 0400 0400 0000 0000 0400 0400")
    still.bench.run("30 ms")
    still.ask("1800")
    still.ask(VERSION)
    steps, now = still.bench["x"].steps(), still.bench.now_ps
    server.close()
    again = slewline.replay(path)
    assert again.now_ps == now
    assert len(steps) > 100
    assert again["x"].steps().times_ps.tolist() == steps.times_ps.tolist()
    assert [str(found) for found in again.findings] == [str(found) for found in still.bench.findings]


def test_the_transcript_has_accesses_and_no_polls(make, tmp_path):
    still = Still(*make(log=tmp_path / "log"))
    still.ask("2464")
    still.ask("0400 126c 0400 0400 0000 0000 4711 0400")
    still.server.close()
    lines = [line.split(maxsplit=1) for line in (tmp_path / "log").read_text().splitlines()]
    assert lines.pop(8)[1].startswith(r"x_isa ! no-request: b'G\x11' is not a request, and reads FF")
    assert [text for _, text in lines] == [
        "x ! a host is connected", "x > 4 ff", "x < 2 6c", "x > 4 7f", "x > 4 ff", "x > 0 5c", "x > 0 11",
        "x ! 47 11 is not a request", "x > 4 7f",
    ]  # fmt: skip
    assert lines[1][0] == "0.003278"  # ten cycles, a clock, and a bus cycle


def test_the_control_port_knows_axes(stand):
    _, host, ask = stand
    host.ask("2464")
    for request in (packet(0x02, reads=2), packet(0x10, 0, 1000), packet(0x11, 4, 0), packet(0x12, 4, 0)):
        host.ask(request)
    host.ask(packet(0x1A))
    assert ask("until", chip="x", axis=2, position=123)["met"] is True
    chip = ask("status")["chips"]["x"]
    assert [axis["position"] for axis in chip["axes"]] == [0, 123, 0, 0]
    assert chip["axes"][1]["registers"]["pos"] == 1000
    assert (chip["position"], chip["moving"]) == (0, True)
    assert ask("until", chip="x", axis=2, position=1000)["met"] is True
    steps = ask("steps", chip="x", axis=2)
    assert steps["positions"] == list(range(1, 1001))
    assert ask("steps", chip="x", axis=1)["positions"] == ask("steps", chip="x")["positions"] == []
    assert "has no axis 5; its axes are 1 to 4" in ask.refused("steps", chip="x", axis=5)
    assert ask.refused("fault", line="x", to="chip", kind="lost") == "no serial line 'x'; allowed: none"


def test_a_status_line_has_all_axes(make):
    server, _ = make()
    server.bench["x"].axes[2].load(-7)
    assert "x busy at 0, 0, -7, 0 | 0 of 1 lines connected" in as_line(server)
    server.close()


def test_a_pin_that_the_control_port_drives_is_seen_by_the_host(stand):
    _, host, ask = stand
    host.ask("2464")
    assert host.packet(0x05, reads=2)[0] == 0x000F
    ask("drive", pin="x.home3", level=0)
    ask("advance", time="1 ms")
    assert host.packet(0x05, reads=2)[0] == 0x000B


# ---------------------------------------------------------------------------------------------------------- the command
@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty directory, in which the command runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.system
def test_a_thousand_packets_in_real_time(serve, client):
    server = serve(*ONE)
    assert list(server.ports) == ["mc1451a"]
    host = Registers(client(server.where))
    host.ask("2464")
    for number in range(1000):
        assert host.packet(0x10, number, 0xFFFF - number) == [0x10 + 0xFFFF & 0xFFFF]
    assert host.packet(0x4A, reads=3) == [999, 0xFFFF - 999, 0x4A + 0xFFFF & 0xFFFF]
    told = "slewline: mc1451a: no-update: axis 1: SET_POS 65535000 without an update"
    status, errors = server.end()
    assert status == 0 and errors.startswith(told) and errors.count("\n") == 1
    assert host.client.read(end=b"") == b""


@pytest.mark.system
def test_a_server_that_is_killed_lets_a_new_one_begin_afresh(serve, client):
    first = serve(*ONE)
    host = Registers(client(first.where))
    host.ask("2464")
    host.packet(0x10, 1, 2)
    first.kill()
    assert host.client.read(end=b"") == b""
    host = Registers(client(serve(*ONE).where))
    host.ask("2464")
    assert host.packet(0x4A, reads=3) == [0, 0, 0x4A]


@pytest.mark.system
@pytest.mark.posix
def test_a_status_line_is_requested(serve, client):
    server = serve(*ONE, "--lockstep")
    Registers(client(server.where)).ask("2464")
    server.process.send_signal(signal.SIGUSR1)
    assert "mc1451a idle at 0, 0, 0, 0 | 1 of 1 lines connected" in server.errors()


@pytest.mark.system
def test_a_bench_file_serves_chipsets_next_to_modules(serve, client, folder):
    (folder / "bench.toml").write_text(
        '[[chip]]\npart = "mc1251a"\nname = "x"\n[[chip]]\npart = "gs-c200s"\nname = "y"\nstraps = { chs = 0 }\n'
        '[[serve]]\nchips = ["x"]\ntcp = "127.0.0.1:0"\n[[serve]]\nchips = ["y"]\ntcp = "127.0.0.1:0"\n'
    )
    server = serve("--bench", "bench.toml", "--lockstep", ports=2)
    host = Registers(client(server.ports["x"]))
    assert host.greeting == b"slewline registers 1 mc1251a 2\r\n"
    assert host.ask(VERSION) == bytes.fromhex("ff6c ff4c11 ff4c7d")
    assert server.end() == (0, "")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--pty", "x"], "mc1451a has no serial line for --pty; use --tcp"),
        (["--rfc2217", "127.0.0.1:0"], "mc1451a has no serial line for --rfc2217; use --tcp"),
        (["--serial", "/dev/null"], "mc1451a has no serial line for --serial; use --tcp"),
        (["--tcp", "127.0.0.1:0", "--framing"], "mc1451a is served as registers, which need no framing"),
        (["--tcp", "127.0.0.1:0", "--state", "d"], "--state stores EEPROMs, but a mc1451a has none; leave out --state"),
        (["--tcp", "0.0.0.0:0"], "--allow-remote"),
        (["--tcp", "127.0.0.1:0", "--lockstep", "--rate", "2"], "leave out --rate"),
        (["--tcp", "127.0.0.1:0", "--strap", "br0=0"], "no pin 'br0'"),
    ],
)
def test_wrong_use_is_reported(capfd, folder, arguments, says):
    assert invoke(["serve", "mc1451a", *arguments]) == 2
    assert says in capfd.readouterr().err
    assert os.listdir(folder) == []


def test_chipsets_do_not_share_a_port(make):
    server, _ = make()
    y = server.bench.add("mc1451a", name="y")
    with pytest.raises(slewline.UsageError, match="x has a bus, so it cannot share a port; give x a port of its own"):
        server.line(server.bench["x"], y)
    server.close()


def test_the_help_names_the_other_end(capfd):
    assert invoke(["serve", "--help"]) == 0
    text = " ".join(capfd.readouterr().out.split())
    assert "slewline.links.clients.chipset_port" in text
    assert "examples/mc1451a/slewline_port.h" in text


def test_a_status_is_json(stand):
    _, _, ask = stand
    assert json.dumps(ask("status")["lines"]["x"]).startswith('{"chips": ["x"], "host": "127.0.0.1:')
