"""slewline panel, and serve --panel: what is started, what is told, and that nothing is left behind."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
from contextlib import contextmanager
from urllib.parse import urlsplit

import pytest
from websockets.sync.client import connect

from tests.links.conftest import PATIENCE, without_lateness

COMMAND = [sys.executable, "-m", "slewline"]


@contextmanager
def started(*arguments):
    """Yield what the command says of its ports, by name; end it with a signal."""
    process = subprocess.Popen([*COMMAND, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    with process:
        try:
            found = {}
            while "panel" not in found:
                line = process.stdout.readline()
                assert line, process.stderr.read()
                name, _, where = line.strip().partition(": ")
                found[name] = where
            yield found
            process.send_signal(signal.SIGTERM)
            assert process.wait(PATIENCE) == 0
            assert without_lateness(process.stderr.read()) == ""
        finally:
            process.kill()


@contextmanager
def page(url):
    """Yield a function that asks what a page of this panel asks."""
    parts = urlsplit(url)
    origin, token = f"http://{parts.netloc}", parts.fragment.partition("=")[2]
    with connect(f"ws://{parts.netloc}/link", origin=origin, proxy=None) as socket:
        socket.send(json.dumps({"token": token}))
        assert json.loads(socket.recv(PATIENCE))["writes"]

        def ask(**request):
            socket.send(json.dumps({"id": 1} | request))
            while "id" not in (reply := json.loads(socket.recv(PATIENCE))):
                pass
            return reply

        yield ask


@pytest.mark.system
def test_a_chip_is_served_with_its_host_and_a_past():
    with started("panel", "cy525", "--no-browser") as found, page(found["panel"]) as ask:
        ask(do="send", chip="cy525", text="A 0\nF 10\nR 100\nS 240\nZ 1\nN 400\nG")
        assert ask(do="until", chip="cy525", position=400)["met"]
        if hasattr(os, "fork"):
            assert "error" not in ask(do="back", time=0)
            assert ask(do="view")["view"]["chips"]["cy525"]["axes"][0]["position"] != 400


@pytest.mark.system
def test_a_program_is_given_to_the_chip(tmp_path):
    (tmp_path / "p.txt").write_text("A 0\nF 10\nR 100\nS 240\nZ 1\nN 40\nG\n")
    command = ("panel", str(tmp_path / "p.txt"), "--chip", "cy525", "--no-browser", "--rate", "10")
    with started(*command) as found, page(found["panel"]) as ask:
        assert ask(do="until", chip="cy525", position=40)["met"]


@pytest.mark.system
def test_a_bench_file_is_shown_with_its_ports(tmp_path):
    (tmp_path / "b.toml").write_text(
        '[[chip]]\nname = "x"\npart = "gs-c200s"\nstraps = { chs = 0 }\n[[serve]]\nchips = ["x"]\ntcp = "127.0.0.1:0"\n'
    )
    with started("panel", str(tmp_path / "b.toml"), "--no-browser") as found, page(found["panel"]) as ask:
        assert found["x"].startswith("socket://127.0.0.1:")
        assert list(ask(do="view")["view"]["chips"]) == ["x"]


@pytest.mark.system
def test_a_server_opens_a_panel():
    with started("serve", "gs-c200s", "--tcp", "127.0.0.1:0", "--panel") as found, page(found["panel"]) as ask:
        assert set(found) == {"gs_c200s", "panel"}
        assert list(ask(do="view")["view"]["chips"]) == ["gs_c200s"]


@pytest.mark.system
def test_a_panel_is_attached_to_a_server():
    with started("panel", "cy525", "--no-browser") as one:
        assert one["panel"].startswith("http://127.0.0.1:")
    serve = [*COMMAND, "serve", "gs-c200s", "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0"]
    process = subprocess.Popen(serve, stdout=subprocess.PIPE, text=True)
    try:
        process.stdout.readline()
        control = process.stdout.readline().strip().partition(": ")[2]
        with started("panel", "--attach", control, "--no-browser") as found, page(found["panel"]) as ask:
            assert list(ask(do="view")["view"]["chips"]) == ["gs_c200s"]
    finally:
        process.terminate()
        process.wait(PATIENCE)
        process.stdout.close()


@pytest.mark.system
def test_attached_to_a_wrong_port_or_without_its_token(call):
    """And nothing of the question reaches the module, whose port it is."""
    serve = ["serve", "gs-c200s", "--tcp", "127.0.0.1:0", "--control", "127.0.0.1:0", "--token", "a long token"]
    with subprocess.Popen([*COMMAND, *serve], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            line, control = (process.stdout.readline().strip().rpartition(" ")[2] for _ in range(2))
            for where, more, says in (
                (line.removeprefix("socket://"), (), "no control port answers there; use the address that slewline"),
                (control, (), "must include the token of this server"),
                (control, (), "give it with --token, or in the environment, SLEWLINE_TOKEN"),
                (control, ("--token", "another token"), "must include the token of this server"),
            ):
                ran = call("panel", "--no-browser", "--attach", where, *more)
                assert ran.status == 2
                assert says in ran.err
        finally:
            process.terminate()
            process.wait(PATIENCE)
        assert "unfinished" not in process.stderr.read()


def when_the_panel_runs(*row):
    """A mistake that is found when the process of the panel has been started."""
    return pytest.param(*row, marks=pytest.mark.system)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "give exactly one of these: a chip, a bench file, a program, --attach HOST:PORT"),
        (
            ["cy525", "--attach", "127.0.0.1:1"],
            "give exactly one of these: a chip, a bench file, a program, --attach HOST:PORT",
        ),
        (["--attach", "127.0.0.1:1", "--rate", "2"], "leave out --rate"),
        (["--attach", "127.0.0.1:1"], "--attach 127.0.0.1:1: Connection refused; give the control port of a running"),
        when_the_panel_runs(["cy526"], "cy525"),
        when_the_panel_runs(["nothing.cy525"], "nothing.cy525"),
        (["cy525", "--listen", "0.0.0.0:0"], "--allow-remote"),
        when_the_panel_runs(["cy525", "--rate", "fast"], "fast"),
        (["b.toml", "--strap", "chs=0"], "leave out --chip, --strap"),
    ],
)
def test_a_mistake_is_reported_and_nothing_is_left(call, arguments, says):
    before = {*threading.enumerate()}  # those of other tests may end meanwhile
    ran = call("panel", "--no-browser", *arguments)
    assert ran.status == 2
    assert says in ran.err
    assert not {*threading.enumerate()} - before and not multiprocessing.active_children()
