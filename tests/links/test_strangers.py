"""A browser, or whoever else knows nothing of modules, changes nothing on any port."""

from __future__ import annotations

import json
import ssl
from itertools import product
from time import perf_counter

import pytest

import slewline
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from slewline.links.sockets.preamble import HOLD_S, LONGEST, METHODS, REGISTERS, TEXT, Preamble

from .conftest import PATIENCE, STRAPS, Asks, Client, Threaded

POST = b"POST / HTTP/1.1\r\nOrigin: http://evil.example\r\nContent-Type: text/plain\r\n\r\n"
BODY = b"\rf+5\r"  # the position is 5
COOKIE = b"\x21\x12\xa4\x42" + b"\x12\x6c" * 6


def hello():
    """What TLS says first."""
    context = ssl.create_default_context()
    sent = ssl.MemoryBIO()
    with pytest.raises(ssl.SSLWantReadError):
        context.wrap_bio(ssl.MemoryBIO(), sent, server_hostname="evil.example").do_handshake()
    return sent.read()


CLIENT = "a client of the control port"
STRANGERS = {
    "WebSocket": b"GET /chat HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\n\r\n",
    "OPTIONS *": b"OPTIONS * HTTP/1.1\r\n\r\n",
    "absolute": b"GET http://127.0.0.1/ HTTP/1.1\r\n\r\n",
    "CONNECT": b"CONNECT 127.0.0.1:443 HTTP/1.1\r\n\r\n",
    "small letters": b"post /x HTTP/1.1\r\n\r\n",
    "mixed letters": b"Post /x HTTP/1.1\r\n\r\n",
    "own method": b"f+5 /x HTTP/1.1\r\n\r\n",
    "own method, CONNECT": b"Go 127.0.0.1:1 HTTP/1.0\r\n\r\n",
    "HTTP/0.9": b"GET /\r\n",
    "HTTP/2": b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    "TLS": hello(),
    "SSL 3": bytes.fromhex("160300 0061 01 00005d 0300") + BODY,
    "SSL 2": bytes.fromhex("802e 01 0002 0015 0000 0010") + BODY,
    "SSL 2 of WebRTC": bytes.fromhex("8046 01 0301 002d 0000 0010") + BODY,
    "STUN": bytes.fromhex("0001 0008") + COOKIE + BODY,
    "TURN": bytes.fromhex("0003 0024") + COOKIE + BODY,
    "ICE over TCP": bytes.fromhex("0064 0001 0050") + COOKIE + BODY,
    "ICE over TCP, long": bytes.fromhex("0138 0001 0124") + COOKIE + BODY,
    CLIENT: b'{"do": "read", "pins": [], "id": 1}\n',
} | {method: f"{method} /x HTTP/1.1\r\n\r\n".encode() for method in METHODS if method != "PRI"}
BEHIND_BLANKS = {f"blank, {name}": b"\r\n" + STRANGERS[name] for name in ("GET", "own method", "HTTP/2")}


def test_every_foreign_request_is_recognised_however_it_is_cut(subtests):
    for greetings, (name, data) in product((TEXT, REGISTERS), STRANGERS.items()):
        with subtests.test(greetings=greetings, name=name):
            for cut in range(len(data) + 1):
                beginning = Preamble(greetings)
                assert beginning.take(data[:cut]) + beginning.take(data[cut:]) == b""
                assert beginning.protocol
            bytewise = Preamble(greetings)
            assert b"".join(bytewise.take(bytes([byte])) for byte in data) == b""


@pytest.mark.parametrize("data", BEHIND_BLANKS.values(), ids=BEHIND_BLANKS)
def test_an_untrusted_client_can_pass_on_a_leading_blank_line_only(data):
    for cut in range(1, len(data)):
        beginning = Preamble()
        passed = beginning.take(data[:cut]) + beginning.take(data[cut:])
        assert passed == (data[:cut] if cut <= 2 else b"")
        assert beginning.protocol == "HTTP"


