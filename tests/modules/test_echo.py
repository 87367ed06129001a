"""Lines that echo: a bridge on a real pty sends back what a tool sends, in front of a module that is served."""

from __future__ import annotations

import io
import os
import select
import socket
import sys
import threading
import time
import tty
from contextlib import suppress
from pathlib import Path

import pytest

from slewline.core.wires.serial import CharacterFormat, LineSetting
from slewline.links.ports.pty import PtyPort
from slewline.modules.dialogue import DialogueFile, DialogueHeader, RecordedDialogue
from slewline.modules.echo import LATE_S, EchoFilter
from slewline.modules.recording_proxy import DialogueRecorder, Proxy
from tests.cli.conftest import call, folder, installed, write  # noqa: F401
from tests.links.conftest import PATIENCE, serve, until  # noqa: F401
from tests.rows import rows

SERVED = ("gs-c200s", "--strap", "chs=0", "--tcp", "127.0.0.1:0")
WELD = ("Po", "S10", "T100", "R5", "+50", "Px")
SAYS = "sent characters come back: this line echoes, as an adapter for two wires (RS-485) or a modem does; give --echo"
FORMAT = LineSetting(9600, CharacterFormat(7, "odd", 2))


# ---------------------------------------------------------------------------------------------------------- the filter
@rows(
    ("sent", "came", "rest"),
    [
        ([b"V2\r"], [b"V2\rV+0\r"], b"V+0\r"),
        ([b"V2\r"], [b"V", b"2", b"\rV", b"+0\r"], b"V+0\r"),
        ([b"V", b"2", b"\r"], [b"V2\r", b"V+0\r"], b"V+0\r"),
        ([b"V2\r"], [b"V+0\r"], b"V+0\r"),  # no echo, and the same first character
        ([b"S10\r", b"T5\r"], [b"S10\rY\rT5\rY\r"], b"Y\rY\r"),
        ([b"S10\r"], [b"Y\rS10\r"], b"Y\r"),  # late, after the answer
        ([b"V2\r"], [b"VV2\r+0\r"], b"V+0\r"),  # within an answer
        ([b"S10\r"], [b"S10\rS10\r"], b"S10\r"),  # an answer that is the same is no echo of anything
        ([b"S10\r"], [b"S1\x000\rY\r"], b"S1\x000\rY\r"),  # damaged: whatever it is, it is not what was sent
        ([b"\xff\r"], [b"\xff\r! garbled\r\n"], b"! garbled\r\n"),
        ([b"F\r", b"F\r"], [b"F\rR\rF\rR\r"], b"R\rR\r"),
        ([], [b"Y\r"], b"Y\r"),
    ],
)
def test_exactly_what_was_sent_is_dropped(sent, came, rest):
    echo = EchoFilter(True)
    for data in sent:
        echo.sent(data, 0.0, 0.01)
    assert b"".join(echo.rest(data, 0.1) for data in came) == rest
    silent = EchoFilter(False)
    for data in sent:
        silent.sent(data, 0.0, 0.01)
    assert b"".join(silent.rest(data, 0.1) for data in came) == b"".join(came) and silent.seen == echo.seen


def test_an_echo_is_expected_for_a_time_alone():
    echo = EchoFilter(True)
    echo.sent(b"V2\r", 10.0, 0.01)
    assert echo.rest(b"V", 10.2) == b"" and echo.keeps
    assert echo.rest(b"", 10.0 + LATE_S + 0.02) == b"V"  # it was no echo after all
    assert echo.rest(b"2\r", 11.0) == b"2\r" and echo.seen == 0


def test_characters_are_waited_for_as_long_as_they_take():
    echo = EchoFilter(True)
    for number in range(100):
        echo.sent(b"+1000\r", 0.0, 0.0075)
        assert echo.until == pytest.approx(LATE_S + 0.0075 * (number + 1))


# ---------------------------------------------------------------------------------------------------------- the bridge
class EchoBridge:
    """A pty whose far end is a module on TCP; what is written comes back, `late` seconds after it has gone on."""

    def __init__(self, where, late=None):
        self.late, self.echoed = late, bytearray()
        self.module = socket.create_connection(where.rpartition("//")[2].rsplit(":", 1))
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.port = os.ttyname(self.slave)
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.over = False
        self.timers = []
        self.thread.start()

    def run(self):
        with suppress(OSError):
            while not self.over:
                ready, _, _ = select.select([self.master, self.module], [], [], 0.05)
                if self.master in ready:
                    data = os.read(self.master, 4096)
                    if self.late is None:
                        self.echo(data)
                        self.module.sendall(data)
                    else:
                        self.module.sendall(data)
                        self.timers.append(threading.Timer(self.late, self.echo, [data]))
                        self.timers[-1].start()
                if self.module in ready:
                    os.write(self.master, self.module.recv(4096))

    def echo(self, data):
        self.echoed += data
        os.write(self.master, data)

    def close(self):
        self.over = True
        self.thread.join()
        for timer in self.timers:  # a busy machine makes them late
            timer.join()
        self.module.close()
        os.close(self.master)
        os.close(self.slave)


@pytest.fixture
def bridge(serve):  # noqa: F811
    made = []

    def make(served=SERVED, **options):
        made.append(EchoBridge(serve(*served).where, **options))
        return made[-1]

    yield make
    for one in made:
        one.close()


real = [pytest.mark.posix, pytest.mark.system]


@pytest.fixture
def commands(call, write, monkeypatch):  # noqa: F811
    """Each command that opens the port of a module, with what it prints or writes when all is right."""
    program = write("weld.gs-c200s", *WELD)

    def talk(port, *more):
        monkeypatch.setattr(sys, "stdin", io.StringIO("V1\nF\n"))
        return call("terminal", port, "--part", "gs-c200s", "--dialogue", "talk.dialogue", *more)

    return {
        "push": lambda port, *more: call("push", port, program, *more),
        "pull": lambda port, *more: call("pull", port, "-o", "saved.gs-c200s", *more),
        "terminal": talk,
    }


