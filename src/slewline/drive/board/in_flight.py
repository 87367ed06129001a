"""Messages in transit between host and board: unanswered frames, and events in order."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass

from .outbox import BoardCommand
from .wire import BoardEvent

KEPT_EVENTS = 8  # maximum number of events that a board can repeat


@dataclass(slots=True)
class SentFrame:
    """A frame that the board has not answered yet.

    `copy` is 1 if the frame is the first copy of its command, 2 for the second, and so on; it is 0 for a
    frame without a command.
    """

    number: int
    kind: int
    size: int
    sent_ns: int
    command: BoardCommand | None = None
    copy: int = 0
    event: int | None = None  # number of the event to be repeated


class EventOrder:
    """The events of a board, each once and in order, starting with number `first`.

    Attributes:
        lost: the number of events that the board has discarded.
        asked: the missing events that have been requested: the number of each event, and the earliest time
            (ns) at which to request it again.
    """

    def __init__(self, first: int) -> None:
        self._next = self._known = first  # the next one to be taken; the next one that the board will have
        self._early: dict[int, BoardEvent] = {}
        self.asked: dict[int, int] = {}  # ns
        self.lost = 0

    @property
    def complete(self) -> bool:
        """True if all known events of the board have been taken."""
        return self._next == self._known

    def counted(self, number: int) -> None:
        """Record the number of the board's next event; events too old for the board to repeat are counted as lost."""
        self._known = number  # however many were lost, because answers keep their order
        while (self._known - self._next) % 256 > KEPT_EVENTS and self._next not in self._early:
            self.lost += 1
            self._go_on()

    def arrived(self, event: BoardEvent) -> None:
        """Store an event until its turn; ignore it if that event has already been taken."""
        if (event.number - self._next) % 256 < 128:
            self._early[event.number] = event
            if (event.number - self._known) % 256 < 128:
                self.counted((event.number + 1) % 256)

    def take(self) -> BoardEvent | None:
        """Remove and return the next event in order; return None if it has not arrived."""
        event = self._early.pop(self._next, None)
        if event:
            self._go_on()
        return event

    def _go_on(self) -> None:
        self.asked.pop(self._next, None)
        self._next = (self._next + 1) % 256

    def missing(self, in_flight: Set[int | None]) -> list[tuple[int, int]]:
        """Return (number, time to request it in ns) for each missing event that is not in `in_flight`.

        `in_flight` has the numbers of the events for which a request is pending; a time of 0 means "now".
        """
        found, number = [], self._next
        while number != self._known:
            if number not in self._early and number not in in_flight:
                found.append((number, self.asked.get(number, 0)))
            number = (number + 1) % 256
        return found