HOSTS = (
    b"Po\r", b"P 100\r", b"G\r", b"POSTE\r", b"GET \r", b"\xff\xfb\x03GET /", b"DEL /\r", b"\r\rR 87H\r", b"? P\r",
    b"/B 2\r", b'"GET / HTTP/1.1"\r', b"4V1\r", b"N 1 2\r", b"!\r", b"?0\r", b"\x16\xbb", b"\x16\x03\x05",
    b"\x52\x01\x87", b"\x00\xbb\x00\x00", b"\x00\x01\x00\x00\x21\x13", b"\x80\x00\x02", b"R 100\nHTTP/1.1",
    b"\x01\x00\x01\x00",
)  # fmt: skip


def test_a_host_that_begins_like_one_is_served_as_soon_as_it_differs(subtests):
    for data in HOSTS:
        with subtests.test(data=data):
            beginning = Preamble()
            assert b"".join(beginning.take(bytes([byte])) for byte in data) == data
            assert not beginning.protocol
            assert beginning.take(b"GET / HTTP/1.1\r\n") == b"GET / HTTP/1.1\r\n"  # it is the beginning that counts


@pytest.mark.parametrize(
    "data", [b"\x24\x64", b"\x34\x64", b"\x44\x64", b"\x04\x00", b"\x12\x6c", b"\x00\x00", b"\x16\xbb"]
)
def test_no_request_of_a_register_waits_for_a_second_one(data):
    assert Preamble(REGISTERS).take(data) == data


@pytest.mark.parametrize("data", [b"\r", b"\n", b"\r\n\r\n"])
def test_single_line_ends_are_passed_on_immediately(data):
    """They set the rate of a chip that adapts to its host."""
    assert Preamble().take(data) == data


def test_nothing_is_withheld_for_ever():
    beginning = Preamble()
    long = b"x" * LONGEST
    assert beginning.take(long) == b""
    assert beginning.take(b"x") == long + b"x"


def test_bytes_withheld_for_too_long_are_passed_on_and_the_request_is_still_recognised():
    beginning = Preamble()
    assert beginning.take(b"POS") == b""
    assert beginning.release() == b"POS"
    assert beginning.take(b"T") == b"T"
    assert beginning.take(b" / HTTP/1.1\r\n") == b""
    assert beginning.protocol == "HTTP"


class Stage:
    """A server with a port of every kind, whose turns are made here, and whose clock a test moves on."""

    KINDS = ("gsc", "rfc2217", "uart", "framing", "cy545", "card", "chipset", "control")

    def __init__(self, monkeypatch):
        self.ahead = 0.0  # its clock, which goes on by nothing else
        monkeypatch.setattr("slewline.links.sockets.loop.perf_counter", lambda: self.ahead)
        bench = self.bench = slewline.Bench()
        self.server = Server(bench, Lockstep(bench))
        self.reached = bytearray()  # what has come to a line, and accesses to a register
        self.ports = {
            name: self.opened(bench.add(part, name=name, straps=STRAPS if part == "gs-c200s" else {}), kind, **more)
            for name, part, kind, more in (
                ("gsc", "gs-c200s", "tcp", {}),
                ("rfc2217", "gs-c200s", "rfc2217", {}),
                ("uart", "cy525", "tcp", {}),
                ("framing", "cy525", "tcp", {"framing": True}),
                ("cy545", "cy545", "tcp", {"over": "serial"}),
                ("card", "cy545", "tcp", {"over": "parallel"}),
                ("chipset", "mc1451a", "tcp", {}),
            )
        }
        self.ports["control"] = self.server.control("127.0.0.1:0")
        perform = "slewline.links.control.control.Requests.perform"
        monkeypatch.setattr(perform, lambda _self, request: self.reached.extend(str(request).encode()) or {})
        self.server.pace.start()

    def opened(self, chip, kind, **more):
        line = self.server.line(chip, **more)
        line.feed = self.reached.extend
        return getattr(self.server, kind)(line, "127.0.0.1:0")

    def turn(self):
        self.server.pace.pass_time()
        self.server.loop.serve(self.server.loop.sleep(0))

    def here(self, port):
        """Whoever is on a port."""
        return next(iter(port.clients), None) if hasattr(port, "clients") else port.session

    def until(self, met):
        end = perf_counter() + PATIENCE
        while not met():
            self.turn()
            assert perf_counter() < end

    def visit(self, kind, data, cut, pause):
        """Send two pieces with a pause between them; the visitor has been hung up on."""
        port = self.ports[kind]
        visitor = Client(port.where)
        self.until(lambda: self.here(port) is not None)
        one = self.here(port)
        visitor.send(data[:cut])
        self.until(lambda: len(one.beginning.seen) >= cut or self.here(port) is None)
        self.ahead += pause
        self.turn()
        if self.here(port) is not None:
            visitor.send(data[cut:])
            self.until(lambda: self.here(port) is None)
        assert one.beginning.protocol
        visitor.close()

    def close(self):
        self.server.close()


