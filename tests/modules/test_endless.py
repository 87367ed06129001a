"""Ports that never fall silent: every exchange with one is over after the time that its characters take."""

from __future__ import annotations

import os
import threading
import time
from itertools import count

import pytest

import slewline.testing  # noqa: F401  # pySerial knows slewline://
from slewline.chips import sheet_of
from slewline.cli.main import invoke
from slewline.modules import module as exchanges
from slewline.modules import spoken
from slewline.modules.conversation import Conversation
from slewline.modules.dialogue import DialogueFile, DialogueHeader
from slewline.modules.echo import EchoFilter
from slewline.modules.failures import EndlessInput, PortLost
from slewline.modules.finding import find
from slewline.modules.module import Module
from slewline.modules.module_port import ModulePort
from slewline.modules.speech import speech_of
from tests.modules.conftest import Taken

SLACK_S = 0.5
SENTENCE = b"$GPGGA,1\r\n"


class Talker:
    """A pseudo-terminal whose other end sends something again and again, and may answer questions before.

    Args:
        data: what it sends.
        pause: seconds in between.
        answers: by what was received; after the last of them it begins to send.
    """

    def __init__(self, data, pause, answers=()):
        import tty

        self.data, self.pause, self.answers = data, pause, list(answers)
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        os.set_blocking(self.master, False)
        self.where = os.ttyname(self.slave)
        self.over = threading.Event()
        self.thread = threading.Thread(target=self._talk)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()
        os.close(self.master)
        os.close(self.slave)

    def _talk(self):
        received = b""
        while self.answers and not self.over.wait(0.005):
            try:
                received += os.read(self.master, 1000)
            except BlockingIOError:
                continue
            for question, answer in self.answers:
                if question in received:
                    os.write(self.master, answer)
                    self.answers.remove((question, answer))
                    received = b""
                    break
        for number in count():
            if self.over.wait(self.pause):
                return
            try:
                os.write(self.master, self.data[number % len(self.data)] if isinstance(self.data, list) else self.data)
            except BlockingIOError:  # nobody reads at the moment
                continue


@pytest.fixture
def brisk(monkeypatch):
    """Let an exchange be over soon; it ends by that alone."""
    monkeypatch.setattr(spoken, "SLACK_S", SLACK_S)
    monkeypatch.setattr(spoken, "ANSWER_S", SLACK_S)
    monkeypatch.setattr(exchanges, "REPORT_S", SLACK_S / 5)


DRIP = [b"$", b"G", b"P"]  # never a line, and never as silent as the end of an answer
ENDLESS = {"chatter": (SENTENCE, 0.01), "no line ends": (b"x" * 20, 0.01), "drip": (DRIP, 0.1)}
PROGRAMS = {"gs-c200s": "Po\nS10\nR5\nPx\n", "cy545": "E\nR 5\nQ\n"}


@pytest.mark.posix
@pytest.mark.system
@pytest.mark.parametrize("how", ENDLESS)
@pytest.mark.parametrize("part", ["gs-c200s", "cy545", "cy525"])
def test_pull_push_and_compare_end_at_a_port_that_never_falls_silent(tmp_path, monkeypatch, capfd, brisk, part, how):
    monkeypatch.chdir(tmp_path)
    calls = [("pull", "-o", f"saved.{part}")]
    if part in PROGRAMS:
        (tmp_path / f"p.{part}").write_text(PROGRAMS[part])
        calls.append(("push", f"p.{part}"))
    with DialogueFile("d.dialogue", DialogueHeader(part, baud=9600), print) as file:
        probe = speech_of(sheet_of(part)).probe
        file.host(probe.encode() + b"\r", 0)
        file.module(b"V+2\r", 10**9)
    calls.append(("compare", "d.dialogue", "--port"))
    for command, *rest in calls:
        with Talker(*ENDLESS[how]) as talker:
            arguments = [command, *rest, talker.where] if command == "compare" else [command, talker.where, *rest]
            status = invoke(arguments)
        _, err = capfd.readouterr()
        assert status in (1, 2), err
        assert "Traceback" not in err
        what = "GPGG" if how == "chatter" else "xxx" if how == "no line ends" else "$GP"
        assert what in err, (command, err)
    assert {*tmp_path.glob("saved.*")} <= {tmp_path / f"saved.{part}.raw"}
    assert not list(tmp_path.glob("*.before.*"))


