"""Modules on TCP ports: hosts that come, go, stay silent, never read, or are too many."""

from __future__ import annotations

import socket
import struct
import time

import pytest

import slewline
from slewline.errors import UsageError
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.lines.served_line import BACKLOG
from slewline.links.server import Server
from slewline.links.sockets.address import parse_address

from .conftest import PATIENCE, STRAPS, Threaded


@pytest.fixture
def port(lockstep, tmp_path):
    """A module on a TCP port: the running server, the line, the port."""
    server, line = lockstep(log=tmp_path / "log")
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server) as running:
        yield running, line, port


@pytest.mark.real("socket")
def test_a_module_answers(port, client):
    host = client(port[2].where)
    assert host.ask(b"F\r") == b"R\r"
    assert host.ask(b"V1\r") == b"V+0\r"


def test_a_program_is_entered_and_runs(port, client):
    running, _, tcp = port
    host = client(tcp.where)
    for line in (b"Po", b"S50", b"T200", b"R20", b"+400", b"E"):
        assert host.ask(line + b"\r") == b"Y\r"
    asked = 1
    while host.ask(b"F\r") == b"B\r":
        asked += 1
    assert host.ask(b"V1\r") == b"V+400\r"
    assert asked > 20  # in lockstep the motion is as far as the questions have brought it
    assert running.do(lambda: running.bench["x"].position) == 400


def test_the_next_host_gets_the_reason_and_the_first_one_stays(port, client):
    first, second = client(port[2].where), client(port[2].where)
    assert first.ask(b"F\r") == b"R\r"
    name = "{}:{}".format(*first.socket.getsockname())
    assert second.read(end=b"") == f"slewline: {name} has this port; one host at a time\r\n".encode()
    assert first.ask(b"F\r") == b"R\r"


@pytest.mark.system
def test_a_host_that_vanishes_makes_room_and_its_commands_are_played(port, client):
    running, line, tcp = port
    first = client(tcp.where)
    first.send(b"V")
    running.until(lambda: line.taken == 1)
    first.close()
    running.until(lambda: line.host is None)
    assert client(tcp.where).ask(b"1\r") == b"V+0\r"


def test_a_host_that_is_cut_off_makes_room(port, client):
    running, line, tcp = port
    first = client(tcp.where)
    assert first.ask(b"F\r") == b"R\r"
    first.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    first.close()  # a reset instead of an end
    running.until(lambda: line.host is None)
    assert client(tcp.where).ask(b"F\r") == b"R\r"


def test_a_permanently_silent_host_is_detected_by_the_system(port, client):
    running, _, tcp = port
    client(tcp.where).ask(b"F\r")
    ours = running.do(lambda: tcp.session.connection)
    assert ours.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
    assert ours.getsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE) == 10


@pytest.mark.parametrize("kind", ["tcp", "rfc2217"])
def test_a_host_that_closes_its_sending_side_gets_its_answers(client, kind):
    bench = slewline.Bench()
    server = Server(bench, Paced(bench))
    line = server.line(bench.add("gs-c200s", name="x", straps=STRAPS))
    port = getattr(server, kind)(line, "127.0.0.1:0")
    with Threaded(server) as running:
        host = client(port.where)
        host.send(b"V1\rF\r")
        host.socket.shutdown(socket.SHUT_WR)
        assert host.read(end=b"").endswith(b"V+0\rR\r")
        running.until(lambda: line.host is None)


def test_a_host_that_closes_its_sending_side_blocks_no_other(client):
    bench = slewline.Bench()
    server = Server(bench, Paced(bench, "0.0001"))  # an answer takes minutes
    line = server.line(bench.add("gs-c200s", name="x", straps=STRAPS))
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server) as running:
        host = client(port.where)
        host.send(b"V1\r")
        host.socket.shutdown(socket.SHUT_WR)
        running.until(lambda: port.session is not None and port.session.stream.at_end)
        assert line.host is not None
        name = "{}:{}".format(*client(port.where).socket.getsockname())
        running.until(lambda: line.host_name == name)
        assert host.read(end=b"") == b""


def test_a_slow_host_is_waited_for(port, client):
    running, line, tcp = port
    host = client(tcp.where)
    for byte in b"V1\r":
        host.send(bytes([byte]))
        taken = line.taken
        running.until(lambda taken=taken: line.taken >= taken)
    assert host.read() == b"V+0\r"


