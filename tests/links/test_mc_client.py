"""The host's end of a served chipset, in this process and in others that have nothing but the standard library."""

from __future__ import annotations

import shutil
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager

import pytest

import slewline
from slewline.errors import UnknownName
from slewline.links.clients import chipset_port
from slewline.links.clients.chipset_host import ChipsetHost
from slewline.links.clients.chipset_port import COMMAND, DATA, STATUS, ChipsetPort
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server

from .conftest import PATIENCE, Asks, Threaded, until

SERVED = ("mc1451a", "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0")
LOCKSTEP = (*SERVED, "--lockstep")


def place(where):
    """Host and port of a URL."""
    host, port = where.rpartition("//")[2].rsplit(":", 1)
    return host, int(port)


@pytest.fixture
def served(serve):
    """The command in lockstep: the server, host and port, the control port."""
    server = serve(*LOCKSTEP, ports=2)
    return server, place(server.where), server.ports["control"]


@pytest.fixture
def stand():
    """A chipset x in lockstep in a thread of this process."""
    bench = slewline.Bench()
    bench.add("mc1451a", name="x")
    server = Server(bench, Lockstep(bench))
    port = server.tcp(server.line(bench["x"]), "127.0.0.1:0")
    with Threaded(server) as running:
        yield running, place(port.where)


# ---------------------------------------------------------------------------------------------------------- registers
def test_it_reports_its_connection(stand):
    _, where = stand
    with ChipsetPort(*where) as port:
        assert (port.part, port.axes) == ("mc1451a", 4)
        assert port.where == "{}:{}".format(*where)


def test_registers_are_read_and_written(stand):
    running, where = stand
    with ChipsetPort(*where) as port:
        assert port.ready() is True
        port.out(COMMAND, 0x6C)
        assert port.inp(STATUS) == 0x7F
        assert port.inp(STATUS) == 0xFF  # in lockstep time has passed
        assert (port.inp(DATA), port.inp(DATA)) == (0x5C, 0x11)
        assert port.ready(0) is False
        assert port.ready() is True
        port.out(0x342, 0x6C)  # of an address the lowest bits count
        assert port.ready(1) is True
        assert (port.inp(0x340), port.inp(0x340)) == (0x5C, 0x11)
        assert [port.inp(address) for address in (1, COMMAND, 0x3F)] == [0xFF, 0xFF, 0xFF]
    found = running.do(lambda: running.bench.findings)
    assert [one.text[:18] for one in found] == ["IN 0x341 reads FF:", "IN 0x342 reads FF:", "IN 0x34f reads FF:"]


def test_a_packet_is_one_exchange(stand):
    running, where = stand
    line = running.server.lines["x"]
    with ChipsetPort(*where) as port:
        port.ready()
        assert port.packet(0x10, (0, 12345)) == (0x3049,)
        assert port.packet(0x4A, reads=3) == (0, 12345, 0x4A + 12345)
        before = running.do(lambda: line.taken)
        assert port.packet(0x39, reads=0) == ()  # RESET
        assert running.do(lambda: line.taken) == before + 6  # one series
        assert port.packet(0x4A, reads=3) == (0, 0, 0x4A)


def test_hostrdy_that_stays_low_is_reported_and_the_port_continues(stand):
    running, where = stand
    with ChipsetPort(*where) as port:
        running.do(lambda: running.bench["x"].pin("reset").drive(0))
        assert port.ready(255) is False
        with pytest.raises(TimeoutError, match=r"127\.0\.0\.1:\d+: HostRdy stays low in packet 31"):
            port.packet(0x31, reads=2)
        running.do(lambda: running.bench["x"].pin("reset").release())
        assert port.packet(0x31, reads=2) == (0x0300, 0x0331)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda port: port.out(0, 256), "byte 256; allowed 0..255"),
        (lambda port: port.out(0, "1"), "byte '1'; allowed 0..255"),
        (lambda port: port.ready(-1), "ms -1; allowed 0..255"),
        (lambda port: port.packet(0x100), "code 256; allowed 0..255"),
        (lambda port: port.packet(0x10, [65536]), "word 65536; allowed 0..65535"),
    ],
)
def test_numbers_out_of_range_are_reported(stand, call, says):
    running, where = stand
    with ChipsetPort(*where) as port:
        with pytest.raises(ValueError) as raised:
            call(port)
        assert str(raised.value) == says
        port.ready(0)
        assert running.do(lambda: running.server.lines["x"].taken) == 2


# ---------------------------------------------------------------------------------------------------- who is at the end
def test_the_next_host_learns_the_owner_of_the_port(stand):
    _, where = stand
    with ChipsetPort(*where) as first:
        name = "{}:{}".format(*first.socket.getsockname())
        with pytest.raises(ConnectionError, match=f"slewline: {name} has this port; one host at a time"):
            ChipsetPort(*where)
        assert first.ready()