def said(path):
    return [each.text for each in RecordedDialogue.read(path).entries if each.speaker == "module"]


@pytest.mark.parametrize("late", [None, 0.001, 0.05])
@pytest.mark.posix
@pytest.mark.system
def test_with_the_option_all_commands_work(bridge, commands, call, late):  # noqa: F811
    """0.05 s late is after the answer."""
    line = bridge(late=late)
    pushed = commands["push"](line.port, "--echo")
    assert pushed.status == 0 and "verified" in pushed.err, pushed.err
    pulled = commands["pull"](line.port, "--echo")
    assert pulled.status == 0, pulled.err
    assert Path("saved.gs-c200s").read_text().splitlines()[3:] == [*WELD]
    talked = commands["terminal"](line.port, "--echo")
    assert talked.status == 0 and "V+0  (" in talked.out and "\nR  (" in talked.out, talked
    assert said("talk.dialogue") == ["V+0\r", "R\r"]
    compared = call(
        "compare", "talk.dialogue", "--port", line.port, "--echo", "--tolerance", "30 s"
    )  # it is answers that count
    assert compared.status == 0 and "2 exchanges, 0 differences" in compared.out, compared
    assert len(line.echoed) > 50


@pytest.mark.posix
@pytest.mark.system
def test_without_the_option_all_commands_suggest_it(bridge, commands, call):  # noqa: F811
    line = bridge()
    for name, command in commands.items():
        for more in ((), ("--baud", "9600"), ("--baud", "9600", "--no-checksum")):
            before = len(line.echoed)
            found = command(line.port, *more)
            assert found.status == 1 and f"{line.port}: {SAYS}" in found.err, (name, more, found)
            assert len(line.echoed) - before < 20  # no other rate was tried
            assert not Path("saved.gs-c200s").exists()
    assert commands["terminal"](line.port, "--echo").status == 0
    compared = call("compare", "talk.dialogue", "--port", line.port)
    assert compared.status != 0 and SAYS in compared.err, compared


@pytest.mark.posix
@pytest.mark.system
def test_the_option_on_a_line_that_does_not_echo_is_refused(commands, serve):  # noqa: F811
    where = serve(*SERVED).where.rpartition("//")[2]
    found = commands["pull"](f"socket://{where}", "--echo")
    assert found.status == 2 and "this line does not echo; leave out --echo" in found.err, found


@pytest.mark.parametrize(
    "served", [("cy525", "--framing"), ("cy545b",)], ids=["an adapter", "a part that answers queries"]
)
@pytest.mark.posix
@pytest.mark.system
def test_other_kinds_of_lines(bridge, call, served):  # noqa: F811
    line = bridge((*served, "--tcp", "127.0.0.1:0"))
    name = f"saved.{served[0]}"
    found = call("pull", line.port, "-o", name)
    assert found.status == 1 and SAYS in found.err, found
    found = call("pull", line.port, "-o", name, "--echo")
    assert found.status == 0 and Path(name).exists(), found


# ----------------------------------------------------------------------------------------------------------- the proxy
class ProxiedHost:
    """A host at the pty of a proxy, before a line that echoes."""

    def __init__(self, device, echo):
        self.told = []
        self.file = DialogueFile("x.dialogue", DialogueHeader("gs-c200s"), self.told.append)
        self.proxy = Proxy(device, FORMAT, DialogueRecorder(self.file), self.opened, self.told.append, echo)
        self.thread = threading.Thread(target=self.proxy.run)
        self.thread.start()
        self.host = os.open("host", os.O_RDWR | os.O_NOCTTY)

    def opened(self, loop, line):
        return PtyPort(loop, line, "host")

    def ask(self, command, number):
        """Send a line; return so many characters of what comes."""
        os.write(self.host, command)
        found = b""
        while len(found) < number:
            assert select.select([self.host], [], [], PATIENCE)[0], found
            found += os.read(self.host, 100)
        return found

    def end(self):
        self.proxy.stop()
        self.thread.join(PATIENCE)
        self.proxy.close()
        os.close(self.host)


@pytest.mark.parametrize(("echo", "answer"), [(True, b"V+0\r"), (False, b"V1\rV+0\r")])
@pytest.mark.posix
@pytest.mark.system
def test_the_proxy_passes_on_and_records_no_echo_with_the_option(bridge, folder, echo, answer):  # noqa: F811
    line = bridge()
    host = ProxiedHost(line.port, echo)
    try:
        for _ in range(3):
            assert host.ask(b"V1\r", len(answer)) == answer
            time.sleep(0.05)
    finally:
        host.end()
    assert "".join(said("x.dialogue")) == answer.decode() * 3
    hint = [text for text in host.told if "this line echoes; give --echo" in text]
    assert len(hint) == (0 if echo else 1)


@pytest.mark.posix
@pytest.mark.system
def test_the_proxy_keeps_nothing_back_that_was_no_echo(bridge, folder):  # noqa: F811
    """The beginning of what was sent comes from the module, and then nothing: it is passed on after a while."""
    line = bridge()
    host = ProxiedHost(line.port, True)
    try:
        assert host.ask(b"V1\r", 4) == b"V+0\r"
        whole, line.echo = line.echo, lambda data: os.write(line.master, data[:1])
        assert host.ask(b"V1", 1) == b"V"  # of a line without an end, which the module does not answer
        line.echo = whole
        assert host.ask(b"\r", 4) == b"V+0\r"
    finally:
        host.end()
