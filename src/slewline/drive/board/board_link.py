"""The host's end of the wire to a board, without a port or a clock: the caller supplies bytes and time.

The line preserves the order of frames.  So the answer to a frame shows that each earlier frame has been
answered or is lost; and the `wanted` field of any answer, which is the number of the next command that
the board expects, shows which commands the board has taken.  No command is sent a second time before it
is known that the board has not taken it; therefore the board takes every record exactly once.
"""

from __future__ import annotations

from collections import deque

from ...core.time.hook import Hook
from . import wire
from .clock import BoardClock
from .in_flight import EventOrder, SentFrame
from .outbox import AT_ONCE, BoardCommand, Outbox
from .records import pack
from .wire import (
    Answer,
    BoardConfig,
    BoardEvent,
    BoardState,
    Damaged,
    Decoder,
    FrameKind,
    FrameResult,
    Happening,
    Ident,
)

MS = 1_000_000
HEARTBEAT = 100 * MS  # ns between round trips, or a quarter of the watchdog
HEARTBEAT_AT_REST = 500 * MS  # if a board at rest needs none: its clock is checked
REFILL = 5 * MS  # while records wait for slots
SILENCE, LONGEST_SILENCE = 5 * MS, 500 * MS  # without an answer; or three median round trips
UNKNOWN = 20 * MS  # for a round trip, before there was one
REPEAT_NS = 5 * MS  # a repeated event follows the answer within this time, or was lost again
RESERVE = 11  # bytes of the room reserved for STOP, ASK and REPEAT
SMALL = 7  # bytes of one such frame
ASKS_KEPT = 8
HOST_ROOM = 127


