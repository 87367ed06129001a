"""A server with a CY525, and its panel as a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import contextmanager
from urllib.parse import urlsplit

import pytest
from websockets.sync.client import connect

import slewline
from slewline.links.lines.pace import Paced
from slewline.links.server import Server
from tests.browsers import browser  # noqa: F401  (a fixture)
from tests.links.conftest import PATIENCE, Threaded

CONTROL_TOKEN = "only the panel knows it"


class PanelProcess:
    """`python -m slewline.panel`, and the way to it."""

    def __init__(self, control, *options, token=CONTROL_TOKEN):
        environment = os.environ | ({} if token is None else {"SLEWLINE_TOKEN": token})
        command = [sys.executable, "-m", "slewline.panel", "--attach", control, "--with-parent", *options]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
        )
        line = self.process.stdout.readline()
        assert line.startswith("panel: http://127.0.0.1:"), line + self.process.stderr.read()
        self.url = line.partition(": ")[2].strip()
        self.port = urlsplit(self.url).port
        self.token = self.url.partition("#token=")[2]
        self.host = f"127.0.0.1:{self.port}"
        self.origin = f"http://{self.host}"

    @contextmanager
    def connect(self, token=None, origin=None, **more):
        """Yield a websocket that has sent its token."""
        url, origin = f"ws://{self.host}/link", origin or self.origin
        with connect(url, origin=origin, proxy=None, compression=None, **more) as socket:
            socket.send(json.dumps({"token": token}))
            yield socket

    def memory(self):
        """Return the memory that the process has in use (MB), as Linux counts it."""
        try:
            with open(f"/proc/{self.process.pid}/status") as file:
                rows = dict(line.split(":", 1) for line in file)
        except FileNotFoundError:
            pytest.skip("no /proc here")
        return int(rows["VmHWM"].split()[0]) / 1024

    def close(self):
        """End it as the end of its parent does; return what it has written on the standard error."""
        self.process.stdin.close()
        assert self.process.wait(PATIENCE) == 0
        said = self.process.stderr.read()
        self.process.stdout.close()
        self.process.stderr.close()
        return said


def ask(socket, **request):
    """Send a request and return its reply; events that come before it are left out."""
    socket.send(json.dumps({"id": 1, **request}))
    while True:
        reply = json.loads(socket.recv(PATIENCE))
        if "event" not in reply:
            return reply


@contextmanager
def lab():
    """Yield a server of a CY525, in a thread, with a control port that wants a token."""
    bench = slewline.Bench()
    bench.host(bench.add("cy525", name="x"))
    server = Server(bench, Paced(bench))
    control = server.control("127.0.0.1:0", CONTROL_TOKEN)
    with Threaded(server) as threaded:
        threaded.where = control.where
        yield threaded


@pytest.fixture(scope="module")
def standing():
    """A server and its panel, for all tests of a module: a panel takes half a second to open."""
    with lab() as served:
        panel = PanelProcess(served.where)
        yield served, panel
        assert panel.close() == ""


@pytest.fixture
def served(standing):
    """That server; the next test finds it as it was."""
    served, _ = standing
    yield served
    served.do(served.bench.pin("x.abort").release)
    served.do(served.server.pace.go)


@pytest.fixture
def panel(standing, served):
    """Its panel."""
    return standing[1]


@pytest.fixture
def panels(served):
    """Open more panels of that server; all end without a word on the standard error."""
    opened = []

    def panel(*options, **more):
        opened.append(PanelProcess(served.where, *options, **more))
        return opened[-1]

    yield panel
    assert [one.close() for one in opened] == [""] * len(opened)
