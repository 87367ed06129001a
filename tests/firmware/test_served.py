"""The emulated board behind a pseudo-terminal: DTR, inputs, supply, a damaged line."""

from __future__ import annotations

import termios
import time

import pytest
import serial

from slewline.drive.board import wire
from slewline.drive.board.records import Record
from slewline.drive.board.wire import Answer, BoardConfig, BoardEvent, FrameKind, Happening, Ident, encode

from .served import ServedBoard

pytestmark = [pytest.mark.posix, pytest.mark.timeout(60)]


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
        end = time.monotonic() + 5
        while time.monotonic() < end:
            answers = [said for said in self.hear() if isinstance(said, Answer)]
            if len(answers) > before:
                return answers[before]
        raise AssertionError(f"no answer; {self.said}")

    def begin(self, **config):
        self.ask(0, FrameKind.HELLO)
        self.ask(0, FrameKind.CONFIG, BoardConfig(16_000, **config).pack())
        self.ask(1, FrameKind.RESET, wire.reset_payload(0))


def until_it_has_made(board, steps):
    """Wait; a busy machine may be behind."""
    end = time.monotonic() + 20
    while len(board.steps()) < steps:
        assert time.monotonic() < end
        time.sleep(0.02)


def events(host):
    return [Happening(said.kind) for said in host.hear(0.3) if isinstance(said, BoardEvent)]


def test_it_runs_in_real_time_and_stops_by_an_input(board):
    host = Host(board)
    host.begin(reflex=(1, 0, 0, 0, 0, 0))
    assert any(isinstance(said, Ident) for said in host.said)
    host.ask(2, FrameKind.PUSH, Record(0, 60_000, 2_000).pack())
    tick = host.ask(3, FrameKind.START, wire.start_payload(host.ask(9, FrameKind.ASK).tick + 1_600_000)).tick
    until_it_has_made(board, 400)
    board.set_input(0, 0)
    assert Happening.STOPPED in events(host)
    stopped = [said for said in host.said if isinstance(said, BoardEvent)][-1]
    assert stopped.position == len(board.steps()) > 300
    assert board.status()["overruns"] == 0
    assert board.steps()[0][0] > tick
    host.line.close()


def test_opening_the_port_resets_it_unless_hupcl_was_cleared(board):
    host = Host(board)
    host.hear(0.1)
    resets = board.status()["resets"]
    assert resets == 1
    host.line.close()
    time.sleep(0.2)
    host = Host(board, stays=True)
    host.ask(0, FrameKind.HELLO)
    assert board.status()["resets"] == 2
    host.line.close()
    time.sleep(0.2)
    host = Host(board)
    assert host.ask(0, FrameKind.ASK).events == 1
    assert board.status()["resets"] == 2
    host.line.close()


def test_without_supply_nothing_moves_and_the_count_is_gone(board):
    host = Host(board)
    host.begin()
    host.ask(2, FrameKind.PUSH, Record(0, 60_000, 2_000).pack())
    host.ask(3, FrameKind.START, wire.start_payload(host.ask(9, FrameKind.ASK).tick + 1_600_000))
    until_it_has_made(board, 400)
    board.supply(False)
    made = len(board.steps())
    time.sleep(0.1)
    assert len(board.steps()) == made > 100
    board.supply(True)
    assert events(host)[-1] == Happening.BOOT
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
    said = host.hear(0.1)
    assert any(isinstance(each, Answer) and each.result == wire.FrameResult.DAMAGED for each in said) or None in said
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