def test_nobody_is_there():
    with socket.socket() as nobody:
        nobody.bind(("127.0.0.1", 0))  # so that nobody else is
        with pytest.raises(ConnectionRefusedError):
            ChipsetPort(*nobody.getsockname())


@contextmanager
def speaking(server, says, ends=True):
    """A server that says something to whoever comes, and hangs up or stays silent."""
    connections = []

    def speak():
        connections.append(server.accept()[0])
        connections[0].send(says)
        if ends:
            connections[0].close()

    thread = threading.Thread(target=speak)
    thread.start()
    yield
    thread.join(PATIENCE)
    connections[0].close()


@pytest.mark.parametrize(
    ("says", "told"),
    [
        (b"SSH-2.0-x\r\n", "'SSH-2.0-x'; expected 'slewline registers 1 ...'"),
        (b"slewline registers 2 mc1451a 4\r\n", "'slewline registers 2 mc1451a 4'; expected"),
        (b"x" * 500, "'xxxxx"),
        (b"slew", "the server has closed the connection"),
    ],
)
def test_something_else_is_there(says, told):
    with socket.create_server(("127.0.0.1", 0)) as server, speaking(server, says):
        with pytest.raises(ConnectionError) as raised:
            ChipsetPort(*server.getsockname())
        assert told in str(raised.value)


def test_an_answer_that_does_not_come_closes_the_port():
    greeting = b"slewline registers 1 mc1451a 4\r\n"
    with socket.create_server(("127.0.0.1", 0)) as server, speaking(server, greeting, ends=False):
        port = ChipsetPort(*server.getsockname())
        port.socket.settimeout(0.01)
        with pytest.raises(TimeoutError):
            port.inp(STATUS)
        with pytest.raises(OSError, match="Bad file descriptor"):
            port.inp(STATUS)


@pytest.mark.system
def test_a_server_that_goes_away_is_reported(served):
    server, where, _ = served
    with ChipsetPort(*where) as port:
        assert port.ready()
        server.kill()
        with pytest.raises(ConnectionError):
            port.ready()
        with pytest.raises(OSError):  # closed
            port.ready()


# ------------------------------------------------------------------------------------------------------------- packets
DIALOGUE = (
    ("GET_VRSN", ()), ("SET_POS", (-12345,)), ("GET_POS", ()), ("SET_VEL", (0x40000,)), ("SET_ACC", (0x400,)),
    ("GET_STATUS", ()), ("SET_2", ()), ("SET_POS", (777,)), ("GET_POS", ()), ("GET_MODE", ()), ("GET_HOME", ()),
)  # fmt: skip


def test_the_calls_are_those_of_a_host_on_a_bench(stand):
    _, where = stand
    bench = slewline.Bench()
    virtual = bench.host(bench.add("mc1451a"))
    with ChipsetHost(*where) as host:
        for name, values in DIALOGUE:
            assert host.command(name, *values) == virtual.command(name, *values)
        assert host.query("GET_POS", axis=1) == virtual.query("GET_POS", axis=1) == -12345
        assert host.packet(0x4A, reads=2) == virtual.packet(0x4A, reads=2) == (0xFFFF, 0xCFC7)
        assert host.packet(0x39, checksum=False) == virtual.packet(0x39, checksum=False) == ()
        assert host.query("GET_POS") == virtual.query("GET_POS") == 0


def test_a_move_is_waited_for(stand):
    running, where = stand
    with ChipsetHost(*where) as host:
        for name, value in (("SET_POS", 1000), ("SET_VEL", 0x80000), ("SET_ACC", 0x8000)):
            host.command(name, value, axis=3)
        host.command("UPDATE")
        assert host.wait("in_motion", every=0) & 0x3400 == 0x2400  # axis 3
        assert host.wait("motion_complete", every=0) & 0x3401 == 0x2001
        assert host.wait("!in_motion") & 0x0400 == 0
        assert host.query("GET_TRGT_POS") == 1000
        for update in ("UPDATE", "MULTI_UPDATE"):
            host.command("SET_POS", 0 if update == "UPDATE" else 1000)
            host.command(update, *([4] if update == "MULTI_UPDATE" else []))
            assert host.wait("!in_motion", every=0) & 0x0400 == 0  # not before the cycle that works the update
            assert host.query("GET_TRGT_POS") == (0 if update == "UPDATE" else 1000)
        host.command("SET_VEL", "12345 steps/s")
        assert host.query("GET_VEL") == 265107
    assert running.do(lambda: running.bench["x"].axis(3).position) == 1000


def test_errors_in_a_packet_are_raised(stand):
    _, where = stand
    with ChipsetHost(*where) as host:
        with pytest.raises(
            slewline.ChecksumError, match=r"packet 22 to 127\.0\.0\.1:\d+: checksum 0000, expected 0022"
        ):
            host.packet(0x22)
        with pytest.raises(slewline.UsageError, match="SET_POS returns nothing"):
            host.query("SET_POS")
        with pytest.raises(slewline.UsageError, match="SET_POS position 1073741824: allowed"):
            host.command("SET_POS", 1 << 30)
        with pytest.raises(UnknownName, match="SET_5 is not a command of the MC1451A"):
            host.command("UPDATE", axis=5)
        with pytest.raises(UnknownName, match="no status bit 'moving'"):
            host.wait("moving")
        with pytest.raises(slewline.Timeout, match=r"waited 0 s for motion_complete; the status word is 0300"):
            host.wait("motion_complete", timeout=0)
        assert host.query("GET_VRSN") == 0x5C11


