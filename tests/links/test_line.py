"""Lines, noise and the transcript, without any socket."""

from __future__ import annotations

import os
import random
from pathlib import Path

import pytest

import slewline
from slewline.errors import UsageError
from slewline.links.lines.pace import Lockstep, Paced
from slewline.links.lines.served_line import ANSWER_TIMEOUT_PS, BACKLOG
from slewline.links.server import Server
from slewline.links.views.server_status import as_line, status
from slewline.parts.lines.noise import LINKED, Noise

from .conftest import STRAPS

CHARACTER = 11 * 10**12 // 9600
TURNROUND = 10**9


class Host:
    """Takes what a line gives, with the instants."""

    def __init__(self, bench, line):
        self.bench, self.got, self.resumed = bench, [], 0
        line.attach("host", self.take, self.resume)

    def take(self, data):
        self.got.append((self.bench.now_ps, data))
        return 0

    def resume(self):
        self.resumed += 1

    @property
    def text(self):
        return b"".join(data for _, data in self.got)


def play(server):
    """Let time pass as far as it may."""
    while not server.pace.pass_time():
        pass


@pytest.fixture
def begun(lockstep):
    """A line in lockstep that nobody serves, and a host on it."""

    def make(**options):
        server, line = lockstep(**options)
        server.bench.run(0)
        server.pace.start()
        return server, line, Host(server.bench, line)

    return make


def test_characters_take_their_time_in_both_directions(begun):
    server, line, host = begun()
    start = server.bench.now_ps
    line.take(b"F\r")
    play(server)
    end = start + 2 * CHARACTER + TURNROUND
    assert [data for _, data in host.got] == [b"R", b"\r"]
    for (instant, _), characters in zip(host.got, (1, 2), strict=True):
        assert abs(instant - (end + characters * CHARACTER)) <= 2  # picoseconds of rounding


def test_time_passes_a_minute_for_what_came_last(begun):
    server, line, _ = begun()
    line.quiet = lambda: False
    line.take(b"F")
    server.bench.run("50 s")
    again = server.bench.now_ps
    line.take(b"F")
    play(server)
    assert server.bench.now_ps == again + ANSWER_TIMEOUT_PS


def test_time_stops_after_the_answer(begun):
    server, line, host = begun()
    line.take(b"F\r")
    play(server)
    assert 0 <= server.bench.now_ps - host.got[-1][0] <= 1


def test_the_eighth_bit_does_not_count(begun):
    server, line, host = begun()
    line.take(bytes(byte | 0x80 for byte in b"F\r"))
    play(server)
    assert host.text == b"R\r"


def test_a_silent_module_is_waited_for_only_to_the_limit(begun):
    server, line, _ = begun()
    line.quiet = lambda: False
    line.take(b"F")
    play(server)
    assert server.bench.now_ps == 10**9 + ANSWER_TIMEOUT_PS
    assert not server.pace.waits


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_unread_characters_are_counted(begun):
    server, line, _ = begun()
    line.detach("has gone")
    line.take(b"F\r")
    play(server)
    assert (line.taken, line.given, line.dropped) == (2, 0, 2)


def test_room_is_bounded_and_comes_back(begun):
    server, line, host = begun()
    assert line.room() == BACKLOG
    line.take(b"F" * BACKLOG)
    assert (line.room(), host.resumed) == (0, 0)
    play(server)
    assert host.resumed == 1
    assert line.room() == BACKLOG


def test_memory_does_not_grow_with_the_output_of_a_module(begun):
    server, line, host = begun()
    for _ in range(50):
        line.take(b"F\r")
        play(server)
    assert len(host.text) == 100
    assert len(line.port.received) <= 1


# ------------------------------------------------------------------------------------------------------------- noise
@pytest.mark.parametrize(
    ("kind", "answer"), [("lost", b""), ("garbled", b"E2\r"), ("parity", b"E1\r"), ("framing", b"E1\r")]
)
def test_noise_on_the_line_to_the_module(begun, kind, answer):
    server, line, host = begun()
    line.to_chip.plan(kind, seed=3)
    line.take(b"F\r")
    play(server)
    assert host.text == answer
    line.take(b"F\r")
    play(server)
    assert host.text == answer + b"R\r"  # only one character was hit
    assert line.to_chip.done[kind] == 1


@pytest.mark.parametrize(("kind", "answer"), [("lost", b"\r"), ("parity", b"\0\r"), ("framing", b"\0\r")])
def test_noise_on_the_line_to_the_host(begun, kind, answer):
    server, line, host = begun()
    line.to_host.plan(kind)
    line.take(b"F\r")
    play(server)
    assert host.text == answer


def test_noise_by_chance_is_repeatable():
    def hits(seed):
        noise = Noise(7, LINKED)
        noise.plan("garbled", 20, 0.1, seed)
        return [noise.hit(0x41) for _ in range(1000)]

    assert hits(1) == hits(1) != hits(2)
    garbled = [byte for byte, _ in hits(1) if byte != 0x41]
    assert len(garbled) == 20
    assert all((byte ^ 0x41).bit_count() == 1 and byte < 128 for byte in garbled)


