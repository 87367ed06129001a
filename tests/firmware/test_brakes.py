"""Brakes of a board whose steps are fast: each ends in a way down, at the count that it tells, as that of the twin."""

from __future__ import annotations

from random import Random

import pytest

from slewline.drive.board import wire
from slewline.drive.board.records import Record
from slewline.drive.board.wire import FrameKind, Happening, Reflex
from slewline.drive.stopping.stop_ramps import spread
from tests.ensembles import members

from .chain import phase_lags
from .dialogue import told_to_twin
from .emulated import PHASES_WITHIN
from .test_rates import HALVES, HZ, Host, events, ramp

pytestmark = pytest.mark.system

WAIT = 6_000_000  # ticks, in which a way down ends
WATCHDOG = 60_000
FEW, MANY = 2, 100
LONG = pytest.mark.long


class BrakedHost(Host):
    """A host that remembers what it has said."""

    def __init__(self, *args, **more):
        self.chunks = []  # ticks are not known, nor needed
        super().__init__(*args, **more)

    def say(self, kind, payload=b""):
        number = self.number
        super().say(kind, payload)
        self.chunks.append((0, wire.encode(number, kind, payload)[:-1]))


def braked(emulator, rate, cause, phase, way, length, pattern=(0,) * 8, slope=0, **config):
    """A board at a rate that brakes for a cause; it has a way down from any rate."""
    top = HZ / rate
    up = ramp(top, 800)[:40]
    slew = [Record(0, length, int(top)) for _ in range(6000 // length)]
    if way is not None:
        slew = [record.with_ramp_left(way, slope) for record in slew]
    silent = cause == "watchdog"
    host = BrakedHost(
        emulator,
        up + slew,
        busy=not silent,
        watchdog=WATCHDOG if silent else 0,
        reflex=(Reflex.BRAKE, Reflex.ESTOP, 0, 0, 0, 0),
        pattern=pattern,
        **config,
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
    elif cause == "emergency stop":
        host.board.set_input(1, 0, host.board.now + 1)
    elif cause == "stop":
        host.say(FrameKind.STOP, b"\1")
    host.busy = False
    host.board.run(host.board.now + WAIT)
    return host


def check(host, cause):
    """The board has made a way down, as the twin does, and each step had its phases in time."""
    board = host.board
    lead = {"underrun": Happening.UNDERRUN, "watchdog": Happening.WATCHDOG}.get(cause, Happening.BRAKED)
    assert [Happening(event.kind) for event in events(board)] == [lead, Happening.HALTED]
    assert events(board)[-1].position == len(board.rises)
    twin = told_to_twin(board, host.chunks)
    assert [tick for tick, _, _ in twin.steps] == board.rises
    assert bytes(twin.sent) == b"".join(frame for _, frame in board.frames)
    if twin.phases:
        assert phase_lags(board)[0].max() <= PHASES_WITHIN


@pytest.mark.parametrize("cause", ["underrun", "stop", "input", "watchdog"])
@pytest.mark.parametrize(
    ("rate", "way"),
    [(27_000, None), (45_000, 40), pytest.param(27_000, 40, marks=LONG), pytest.param(45_000, None, marks=LONG)],
)
@members("phases", FEW, MANY, at_once=MANY)
def test_a_brake_ends_in_a_stop_ramp(emulator, rate, cause, way, phases):
    for phase in phases:
        # with short records the one more step is now and then that of the next one
        length, pattern = 100 if phase % 2 else 23, HALVES if phase % 3 else (0,) * 8
        check(braked(emulator, rate, cause, phase, way, length, pattern), cause)


@members("seeds", 2, 202, at_once=200)
def test_brakes_at_any_rate_with_stop_ramps_of_any_length(emulator, seeds):
    for seed in seeds:
        random = Random(seed)
        cause = random.choice(["underrun", "stop", "input", "watchdog"])
        slope, length = random.choice((-1, 0, 1)), random.randint(20, 120)
        way = random.randint(length if slope < 0 else 1, 160)
        rate = random.uniform(20_000, 40_000)  # a way that begins with a piece of one step may be late at 43,000
        check(braked(emulator, rate, cause, random.randrange(1000), way, length, HALVES, slope), cause)


@pytest.mark.parametrize(
    ("rate", "way", "length", "phases"),
    [
        (39_649, 155, 114, range(90, 120, 3)),  # the second piece has one step: the next one comes in its interrupt
        (39_649, 90, 60, (0, 50, 115)),
        (38_000, 120, 60, range(95, 130, 5)),
        (38_000, 90, 23, range(5, 30, 5)),
    ],
)
def test_steps_of_short_pieces_have_their_phases_in_time(emulator, rate, way, length, phases):
    for phase in phases:
        check(braked(emulator, rate, "stop", phase, way, length, HALVES, -1), "stop")
