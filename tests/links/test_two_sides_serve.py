"""A chip with two sides, served: characters on a pty, TCP or RFC 2217, and at the same time its bus as registers."""

from __future__ import annotations

import random
import threading

import pytest

import slewline
from slewline.cli.main import invoke
from slewline.links.clients.card_port import CONTROL, DRIVE, REQUEST, CardPort
from slewline.links.clients.chipset_port import DATA, IN, OUT, STATUS
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server

from .conftest import PATIENCE, Process, Threaded, patient

serial = pytest.importorskip("serial")
pytestmark = pytest.mark.filterwarnings("ignore:set(Daemon|Name)\\(\\) is deprecated:DeprecationWarning")
NOWHERE = "127.0.0.1:0"
READY, ANSWER, MESSAGE = 0x24, 0x34, 0x44


def card_of(where: str) -> CardPort:
    """Return the other end of a card, from where it is found: registers://HOST:PORT."""
    scheme, _, place = where.partition("://")
    assert scheme == "registers"
    host, port = place.rsplit(":", 1)
    return CardPort(host, int(port), PATIENCE)


@pytest.fixture
def both():
    """A chip x on a bench, and a server in lockstep with its bus on TCP."""
    bench = slewline.Bench()
    x = bench.add("cy545b", name="x")
    bench.part("ram", name="ram", to=x)
    server = Server(bench, Lockstep(bench))
    line = server.line(x, over="parallel")
    port = server.tcp(line, NOWHERE)
    serial_port = server.tcp(server.line(x, over="serial"), NOWHERE)
    with Threaded(server) as threaded:
        yield threaded, port.where, serial_port.where


# ------------------------------------------------------------------------------------------ registers
def test_the_registers_are_the_lines_of_the_handshake(both):
    threaded, where, _ = both
    x = threaded.bench.chips["x"]
    with card_of(where) as card:
        assert (card.part, card.axes) == ("cy545b", 1)
        assert card.inp(STATUS) == 0xFF  # BUSY and FPL high, the others open
        assert (card.inp(DATA), card.inp(CONTROL), card.inp(7)) == (0xFF, 0, 0xFF)
        card.out(DATA, 0x41)
        assert card.inp(DATA) == 0xFF  # a latch, which does not drive yet
        card.out(CONTROL, 0xF0 | DRIVE)
        assert (card.inp(DATA), card.inp(CONTROL)) == (0x41, DRIVE)
        assert threaded.do(lambda: x.pin("io_request").level) == 1
        card.out(CONTROL, REQUEST | DRIVE)
        assert threaded.do(lambda: x.pin("io_request").level) == 0
        assert card.exchange((ANSWER, 10))[0] == 0x7F
        card.out(CONTROL, 0)
        assert card.inp(DATA) == 0xFF
        assert card.exchange((READY, 10), (0x54, 1), (0x25, 0)) == b"\xff\xff\xff"


def test_a_program_does_the_handshake_byte_by_byte_and_reads_a_message(both):
    _, where, _ = both
    with card_of(where) as card:
        for byte in b"O 81H\r? R\r":
            while not card.inp(STATUS) & 0x80:
                pass
            card.out(DATA, byte)
            card.out(CONTROL, REQUEST | DRIVE)
            while card.inp(STATUS) & 0x80:
                pass
            card.out(CONTROL, 0)
        assert card.exchange((MESSAGE, 50))[0] & 0x40 == 0
        found = bytearray()
        while True:
            assert card.exchange((READY, 10))[0] & 0x80
            if card.inp(STATUS) & 0x40:
                break
            card.out(CONTROL, REQUEST)
            found += card.exchange((ANSWER, 10), (IN + DATA, 0), (OUT + CONTROL, 0))[1:2]
        assert found == b"R=00100\r"


def test_the_waits_end_in_time(both):
    threaded, where, _ = both
    with card_of(where) as card:
        start = threaded.do(lambda: threaded.bench.now_ps)
        assert card.exchange((MESSAGE, 20), (ANSWER, 30)) == b"\xff\xff"
        assert threaded.do(lambda: threaded.bench.now_ps) - start == pytest.approx(50 * 10**9, rel=0.001)
        with pytest.raises(TimeoutError, match="stays 0xff"):
            card.until(MESSAGE, 300, 0x40, 0)


def test_a_write_to_the_reset_register_resets_the_chip(both):
    threaded, where, _ = both
    with card_of(where) as card:
        card.command("R 9")
        card.free(100)
        card.out(8, 0)
        card.exchange((MESSAGE, 20))
        assert threaded.do(lambda: threaded.bench.chips["x"].registers["rate"]) == 100


