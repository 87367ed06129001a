"""The way between a page and the control port, and the life of the process."""

from __future__ import annotations

import asyncio
import json
import signal
import socket
import struct
import subprocess
import sys

import pytest
from starlette.websockets import WebSocket
from websockets.exceptions import ConnectionClosed

from slewline.panel.relay import Access, Relay
from tests.links.conftest import PATIENCE

from .conftest import CONTROL_TOKEN, PanelProcess, ask, lab

pytestmark = pytest.mark.system


@pytest.fixture
def page(panel):
    """A page that may move and write."""
    with panel.connect(panel.token) as page:
        assert json.loads(page.recv(PATIENCE))["writes"]
        yield page


def test_replies_come_in_order_and_with_their_ids(page):
    for number in range(50):
        page.send(json.dumps({"do": "read", "pins": ["x.abort"], "id": number}))
    assert [json.loads(page.recv(PATIENCE))["id"] for _ in range(50)] == list(range(50))


def test_pages_that_leave_before_they_have_sent_anything_leave_no_trace(panels):
    panel = panels()  # its standard error must be empty at the end
    for _ in range(10):
        with socket.create_connection(("127.0.0.1", panel.port)) as page:
            fields = {"Host": panel.host, "Origin": panel.origin, "Upgrade": "websocket", "Connection": "Upgrade"}
            fields |= {"Sec-WebSocket-Version": "13", "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ=="}
            lines = ["GET /link HTTP/1.1", *(f"{name}: {value}" for name, value in fields.items()), "", ""]
            page.sendall("\r\n".join(lines).encode())
            page.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # it breaks off
    with panel.connect(panel.token) as page:
        assert json.loads(page.recv(PATIENCE))["writes"]


def test_events_come_between(page):
    assert ask(page, do="subscribe", every="33 ms")["view"]["chips"]["x"]
    assert json.loads(page.recv(PATIENCE))["event"] in ("view", "said")


def test_a_pause_is_not_delayed_by_a_request_that_waits(page, served):
    page.send(json.dumps({"do": "until", "pin": "x.abort", "level": 0, "timeout": "60 s", "id": "late"}))
    assert "error" not in ask(page, do="pause")
    assert served.do(lambda: served.server.pace.paused)
    page.send(json.dumps({"do": "go", "rate": "1", "id": "go"}))
    page.send(json.dumps({"do": "drive", "pin": "x.abort", "level": 0, "id": "drive"}))
    assert "late" in {json.loads(page.recv(PATIENCE)).get("id") for _ in range(3)}


def test_a_step_answers(page):
    assert ask(page, do="pause")["id"] == 1
    ask(page, do="send", chip="x", text="R 100")
    assert ask(page, do="step", chip="x", by="command", timeout="1 s")["met"] is True


def test_every_page_has_a_connection_of_its_own(panel, page):
    with panel.connect() as other:
        other.recv(PATIENCE)
        ask(page, do="subscribe", every="33 ms")
        assert ask(other, do="status")["id"] == 1


def test_the_end_of_the_server_closes_the_page():
    with lab() as served:
        panel = PanelProcess(served.where)
        with panel.connect() as page, pytest.raises(ConnectionClosed) as closed:
            page.recv(PATIENCE)
            served.server.stop()
            while True:
                page.recv(PATIENCE)
        assert "server" in closed.value.rcvd.reason
    assert panel.close() == ""


def test_when_the_server_has_gone_the_page_is_notified():
    with socket.create_server(("127.0.0.1", 0)) as server:
        panel = PanelProcess("{}:{}".format(*server.getsockname()))
    with panel.connect() as page, pytest.raises(ConnectionClosed) as closed:
        page.recv(PATIENCE)
    assert "no server" in closed.value.rcvd.reason
    assert panel.close() == ""


@pytest.mark.posix
@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_a_signal_ends_it_silently(served, number):
    panel = PanelProcess(served.where)
    with panel.connect() as page:
        page.recv(PATIENCE)
        panel.process.send_signal(getattr(signal, number))
        assert panel.process.wait(PATIENCE) == 0
    assert panel.close() == ""


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--attach", "127.0.0.1:0"], "port 0 is not the number of a control port; allowed 1 to 65535"),
        (["--attach", "nonsense"], "expected HOST:PORT"),
        (["--attach", "127.0.0.1:1", "--listen", "0.0.0.0:0"], "other machines could reach it; add --allow-remote"),
    ],
)
def test_a_wrong_address_is_reported(options, says):
    command = [sys.executable, "-m", "slewline.panel", *options]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert ran.returncode == 2
    assert says in ran.stderr


def test_a_panel_for_other_machines_needs_the_token_to_read_too(served):
    panel = PanelProcess.__new__(PanelProcess)
    command = [sys.executable, "-m", "slewline.panel", "--attach", served.where, "--listen", "0.0.0.0:0"]
    panel.process = subprocess.Popen(
        [*command, "--allow-remote", "--with-parent"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    port = panel.process.stdout.readline().partition("0.0.0.0:")[2].partition("/")[0]
    panel.host = f"127.0.0.1:{port}"
    panel.origin = f"http://{panel.host}"
    with panel.connect() as page, pytest.raises(ConnectionClosed) as closed:
        page.recv(PATIENCE)
    assert "token" in closed.value.rcvd.reason
    panel.close()


@pytest.mark.parametrize("taken", [0, 1])
def test_a_page_that_leaves_during_a_message_to_it_ends_silently(served, taken):
    """After so many messages; whoever reads from it next finds it gone, in the same turn of the loop."""

    async def relayed():
        said = []
        heard = iter([{"type": "websocket.connect"}, {"type": "websocket.receive", "text": '{"token": "t"}'}])

        async def receive():
            await asyncio.sleep(0)
            if (message := next(heard, None)) is None:
                return {"type": "websocket.receive", "text": json.dumps({"id": 1, "do": "view"})}
            return message

        async def send(message):
            if message["type"] == "websocket.send":
                if len(said) == taken:
                    raise OSError
                said.append(message)

        page = WebSocket({"type": "websocket", "headers": []}, receive, send)
        address, _, port = served.where.rpartition(":")
        await Relay(page, Access(address, int(port), "t", CONTROL_TOKEN)).run(lambda _relay, _own: None)
        return len(said)

    assert asyncio.run(asyncio.wait_for(relayed(), PATIENCE)) == taken
