"""Requests in one message, and hosts that do not wait for what they can foresee: the same as one by one."""

from __future__ import annotations

import json
import random
import shutil
import subprocess

import pytest

import slewline
from slewline.links.clients.card_port import CardPort
from slewline.links.clients.chipset_port import COMMAND, DATA, HOSTRDY, RESET, STATUS, ChipsetPort
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.ports import register_port
from slewline.links.server import Server
from tests.ensembles import few

from .conftest import PATIENCE, Asks, Threaded

MS, CYCLE = 10**9, 750_000  # picoseconds
PINS = ("hostslct", "hostcmd", "hostwrite", "hostread", "hostrdy", "reset")
PACKET = "2464 1210 2464 1000 1000 2464 1030 1039 2464 0000 0000"
VERSION = "2464 126c 2464 0000 0000 2464 0000 0000"
EXAMPLES = __file__.partition("tests")[0] + "examples/mc1451a"
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


class Stand:
    """A chipset x in lockstep, or paced, on a bench that records the pins of its host port."""

    def __init__(self, client, rate=None, part="mc1451a", over=None, **options):
        log = options.pop("log", None)
        self.bench = slewline.Bench(**options)
        self.x = self.bench.add(part, name="x")
        self.server = Server(self.bench, Lockstep(self.bench) if rate is None else Paced(self.bench, rate), log)
        self.line = self.server.line(self.x, over=over)
        self.port = self.server.tcp(self.line, "127.0.0.1:0")
        self.control = self.server.control("127.0.0.1:0")
        if over is None:
            self.bench.record(*(f"x.{pin}" for pin in PINS))
        self.client = client
        self.running = Threaded(self.server)

    @property
    def place(self):
        host, port = self.port.where.rpartition("//")[2].rsplit(":", 1)
        return host, int(port)

    def host(self):
        return Host(self.client(self.port.where))

    def asks(self):
        return Asks(self.client(self.control.where))

    def seen(self):
        """All that can be seen of what a host has done: edges, findings, the time."""
        return self.running.do(self._seen)

    def _seen(self):
        edges = {pin: [list(map(int, found)) for found in self.bench.edges(f"x.{pin}")] for pin in PINS}
        found = [(one.time_ps, one.source, one.code, one.text) for one in self.bench.findings]
        return {"edges": edges, "findings": found, "now": self.bench.now_ps}


