"""A stranger's page may neither read nor move anything; whoever sends too much, or nothing, is refused or held."""

from __future__ import annotations

import http.client
import json
import socket
import time
from contextlib import ExitStack, suppress

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from slewline.panel.relay import CLIENTS, FULL, READING, WAITS, WRONG_TOKEN
from tests.links.conftest import PATIENCE, until

from .conftest import ask

pytestmark = pytest.mark.system


def get(panel, path="/", **headers):
    """Return the status, headers and body of a request."""
    connection = http.client.HTTPConnection("127.0.0.1", panel.port, timeout=PATIENCE)
    connection.putrequest("GET", path, skip_host="Host" in headers)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    reply = connection.getresponse()
    found = reply.status, {name.lower(): value for name, value in reply.getheaders()}, reply.read()
    connection.close()
    return found


def pin(served, name="abort"):
    """Return the level that is driven on a pin."""
    return served.do(lambda: served.bench.pin(f"x.{name}").level)


# --------------------------------------------------------------------------------------------------------- who may ask
HOSTILE = [
    "evil.example:{port}",
    "evil.example",
    "10.0.0.1:{port}",
    "127.0.0.2:{port}",
    "localhost.evil:{port}",
    "127.0.0.1.evil.example:{port}",
    "[::1]evil:{port}",
    "localhost:9999:{port}",
    "localhost:port",
    "localhost:",
    "",
]
OURS = [
    f"{name}{port}"
    for name in ("127.0.0.1", "localhost", "[::1]", "LOCALHOST")
    for port in (":{port}", ":9999", ":1", "")
]


@pytest.mark.parametrize("host", HOSTILE)
def test_another_host_is_refused(panel, host):
    for path in ("/", "/panel.js", "/link"):
        status, headers, body = get(panel, path, Host=host.format(port=panel.port))
        assert (status, headers["connection"]) == (403, "close")
        assert b"script" not in body


def test_our_own_names_are_answered_on_any_port(panel, subtests):
    """A tunnel or a container has a port of its own: the browser names that one."""
    for host in OURS:
        with subtests.test(host=host):
            assert get(panel, Host=host.format(port=panel.port))[0] == 200


@pytest.mark.parametrize("host", ["localhost:9999", "[::1]:1", "127.0.0.1"])
def test_a_page_through_a_tunnel_moves_and_a_page_of_another_port_does_not(panel, served, host):
    """The Origin must be that of the Host, whatever the port: other servers of this machine are strangers."""

    def through_tunnel(origin):
        """What the browser asks is `host`; the tunnel leads to the panel."""
        tunnel = socket.create_connection(("127.0.0.1", panel.port), PATIENCE)
        return connect(f"ws://{host}/link", sock=tunnel, origin=origin, proxy=None, compression=None)

    for origin in ("http://localhost:8000", f"http://127.0.0.1:{panel.port}", f"https://{host}"):
        with pytest.raises(InvalidStatus) as refused, through_tunnel(origin):
            pass
        assert refused.value.response.status_code == 403
    with through_tunnel(f"http://{host}") as page:
        page.send(json.dumps({"token": panel.token}))
        assert json.loads(page.recv(PATIENCE)) == {"event": "panel", "writes": True}
        assert "error" not in ask(page, do="drive", pin="x.abort", level=0)
    assert pin(served) == 0


ORIGINS = ["http://evil.example", "null", "http://127.0.0.1", "http://127.0.0.1:1", "https://127.0.0.1:{port}",
           "http://127.0.0.1:{port}.evil.example", "http://localhost:{port}"]  # fmt: skip


@pytest.mark.parametrize("origin", ORIGINS)
def test_another_origin_is_refused_with_the_right_token_too(panel, served, origin):
    with pytest.raises(InvalidStatus) as refused, panel.connect(panel.token, origin.format(port=panel.port)):
        pass
    assert refused.value.response.status_code == 403
    assert pin(served) != 0


def test_no_origin_is_refused(panel):
    with pytest.raises(InvalidStatus), connect(f"ws://{panel.host}/link", proxy=None):
        pass


@pytest.mark.parametrize("path", ["/", "/panel.js", "/style.css", "/nothing", "/../app.py", "/%2e%2e/app.py"])
def test_every_answer_binds_the_browser(panel, path):
    status, headers, body = get(panel, path)
    assert status in (200, 404)
    assert b"import uvicorn" not in body
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy
    assert "*" not in policy
    assert headers["x-frame-options"] == "DENY"
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["cross-origin-resource-policy"] == headers["cross-origin-opener-policy"] == "same-origin"
    assert headers["cache-control"] == "no-store"
    assert "access-control-allow-origin" not in headers


def test_nothing_can_be_posted(panel):
    connection = http.client.HTTPConnection("127.0.0.1", panel.port, timeout=PATIENCE)
    connection.request("POST", "/link", b'{"do": "drive", "pin": "x.abort", "level": 0}')
    assert connection.getresponse().status in (404, 405)
    connection.close()