# ------------------------------------------------------------------------------------------------- another process
HOMING = """
import sys
from chipset_port import COMMAND, DATA, HOSTRDY, STATUS, ChipsetPort

assert not any(name.partition(".")[0] in ("slewline", "numpy") for name in sys.modules)
port = ChipsetPort(sys.argv[1], int(sys.argv[2]))

def ready():
    while not port.inp(STATUS) & HOSTRDY:
        pass

def word():
    found = 0
    for _ in range(2):
        ready()
        found = found << 8 | port.inp(DATA)
    return found

def command(code, *words, reads=0):
    ready()
    port.out(COMMAND, code)
    for each in words:
        for byte in each.to_bytes(2, "big"):
            ready()
            port.out(DATA, byte)
    found = [word() for _ in range(reads)]
    assert word() == (code + sum(words) + sum(found)) & 0xFFFF
    return found

def long(value):
    return divmod(value & 0xFFFFFFFF, 0x10000)

def until(bit):
    while not command(0x31, reads=1)[0] & bit:
        pass

print("version", f"{command(0x6C, reads=1)[0]:04x}", flush=True)
command(0x10, *long(-10**9))        # SET_POS
command(0x11, 16, 0)                # SET_VEL: 16 steps per cycle
command(0x12, 0, 0x4000)            # SET_ACC
command(0x1A)                       # UPDATE
until(0x0400)                       # in motion
command(0x46)                       # STOP, with the next update
command(0x5E)                       # SET_EXT_BRK: which a low HOME is
print("waits", flush=True)
until(0x0004)                       # breakpoint
until(0x0001)                       # motion complete
command(0x4D, 0, 0)                 # SET_ACTL_POS: zero is here
command(0x10, *long(20000))
command(0x33)                       # CLR_STATUS
command(0x1A)
until(0x0001)
high, low = command(0x1D, reads=2)  # GET_TRGT_POS
print("at", high << 16 | low)
for number in range(1000):
    assert port.packet(0x10, long(number))[0] == 0x10 + number
print("packets", 1000)
port.close()
"""


@pytest.fixture
def program(tmp_path):
    """The host program, beside a copy of the client; started without slewline in reach."""
    shutil.copy(chipset_port.__file__, tmp_path)
    (tmp_path / "homing.py").write_text(HOMING)

    def start(where):
        code = "import sys; sys.path.insert(0, sys.argv.pop(1)); import homing"
        command = [sys.executable, "-I", "-S", "-W", "error", "-c", code, str(tmp_path), where[0], str(where[1])]
        started.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
        return started[-1]

    started = []
    yield start
    for one in started:
        one.kill()
        one.communicate()


def position(ask):
    """Where the first axis is."""
    return ask("status")["chips"]["mc1451a"]["position"]


@pytest.mark.system
def test_a_host_program_homes_and_moves_in_real_time(serve, client, program):
    server = serve(*SERVED, ports=2)
    ask = Asks(client(server.ports["control"]))
    host = program(place(server.where))
    assert [host.stdout.readline() for _ in range(2)] == ["version 5c11\n", "waits\n"]
    until(lambda: position(ask) < -500)
    ask("drive", pin="mc1451a.home1", level=0)
    out, err = host.communicate(timeout=PATIENCE)
    assert err == ""
    found = dict(line.split() for line in out.splitlines())
    assert found == {"at": "20000", "packets": "1000"}
    chip = ask("status")["chips"]["mc1451a"]
    assert chip["position"] == 20000
    codes = {found["code"] for found in chip["findings"]}
    assert codes <= {"no-update"}  # its thousand packets set a position that no update takes
    assert server.end()[0] == 0


@pytest.mark.system
def test_a_host_program_that_is_killed_leaves_the_motion_and_makes_room(serve, client, program):
    server = serve(*SERVED, ports=2)
    ask = Asks(client(server.ports["control"]))
    first = program(place(server.where))
    assert [first.stdout.readline() for _ in range(2)] == ["version 5c11\n", "waits\n"]
    until(lambda: position(ask) < -500)
    first.kill()
    first.wait(PATIENCE)
    until(lambda: ask("status")["lines"]["mc1451a"]["host"] is None)
    assert ask("status")["chips"]["mc1451a"]["moving"] is True
    with ChipsetHost(*place(server.where)) as second:
        second.command("STOP")
        second.command("UPDATE")
        assert second.wait("motion_complete") & 0x0400 == 0
        assert second.query("GET_TRGT_POS") == position(ask) < -500
    assert server.end() == (0, "")
