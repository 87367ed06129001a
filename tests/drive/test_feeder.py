"""The feeder against a board that hears at once: every step of a chip is one of the motor, a horizon later."""

from __future__ import annotations

from collections import deque
from random import Random

import numpy as np
import pytest

from slewline.drive.board.records import OUT, PAUSE, REST, pack
from slewline.drive.board.twin_board import BoardTwin
from slewline.drive.board.wire import (
    BoardConfig,
    BoardState,
    Decoder,
    FrameKind,
    FrameResult,
    Happening,
    encode,
    read,
    reset_payload,
    start_payload,
)
from slewline.drive.feeder import Feeder, PlannedOutput
from slewline.drive.ticks import TickMap
from tests.ensembles import few

from .families import SCRIPTS, furnished

HZ = 16_000_000
MS = 10**9  # ps
H = HZ // 10
WITHIN = 9  # ticks: a tolerance of 8, and what is rounded down


class ShortWire:
    """A wire that needs no time to a board that answers at once; what it has no room for waits its turn."""

    def __init__(self, twin):
        self.twin, self.waiting, self.number, self.events = twin, deque(), 0, []
        self.decoder, self.refused, self.pushed = Decoder(), [], []
        self.say(FrameKind.HELLO)
        self.say(FrameKind.CONFIG, BoardConfig(HZ // 500).pack())
        self.say(FrameKind.RESET, reset_payload(0))

    def push(self, records):
        self.pushed += records
        self.waiting += [(FrameKind.PUSH, pack(records[at : at + 5])) for at in range(0, len(records), 5)]

    def start(self, tick):
        self.waiting.append((FrameKind.START, start_payload(tick)))

    def say(self, kind, payload=b""):
        number = 0 if kind == FrameKind.HELLO else self.number
        self.twin.receive(encode(number, kind, payload), self.twin.now)
        result = None
        for frame in self.decoder.feed(self.twin.take()):
            told = read(frame)
            if frame.kind == FrameKind.ANSWER:
                result = FrameResult(told.result)
                self.number = told.wanted
            elif frame.kind == FrameKind.EVENT:
                self.events.append(told)
        return result

    def carry(self):
        while self.waiting:
            result = self.say(*self.waiting[0])
            if result == FrameResult.NO_ROOM:
                return
            kind, _ = self.waiting.popleft()
            if result != FrameResult.TAKEN:
                self.refused.append((kind, result))


class Bench:
    """A chip, its feeder, a wire and a board; `lag` ticks lie between the board and the model."""

    def __init__(self, name, turn=lambda: 5 * MS, **options):
        self.bench, self.x, self.host, self.seconds = furnished(name, **options)
        self.turn = turn
        self.bench.run(0)
        self.twin = BoardTwin()
        self.wire = ShortWire(self.twin)
        self.ticks = TickMap(HZ)
        self.ticks.align(0, 1000)
        self.outputs = []
        self.feeder = Feeder(self.x.motor, self.bench.kernel, self.wire, self.ticks, H, 224, self.outputs.append)

    def run(self, ps):
        end = self.bench.now_ps + ps
        while self.bench.now_ps < end:
            self.step()

    def step(self):
        self.bench.kernel.run(self.bench.kernel.now + self.turn())
        tick = self.ticks.at(self.bench.now_ps) >> 16
        self.twin.run(tick)
        self.wire.say(FrameKind.ASK)
        events, self.wire.events = self.wire.events, []
        for event in events:
            assert event.kind in (Happening.REST, Happening.BOOT), event
            if event.kind == Happening.REST:
                self.feeder.rest(event.tick)
        self.feeder.turn(tick)
        self.wire.carry()

    def check(self):
        """Every step of the model that was due has been made, at its instant and in its direction, and no other one."""
        steps = self.x.steps()
        wanted = (self.ticks.many(steps.times_ps) >> 16) + H
        made = np.array(self.twin.steps)
        count = len(made)
        assert int((wanted < self.twin.now - WITHIN).sum()) <= count <= len(steps)
        assert count and np.abs(made[:, 0] - wanted[:count]).max() <= WITHIN
        assert (made[:, 1] == steps.directions[:count]).all()
        assert not self.wire.refused


@pytest.mark.parametrize("name", SCRIPTS)
def test_every_step_is_made_a_horizon_later(name):
    each = Bench(name)
    each.run(int(each.seconds * 1000) * MS)
    if each.x.idle:
        each.run(150 * MS)
        assert len(each.twin.steps) == len(each.x.steps())
        assert each.twin.state == BoardState.IDLE and not each.feeder.busy and not each.twin.queue
    each.check()


@pytest.mark.parametrize("seed", few(range(4), 1))
@pytest.mark.parametrize("name", ["cy525 to and fro", "cy525 program of slow steps", "gs-c200s moves in a row"])
def test_a_host_that_is_late_by_up_to_half_the_horizon_changes_nothing(name, seed):
    rnd = Random(seed)
    each = Bench(name, turn=lambda: rnd.choice((5 * MS, 1 * MS, rnd.randrange(1, 50 * MS))))
    each.run(int(each.seconds * 1000) * MS + 200 * MS)
    each.check()


def test_a_new_motion_joins_the_rest_of_the_one_before():
    each = Bench("cy525 to and fro")
    each.run(1500 * MS)
    rests = sum(bool(record.flags & REST) for record in each.wire.pushed)
    starts = sum(1 for _ in each.x.motions())
    assert rests > 2 and starts > 3


def test_records_after_a_rest_that_the_board_has_already_reached_are_started_there():
    """The records are 6 ms on their way; the second motion begins about when the board comes to rest."""
    starts, past = [], 0
    for gap in range(84, 104):
        each = Bench("cy525 five steps", turn=lambda: 1 * MS)
        carry, waiting, begun = each.wire.carry, each.wire.waiting, []
        started = each.wire.start
        each.wire.start = lambda tick: (begun.append(tick < each.twin.now), started(tick))  # noqa: B023
        sent: list[tuple[int, int]] = []

        def late():
            """Let a frame go when it has waited."""
            now = each.twin.now  # noqa: B023
            sent.extend((now, 0) for _ in range(len(waiting) - len(sent)))  # noqa: B023
            due = sum(since + 6 * 16_000 <= now for since, _ in sent)  # noqa: B023
            rest = [waiting.pop() for _ in range(len(waiting) - due)]  # noqa: B023
            carry()  # noqa: B023
            del sent[:due]  # noqa: B023
            waiting.extend(reversed(rest))  # noqa: B023

        each.wire.carry = late
        each.run(50 * MS)
        last = int(each.x.steps().times_ps[-1])
        each.bench.at(f"{last + gap * MS} ps", lambda: each.host.send("G\r"))  # noqa: B023
        each.run(400 * MS)
        each.check()
        assert len(each.twin.steps) == 10
        rests = [record for record in each.wire.pushed if record.flags & REST]
        starts.append((len(begun), len(rests)))
        past += sum(begun)
    assert {2} == {count for count, _ in starts[-3:]}
    assert past > 3
    assert (1, 2) in starts  # the second motion has joined


def test_outputs_change_in_the_order_of_the_steps():
    each = Bench("gs-c200s moves in a row")
    pin, feeder = each.x.pin("uo2"), each.feeder
    pin.net.watch(lambda net: feeder.change(2, 2 * net.level))
    changed = []
    pin.net.watch(lambda net: changed.append((each.bench.now_ps, net.level)))
    each.run(1500 * MS)
    each.check()
    assert len(changed) == 2
    assert [value for _, value in each.twin.outputs] == [2, 0]
    for (ps, _), (tick, _) in zip(changed, each.twin.outputs, strict=True):
        assert abs(tick - (each.ticks.at(ps) >> 16) - H) <= 1


def test_outputs_at_rest_go_by_a_frame():
    each = Bench("cy525 to and fro")
    each.feeder.change(1, 1)
    each.step()
    assert [(each.mask, each.value) for each in each.outputs] == [(1, 1)]
    assert isinstance(each.outputs[0], PlannedOutput) and not each.wire.pushed


def test_steps_of_the_model_after_a_halt_are_counted_and_not_output():
    each = Bench("cy525 top")
    each.run(1000 * MS)
    each.feeder.halt()
    before, made = len(each.x.steps()), len(each.wire.pushed)
    each.bench.run("500 ms")
    each.feeder.turn(0)
    assert each.feeder.lost == pytest.approx(len(each.x.steps()) - before, abs=1)
    assert len(each.wire.pushed) == made and not each.feeder.busy


def test_before_the_first_step_and_after_a_halt_there_is_no_last_interval():
    each = Bench("cy525 top")
    assert each.feeder.interval16 == 0
    each.run(1000 * MS)
    assert each.feeder.interval16 > 0
    each.feeder.halt()
    assert each.feeder.interval16 == 0


def test_few_records_and_little_time_for_a_long_slew():
    each = Bench("cy525 top")
    each.run(2300 * MS)
    assert each.feeder.steps == 20_000
    assert each.feeder.records < 300
    assert not any(record.flags & (PAUSE | OUT) == PAUSE | OUT for record in each.wire.pushed)


def test_ticks_are_exact_for_a_hundred_days():
    ticks = TickMap(HZ)
    day = 86_400 * 10**12
    assert ticks.at(100 * day) >> 16 == 100 * 86_400 * HZ
    ticks.align(3 * day + 12_345, 7)
    rnd = Random(1)
    instants = [rnd.randrange(100 * day) for _ in range(1000)]
    assert ticks.many(np.array(instants)).tolist() == [ticks.at(ps) for ps in instants]
    for ps in instants:
        tick = ticks.at(ps) >> 16
        last = ticks.ps(tick)
        assert last <= ps < ticks.ps(tick + 1) + 1
        assert ticks.at(last) <= tick << 16 < ticks.at(last + 1)
    assert ticks.at(3 * day + 12_345) == 7 << 16


def test_an_output_that_changes_right_before_a_step_changes_before_it():
    each = Bench("cy525 long ramp")
    each.run(250 * MS)  # at the beginning of the ramp
    train = each.x.motor.past[-1].playing.train
    for number, before in ((4, 2 * 10**6), (40, 40 * 10**6)):
        step = train.clock.ps(train.end(train.count(each.bench.now_ps) + number))
        each.bench.at(f"{step - before} ps", lambda: each.feeder.change(1, 1))
        each.bench.at(f"{step + 2000 * 10**6} ps", lambda: each.feeder.change(1, 0))
    each.run(400 * MS)
    each.check()
    assert [value for _, value in each.twin.outputs] == [1, 0, 1, 0] and not each.outputs


def test_another_direction_without_a_rest_in_between():
    """Of a chip that turns round at once: its axis follows one train down behind another one up."""
    from slewline.core.motion.train import Playing, StepTrain

    each = Bench("cy525 five steps")
    each.run(90 * MS)
    axis, clock, kernel = each.x.motor, each.x.clock, each.bench.kernel
    first = clock.ticks_from(kernel.now + MS)

    def follow(number):
        train = StepTrain(clock, first + number * 80_000, ((2000, 40),))
        axis.follow(Playing(train), (1, -1)[number % 2])

    for number in range(3):
        each.bench.at(f"{clock.ps(first + number * 80_000)} ps", lambda number=number: follow(number))
    each.run(300 * MS)
    each.check()
    assert len(each.twin.steps) == 125 and len({direction for _, direction, _ in each.twin.steps}) == 2
