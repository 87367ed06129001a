"""The proxy, between real ptys and sockets: every character passes, at once, and is in the record."""

from __future__ import annotations

import os
import random
import select
import signal
import socket
import subprocess
import sys
import termios
import threading
import time
import tty
from itertools import groupby
from operator import itemgetter

import pytest
import serial

from slewline.chips import sheet_of
from slewline.core.wires.serial import CharacterFormat, LineSetting
from slewline.errors import UsageError
from slewline.links.ports.pty import PtyPort
from slewline.links.ports.tcp import TcpPort
from slewline.modules import recording_proxy
from slewline.modules.comparing.model_differences import DialogueComparison, Tolerance
from slewline.modules.dialogue import DialogueFile, DialogueHeader, RecordedDialogue
from slewline.modules.recording_proxy import DialogueRecorder, LatenessHistogram, Proxy
from slewline.modules.speech import speech_of
from tests.links.conftest import PATIENCE, until
from tests.modules import lateness

pytestmark = [pytest.mark.posix, pytest.mark.system]
PLAIN = LineSetting(9600, CharacterFormat(8, "none", 1))
COMMAND = [sys.executable, "-m", "slewline", "proxy", "--part", "gs-c200s"]


class Running:
    """A proxy in a thread, between two ptys: `module` and `host` are descriptors of their far ends."""

    def __init__(self, folder, file=None, kind="pty"):
        self.path, self.told = folder / "x.dialogue", []
        self.module, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.device = folder / "ttyUSB0"
        self.device.symlink_to(os.ttyname(self.slave))
        self.file = file or DialogueFile(self.path, DialogueHeader("gs-c200s"), self.told.append)

        def port(loop, line):
            if kind == "pty":
                return PtyPort(loop, line, str(folder / "host"))
            return TcpPort(loop, line, "127.0.0.1:0")

        self.proxy = Proxy(str(self.device), PLAIN, DialogueRecorder(self.file), port, self.told.append)
        self.thread = threading.Thread(target=self.proxy.run)
        self.thread.start()
        self.socket = None
        if kind == "pty":
            self.host = os.open(folder / "host", os.O_RDWR | os.O_NOCTTY)
        else:
            self.socket = socket.create_connection(self.proxy.port.where.rpartition("/")[2].split(":"))
            self.host = self.socket.fileno()

    def end(self):
        self.proxy.stop()
        self.thread.join(PATIENCE)
        self.proxy.close()
        if self.socket is None:
            os.close(self.host)
        else:
            self.socket.close()
        for end in (self.module, self.slave):
            os.close(end)
        return RecordedDialogue.read(self.path)


def read(fd, count):
    """Return so many characters."""
    found = b""
    while len(found) < count:
        assert select.select([fd], [], [], PATIENCE)[0], found
        found += os.read(fd, count - len(found))
    return found


def spoken(path):
    """What was said by host and module, in a file; a line between whose characters a second has passed is in pieces."""
    said = [(each.speaker, each.text) for each in RecordedDialogue.read(path).entries if each.speaker != "tool"]
    return ["".join(text for _, text in turn) for _, turn in groupby(said, itemgetter(0))]


@pytest.fixture
def start(tmp_path):
    made = []

    def run(**options):
        made.append(Running(tmp_path, **options))
        return made[-1]

    yield run
    for one in made:
        if one.thread.is_alive():
            one.end()


@pytest.mark.parametrize("kind", ["pty", "tcp"])
def test_every_character_passes_and_is_recorded(start, kind):
    running = start(kind=kind)
    draw = random.Random(20)
    sent = {speaker: bytes(draw.choices(range(256), k=3000)) for speaker in ("host", "module")}
    if kind == "tcp":
        sent["host"] = b"\r" + sent["host"]
    for at in range(0, 3001, 100):
        ways = ("host", running.host, running.module), ("module", running.module, running.host)
        for speaker, here, there in ways:
            part = sent[speaker][at : at + 100]
            os.write(here, part)
            assert read(there, len(part)) == part
    found = running.end()
    for speaker, data in sent.items():
        assert b"".join(said.data for said in found.entries if said.speaker == speaker) == data


def test_a_host_that_sends_large_blocks_is_throttled_and_loses_nothing(start):
    running = start()
    data = bytes(random.Random(3).choices(range(256), k=200_000))

    def write():
        left = memoryview(data)
        while left:
            left = left[os.write(running.host, left) :]

    writer = threading.Thread(target=write)
    writer.start()
    time.sleep(0.2)
    assert running.proxy.waiting <= 3 * 4096  # far less than what has come
    assert read(running.module, len(data)) == data
    writer.join(PATIENCE)


