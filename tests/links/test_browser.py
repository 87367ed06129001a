"""A page in a real browser attacks every kind of port; nothing that it makes the browser send reaches a module."""

from __future__ import annotations

import json
import os
import subprocess
import threading
from collections import Counter
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest

import slewline
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from tests.browsers import needed, own_folder

from .conftest import PATIENCE, STRAPS, Threaded

pytestmark = [
    pytest.mark.system,
    pytest.mark.filterwarnings("ignore:set(Daemon|Name)\\(\\) is deprecated:DeprecationWarning"),
]
PAGE = Path(__file__).with_name("attacks.html")
QUIET = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --disable-dev-shm-usage"
)
SECONDS = float(os.environ.get("ATTACK_S", "0"))  # of each attack, beyond the first try
WAYS = (  # in one of each way the browser has come to every port; it may spare itself a single attack
    {"get", "post", "put", "own", "beacon", "image", "script", "socket", "form"},
    {"tls", "tls_post", "image_tls", "socket_tls", "turns"},
    {"turn", "ice"},
)


@pytest.fixture
def browser(tmp_path):
    """Open a page; where there is no browser, the test is skipped."""
    path = needed()
    started = []
    with own_folder() as environment:

        def opened(url):
            command = [path, *QUIET.split(), f"--user-data-dir={tmp_path / 'profile'}", url]
            quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            started.append(subprocess.Popen(command, env=environment, **quiet))

        yield opened
        for one in started:
            one.kill()
            one.wait()


class Site:
    """What serves the page; it learns which attack has begun."""

    def __init__(self, ports):
        self.attack, self.over = "", threading.Event()
        site, plan = self, json.dumps({"ports": ports, "seconds": SECONDS}).encode()

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self):
                what, _, name = self.path.partition("?")
                if what == "/begins":
                    site.attack = name
                elif what == "/done":
                    site.over.set()
                body = {"/": PAGE.read_bytes(), "/plan": plan}.get(what, b"")
                self.send_response(200)
                self.send_header("Content-Type", "text/html")
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_):
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.thread = threading.Thread(target=self.server.serve_forever)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()
        self.thread.join(PATIENCE)

    @property
    def url(self):
        return f"http://127.0.0.1:{self.server.server_address[1]}/"


class Target:
    """A chip of each kind on its port, and all that has reached one of them."""

    def __init__(self, journal):
        bench = slewline.Bench(journal=journal)
        self.bench, self.server = bench, Server(bench, Lockstep(bench))
        self.ports, self.connections, self.reached = {}, Counter(), Counter()
        for name, part, kind, more in (
            ("gsc", "gs-c200s", "tcp", {}),
            ("gsc_rfc2217", "gs-c200s", "rfc2217", {}),
            ("uart", "cy525", "tcp", {}),
            ("framing", "cy525", "tcp", {"framing": True}),
            ("cy545", "cy545", "tcp", {"over": "serial"}),
            ("card", "cy545", "tcp", {"over": "parallel"}),
            ("chipset", "mc1451a", "tcp", {}),
        ):
            chip = bench.add(part, name=name, straps=STRAPS if part == "gs-c200s" else {})
            line = self.server.line(chip, **more)
            self._opened(name, getattr(self.server, kind)(line, "127.0.0.1:0"))
            self._noted(line, "feed", f"{name}: bytes", len)
            if hasattr(line, "board"):
                self._noted(line.board, "cycle", f"{name}: accesses", lambda _port, _byte=None: 1)
        self._opened("control", self.server.control("127.0.0.1:0"))

    def _opened(self, name, port):
        self.ports[name] = port.listener.socket.getsockname()[1]
        accept = port.listener.accept

        def accepted(connection, peer):
            self.connections[name, self.attack()] += 1
            accept(connection, peer)

        port.listener.accept = accepted

    def _noted(self, owner, call, what, size):
        real = getattr(owner, call)

        def noted(*given):
            self.reached[f"{what} of {self.attack()}"] += size(*given)
            return real(*given)

        setattr(owner, call, noted)

    attack = staticmethod(lambda: "")


def test_no_page_makes_a_browser_reach_a_module(browser, tmp_path):
    journal = tmp_path / "journal"
    target = Target(journal)
    with Threaded(target.server) as running, Site(list(target.ports.values())) as site:
        target.attack = lambda: site.attack
        before = journal.read_text().splitlines()
        browser(site.url)
        assert site.over.wait(PATIENCE + 20 * (SECONDS + 1))
        steps = running.do(lambda: {name: running.server.steps_of(chip) for name, chip in target.bench.chips.items()})
    inputs = [line for line in journal.read_text().splitlines()[len(before) :] if json.loads(line)["do"] != "run"]
    assert (dict(target.reached), set(steps.values()), inputs) == ({}, {0}, [])
    ways = {port: [sum(target.connections[port, attack] for attack in way) for way in WAYS] for port in target.ports}
    assert all(map(all, ways.values())), ways