# ------------------------------------------------------------------------------------------------------------- tokens
MOVES = [
    {"do": "drive", "pin": "x.abort", "level": 0},
    {"do": "pulse", "pin": "x.abort", "level": 0, "width": "1 s"},
    {"do": "pause"},
    {"do": "send", "chip": "x", "text": "R 1"},
    {"do": "step", "chip": "x", "by": "instruction"},
    {"do": "back", "time": 0},
    {"do": "breakpoints", "breakpoints": []},
    {"do": "nothing of the kind"},
]


@pytest.mark.parametrize("request_", MOVES, ids=lambda request: request["do"])
def test_without_a_token_a_page_only_reads(panel, served, request_):
    with panel.connect() as page:
        assert json.loads(page.recv(PATIENCE)) == {"event": "panel", "writes": False}
        assert "this page is read-only" in ask(page, **request_)["error"]
        assert ask(page, do="status")["chips"]
    assert pin(served) != 0
    assert not served.do(lambda: served.server.pace.paused)


@pytest.mark.parametrize("token", ["", "wrong", "é", 7, ["x"], {}])
def test_a_wrong_token_ends_the_connection(panel, token):
    with panel.connect(token) as page, pytest.raises(ConnectionClosed) as closed:
        page.recv(PATIENCE)
    assert closed.value.rcvd.code == WRONG_TOKEN


def test_with_the_token_a_page_moves(panel, served):
    with panel.connect(panel.token) as page:
        assert json.loads(page.recv(PATIENCE)) == {"event": "panel", "writes": True}
        assert "error" not in ask(page, do="drive", pin="x.abort", level=0)
    assert pin(served) == 0


def test_a_panel_to_look_at_moves_nothing_for_anybody(panels, served):
    panel = panels("--read-only")
    with panel.connect(panel.token) as page:
        assert not json.loads(page.recv(PATIENCE))["writes"]
        assert "is read-only" in ask(page, do="drive", pin="x.abort", level=0)["error"]
    assert pin(served) != 0


def test_nobody_ends_the_server(panel, served):
    with panel.connect(panel.token) as page:
        page.recv(PATIENCE)
        assert "not allowed from a page" in ask(page, do="quit")["error"]
        assert ask(page, do="status")["chips"]


SMUGGLED = [
    '{"do": "status", "x": [\n{"do": "drive", "pin": "x.abort", "level": 0}\n]}',
    '{"do": "status"}\n{"do": "drive", "pin": "x.abort", "level": 0}',
    '{"do": "status"}\r{"do": "drive", "pin": "x.abort", "level": 0}',
    '{"do": ["drive"], "pin": "x.abort", "level": 0}',
    '{"do": "status", "do": "drive", "pin": "x.abort", "level": 0}',
    "[" * 60_000,
    "not json",
    "[]",
]


@pytest.mark.parametrize("text", SMUGGLED, ids=lambda text: text[:24])
def test_nothing_is_smuggled_past_the_check(panel, served, text):
    with panel.connect() as page:
        page.recv(PATIENCE)
        page.send(text)
        assert "error" in json.loads(page.recv(PATIENCE))
        assert ask(page, do="status")["chips"]
    assert pin(served) != 0


def test_the_token_of_the_control_port_stays_here(panel, served):
    seen = [get(panel, path)[2] for path in ("/", "/panel.js", "/link.js")]
    with panel.connect(panel.token) as page:
        seen.append(page.recv(PATIENCE).encode())
        seen.append(json.dumps(ask(page, do="status")).encode())
    assert not any(served.server.ports[0].token.encode() in one for one in seen)


def test_a_wrong_token_of_the_control_port_is_reported(panels):
    panel = panels(token="quite another one")
    with panel.connect(panel.token) as page, pytest.raises(ConnectionClosed) as closed:
        page.recv(PATIENCE)
    assert "needs a different token" in closed.value.rcvd.reason


def test_all_that_reads_is_a_request_of_the_control_port(panel):
    with panel.connect() as page:
        page.recv(PATIENCE)
        schema = json.dumps(ask(page, do="schema")["schema"])
    assert {do for do in READING if f'"{do}"' not in schema} == set()


# ---------------------------------------------------------------------------------------------------- too much, too few
@pytest.mark.parametrize("size", [70_000, 1_000_000, 300_000_000])
def test_a_long_message_is_refused_and_not_kept(panel, served, size):
    before = panel.memory()
    with panel.connect(panel.token) as page:
        page.recv(PATIENCE)
        with pytest.raises((ConnectionClosed, OSError)):
            page.send("x" * size)
            page.recv(PATIENCE)
    assert panel.memory() - before < 30
    with panel.connect() as page:
        page.recv(PATIENCE)
        assert ask(page, do="status")["chips"]


