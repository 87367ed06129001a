"""A step-by-step model of a board, the reference for the firmware: slow and simple.

This file handles the frames of the board.
"""

from __future__ import annotations

from . import wire
from .boards import LEAST_CHECK, START_LEAD_TICKS, START_MOST_TICKS, UNO, BoardModel
from .records import MOST_RAMP_LEFT, unpack
from .twin_motion import BOOT, BRAKE, HALT, IDLE, RUN, MovingTwin
from .wire import (
    ENABLE,
    HOST,
    NUMBERED,
    RECORD_BYTES,
    RECORDS_A_FRAME,
    SIZES,
    USER_OUTPUTS,
    VERSION,
    Answer,
    BoardConfig,
    Damaged,
    Decoder,
    DriverFlag,
    Frame,
    FrameKind,
    FrameResult,
    Happening,
    Ident,
    ResetFlag,
)

ALL_OUTPUTS = USER_OUTPUTS | ENABLE
FROM_HOST = frozenset(kind for kind in FrameKind if kind < FrameKind.ANSWER)
ALLOWED = {  # states in which a frame is accepted; other frames in any
    FrameKind.PUSH: {IDLE, RUN},
    FrameKind.START: {IDLE},
    FrameKind.CONFIG: {BOOT, IDLE, HALT},
    FrameKind.TAIL: {IDLE, RUN, HALT},
    FrameKind.RESET: {IDLE, HALT},
    FrameKind.OUTPUTS: {IDLE, RUN, BRAKE, HALT},
    FrameKind.CHECK: {IDLE},
}


def _signed(tick: int) -> int:
    """Return the number in -2^31 .. 2^31 - 1 that equals a tick modulo 2^32."""
    return (tick + 2**31) % 2**32 - 2**31


