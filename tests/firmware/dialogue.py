"""Dialogues at random, by a seed, and what board and twin make of them."""

from __future__ import annotations

from collections import Counter
from random import Random

from slewline.drive.board import wire
from slewline.drive.board.boards import UNO
from slewline.drive.board.frames import decode
from slewline.drive.board.records import Record
from slewline.drive.board.twin_board import BoardTwin
from slewline.drive.board.wire import Answer, BoardConfig, BoardEvent, BoardState, FrameKind, Happening, Reflex, encode

from .emulated import EmulatedBoard, Emulator

DOWN, REST, PAUSE, OUT, HALF = 1, 2, 4, 8, 16
ENABLED = wire.ENABLE
WHOLE, HALVES = (1, 1, 2, 2, 4, 4, 8, 8), (1, 3, 2, 6, 4, 12, 8, 9)

# Bounds, in ticks of 62.5 ns; measured, and rounded up.
TAKEN_WITHIN = 80_000  # of the end of a frame, or of the answer before it; a full ring and eight events may go first
SEEN_WITHIN = 2_500  # of an edge of an input; usually some 200
FILTERED_WITHIN = 350  # more for each look of the filter
SILENT_WITHIN = 8_000  # silence is noticed: a round of the main loop that took records while steps were made
SHOWN_WITHIN = 2_000  # phases and outputs; these are longest behind a START at which inputs act
LAMPS_WITHIN = 80_000  # lamps: the main loop shows them, and eight events may be told first
MOMENT = 400  # from the level of a pin to its direction
PULSE_LEAST = 80


BEYOND = [  # bytes of CONFIG, and values that are none: None, any
    (7, 0x80), (8, 4), (9, 64), (10, 128), (11, 4), (12, 3), (15, 16), (16, 5), (16, 0x50), (17, None), (17, None),
    (22, None), (23, 16), (31, 8),
]  # fmt: skip
ROUND, SILENCE = object(), object()  # what a board does by its main loop


