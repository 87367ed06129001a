"""The host's end of the wire to a board, without a line and without a clock: bytes in, bytes out, and what time it is.

The line keeps the order of what it carries.  So the answer to one frame shows that each frame before it has been
answered or is lost, and `wanted` of any answer shows which of the numbered ones were taken.  Nothing is sent a second
time before that is known; that is why every record arrives once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from ..core.time.hook import Hook
from . import wire
from .clock import BoardClock
from .records import Record, pack
from .wire import (
    ENTRIES_A_FRAME,
    Answer,
    BoardConfig,
    BoardEvent,
    BoardState,
    Damaged,
    Decoder,
    FrameKind,
    Happening,
    Ident,
    Outcome,
)

MS = 1_000_000
HEARTBEAT = 100 * MS  # ns between round trips, or a quarter of the watchdog
REFILL = 5 * MS  # while records wait for slots
PATIENCE, LONGEST_PATIENCE = 5 * MS, 500 * MS  # without an answer; or three median round trips
UNKNOWN = 20 * MS  # for a round trip, before there was one
BEHIND = 5 * MS  # an event that is told again comes so soon behind the answer, or it was lost again
AT_ONCE = 4  # records of a frame: two such frames are in the room of 127 bytes, with what is reserved; of 5 it is one
RESERVE = 11  # bytes of the room that only STOP, ASK and REPEAT may take
SMALL = 7  # bytes that one of these has
NOISY = 1000 * MS  # so long after damage each burst has an ASK behind it, whose answer shows what was lost
KEPT_EVENTS = 8  # that a board can tell again
ASKS_KEPT = 8
HOST_ROOM = 127


@dataclass(slots=True)
class Command:
    """Something numbered that the board is to take: its number is its place in the queue."""

    kind: FrameKind
    payload: bytes = b""
    records: list[Record] = field(default_factory=list)
    copies: int = 0  # sent so far


@dataclass(slots=True)
class Flight:
    """A frame that has not been answered; `copy` is the how manieth of its command."""

    number: int
    kind: int
    size: int
    sent_ns: int
    command: Command | None = None
    copy: int = 0
    event: int | None = None  # that is to be told again


class Link:
    """Frames to and from one board.

    `answer` is the last one, its tick unwrapped; `free` the slots that nothing is on its way to; `backlog` the records
    that the board has not taken yet.  `damaged` counts frames of the board that were, `resent` those of the host that
    went out again, `lost_events` what the board could not tell any more.

    `on_event` tells each event of the board once, in order, its tick unwrapped; `on_boot` that the board began anew:
    what was to be sent is forgotten, and it is to be opened again; `on_open` that it is open, with what it is;
    `on_refused` the answer to what it did not take (results 4, 5 and 6): that is dropped, what comes behind it goes on.
    """

    def __init__(self, clock: BoardClock) -> None:
        self.clock = clock
        self.on_event: Hook[[BoardEvent]] = Hook()
        self.on_boot: Hook[[]] = Hook()
        self.on_open: Hook[[Ident]] = Hook()
        self.on_refused: Hook[[Answer]] = Hook()
        self.ident: Ident | None = None
        self.answer: Answer | None = None
        self.damaged = self.resent = self.lost_events = 0
        self.heard_ns: int | None = None  # when the last frame came
        self._config: BoardConfig | None = None
        self._decoder = Decoder()
        self._token = 0
        self._now = 0
        self._close()

    def _close(self) -> None:
        self.is_open = self._configured = False
        self._opening = False
        self._commands: deque[Command] = deque()
        self._base = self._sent = 0  # number of the first command; how many of the first ones are under way
        self._flight: deque[Flight] = deque()
        self._stops: deque[int] = deque()  # `how`; the first may be under way
        self._ask = self._doubtful = False
        self._silences = 0
        self._waits_since = 0  # for the first answer that is missing
        self._most = AT_ONCE
        self._event = self._known_events = 0  # the next one to be told; the next one that the board will have
        self._early: dict[int, BoardEvent] = {}
        self._repeat_at: dict[int, int] = {}  # when each missing event may be asked for again, ns
        self._last_ask = 0
        self._noisy_until = 0

    # ---------------------------------------------------------------------------------------------- what is to be sent
    def open(self, config: BoardConfig) -> None:
        """Begin with a board, whatever it did before: HELLO, then CONFIG.  What was to be sent is forgotten."""
        payload = config.pack()
        self._close()
        self._config, self._opening = config, True
        self._commands.append(Command(FrameKind.CONFIG, payload))

    def _put(self, kind: FrameKind, payload: bytes) -> None:
        if self._opening or self.is_open:
            self._commands.append(Command(kind, payload))

    def configure(self, config: BoardConfig) -> None:
        """Send another CONFIG, which the board takes in BOOT, IDLE and HALT."""
        self._put(FrameKind.CONFIG, config.pack())
        self._config = config

    def push(self, records: Iterable[Record]) -> None:
        """Send records, as the board has room for them, in their order with everything else that is numbered.

        Like all that is called before `open` or after a boot, it has no effect then.
        """
        if not (self._opening or self.is_open):
            return
        for record in records:
            last = self._commands[-1] if len(self._commands) > self._sent else None
            if last and last.kind == FrameKind.PUSH and len(last.records) < self._most:
                last.records.append(record)
            else:
                self._commands.append(Command(FrameKind.PUSH, records=[record]))

    def start(self, tick: int) -> None:
        """Start what has been pushed before; the first record begins at a tick."""
        self._put(FrameKind.START, wire.start_payload(tick))

    def stop(self, how: int) -> None:
        """Stop: 0, at once; 1, by the tail.  It goes first; nothing numbered goes out until it is answered."""
        if self._opening or self.is_open:
            self._stops.append(how)

    def tail(self, entries: Sequence[tuple[int, int]]) -> None:
        """Replace the tail: (interval in 1/256 tick, count), ascending; as many as the board has room for."""
        for first in range(0, len(entries), ENTRIES_A_FRAME):
            self._put(FrameKind.TAIL, wire.tail_payload(first, entries[first : first + ENTRIES_A_FRAME]))

    def reset(self, position: int | None = None) -> None:
        """Leave HALT, or forget the queue; set the position, if one is given."""
        self._put(FrameKind.RESET, wire.reset_payload(position))

    def outputs(self, mask: int, value: int) -> None:
        """Set outputs: bits 0 to 3 are the user's, bit 4 is ENABLE."""
        self._put(FrameKind.OUTPUTS, bytes((mask, value)))

    def check(self, count: int, interval: int) -> None:
        """Begin the self-test: so many pulses, so many ticks apart."""
        self._put(FrameKind.CHECK, wire.check_payload(count, interval))

    def ask(self) -> None:
        """Ask how the board stands, as soon as possible."""
        self._ask = True

    # ------------------------------------------------------------------------------------------------------- how it is
    @property
    def backlog(self) -> int:
        """The records that the board has not taken yet."""
        return sum(len(command.records) for command in self._commands)

    @property
    def idle(self) -> bool:
        """Whether all that was to be sent has been taken, and every event told."""
        return not (self._commands or self._stops or self._opening) and self._event == self._known_events

    @property
    def free(self) -> int:
        """The slots of the board, minus what is on its way to them."""
        return max(0, self.answer.free - self.backlog) if self.answer and self.is_open else 0

    @property
    def _room(self) -> int:
        return (self.ident.room if self.ident else HOST_ROOM) - sum(each.size for each in self._flight)

    @property
    def _patience(self) -> int:
        usual = self.clock.round_trip_ns[2] or UNKNOWN
        least = max(PATIENCE, 3 * usual) << min(self._silences, 5)
        return min(least, LONGEST_PATIENCE)

    @property
    def _heartbeat(self) -> int:
        watchdog = self._config.watchdog if self._config else 0
        return min(HEARTBEAT, watchdog * 1_000_000_000 // self.clock.hz // 4) if watchdog else HEARTBEAT

    def _slots(self) -> int:
        """Return how many records may go out now."""
        under_way = sum(len(self._commands[at].records) for at in range(self._sent))
        return self.answer.free - under_way if self.answer else 0

    def due_ns(self) -> int | None:
        """Return when `outgoing` may next have something, if nothing comes in before; None if it will not."""
        if not (self._opening or self.is_open):
            return None
        if not self._flight:
            if self._opening or self._stops or self._ask or (self._next() is not None and not self._doubtful):
                return self._now
            if self._commands or self._doubtful:
                return self._last_ask + REFILL
            return min([self._last_ask + self._heartbeat, *(self._repeat_at.get(each, 0) for each in self._missing())])
        due = self._waits_since + self._patience
        if self.is_open:
            due = min(due, max(self._last_ask + self._heartbeat, self._now + MS))
        return due

    # --------------------------------------------------------------------------------------------------------- out
    def outgoing(self, now_ns: int) -> bytes:
        """Return what may go out now, and take it as sent."""
        self._now = now_ns
        out = bytearray()
        if self._flight and now_ns - self._waits_since >= self._patience:
            self._silences += 1
            self._waits_since = now_ns
            self._doubtful = self._ask = True
            if self._opening:
                self._flight.clear()
            else:
                out += self._send_ask()  # whatever is unanswered: it is lost, or the board does not listen anyway
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
        for event in self._missing():
            if self._room >= SMALL and now_ns >= self._repeat_at.get(event, 0):
                out += self._send(FrameKind.REPEAT, bytes((event,)))
                self._flight[-1].event = event
        while not self._stops and not self._doubtful and (command := self._next()):
            frame = wire.encode((self._base + self._sent) % 256, command.kind, command.payload or pack(command.records))
            if len(frame) > self._room - RESERVE:
                break
            self._sent += 1
            self.resent += command.copies > 0
            command.copies += 1
            self._note_sent(frame, (self._base + self._sent - 1) % 256, command.kind, command)
            out += frame
        behind = self._flight and self._flight[-1].command is not None
        if behind and now_ns < self._noisy_until and self._room >= SMALL:
            out += self._send_ask()
        return bytes(out)

    def _wants_ask(self) -> bool:
        asked = any(each.kind == FrameKind.ASK for each in self._flight)
        if asked:
            return False
        waits = self._commands and not self._flight and self._next() is None
        every = REFILL if waits or self._doubtful else self._heartbeat
        return self._ask or self._now - self._last_ask >= every

    def _next(self) -> Command | None:
        """Return the next command that may go out, as far as slots are concerned."""
        if self._sent >= len(self._commands):
            return None
        command = self._commands[self._sent]
        if command.kind == FrameKind.PUSH:
            fits = min(self._most, self._slots())
            if fits <= 0:
                return None
            if len(command.records) > fits:
                self._commands.insert(self._sent + 1, Command(FrameKind.PUSH, records=command.records[fits:]))
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

    def _note_sent(self, frame: bytes, number: int, kind: int, command: Command | None = None) -> None:
        if not self._flight:
            self._waits_since = self._now
        copy = command.copies if command else 0
        self._flight.append(Flight(number, kind, len(frame), self._now, command, copy))

    # ---------------------------------------------------------------------------------------------------------- in
    def receive(self, data: bytes, now_ns: int) -> None:
        """Take bytes of the board; the hooks are called from here."""
        self._now = now_ns
        for frame in list(self._decoder.feed(data)):
            said = None if isinstance(frame, Damaged) else wire.read(frame)
            if said is None:
                self.damaged += 1  # an answer, or an event: the next answer will show it
                self._ask = True
                self._noisy_until = now_ns + NOISY
                continue
            self.heard_ns = now_ns
            if isinstance(said, Answer):
                self._answered(said)
            elif isinstance(said, BoardEvent):
                self._happened(said)
            else:
                self.ident = said

    def _answered(self, answer: Answer) -> None:
        if not (self._opening or self.is_open):
            return
        flight = self._landed(answer)
        if self._opening:
            if flight and flight.kind == FrameKind.HELLO and answer.result == Outcome.TAKEN and self.ident:
                self._opened(self._unwrapped(flight, answer))
            return
        if answer.kind == 0:
            # which frame it was is known when the last one that is under way has been answered, if it is an ASK
            self._doubtful = True
            self._ask = not self._flight or self._flight[-1].kind != FrameKind.ASK
            self._noisy_until = self._now + NOISY
        answer = self._unwrapped(flight, answer)
        if answer.state == BoardState.BOOT and self._configured:
            self._booted()
            return
        self.answer = answer
        taken = (answer.wanted - self._base) % 256
        if taken <= self._sent:
            self._take(taken)
        self._lost_before(flight, answer)
        ahead = (answer.events - self._known_events) % 256
        if ahead < 128:
            self._known_events = answer.events
            self._tell()

    def _landed(self, answer: Answer) -> Flight | None:
        """Return the frame that an answer is for."""
        for flight in self._flight:
            if (flight.number, flight.kind) == (answer.echo, answer.kind):
                return flight
        return None

    def _unwrapped(self, flight: Flight | None, answer: Answer) -> Answer:
        if flight:
            self.clock.note(flight.sent_ns, self._now, answer.tick)
        return answer._replace(tick=self.clock.unwrap(answer.tick))

    def _opened(self, answer: Answer) -> None:
        assert self.ident is not None  # noqa: S101
        self._opening, self.is_open, self.answer = False, True, answer
        self._flight.clear()
        self._silences, self._doubtful = 0, False
        self._event = self._known_events = answer.events
        self._last_ask = self._now
        self.on_open(self.ident)

    def _take(self, taken: int) -> None:
        """The board has taken so many more commands."""
        for _ in range(taken):
            command = self._commands.popleft()
            self._configured |= command.kind == FrameKind.CONFIG
            if command.kind == FrameKind.PUSH:
                self._most = min(AT_ONCE, self._most + 1)
        self._base = (self._base + taken) % 256
        self._sent -= taken

    def _lost_before(self, flight: Flight | None, answer: Answer) -> None:
        """An answer came: what went out before its frame has been answered, or is lost."""
        if flight is None:
            return
        self._silences = 0
        self._waits_since = self._now
        while (each := self._flight.popleft()) is not flight:
            self._again(each)
        if flight.kind == FrameKind.ASK and not any(each.kind == FrameKind.ASK for each in self._flight):
            self._doubtful = self._ask
        if flight.kind == FrameKind.STOP and self._stops:
            self._stops.popleft()
        if flight.event is not None:
            self._repeat_at[flight.event] = self._now + BEHIND
        if answer.result in (Outcome.WRONG_NUMBER, Outcome.NO_ROOM):
            self._again(flight)
        elif answer.result != Outcome.TAKEN:
            if flight.command and self._commands and self._commands[0] is flight.command:
                self._commands.popleft()
                self._sent = 0
            self.on_refused(answer)

    def _again(self, flight: Flight) -> None:
        """A frame is lost: its command goes out again, and so do those behind it, which the board cannot take."""
        command = flight.command
        if command is None or command.copies != flight.copy:
            return
        for at in range(self._sent):
            if self._commands[at] is command:
                self._sent = at
                self._most = max(1, self._most // 2)
                return

    # ------------------------------------------------------------------------------------------------------- events
    def _happened(self, event: BoardEvent) -> None:
        if not self.is_open:
            return
        if event.kind == Happening.BOOT:
            self._booted()
            return
        ahead = (event.number - self._event) % 256
        if ahead >= 128:
            return  # told before
        self._early[event.number] = event._replace(tick=self.clock.unwrap(event.tick))
        if (event.number + 1 - self._known_events) % 256 < 128:
            self._known_events = (event.number + 1) % 256
        self._tell()

    def _tell(self) -> None:
        self._skip_what_is_too_old()
        while self.is_open and (told := self._early.pop(self._event, None)):
            self._repeat_at.pop(self._event, None)
            self._event = (self._event + 1) % 256
            self.on_event(told)

    def _skip_what_is_too_old(self) -> None:
        """Give up events that the board does not keep any more."""
        while (self._known_events - self._event) % 256 > KEPT_EVENTS and self._event not in self._early:
            self.lost_events += 1
            self._repeat_at.pop(self._event, None)
            self._event = (self._event + 1) % 256

    def _missing(self) -> list[int]:
        """Return the numbers of events that the board has told, that did not arrive, and that nothing was sent for."""
        asked = {each.event for each in self._flight}
        count = (self._known_events - self._event) % 256
        numbers = ((self._event + more) % 256 for more in range(count))
        return [number for number in numbers if number not in self._early and number not in asked]

    def _booted(self) -> None:
        self._close()
        self.ident = None
        self.clock.restart()
        self.on_boot()
