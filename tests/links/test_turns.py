"""Hosts on one port, one after the other: what each has sent is played, and nobody waits for one that has gone."""

from __future__ import annotations

import re
import socket
import struct

import pytest
import serial

import slewline
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.lines.served_line import BACKLOG
from slewline.links.ports.tcp import AHEAD
from slewline.links.server import Server

from .conftest import PATIENCE, STRAPS, Client, Threaded, patient

KINDS = pytest.mark.parametrize("kind", ["tcp", pytest.param("rfc2217", marks=pytest.mark.system)])  # its client waits
LITTLE = 400  # bytes
S = 10**9  # nanoseconds of the wall clock

# the client of pySerial 3.5 names its thread in a way that Python 3.10 calls deprecated
pytestmark = pytest.mark.filterwarnings("ignore:set(Daemon|Name)\\(\\) is deprecated:DeprecationWarning")


class Stand:
    """A module on a port, and all that its line has been fed."""

    def __init__(self, kind, pace, log=None, where="127.0.0.1:0", straps=STRAPS):
        bench = slewline.Bench()
        self.server = Server(bench, pace(bench), log)
        self.line = self.server.line(bench.add("gs-c200s", name="x", straps=straps))
        self.port = getattr(self.server, kind)(self.line, where)
        self.fed = bytearray()
        feed = self.line.feed

        def noted(data):
            self.fed += data
            feed(data)

        self.line.feed = noted

    def leave(self, data):
        """A host that writes, closes, and has read nothing."""
        host = Client(self.port.where)
        host.send(data)
        host.close()


def opened(port, **settings):
    settings = {"baudrate": 9600, "bytesize": 7, "parity": "O", "stopbits": 2, "timeout": PATIENCE} | settings
    return serial.serial_for_url(patient(port.where), **settings)


class Wall:
    """A wall clock that goes on when it is told to."""

    def __init__(self):
        self.ns = 0

    def pace(self, bench):
        return Paced(bench, 1, lambda: self.ns)

    def until(self, running, met):
        while not running.do(met):
            self.ns += S // 20


def cycles(kind, number, log):
    stand = Stand(kind, Lockstep, log)
    data = [f"{host:03d}\r".encode() for host in range(number)]
    with Threaded(stand.server) as running:
        for one in data:
            stand.leave(one)
        running.until(lambda: len(stand.fed) >= 4 * number)
        host = Client(stand.port.where)
        host.send(b"F\r")
        assert host.read(b"R\r").endswith(b"R\r")
        host.close()
    assert stand.fed == b"".join(data) + b"F\r"
    assert "refused" not in log.read_text()


@KINDS
def test_a_host_may_write_close_and_open_again_immediately(kind, tmp_path):
    cycles(kind, 100, tmp_path / "log")


@pytest.mark.long
@KINDS
def test_a_thousand_hosts_may(kind, tmp_path):
    cycles(kind, 1000, tmp_path / "log")


@pytest.mark.system
@pytest.mark.posix
def test_a_pty_is_such_a_line_by_itself(tmp_path):
    """The system keeps what a host has written there."""
    stand = Stand("pty", Lockstep, where=str(tmp_path / "x"))
    data = [f"{host:03d}\r".encode() for host in range(50)]
    with Threaded(stand.server) as running:
        for one in data:
            with open(tmp_path / "x", "wb", buffering=0) as host:
                host.write(one)
        running.until(lambda: len(stand.fed) >= 200)
    assert stand.fed == b"".join(data)


@KINDS
def test_leftovers_of_a_host_keep_no_other_host_out(kind, tmp_path):
    """More than is read ahead: the next host is there at once, and its bytes come behind those."""
    wall = Wall()
    stand = Stand(kind, wall.pace)
    left = b"F\r" * 2400
    with Threaded(stand.server) as running:
        stand.leave(left)
        with opened(stand.port) as host:
            assert running.do(lambda: len(stand.fed)) < 1000
            host.write(b"V1\r")
            wall.until(running, lambda: len(stand.fed) == len(left) + 3 and stand.line.quiet())
            assert host.read_until(b"V+0\r").endswith(b"R\rV+0\r")
    assert stand.fed == left + b"V1\r"


@pytest.fixture
def little(monkeypatch):
    """The next host waits for little, so that the tests do."""
    monkeypatch.setattr("slewline.links.ports.tcp.REMAINS", LITTLE)


