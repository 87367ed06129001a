"""Events in time, by number and by instant: steps, edges on a wire, marks passed by a shaft, recorded events.

    instant      0         a         b    c                d
    events       ----------|---------|----|----------------|------
    number                 1         2    3                4

    count(ps)            number of events by an instant    count(c) = 3
    time(k)              instant of event k                time(3) = c
    times(first, last)   instants of events, an array      times(2, 3) = [b, c]

All recurring events have this interface.  A source of events is a value: a step train computes its
events by arithmetic, a wire is searched, a list is looked up, and the caller need not distinguish them.
Events derived from other events have the same interface: shifted by a constant (`Later`), cut off at an
instant (`Until`), or numbered from an instant (`Since`).

The time of an event is a `When`: an instant (ps); or `NotYet`, if the search stopped early: the event does
not occur before the instant `at`, when the search can continue; or None, if the event is not foreseen.
NotYet is not a number, so a type checker finds code that mistakes it for an instant; code that only needs
a wake-up time calls `ask_at`.

Rules of this file: events are numbered from 1; the count at an instant includes an event at that instant;
queries have no effect.  The levels of a wire between its events are a wave (core/wires/wave.py).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, TypeAlias

from .timebase import Clock

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(slots=True)
class NotYet:
    """An event that has not been found yet: it does not occur before the instant `at` (ps); query again then."""

    at: int


When: TypeAlias = "int | NotYet | None"


def ask_at(when: When) -> int | None:
    """Return the instant (ps) of an event; for NotYet, that of the next query; None if none is foreseen."""
    return when.at if isinstance(when, NotYet) else when


def earliest(whens: Sequence[When]) -> int | None:
    """Return the earliest instant (ps) that `ask_at` returns for any of these events; None if none is foreseen."""
    return min((at for when in whens if (at := ask_at(when)) is not None), default=None)


def later(when: When, lag_ps: int) -> When:
    """Return `when` delayed by `lag_ps`: the instant of an event, or the `at` of a NotYet; None remains None."""
    if isinstance(when, NotYet):
        return NotYet(when.at + lag_ps)
    return None if when is None else when + lag_ps


def before(when: When, until: int | None) -> When:
    """Return the time of an event if it is before `until` (ps), else None; an `until` of None sets no limit."""
    if until is None or when is None:
        return when
    at = when.at if isinstance(when, NotYet) else when
    return when if at < until else None


class Events(Protocol):
    """Events in time, numbered from 1."""

    def count(self, ps: int) -> int:
        """Return the number of events up to and including an instant (ps)."""

    def time(self, k: int) -> When:
        """Return the instant (ps) of event k; NotYet if the search stopped early; None if event k is not foreseen."""

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of events first ... last, all of which must exist: (n,) int64 ps, ascending."""

    def few(self, numbers: list[int]) -> list[int]:
        """Return the instants (ps) of the events with the given ascending numbers.

        All the events must exist.  For a few events, this is faster than `times`.
        """
        return [at for k in numbers if isinstance(at := self.time(k), int)]


class Listed(Events):
    """Events at instants in a list, which may grow."""

    def __init__(self, instants: Sequence[int]) -> None:
        self.instants = instants

    def count(self, ps: int) -> int:
        return bisect_right(self.instants, ps)

    def time(self, k: int) -> When:
        """Return the instant of event k (ps); None if it is not in the list."""
        return self.instants[k - 1] if k <= len(self.instants) else None

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        import numpy as np

        return np.array(self.instants[first - 1 : last], np.int64)


class NoEvents(Listed):
    """A source without events, such as a wire with a constant level."""

    def __init__(self) -> None:
        super().__init__(())


class Even(Events):
    """Events at a constant rate (1/s), the first of which occurs one period after the instant `since` (ps)."""

    def __init__(self, since: int, rate: int) -> None:
        self.since, self.clock = since, Clock(rate)

    def count(self, ps: int) -> int:
        return max(self.clock.ticks_until(ps - self.since), 0)

    def time(self, k: int) -> When:
        """Return the instant (ps) of event k, rounded down to a whole picosecond."""
        return self.since + self.clock.ps(k)

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of events first ... last: (n,) int64 ps, ascending."""
        import numpy as np

        return self.since + self.clock.ps_array(np.arange(first, last + 1))


class Until(Events):
    """The events of a source before the instant `until` (ps); all its events if `until` is None."""

    until: int | None

    def __init__(self, of: Events, until: int | None = None) -> None:
        self.of, self.until = of, until

    def cut(self, ps: int) -> None:
        """Set the limit so that all events after an instant (ps) are left out."""
        self.until = ps + 1

    def within(self, ps: int) -> int:
        """Return the given instant (ps), or the last instant before `until` if that is earlier."""
        until = self.until
        return ps if until is None or ps < until else until - 1

    def count(self, ps: int) -> int:
        until = self.until
        return self.of.count(ps if until is None or ps < until else until - 1)

    def time(self, k: int) -> When:
        """Return the instant (ps) of event k; NotYet as in `Events.time`; None if not foreseen before `until`."""
        return before(self.of.time(k), self.until)

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        return self.of.times(first, last)

    def few(self, numbers: list[int]) -> list[int]:
        """Return the instants (ps) of the events with the given ascending numbers; all the events must exist."""
        return self.of.few(numbers)


class Later(Events):
    """The events of a source, each delayed by the same number of picoseconds."""

    def __init__(self, of: Events, lag_ps: int) -> None:
        self.of, self.lag_ps = of, lag_ps

    def count(self, ps: int) -> int:
        return self.of.count(ps - self.lag_ps)

    def time(self, k: int) -> When:
        return later(self.of.time(k), self.lag_ps)

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        return self.of.times(first, last) + self.lag_ps

    def few(self, numbers: list[int]) -> list[int]:
        """Return the instants (ps) of the events with the given ascending numbers; all the events must exist."""
        return [at + self.lag_ps for at in self.of.few(numbers)]


class Since(Events):
    """The events of a source after an instant (ps), numbered from 1."""

    def __init__(self, of: Events, ps: int) -> None:
        self.of, self.first = of, of.count(ps)

    def count(self, ps: int) -> int:
        return max(self.of.count(ps) - self.first, 0)

    def time(self, k: int) -> When:
        return self.of.time(self.first + k)

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        return self.of.times(self.first + first, self.first + last)

    def few(self, numbers: list[int]) -> list[int]:
        """Return the instants (ps) of the events with the given ascending numbers; all the events must exist."""
        first = self.first
        return self.of.few([first + k for k in numbers])
