"""The emulated board behind a pseudo-terminal: DTR, inputs, supply, a damaged line."""

from __future__ import annotations

import termios
import time

import pytest
import serial

from slewline.drive.board import wire
from slewline.drive.board.records import Record
from slewline.drive.board.wire import Answer, BoardConfig, BoardEvent, FrameKind, Happening, Ident, encode

from ..links.conftest import PATIENCE
from .served import HZ, ServedBoard

pytestmark = [pytest.mark.posix, pytest.mark.system]
MANY = Record(0, 60_000, 2_000).pack()  # steps for 7.5 s


@pytest.fixture
def board(firmware):
    with ServedBoard(firmware) as board:
        yield board


class Host:
    """The least that can talk."""

    def __init__(self, board, stays=False):
        self.line = serial.Serial(board.port, 500_000, timeout=0.005)
        if stays:
            settings = termios.tcgetattr(self.line.fd)
            settings[2] &= ~termios.HUPCL
            termios.tcsetattr(self.line.fd, termios.TCSANOW, settings)
        self.decoder, self.said = wire.Decoder(), []

    def hear(self, seconds=0.0):
        end = time.monotonic() + seconds
        while True:
            for frame in self.decoder.feed(self.line.read(4096)):
                self.said.append(wire.read(frame) if isinstance(frame, wire.Frame) else None)
            if time.monotonic() >= end:
                return self.said

    def ask(self, number, kind, payload=b""):
        """Send a frame, and return its answer."""
        before = sum(isinstance(said, Answer) for said in self.said)
        self.line.write(encode(number, kind, payload))
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            answers = [said for said in self.hear() if isinstance(said, Answer)]
            if len(answers) > before:
                return answers[before]
        raise AssertionError(f"no answer; {self.said}")

    def until(self, met):
        """Hear until something is met of what was said; return that."""
        end = time.monotonic() + PATIENCE
        while not (found := [said for said in self.hear() if met(said)]):
            assert time.monotonic() < end, self.said
        return found[0]

    def start(self):
        """Start many steps 100 ms from now; a board that is asked too late refuses, and is asked again."""
        for number in range(2, 6):
            assert self.ask(number, FrameKind.PUSH, MANY).result == wire.FrameResult.TAKEN
        while True:
            soon = wire.start_payload(self.ask(9, FrameKind.ASK).tick + HZ // 10)
            answer = self.ask(6, FrameKind.START, soon)
            if answer.result == wire.FrameResult.TAKEN:
                return answer.tick
            assert answer.result == wire.FrameResult.LATE

    def begin(self, **config):
        self.ask(0, FrameKind.HELLO)
        self.ask(0, FrameKind.CONFIG, BoardConfig(16_000, driver=0, **config).pack())
        self.ask(1, FrameKind.RESET, wire.reset_payload(0))


def until_it_has_made(board, steps):
    """Wait; a busy machine may be behind."""
    end = time.monotonic() + PATIENCE
    while len(board.steps()) < steps:
        assert time.monotonic() < end
        time.sleep(0.02)


def until_nobody_has_it_open(board):
    """Wait until the board has seen that its port was closed."""
    end = time.monotonic() + PATIENCE
    while board.status()["open"]:
        assert time.monotonic() < end
        time.sleep(0.005)


def happened(kind):
    """Return whether what was said tells of something that has happened."""
    return lambda said: isinstance(said, BoardEvent) and said.kind == kind


def test_it_runs_in_real_time_and_stops_by_an_input(board):
    host = Host(board)
    host.begin(reflex=(1, 0, 0, 0, 0, 0))
    assert any(isinstance(said, Ident) for said in host.said)
    tick = host.start()
    until_it_has_made(board, 400)
    board.set_input(0, 0)
    stopped = host.until(happened(Happening.STOPPED))
    assert stopped.position == len(board.steps()) > 300
    assert board.status()["overruns"] == 0
    assert board.steps()[0][0] > tick
    host.line.close()


def test_opening_the_port_resets_it_unless_hupcl_was_cleared(board):
    host = Host(board)
    host.ask(0, FrameKind.HELLO)
    assert board.status()["resets"] == 1
    host.line.close()
    until_nobody_has_it_open(board)
    host = Host(board, stays=True)
    host.ask(0, FrameKind.HELLO)
    assert board.status()["resets"] == 2
    host.line.close()
    until_nobody_has_it_open(board)
    host = Host(board)
    assert host.ask(0, FrameKind.ASK).events == 1
    assert board.status()["resets"] == 2
    host.line.close()


def test_without_supply_nothing_moves_and_the_count_is_gone(board):
    host = Host(board)
    host.begin()
    host.start()
    until_it_has_made(board, 400)
    host.said.clear()
    board.supply(False)
    made = len(board.steps())
    time.sleep(0.1)
    assert len(board.steps()) == made > 100
    board.supply(True)
    host.until(happened(Happening.BOOT))
    assert [bool(life) for life in board.lives()] == [False, True, False]
    assert host.ask(0, FrameKind.ASK).state == wire.BoardState.BOOT
    host.line.close()


def test_a_damaged_line_damages_frames(board):
    host = Host(board)
    host.begin()
    board.damage(0.05, seed=3)
    for number in range(40):
        host.line.write(encode(number, FrameKind.ASK))
        host.hear(0.01)
    host.until(lambda said: said is None or (isinstance(said, Answer) and said.result == wire.FrameResult.DAMAGED))
    host.line.close()


def test_a_pulled_cable_comes_back_under_its_name(board):
    host = Host(board)
    host.begin()
    board.unplug()
    with pytest.raises((OSError, serial.SerialException)):
        for _ in range(50):
            host.line.read(10)
            host.line.write(b"\0")
    host.line.close()
    board.plug()
    host = Host(board)
    assert host.ask(0, FrameKind.ASK).state == wire.BoardState.BOOT
    host.line.close()
