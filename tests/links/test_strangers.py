"""A browser, or whoever else knows nothing of modules, changes nothing on any port."""

from __future__ import annotations

import json

import pytest

from slewline.links.strangers import METHODS, Beginning

from .conftest import Asks, Client, Threaded

POST = b"POST / HTTP/1.1\r\nOrigin: http://evil.example\r\nContent-Type: text/plain\r\n\r\n"
BODY = b"\rf+5\r"  # the position is 5


@pytest.mark.parametrize("method", METHODS)
def test_every_request_is_known_however_it_is_cut(method):
    request = f"{method} /x HTTP/1.1\r\n".encode()
    for cut in range(1, len(request)):
        beginning = Beginning()
        assert beginning.take(request[:cut]) + beginning.take(request[cut:]) == b""
        assert beginning.is_http


@pytest.mark.parametrize("data", [b"Po\r", b"P 100\r", b"G\r", b"POSTE\r", b"GET \r", b"\xff\xfb\x03GET /", b"DEL /\r"])
def test_a_host_that_begins_like_one_is_heard_as_soon_as_it_differs(data):
    beginning = Beginning()
    assert b"".join(beginning.take(bytes([byte])) for byte in data) == data
    assert not beginning.is_http
    assert beginning.take(b"GET / HTTP/1.1\r\n") == b"GET / HTTP/1.1\r\n"  # it is the beginning that counts


def test_what_was_held_long_enough_is_passed_on_and_the_request_is_known_all_the_same():
    beginning = Beginning()
    assert beginning.take(b"POS") == b""
    assert beginning.release() == b"POS"
    assert beginning.take(b"T") == b"T"
    assert beginning.take(b" / HTTP/1.1\r\n") == b""
    assert beginning.is_http


@pytest.fixture
def ports(lockstep, monkeypatch, tmp_path):
    """A module and its ports: the running server, the line, the port of the line, the control port."""
    monkeypatch.setattr("slewline.links.tcp.HOLD_S", 1000.0)
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
            lambda: not control.clients or len(control.clients[0].incoming) >= at
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


def test_a_host_that_types_slowly_is_heard_and_a_stranger_that_does_is_hung_up_on(ports, monkeypatch, tmp_path):
    running, line, port, _ = ports()
    monkeypatch.setattr("slewline.links.tcp.HOLD_S", 0.001)
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


def test_a_byte_at_a_time_is_heard_as_soon_as_it_can_be_no_request(ports):
    """Here the hold lasts for ever, and it is not waited for."""
    running, line, port, _ = ports()
    host = Client(port.where)
    host.send(b"P")
    running.until(lambda: port.session is not None and port.session.beginning.held == b"P")
    host.send(b"o")
    running.until(lambda: line.taken == 2)
    assert host.ask(b"\r") == b"Y\r"
    host.close()


@pytest.mark.parametrize("first", [b"nonsense", b"[1]", b"17", b'"quit"', b"null", b"[" * 60_000, b"x" * 200_000])
def test_a_client_whose_first_line_is_no_object_is_hung_up_on(ports, client, first):
    running, _, _, control = ports()
    stranger = client(control.where)
    stranger.send(first + b'\n{"do": "quit"}\n')
    assert "is no JSON object" in json.loads(stranger.read(b"\n"))["error"]
    assert running.thread.is_alive()
    assert "chips" in Asks(client(control.where))("status")