def test_a_long_body_is_not_kept(panel):
    before = panel.memory()
    with socket.create_connection(("127.0.0.1", panel.port), PATIENCE) as one:
        one.sendall(f"POST / HTTP/1.1\r\nHost: {panel.host}\r\nContent-Length: 300000000\r\n\r\n".encode())
        piece = bytes(1 << 20)
        try:
            for _ in range(300):
                one.settimeout(1)
                one.sendall(piece)
        except OSError:
            pass  # refused, or held
    assert panel.memory() - before < 30


def admitted(panel):
    """Is there room for one more page?"""
    with suppress(OSError, InvalidStatus, EOFError, ConnectionClosed), panel.connect() as page:
        return json.loads(page.recv(PATIENCE))["event"] == "panel"


def test_a_hundred_pages_are_limited(panels):
    panel = panels()  # none of another test is on its way out
    before, pages = panel.memory(), []
    with ExitStack() as stack:
        for _ in range(100):
            with suppress(OSError, InvalidStatus, EOFError, ConnectionClosed):
                pages.append(stack.enter_context(panel.connect()))
        answers = []
        for page in pages:
            try:
                answers.append(json.loads(page.recv(PATIENCE))["event"])
            except ConnectionClosed as closed:
                answers.append(closed.rcvd.code if closed.rcvd else None)
        assert answers.count("panel") == CLIENTS
        assert {*answers} <= {"panel", FULL}  # those that are refused later than at the door hear why
        assert ask(pages[0], do="status")["chips"]
    assert panel.memory() - before < 50
    until(lambda: admitted(panel))


def test_pages_that_only_read_do_not_shut_out_the_page_of_the_user(panels):
    panel = panels()
    with ExitStack() as stack:
        for page in [stack.enter_context(panel.connect()) for _ in range(CLIENTS)]:
            assert json.loads(page.recv(PATIENCE)) == {"event": "panel", "writes": False}
        with pytest.raises(ConnectionClosed) as closed, panel.connect() as page:
            page.recv(PATIENCE)
        assert closed.value.rcvd.code == FULL
        for page in [stack.enter_context(panel.connect(panel.token)) for _ in range(CLIENTS)]:
            assert json.loads(page.recv(PATIENCE)) == {"event": "panel", "writes": True}
        with pytest.raises(ConnectionClosed), panel.connect(panel.token) as page:
            page.recv(PATIENCE)


def test_silent_pages_do_not_shut_out_the_page_of_the_user(panels):
    panel = panels()
    with ExitStack() as stack:
        for _ in range(CLIENTS + 3):
            stack.enter_context(connect(f"ws://{panel.host}/link", origin=panel.origin, proxy=None, compression=None))
        with panel.connect(panel.token) as page:
            assert json.loads(page.recv(PATIENCE))["writes"]


def test_pings_whose_answers_nobody_reads_cost_no_memory(panel):
    with socket.create_connection(("127.0.0.1", panel.port), PATIENCE) as one:
        head = f"GET /link HTTP/1.1\r\nHost: {panel.host}\r\nOrigin: {panel.origin}\r\nUpgrade: websocket\r\n"
        head += (
            "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
        )
        one.sendall(head.encode())
        assert b"101" in one.recv(1000)
        before = panel.memory()
        pings = (b"\x89\xfd\0\0\0\0" + bytes(125)) * 8000  # a megabyte
        one.settimeout(1)
        with suppress(OSError):
            for _ in range(60):
                one.sendall(pings)
        assert panel.memory() - before < 20
    with panel.connect(panel.token) as page:
        page.recv(PATIENCE)
        assert ask(page, do="status")["chips"]


def test_a_hundred_silent_connections_are_dropped(panel):
    silent = [socket.create_connection(("127.0.0.1", panel.port), PATIENCE) for _ in range(100)]
    time.sleep(0.3)
    assert get(panel)[0] == 200  # the oldest one gives way
    for one in silent[:60]:
        one.close()
    assert get(panel)[0] == 200
    for one in silent[60:]:
        one.close()


def test_too_many_requests_that_wait_are_refused(panel):
    with panel.connect(panel.token) as page:
        page.recv(PATIENCE)
        for number in range(WAITS + 1):
            page.send(json.dumps({"id": number, "do": "until", "pin": "x.abort", "level": 0}))
        error = f"{WAITS} requests are already waiting; wait until one ends"
        assert json.loads(page.recv(PATIENCE)) == {"error": error, "id": WAITS}
        assert ask(page, do="status")["chips"]  # which waits for none of them


def test_a_page_that_reads_nothing_holds_up_only_itself(panel, served):
    before = panel.memory()
    with panel.connect(max_queue=1) as page, panel.connect() as other:
        other.recv(PATIENCE)
        for _ in range(3000):
            try:
                page.socket.settimeout(0.5)
                page.send('{"do": "schema"}')
            except (OSError, TimeoutError, ConnectionClosed):
                break
        assert ask(other, do="status")["chips"]
        assert panel.memory() - before < 40
        page.socket.close()
