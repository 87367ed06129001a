"""Spans of time where 32 bits end: a START from another time, and more events than their numbers can show."""

from __future__ import annotations

import pytest

from slewline.drive.board import wire
from slewline.drive.board.records import PAUSE, REST, Record
from slewline.drive.board.wire import BoardState, FrameKind, FrameResult, Happening

from .dialogue import told_to_twin
from .talk import TAKEN, Talk

pytestmark = pytest.mark.system

LATE = FrameResult.LATE
LONGEST = 2**31 - 1
NEAR = 60_000  # ticks, more than a frame takes
END = Record(PAUSE | REST, 0, 300)
EDGES, APART = 200, 20_000


def same_as_the_twin(talk):
    """Whether board and twin have sent the same, and made the same steps."""
    twin = told_to_twin(talk.board, talk.chunks)
    assert bytes(twin.sent) == b"".join(frame for _, frame in talk.board.frames)
    assert [tick for tick, _, _ in twin.steps] == talk.board.rises


@pytest.mark.parametrize(
    "ahead, interval, result",
    [
        (2**28 - NEAR, 1_000, TAKEN),
        (2**28 - NEAR, LONGEST, TAKEN),
        (2**28 + NEAR, 1_000, LATE),
        (2**28 + NEAR, LONGEST, LATE),
        (2**30, 1_000, LATE),
        (2**31 - NEAR, 1_000, LATE),
        (2**31 + NEAR, LONGEST, LATE),
        (-(2**30), LONGEST, LATE),
        (-(2**28) - NEAR, 2**29, LATE),
        (-(2**28) + NEAR, 2**29, TAKEN),
        (-(2**28) + NEAR, 2**28 - 2 * NEAR, LATE),
        (-NEAR, NEAR, LATE),
        (NEAR, LONGEST, TAKEN),
    ],
)
def test_a_start_is_taken_within_seventeen_seconds(emulator, ahead, interval, result):
    talk = Talk(emulator)
    talk.say(FrameKind.PUSH, Record(0, 1, interval).pack())
    answer = talk.say(FrameKind.START, wire.start_payload(talk.board.now + ahead))
    assert answer.result == result and answer.state == (BoardState.RUN if result == TAKEN else BoardState.IDLE)
    talk.board.run(talk.board.now + 200_000)
    assert not talk.board.rises
    same_as_the_twin(talk)


def test_a_start_that_began_has_its_first_step_at_its_tick(emulator):
    talk = Talk(emulator)
    talk.say(FrameKind.PUSH, Record(0, 2, 400_000).pack() + END.pack())
    begin = talk.board.now - 100_000
    assert talk.say(FrameKind.START, wire.start_payload(begin)).result == TAKEN
    talk.board.run(begin + 900_000)
    assert talk.board.rises == [begin + 400_000, begin + 800_000]
    same_as_the_twin(talk)


def test_events_are_reported_after_a_self_test_with_more_than_half_of_their_numbers(emulator):
    talk = Talk(emulator, report=4)
    assert talk.say(FrameKind.CHECK, wire.check_payload(EDGES, APART + 500)).result == TAKEN
    begin = talk.board.now + NEAR
    for at in range(EDGES):
        talk.board.set_input(2, 1 - at % 2, begin + at * APART)
    talk.board.run(begin + (EDGES + 20) * APART)
    numbers = [event.number for event in talk.events]
    assert talk.events[-1].kind == Happening.CHECKED and numbers[-1] == EDGES + 1
    assert numbers[-8:] == list(range(EDGES - 6, EDGES + 2))
    assert talk.say(FrameKind.ASK).events == EDGES + 2
