"""What is under way between a host and a board: frames without an answer, events in their order."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass

from .outbox import BoardCommand
from .wire import BoardEvent

KEPT_EVENTS = 8  # that a board can report again


@dataclass(slots=True)
class SentFrame:
    """A frame that has not been answered; `copy` is the how manieth of its command."""

    number: int
    kind: int
    size: int
    sent_ns: int
    command: BoardCommand | None = None
    copy: int = 0
    event: int | None = None  # that is to be reported again


class EventOrder:
    """Events of a board, each once and in order, from the one with number `first` on.

    `lost` counts those that the board does not keep any more; `asked` has when to ask again for one that did not come.
    """

    def __init__(self, first: int) -> None:
        self._next = self._known = first  # the next one to be taken; the next one that the board will have
        self._early: dict[int, BoardEvent] = {}
        self.asked: dict[int, int] = {}  # ns
        self.lost = 0

    @property
    def complete(self) -> bool:
        """Whether all have been taken that the board is known to have had."""
        return self._next == self._known

    def counted(self, number: int) -> None:
        """Learn the number of the next event that the board will have, from an answer."""
        self._known = number  # however many there have been: answers keep their order
        while (self._known - self._next) % 256 > KEPT_EVENTS and self._next not in self._early:
            self.lost += 1
            self._go_on()

    def arrived(self, event: BoardEvent) -> None:
        """Keep an event until it is its turn; one that was taken before is nothing."""
        if (event.number - self._next) % 256 < 128:
            self._early[event.number] = event
            if (event.number - self._known) % 256 < 128:
                self.counted((event.number + 1) % 256)

    def take(self) -> BoardEvent | None:
        """Return the next event; None if it has not arrived."""
        event = self._early.pop(self._next, None)
        if event:
            self._go_on()
        return event

    def _go_on(self) -> None:
        self.asked.pop(self._next, None)
        self._next = (self._next + 1) % 256

    def missing(self, under_way: Set[int | None]) -> list[tuple[int, int]]:
        """Return the events that did not arrive and have not been asked for, and when to ask for each, in ns."""
        count = (self._known - self._next) % 256
        numbers = ((self._next + more) % 256 for more in range(count))
        return [
            (number, self.asked.get(number, 0))
            for number in numbers
            if number not in self._early and number not in under_way
        ]
