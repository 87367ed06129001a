"""A line between a link and the twin of a board, in virtual time: slow, late, and damaged with a fixed seed."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable

from slewline.drive.board.board_link import Link
from slewline.drive.board.boards import UNO, BoardModel
from slewline.drive.board.clock import BoardClock
from slewline.drive.board.twin_board import BoardTwin

A_BYTE = 20_000  # ns, at 500 kbaud
MS = 1_000_000


class Pipe:
    """Both ends of a line; `bad_frames` and `bad_bytes` are the probabilities of damage, in both directions.

    `late` is least and greatest latency of each direction in ns, beside the time of the bytes.  The host looks each
    `turn`.
    """

    def __init__(
        self,
        seed: int = 0,
        *,
        bad_frames: float = 0,
        bad_bytes: float = 0,
        late: tuple[int, int] = (0, 1 * MS),
        turn: int = 1 * MS,
        ppm: float = 0,
        model: BoardModel = UNO,
        begun: int = 0,
    ) -> None:
        self.chance = random.Random(seed)
        self.bad_frames, self.bad_bytes, self.late, self.turn = bad_frames, bad_bytes, late, turn
        self.twin, self.clock = BoardTwin(model), BoardClock(model.hz)
        self.link = Link(self.clock)
        self.rate = model.hz * (1 + ppm / 1e6) / 1e9
        self.now = 5_000_000_000  # ns of the host
        self.power_ns = self.now - begun  # when the board's ticks were 0
        self.down: deque[tuple[int, bytes]] = deque()  # arrival, bytes
        self.up: deque[tuple[int, bytes]] = deque()
        self.free_at = [0, 0]  # when the line of each direction is free, and the last arrival
        self.last = [0, 0]
        self.each_turn: Callable[[], object] = lambda: None
        self.cut = False
        self.damages = 0

    def tick(self, at_ns: int) -> int:
        return int((at_ns - self.power_ns) * self.rate)

    def power_up(self) -> None:
        """Reset the board: what is on its way to it is lost in part."""
        self.twin.run(self.tick(self.now))
        self.power_ns = self.now
        self.down.clear()
        self.twin.power_up()

    def _damaged(self, data: bytes) -> bytes:
        out = bytearray()
        for frame in data.split(b"\0")[:-1]:
            frame += b"\0"
            hit = self.chance.random() < self.bad_frames
            at = self.chance.randrange(len(frame)) if hit else -1
            for place, byte in enumerate(frame):
                if place == at or (self.bad_bytes and self.chance.random() < self.bad_bytes):
                    kind = self.chance.randrange(4)
                    self.damages += 1
                    if kind == 0:
                        continue  # lost
                    if kind == 1:
                        out.append(byte)  # twice
                    byte = (
                        byte ^ 1 << self.chance.randrange(8) if kind == 2 else self.chance.choice((0, 255, byte ^ 85))
                    )
                out.append(byte)
        return bytes(out)

    def _sent(self, way: int, data: bytes, at: int, to: deque[tuple[int, bytes]]) -> None:
        if not data or self.cut:
            return
        data = self._damaged(data)
        start = max(at, self.free_at[way])
        for place in range(0, len(data), 16):
            piece = data[place : place + 16]
            start += len(piece) * A_BYTE
            self.last[way] = max(self.last[way], start + self.chance.randint(*self.late))
            to.append((self.last[way], piece))
        self.free_at[way] = start

    def run(self, length: int) -> None:
        """Let time pass, in ns."""
        end = self.now + length
        while self.now < end:
            self.now += self.turn
            while self.down and self.down[0][0] <= self.now:
                at, data = self.down.popleft()
                self.twin.receive(data, max(self.tick(at), self.twin.now))
                self._sent(1, self.twin.take(), at, self.up)
            self.twin.look_for_silence(max(self.tick(self.now), self.twin.now))
            self._sent(1, self.twin.take(), self.now, self.up)
            while self.up and self.up[0][0] <= self.now:
                self.link.receive(self.up.popleft()[1], self.now)
            self.each_turn()
            self._sent(0, self.link.outgoing(self.now), self.now, self.down)

    def run_until(self, ready: Callable[[], bool], most: int = 20_000 * MS) -> None:
        end = self.now + most
        while not ready():
            assert self.now < end, "it takes too long"
            self.run(self.turn)