class BoardTwin(MovingTwin):
    """A model of a board, from its power-up on.

    Attributes:
        steps: for each step, its tick, its direction, and the position after it.
        phases: the tick and the new value of each change of the phases.
        outputs: the tick and the new value of each change of the outputs.  Bits 0 to 3 are the user outputs,
            including lamps; bit 4 is ENABLE.
        enable: the tick and the new level of each change of the ENABLE pin; the level is None if there is no
            such pin.
        sent: the frames for the host, as bytes.
    """

    def __init__(self, model: BoardModel = UNO) -> None:
        super().__init__(model)

    def power_up(self, tick: int = 0) -> None:
        self._decoder = Decoder()
        self.wanted = 0
        self.last_frame = tick
        self._silent = False
        self._repeated = b""  # an event that follows the answer
        super().power_up(tick)

    # --------------------------------------------------------------------------------------------------------- inputs
    def take(self) -> bytes:
        """Return the bytes sent since the last call."""
        out = bytes(self.sent)
        self.sent.clear()
        return out

    def receive(self, data: bytes, tick: int) -> None:
        """Receive bytes from the host; each frame that they complete takes effect at this tick."""
        for frame in self._decoder.feed(data):
            self.run(tick)
            self._take(frame, tick)
            self._show(tick)

    def look_for_silence(self, tick: int) -> None:
        """Run the checks of the main loop at a tick, and brake if they find that the host is silent."""
        self.look(tick)
        self.brake_if_silent(tick)

    def look(self, tick: int) -> None:
        """Check, as the main loop does, whether the host is silent, and switch the driver off if that is due."""
        self.run(tick)
        limit = self.config.watchdog
        self._silent |= bool(limit) and tick - self.last_frame >= limit
        self.power.watch(tick, self.state, self.config, self._silent)

    def brake_if_silent(self, tick: int) -> None:
        """Brake a motion if the last check found that the host was silent."""
        if self._silent:
            self.run(tick)
            if self.state == RUN:
                self._brake(Happening.WATCHDOG, HOST, tick)
                self._show(tick)

    def checked(self, counted: int, right: bool, tick: int) -> None:
        """End a self-test in which `counted` pulses came back; `right`: True if that is the number sent."""
        self.run(tick)
        self._report_event(Happening.CHECKED, 0 if right else 1, tick, counted)

    # ------------------------------------------------------------------------------------------------------- frames
    def _take(self, frame: Frame | Damaged, tick: int) -> None:
        if isinstance(frame, Damaged):
            echo, kind, result = 0, 0, FrameResult.DAMAGED
        else:
            echo, kind = frame.number, frame.kind
            self.last_frame, self._silent = tick, False
            result = self._judge(frame, tick)
            if result == FrameResult.TAKEN:
                result = self._obey(frame, tick)
            if result == FrameResult.TAKEN and kind == FrameKind.HELLO:
                self.wanted = 0
                model = self.model
                ident = Ident(0, VERSION, model.number, model.slots, model.tail, model.room, model.shortest, model.hz)
                self.sent += wire.ident_frame(ident)
            if result == FrameResult.TAKEN and kind in NUMBERED:
                self.wanted = (self.wanted + 1) % 256
        answer = Answer(
            self.wanted,
            echo,
            kind,
            result,
            self.model.slots - len(self.queue),
            self.state,
            self._event % 256,
            self.inputs,
            self.power.flags(self.estop),
            self.position,
            tick,
        )
        self.sent += wire.answer_frame(answer) + self._repeated
        self._repeated = b""

    def _judge(self, frame: Frame, tick: int) -> FrameResult:
        """Return the error found in a frame before it is executed; TAKEN if there is none."""
        number, kind, payload = frame
        if kind not in FROM_HOST:
            return FrameResult.BAD_CONTENT
        if kind in NUMBERED and number != self.wanted:
            return FrameResult.WRONG_NUMBER
        if kind in ALLOWED and self.state not in ALLOWED[FrameKind(kind)]:
            return FrameResult.WRONG_STATE
        if kind == FrameKind.START and not self.queue:
            return FrameResult.WRONG_STATE
        if kind == FrameKind.RESET and self.estop:
            return FrameResult.WRONG_STATE
        if kind == FrameKind.CHECK and (self.config.driver & DriverFlag.DRY or self.power.on):
            return FrameResult.WRONG_STATE
        if kind in SIZES and len(payload) != SIZES[FrameKind(kind)]:
            return FrameResult.BAD_CONTENT
        return FrameResult.TAKEN

    def _obey(self, frame: Frame, tick: int) -> FrameResult:
        """Execute a frame, and return the result: TAKEN, or an error that only the execution reveals."""
        _, kind, payload = frame
        if kind == FrameKind.PUSH:
            return self._push(payload)
        if kind == FrameKind.START:
            return self._start(wire.start_tick(payload), tick)
        if kind == FrameKind.STOP:
            return self._stop(payload[0], tick)
        if kind == FrameKind.CONFIG:
            return self._configure(BoardConfig.unpack(payload), tick)
        if kind == FrameKind.TAIL:
            return self._set_table(payload)
        if kind == FrameKind.RESET:
            if payload[0] > ResetFlag.POSITION | ResetFlag.KNOWN | ResetFlag.POWER:
                return FrameResult.BAD_CONTENT
            self.power.unlock(payload[0])
            self._forget_the_run()
            self.state = IDLE
            if (position := wire.reset_position(payload)) is not None:
                self.position = position
        if kind == FrameKind.OUTPUTS:
            if max(payload) > ALL_OUTPUTS:
                return FrameResult.BAD_CONTENT
            if not self.power.may_switch(payload[0], payload[1], self.state, self.config, self.estop):
                return FrameResult.WRONG_STATE
            self._set_outputs(payload[0], payload[1], tick)
        if kind == FrameKind.REPEAT:
            age = (self._event - payload[0]) % 256
            if 1 <= age <= len(self._events):
                self._repeated = self._events[-age]
        if kind == FrameKind.CHECK:
            count, interval = wire.check_numbers(payload)
            if not count or interval < LEAST_CHECK:
                return FrameResult.BAD_CONTENT
        return FrameResult.TAKEN

    def _push(self, payload: bytes) -> FrameResult:
        if len(payload) % RECORD_BYTES or not RECORD_BYTES <= len(payload) <= RECORDS_A_FRAME * RECORD_BYTES:
            return FrameResult.BAD_CONTENT
        records = unpack(payload)
        if not all(record.good(self.model.shortest) for record in records):
            return FrameResult.BAD_CONTENT
        if len(self.queue) + len(records) > self.model.slots:
            return FrameResult.NO_ROOM
        self.queue.extend(records)
        return FrameResult.TAKEN

    def _start(self, start: int, tick: int) -> FrameResult:
        first = self.queue[0].interval
        ahead = _signed(start - tick)
        if abs(ahead) > START_MOST_TICKS or ahead + first < START_LEAD_TICKS:
            return FrameResult.LATE
        start = tick + ahead
        self.time = start << 16
        self.state = RUN
        self.power.begin_motion()
        self._load()
        for number in self._active():
            self._active_edge(number, start, starting=True)
        return FrameResult.TAKEN

    def _stop(self, how: int, tick: int) -> FrameResult:
        if how > 1:
            return FrameResult.BAD_CONTENT
        if how == 0 and self.state in (RUN, BRAKE):
            self._halt()
            self._report_event(Happening.STOPPED, HOST, tick)
        if how == 1 and self.state == RUN:
            self._brake(Happening.BRAKED, HOST, tick)
        return FrameResult.TAKEN

    def _configure(self, config: BoardConfig, tick: int) -> FrameResult:
        if not config.good:
            return FrameResult.BAD_CONTENT
        before, self.config = self.config, config
        if (before.driver, before.polarity & 2) != (config.driver, config.polarity & 2):
            self._set_outputs(ENABLE, 0, tick)
        if self.estop:
            self.power.cut(False, tick)
            if self.state == IDLE:
                self._halt()
        self.index = config.phase
        self._set_phases(tick)
        if self.state == BOOT:
            self._halt()
        return FrameResult.TAKEN

    def _set_table(self, payload: bytes) -> FrameResult:
        message = wire.tail_entries(payload)
        if message is None:
            return FrameResult.BAD_CONTENT
        first, entries = message
        intervals = [interval for interval, _ in self.table[:first] + entries]
        ascend = intervals[0] >= self.model.shortest << 8 and intervals == sorted(intervals)
        if first > len(self.table) or not ascend or not all(count for _, count in entries):
            return FrameResult.BAD_CONTENT
        if first + len(entries) > self.model.tail:
            return FrameResult.NO_ROOM
        if sum(count for _, count in self.table[:first] + entries) > MOST_RAMP_LEFT:
            return FrameResult.BAD_CONTENT
        self.table[first:] = entries
        return FrameResult.TAKEN