def test_a_host_that_never_reads_costs_a_bounded_queue(port, client):
    running, line, tcp = port
    client(tcp.where)
    running.until(lambda: line.host is not None)

    def flood():
        for _ in range(1000):
            line.give(bytes(1000))  # in one turn, so that the system cannot take any of it
        return len(tcp.session.stream.outgoing)

    assert running.do(flood) <= 1 << 16
    assert line.dropped >= 1_000_000 - (1 << 16)
    assert line.given + line.dropped == 1_000_000


def test_a_host_that_writes_endlessly_is_blocked(client):
    bench = slewline.Bench()
    server = Server(bench, Paced(bench, "0.0001"))  # a character takes 11 s
    line = server.line(bench.add("gs-c200s", name="x", straps=STRAPS))
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server) as running:
        host = client(port.where)
        host.socket.setblocking(False)
        with pytest.raises(BlockingIOError):
            while True:
                host.send(bytes(1 << 16))
        running.until(lambda: line.taken == BACKLOG)
        assert running.do(lambda: line.uart.backlog) == BACKLOG


def test_a_byte_meets_the_virtual_time_of_its_arrival(client, tmp_path):
    """The server has slept for a long time: nothing was to be done."""
    wall = [0]
    bench = slewline.Bench()
    server = Server(bench, Paced(bench, 1, lambda: wall[0]), tmp_path / "log")
    port = server.tcp(server.line(bench.add("gs-c200s", name="x", straps=STRAPS)), "127.0.0.1:0")
    with Threaded(server) as running:
        host = client(port.where)
        running.until(lambda: port.session is not None)
        wall[0] += 700_000_000
        host.send(b"F\r")
        running.until(lambda: running.server.lines["x"].taken == 2)
        wall[0] += 100_000_000
        assert host.read() == b"R\r"
    lines = [line.split() for line in (tmp_path / "log").read_text().splitlines()]
    assert ["0.701000", "x", "<", "F\\r"] in lines
    assert ["0.705437", "x", ">", "R\\r"] in lines


@pytest.mark.system
def test_accept_is_retried_without_file_descriptors(port, client, monkeypatch):
    _, _, tcp = port
    asked = []

    def accept():
        asked.append(1)
        if len(asked) == 1:
            raise OSError(24, "too many open files")
        return real.accept()

    real = tcp.listener.socket
    monkeypatch.setattr(tcp.listener, "socket", Proxy(real, accept))
    assert client(tcp.where).ask(b"F\r") == b"R\r"
    assert len(asked) == 2  # it has not kept the loop busy meanwhile


class Proxy:
    """A socket with another accept."""

    def __init__(self, real, accept):
        self.real, self.accept = real, accept

    def __getattr__(self, name):
        return getattr(self.real, name)


def test_several_modules_share_a_line(client):
    bench = slewline.Bench()
    straps = ({"sel0": 1, "sel1": 1, "sel2": 0}, {"sel0": 1, "sel1": 0, "sel2": 1})
    chips = [bench.add("gs-c200s", name=name, straps=STRAPS | sel) for name, sel in zip("xy", straps, strict=True)]
    server = Server(bench, Lockstep(bench))
    port = server.tcp(server.line(*chips), "127.0.0.1:0")
    addresses = [str(chip.strapped_address()).encode() for chip in chips]
    assert b"0" not in addresses and len(set(addresses)) == 2
    with Threaded(server):
        host = client(port.where)
        for chip, address, value in zip(chips, addresses, (b"+5", b"-7"), strict=True):
            assert host.ask(address + b"f" + value + b"\r") == b"Y\r"
            assert host.ask(address + b"V1\r") == b"V" + value + b"\r"
            assert chip.position == int(value)


def test_modules_of_different_speed_share_no_line():
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench))
    chips = [bench.add("gs-c200s", straps=STRAPS), bench.add("gs-c200s", straps=STRAPS | {"br0": 1})]
    with pytest.raises(UsageError, match="differ in rate or format"):
        server.line(*chips)
    server.close()


def test_a_chip_on_a_bus_shares_no_line():
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench))
    with pytest.raises(UsageError, match="c has a bus, so it cannot share a port; give c a port of its own"):
        server.line(bench.add("gs-c200s", name="x"), bench.add("cy525", name="c"))
    server.close()


@pytest.mark.parametrize(
    "text", ["127.0.0.1", "127.0.0.1:", ":4001", "127.0.0.1:65536", "127.0.0.1:http", "127.0.0.1:-1"]
)
def test_an_address_has_host_and_port(text):
    with pytest.raises(UsageError, match="expected HOST:PORT"):
        parse_address(text)