class Dialogue:
    """A host that does what a host does, and much that it should not.

    `fastest`: least interval in ticks.
    """

    def __init__(self, emulator: Emulator, seed: int, ticks: int = 1_000_000, fastest: int = 400) -> None:
        self.random = Random(seed)
        self.ticks = ticks
        self.fastest = fastest
        self.emulator = emulator
        self.lives: list[tuple[EmulatedBoard, list[tuple[int, bytes]]]] = []
        self.calls: list[tuple[int, int, int]] = []

    # ---------------------------------------------------------------------------------------------------- the host
    def play(self) -> EmulatedBoard:
        """Talk to a board for some time, and return it; what was sent is in `chunks`."""
        random = self.random
        self.board = board = EmulatedBoard(self.emulator, polarity=random.randrange(2), rounds=True)
        self.restless = random.choice((0.02, 0.02, 0.08, 0.3))  # how often an input changes in a turn
        self.sprints = random.random() < 0.5  # long records, fast, few of other kinds
        self.ways = random.random() < 0.5  # records say how long their way down is
        self.dry = random.random() < 0.15  # most runs are
        self.lamps = tuple(random.choice((0, 0, 1, 2, 3, 4)) for _ in range(2))  # output + 1: of a halt, of power
        self.filter = random.choice((0, 0, 0, 0, 3, 8, 15))
        self.mute_until = 0
        self.is_on = False
        board.run(1_000)  # it has looked at its inputs
        self.chunks: list[tuple[int, bytes]] = []  # tick of the last byte, bytes without the zero
        self.edges: list[tuple[int, int]] = []
        self.levels = 0x3F
        self.quiet_until = 0
        self.reflexes, self.active = [0] * 6, 0
        self.number, self.state, self.free = 0, BoardState.BOOT, UNO.slots
        self.unanswered: list[int] = []
        self.line_free = 0
        self.interval = float(random.randint(self.fastest, 6_000))
        self.down = False
        self.gentle = True
        self.thirsty_until = 0
        self._say(FrameKind.HELLO, number=random.randrange(256))
        self._configure()
        while board.now < self.ticks:
            gap = random.choice((400, 2_000, 8_000, 20_000))
            self._turn()
            self._inputs(gap)
            told = board.run(board.now + gap)
            for chunk, until in zip(
                self.chunks[-len(told["until"]) :] if told["until"] else [], told["until"], strict=True
            ):
                self.chunks[self.chunks.index(chunk)] = (until, chunk[1])
            self._hear()
        board.run(board.now + 60_000)
        self._hear()
        self.end = board.now - 40_000
        return board

    def _hear(self) -> None:
        for chunk in self.board.take().split(b"\0")[:-1]:
            said = wire.read(decode(chunk))  # type: ignore[arg-type]
            if isinstance(said, Answer):
                self.unanswered.pop(0)
                self.state, self.free = BoardState(said.state), said.free
                self.is_on = bool(said.flags & wire.PowerFlag.ENERGISED)
                if said.result:
                    self.gentle = True
                if not self.unanswered or said.result:
                    self.number = said.wanted
            elif isinstance(said, BoardEvent):
                self.state = BoardState(said.state)

    def _put(self, data: bytes) -> None:
        """Put an encoded frame on the line, if there is credit for it."""
        if sum(self.unanswered) + len(data) > UNO.room:
            return
        self.board.receive(data, self.board.now)
        *chunks, _ = data.split(b"\0")
        for chunk in chunks:
            if chunk:
                self.unanswered.append(len(chunk) + 1)
                self.chunks.append((0, chunk))
            else:
                pass

    def _say(self, kind: int, payload: bytes = b"", number: int | None = None) -> None:
        random = self.random
        numbered = kind in wire.NUMBERED
        frame = encode(self.number if number is None else number, kind, payload)
        if sum(self.unanswered) + len(frame) > UNO.room:
            self.gentle = True  # what goes before the next record is another one
            return
        fate = random.random()
        if fate < 0.04:  # damaged on the way
            at = random.randrange(len(frame) - 1)
            frame = frame[:at] + bytes((random.randrange(1, 256),)) + frame[at + 1 :]
        elif fate < 0.05 and len(frame) > 8:  # an end in the middle
            at = random.randrange(1, len(frame) - 2)
            frame = frame[:at] + b"\0" + frame[at + 1 :]
        elif fate < 0.06:
            frame = b"\0\0" + frame
        self._put_parts(frame)
        if fate > 0.98:
            self._put_parts(frame)
        if numbered and number is None:
            self.number = (self.number + 1) % 256

    def _put_parts(self, frame: bytes) -> None:
        """Each chunk by itself, so that the end of each is known."""
        if sum(self.unanswered) + len(frame) > UNO.room:
            return
        for chunk in frame.split(b"\0")[:-1]:
            self._put(chunk + b"\0") if chunk else self._empty()

    def _empty(self) -> None:
        self.board.receive(b"\0", self.board.now)
        self.chunks.append((0, b""))

    def _configure(self) -> None:
        random = self.random
        kinds = [0, 0, 0, *[Reflex.STOP, Reflex.BRAKE, Reflex.MARK] * 2, Reflex.STOP, Reflex.ESTOP]
        reflexes = []
        for _ in range(6):
            kind = random.choice(kinds)
            only = random.choice((0, 0, 16, 32)) if kind in (Reflex.STOP, Reflex.BRAKE) else 0
            reflexes.append(int(kind) + only)
        config = BoardConfig(
            start_stop=random.choice((2_000, 8_000, 16_000, 30_000)),
            watchdog=random.choice((0, 0, 0, 60_000, 150_000)),
            polarity=self.board.polarity | random.choice((0, 2)),
            active=random.choice((0, 63, random.randrange(64))),
            report=random.choice((63, 0, random.randrange(64))),
            driver=random.choice((2, 2, 2, 3, 1) if self.dry else (1, 1, 1, 1, 1, 1, 0, 2)),
            enable_off=random.choice((0, 1, 1, 2, 2)),
            enable_hold=random.choice((0, 1, 2, 3, 6, 65_535)),
            filter=self.filter,
            fault_output=self.lamps[0],
            power_output=self.lamps[1],
            reflex=tuple(reflexes),
            pattern=random.choice((WHOLE, HALVES, (0,) * 8, tuple(random.randrange(16) for _ in range(8)))),
            phase=random.randrange(8),
        )
        # What is not active stays so until an edge: otherwise nothing would ever move.
        if random.random() < 0.9:
            for n in range(6):
                if reflexes[n] and not (self.levels ^ config.active) >> n & 1:
                    self._edge(n, self.board.now + 10)
        payload = bytearray(config.pack())
        if random.random() < 0.05:
            at, value = random.choice(BEYOND)
            payload[at] = random.randrange(64) if value is None else value
        if BoardConfig.unpack(bytes(payload)).good:
            self.reflexes, self.active = [*payload[17:23]], config.active
        self._say(FrameKind.CONFIG, bytes(payload))

    def _edge(self, number: int, tick: int) -> None:
        tick = max([tick, *(each + 1 for each, other in self.edges[-12:] if other == number)])
        self.levels ^= 1 << number
        self.board.set_input(number, self.levels >> number & 1, tick)
        self.edges.append((tick, number))

    def _release_stops(self) -> None:
        """Let most inputs that keep a board from running be inactive again."""
        for number in range(6):
            active = self.reflexes[number] and not (self.levels ^ self.active) >> number & 1
            if active and self.random.random() < 0.9 and self.board.now > self.quiet_until:
                self._edge(number, self.board.now + 10)
                self.quiet_until = self.board.now + 5_000

    def _inputs(self, gap: int) -> None:
        random, now = self.random, self.board.now
        if now < self.quiet_until or random.random() > self.restless:
            return
        tick = now + random.randrange(max(1, gap - 200))
        for number in random.sample(range(6), random.choice((1, 1, 1, 1, 2, 3))):
            self._edge(number, tick)
            tick += random.choice((0, 0, 1, 7, 40, 150))
        self.quiet_until = tick + random.choice((8_000, 20_000, 60_000))

    def _records(self) -> list[Record]:
        random = self.random
        records = []
        for _ in range(random.randint(1, 5)):
            what = random.random()
            if self.sprints:
                what = what**0.3
            half = HALF * (random.random() < 0.3)
            # Behind a pause or a turn the first step has time; the board needs some 700 cycles there.
            if what < 0.12:
                self.gentle = True
                flags = PAUSE | random.choice((0, 0, OUT)) | DOWN * self.down
                count = random.randrange(32) << 8 | random.randrange(32) if flags & OUT else 0
                if random.random() < 0.3:
                    flags |= REST
                records.append(
                    Record(
                        flags, count, random.choice((1_000, 1_500, 5_000, 40_000, 150_000)), random.randrange(65536), 5
                    )
                )
                continue
            if what < 0.2:
                self.down = not self.down
                self.gentle = True
            elif what < 0.25:
                self.interval = float(random.choice((self.fastest, 1_000, 4_000, 20_000, 70_000, 120_000)))
            if self.gentle:
                self.interval = max(self.interval, 1_200)
            self.gentle = False
            count = random.choice((5, 20, 50, 100) if self.sprints else (1, 1, 2, 3, 10, 30, 100))
            add = 0
            if random.random() < 0.6:
                aim = self.interval * random.uniform(*((0.6, 1.2) if self.sprints else (0.7, 1.4)))
                aim = max(self.fastest, min(200_000, aim))
                add = int((aim - self.interval) * 65536 / count)
            interval = int(self.interval)
            record = Record(DOWN * self.down | half, count, interval, random.randrange(65536), add)
            if not record.good(self.fastest) or abs(add) >= 2**31:
                record = record._replace(add=0)
            if self.ways:
                record = record.with_ramp_left(random.choice((0, 1, 4, 9, 30, 200)), random.choice((0, 0, 1, -1, -1)))
                if not record.good(self.fastest) and random.random() < 0.99:
                    record = record.with_ramp_left(count, -1)
            self.interval = max(self.fastest, (record.last >> 16))
            records.append(record)
        if random.random() < 0.01:
            records[-1] = records[-1]._replace(interval=random.choice((0, 200, 2**31)))
        return records

    def _turn(self) -> None:
        random, state = self.random, self.state
        if self.board.now < self.mute_until:
            return
        if random.random() < 0.003:
            self.mute_until = self.board.now + random.choice((60_000, 150_000, 300_000))
        if sum(self.unanswered) > 60 and random.random() < 0.9:
            return
        chance = random.random()
        if state == BoardState.BOOT and chance < 0.8:
            if not self.unanswered:
                self._configure()
        elif state == BoardState.HALT and chance < 0.8:
            position = random.choice((None, None, random.randrange(-(2**31), 2**31)))
            self._release_stops()
            known, power = random.random() < 0.5, random.random() < 0.5
            self._say(FrameKind.RESET, wire.reset_payload(position, known=known, power=power))
        elif state == BoardState.IDLE and not self.is_on and chance < 0.12:
            self._say(FrameKind.OUTPUTS, bytes((ENABLED | random.randrange(16), ENABLED)))
        elif state == BoardState.IDLE and chance < 0.4 and self.free < UNO.slots - 4:
            start = self.board.now + random.choice((-10_000, 5_000, 20_000, 20_000, 40_000))
            if random.random() < 0.05:  # from another time
                start += random.choice((-(2**28) - 50_000, 2**28 + 20_000, 2**31, 2**31 - 40_000))
            self._say(FrameKind.START, wire.start_payload(start))
        elif chance < (0.6 if state != BoardState.RUN or self.free < 30 else 0.8):
            if state == BoardState.RUN and random.random() < 0.08:
                self.thirsty_until = self.board.now + 300_000
                if random.random() < 0.5:
                    self._say(FrameKind.PUSH, Record(PAUSE | REST | DOWN * self.down, 0, 1_000).pack())
            if self.board.now < self.thirsty_until and state == BoardState.RUN:
                return
            if state not in (BoardState.BRAKE, BoardState.HALT) and (
                self.free > (50 if self.sprints else 8) or random.random() < 0.05
            ):
                for _ in range(random.choice((1, 2))):
                    self._say(FrameKind.PUSH, b"".join(record.pack() for record in self._records()))
            return
        chance = random.uniform(0.55, 1.1)
        if chance < 0.56 and state == BoardState.IDLE:
            self._say(FrameKind.RESET, bytes((random.randrange(10), 7, 0, 0, 0)))
        elif chance < 0.65:
            self._say(FrameKind.ASK, number=random.randrange(256))
        elif chance < 0.70:
            self._tail()
        elif chance < 0.73:
            mask = random.choice((15, 31)) if random.random() < 0.6 else random.randrange(33)
            self._say(FrameKind.OUTPUTS, bytes((mask, random.randrange(32) if random.random() < 0.98 else 32)))
        elif chance < 0.75:
            self._say(FrameKind.REPEAT, bytes((random.randrange(12),)), number=random.randrange(256))
        elif chance < 0.765:
            self._say(FrameKind.STOP, bytes((random.choice((0, 1, 1, 2)),)), number=random.randrange(256))
        elif chance < 0.775:
            self._say(random.choice((0, 12, 99, 0x80, 2, 3, 5, 7)), random.randbytes(random.randrange(30)))
        elif chance < 0.785:
            self._say(FrameKind.PUSH, b"", number=self.number + random.randrange(1, 9) & 255)
        elif chance < 0.79:
            self._put_parts(
                bytes(random.randrange(1, 256) for _ in range(random.choice((1, 3, 79, 80, 81, 100)))) + b"\0"
            )
        elif chance < 0.80 and state in (BoardState.IDLE, BoardState.HALT):
            self._configure()
        elif chance < 0.802:
            self._say(FrameKind.HELLO)

    def _tail(self) -> None:
        random = self.random
        first = random.choice((0, 0, 0, 3, 10))
        interval = random.choice((1 << 16, self.fastest << 8, int(self.interval) << 8)) + random.choice(
            (0, random.randrange(256))
        )
        entries = []
        for _ in range(random.randint(1, 10)):
            entries.append((interval, random.choice((1, 1, 2, 5))))
            interval += random.choice((0, 20_000, 100_000, 400_000))
        if random.random() < 0.05:
            entries.reverse()
        self._say(FrameKind.TAIL, wire.tail_payload(first, entries))


