"""The host's end against the twin of a board: what arrives once, in order, over lines of all kinds."""

from __future__ import annotations

import pytest

from slewline.drive.board import wire
from slewline.drive.board.records import PAUSE, REST, Record
from slewline.drive.board.wire import (
    Answer,
    BoardConfig,
    BoardEvent,
    BoardState,
    FrameKind,
    FrameResult,
    Happening,
    Reflex,
)
from slewline.errors import UsageError
from tests.ensembles import few

from .pipe import MS, Pipe

MARK = Reflex.MARK
CONFIG = BoardConfig(20_000, reflex=(int(MARK), 0, 0, 0, 0, 0), active=1)
LINES = {
    "clean": {},
    "late": {"late": (1 * MS, 30 * MS)},
    "frames": {"bad_frames": 0.01},
    "many frames": {"bad_frames": 0.1},
    "bytes": {"bad_bytes": 0.01},
    "late and bytes": {"late": (1 * MS, 16 * MS), "bad_bytes": 0.01},
}


def opened(pipe: Pipe, config: BoardConfig = CONFIG) -> Pipe:
    pipe.twin.inputs = 0
    pipe.link.open(config)
    pipe.link.reset(0)
    pipe.run_until(lambda: pipe.link.idle)
    assert pipe.link.is_open and pipe.twin.state == BoardState.IDLE
    return pipe


def train(count: int, interval: int = 100_000) -> list[Record]:
    """Records of which each is another one: the steps tell in which order they were played."""
    return [Record(0, 1 + at % 3, interval + 7 * at, at) for at in range(count)]


# how long each of the intervals is, so that the queue does not run dry: ticks, of which a record has two on average
INTERVALS = {"late and bytes": 700_000}


@pytest.mark.parametrize("seed", few(range(5), 1))
@pytest.mark.parametrize("line", LINES)
def test_every_record_arrives_once_and_in_order_and_every_event_is_reported_once_and_in_order(
    line: str, seed: int
) -> None:
    pipe = opened(Pipe(seed, **LINES[line], ppm=4000, begun=2**32 * 60))  # type: ignore[arg-type]
    told: list[BoardEvent] = []
    pipe.link.on_event.add(told.append)
    records = train(300, INTERVALS.get(line, 100_000))
    waiting = [*records, Record(PAUSE | REST, 0, 1000)]
    level = 0

    def turn() -> None:
        nonlocal level
        count = pipe.link.free
        pipe.link.push(waiting[:count])
        del waiting[:count]
        if pipe.chance.random() < 1000 / records[0].interval:
            level ^= 1
            pipe.twin.set_input(0, level, max(pipe.tick(pipe.now), pipe.twin.now))

    pipe.run_until(lambda: pipe.link.is_open)
    first = waiting[:40]
    del waiting[:40]
    pipe.link.push(first)
    start = pipe.clock.ticks(pipe.now) + 80_000_000
    pipe.link.start(start)
    pipe.each_turn = turn
    pipe.run_until(lambda: not waiting and pipe.twin.state != BoardState.RUN, most=60_000 * MS)
    pipe.each_turn = lambda: None
    pipe.run(300 * MS)  # the last ones may be on their way
    pipe.run_until(lambda: pipe.link.idle)
    expected, base = [], start << 16
    for record in records:
        expected += [time >> 16 for time in record.times(base)]
        base += record.length
    assert [tick for tick, _, _ in pipe.twin.steps] == expected
    assert [event.number for event in told] == [number % 256 for number in range(told[0].number, pipe.twin._event)]
    assert told[0].number == 1  # behind that of the power-up
    assert {event.kind for event in told} == {Happening.REST, Happening.MARK} and len(told) > 10
    rest = next(event for event in told if event.kind == Happening.REST)
    assert rest.tick == (base >> 16) + 1000 and rest.position == sum(record.count for record in records)
    if line == "clean":
        assert pipe.link.resent == pipe.link.damaged == 0
    elif line != "late":
        assert pipe.damages > 0


def test_refusals_of_the_board_are_reported_and_the_following_records_continue() -> None:
    pipe = opened(Pipe(1))
    refused: list[Answer] = []
    pipe.link.on_refused.add(refused.append)
    pipe.link.start(pipe.clock.ticks(pipe.now))  # nothing to play
    pipe.link.outputs(3, 1)
    pipe.link.push(train(7))
    pipe.link.start(pipe.clock.ticks(pipe.now) - 30_000_000)  # late
    pipe.link.outputs(3, 2)
    pipe.run_until(lambda: pipe.link.idle)
    assert [(each.kind, each.result) for each in refused] == [
        (FrameKind.START, FrameResult.WRONG_STATE),
        (FrameKind.START, FrameResult.LATE),
    ]
    assert [value for _, value in pipe.twin.outputs] == [1, 2]
    assert [*pipe.twin.queue] == train(7)