class Host:
    """A host on the port; requests in hexadecimal."""

    def __init__(self, client):
        self.client = client
        self.greeting = client.read(b"\n")

    def send(self, *requests):
        self.client.send(b"".join(bytes.fromhex(each) for each in requests))

    def ask(self, requests):
        """One by one: each request waits for the answer to the one before."""
        data = bytes.fromhex(requests)
        found = b""
        for at in range(0, len(data), 2):
            self.client.send(data[at : at + 2])
            found += self.answers(1)
        return found

    def series(self, requests, kind=0xC0):
        data = bytes.fromhex(requests)
        self.client.send(bytes([kind, len(data) // 2]) + data)
        return self.answers(len(data) // 2)

    def answers(self, number):
        found = b""
        while len(found) < number:
            more = self.client.socket.recv(number - len(found))
            assert more, "the server has closed the connection"
            found += more
        return found

    def polled(self, request):
        """An access of a host that polls; the answers, polls included."""
        found = b""
        while not (found and found[-1] & HOSTRDY):
            found += self.ask("0400")
        return found + self.ask(request)


@pytest.fixture
def stand(client):
    """Make stands; they run until the test is over."""
    made = []

    def make(**options):
        made.append(Stand(client, **options))
        made[-1].running.__enter__()
        return made[-1]

    yield make
    for one in made:
        one.running.__exit__()


@pytest.fixture
def older(monkeypatch):
    """Servers from now on know no series."""
    monkeypatch.setattr(register_port, "HELLO", None)
    monkeypatch.setattr(register_port, "SERIES", None)
    monkeypatch.setattr(register_port, "ON", None)
    monkeypatch.setattr(register_port, "POLL", None)


# ------------------------------------------------------------------------------------------------------------ messages
def test_a_host_queries_the_version_of_its_server(stand):
    for rate, answer in ((None, b"\x82"), ("1", b"\x02")):
        one = stand(rate=rate)
        host = one.host()
        assert host.greeting == b"slewline registers 1 mc1451a 4\r\n"
        assert host.ask("9002") == host.ask("9000") == answer
        assert one.seen()["findings"] == []


@pytest.mark.parametrize(
    "requests",
    [
        PACKET,
        VERSION,
        "0400 126c 0400 0400 0000 0000 0400",
        "1210 1000 1000 2464 1210 0400",
        "1800 24ff 0400",
        "0100 0f00",
    ],
)
def test_a_series_is_what_its_requests_are_one_by_one(stand, requests):
    one, other = stand(), stand()
    hosts = one.host(), other.host()
    for _ in range(2):
        assert hosts[0].series(requests) == hosts[1].ask(requests)
        assert one.seen() == other.seen()


def test_a_poll_in_a_series_is_the_loop_of_a_host_that_polls(stand):
    one, other = stand(), stand()
    first, second = one.host(), other.host()
    for access in ("1210", "1000", "1000", "1030", "1039", "0000", "0000", "1239", "126c", "0000"):
        found = first.series(f"5464 {access}")
        assert found == second.polled(access)[-2:]
        assert one.seen() == other.seen()  # 3.3 ms of polls behind RESET (39)


def test_a_failed_wait_ends_a_series_and_its_dependents(stand):
    one = stand()
    host = one.host()
    assert host.series(VERSION)[-2:] == b"\x5c\x7d"
    one.running.do(lambda: one.x.pin("reset").drive(0))
    begun = one.seen()["now"]
    assert host.series("0f00 540a 1210 0000") == b"\xff\x7f\xff\xff"
    assert 10 * MS <= one.seen()["now"] - begun < 11 * MS
    begun = one.seen()["now"]
    assert host.series("126c 0400", kind=0xC1) == b"\xff\xff"
    assert one.seen()["now"] == begun  # nothing is done
    assert host.series("2405 126c") == b"\x7f\xff"
    assert one.seen()["now"] == begun + 5 * MS + CYCLE
    one.running.do(lambda: one.x.pin("reset").release())
    assert host.series("126c", kind=0xC1) == b"\xff"
    assert host.series(VERSION) == bytes.fromhex("ff6c ff5c11 ff5c7d")
    assert host.series("0f00", kind=0xC1) == b"\xff"
    assert host.series("2464 126c", kind=0xC1) == b"\xff\x6c"  # the one before has come to its end
    assert codes(one) <= {"conflict", "no-register"}  # of the pin that is driven here


@pytest.mark.parametrize("wait", ["24ff", "54ff"])
def test_a_reset_in_the_middle_of_a_series(stand, wait):
    one = stand()
    host, ask = one.host(), one.asks()
    assert host.series(VERSION)[-2:] == b"\x5c\x7d"
    assert ask("drive", pin="x.reset", level=0).keys() == {"time_ps"}
    host.send("c004 2464 1210 1000 0000 c002 2464 126c")  # the second does not depend on the first
    assert host.answers(6) == b"\x7f\xff\xff\xff\x7f\xff"
    host.send(f"c005 {wait} 126c {wait} 0000 0000")
    ask("release", pin="x.reset")
    assert host.answers(5) == bytes.fromhex("7fff ffffff")  # all that was sent before
    assert host.series(f"{wait} 126c {wait} 0000 0000") == bytes.fromhex("ff6c ff5c11")
    assert codes(one) <= {"conflict", "no-register"}


def test_a_reset_between_the_bytes_of_a_word_is_what_it_is_one_by_one(stand):
    one, other = stand(), stand()
    hosts = one.host(), other.host()
    assert hosts[0].series("2464 1210 2464 1012 1800 1034 24ff 126c 2464 0000") == hosts[1].ask(
        "2464 1210 2464 1012 1800 1034 24ff 126c 2464 0000"
    )
    assert one.seen() == other.seen()


def test_series_may_come_in_any_pieces(stand):
    one, other = stand(), stand()
    hosts = one.host(), other.host()
    data = bytes.fromhex(PACKET)
    whole = b"\xc0" + bytes([len(data) // 2]) + data + b"\x04\x00"
    for byte in whole:
        hosts[0].client.send(bytes([byte]))
        one.running.do(lambda: None)
    hosts[1].client.send(whole)
    assert hosts[0].answers(len(data) // 2 + 1) == hosts[1].answers(len(data) // 2 + 1)
    assert one.seen() == other.seen()


def test_pieces_of_a_series_in_one_go_are_one_input_of_the_board(stand, tmp_path):
    one, other = stand(journal=tmp_path / "journal"), stand()
    hosts = one.host(), other.host()
    data = bytes.fromhex(PACKET)
    pieces = [bytes([0xC1 if at else 0xC0, 1]) + data[at : at + 2] for at in range(0, len(data), 2)]
    hosts[0].client.send(b"".join(pieces))
    assert hosts[0].answers(len(data) // 2) == hosts[1].ask(PACKET)
    assert one.seen() == other.seen()
    now = one.seen()["now"]
    one.server.stop()
    one.running.thread.join(PATIENCE)
    entries = [json.loads(line) for line in (tmp_path / "journal").read_text().splitlines()]
    assert [entry["verb"] for entry in entries if entry.get("do") == "input"] == ["series"]
    again = slewline.replay(tmp_path / "journal", prepare=lambda bench: bench.record("x.hostwrite"))
    assert again.now_ps == now
    assert list(again.edges("x.hostwrite")[0]) == other.seen()["edges"]["hostwrite"][0]


def test_the_transcript_has_each_access_at_its_time(stand, tmp_path):
    one, other = stand(log=tmp_path / "one"), stand(log=tmp_path / "other")
    one.host().series(PACKET)
    other.host().ask(PACKET)
    for each in (one, other):
        each.server.stop()
        each.running.thread.join(PATIENCE)
    accesses = [
        [line for line in (tmp_path / name).read_text().splitlines() if " ! " not in line] for name in ("one", "other")
    ]
    assert accesses[0] == accesses[1]
    assert len(accesses[0]) == 8  # five bytes written, two read, and HostRdy once


# ------------------------------------------------------------------------------------ what is wrong, and who comes next
@pytest.mark.parametrize(
    ("message", "number", "came"),
    [
        ("c003 126c 2064 0400", 3, r"b' d' (text, it seems) in a series is"),
        ("c002 126c 3464", 2, "b'4d' (text, it seems) in a series is"),  # a parallel card has it
        ("c001 9002", 1, r"b'\x90\x02' in a series is"),
        ("c002 c001 0400", 2, r"b'\xc0\x01' in a series is"),
        ("c000", 1, r"b'\xc0\x00' is"),
        ("9102", 1, r"b'\x91\x02' is"),
    ],
)
def test_an_invalid_request_is_reported_and_the_answers_stay_in_step(stand, message, number, came):
    one = stand()
    host = one.host()
    host.ask("2464")
    begun = one.seen()["now"]
    host.send(message)
    assert host.answers(number) == b"\xff" * number
    assert one.seen()["now"] == begun
    host.send(message, "2464")
    assert host.answers(number + 1) == b"\xff" * (number + 1)
    ((_, source, code, text),) = one.seen()["findings"]  # once for each host
    assert (source, code) == ("x_isa", "no-request")
    assert text.startswith(f"{came} not a request, and reads FF: ")
    assert ("none of the series is executed" in text) is ("series" in came)
    assert host.series(VERSION)[-2:] == b"\x5c\x7d"


def test_a_host_that_leaves_in_the_middle_of_a_series_has_done_none_of_it(stand, tmp_path):
    one = stand(log=tmp_path / "log")
    first = one.host()
    first.send("c00b", PACKET[:22])
    first.client.close()
    second = one.host()
    assert second.series(VERSION) == bytes.fromhex("ff6c ff5c11 ff5c7d")
    assert len(one.seen()["edges"]["hostwrite"][0]) == 2  # 6c alone
    assert "the previous host left an incomplete request, c00b 2464 1210 2464" in (tmp_path / "log").read_text()


def test_commands_of_a_host_are_processed_after_it_has_left_and_the_next_gets_its_own_answers(stand):
    one = stand()
    first = one.host()
    first.send("c001 1210", "c102 54ff 1000")
    first.client.close()
    second = one.host()
    assert second.series("54ff 1000") == b"\xff\x00"
    assert len(one.seen()["edges"]["hostwrite"][0]) == 6


def test_two_chipsets_have_their_hosts_at_the_same_time(client):
    bench = slewline.Bench()
    server = Server(bench, Lockstep(bench))
    ports = [server.tcp(server.line(bench.add("mc1451a", name=name)), "127.0.0.1:0") for name in "ab"]
    with Threaded(server):
        hosts = [Host(client(port.where)) for port in ports]
        for number in range(20):
            for place, host in enumerate(hosts):
                host.send(f"c00b 2464 1210 2464 1000 1000 2464 10{place:02x} 10{number:02x} 2464 0000 0000")
            for place, host in enumerate(hosts):
                assert host.answers(11)[-2:] == bytes([place, 0x10 + number])


# ------------------------------------------------------------------------------------------------------------- clients
def codes(one):
    """What was found, by its codes."""
    return {found[2] for found in one.seen()["findings"]}


def ready(port):
    while not port.inp(STATUS) & HOSTRDY:
        pass


def by_bytes(port):
    """SET_POS 12345, with a poll before each byte."""
    found = []
    for register, byte in (
        (COMMAND, 0x10),
        (DATA, 0),
        (DATA, 0),
        (DATA, 0x30),
        (DATA, 0x39),
        (DATA, None),
        (DATA, None),
    ):
        ready(port)
        found.append(port.inp(register) if byte is None else port.out(register, byte))
    return found[-2:]


def by_words(port):
    """GET_VRSN, with a poll before each word."""
    ready(port)
    port.out(COMMAND, 0x6C)
    found = []
    for _ in range(2):
        ready(port)
        found += [port.inp(DATA), port.inp(DATA)]
    return found


def without_polls(port):
    """A host that does not look: HostRdy is low for half of it."""
    for byte in (0x10, 0x6C):
        port.out(COMMAND, byte)
    return [port.inp(DATA), port.inp(DATA), port.inp(STATUS), port.inp(STATUS), port.inp(STATUS)]


def broken_off(port):
    """A packet is broken off in mid-word, and another one begins."""
    ready(port)
    port.out(COMMAND, 0x10)
    ready(port)
    port.out(DATA, 0x12)
    return [port.inp(STATUS), *by_words(port)]


def reset(port):
    """RESET as a command, and as a register."""
    ready(port)
    port.out(COMMAND, 0x39)
    found = by_words(port)
    port.out(RESET, 0)
    return [*found, port.inp(STATUS), *by_words(port)]


def one_poll(port):
    """One poll at a time, whatever it says; then too many."""
    ready(port)
    port.out(COMMAND, 0x6C)
    found = [port.inp(STATUS), port.inp(1), port.inp(STATUS), port.inp(STATUS), port.inp(STATUS)]
    return [*found, port.inp(DATA), port.inp(STATUS), port.inp(DATA), port.inp(STATUS), port.ready(), port.inp(STATUS)]


def in_messages(port):
    """Byte by byte and in messages by turns."""
    found = [*by_bytes(port), port.packet(0x4A, reads=3), port.inp(STATUS), *by_words(port)]
    port.out(COMMAND, 0x6C)
    return [*found, port.packet(0x6C, reads=2), port.exchange((0x04, 0), (0x12, 0x6C)), port.ready(), *by_words(port)]


PROGRAMS = (by_bytes, by_words, without_polls, broken_off, reset, one_poll, in_messages)


@pytest.mark.parametrize("program", PROGRAMS)
def test_a_host_that_foresees_answers_is_one_that_waits_for_them(stand, program):
    one, other = stand(), stand()
    with ChipsetPort(*one.place) as port, ChipsetPort(*other.place, plain=True) as plain:
        for _ in range(3):
            assert program(port) == program(plain)
            assert one.seen() == other.seen()


@pytest.mark.parametrize("seed", few(range(5), 2))
def test_the_same_for_any_host(stand, seed):
    one, other = stand(), stand()
    chance = random.Random(seed)
    with ChipsetPort(*one.place) as port, ChipsetPort(*other.place, plain=True) as plain:
        for _ in range(400):
            kind, register, byte = (
                chance.choice("iiooppr"),
                chance.choice((0, 0, 0, 2, 4, 5)),
                chance.choice((0x6C, 0x10, 0x4A, chance.randrange(256))),
            )
            calls = {
                "i": lambda port: port.inp(register),  # noqa: B023
                "o": lambda port: port.out(register, byte),  # noqa: B023
                "p": ready,
                "r": lambda port: port.inp(STATUS),
            }
            assert calls[kind](port) == calls[kind](plain)
        assert one.seen() == other.seen()


def counted(port, monkeypatch):
    """Count how often a port waits for an answer."""
    waits = []
    read = port._read
    monkeypatch.setattr(port, "_read", lambda number: waits.append(number) or read(number))
    return waits


def test_a_packet_byte_by_byte_waits_for_the_bytes_that_it_reads(stand, monkeypatch):
    with ChipsetPort(*stand().place) as port:
        by_bytes(port)
        waits = counted(port, monkeypatch)
        assert by_bytes(port) == [0x30, 0x49]
        assert len(waits) == 2


def test_a_packet_is_one_message(stand, monkeypatch):
    one = stand()
    with ChipsetPort(*one.place) as port:
        port.packet(0x6C, reads=2)
        waits, before = counted(port, monkeypatch), one.running.do(lambda: one.line.taken)
        assert port.packet(0x10, (0, 12345)) == (0x3049,)
        assert waits == [11]
        assert one.running.do(lambda: one.line.taken) == before + 24


def test_paced_every_answer_is_waited_for(stand, monkeypatch):
    with ChipsetPort(*stand(rate="1").place) as port:
        by_bytes(port)
        waits = counted(port, monkeypatch)
        assert by_bytes(port) == [0x30, 0x49]
        assert len(waits) >= 7 + 7


def test_sent_commands_precede_queries_elsewhere(stand):
    one = stand()
    ask = one.asks()
    with ChipsetPort(*one.place) as port:
        port.packet(0x6C, reads=2)
        for number in range(20):
            before = ask("read", pins=["x.hostrdy"])["time_ps"]
            port.out(COMMAND, 0x6C)
            answer = ask("read", pins=["x.hostrdy"])
            assert (answer["levels"], answer["time_ps"] - before) == ({"x.hostrdy": 0}, CYCLE), number
            ready(port)
            assert ask("read", pins=["x.hostrdy"])["levels"] == {"x.hostrdy": 1}, number


def test_hostrdy_that_stays_low_is_found_and_nothing_is_lost(stand):
    one = stand()
    ask = one.asks()
    with ChipsetPort(*one.place) as port:
        by_bytes(port)
        ready(port)
        ask("drive", pin="x.reset", level=0)
        port.out(COMMAND, 0x6C)  # no effect, as with every host: HostRdy is low
        assert [port.inp(STATUS) for _ in range(4)] == [0x7F, 0xFF, 0x7F, 0x7F]  # the second was foreseen
        port.out(COMMAND, 0x6C)
        assert port.inp(STATUS) == 0x7F
        ask("release", pin="x.reset")
        ready(port)
        assert [port.inp(DATA), port.inp(DATA)] == [0x5C, 0x11]
        ready(port)
        ask("drive", pin="x.reset", level=0)
        port.out(COMMAND, 0x6C)
        ready(port)
        for byte in range(200):  # more than is kept
            port.out(DATA, byte)
        assert port.inp(DATA) is not None  # it comes back
        ask("release", pin="x.reset")
        assert port.ready(255) is True
        assert by_words(port) == [0x5C, 0x11, 0x5C, 0x7D]


def test_the_last_writes_are_sent_when_the_port_is_closed(stand):
    one = stand()
    for number in range(1, 20):
        with ChipsetPort(*one.place) as port:
            port.out(COMMAND, 0x6C)
            port.out(5, 0)
        assert len(one.seen()["edges"]["hostwrite"][0]) == 2 * number


def test_an_older_server_is_served_with_the_old_protocol(stand, older):
    one, other = stand(), stand()
    with ChipsetPort(*one.place) as port, ChipsetPort(*other.place, plain=True) as plain:
        for program in PROGRAMS:
            assert program(port) == program(plain)
        seen, expected = one.seen(), other.seen()
    assert seen["edges"] == expected["edges"]
    (told,) = [found for found in seen["findings"] if found not in expected["findings"]]
    assert told[2] == "no-request"
    assert told[3].startswith(r"b'\x90\x02' is not a request, and reads FF: this is a port for registers")


@pytest.mark.parametrize("plain", [False, True])
def test_bytes_through_the_handshake_of_a_card(stand, plain):
    one = stand(part="cy545", over="parallel")
    with CardPort(*one.place, plain=plain) as port:
        port.command("O 81H")
        assert port.ask("? P") == "P=00000000"
        port.command("P 00001234")
        assert port.ask("? P") == "P=00001234"
        one.running.do(lambda: one.x.pin("reset").drive(1))
        begun = one.running.do(lambda: one.bench.now_ps)
        with pytest.raises(TimeoutError, match=r"byte 0 of b'ABCDE' was not accepted"):
            port.write(b"ABCDE")
        took = one.running.do(lambda: one.bench.now_ps) - begun
        assert took // (100 * MS) == (10 if plain else 2)  # a series ends there; one by one all waits are made


# ------------------------------------------------------------------------------------------------------------------- C
PROGRAM = r"""
%s
#include <stdio.h>
#include "slewline_port.h"
static void ready(void) { while (!(inp(0x344) & 0x80)) ; }
static void word(unsigned word) { ready(); outp(0x340, word >> 8); ready(); outp(0x340, word & 0xFF); }
static void show(void) { int high; ready(); high = inp(0x340); ready(); printf("%%02x%%02x ", high, inp(0x340)); }
int main(void)
{
    int n;
    for (n = 0; n < 50; n++) {
        ready(); outp(0x342, 0x10); word(0); word(12345 + n); show();
        ready(); outp(0x342, 0x4a); show(); show(); show();
        ready(); outp(0x342, 0x1a); ready(); printf("%%02x%%02x ", inp(0x340), inp(0x340));
    }
    outp(0x342, 0x6c); outp(0x342, 0x10); printf("%%02x %%02x %%02x ", inp(0x344), inp(0x344), inp(0x344));
    ready(); outp(0x342, 0x39); show();
    printf("%%d ", slewline_ready(0)); outp(0x348, 0); printf("%%d %%d ", slewline_ready(0), slewline_ready(100));
    ready(); outp(0x342, 0x6c); show(); show(); outp(0x342, 0x6c); inp(0x344); outp(0x341, 1); outp(0x342, 0x10);
    %s
    return 0;
}
"""


@pytest.fixture
def compiled(tmp_path):
    def compiled(first="", last="", name="program"):
        source = tmp_path / f"{name}.c"
        source.write_text(PROGRAM % (first, last))
        flags = ["-std=c89", "-pedantic", "-Wall", "-Wextra", "-Werror", f"-I{EXAMPLES}"]
        subprocess.run([COMPILER, *flags, "-o", tmp_path / name, source], check=True)
        return tmp_path / name

    if COMPILER is None:
        pytest.skip("no C compiler (cc, gcc, clang) on this machine")
    return compiled


def ran(program, one):
    where = one.port.where.rpartition("//")[2]
    done = subprocess.run(
        [program], check=False, env={"SLEWLINE": where}, capture_output=True, text=True, timeout=PATIENCE
    )
    return done.returncode, done.stdout, done.stderr


def rested(one):
    """What is seen once the host has gone and what it has sent is worked."""
    one.running.until(lambda: one.port.session is None and one.line.quiet() and not one.port.turns)
    return one.seen()


@pytest.mark.system
def test_a_program_in_c_that_waits_for_few_answers_is_one_that_waits_for_all(stand, compiled):
    one, other = stand(), stand()
    results = ran(compiled(), one), ran(compiled("#define SLEWLINE_PLAIN", name="plain"), other)
    assert results[0] == results[1]
    assert (results[0][0], results[0][2]) == (0, "")
    assert "5c11 5c7d" in results[0][1]
    assert rested(one) == rested(other)
    assert one.running.do(lambda: one.line.taken) > other.running.do(lambda: other.line.taken)


@pytest.mark.system
def test_the_same_with_an_older_server(stand, older, compiled):
    one, other = stand(), stand()
    assert ran(compiled(), one) == ran(compiled("#define SLEWLINE_PLAIN", name="plain"), other)
    seen, expected = rested(one), rested(other)
    assert seen["edges"] == expected["edges"]
    assert [found[2] for found in seen["findings"]].count("no-request") == 1


LOW = r"""
    ready(); puts(""); fflush(stdout); getchar();
    { int n, high = 0; outp(0x342, 0x6c); for (n = 0; n < 5; n++) printf("%d", inp(0x344) >> 7);
    outp(0x342, 0x6c); printf("%d\n", inp(0x344) >> 7); fflush(stdout); getchar();
    ready(); high = inp(0x340); printf("%02x%02x\n", high, inp(0x340)); ready(); fflush(stdout); getchar();
    outp(0x342, 0x6c); ready(); for (n = 0; n < 200; n++) outp(0x340, n);
    inp(0x340); puts("back"); }
"""


@pytest.mark.system
def test_a_chipset_in_reset_is_found_by_a_program_in_c_and_nothing_is_lost(stand, compiled):
    one = stand()
    ask = one.asks()
    where = one.port.where.rpartition("//")[2]
    program = subprocess.Popen(
        [compiled(last=LOW)],
        env={"SLEWLINE": where},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        bufsize=1,
    )

    def goes_on():
        program.stdin.write("\n")
        program.stdin.flush()

    try:
        program.stdout.readline()
        ask("drive", pin="x.reset", level=0)
        goes_on()
        assert program.stdout.readline() == "010000\n"  # the second was foreseen
        ask("release", pin="x.reset")
        goes_on()
        assert program.stdout.readline() == "5c11\n"
        ask("drive", pin="x.reset", level=0)
        goes_on()
        assert program.communicate(timeout=PATIENCE)[0] == "back\n"
    finally:
        program.kill()
        program.wait()