def test_times_are_those_of_the_characters(start, monkeypatch):
    monkeypatch.setattr(recording_proxy, "SILENCE_S", PATIENCE)  # however long this takes, it is one line
    running = start()
    began = time.monotonic()
    os.write(running.host, b"F")
    read(running.module, 1)
    time.sleep(0.2)
    os.write(running.host, b"\r")
    read(running.module, 1)
    os.write(running.module, b"R\r")
    read(running.host, 2)
    took = time.monotonic() - began
    said = [each for each in running.end().entries if each.speaker != "tool"]
    assert [each.text for each in said] == ["F\r", "R\r"]
    assert 200_000 <= said[0].last_us - said[0].at_us <= took * 1e6
    assert said[0].last_us <= said[1].at_us <= said[1].last_us <= said[0].at_us + took * 1e6


def test_an_unfinished_line_is_written_after_a_silence(start):
    running = start()
    os.write(running.host, b"V1")
    until(lambda: b'"V1"' in running.path.read_bytes())


def test_the_rate_that_a_host_sets_is_set_on_the_serial_port(start, tmp_path):
    running = start()
    with serial.Serial(str(tmp_path / "host"), 4800, timeout=PATIENCE) as port:
        until(lambda: termios.tcgetattr(running.slave)[5] == termios.B4800)
        port.write(b"F\r")
        assert read(running.module, 2) == b"F\r"
    assert "the host has set 4800 baud" in [said.text for said in running.end().entries]


def test_rts_and_cts_are_those_of_the_serial_port(start, tmp_path):
    running = start()
    with serial.Serial(str(tmp_path / "host"), 9600, rtscts=True):
        until(lambda: termios.tcgetattr(running.slave)[2] & termios.CRTSCTS)


def test_a_cable_that_is_pulled_and_put_back(start, tmp_path):
    running = start()
    running.device.unlink()
    old = running.module, running.slave
    running.module, running.slave = os.openpty()
    tty.setraw(running.slave)
    for end in old:
        os.close(end)
    until(lambda: running.told)
    assert running.told[0].startswith(f"{running.device}: gone")
    os.write(running.host, b"lost\r")
    until(lambda: running.proxy.module.lost)
    running.device.symlink_to(os.ttyname(running.slave))
    until(lambda: len(running.told) > 1)
    assert running.told[1] == f"{running.device}: back"
    os.write(running.host, b"F\r")
    assert read(running.module, 2) == b"F\r"
    texts = [said.text for said in running.end().entries]
    assert "module: takes no characters; 5 and all further ones are lost" in texts


def test_a_slow_disk_makes_no_character_late(start, tmp_path):
    passed = threading.Event()

    class StuckFile(DialogueFile):
        """A file on a disk that takes nothing of the host's for a long time."""

        def _write(self, entry):
            assert entry.get("from") != "host" or passed.wait(2 * PATIENCE)
            return super()._write(entry)

    running = start(file=StuckFile(tmp_path / "x.dialogue", DialogueHeader("gs-c200s")))
    for _ in range(20):
        os.write(running.host, b"F\r")
        assert read(running.module, 2) == b"F\r"  # nothing waits for the disk
    assert b'"host"' not in running.path.read_bytes()
    passed.set()
    running.end()
    assert spoken(running.path) == ["F\r" * 20]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_a_full_disk_is_reported_and_the_characters_continue(start, tmp_path):
    told = []
    file = DialogueFile(tmp_path / "x.dialogue", DialogueHeader("gs-c200s"), told.append)
    file._file.close()
    file._file = open("/dev/full", "r+b", buffering=0)  # noqa: SIM115
    running = start(file=file)
    for _ in range(3):
        os.write(running.host, b"F\r")
        assert read(running.module, 2) == b"F\r"
    until(lambda: told)
    running.end()
    assert told == [f"dialogue {file.path}: No space left on device; it ends here, the 0 lines before are kept"]


def test_a_port_that_cannot_be_opened_leaves_no_trace(tmp_path):
    path = tmp_path / "x.dialogue"
    call = [*COMMAND, "--serial", "/dev/ttyUSB77", "--pty", tmp_path / "host", "--dialogue", path]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("slewline: /dev/ttyUSB77: No such file or directory; name a serial port that exists")
    assert not path.exists()
    assert not os.path.lexists(tmp_path / "host")


def test_a_dialogue_that_is_there_stays(tmp_path):
    path = tmp_path / "x.dialogue"
    path.write_text("precious")
    call = [*COMMAND, "--serial", "/dev/ttyUSB77", "--pty", tmp_path / "host", "--dialogue", path]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert (done.returncode, path.read_text()) == (2, "precious")
    assert "this file exists; name a new file" in done.stderr