@pytest.mark.parametrize("seed", few(range(10), 4))
def test_a_refusal_on_a_bad_line_drops_that_one_alone(seed: int) -> None:
    pipe = opened(Pipe(seed, bad_frames=0.2))
    refused: list[Answer] = []
    pipe.link.on_refused.add(refused.append)
    for value in range(1, 16):
        pipe.link.start(0)
        pipe.link.outputs(15, value)
    pipe.run_until(lambda: pipe.link.idle)
    assert [value for _, value in pipe.twin.outputs] == [*range(1, 16)]
    assert {each.kind for each in refused} == {FrameKind.START} and len(refused) == 15


def test_no_more_is_unanswered_than_the_board_has_room_for() -> None:
    pipe = opened(Pipe(2, late=(10 * MS, 20 * MS)))
    in_progress = most = 0
    pipe.link.push(train(60))
    for _ in range(600):
        before = sum(len(data) for _, data in pipe.down)
        pipe.run(pipe.turn)
        in_progress = sum(each.size for each in pipe.link._flight)
        assert before <= pipe.twin.model.room
        most = max(most, in_progress)
    assert 71 <= most <= pipe.twin.model.room
    assert len(pipe.twin.queue) == 60 and pipe.link.backlog == 0 and pipe.link.free == pipe.twin.model.slots - 60


def test_records_and_all_later_messages_wait_for_slots() -> None:
    pipe = opened(Pipe(3))
    slots = pipe.twin.model.slots
    pipe.link.push(train(slots + 10))
    pipe.link.outputs(1, 1)
    pipe.run(500 * MS)
    assert len(pipe.twin.queue) == slots and pipe.link.backlog == 10 and pipe.twin.outputs == [] and pipe.link.free == 0
    pipe.link.stop(0)  # goes before them, though there is nothing to stop
    pipe.run(20 * MS)
    assert pipe.link.answer is not None and pipe.link.resent == 0


@pytest.mark.parametrize("seed", few(range(10), 4))
def test_a_stop_goes_first_and_later_messages_follow_it(seed: int) -> None:
    pipe = opened(Pipe(seed, bad_frames=0.2))
    told: list[BoardEvent] = []
    pipe.link.on_event.add(told.append)
    pipe.link.push([Record(0, 60_000, 1000)])
    pipe.link.start(pipe.clock.ticks(pipe.now) + 16_000_000)
    pipe.run_until(lambda: pipe.twin.state == BoardState.RUN)
    pipe.run(1250 * MS)
    pipe.link.stop(0)
    pipe.link.reset()
    pipe.link.push(train(3))
    pipe.run_until(lambda: pipe.link.idle)
    assert [event.kind for event in told] == [Happening.STOPPED]
    assert pipe.twin.state == BoardState.IDLE and [*pipe.twin.queue] == train(3)
    assert pipe.twin.position == told[0].position > 0


@pytest.mark.parametrize("seed", few(range(10), 4))
def test_a_boot_is_noticed_at_any_time_and_the_clock_continues(seed: int) -> None:
    pipe = opened(Pipe(seed, bad_frames=0.1))
    booted: list[int] = []
    pipe.link.on_boot.add(lambda: booted.append(pipe.now))
    for life in range(5):
        pipe.link.push(train(30))
        pipe.link.outputs(15, life + 1)
        pipe.run(pipe.chance.randrange(40) * MS)
        before = pipe.clock.nanoseconds(pipe.now)
        pipe.power_up()
        at = pipe.now
        pipe.run_until(lambda life=life: len(booted) > life, most=2000 * MS)  # type: ignore[misc]
        assert booted[-1] - at < 400 * MS
        assert not pipe.link.is_open and pipe.link.backlog == 0
        pipe.link.push(train(1))  # goes nowhere
        pipe.run(50 * MS)
        assert pipe.twin.state == BoardState.BOOT
        opened(pipe)
        assert before <= pipe.clock.nanoseconds(pipe.now) < before + 3_000 * MS
        assert abs(pipe.clock.ticks(pipe.now) - pipe.tick(pipe.now)) < 40_000
    assert len(booted) == 5


