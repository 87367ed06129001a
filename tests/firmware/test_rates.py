"""How fast the board is, and what it takes: measured in the emulator, with bounds."""

from __future__ import annotations

import shutil
from itertools import pairwise
from random import Random

import pytest

from slewline.drive.board import wire
from slewline.drive.board.boards import UNO
from slewline.drive.board.frames import decode
from slewline.drive.board.records import Record
from slewline.drive.board.wire import (
    Answer,
    BoardConfig,
    BoardEvent,
    DriverFlag,
    FrameKind,
    Happening,
    Reflex,
    encode,
)
from tests.ensembles import in_long_runs
from tools.firmware import FLASH, RAM, build

from .chain import low_time, phase_lags, pulse_widths
from .emulated import PHASES_WITHIN, EmulatedBoard

pytestmark = pytest.mark.system

HZ = UNO.hz
PAUSE, REST = 4, 2
HALVES = (1, 3, 2, 6, 4, 12, 8, 9)


def read(board):
    return [wire.read(decode(frame[:-1])) for _, frame in board.frames]


def events(board):
    return [said for said in read(board) if isinstance(said, BoardEvent) and said.kind != Happening.BOOT]


class Host:
    """Streams records by credit, and keeps the line as busy as it is told."""

    def __init__(self, emulator, records, *, busy=False, **config):
        self.board = EmulatedBoard(emulator, polarity=1)
        self.records, self.busy = list(records), busy
        self.number, self.slots, self.sent, self.answered = 0, UNO.slots, [], 0
        self.say(FrameKind.HELLO)
        config = {"driver": DriverFlag.ENABLE, **config}
        self.say(FrameKind.CONFIG, BoardConfig(16_000, **config).pack())
        self.settle()
        self.say(FrameKind.RESET, wire.reset_payload(0))
        self.settle()

    def say(self, kind, payload=b""):
        frame = encode(self.number, kind, payload)
        self.board.receive(frame, self.board.now)
        self.sent.append(len(frame))
        self.number += kind in wire.NUMBERED
        self.number %= 256

    def room(self):
        return UNO.room - sum(self.sent[self.answered :])

    def hear(self):
        answers = [said for said in read(self.board) if isinstance(said, Answer)]
        assert all(answer.result == wire.FrameResult.TAKEN for answer in answers)
        self.answered = len(answers)
        self.slots = answers[-1].free

    def settle(self):
        self.board.run(self.board.now + 60_000)
        self.hear()

    def feed(self):
        while self.records and self.room() >= 72 and self.slots >= 5:
            now, self.records = self.records[:5], self.records[5:]
            self.say(FrameKind.PUSH, b"".join(record.pack() for record in now))
            self.slots -= len(now)
        # A frame of records must find room among those that keep the line busy.
        while self.busy and self.room() >= 78:
            self.say(FrameKind.ASK)
        if self.records and self.slots < 5 and self.room() >= 78:
            self.say(FrameKind.ASK)

    def start(self, ticks):
        for _ in range(40):
            busy, self.busy = self.busy, False
            self.feed()
            self.settle()
            self.busy = busy
        self.say(FrameKind.START, wire.start_payload(self.board.now + 20_000))
        end = self.board.now + ticks
        while self.board.now < end:
            self.feed()
            self.board.run(self.board.now + 8_000)
            self.hear()


def expected(records, first):
    """The steps, if the first is made at this tick."""
    times, base = [], 0
    for record in records:
        times += record.times(base)
        base += record.length
    start = (first << 16) - times[0]
    start = (start + 0xFFFF) // 65_536 * 65_536
    return [(start + time) >> 16 for time in times]


def constant(interval, seconds, steps=100):
    """Slews of some steps each, at one rate."""
    return [Record(0, steps, interval) for _ in range(int(seconds * HZ / interval / steps))]


def ramp(lowest, steps=2_000):
    """Up to a rate in pieces of twenty steps, and down again."""
    highest, pieces = 3_000, steps // 20
    ratio = (lowest / highest) ** (1 / pieces)
    up = [highest * ratio**at for at in range(pieces + 1)]
    out = []
    for one, other in [*pairwise(up), *pairwise(up[::-1])]:
        out.append(Record(0, 20, int(one), 0, int((other - one) * 65_536 / 20)))
    return out


def streamed(emulator, records, **more):
    """Stream records, and return the board if each step came at its tick and nothing was late."""
    records = [*records, Record(PAUSE | REST, 0, 16_000)]
    ticks = sum(record.length for record in records) >> 16
    host = Host(emulator, records, **more)
    host.start(ticks + 100_000)
    board = host.board
    told = [Happening(event.kind).name for event in events(board)]
    assert told == ["REST"], told
    assert board.rises == expected(records[:-1], board.rises[0])
    assert board.overruns == 0
    return board