def test_a_chipset_knows_neither_of_the_new_waits():
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench))
    port = server.tcp(server.line(bench.add("mc1451a")), NOWHERE)
    with Threaded(server):
        host, number = port.where.partition("://")[2].rsplit(":", 1)
        with CardPort(host, int(number)) as other:
            assert other.exchange((ANSWER, 1), (MESSAGE, 1)) == b"\xff\xff"


# -------------------------------------------------------------------------------------------------------- its other end
def test_the_other_end_enters_a_program_and_gives_it_commands_while_it_talks(both):
    threaded, where, _ = both
    with card_of(where) as card:
        card.command("O 81H")
        card.command("Y 0")
        card.enter('"tick"\nD 20\nJ 0')
        assert threaded.do(lambda: threaded.bench.parts["ram"].content[:18]) == b'"tick"\rD 20\rJ 0\r\xff\xff'
        card.command("Y 0")
        card.command("X")
        assert card.listen(100).startswith(b"tick")
        for number in range(20):
            card.command(f"R {number}")
            assert card.ask("? R") == f"R={number:05}"
        card.command("0")
        assert set(bytes(card.messages).split(b"tick")) <= {b""}
    assert threaded.do(lambda: [found.code for found in threaded.bench.findings]) == []


@pytest.mark.parametrize("query", ["? R", "?P", "? N", "? B", "? Y", "? M,2", "?M 3", "? M,1"])
def test_a_query_is_answered_as_in_the_process(both, query):
    threaded, where, _ = both
    bench, stored = slewline.Bench(), b"N 1\r\xa7\r\r"
    x = bench.add("cy545b")
    bench.part("ram", to=x).load(stored, 10)
    host = bench.host(x)
    host.send("O 81H\rY 10\r")
    bench.run_until_idle()
    with card_of(where) as card:
        card.command("O 81H")
        card.command("Y 10")
        threaded.do(lambda: threaded.bench.parts["ram"].load(stored, 10))
        assert card.ask(query) == host.ask(query)
        assert card.messages == b"" and card.ask("? R") == "R=00100"


def test_a_program_that_leaves_within_a_handshake_does_not_delay_the_next_one(both):
    _, where, _ = both
    with card_of(where) as card:
        card.out(CONTROL, REQUEST)
    with card_of(where) as card:
        assert card.inp(CONTROL) == 0
        card.command("O 81H")
        assert card.ask("? R") == "R=00100"


def test_a_query_whose_answer_goes_elsewhere_is_a_timeout(both):
    _, where, _ = both
    with card_of(where) as card, pytest.raises(TimeoutError):
        card.ask("? R", 300)


def test_both_sides_at_the_same_time_from_two_programs(both):
    threaded, where, serial_where = both
    chance = random.Random(545)
    port = serial.serial_for_url(serial_where, timeout=PATIENCE)
    port.write(b"\r\rO 0A0H\r")  # with CTS, for the other program may dawdle within a command
    wrong = []

    def over_the_line() -> None:
        for number in range(60):
            port.write(b"? S\r")
            answer = port.read_until(b"\r")
            if answer != b"S=00220\r":
                wrong.append((number, answer))

    thread = threading.Thread(target=over_the_line)
    with card_of(where) as card:
        thread.start()
        for _ in range(150):
            card.command(chance.choice(["R 5", "B 16", "B 0", "D 1"]))
        thread.join(PATIENCE)
    port.close()
    assert wrong == [] and threaded.do(lambda: [found.code for found in threaded.bench.findings]) == []


@pytest.mark.fact("CY545-UND-TWO-SIDES")
def test_a_program_that_leaves_after_the_empty_handshake_leaves_the_line_its_chip(both):
    _, where, serial_where = both
    with card_of(where) as card:
        card.empty()
    port = serial.serial_for_url(serial_where, timeout=PATIENCE)
    port.write(b"\r\r? R\r")
    assert port.read_until(b"\r") == b"R=00100\r"
    port.close()


def test_in_lockstep_characters_waiting_after_a_command_of_the_bus_are_performed(both):
    threaded, where, serial_where = both
    x, line = threaded.bench.chips["x"], threaded.server.lines["x_serial"]
    port = serial.serial_for_url(serial_where, timeout=PATIENCE)
    with card_of(where) as card:
        port.write(b"\r\r")
        threaded.until(lambda: x.baud)
        card.command("D 300")
        port.write(b"+\r")
        threaded.until(lambda: line.taken == 4 and line.wait is None)
        assert threaded.do(lambda: x.pin("ccw").level) == 0
    port.close()