def test_a_silent_board_is_queried_again_but_not_often() -> None:
    pipe = opened(Pipe(4))
    pipe.cut = True
    sent = 0
    pipe.link.push(train(20))
    for _ in range(10_000):
        pipe.now += MS
        sent += len(pipe.link.outgoing(pipe.now))
    assert sent < 2000 and len(pipe.link._flight) < 20
    pipe.cut = False
    pipe.run_until(lambda: pipe.link.idle)
    assert [*pipe.twin.queue] == train(20)


@pytest.mark.parametrize(("cut_ms", "asks"), [(0, 0), (100, 1)])
def test_a_board_that_missed_a_hello_is_queried_for_its_state_once_it_is_open(cut_ms: int, asks: int) -> None:
    pipe = Pipe(4)
    pipe.link.open(CONFIG)
    pipe.cut = True
    pipe.run(cut_ms * MS)
    pipe.cut = False
    pipe.run_until(lambda: pipe.link.is_open)
    assert [each.kind for each in pipe.link._flight].count(FrameKind.ASK) == asks


def test_a_heartbeat_comes_each_quarter_of_the_watchdog() -> None:
    pipe = opened(Pipe(5), BoardConfig(20_000, watchdog=800_000))
    told: list[BoardEvent] = []
    pipe.link.on_event.add(told.append)
    pipe.link.push([Record(0, 3000, 16_000)])
    pipe.link.start(pipe.clock.ticks(pipe.now) + 400_000)
    pipe.run(2000 * MS)
    assert told == [] and pipe.twin.state == BoardState.RUN
    pipe.cut = True
    pipe.run(60 * MS)
    assert pipe.twin.state == BoardState.HALT


def test_events_that_the_board_has_forgotten_are_given_up_and_counted() -> None:
    pipe = opened(Pipe(6))
    told: list[BoardEvent] = []
    pipe.link.on_event.add(told.append)
    pipe.cut = True
    for at in range(24):
        pipe.twin.set_input(0, at % 2 == 0, pipe.twin.now + 10)
    pipe.run(2 * MS)
    pipe.cut = False
    pipe.run_until(lambda: len(told) == 8)
    assert [event.number for event in told] == [*range(5, 13)] and pipe.link.lost_events == 4


def test_when_it_is_due() -> None:
    pipe = Pipe(7)
    assert pipe.link.due_ns() is None and pipe.link.outgoing(pipe.now) == b""
    opened(pipe)
    due = pipe.link.due_ns()
    assert due is not None and pipe.now < due <= pipe.now + 100 * MS
    assert pipe.link.outgoing(due - 1) == b"" and pipe.link.outgoing(due) != b""
    pipe.link.push(train(1))
    assert pipe.link.due_ns() <= due + 20 * MS  # type: ignore[operator]


def test_a_malformed_frame_of_the_board_is_damage() -> None:
    pipe = opened(Pipe(8))
    pipe.link.receive(wire.encode(0, 0x90, b"x"), pipe.now)
    assert pipe.link.damaged == 1


def test_bad_content_is_refused() -> None:
    pipe = opened(Pipe(9))
    refused: list[Answer] = []
    pipe.link.on_refused.add(refused.append)
    pipe.link.push([Record(0, 1, 5)])
    pipe.link.outputs(1, 1)
    pipe.link.push(train(1))
    pipe.run_until(lambda: pipe.link.idle)
    assert [each.result for each in refused] == [FrameResult.BAD_CONTENT]
    assert [*pipe.twin.queue] == train(1)


def test_stop_has_two_modes() -> None:
    with pytest.raises(UsageError, match=r"0 \(immediately\) or 1 \(along the stop ramp\)"):
        Pipe().link.stop(2)


def test_an_answer_that_counts_frames_which_were_not_sent_takes_nothing() -> None:
    pipe = opened(Pipe(10))
    answer = pipe.link.answer
    assert answer is not None
    pipe.link.push(train(9))
    pipe.now += MS
    pipe._sent(0, pipe.link.outgoing(pipe.now), pipe.now, pipe.down)
    pipe.link.receive(wire.answer_frame(answer._replace(wanted=(answer.wanted + 3) % 256, echo=9)), pipe.now)
    assert pipe.link.backlog == 9
    pipe.run_until(lambda: pipe.link.idle)
    assert [*pipe.twin.queue] == train(9)
