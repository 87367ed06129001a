"""A Pico on a pseudo-terminal, in real time: old programs and the tools of slewline find the same module."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest
import serial

from .emulated import HZ, US, Emulator, Pico

pytestmark = [pytest.mark.system, pytest.mark.posix, pytest.mark.timeout(240)]
SLICE = 0.002  # seconds between two looks at the line
MOST = 20_000 * US  # of the board in one go
STRAPS = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
PROGRAM = "Po\nS100\nT500\nR20\nL0\n+200\n-200\nL2\nA1\nPx\n"


class Served:
    """A board with a pseudo-terminal at its line; `port` is the name of the other end."""

    def __init__(self, emulator: Emulator) -> None:
        self.board = Pico(emulator, **STRAPS)
        self.board.power_up()
        self.board.run(self.board.up + 1000 * US)
        self.master, self.slave = pty.openpty()
        tty.setraw(self.slave)
        self.port = os.ttyname(self.slave)
        os.set_blocking(self.master, False)
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self._serve)
        self.thread.start()

    def _serve(self) -> None:
        board, begun, first, free = self.board, time.monotonic(), self.board.now, 0
        while not self.ended.wait(SLICE):
            try:
                data = os.read(self.master, 256)
            except BlockingIOError:
                data = b""
            if data:
                free = board.send(data, max(free, board.now + 1000))
            # If it cannot keep up, its time passes more slowly.
            board.run(min(first + round((time.monotonic() - begun) * HZ), board.now + MOST))
            done = [(at, each) for at, each in board.characters() if at + 11 * board.bit <= board.now]
            if done:
                os.write(self.master, "".join(each for _, each in done).encode("latin-1"))
                last = done[-1][0] + 11 * board.bit - board.bit // 2
                board.changes[:] = [change for change in board.changes if change[0] > last]

    def close(self) -> None:
        """End it."""
        self.ended.set()
        self.thread.join()
        os.close(self.master)
        os.close(self.slave)


@pytest.fixture
def served(boards: Emulator) -> Iterator[Served]:
    """A board with a port."""
    served = Served(boards)
    yield served
    served.close()


def slewline(*words: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a command of slewline."""
    call = [sys.executable, "-m", "slewline", *map(str, words)]
    return subprocess.run(call, capture_output=True, text=True, check=False, timeout=200)


def old_program(port: str) -> list[str]:
    """Do what a program with pySerial does; return the answers."""
    answers = []
    with serial.serial_for_url(port, 9600, bytesize=7, parity="O", stopbits=2, timeout=30) as line:
        for text in ("F", "Po", "S100", "T500", "R20", "+300", "zoo", "Px", "E", "F", "V1", "K", "V2"):
            line.write(f"{text}\r".encode())
            answers.append(line.read_until(b"\r").decode())
            if text == "F":
                time.sleep(2.5 if answers[-1] == "B\r" else 0)
    return answers


def test_a_program_with_pyserial_gets_the_same_answers_as_from_a_served_module(served: Served, tmp_path: Path) -> None:
    words = [
        sys.executable,
        "-m",
        "slewline",
        "serve",
        "gs-c200s",
        "--strap",
        "chs=0",
        "--pty",
        str(tmp_path / "module"),
    ]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as module:
        assert module.stdout is not None
        module.stdout.readline()
        try:
            model = old_program(str(tmp_path / "module"))
        finally:
            module.terminate()
            module.communicate()
    assert old_program(served.port) == model
    assert model[-3:] == ["V+300\r", "Y\r", "V70\r"]


def test_push_stores_a_program_and_pull_saves_it(served: Served, tmp_path: Path) -> None:
    (tmp_path / "weld.gs-c200s").write_text(PROGRAM, "ascii")
    words = ("--chip", "gs-c200s", "--baud", "9600", "--no-checksum")
    pushed = slewline("push", served.port, tmp_path / "weld.gs-c200s", *words, "--store", "--move")
    assert pushed.returncode == 0, pushed.stdout + pushed.stderr
    pulled = slewline("pull", served.port, "-o", tmp_path / "saved.gs-c200s", *words, "--eeprom")
    assert pulled.returncode == 0, pulled.stdout + pulled.stderr
    saved = (tmp_path / "saved.gs-c200s").read_text("utf-8")
    assert all(line in saved for line in PROGRAM.split()[1:-1])


def test_compare_plays_a_dialogue_to_the_board_and_finds_no_difference(served: Served, tmp_path: Path) -> None:
    dialogue = tmp_path / "fixed.dialogue"
    words = [
        sys.executable,
        "-m",
        "slewline",
        "serve",
        "gs-c200s",
        "--strap",
        "chs=0",
        "--pty",
        str(tmp_path / "module"),
    ]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as module:
        assert module.stdout is not None
        module.stdout.readline()
        where = tmp_path / "module"
        proxy = [sys.executable, "-m", "slewline", "proxy", "--serial", str(where), "--chip", "gs-c200s"]
        with subprocess.Popen(
            [*proxy, "--pty", str(tmp_path / "between"), "--dialogue", str(dialogue)], stdout=subprocess.PIPE, text=True
        ) as between:
            assert between.stdout is not None
            between.stdout.readline()
            old_program(str(tmp_path / "between"))
            between.terminate()
            between.communicate()
        module.terminate()
        module.communicate()
    # It is answers that count: the emulated board is as late as a busy machine lets it be; its times are held to the
    # model's in virtual time (test_pico_dialogues).
    compared = slewline("compare", dialogue, "--port", served.port, "--move", "--replace", "--tolerance", "30 s")
    assert compared.returncode == 0, compared.stdout + compared.stderr


def test_the_board_passes_its_check(served: Served) -> None:
    words = ("--baud", "9600", "--no-checksum", "--replace", "--move", "--tolerance", "30 s")
    checked = slewline("firmware", "gs-c200s", "--check", served.port, *words)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert checked.stdout.startswith("gs-c200s: 48 exchanges, 0 differences;")
