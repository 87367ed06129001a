"""Host software with a Prologix GPIB controller, and chips on an IEEE-488 bus behind it."""

from __future__ import annotations

import socket
from time import monotonic

import pytest

import slewline
from slewline.bench.file import BenchFile
from slewline.cli.live.serve import open_bench_file
from slewline.cli.main import invoke
from slewline.errors import BenchFileError, UsageError
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.ports import prologix
from slewline.links.server import Server
from tests.rows import rows

from .conftest import PATIENCE, Client, Threaded

MOVE = b"A 0\nF 10\nR 10\nS 255\nZ 1\nN 20\n"


class Host(Client):
    """A host program on such a port."""

    def line(self):
        return self.read(b"\n").decode().removesuffix("\r\n")

    def tell(self, line):
        self.send(f"{line}\n".encode("latin-1"))

    def query(self, line):
        self.tell(line)
        return self.line()

    def bytes(self, number):
        found = b""
        while len(found) < number:
            data = self.socket.recv(number - len(found))
            assert data, found
            found += data
        return found

    def settled(self):
        """Everything before this is done."""
        return self.query("++ver").startswith("Prologix GPIB-ETHERNET Controller version ")

    def vanish(self):
        """Go without a word, as a process that is killed."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
        self.socket.close()


class Rig:
    """A server with chips behind a controller, and a host."""

    def __init__(self, *parts, rate=None, furnish=lambda bench: None, pty=None):
        self.bench = slewline.Bench()
        self.chips = [self.bench.add(part, f"x{number}") for number, part in enumerate(parts or ["cy525"])]
        furnish(self.bench)
        pace = Lockstep(self.bench) if rate is None else Paced(self.bench, rate)
        self.server = Server(self.bench, pace)
        self.line = self.server.line(*self.chips, prologix=True)
        self.sent = []
        self.bench.on_input.add(lambda do, what: self.sent.append(what) if what.get("verb") == "send" else None)
        port = self.server.tcp(self.line, "127.0.0.1:0") if pty is None else self.server.pty(self.line, pty)
        self.where, self.host = port.where, None
        self.thread = Threaded(self.server)

    def __enter__(self):
        self.thread.__enter__()
        if self.where.startswith("socket:"):
            self.host = Host(self.where)
        return self

    def __exit__(self, *error):
        if self.host is not None:
            self.host.close()
        self.thread.__exit__(*error)

    def codes(self):
        return [found.code for found in self.thread.do(lambda: self.bench.findings)]

    def position(self, number=0):
        return self.thread.do(lambda: self.chips[number].position)


# ------------------------------------------------------------------------------------------------------- what it takes
def test_a_chip_is_commanded_read_and_polled():
    with Rig() as rig:
        host = rig.host
        assert host.settled()
        host.tell("A 111\nV 0\n++read eoi")
        assert host.bytes(5) == b"00111"
        host.tell("N 513\nS 25\nR 127\nF 3\nZ 1\nV 3\n++read")
        assert host.bytes(6) == bytes.fromhex("02 01 19 7F 03 01")
        assert (host.query("++spoll"), host.query("++srq")) == ("255", "0")
        host.send(MOVE + b"G\nV 0\n++read eoi\n")  # the chip takes no V before it has moved
        assert host.bytes(5) == b"00020"
        assert rig.codes() == []


def test_the_end_of_a_motion_requests_service():
    with Rig(rate=5) as rig:
        host = rig.host
        host.send(MOVE.replace(b"20", b"400") + b"G\n++srq\n++spoll\n")  # in one go, while it moves
        assert (host.line(), int(host.line()) & 0x21) == ("0", 0x01)
        end = monotonic() + PATIENCE
        while host.query("++srq") == "0":
            assert monotonic() < end
        assert not int(host.query("++spoll")) & 0x01  # MOTION COMPLETE
        assert rig.position() == 400
        assert rig.codes() == []


@pytest.mark.parametrize(
    ("name", "usual", "value"),
    [
        ("addr", "5", "7"),
        ("auto", "0", "1"),
        ("eoi", "1", "0"),
        ("eos", "1", "3"),
        ("eot_enable", "0", "1"),
        ("eot_char", "0", "255"),
        ("mode", "1", "1"),
        ("read_tmo_ms", "500", "3000"),
        ("savecfg", "1", "0"),
    ],
)
def test_a_setting_is_reported_and_changed(name, usual, value):
    with Rig() as rig:
        assert rig.host.query(f"++{name}") == usual
        rig.host.tell(f"++{name} {value}")
        assert rig.host.query(f"++{name}") == value
        assert rig.codes() == ["gpib-address"] * (name == "addr")  # no device has 7


def test_a_secondary_address_is_reported_again():
    with Rig() as rig:
        rig.host.tell("++addr 5 96")
        assert rig.host.query("++addr") == "5 96"
        rig.host.tell("A 7\nV 0\n++read eoi")
        assert rig.host.bytes(5) == b"00007"


NO_COMMANDS = [
    *("++", "++nothing", "++read_tmo", "++readeoi", "++read_tmo_ms 0", "++read_tmo_ms 3001", "++read 256"),
    *("++addr 31", "++addr -1", "++addr 5 95", "++addr 5 96 7", "++addr x", "++auto 2", "++eos 4", "++mode 0"),
    *("++read eoi eoi", "++spoll 31", "++trg 31", "++trg" + " 5" * 16, "++srq 1", "++ver 1", "++rst 1", "++clr 5"),
    *("++ifc 5", "++help me", "++eoi 1 1", "++eot_char 0x0d", "++read_tmo_ms ²"),
]


def test_an_unknown_command_is_refused(subtests):
    for line in NO_COMMANDS:
        with subtests.test(line=line), Rig() as rig:
            assert rig.host.query(line) == "Unrecognized command"
            assert rig.host.settled()
            assert rig.codes() == ["gpib-command"]
            (found,) = rig.thread.do(lambda: rig.bench.findings)
            assert "; allowed " in found.text
            assert rig.host.query("++read_tmo_ms") == "500"


def test_the_commands_are_listed():
    with Rig() as rig:
        rig.host.tell("++help\n++ver")
        listed = []
        while not (line := rig.host.line()).startswith("Prologix"):
            listed.append(line.split()[0].removeprefix("++"))
        assert listed == sorted({*prologix.COMMANDS, *prologix.SETTINGS})


@pytest.mark.parametrize("address", [5, 7])
def test_an_address_without_a_device_is_a_finding_that_lists_the_devices(address):
    with Rig() as rig:
        rig.host.tell(f"++addr {address}")
        rig.host.settled()
        found = [each.text for each in rig.bench.findings if each.code == "gpib-address"]
    assert found == ([] if address == 5 else ["++addr 7: no device has this address; devices are at 5"])


@pytest.mark.parametrize(
    ("line", "eos", "data"),
    [
        (b"C\n", 1, b"C\r"),
        (b"C\r\n", 1, b"C\r"),
        (b"C\n\r", 0, b"C\r\n"),
        (b"C\n", 2, b"C\n"),
        (b"C\x1b\r\n", 3, b"C\r"),
        (b"\x1b+\x1b\r\n", 3, b"+\r"),
        (b"\x1b+\x1b+ver\n", 3, b"++ver"),
        (b"W\x01\x1b\n\n", 3, b"W\x01\n"),
        (b"\x1b\x1b\x1bA\n", 3, b"\x1bA"),
        (b" ++ver\n", 3, b" ver"),
    ],
)
def test_data_are_sent_unchanged_or_escaped(line, eos, data):
    with Rig() as rig:
        rig.host.tell(f"++eos {eos}\n++addr 9")  # where no device is
        for byte in line:
            rig.host.send(bytes([byte]))
        assert rig.host.settled()
        assert [bytes(what["args"][0]) for what in rig.sent] == [data]
        assert ("gpib-plus" in rig.codes()) is (line == b" ++ver\n")


def test_a_poll_of_an_address_without_a_device_is_a_finding():
    with Rig() as rig:
        rig.host.tell("++spoll 9")
        assert rig.host.settled()
        (found,) = rig.thread.do(lambda: [each.text for each in rig.bench.findings if each.code == "gpib-address"])
    assert found.startswith("++spoll 9: no device has this address; devices are at ")


def test_telnet_is_named():
    with Rig() as rig:
        rig.host.send(b"\xff\xfb\x1f\xff\xfb\x20\xff\xfd\x03A 0\n")
        assert rig.host.settled()
        found = rig.thread.do(lambda: [each.text for each in rig.bench.findings if each.code == "telnet"])
    assert found == [
        "the host negotiates options (bytes ff fb to fe), which a module mistakes for commands; this looks like "
        "telnet: use a raw connection"
    ]


def test_a_line_that_is_too_long_is_not_sent():
    with Rig() as rig:
        rig.host.send(b"A" * 5000 + b"\n++addr\n")
        assert rig.host.line() == "5"
        assert rig.codes() == ["gpib-line"]
        assert rig.sent == []


@rows("length", (4097, 4159, 4160))
def test_a_line_is_too_long_from_4097_bytes_on_however_it_is_cut(length):
    with Rig() as rig:
        for size in (4096, length):
            rig.host.send(b"A" * size + b"\n++addr\n")
            assert rig.host.line() == "5"
        assert [len(bytes(what["args"][0]).rstrip()) for what in rig.sent] == [4096]
        assert rig.codes().count("gpib-line") == 1


def test_a_line_that_became_too_long_while_a_branch_was_shown_is_not_sent():
    with Rig() as rig:

        def resume():
            assert rig.line.whole(b"A" * 5000) == b""
            line = rig.line.whole(b"\n")
            for piece in (line[:-1], line[-1:]):
                rig.line.feed(piece)

        rig.thread.do(resume)
        assert rig.codes() == ["gpib-line"]
        assert rig.sent == []


# -------------------------------------------------------------------------------------------------------------- reading
def test_a_read_ends_at_a_character_or_at_the_end_of_the_group():
    with Rig() as rig:
        host = rig.host
        host.tell("++eot_enable 1\n++eot_char 33\nA 12345\nV 0\n++read 51")  # the digit 3
        assert host.bytes(3) == b"123"
        host.tell("++read eoi\n++srq")
        assert host.bytes(3 + 3) == b"45!0\r\n"
        assert rig.codes() == []


def test_an_empty_read_ends_after_a_pause_of_virtual_time():
    with Rig() as rig:
        host = rig.host
        host.tell("++addr 9\n++read_tmo_ms 2000\n++read eoi")
        assert host.query("++srq") == "0"
        assert 2000 * 10**9 <= rig.thread.do(lambda: rig.bench.now_ps) < 2100 * 10**9
        host.tell("++spoll")  # is not answered either
        assert host.query("++srq") == "0"
        assert 4000 * 10**9 <= rig.thread.do(lambda: rig.bench.now_ps) < 4200 * 10**9


def test_a_chip_that_moves_is_not_waited_for_longer_than_that():
    with Rig() as rig:
        host = rig.host
        host.send(b"++read_tmo_ms 20\nV 0\n" + MOVE.replace(b"A 0\n", b"") + b"G\n++read eoi\n")
        assert not int(host.query("++spoll")) & 0x20  # READY is low
        host.tell("++read_tmo_ms 3000\n++read eoi")
        assert len(host.bytes(5)) == 5
        assert "verify-overrun" not in rig.codes()


def test_a_chip_without_a_selected_output_returns_a_byte_and_reports_it():
    with Rig() as rig:
        rig.host.tell("++read eoi")
        assert rig.host.bytes(1) == b"\xff"
        rig.host.tell("V 2\n++read eoi\n++read eoi")
        assert rig.host.bytes(7)[6:] == b"\xff"
        assert rig.codes() == ["verify-without-v", "verify-overrun"]


def test_a_program_that_is_entered_selects_nothing():
    with Rig() as rig:
        rig.host.tell("A 5\nV 0\nE\nV 1\n++eos 3\nQ\n++eos 1\n++read eoi\n++srq")
        assert rig.host.bytes(5 + 3)[5:] == b"0\r\n"
        assert rig.codes() == []


def test_in_binary_the_position_has_two_bytes():
    with Rig(furnish=lambda bench: bench.pin("x0.ascii_binary").drive(0)) as rig:
        rig.host.send(b"++eos 3\nA\x02\x2c\x01\nV\x01\x00\n++read eoi\n++srq\n")
        assert rig.host.bytes(5) == b"\x01\x2c0\r\n"
        assert rig.codes() == []


def test_each_line_of_data_is_followed_by_a_read_if_that_is_wanted():
    with Rig() as rig:
        rig.host.tell("A 42\n++auto 1\nV 0")
        assert rig.host.bytes(5) == b"00042"


# -------------------------------------------------------------------------------------------------------- the interface
def test_a_motion_is_paused_by_clear_and_resumed_with_trigger():
    with Rig() as rig:
        host = rig.host
        host.send(MOVE + b"++clr\nG\n++read_tmo_ms 3000\n++read eoi\n")
        assert not int(host.query("++spoll")) & 0x20
        assert rig.position() == 0
        host.tell("++trg\nV 0\n++read eoi")
        assert host.bytes(5) == b"00020"


def test_interface_clear_aborts_the_current_transfer():
    with Rig(rate=1) as rig:
        host = rig.host
        host.send(MOVE + b"++clr\nG\nV 0\n++srq\n")  # the chip takes no V, so nothing is answered
        rig.thread.until(lambda: rig.bench.now_ps > 200 * 10**9)
        host.tell("++ifc\n++spoll")
        assert host.line() == "223"  # not what ++srq asked for; READY is low
        host.tell("++trg")
        assert host.settled()


def test_kept_settings_survive_a_reset():
    with Rig() as rig:
        host = rig.host
        host.tell("++eos 3\n++savecfg 0\n++addr 7\n++auto 1\n++rst")
        assert [host.query(f"++{name}") for name in ("eos", "addr", "auto", "savecfg")] == ["3", "5", "0", "0"]
        host.tell("++addr 9\n++savecfg 1\n++rst")
        assert host.query("++addr") == "9"


def test_local_messages_reach_a_device_that_knows_none():
    with Rig() as rig:
        rig.host.tell("++loc\n++llo\nA 5\nV 0\n++read eoi")
        assert rig.host.bytes(5) == b"00005"
        assert rig.codes() == []


# ------------------------------------------------------------------------------------------------------------ circuits
def test_two_chips_share_a_bus():
    with Rig("cy525", "cy525") as rig:
        rig.host.tell("A 111\n++addr 6\nA 222\nV 0\n++addr 5\nV 0\n++read eoi\n++addr 6\n++read eoi")
        assert rig.host.bytes(10) == b"0011100222"
        assert (rig.position(0), rig.position(1)) == (111, 222)
        assert rig.codes() == []


def own(bench):
    bench.part("gpib_device", "left", to="x0", address=12)
    bench.part("gpib_controller", "pc", to="left")


def test_devices_and_controller_of_the_bench_are_used():
    with Rig("cy525", "cy525", furnish=own) as rig:
        assert list(rig.line.devices) == [12, 5]
        assert rig.line.controller is rig.bench["pc"]
        rig.host.tell("A 3\n++addr 5\nA 4\n++addr 12\nV 0\n++read eoi")
        assert rig.host.bytes(5) == b"00003"
        assert rig.position(1) == 4


def twice(bench):
    for name in ("x0", "x1"):
        bench.part("gpib_device", f"device_{name}", to=name, address=9)


@pytest.mark.parametrize(
    ("parts", "furnish", "says"),
    [
        (["cy525", "cy525"], twice, "x0 and x1: both have address 9; give each its own address"),
        (["cy525"], lambda bench: bench.part("gpib_listener", "ear", to="x0"), "ear has no address, and cannot answer"),
        (["gs-c200s"], lambda bench: None, "x0 has no port for a GPIB interface; leave out prologix"),
        (["cy545"], lambda bench: None, "x0 has no port for a GPIB interface"),
    ],
)
def test_a_circuit_that_does_not_fit_is_refused(parts, furnish, says):
    with pytest.raises(UsageError, match=says):
        Rig(*parts, furnish=furnish)


def test_a_bench_file_serves_a_bus(tmp_path):
    path = tmp_path / "bus.toml"
    rows = '[[chip]]\npart = "cy525"\nname = "x"\n[[serve]]\ntcp = "127.0.0.1:0"\nprologix = true\n'
    path.write_text(rows)
    file = BenchFile(path)
    bench = file.load()
    assert [(port.framing, port.prologix) for port in file.served(bench)] == [(False, True)]
    server = Server(bench, Lockstep(bench))
    ((name, where),) = open_bench_file(server, file)
    assert (name, where.partition(":")[0]) == ("x (address 5)", "socket")
    server.close()
    path.write_text(f"{rows}framing = true\n")
    file = BenchFile(path)
    with pytest.raises(BenchFileError, match="framing given together with prologix"):
        file.served(file.load())


def test_the_command_line_has_one_protocol_on_a_port(capsys):
    assert invoke(["serve", "cy525", "--framing", "--prologix", "--tcp", "127.0.0.1:0"]) == 2
    assert "--framing and --prologix: a port can have only one of the two" in capsys.readouterr().err


# ---------------------------------------------------------------------------------------------------------- other hosts
def test_a_host_that_dies_leaves_the_next_one_its_own_answers():
    with Rig() as rig:
        rig.host.tell("A 77\nV 0\n++read eoi\n++help\n++help")
        rig.host.vanish()
        rig.host = Host(rig.where)
        assert rig.host.settled()
        assert rig.host.query("++addr") == "5"
        rig.host.tell("V 0\n++read eoi")
        assert rig.host.bytes(5) == b"00077"


def test_a_host_gets_no_answer_to_leftovers_of_its_predecessor():
    with Rig(rate=1) as rig:
        rig.thread.do(rig.server.pace.pause_time)
        rig.host.send(b"++addr 9\n++read_tmo_ms 300\n++read\n" + b"++srq\n" * 1000)  # more than may wait for the bus
        rig.thread.until(lambda: rig.line.queue.requests and rig.line.taken > 100)
        rig.host.close()
        rig.host = Host(rig.where)
        rig.thread.do(rig.server.pace.go)
        assert rig.host.settled()


def test_a_host_that_dies_while_the_bus_is_stuck_leaves_a_bus_that_can_be_cleared():
    with Rig(rate=1) as rig:
        rig.host.send(MOVE + b"++clr\nG\nV 0\n++srq\n")
        rig.thread.until(lambda: rig.bench.now_ps > 200 * 10**9)
        rig.host.vanish()
        rig.host = Host(rig.where)
        rig.host.tell("++ifc")
        assert rig.host.settled()


@pytest.mark.parametrize("request_", [b"GET / HTTP/1.1\r\n\r\n", b"++x / HTTP/1.1\r\n\r\n"])
def test_a_browser_reaches_no_device(request_):
    with Rig() as rig:
        rig.host.send(request_ + b"A 7\n")
        assert rig.host.read(None) == b""
        rig.host.close()
        rig.host = Host(rig.where)
        assert rig.host.settled()
        assert rig.sent == []


# --------------------------------------------------------------------------------------------------------- real clients
@pytest.fixture
def manager():
    """PyVISA-py."""
    pyvisa = pytest.importorskip("pyvisa")
    pytest.importorskip("pyvisa_py")
    manager = pyvisa.ResourceManager("@py")
    yield manager
    manager.close()


def session_of(manager, name):
    """The controller at a place, and the device at address 5 behind it."""
    controller = manager.open_resource(name)
    controller.write("++eos 1")  # the return that a CY525 waits for
    device = manager.open_resource("GPIB0::5::INSTR", write_termination="\r\n")
    controller.timeout = device.timeout = PATIENCE * 1000
    return controller, device


def converse(manager, name):
    """A whole session: parameters, a motion in both directions, service request, status, hold and release."""
    controller, device = session_of(manager, name)
    for command in ("A 0", "F 10", "R 10", "S 255", "Z 1", "N 20", "+", "G", "V 0"):
        device.write(command)
    assert device.read_bytes(5) == b"00020"
    assert device.read_stb() & 0x20
    device.clear()
    device.assert_trigger()
    for command in ("-", "G", "V 0"):
        device.write(command)
    assert device.read_bytes(5) == b"00000"
    controller.close()


def test_pyvisa_has_a_session_over_the_network(manager):
    with Rig(rate=20) as rig:
        rig.host.close()
        host, port = rig.where.removeprefix("socket://").split(":")
        converse(manager, f"PRLGX-TCPIP0::{host}::{port}::INTFC")
        assert rig.codes() == []
        assert len(rig.thread.do(rig.chips[0].steps)) == 40


@pytest.mark.system
@pytest.mark.posix
def test_pyvisa_has_a_session_over_a_device_file(manager, tmp_path):
    pytest.importorskip("serial")
    with Rig(rate=20, pty=str(tmp_path / "gpib")) as rig:
        converse(manager, f"PRLGX-ASRL0::{rig.where}::INTFC")
        assert rig.codes() == []