class Link(Outbox):
    """Frames to and from one board.

    Attributes:
        answer: the last answer, with its tick unwrapped.
        backlog: the number of records that the board has not taken yet.
        free: the number of slots that will be free on the board after it has taken the backlog.
        damaged: the number of damaged frames from the board.
        resent: the number of commands that the host has sent again.
        at_rest: True if the motor is at rest and no step is pending; set by the owner.
        bears_silence: True if a board at rest needs no messages; set by the owner.
        on_event: hook, called with each event of the board once, in order, with its tick unwrapped.
        on_boot: hook, called when the board has restarted; pending commands are discarded, and the board
            must be opened again.
        on_open: hook, called with the IDENT of the board when the board is open.
        on_refused: hook, called with the answer to a refused command (results 4, 5 and 6); this command is
            dropped, and the later commands are still sent.
    """

    def __init__(self, clock: BoardClock) -> None:
        super().__init__()
        self.clock = clock
        self.on_event: Hook[[BoardEvent]] = Hook()
        self.on_boot: Hook[[]] = Hook()
        self.on_open: Hook[[Ident]] = Hook()
        self.on_refused: Hook[[Answer]] = Hook()
        self.ident: Ident | None = None
        self.answer: Answer | None = None
        self.counted: int | None = None  # the board's count, as last reported: signed 32 bits
        self.damaged = self.resent = 0
        self.received_ns: int | None = None  # time of the last frame
        self.at_rest = self.bears_silence = False
        self._decoder = Decoder()
        self._token = 0
        self._now = 0
        self._close()

    def _close(self) -> None:
        self.is_open = self._opening = self._configured = False
        self._forget_commands()
        self._base = 0  # number of the first command
        self._flight: deque[SentFrame] = deque()
        self._ask = False
        self._silences = 0
        self._waits_since = 0  # start of the wait for the first missing answer
        self._asked_ns = 0  # time of the first of the unanswered frames
        self._events = EventOrder(0)
        self._last_ask = 0

    def open(self, config: BoardConfig) -> None:
        """Open a board, whatever its state: send HELLO, then CONFIG.  Pending commands are discarded."""
        payload = config.pack()
        self._close()
        self._config, self._opening = config, True
        self._commands.append(BoardCommand(FrameKind.CONFIG, payload))

    def ask(self) -> None:
        """Query the state of the board as soon as possible."""
        self._ask = True

    # ----------------------------------------------------------------------------------------------------------- state
    @property
    def lost_events(self) -> int:
        """The number of events that the board has discarded since it was opened, and cannot repeat."""
        return self._events.lost

    @property
    def idle(self) -> bool:
        """True if the board has taken all commands, and all its known events have been reported."""
        return not (self._commands or self._stops or self._opening) and self._events.complete

    def unanswered_ns(self, now_ns: int) -> int:
        """Return how long the board has been silent while frames are pending, in ns; 0 if no frame is pending."""
        if not self._flight:
            return 0
        return now_ns - max(self.received_ns or 0, self._asked_ns)

    @property
    def free(self) -> int:
        """The number of slots that will be free on the board after it has taken all records of the backlog."""
        return max(0, self.answer.free - self.backlog) if self.answer and self.is_open else 0

    @property
    def _room(self) -> int:
        return (self.ident.room if self.ident else HOST_ROOM) - sum(each.size for each in self._flight)

    @property
    def _answer_timeout(self) -> int:
        usual = self.clock.round_trip_ns[2] or UNKNOWN
        least = max(SILENCE, 3 * usual) << min(self._silences, 2)
        return min(least, LONGEST_SILENCE)

    @property
    def _heartbeat(self) -> int:
        if self.at_rest and self.bears_silence:
            return HEARTBEAT_AT_REST
        watchdog = self._config.watchdog if self._config else 0
        return min(HEARTBEAT, watchdog * 1_000_000_000 // self.clock.hz // 4) if watchdog else HEARTBEAT

    def _slots(self) -> int:
        """Return the number of records that may be sent now."""
        in_flight = sum(len(self._commands[at].records) for at in range(self._sent))
        return self.answer.free - in_flight if self.answer else 0

    def due_ns(self) -> int | None:
        """Return when (ns) `outgoing` may next return bytes, unless bytes are received first; None while closed."""
        if not (self._opening or self.is_open):
            return None
        if not self._flight:
            if self._opening or self._stops or self._ask or self._next() is not None:
                return self._now
            if self._commands:
                return self._last_ask + REFILL
            return min([self._last_ask + self._heartbeat, *(again_ns for _, again_ns in self._events.missing(set()))])
        due = self._waits_since + self._answer_timeout
        if self.is_open:
            due = min(due, max(self._last_ask + self._heartbeat, self._now + MS))
        return due

    # --------------------------------------------------------------------------------------------------------- out
    def outgoing(self, now_ns: int) -> bytes:
        """Return the bytes to send now, and count them as sent."""
        self._now = now_ns
        out = bytearray()
        if self._flight and now_ns - self._waits_since >= self._answer_timeout:
            self._silences += 1
            self._waits_since = now_ns
            self._ask = True
            if self._opening:
                self._flight.clear()
            else:
                out += self._send_ask()  # despite unanswered frames: they were lost, or the board ignored them
        if self._opening:
            if not self._flight:
                out += self._send(FrameKind.HELLO)
            return bytes(out)
        if not self.is_open:
            return b""
        if self._stops and not any(each.kind == FrameKind.STOP for each in self._flight):
            out += self._send(FrameKind.STOP, bytes((self._stops[0],)))
        if self._wants_ask() and self._room >= SMALL:
            out += self._send_ask()
        for event, again_ns in self._events.missing({each.event for each in self._flight}):
            if self._room >= SMALL and now_ns >= again_ns:
                out += self._send(FrameKind.REPEAT, bytes((event,)))
                self._flight[-1].event = event
        while not self._stops and (command := self._next()):
            frame = wire.encode((self._base + self._sent) % 256, command.kind, command.payload or pack(command.records))
            if len(frame) > self._room - RESERVE:
                break
            self._sent += 1
            self.resent += command.copies > 0
            command.copies += 1
            self._note_sent(frame, (self._base + self._sent - 1) % 256, command.kind, command)
            out += frame
        return bytes(out)

    def _wants_ask(self) -> bool:
        asked = any(each.kind == FrameKind.ASK for each in self._flight)
        if asked:
            return False
        waits = self._commands and not self._flight and self._next() is None
        every = REFILL if waits else self._heartbeat
        return self._ask or self._now - self._last_ask >= every

    def _next(self) -> BoardCommand | None:
        """Return the next command to send; None if there is none, or the board has no free slots for its records."""
        if self._sent >= len(self._commands):
            return None
        command = self._commands[self._sent]
        if command.kind == FrameKind.PUSH:
            fits = min(self._most, self._slots())
            if fits <= 0:
                return None
            if len(command.records) > fits:
                self._commands.insert(self._sent + 1, BoardCommand(FrameKind.PUSH, records=command.records[fits:]))
                del command.records[fits:]
        return command

    def _send_ask(self) -> bytes:
        self._ask, self._last_ask = False, self._now
        asks = [each for each in self._flight if each.kind == FrameKind.ASK]
        for each in asks[:-ASKS_KEPT]:
            self._flight.remove(each)
        return self._send(FrameKind.ASK)

    def _send(self, kind: FrameKind, payload: bytes = b"") -> bytes:
        self._token = (self._token + 1) % 256
        frame = wire.encode(self._token, kind, payload)
        self._note_sent(frame, self._token, kind)
        return frame

    def _note_sent(self, frame: bytes, number: int, kind: int, command: BoardCommand | None = None) -> None:
        if not self._flight:
            self._waits_since = self._asked_ns = self._now
        copy = command.copies if command else 0
        self._flight.append(SentFrame(number, kind, len(frame), self._now, command, copy))

    # ---------------------------------------------------------------------------------------------------------- in
    def receive(self, data: bytes, now_ns: int) -> None:
        """Receive bytes from the board; the hooks are called from here."""
        self._now = now_ns
        for frame in self._decoder.feed(data):
            message = None if isinstance(frame, Damaged) else wire.read(frame)
            if message is None:
                self.damaged += 1  # an answer or an event: the next answer shows which
                self._ask = True
                continue
            self.received_ns = now_ns
            if isinstance(message, Answer):
                self._answered(message)
            elif isinstance(message, BoardEvent):
                self._happened(message)
            else:
                self.ident = message

    def _answered(self, answer: Answer) -> None:
        if not (self._opening or self.is_open):
            return
        flight = self._landed(answer)
        if self._opening:
            if flight and flight.kind == FrameKind.HELLO and answer.result == FrameResult.TAKEN and self.ident:
                self._opened(self._unwrapped(flight, answer))
            return
        if answer.kind == 0:
            # the frame is known when the last pending one has been answered, if it is an ASK
            self._ask = not self._flight or self._flight[-1].kind != FrameKind.ASK
        answer = self._unwrapped(flight, answer)
        if answer.state == BoardState.BOOT and self._configured:
            self._booted()
            return
        self.answer, self.counted = answer, answer.position
        taken = (answer.wanted - self._base) % 256
        if taken <= self._sent:
            self._take(taken)
        self._lost_before(flight, answer)
        self._events.counted(answer.events)
        self._report()

    def _landed(self, answer: Answer) -> SentFrame | None:
        """Return the pending frame to which an answer belongs; None if there is no such frame."""
        for flight in self._flight:
            if (flight.number, flight.kind) == (answer.echo, answer.kind):
                return flight
        return None

    def _unwrapped(self, flight: SentFrame | None, answer: Answer) -> Answer:
        if flight:
            self.clock.note(flight.sent_ns, self._now, answer.tick)
        return answer._replace(tick=self.clock.unwrap(answer.tick))

    def _opened(self, answer: Answer) -> None:
        assert self.ident is not None  # noqa: S101
        self._opening, self.is_open, self.answer = False, True, answer
        self.counted = answer.position
        self._flight.clear()
        self._silences = 0
        self._events = EventOrder(answer.events)
        self._last_ask = self._now
        self.on_open(self.ident)

    def _take(self, taken: int) -> None:
        """Record that the board has taken `taken` more commands."""
        for _ in range(taken):
            command = self._commands.popleft()
            self._configured |= command.kind == FrameKind.CONFIG
            if command.kind == FrameKind.PUSH:
                self._most = min(AT_ONCE, self._most + 1)
        self._base = (self._base + taken) % 256
        self._sent -= taken

    def _lost_before(self, flight: SentFrame | None, answer: Answer) -> None:
        """Handle the answer to a frame: pending frames sent before it are lost, and their commands are sent again."""
        if flight is None:
            return
        self._silences = 0
        self._waits_since = self._now
        while (each := self._flight.popleft()) is not flight:
            self._again(each)
        if flight.kind == FrameKind.STOP and self._stops and answer.result == FrameResult.TAKEN:
            self._stops.popleft()
        if flight.event is not None:
            self._events.asked[flight.event] = self._now + REPEAT_NS
        if answer.result in (FrameResult.WRONG_NUMBER, FrameResult.NO_ROOM):
            self._again(flight)
        elif answer.result != FrameResult.TAKEN and flight.command:
            self._refused(flight.command, answer)

    def _refused(self, command: BoardCommand, answer: Answer) -> None:
        """Drop a command that the board has refused, and renumber the later commands."""
        if self._commands and self._commands[0] is command:
            self._commands.popleft()
            self._sent = 0
            self.on_refused(answer)

    def _again(self, flight: SentFrame) -> None:
        """Send again the command of a lost frame, and all later ones, which the board cannot take without it."""
        command = flight.command
        if command is None or command.copies != flight.copy:
            return
        for at in range(self._sent):
            if self._commands[at] is command:
                self._sent = at
                self._most = max(1, self._most // 2)
                return

    def _happened(self, event: BoardEvent) -> None:
        if not self.is_open:
            return
        if event.kind == Happening.BOOT:
            self._booted()
            return
        self._events.arrived(event._replace(tick=self.clock.unwrap(event.tick)))
        self._report()

    def _report(self) -> None:
        while self.is_open and (event := self._events.take()):
            if self.answer is None or event.tick >= self.answer.tick:
                self.counted = event.position
            self.on_event(event)

    def _booted(self) -> None:
        self._close()
        self.ident = None
        self.clock.restart()
        self.on_boot()
