"""Servers for the tests: in a thread of this process, or as the command in a process of its own."""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

import slewline
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server

PATIENCE = 60.0  # seconds of the wall clock after which a test gives up; nothing depends on it
STRAPS = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}  # 9600 baud, no checksum
STOP = getattr(signal, "CTRL_BREAK_EVENT", signal.SIGTERM)  # what Windows has for a process of another group
LATE = "slewline: virtual time "  # begins what is said when the machine has been too busy for the wall clock
GROUP = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
COMMAND = [sys.executable, "-W", "error", "-c", "from slewline.cli.main import main; main()", "serve"]


def until(met):
    """Wait for something to become true."""
    end = time.monotonic() + PATIENCE
    while not met():
        assert time.monotonic() < end
        time.sleep(0.01)


def patient(url):
    """The URL of a port, with the patience of these tests for pySerial: its client of RFC 2217 has three seconds."""
    return f"{url}?timeout={PATIENCE:g}" if url.startswith("rfc2217:") else url


def without_lateness(text):
    """What a server has said on its standard error, without what a busy machine makes it say."""
    return "".join(line for line in text.splitlines(True) if not line.startswith(LATE))


class Client:
    """A host program on a socket; its system keeps `room` bytes for it while it does not read."""

    def __init__(self, where, room=None):
        host, port = where.rpartition("//")[2].rsplit(":", 1)
        self.socket = socket.socket()
        if room is not None:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, room)
        self.socket.settimeout(PATIENCE)
        self.socket.connect((host, int(port)))

    def send(self, data):
        self.socket.sendall(data)

    def read(self, end=b"\r"):
        """What comes, up to an end; without one, up to the end of the connection."""
        found = b""
        while not (end and found.endswith(end)):
            data = self.socket.recv(4096, socket.MSG_PEEK if end else 0)
            if not data:
                break
            if end:  # what comes after it stays in the socket
                at = (found + data).find(end)
                data = self.socket.recv(len(data) if at < 0 else at + len(end) - len(found))
            found += data
        return found

    def ask(self, data):
        self.send(data)
        return self.read()

    def close(self):
        self.socket.close()


class Asks:
    """A client of the control port, of what `Client` has on a socket."""

    def __init__(self, client):
        self.client = client

    def __call__(self, do, **more):
        self.client.send(json.dumps({"do": do} | more).encode() + b"\n")
        return self.answer()

    def answer(self):
        return json.loads(self.client.read(b"\n"))

    def refused(self, do, **more):
        return self(do, **more)["error"]


class Threaded:
    """A server in a thread; `do` calls a function in it."""

    def __init__(self, server):
        self.server, self.bench = server, server.bench
        self.thread = threading.Thread(target=server.run, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.server.stop()
        self.thread.join(PATIENCE)
        assert not self.thread.is_alive()

    def do(self, function):
        return self.server.call(function, PATIENCE)

    def until(self, met):
        """Wait for something to become true in the server."""
        end = time.monotonic() + PATIENCE
        while not self.do(met):
            assert time.monotonic() < end
            time.sleep(0.005)

    def standing(self, number):
        """Return a number of the server's once it has not changed for half a second."""
        end = time.monotonic() + PATIENCE
        last, since = self.do(number), time.monotonic()
        while time.monotonic() < since + 0.5:
            assert time.monotonic() < end
            time.sleep(0.005)
            if (now := self.do(number)) != last:
                last, since = now, time.monotonic()
        return last


class Process:
    """`slewline serve` in a process of its own; `ports` is what it says about them.

    Args:
        folder: for its temporary files, which it leaves when it is killed.
    """

    def __init__(self, *arguments, ports=1, folder=None):
        self.process = subprocess.Popen(
            [*COMMAND, *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            creationflags=GROUP,
            env=os.environ | ({} if folder is None else {"TMPDIR": str(folder)}),
        )
        lines = [self.process.stdout.readline().strip() for _ in range(ports)]
        if not all(lines):
            pytest.fail(f"the server has ended: {self.process.communicate()}")
        self.ports = dict(line.split(": ", 1) for line in lines)

    @property
    def where(self):
        return next(iter(self.ports.values()))

    def end(self, number=STOP):
        """Send a signal; returns exit status and standard error, without what a busy machine makes it say."""
        self.process.send_signal(number)
        err = self.process.communicate(timeout=PATIENCE)[1]
        return self.process.returncode, without_lateness(err)

    def kill(self):
        """End it without a word to it; true when it was still there."""
        self.process.kill()
        self.process.communicate(timeout=PATIENCE)
        return self.process.returncode != 0

    def over(self):
        """End it, and all that it has forked: a process that a failed test has stopped ends by nothing else."""
        group = descendants(self.process.pid)
        if self.process.poll() is None:
            self.process.kill()
        for process in group:
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        self.process.communicate()

    def errors(self):
        """A line of the standard error; those that are there behind it are left for `end`."""
        line, descriptor = b"", self.process.stderr.fileno()
        while not line.endswith(b"\n"):
            assert select.select([descriptor], [], [], PATIENCE)[0], line
            byte = os.read(descriptor, 1)
            assert byte, line
            line += byte
        return self.errors() if line.startswith(LATE.encode()) else line.decode()

    def memory_kb(self):
        """What the process has of the machine's memory."""
        with open(f"/proc/{self.process.pid}/status") as status:
            return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def children(process):
    """The processes that a process has begun, with those that have ended without notice; on Linux only."""
    found = []
    for place in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if int((place / "stat").read_text().rpartition(")")[2].split()[1]) == process:
                found.append(int(place.name))
    return found


def descendants(process):
    """The processes that a process has begun, and those that these have."""
    return [each for child in children(process) for each in (child, *descendants(child))]


@pytest.fixture
def lockstep():
    """A bench with a module x, and a server in lockstep, to be started with Threaded(server)."""

    def make(*, straps=None, journal=None, log=None, part="gs-c200s"):
        bench = slewline.Bench(journal=journal)
        x = bench.add(part, name="x", straps=STRAPS | (straps or {}))
        server = Server(bench, Lockstep(bench), log)
        return server, server.line(x)

    return make


@pytest.fixture
def client():
    """Connect to a port."""
    made = []

    def connect(where, room=None):
        made.append(Client(where, room))
        return made[-1]

    yield connect
    for one in made:
        one.close()


@pytest.fixture
def serve(tmp_path_factory):
    """Start the command."""
    made = []

    def start(*arguments, ports=1):
        made.append(Process(*arguments, ports=ports, folder=tmp_path_factory.mktemp("served")))
        return made[-1]

    yield start
    for one in made:
        one.over()
