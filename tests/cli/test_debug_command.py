"""slewline debug: what it refuses, and the port that it opens for other front ends."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time

import pytest

from tests.links.conftest import PATIENCE


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((), "give exactly one of these: a program, a chip, a bench file, --attach HOST:PORT"),
        (
            ("cy525", "--attach", "4002"),
            "give exactly one of these: a program, a chip, a bench file, --attach HOST:PORT",
        ),
        (("--attach", "4002", "--chip", "cy525"), "--attach debugs a running server"),
        (("cell.toml", "--chip", "cy525"), "a bench file names its chips"),
        (("cy525", "--rate", "0"), "--rate 0: allowed 0.001 to 1000"),
    ],
)
def test_refused_arguments(call, arguments, says):
    ran = call("debug", *arguments)
    assert ran.status == 2
    assert says in ran.err


BY_THE_SERVER = [
    (("nosuch.cy525",), "nosuch.cy525 cannot be read"),
    (("nosuch.toml",), "nosuch.toml cannot be read"),
    (("cy525", "--strap", "slew=1"), "a strap sets an input to 0 or 1"),
]


@pytest.mark.parametrize(("arguments", "says"), BY_THE_SERVER)
def test_refusals_of_the_server(call, arguments, says):
    ran = call("debug", *arguments, "--control", "127.0.0.1:0")
    assert ran.status == 2
    assert says in ran.err


@pytest.mark.system
@pytest.mark.parametrize(("arguments", "says"), BY_THE_SERVER)
def test_the_refusal_of_the_server_is_passed_on(call, arguments, says):
    ran = call("debug", *arguments)
    assert ran.status == 2
    assert says in ran.err


@pytest.mark.system
@pytest.mark.parametrize("arguments", [("cy525",), ("--attach", "127.0.0.1:1")])
def test_without_a_terminal_it_draws_nothing_and_ends(arguments):
    call = [sys.executable, "-m", "slewline", "debug", *arguments]
    ran = subprocess.run(call, stdin=subprocess.DEVNULL, capture_output=True, timeout=PATIENCE, check=False)
    assert (ran.returncode, ran.stdout) == (2, b"")
    assert b"debug needs a terminal for its screen" in ran.stderr and b"\x1b" not in ran.stderr


def test_without_textual(call, monkeypatch):
    for name in [name for name in sys.modules if name.startswith(("textual", "slewline.panel"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "textual", None)
    ran = call("debug", "cy525")
    assert ran.status == 2
    assert ran.err.startswith("slewline: the debugger needs textual: pip install textual")


@pytest.mark.system
def test_a_custom_front_end(write):
    program = write("five.cy525", "F 3", "R 100", "S 254", "Z 1", "A 0", "N 5", "G")
    call = [sys.executable, "-m", "slewline", "debug", program, "--control", "127.0.0.1:0", "--while-input"]
    with subprocess.Popen(call, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=os.environ) as process:
        host, port = process.stdout.readline().decode().removeprefix("control: ").strip().split(":")
        with socket.create_connection((host, int(port)), PATIENCE) as connection, connection.makefile("rwb") as lines:

            def ask(**request):
                lines.write(json.dumps(request).encode() + b"\n")
                lines.flush()
                return json.loads(lines.readline())

            first = ask(do="view")
            time.sleep(0.05)
            assert first["view"]["pace"]["paused"]
            assert ask(do="view")["time_ps"] == first["time_ps"]
            assert ask(do="until", chip="cy525", position=5)["met"]
        process.stdin.close()  # what has started it has gone
        assert process.wait(PATIENCE) == 0