@pytest.fixture
def stage(monkeypatch):
    one = Stage(monkeypatch)
    yield one
    one.close()


def cuts(stage, kind, data, step, pauses=(0, 0.06, 0.3)):
    for cut in range(1, len(data), step):
        for pause in pauses:
            stage.visit(kind, data, cut, pause)
    assert not stage.reached.strip(b"\r\n")


@pytest.mark.parametrize("kind", Stage.KINDS)
def test_no_foreign_request_reaches_anything_on_any_port(stage, kind):
    for name, data in (STRANGERS | BEHIND_BLANKS).items():
        if (name, kind) == (CLIENT, "control"):
            continue
        cuts(stage, kind, data, len(data) // 3, (0, 0.3))


@pytest.mark.long
@pytest.mark.parametrize("kind", Stage.KINDS)
@pytest.mark.parametrize("name", STRANGERS | BEHIND_BLANKS)
def test_no_foreign_request_reaches_anything_cut_at_every_byte(stage, kind, name):
    if (name, kind) == (CLIENT, "control"):
        pytest.skip("it is none there")
    cuts(stage, kind, (STRANGERS | BEHIND_BLANKS)[name], 1)


def test_a_browser_that_pauses_at_every_byte_reaches_nothing(stage):
    """Each pause by itself counts, not all of them together."""
    port = stage.ports["gsc"]
    visitor = Client(port.where)
    stage.until(lambda: port.session is not None)
    one = port.session
    for at in range(4):
        visitor.send(POST[at : at + 1])
        stage.until(lambda at=at: len(one.beginning.seen) > at)
        stage.ahead += 0.6 * HOLD_S
        stage.turn()
    visitor.send(POST[4:])
    stage.until(lambda: port.session is None)
    assert not stage.reached
    visitor.close()


def test_a_byte_that_comes_alone_is_passed_on_after_a_while(stage):
    port = stage.ports["cy545"]
    host = Client(port.where)
    host.send(b"Q")
    stage.until(lambda: port.session is not None and port.session.beginning.pending)
    stage.ahead += 0.9 * HOLD_S
    stage.turn()
    assert stage.reached == b""
    stage.ahead += 0.2 * HOLD_S
    stage.until(lambda: stage.reached == b"Q")
    host.close()


@pytest.fixture
def ports(lockstep, monkeypatch, tmp_path):
    """A module and its ports: the running server, the line, the port of the line, the control port."""
    monkeypatch.setattr("slewline.links.ports.tcp.HOLD_S", 1000.0)  # nothing is passed on because time has gone by
    started = []

    def start(kind="tcp"):
        server, line = lockstep(log=tmp_path / "log")
        port, control = getattr(server, kind)(line, "127.0.0.1:0"), server.control("127.0.0.1:0")
        started.append(Threaded(server))
        return started[-1].__enter__(), line, port, control

    yield start
    for running in started:
        running.__exit__()


def cut(where, data, at, arrived):
    """Send two pieces as two; returns what the server has to say."""
    host = Client(where)
    host.send(data[:at])
    arrived(at)
    try:
        host.send(data[at:])
        said = host.read(end=b"")
    except ConnectionError:  # hung up on, with the rest unread
        said = b""
    host.close()
    return said


@pytest.mark.parametrize("kind", ["tcp", "rfc2217"])
def test_a_post_cut_anywhere_never_reaches_a_module(ports, client, kind):
    running, line, port, _ = ports(kind)
    data = POST + BODY
    for at in range(1, len(data)):
        arrived = lambda at: running.until(  # noqa: E731
            lambda: port.session is None or len(port.session.beginning.seen) >= at
        )
        cut(port.where, data, at, arrived)
        running.until(lambda: port.session is None)
    assert line.taken == 0
    host = client(port.where)
    host.send(b"V1\r")
    assert host.read(b"V+0\r").endswith(b"V+0\r")


def test_a_post_cut_anywhere_does_nothing_on_the_control_port(ports):
    running, _, _, control = ports()
    data = POST + b'{"do": "drive", "pin": "x.ui1", "level": 0}\n{"do": "quit"}\n'
    for at in range(1, len(data)):
        arrived = lambda at: running.until(  # noqa: E731
            lambda: not control.clients or len(control.clients[0].beginning.seen) >= at
        )
        cut(control.where, data, at, arrived)
        running.until(lambda: not control.clients)
    assert running.bench.pin("x.ui1").level == 1
    assert running.thread.is_alive()


def test_a_post_never_reaches_the_registers_of_a_chipset(lockstep):
    server, _ = lockstep()
    line = server.line(server.bench.add("mc1451a", name="m"))
    port = server.tcp(line, "127.0.0.1:0")
    with Threaded(server) as running:
        cut(port.where, POST + b"\x12\x6c", len(POST), lambda _: None)
        running.until(lambda: port.session is None)
    assert line.taken == 0


def test_a_host_that_types_slowly_is_served_and_a_slow_browser_is_disconnected(ports, monkeypatch, tmp_path):
    running, line, port, _ = ports()
    monkeypatch.setattr("slewline.links.ports.tcp.HOLD_S", 0.001)
    host = Client(port.where)
    host.send(b"P")
    running.until(lambda: line.taken == 1)
    assert host.ask(b"o\r") == b"Y\r"
    host.close()
    stranger = Client(port.where)
    stranger.send(b"GET")
    running.until(lambda: line.taken == 6)
    stranger.send(b" / HTTP/1.1\r\n\r\n")
    assert stranger.read(end=b"") == b""
    stranger.close()
    running.until(lambda: port.session is None)
    assert line.taken == 6
    assert "speaks HTTP" in (tmp_path / "log").read_text()


@pytest.mark.parametrize("kind", ["tcp", "rfc2217"])
def test_the_server_is_notified_once_that_a_browser_has_come(ports, client, kind):
    _, _, port, _ = ports(kind)
    said = []
    port.report = said.append
    for _ in range(2):
        browser = client(port.where)
        browser.send(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
        browser.read(end=b"")  # until it is hung up on
    (text,) = said
    assert text.startswith("127.0.0.1:")
    assert text.endswith(
        " speaks HTTP, which hosts do not use; connection closed; a browser opens the page of slewline panel"
    )


def test_a_typed_line_is_served_when_it_ends(ports):
    """Here the hold lasts for ever, and it is not waited for."""
    running, line, port, _ = ports()
    host = Client(port.where)
    for typed in (b"P", b"Po"):
        host.send(typed[-1:])
        running.until(lambda typed=typed: port.session is not None and port.session.beginning.pending == typed)
    assert line.taken == 0
    assert host.ask(b"\r") == b"Y\r"
    host.send(b"G")
    running.until(lambda: line.taken == 4)  # only the first line waits
    host.close()


@pytest.mark.parametrize("first", [b"nonsense", b"[1]", b"17", b'"quit"', b"null", b"[" * 60_000, b"x" * 200_000])
def test_a_client_whose_first_line_is_not_an_object_is_disconnected(ports, client, first):
    running, _, _, control = ports()
    stranger = client(control.where)
    stranger.send(first + b'\n{"do": "quit"}\n')
    assert "is not a JSON object" in json.loads(stranger.read(b"\n"))["error"]
    assert running.thread.is_alive()
    assert "chips" in Asks(client(control.where))("status")