def test_one_port_for_the_host_is_wanted(tmp_path):
    for ports in ([], ["--pty", "a", "--tcp", "127.0.0.1:0"]):
        call = [*COMMAND, "--serial", "x", "--dialogue", tmp_path / "x", *ports]
        done = subprocess.run(call, capture_output=True, text=True, check=False)
        assert done.returncode == 2
        assert "give either --pty LINK or --tcp HOST:PORT" in done.stderr


def test_other_machines_need_leave(tmp_path):
    running = Running(tmp_path)
    try:
        with pytest.raises(UsageError, match="add --allow-remote"):
            TcpPort(running.proxy.loop, running.proxy.host, "0.0.0.0:0")
    finally:
        running.end()


HOST = f"""
import serial, sys, termios, time

def opened():
    end = time.monotonic() + {PATIENCE}
    while True:  # an open right after a close fails, until the proxy has seen the close
        try:
            return serial.Serial(sys.argv[1], 9600, bytesize=7, parity="O", stopbits=2, timeout={PATIENCE})
        except termios.error:
            if time.monotonic() > end:
                raise
            time.sleep(0.05)

for _ in range(10):
    with opened() as port:
        port.write(b"V1\\r")
        assert port.read_until(b"\\r") == b"V+0\\r"
"""
SAID = ["V1\r", "V+0\r"] * 10


@pytest.fixture
def proxied(serve, tmp_path):
    """Start the command between a served module and a pty; return both links, the file, and the process."""
    module, host, path = tmp_path / "module", tmp_path / "host", tmp_path / "x.dialogue"
    serve("gs-c200s", "--pty", module, "--strap", "chs=0")
    call = [*COMMAND, "--serial", module, "--pty", host, "--dialogue", path]
    process = subprocess.Popen(call, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == f"host: {host}\n"
    yield host, path, process
    if process.poll() is None:
        process.kill()
    process.communicate()


def test_a_host_opens_it_as_7o2_again_and_again(proxied):
    host, path, process = proxied
    subprocess.run([sys.executable, "-c", HOST, host], check=True, timeout=PATIENCE)
    process.terminate()
    out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out) == (0, "")
    assert "to the module: 30 characters, half of them within" in err
    assert "to the host: 40 characters" in err
    assert spoken(path) == SAID
    assert RecordedDialogue.read(path).header.baud == 9600
    assert not os.path.lexists(host)


def test_a_recorded_dialogue_is_compared(proxied):
    host, path, process = proxied
    subprocess.run([sys.executable, "-c", HOST, host], check=True, timeout=PATIENCE)
    process.terminate()
    process.communicate(timeout=PATIENCE)
    dialogue = RecordedDialogue.read(path)
    tolerance = Tolerance(round(PATIENCE * 1e6), 0)  # a busy machine makes answers late
    found = DialogueComparison(dialogue, speech_of(sheet_of("gs-c200s"), 9600), tolerance).compare()
    assert (found.exchanges, found.rows) == (10, [])
    assert min(found.delays_us) > -1_000  # no answer came before it could


def test_after_a_kill_the_record_has_all_that_was_sent(proxied):
    host, path, process = proxied
    subprocess.run([sys.executable, "-c", HOST, host], check=True, timeout=PATIENCE)
    until(lambda: spoken(path) == SAID)  # soon: a thread of its own writes it
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert spoken(path) == SAID


def test_a_browser_reaches_no_module(start):
    running = start(kind="tcp")
    running.socket.sendall(b"POST / HTTP/1.1\r\nHost: x\r\n\r\nG\r")
    running.socket.settimeout(PATIENCE)
    assert running.socket.recv(10) == b""
    assert not select.select([running.module], [], [], 0.1)[0]
    assert any("speaks HTTP" in said.text for said in running.end().entries)


def test_a_histogram_counts_characters():
    found = LatenessHistogram()
    assert str(found) == "no characters"
    for late_us in range(100):
        found.note(late_us * 10_000, 2)
    found.note(50_000_000)
    assert found.characters == 201
    assert (found.within_us(0.5), found.within_us(0.99), found.within_us(1)) == (510, 1000, 50_000)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["tcp", "pty"])
def test_a_character_is_late_by_a_millisecond_at_most_next_to_busy_processes(kind):
    """A pty delivers by threads of the system, which busy processes hold up: its own lateness is measured, too."""
    direct, *proxied = lateness.measured(kind, 10)
    line_us = lateness.share_us(direct, 0.99)
    for late in proxied:
        assert lateness.share_us(late, 0.99) <= (2 * line_us if kind == "pty" else 0) + 1000
        assert lateness.share_us(late, 0.5) <= 500