def test_seventy_thousand_steps_a_second(emulator):
    board = streamed(emulator, constant(HZ // 70_000, 0.2))
    assert len(board.rises) > 13_000


@pytest.mark.long
@pytest.mark.timeout(300)
def test_sixty_eight_thousand_with_records_of_any_length(emulator):
    for steps in range(60, 140, 4):  # at 70,000 one of twenty lengths meets a frame at the wrong instant
        streamed(emulator, constant(HZ // 68_000, 0.1, steps))


def test_forty_five_thousand_in_a_ramp_with_the_line_busy(emulator):
    board = streamed(emulator, ramp(HZ / 45_000), busy=True)
    assert len(board.rises) == 4_000


def nudged(board, random):
    """Let edges of inputs come in the next 8,000 ticks, now and then more than one at once."""
    for number in random.sample(range(6), random.choice((0, 0, 0, 0, 1, 1, 3))):
        board.set_input(number, random.randrange(2), board.now + random.choice((0, 0, 1, 40)) + random.randrange(7_000))


FRAMES = {
    FrameKind.OUTPUTS: lambda random: bytes((15, random.randrange(32))),
    FrameKind.REPEAT: lambda random: bytes((random.randrange(8),)),
    FrameKind.TAIL: lambda random: wire.tail_payload(0, [(100_000 + n, 3) for n in range(random.randint(1, 3))]),
    FrameKind.ASK: lambda random: b"",
}


class RestlessHost(Host):
    """Frames of all kinds that a board takes while it runs, and inputs that mark, are told, or would stop it there."""

    def __init__(self, emulator, records, *, seed, **config):
        self.random = Random(seed)
        reflex = (Reflex.MARK, Reflex.MARK, 0, 0, Reflex.STOP | Reflex.DOWNWARDS, Reflex.BRAKE | Reflex.DOWNWARDS)
        super().__init__(emulator, records, busy=True, reflex=reflex, report=63, **config)

    def feed(self):
        kind = self.random.choice(list(FRAMES))
        if self.busy and self.room() >= 100:
            self.say(kind, FRAMES[kind](self.random))
        super().feed()
        if self.busy:
            nudged(self.board, self.random)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 12))])
@pytest.mark.parametrize("quiet", [in_long_runs(True), False], ids=["quiet", "restless"])
def test_phases_follow_the_steps(emulator, quiet, seed):
    half = ramp(HZ / 45_000)
    records = [
        *half[:100],
        *(Record(0, 23 + seed, 355) for _ in range(50)),
        *half[100:],
        Record(PAUSE | REST, 0, 16_000),
    ]
    host = (Host if quiet else RestlessHost)(emulator, records, pattern=HALVES, **({} if quiet else {"seed": seed}))
    host.start((sum(record.length for record in records) >> 16) + 100_000)
    told = {event.kind for event in events(host.board)}
    assert told == ({Happening.REST} if quiet else {Happening.MARK, Happening.INPUT, Happening.REST})
    assert len(host.board.rises) == 4_000 + 50 * (23 + seed) and not host.board.overruns
    lags, _ = phase_lags(host.board)
    assert lags.min() > 0 and lags.max() <= PHASES_WITHIN
    high, _ = pulse_widths(host.board)
    assert high >= UNO.high and low_time(host.board) >= UNO.low


def test_a_record_for_each_step(emulator):
    streamed(emulator, [Record(0, 1, 360 + at % 3) for at in range(60)])


def test_the_shortest_interval_is_the_stated_one(emulator):
    streamed(emulator, constant(UNO.shortest, 0.05))
    host = Host(emulator, [])
    host.say(FrameKind.PUSH, Record(0, 100, UNO.shortest - 1).pack())
    host.board.run(host.board.now + 60_000)
    assert read(host.board)[-1].result == wire.FrameResult.BAD_CONTENT


# Pieces of one step each follow too fast for the board beyond some 30,000 steps a second: the host makes none.
@pytest.mark.parametrize(
    "rate, steps, table",
    [
        *((rate, steps, True) for rate in (10_000, 27_000) for steps in (1, 3)),
        (10_000, 1, False),
        (27_000, 1, False),
        (45_000, 3, True),
    ],
)
def test_an_underrun_is_followed_by_the_stop_ramp(emulator, rate, steps, table):
    host = Host(emulator, ramp(HZ / rate, 800)[:40])
    if table:
        host.say(FrameKind.TAIL, wire.tail_payload(0, [(int(HZ / rate * 1.06**at) << 8, steps) for at in range(1, 11)]))
    host.settle()
    host.start(4_000_000)
    told = [Happening(event.kind) for event in events(host.board)]
    assert told == [Happening.UNDERRUN, Happening.HALTED], told
    assert events(host.board)[-1].position == len(host.board.rises)


def test_flash_ram_and_stack_are_limited(firmware, emulator):
    assert firmware.flash <= FLASH * 5 // 8
    host = Host(emulator, ramp(HZ / 30_000), busy=True, pattern=HALVES, reflex=(Reflex.MARK,) * 6, report=63)
    for number in range(6):
        host.board.set_input(number, 0, host.board.now + 400_000 + 3 * number)
    host.start(1_000_000)
    told = host.board.run(host.board.now + 10, end=firmware.end)
    assert firmware.ram <= RAM
    assert told["unused"] >= 250  # bytes that the stack has never reached


@pytest.mark.check
def test_the_same_bytes_wherever_it_is_built(firmware, tmp_path):
    place = tmp_path / "another name"
    assert build(place).path.read_bytes() == firmware.path.read_bytes()
    copied = shutil.copytree(place, tmp_path / "copied") / firmware.path.name
    assert str(tmp_path).encode() not in copied.read_bytes()


@pytest.mark.parametrize("looped", [True, False])
def test_the_board_counts_its_own_pulses(emulator, looped):
    host = Host(emulator, [])
    emulator.ask(loop=looped)
    before = len(host.board.rises)
    host.say(FrameKind.CHECK, wire.check_payload(300, 1_600))
    host.board.run(host.board.now + 800_000)
    emulator.ask(loop=False)
    checked = events(host.board)[-1]
    assert (checked.kind, checked.which, checked.position) == (Happening.CHECKED, not looped, 300 if looped else 0)
    rises = host.board.rises[before:]
    assert len(rises) == 300
    assert read(host.board)[-2].position == 0
