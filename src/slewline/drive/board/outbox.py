"""Commands from a host to a board, in the order in which the board is to take them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from ...errors import UsageError
from . import wire
from .records import Record
from .wire import ENTRIES_A_FRAME, BoardConfig, FrameKind

MOTION = (FrameKind.PUSH, FrameKind.START)
AT_ONCE = 4  # records per frame: two such frames fit into the room of 127 bytes, minus the reserve; with 5, only one


@dataclass(slots=True)
class BoardCommand:
    """A numbered command for the board; its number follows from its position in the queue."""

    kind: FrameKind
    payload: bytes = b""
    records: list[Record] = field(default_factory=list)
    copies: int = 0  # sent so far


class Outbox:
    """The pending commands; calls have no effect while the link is closed."""

    def __init__(self) -> None:
        self.is_open = self._opening = False
        self._config: BoardConfig | None = None
        self._forget_commands()

    def _forget_commands(self) -> None:
        self._commands: deque[BoardCommand] = deque()
        self._sent = 0  # number of the first ones in transit
        self._stops: deque[int] = deque()  # `how`; the first may be in transit
        self._most = AT_ONCE  # records per frame; fewer on a line that damages many

    @property
    def backlog(self) -> int:
        """The number of records that the board has not taken yet."""
        return sum(len(command.records) for command in self._commands)

    def _put(self, kind: FrameKind, payload: bytes) -> None:
        if self._opening or self.is_open:
            self._commands.append(BoardCommand(kind, payload))

    def configure(self, config: BoardConfig) -> None:
        """Send a new CONFIG, which the board accepts in BOOT, IDLE and HALT."""
        self._put(FrameKind.CONFIG, config.pack())
        self._config = config

    def push(self, records: Iterable[Record]) -> None:
        """Queue records, which are sent as the board has room for them, in order with all other numbered commands.

        Like every call, this has no effect before `open`, or after a restart of the board.
        """
        if not (self._opening or self.is_open):
            return
        for record in records:
            last = self._commands[-1] if len(self._commands) > self._sent else None
            if last and last.kind == FrameKind.PUSH and len(last.records) < self._most:
                last.records.append(record)
            else:
                self._commands.append(BoardCommand(FrameKind.PUSH, records=[record]))

    def start(self, tick: int) -> None:
        """Start the records pushed earlier; the first record begins at the given tick."""
        self._put(FrameKind.START, wire.start_payload(tick))

    def restart(self, tick: int) -> None:
        """Make the records already on the board begin at a tick: send START, ahead of any further records.

        START must come first because the board frees no slots for further records until it has started.
        """
        if self.is_open:
            self._commands.insert(self._sent, BoardCommand(FrameKind.START, wire.start_payload(tick)))

    @property
    def starting(self) -> bool:
        """True while there is a START that the board has not taken yet."""
        return any(command.kind == FrameKind.START for command in self._commands)

    def abandon(self) -> None:
        """Discard the unsent rest of a motion; records in transit may still be taken, and then remain until RESET."""
        later = [self._commands.pop() for _ in range(len(self._commands) - self._sent)]
        self._commands.extend(each for each in reversed(later) if each.kind not in MOTION)

    def stop(self, how: int) -> None:
        """Stop the motor, immediately (`how` = 0) or along the tail (1).

        STOP overtakes the numbered commands not yet sent; these wait until it is answered.

        Raises:
            UsageError: `how` is neither 0 nor 1.
        """
        if how not in (0, 1):
            raise UsageError(f"stop({how!r}); expected 0 (immediately) or 1 (along the stop ramp)")
        if self._opening or self.is_open:
            self._stops.append(how)

    def tail(self, entries: Sequence[tuple[int, int]]) -> None:
        """Replace the tail, which is the board's stop ramp.

        Args:
            entries: pairs (interval in 1/256 tick, number of steps), sorted by ascending interval; no more than
                the board has room for.
        """
        for first in range(0, len(entries), ENTRIES_A_FRAME):
            self._put(FrameKind.TAIL, wire.tail_payload(first, entries[first : first + ENTRIES_A_FRAME]))

    def reset(self, position: int | None = None, *, known: bool = False, power: bool = False) -> None:
        """Clear the board's queue, and leave HALT; set the position if one is given.

        Args:
            position: the new count of the board; None to keep its count.
            known: True if the count is known to be the position of the motor.
            power: True if the driver may be switched on again, even if the board has switched it off.
        """
        self._put(FrameKind.RESET, wire.reset_payload(position, known=known, power=power))

    def outputs(self, mask: int, value: int) -> None:
        """Set the outputs in `mask` to the bits of `value`: bits 0 to 3 are the user outputs, bit 4 is ENABLE."""
        self._put(FrameKind.OUTPUTS, bytes((mask, value)))

    def check(self, count: int, interval: int) -> None:
        """Start the board's self-test: `count` pulses, `interval` ticks apart."""
        self._put(FrameKind.CHECK, wire.check_payload(count, interval))
