"""A host that says one thing after the other to an emulated board, and looks at its pins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from slewline.drive.board import wire
from slewline.drive.board.frames import decode
from slewline.drive.board.records import Record, pack
from slewline.drive.board.wire import (
    ENABLE,
    Answer,
    BoardConfig,
    BoardEvent,
    DriverFlag,
    FrameKind,
    FrameResult,
    Happening,
    Reflex,
    encode,
)

from .emulated import EmulatedBoard, Emulator

if TYPE_CHECKING:
    from collections.abc import Iterable

ESTOP_INPUT, LIMIT_INPUT = 1, 0
TAKEN = FrameResult.TAKEN
LONG = 16_000  # ticks between slow steps
HOLD = 65_536  # ticks


class Talk:
    """A board that has been configured and reset; its inputs are closed, that is low.

    Input 0 is a limit, input 1 an emergency stop; both act when they open.
    """

    def __init__(self, emulator: Emulator, *, rounds: bool = False, **config: object) -> None:
        self.board = EmulatedBoard(emulator, polarity=1, rounds=rounds)
        for number in range(6):
            self.board.set_input(number, 0, 100)
        self.board.run(5_000)
        self.number, self.chunks = 0, []
        self.config = BoardConfig(
            **{  # type: ignore[arg-type]
                "start_stop": LONG,
                "driver": DriverFlag.ENABLE,
                "active": 63,
                "reflex": (Reflex.STOP, Reflex.ESTOP, 0, 0, 0, 0),
                **config,
            }
        )
        assert self.say(FrameKind.HELLO).result == TAKEN
        assert self.say(FrameKind.CONFIG, self.config.pack()).result == TAKEN
        assert self.reset().result == TAKEN

    # ---------------------------------------------------------------------------------------------------- what is said
    def say(self, kind: int, payload: bytes = b"") -> Answer:
        """Send a frame; return its answer."""
        before = len(self.answers)
        frame = encode(self.number, kind, payload)
        self.board.receive(frame, self.board.now)
        self.chunks.append((0, frame[:-1]))
        while len(self.answers) == before:
            self.board.run(self.board.now + 2_000)
        answer = self.answers[-1]
        self.number = answer.wanted
        return answer

    def reset(self, *, known: bool = True, power: bool = False) -> Answer:
        """Send RESET; without flags but that the count is known."""
        return self.say(FrameKind.RESET, wire.reset_payload(0, known=known, power=power))

    def switch(self, on: bool) -> Answer:
        """Send OUTPUTS with ENABLE."""
        return self.say(FrameKind.OUTPUTS, bytes((ENABLE, ENABLE * on)))

    def play(self, records: Iterable[Record]) -> Answer:
        """Send up to five records, and START."""
        assert self.say(FrameKind.PUSH, pack(records)).result == TAKEN
        return self.say(FrameKind.START, wire.start_payload(self.board.now + 20_000))

    def pass_by(self, ticks: int, *, silent: bool = False) -> None:
        """Let time pass; a host that is not silent sends ASK now and then."""
        end = self.board.now + ticks
        while self.board.now < end:
            self.board.run(min(end, self.board.now + 50_000))
            if not silent:
                self.say(FrameKind.ASK)

    # ----------------------------------------------------------------------------------------------------- what it did
    @property
    def answers(self) -> list[Answer]:
        """All answers so far."""
        return [said for said in self._said() if isinstance(said, Answer)]

    @property
    def events(self) -> list[BoardEvent]:
        """All events so far, but that of power-up."""
        return [said for said in self._said() if isinstance(said, BoardEvent) and said.kind != Happening.BOOT]

    def _said(self) -> list[object]:
        return [wire.read(decode(frame[:-1])) for _, frame in self.board.frames]  # type: ignore[arg-type]

    @property
    def level(self) -> int | None:
        """The level of D11, or None: it has high impedance."""
        return self.board.enable[-1][1] if self.board.enable else None

    def output(self, number: int) -> int:
        """The level of a user output."""
        value = self.board.outputs[-1][1] if self.board.outputs else 0
        return value >> number & 1
