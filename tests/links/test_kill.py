"""kill -9 at any moment: what a module has answered Y to is in its EEPROM after the restart.

Each round starts the server on the same directory, sees what X recalls, enters another program, saves it with M, and is
killed: most often between the carriage return of M and 50 ms after its Y, else at some moment before.
"""

from __future__ import annotations

import select
import socket
import subprocess
import sys
import time
from random import Random

import pytest

from slewline.language.lines import framed

DEADLINE_S = 60.0  # for whatever must come some time, on a machine of any speed
BEHIND_S = 0.05
NEAR = 0.7  # the share of rounds that are killed around the answer to M


class Served:
    """A server process, and a host that is connected to it."""

    def __init__(self, directory, *how):
        command = "from slewline.cli.main import main; main()"
        words = ["serve", "gs-c200s", "--tcp", "127.0.0.1:0", "--state", str(directory), *how]
        words += ["--option", "eeprom_time=20 ms"]
        self.process = subprocess.Popen([sys.executable, "-c", command, *words], stdout=subprocess.PIPE, text=True)
        where = self.process.stdout.readline().strip()
        address, port = where.rpartition("socket://")[2].rsplit(":", 1)
        self.socket = socket.create_connection((address, int(port)), DEADLINE_S)
        self.received = b""

    def ask(self, command, end=b"\r"):
        """Send a command, and wait for its answer."""
        self.socket.sendall(framed(command))
        return self.answer(DEADLINE_S, end)

    def answer(self, seconds, end=b"\r"):
        """What comes within so many seconds of the wall clock, up to and including `end`; empty if it does not."""
        until = time.monotonic() + seconds
        while end not in self.received:
            left = until - time.monotonic()
            if left <= 0 or not select.select([self.socket], [], [], left)[0]:
                return b""
            data = self.socket.recv(1000)
            assert data, "the server has closed the connection"
            self.received += data
        line, self.received = self.received.split(end, 1)[0] + end, self.received.split(end, 1)[1]
        return line

    def kill(self):
        """kill -9; returns what had been sent and not been read."""
        self.process.kill()
        self.process.wait()
        self.socket.settimeout(DEADLINE_S)
        left = self.received
        try:
            while data := self.socket.recv(1000):
                left += data
        except ConnectionResetError:
            pass
        self.close()
        return left

    def close(self):
        """Let go of everything; the process has ended, or ends now."""
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.socket.close()


class Rounds:
    """Kills, one after the other, of servers on one directory."""

    def __init__(self, directory, seed):
        self.directory, self.random = directory, Random(seed)
        self.allowed = [()]  # what may be found in the EEPROM: the last program answered Y, or one in question
        self.number = 0
        self.before = self.after = self.elsewhere = 0  # kills before Y, up to 50 ms after it, and at other moments
        self.answer_s = 0.05  # how long the answer to M takes here

    def found(self, server):
        """The program that X recalls."""
        assert server.ask("X") == b"YY\r"
        listing = server.ask("Q", framed("END"))
        return tuple(line[:-1].decode() for line in listing.split(b"\r")[:-2])

    def check(self, server):
        """The program is one of those that may be there, whole."""
        program = self.found(server)
        assert program in self.allowed, f"round {self.number}"
        self.allowed = [program]

    def round(self):
        """Start, check, enter the next program, save it or do not, kill."""
        self.number += 1
        server = Served(self.directory, *(["--lockstep"] if self.number % 2 else ["--rate", "10"]))
        try:
            self.check(server)
            program = ("S10", "T100", "R50", *(f"+{self.number}" for _ in range(self.random.randrange(1, 25))))
            stop = len(program) if self.random.random() < NEAR else self.random.randrange(len(program))
            for command in ("Po", *program[:stop]):
                assert server.ask(command) == b"YY\r"
            if stop < len(program):
                self.elsewhere += 1
                server.kill()
            else:
                self.save_and_kill(server, program)
        finally:
            server.close()

    def save_and_kill(self, server, program):
        """M, and the kill around its answer."""
        self.allowed.append(program)
        began = time.monotonic()
        server.socket.sendall(framed("M"))
        answered = server.answer(DEADLINE_S if self.random.random() < 0.5 else self.random.uniform(0, self.answer_s))
        if answered:
            self.answer_s = time.monotonic() - began
            time.sleep(self.random.uniform(0, BEHIND_S))
        left = server.kill()
        self.after += bool(answered)
        self.before += not answered
        assert (answered or left) in (b"YY\r", b"", b"Y", b"YY"), (answered, left)
        if b"YY\r" in (answered, left):
            self.allowed = [program]


def killed(directory, rounds, seed):
    """So many kills, and a last look."""
    done = Rounds(directory, seed)
    for _ in range(rounds):
        done.round()
    server = Served(directory, "--lockstep")
    try:
        done.check(server)
        assert server.ask("M") == b"YY\r"
    finally:
        server.close()
    assert {path.name for path in directory.iterdir()} == {".lock", "gs_c200s.eeprom"}
    return done


@pytest.mark.system
def test_a_few_kills(tmp_path):
    killed(tmp_path, 5, 1)


@pytest.mark.long
@pytest.mark.timeout(1800)
def test_two_hundred_kills(tmp_path):
    done = killed(tmp_path, 200, 2)
    print(f"kills before Y: {done.before}, up to 50 ms after it: {done.after}, elsewhere: {done.elsewhere}")
    assert done.before + done.after >= 100