# ------------------------------------------------------------------------------------------ the command
@pytest.mark.system
@pytest.mark.parametrize("kind", ["pty", "tcp", "rfc2217"])
def test_the_command_serves_both_sides_of_a_chip(serve, tmp_path, kind):
    place = str(tmp_path / "line") if kind == "pty" else NOWHERE
    process = serve("cy545b", "--lockstep", f"--{kind}", place, "--registers", NOWHERE, ports=2)
    assert list(process.ports) == ["cy545b_serial", "cy545b_parallel"]
    port = serial.serial_for_url(patient(process.ports["cy545b_serial"]), 9600, timeout=PATIENCE)
    with card_of(process.ports["cy545b_parallel"]) as card:
        card.command("R 77")
        port.write(b"\r\r? R\r")
        assert port.read_until(b"\r") == b"R=00077\r"
        port.write(b"R 78\r? R\r")
        assert port.read_until(b"\r") == b"R=00078\r"
        card.command("O 81H")
        assert card.ask("? R") == "R=00078"
    port.close()
    assert process.end() == (0, "")


@pytest.mark.system
def test_one_side_alone_is_served_too(serve):
    process = serve("cy545", "--lockstep", "--registers", NOWHERE)
    with card_of(process.where) as card:
        card.command("O 81H")
        assert card.part == "cy545" and card.ask("? N") == "N=00000200"


@pytest.mark.system
@pytest.mark.parametrize("baud", [300, 2400, 19200])
def test_over_rfc_2217_the_rate_of_the_host_is_that_of_the_line(serve, baud):
    process: Process = serve("cy545b", "--lockstep", "--rfc2217", NOWHERE)
    port = serial.serial_for_url(patient(process.where), baud, timeout=1 if baud == 300 else PATIENCE)
    port.write(b"\r\r? R\r")
    if baud == 300:
        assert port.read(1) == b""  # at 12 MHz it is none of the rates
    else:
        assert port.read_until(b"\r") == b"R=00100\r"
    port.close()


@pytest.mark.system
@pytest.mark.parametrize(
    ("kind", "rtscts", "kept"),
    [("rfc2217", True, True), ("rfc2217", False, False), ("pty", True, True), ("tcp", None, True)],
)
def test_cts_stops_the_characters_of_a_host_that_requests_it(serve, tmp_path, kind, rtscts, kept):
    place = str(tmp_path / "line") if kind == "pty" else NOWHERE
    process = serve("cy545b", "--lockstep", f"--{kind}", place)
    port = serial.serial_for_url(patient(process.where), 9600, timeout=PATIENCE, rtscts=bool(rtscts))
    port.write(b"\r\rO 0A0H\rD 100\rR 1\rR 2\rR 3\r? R\r")
    if kept:
        assert port.read_until(b"\r") == b"R=00003\r"
    while not kept and "serial-overrun" not in process.errors():
        pass
    port.close()
    code, text = process.end()
    assert code == 0 and not (kept and "serial-overrun" in text)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("gs-c200", "--registers", NOWHERE), "--registers is for a chip with a bus and a serial line"),
        (("mc1451a", "--registers", NOWHERE), "a mc1451a is served with --tcp, --pty"),
        (("cy545b", "--tcp", NOWHERE, "--pty", "x"), "a chip has one port"),
        (("cy545b",), "no port given; give one of --tcp, --pty, --rfc2217, --serial, or --registers for its bus"),
        (("cy545b", "--tcp", NOWHERE, "--framing"), "leave out framing"),
        (("cy545b", "--registers", NOWHERE, "--framing"), "leave out framing"),
    ],
)
def test_refusals_of_the_command(capsys, arguments, text):
    assert invoke(["serve", *arguments]) != 0
    assert text in " ".join(capsys.readouterr().err.split())


# ------------------------------------------------------------------------------------------ bench files
FILE = """
[[chip]]
part = "cy545b"
name = "x"

[[part]]
kind = "ram"
to = "x"

[[serve]]
over = "serial"
tcp = "127.0.0.1:0"

[[serve]]
over = "{over}"
tcp = "127.0.0.1:0"
"""


@pytest.mark.system
def test_a_bench_file_serves_both_sides(serve, tmp_path):
    path = tmp_path / "both.toml"
    path.write_text(FILE.format(over="parallel"))
    process = serve("--bench", path, "--lockstep", ports=2)
    port = serial.serial_for_url(process.ports["x_serial"], timeout=PATIENCE)
    with card_of(process.ports["x_parallel"]) as card:
        card.command("S 44")
        port.write(b"\r\r? S\r")
        assert port.read_until(b"\r") == b"S=00044\r"
    port.close()


@pytest.mark.parametrize(
    ("over", "text"), [("serial", "x has a host or a port already"), ("bus", "these channels: parallel, serial")]
)
def test_mistakes_of_a_bench_file_are_reported_with_their_line(capsys, tmp_path, over, text):
    path = tmp_path / "both.toml"
    path.write_text(FILE.format(over=over))
    assert invoke(["serve", "--bench", str(path)]) != 0
    told = capsys.readouterr().err
    assert text in told and "both.toml, line" in told