@KINDS
@pytest.mark.parametrize("size", [100_000, 2_900_000])
def test_much_that_a_host_has_left_is_dropped_for_the_next_one(kind, size, little):
    """It has gone, though its end is behind more than the system keeps."""
    wall, told = Wall(), []
    stand = Stand(kind, wall.pace)
    stand.port.report = told.append
    with Threaded(stand.server) as running:
        gone = Client(stand.port.where)
        gone.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 2 * size)
        gone.socket.setblocking(False)
        sent = gone.socket.send(b"F\r" * (size // 2))
        gone.close()
        with opened(stand.port) as host:
            host.write(b"V1\r")
            wall.until(running, lambda: stand.fed.endswith(b"V1\r") and stand.line.quiet())
            assert host.read_until(b"V+0\r").endswith(b"R\rV+0\r")
    played = len(stand.fed) - 3
    assert LITTLE <= played <= LITTLE + BACKLOG  # what was on its way, and as much as the next one waits for
    assert stand.fed == b"F\r" * (played // 2) + b"V1\r"
    (text,) = told
    dropped = int(re.search(r"(\d+) of them were dropped", text)[1])
    if kind == "tcp":  # else it has closed with an answer unread, and a reset loses what its system has not sent
        assert dropped == sent - played or dropped >= AHEAD - LITTLE
    assert 0 < dropped <= sent - played


def test_kept_input_of_a_host_ends_with_a_complete_line(little):
    wall, told = Wall(), []
    stand = Stand("tcp", wall.pace)
    stand.port.report = told.append
    line = b"R 100\r\n"
    with Threaded(stand.server) as running:
        stand.leave(line * 300)
        running.until(lambda: stand.port.full)
        host = Client(stand.port.where)
        host.send(b"V1\r")
        wall.until(running, lambda: stand.fed.endswith(b"V1\r"))
        host.close()
    kept = (len(stand.fed) - 3) // len(line)
    assert stand.fed == line * kept + b"V1\r"
    assert len(told) == 1


def test_many_hosts_together_leave_no_more_than_one_may(little):
    """The longest is cut; what the others have left is played."""
    wall, told = Wall(), []
    stand = Stand("tcp", wall.pace)
    stand.port.report = told.append
    with Threaded(stand.server) as running:
        for number in range(6):
            stand.leave(b"F\r" * 300)
            running.until(lambda number=number: len(stand.port.turns) == 2 * number + 1)
            stand.leave(b"%d\r" % number)
            running.until(lambda number=number: len(stand.port.turns) == 2 * number + 2)
        host = Client(stand.port.where)
        host.send(b"V1\r")
        running.until(lambda: len(stand.port.turns) == 13)
        assert running.do(lambda: sum(len(one.characters) for one in stand.port.turns)) <= LITTLE + 3
        wall.until(running, lambda: stand.fed.endswith(b"V1\r"))
        host.close()
    assert [number for number in range(6) if b"%d\r" % number not in stand.fed] == []
    assert len(told) >= 1


def test_a_long_program_without_a_waiting_host_is_played_completely(little):
    stand = Stand("tcp", Lockstep)
    data = b"F\r" * 1000
    with Threaded(stand.server) as running:
        stand.leave(data)
        running.until(lambda: len(stand.fed) == len(data))
    assert stand.fed == data


def test_a_live_host_that_has_much_to_say_keeps_its_port(little):
    """Neither is it hung up on, nor is a byte of it lost."""
    wall = Wall()
    stand = Stand("tcp", wall.pace)
    data = b"F\r" * 1000
    with Threaded(stand.server) as running:
        host = Client(stand.port.where)
        host.send(data)
        running.until(lambda: stand.port.full)
        second = Client(stand.port.where)
        assert b"one host at a time" in second.read(end=b"\n")
        wall.until(running, lambda: len(stand.fed) == len(data))
        host.close()
        second.close()
    assert stand.fed == data


def test_a_client_with_excessive_pending_input_gives_precedence(little, monkeypatch):
    """Whether it has closed cannot be seen."""
    monkeypatch.setattr("slewline.links.ports.tcp.AHEAD", 2000)
    wall, told = Wall(), []
    stand = Stand("tcp", wall.pace)
    stand.port.report = told.append
    with Threaded(stand.server) as running:
        floods = Client(stand.port.where)
        floods.send(b"F\r" * 10_000)
        running.until(lambda: stand.port.full)
        host = Client(stand.port.where)
        host.send(b"V1\r")
        wall.until(running, lambda: stand.fed.endswith(b"V1\r"))
        host.close()
        floods.close()
    assert len(told) == 1


@KINDS
def test_in_lockstep_time_passes_until_all_of_it_is_played(kind):
    """At 110 baud it takes minutes, which is longer than an answer is waited for."""
    stand = Stand(kind, Lockstep, straps=STRAPS | {f"br{bit}": 1 for bit in range(3)})
    left = b"F\r" * 600
    with Threaded(stand.server) as running:
        assert stand.line.port.baud == 110
        stand.leave(left)
        with opened(stand.port, baudrate=110) as host:
            host.write(b"V1\r")
            assert host.read_until(b"V+0\r").endswith(b"V+0\r")
        assert running.do(lambda: running.bench.now_ps) > 120 * 10**12
    assert stand.fed == left + b"V1\r"


@KINDS
def test_a_host_that_is_cut_off_amid_its_answers_is_served_completely(kind):
    """It closes with answers unread: its system resets the connection, and answers cannot be sent any more."""
    stand = Stand(kind, Lockstep)
    left = b"F\r" * 2500
    with Threaded(stand.server) as running:
        host = Client(stand.port.where)
        host.send(left)
        assert host.socket.recv(1)
        host.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        host.close()
        running.until(lambda: stand.line.host is None and len(stand.fed) == len(left))
        with opened(stand.port) as host:
            host.write(b"V1\r")
            assert host.read_until(b"V+0\r").endswith(b"V+0\r")
    assert stand.fed == left + b"V1\r"


def test_a_second_host_next_to_a_live_one_is_refused_and_the_one_after_a_gone_one_is_named():
    wall = Wall()
    stand = Stand("tcp", wall.pace)
    with Threaded(stand.server) as running:
        stand.leave(b"F\r" * 100)
        live = Client(stand.port.where)
        running.until(lambda: stand.port.session is not None and len(stand.port.turns) == 2)
        name = "{}:{}".format(*live.socket.getsockname())
        refused = Client(stand.port.where)
        assert refused.read(end=b"") == f"slewline: {name} has this port; one host at a time\r\n".encode()
        for one in (live, refused):
            one.close()


@pytest.mark.system
def test_settings_hold_for_the_turn_of_their_host():
    """What a host has left at 4800 baud goes out at 4800 baud; the next one finds the settings of the module."""
    wall = Wall()
    stand = Stand("rfc2217", wall.pace)
    line = stand.line
    with Threaded(stand.server) as running:
        with opened(stand.port, baudrate=4800, parity="E") as first:
            first.write(b"V1\r" * 50)
            running.until(lambda: line.taken == 150)
        with opened(stand.port) as second:  # pySerial empties both queues when it opens: its own
            found = running.do(lambda: (line.port.baud, str(line.port.word), line.uart.backlog))
            assert found == (4800, "7E2", 150)
            assert second.baudrate == 9600
            wall.until(running, lambda: line.port.baud == 9600)
            assert running.do(lambda: (str(line.port.word), line.uart.backlog)) == ("7O2", 0)
            second.baudrate = 1200
            wall.until(running, lambda: line.port.baud == 1200)
        wall.until(running, lambda: line.port.baud == 9600)


@pytest.mark.system
def test_a_break_waits_for_its_turn():
    wall = Wall()
    stand = Stand("rfc2217", wall.pace)
    with Threaded(stand.server) as running:
        stand.leave(b"\0" * 50)
        with opened(stand.port) as host:
            host.break_condition = True
            assert not running.do(lambda: stand.port.turns[0].begun and stand.port.turns[0] is stand.port.session)
            wall.until(running, lambda: stand.line.port.pin("txd").level == 1 and stand.line.sent())
        wall.until(running, lambda: stand.line.port.pin("txd").level == 0)


def test_rapidly_changing_hosts_wait_outside(monkeypatch):
    monkeypatch.setattr("slewline.links.ports.tcp.QUEUE", 500)
    wall = Wall()
    stand = Stand("tcp", wall.pace)
    with Threaded(stand.server) as running:
        for number in range(30):
            stand.leave(f"{number:02d}\r".encode())
        running.until(lambda: stand.port.crowded)
        assert len(stand.port.turns) <= 500 // 64 + 1
        wall.until(running, lambda: len(stand.fed) == 90)
        assert not running.do(lambda: stand.port.crowded)
    assert stand.fed == b"".join(f"{number:02d}\r".encode() for number in range(30))


def test_registers_work_what_a_host_has_left_and_its_answers_go_to_nobody():
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench))
    line = server.line(bench.add("mc1451a", name="x"))
    port = server.tcp(line, "127.0.0.1:0")
    version = bytes.fromhex("2464 126c 2464 0000 0000 2464 0000 0000")
    with Threaded(server) as running:
        for _ in range(5):
            host = Client(port.where)
            host.send(b"\x01\x00" * 3000 + b"\x10")  # half a request at the end
            host.close()
            host = Client(port.where)
            host.send(version)
            host.socket.shutdown(socket.SHUT_WR)
            assert host.read(end=b"") == b"slewline registers 1 mc1451a 4\r\n" + bytes.fromhex("ff6c ff5c11 ff5c7d")
            host.close()
        running.until(lambda: line.host is None)
    assert line.taken == 5 * (6001 + len(version))
