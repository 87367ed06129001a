"""Brakes of a board whose steps are fast: each ends in a way down, at the count that it tells, as that of the twin."""

from __future__ import annotations

import pytest

from slewline.drive.board import wire
from slewline.drive.board.records import Record
from slewline.drive.board.wire import FrameKind, Happening, Reflex
from slewline.drive.stopping.ways import spread
from tests.ensembles import members

from .dialogue import told_to_twin
from .test_rates import HZ, Host, events, ramp

WAIT = 6_000_000  # ticks, in which a way down ends
WATCHDOG = 60_000
FEW, MANY = 2, 40
FAST_RATE = 27_000
HALVES = (1, 3, 2, 6, 4, 12, 8, 9)


class BrakedHost(Host):
    """A host that remembers what it has said."""

    def __init__(self, *args, **more):
        self.chunks = []  # ticks are not known, nor needed
        super().__init__(*args, **more)

    def say(self, kind, payload=b""):
        number = self.number
        super().say(kind, payload)
        self.chunks.append((0, wire.encode(number, kind, payload)[:-1]))


def braked(emulator, rate, cause, phase, way, length, pattern=(0,) * 8):
    """A board at a rate that brakes for a cause; it has a way down from any rate."""
    top = HZ / rate
    up = ramp(top, 800)[:40]
    slew = [Record(0, length, int(top)) for _ in range(6000 // length)]
    if way is not None:
        slew = [record.with_way(way, 0) for record in slew]
    silent = cause == "watchdog"
    host = BrakedHost(
        emulator,
        up + slew,
        busy=not silent,
        watchdog=WATCHDOG if silent else 0,
        reflex=(Reflex.BRAKE, 0, 0, 0, 0, 0),
        pattern=pattern,
    )
    table = spread(224, 16_000, 40)
    for first in range(0, len(table), wire.ENTRIES_A_FRAME):
        host.say(FrameKind.TAIL, wire.tail_payload(first, table[first : first + wire.ENTRIES_A_FRAME]))
        host.settle()
    host.busy = False
    for _ in range(20):
        host.feed()
        host.settle()
    host.busy = not silent
    host.say(FrameKind.START, wire.start_payload(host.board.now + 20_000))
    ticks = 80_000 + sum(record.length >> 16 for record in up) + phase * 37
    end = host.board.now + (ticks if cause != "underrun" else 4 * WATCHDOG)
    while host.board.now < end:
        if not silent:
            host.feed()
        host.board.run(min(end, host.board.now + 8000))
        host.hear()
    if cause == "input":
        host.board.set_input(0, 0, host.board.now + 1)
    elif cause == "stop":
        host.say(FrameKind.STOP, b"\1")
    host.busy = False
    host.board.run(host.board.now + WAIT)
    return host


@pytest.mark.parametrize("way", [None, 40])
@pytest.mark.parametrize("cause", ["underrun", "stop", "input", "watchdog"])
@pytest.mark.parametrize("rate", [27_000, 45_000])
@members("phases", FEW, MANY, at_once=MANY)
def test_a_brake_ends_in_a_way_down(emulator, rate, cause, way, phases):
    lead = {"underrun": Happening.UNDERRUN, "watchdog": Happening.WATCHDOG}.get(cause, Happening.BRAKED)
    late = 0
    for phase in phases:
        # with short records the one more step is now and then that of the next one
        host = braked(emulator, rate, cause, phase, way, 100 if phase % 2 else 23, HALVES if phase % 3 else (0,) * 8)
        board = host.board
        told = [Happening(event.kind) for event in events(board)]
        if cause == "input" and rate > FAST_RATE and told == [lead, Happening.LATE]:
            late += 1  # a look at an input beside a busy line may take longer than a step: a dead stop
            assert events(board)[-1].position == len(board.rises)
            continue
        assert told == [lead, Happening.HALTED], (phase, told)
        assert events(board)[-1].position == len(board.rises)
        twin = told_to_twin(board, host.chunks)
        assert [tick for tick, _, _ in twin.steps] == board.rises
        assert bytes(twin.sent) == b"".join(frame for _, frame in board.frames)
    assert late <= len(phases) / 10
