"""What an axis keeps of its motions, for pictures: when each began, by what, at which rates, and what else happened.

    command      MotionStart               Mark              MotionStart
       |             |                       |                   |
       v     sets out| first step            | "ABORT"           |
    ---.-------------|.....___---------------|---___-------------|....___---
                     |<-- ideal, from the first step on -->|
                                             departs: the motion follows its ideal no longer

Recording costs an append: names, rates and ideals are made when somebody asks.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from .ideal import Ideal
    from .kernel import Kernel


@dataclass(frozen=True, slots=True)
class MotionStart:
    """A motion has begun on an axis.

    `text` says what began it, in the manual's words; `rates` are those in force, by name, in steps/s ("R = 80" ->
    5978.0), `notes` further parameters ("S" -> 200); `ideal` is the part's ideal of this motion, as far as the motion
    has followed it, None where the part defines none or nothing has moved yet.  `changes` are other rates that came
    into force on the way, in place of these: since when, in ps, and all of them.
    """

    time_ps: int
    text: str
    rates: Mapping[str, float] = field(default_factory=dict)
    notes: Mapping[str, object] = field(default_factory=dict)
    law: Callable[[], Ideal | None] | None = field(default=None, compare=False, repr=False)
    changes: tuple[tuple[int, Mapping[str, float]], ...] = ()

    @property
    def ideal(self) -> Ideal | None:
        """The ideal, worked out when it is asked for: a picture of an hour has thousands of motions."""
        return self.law() if self.law is not None else None


@dataclass(frozen=True, slots=True)
class Mark:
    """Something that happened to an axis, in the manual's words; `kind` is "command", "limit", "home" or "event"."""

    time_ps: int
    kind: str
    text: str


class Parameters(NamedTuple):
    """What a motion is made with: rates in steps/s, and further parameters, by name."""

    rates: Mapping[str, float] = {}
    notes: Mapping[str, object] = {}


@dataclass(slots=True)
class _Started:
    """A motion as it is kept: what it is made with and its ideal are worked out when somebody asks."""

    time_ps: int
    text: str
    parameters: Callable[[], Parameters]
    ideal: Callable[[], Ideal | None] | None = None
    departed: int | None = None  # when it ceased to follow its ideal
    changes: list[tuple[int, Callable[[], Mapping[str, float]]]] = field(default_factory=list)

    def law(self) -> Ideal | None:
        """The ideal, as far as the motion has followed it."""
        ideal = self.ideal() if self.ideal is not None else None
        return ideal.until(self.departed) if ideal is not None and self.departed is not None else ideal


_time = attrgetter("time_ps")


class Motions:
    """The motions and marks of one axis, in the order of time."""

    __slots__ = ("_marks", "_started", "kernel")

    def __init__(self, kernel: Kernel) -> None:
        self.kernel = kernel
        self._started: list[_Started] = []
        self._marks: list[Mark] = []

    # ------------------------------------------------------------------------------------------------ what a chip says
    def begin(self, text: str, parameters: Callable[[], Parameters]) -> None:
        """A motion begins now; `parameters` says later with which ones."""
        self.depart()
        self._started.append(_Started(self.kernel.now, text, parameters))

    def expect(self, ideal: Callable[[], Ideal | None]) -> None:
        """The motion that has begun last follows an ideal, which is worked out later."""
        if self._started:
            self._started[-1].ideal = ideal

    def depart(self) -> None:
        """From now on the last motion does not follow its ideal any more."""
        if self._started and self._started[-1].departed is None:
            self._started[-1].departed = self.kernel.now

    def change(self, rates: Callable[[], Mapping[str, float]]) -> None:
        """From now on the last motion has other rates; `rates` says later which ones."""
        if self._started:
            self._started[-1].changes.append((self.kernel.now, rates))

    def mark(self, kind: str, text: str) -> None:
        """Something happens now."""
        self._marks.append(Mark(self.kernel.now, kind, text))

    # ---------------------------------------------------------------------------------------------------- what is asked
    def starts(self, start: int, stop: int) -> list[MotionStart]:
        """Return the motions that begin at start <= t <= stop."""
        first = bisect_left(self._started, start, key=_time)
        return [self._told(started) for started in self._started[first : bisect_right(self._started, stop, key=_time)]]

    def latest(self) -> MotionStart | None:
        """Return the motion that has begun last."""
        return self._told(self._started[-1]) if self._started else None

    def marks(self, start: int, stop: int) -> list[Mark]:
        """Return what has happened at start <= t <= stop."""
        first = bisect_left(self._marks, start, key=_time)
        return self._marks[first : bisect_right(self._marks, stop, key=_time)]

    def _told(self, started: _Started) -> MotionStart:
        changes = tuple((since, rates()) for since, rates in started.changes)
        return MotionStart(started.time_ps, started.text, *started.parameters(), started.law, changes)

    def forget(self, before: int) -> None:
        """Drop what lies before an instant, but for the motion that is under way there."""
        del self._started[: max(bisect_right(self._started, before, key=_time) - 1, 0)]
        del self._marks[: bisect_left(self._marks, before, key=_time)]
