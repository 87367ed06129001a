"""Ports that are no device: what is said of one that cannot be opened, and of a server that has a host already."""

from __future__ import annotations

import gc
import socket
import threading
from contextlib import closing

import pytest

from slewline.chips import sheet_of
from slewline.cli.main import invoke
from slewline.errors import UsageError
from slewline.links.ports.urls import dismissal, unopened
from slewline.modules.failures import PortLost
from slewline.modules.finding import find
from slewline.modules.module_port import ModulePort
from slewline.modules.speech import speech_of
from slewline.testing.endpoints import running
from tests.links.conftest import PATIENCE, until
from tests.ports import free_port

pytest.importorskip("serial")

SETTING = speech_of(sheet_of("gs-c200s"), None, None, None).setting
HAS = "has this port; one host at a time; end the other program, and call again"
NO_PORTS = [  # what is given, the end of the answer
    ("socket://127.0.0.1:{free}", "connection refused: nothing listens at 127.0.0.1:{free}; start its server first"),
    ("rfc2217://127.0.0.1:{free}", "connection refused: nothing listens at 127.0.0.1:{free}; start its server first"),
    ("127.0.0.1:{free}", "is an address; write the port of another program as socket://127.0.0.1:{free}, a device"),
    ("localhost:{free}", "another program as socket://localhost:{free}, a device /dev/ttyUSB0 or COM3"),
    ("{free}", "is an address; write the port of another program as socket://127.0.0.1:{free}, a device"),
    ("tcp://127.0.0.1:{free}", "the port of another program as socket://127.0.0.1:{free}, a device"),
    ("socket://127.0.0.1", "expected socket://HOST:PORT, such as socket://127.0.0.1:4001, with a port of 1 to 65535"),
    ("rfc2217://127.0.0.1", "expected rfc2217://HOST:PORT, such as rfc2217://127.0.0.1:4001"),
    ("socket://127.0.0.1:99999", "expected socket://HOST:PORT, such as socket://127.0.0.1:4001"),
    (
        "http://127.0.0.1:{free}",
        "http:// is not supported here; allowed: a device, such as /dev/ttyUSB0 or COM3, socket",
    ),
    ("/dev/none:4001", "No such file or directory; name a serial port that exists"),
]


@pytest.mark.parametrize(("where", "says"), NO_PORTS)
def test_an_invalid_port_is_answered_with_a_suggestion(where, says):
    free = free_port()
    where, says = (text.format(free=free) for text in (where, says))
    with pytest.raises(UsageError) as raised:
        ModulePort(where, SETTING)
    assert str(raised.value).startswith(f"{where}: ") and says in str(raised.value)
    assert "://" not in where or "list_ports" not in str(raised.value)  # the cure of a device


@pytest.mark.parametrize(
    ("cause", "says"),
    [
        (socket.gaierror(-2, "x"), "the name 'there' cannot be resolved; correct it, or give the address in numbers"),
        (
            TimeoutError("timed out"),
            "no answer from there; check that it is on, and check the network and its firewall",
        ),
        (OSError(113, "x"), "No route to host; check the address, the network and the server"),
    ],
)
def test_a_place_that_cannot_be_reached_has_the_cure_of_a_network(cause, says):
    error = OSError("Could not open port")
    error.__context__ = cause
    assert unopened("socket://there:4001", error) == says


@pytest.fixture
def collected():
    """Let the sockets go that pySerial leaves open when the other end has hung up first, and a server that ends."""
    yield
    gc.collect()


UNCLOSED = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
COMMANDS = (  # that speak to a module
    "pull {url} -o w.gs-c200s --baud 9600",
    "pull {url} -o w.gs-c200s",
    "terminal {url} --chip gs-c200s",
    "terminal {url} --chip cy545",
)


@UNCLOSED
@pytest.mark.filterwarnings("ignore:set:DeprecationWarning")
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("kind", ["tcp", "rfc2217"])
def test_the_line_of_a_server_that_has_a_host_already_is_shown(kind, command, capsys, tmp_path, monkeypatch, collected):
    monkeypatch.chdir(tmp_path)
    module = running("gs-c200s", straps={"chs": 0}, on=kind)
    host, _, number = module.url.partition("://")[2].rpartition(":")
    try:
        with socket.create_connection((host, int(number)), PATIENCE) as first:
            until(lambda: bool(module.rig.do(lambda: module.rig.line.host_name)))
            name = "{}:{}".format(*first.getsockname())
            assert invoke(command.format(url=module.url).split()) == (1 if kind == "tcp" else 2)
    finally:
        module.close()
    assert f"{module.url}: the server reports: {name} {HAS}" in capsys.readouterr().err


@UNCLOSED
def test_a_server_that_disconnects_silently_is_gone(collected):
    server = socket.create_server(("127.0.0.1", 0))

    def hang_up():
        for _ in range(2):  # the port is asked again
            server.accept()[0].close()

    thread = threading.Thread(target=hang_up, daemon=True)
    thread.start()
    with closing(server), pytest.raises(PortLost, match=r"the port is gone \(.*\); start its server again, and try"):
        find(f"socket://127.0.0.1:{server.getsockname()[1]}", sheet_of("gs-c200s"), baud=9600)
    thread.join(PATIENCE)


def test_only_the_words_of_a_server_at_the_end_are_its_reason():
    assert dismissal(b"V70\rslewline: x has this port\r\n").startswith("the server reports: x has this port; ")
    assert dismissal(b"slewline: x\r\nV70\r") == dismissal(b"slewline: \x1b[2J\r\n") == dismissal(b"") == ""