@pytest.mark.parametrize("text", ["0.0.0.0:0", "[::]:0", "192.168.0.1:4001", "example.org:4001"])
def test_other_machines_come_in_only_when_they_may(text, monkeypatch):
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [(socket.AF_INET,)])
    with pytest.raises(UsageError, match="--allow-remote"):
        parse_address(text)
    assert parse_address(text, True)[1] in (0, 4001)


@pytest.mark.parametrize("kind", ["tcp", "rfc2217"])
def test_a_port_reachable_from_other_machines_is_reported(kind):
    bench, told = slewline.Bench(), []
    server = Server(bench, Lockstep(bench), allow_remote=True, report=told.append)
    line = server.line(bench.add("gs-c200s", name="x", straps={"br0": 0, "chs": 0}))
    open_to_all = getattr(server, kind)(line, "0.0.0.0:0")
    (text,) = [text for text in told if "open to" in text]
    assert text == (
        f"{open_to_all.where}: open to every network of this machine; "
        "any client that connects can command the module, without a password"
    )
    told.clear()
    getattr(server, kind)(line, "127.0.0.1:0")
    assert not any("open to" in text for text in told)
    control = server.control("0.0.0.0:0", "12345678")
    assert (
        told[-1]
        == f"{control.where}: open to every network of this machine; any client with the token can drive every pin"
    )
    server.close()


@pytest.mark.parametrize("allow_remote", [False, True])
def test_an_unknown_name_is_reported(lockstep, monkeypatch, allow_remote):
    def unknown(*_, **__):
        raise socket.gaierror(socket.EAI_NONAME, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    server, line = lockstep()
    server.allow_remote = allow_remote
    with pytest.raises(UsageError, match=r"the name 'nohost\.invalid' cannot be resolved"):
        server.tcp(line, "nohost.invalid:0")
    server.close()


@pytest.mark.parametrize("text", ["127.0.0.1:1", "127.8.8.8:1", "localhost:1", "[::1]:1"])
def test_this_machine_always_may(text):
    assert parse_address(text)[1] == 1


def test_an_occupied_port_is_reported(lockstep):
    server, line = lockstep()
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.raises(UsageError, match="choose another address"):
        server.tcp(line, f"127.0.0.1:{taken.getsockname()[1]}")
    server.close()


@pytest.mark.skipif(not hasattr(socket, "TCP_QUICKACK"), reason="this system has no such option")
def test_a_host_that_writes_in_small_pieces_does_not_wait_for_acknowledgements(lockstep, client):
    """Nagle's rule holds its second piece back until the first is acknowledged, which a system does after 40 ms."""
    server, line = lockstep()
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server):
        host = client(port.where)
        took, end = [], time.perf_counter() + PATIENCE
        while not any(seconds < 0.03 for seconds in took[10:]):  # a busy machine takes longer now and then
            began = time.perf_counter()
            host.send(b"V")
            host.send(b"1")
            host.send(b"\r")
            assert host.read() == b"V+0\r"
            took.append(time.perf_counter() - began)
            assert began < end


@pytest.mark.parametrize(("part", "over"), [("gs-c200s", None), ("cy545b", "serial"), ("cy525", None)])
def test_telnet_on_a_raw_port_is_a_finding(part, over, client):
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench))
    x = bench.add(part)
    port = server.tcp(server.line(x, over=over), "127.0.0.1:0")
    with Threaded(server) as running:
        host = client(port.where)
        host.socket.sendall(bytes.fromhex("fffd03 fffb18 fffb1f"))
        host.socket.sendall(b"F\r")
        running.until(lambda: any(found.code == "telnet" for found in bench.findings))
        running.do(lambda: None)
    (found,) = [found.text for found in bench.findings if found.code == "telnet"]
    assert "use a raw connection, or --rfc2217" in found


@pytest.mark.parametrize("data", [b"\xffN 1\r", b"\xff\xfb\x01\r", b"V1\r\xff\xfd\x03\xff\xfb\x18"])
def test_bytes_that_only_begin_like_telnet_are_none(data):
    """On a line of 8 bits a byte may be 0xff."""
    bench = slewline.Bench()
    bench.host(bench.add("cy545b"), over="serial").write(data)
    bench.run("1 s")
    assert "telnet" not in [found.code for found in bench.findings]