@pytest.mark.posix
@pytest.mark.system
def test_the_time_is_that_of_the_characters_and_they_are_reported_before(capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with Talker(SENTENCE, 0.02) as talker:
        begun = time.monotonic()
        assert invoke(["pull", talker.where, "-o", "a.gs-c200s"]) == 1
        took = time.monotonic() - begun
    lines = capfd.readouterr().err.splitlines()
    assert took > spoken.SLACK_S  # that it ends at all is what matters; how soon is the business of the next tests
    assert [" has not ended; received so far: " in line for line in lines] == [True, False, False]
    assert lines[1].endswith(".raw")
    assert "$GPGGA" in lines[0]
    assert "allowed: a port that is silent without a query" in lines[2]


@pytest.mark.posix
@pytest.mark.system
def test_a_module_that_sends_endlessly_after_it_was_found_has_no_program(capfd, tmp_path, monkeypatch, brisk):
    monkeypatch.chdir(tmp_path)
    with Talker(b"+0100\r", 0.005, [(b"V2\r", b"V00\r")]) as talker:
        assert invoke(["pull", talker.where, "-o", "a.gs-c200s"]) == 1
    assert "+0100" in capfd.readouterr().err
    assert not (tmp_path / "a.gs-c200s").exists()


class Clocked:
    """A line on which a character comes every so many seconds of its own clock."""

    def __init__(self, every):
        self.now, self.every, self.in_waiting = 0.0, every, 0

    def clock(self):
        return self.now

    def read(self, size=1):
        self.now += self.every * bool(size)
        return b"x" * size

    def write(self, data):
        pass

    def close(self):
        pass


def clocked(every, part="gs-c200s", **speech):
    port = object.__new__(ModulePort)
    port.where, port.line, port.raw, port.echo = "port", Clocked(every), None, EchoFilter(False)
    spoken_as = speech_of(sheet_of(part), **speech)
    port.setting = spoken_as.setting
    return Module(port, spoken_as, Taken())


@pytest.mark.parametrize(("part", "baud"), [("gs-c200s", 9600), ("gs-c200s", 110), ("cy545", 300)])
def test_an_answer_has_twice_the_time_of_its_characters_and_5_s(part, baud):
    x = clocked(0.001, part, baud=baud)
    command = x.speech.probe
    with pytest.raises(EndlessInput, match=r"of [0-9]+ characters"):
        x.once(command)
    expected = 5 + 2 * (len(x.speech.framed(command)) + spoken.LONGEST) * x.speech.character_s
    assert x.port.line.now == pytest.approx(expected, abs=0.01)


def test_a_listing_has_the_time_of_a_full_memory_and_a_command_that_stores_its_own():
    x = clocked(0.001)
    with pytest.raises(EndlessInput):
        x.once("Q")
    assert x.port.line.now == pytest.approx(5 + 2 * (120 * 11 + 2) * x.speech.character_s, abs=0.01)
    x = clocked(0.001)
    with pytest.raises(EndlessInput):
        x.once("M")
    assert x.port.line.now > spoken.STORED_S


def test_a_process_that_was_stopped_has_not_waited():
    x = clocked(0.001)
    line, read = x.port.line, x.port.line.read

    def stopped(size=1):
        if size and line.now == 0:
            line.now += 1000
        data = read(size)
        return b"V+2\r" if line.now > 1000.1 else data

    line.read = stopped
    assert x.once("V2").text.endswith("V+2")


def test_a_port_that_takes_no_characters_is_reported():
    from serial import SerialTimeoutException

    x = clocked(0.001)

    def write(_data):
        raise SerialTimeoutException("Write timeout")

    x.port.line.write = write
    with pytest.raises(PortLost, match="has accepted no characters for 5 s"):
        x.send(b"V2\r")


def test_a_person_sees_unsolicited_text_and_continues():
    x = Conversation(clocked(0.01))
    x.module.port.line.in_waiting = 1
    assert set(x.unasked()) == {"x"}
    assert x.module.port.line.now < 2
    assert "has not ended after" in x.say("V2").failure
    assert x.say(":send V2\\r").lines
    assert x.say(":quit").over


def test_a_slow_search_reports_its_received_characters():
    said = []
    with pytest.raises(OSError, match="no GS-C200S answers V2"):
        find(
            "slewline://gs-c200s?chs=0&br0=1&br1=1&br2=1",
            sheet_of("gs-c200s"),
            baud=None,
            address=3,
            report=said.append,
        )
    assert [line.endswith("; other rates are being tried") for line in said] == [True]