def test_plans_queue_up():
    noise = Noise(7, LINKED)
    noise.plan("lost", 2)
    noise.plan("parity")
    assert [noise.hit(1) for _ in range(4)] == [(None, ""), (None, ""), (1, "parity"), (1, "")]


@pytest.mark.parametrize(
    "plan", [("loud",), ("lost", 0), ("lost", 1.5), ("lost", 1, 0), ("lost", 1, 1.1), ("lost", 1, "often")]
)
def test_a_plan_makes_sense(plan):
    with pytest.raises(UsageError, match="allowed"):
        Noise(7, LINKED).plan(*plan)


# --------------------------------------------------------------------------------------------------------- transcript
def test_the_transcript_has_both_directions_in_virtual_time(begun):
    server, line, _ = begun(log="transcript")
    line.take(b"F\rV")
    play(server)
    line.take(b"1\r")
    play(server)
    line.detach("hung up")
    server.close()
    lines = Path("transcript").read_text().splitlines()
    assert [line.split(maxsplit=1)[1] for line in lines] == [
        "x ! host is connected",
        "x < F\\r",
        "x < V",
        "x > R\\r",
        "x < 1\\r",
        "x > V+0\\r",
        "x ! host: hung up",
    ]
    assert [line.split()[0] for line in lines[:3]] == ["0.001000"] * 3


def test_findings_are_in_the_transcript(begun):
    server, line, _ = begun(log="transcript")
    line.to_chip.plan("parity")
    line.take(b"F\r")
    play(server)
    server.close()
    assert (
        " x ! E1: b'F': a parity or framing error: this module is set to 9600 baud, 7 data bits"
        in Path("transcript").read_text()
    )


def test_a_transcript_that_cannot_be_written_is_reported(lockstep):
    with pytest.raises(UsageError, match="give a file that can be written"):
        lockstep(log="nowhere/transcript")


@pytest.mark.posix
@pytest.mark.parametrize("path", ["fifo", "/dev/null"])
def test_a_transcript_goes_to_a_regular_file_only(lockstep, path):
    """To open a FIFO is to wait for its other end."""
    os.mkfifo("fifo")
    with pytest.raises(UsageError, match="is not a regular file; give a file, or - for standard error"):
        lockstep(log=path)


def test_a_disk_that_is_full_is_reported_once_and_the_server_continues(begun):
    server, line, host = begun(log="transcript")
    server.log.close()
    server.log.file = open("/dev/full", "w", buffering=1)  # noqa: SIM115
    for _ in range(2):
        line.take(b"F\r")
        play(server)
    says = "log transcript: No space left on device; the transcript ends here"
    assert status(server)["troubles"] == [says]
    assert says in as_line(server)
    assert host.text == b"R\rR\r"
    server.close()


def test_a_journal_that_takes_no_more_is_reported_once_and_the_server_continues(begun):
    server, line, host = begun(journal="journal")
    told = []
    server.report = told.append
    journal = server.bench.journal
    journal.close()
    journal.file = open("/dev/full", "w", buffering=1)  # noqa: SIM115
    for _ in range(2):
        line.take(b"F\r")
        play(server)
    says = "journal journal: No space left on device; the journal ends here"
    assert told == status(server)["troubles"] == [says]
    assert host.text == b"R\rR\r"
    server.close()
    assert list(slewline.replay("journal").chips) == ["x"]  # what is in it is good


# ------------------------------------------------------------------------------------- served and in virtual time alike
@pytest.mark.parametrize("paced", [False, True])
def test_served_and_in_virtual_time_alike(paced, folder):
    """The same bytes at the same virtual instants, whether a module is served or spoken to in virtual time."""
    chance = random.Random(4)
    bench = slewline.Bench(journal="journal")
    wall = [0]
    pace = Paced(bench, 1, lambda: wall[0]) if paced else Lockstep(bench)
    server = Server(bench, pace)
    line = server.line(bench.add("gs-c200s", name="x", straps=STRAPS))
    host = Host(bench, line)
    bench.run(0)
    pace.start()
    sent = []
    for text in (
        b"S50\rT200\rR20\r",
        b"Po\r+400\rG0\rD3\rE\r",
        b"F\r",
        b"V1\r",
        b"V2",
        b"\rM\r",
        b"F\r",
        b"Z\r",
        b"V1\r",
        b"Q\r",
    ):
        wall[0] += chance.randrange(30_000_000)
        pace.present()
        sent.append((bench.now_ps, text))
        line.take(text)
        play(server)
    wall[0] += 2 * 10**9 // 2
    play(server)
    server.close()

    twin = slewline.Bench()
    twin.add("gs-c200s", name="x", straps=STRAPS)
    port = twin.part("serial_port", to="x")
    heard = []
    port.on_character.add(heard.append)
    for instant, text in sent:
        twin.run_to(instant)
        port.write(text)
    twin.run_to(bench.now_ps)
    assert [(c.end_ps, bytes([c.byte])) for c in heard if c.end_ps <= bench.now_ps] == host.got
    assert len(host.got) > 30
    assert twin["x"].position == bench["x"].position

    again = slewline.replay("journal")
    assert (again.now_ps, again["x"].position) == (bench.now_ps, bench["x"].position)
    assert bytes(again["x_line"].received)[: len(host.text)] == host.text