def told_to_twin(
    board: EmulatedBoard, chunks: list[tuple[int, bytes]], counts: Counter[str] | None = None
) -> BoardTwin:
    """Return a twin that has been told the same, at the instants at which the board took it.

    `counts`: by what the driver was switched, and how often.
    """
    twin, counts = BoardTwin(), Counter() if counts is None else counts
    told: list[tuple[int, int, object]] = []
    left = [chunk for _, chunk in chunks if chunk]
    told += [(tick, -2, ROUND) for tick in board.rounds]
    boot = None
    for at, (_, frame) in enumerate(board.frames):
        said = wire.read(decode(frame[:-1]))  # type: ignore[arg-type]
        if isinstance(said, Answer):
            told.append((said.tick, at, left.pop(0)))
        elif isinstance(said, BoardEvent) and said.kind == Happening.WATCHDOG:
            told.append((said.tick, at, SILENCE))
        elif isinstance(said, BoardEvent) and said.kind == Happening.BOOT and boot is None:
            boot = said.tick
    levels = 0x3F
    for tick, after in board.looks:
        if after != levels:
            told.append((tick, -1, after))
        levels = after
    twin.power_up(boot or 0)
    for tick, _, what in sorted(told, key=lambda row: row[0]):
        twin.run(tick)
        was_on, state = twin.power.on, twin.state
        if isinstance(what, bytes):
            twin.receive(what + b"\0", tick)
        elif isinstance(what, int):
            number = (what ^ twin.inputs).bit_length() - 1
            twin.set_input(number, what >> number & 1, tick)
        elif what is ROUND:
            twin.look(tick)
        else:
            within = SILENT_WITHIN + 4 * FILTERED_WITHIN * twin.config.filter
            assert 0 <= tick - twin.last_frame - twin.config.watchdog <= within
            if not board.rounds:
                twin.look(tick)
            twin.brake_if_silent(tick)
        if was_on != twin.power.on:
            kind = "round" if what is ROUND else "frame" if isinstance(what, bytes) else "input"
            counts[f"{'off' if was_on else 'on'} by {kind}, {state.name}{', locked' if twin.power.locked else ''}"] += 1
    twin.run(board.now)
    return twin
