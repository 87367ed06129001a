"""The motions of an axis, each with its start, command, rates, end and the reason for the end; and other events.

    command      MotionStart               Mark            MotionEnd        MotionStart
       |             |                       |                |                  |
       v      starts | first step            | "ABORT"        | "stopped"        |
    ---.-------------|.....___---------------|---___----------|------------------|....___---
                     |<-- ideal, from the first step on -->|
                                             departs: the motion no longer follows its ideal

Recording an event costs only a list append: names, rates and ideals are computed on request.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import TYPE_CHECKING, Literal, NamedTuple

from ..messages.instead import missing
from ..time.hook import Hook
from ..time.kernel import Kernel

if TYPE_CHECKING:
    from .ideal_motion import Ideal

Why = Literal["done", "stopped", "limit", "changed", "cut"]


@dataclass(frozen=True, slots=True)
class MotionEnd:
    """The end of a motion of an axis.

    Attributes:
        time_ps: the instant at which the motion ended, ps.
        position: the position register at that instant.
        steps: the net steps of this motion, negative counter-clockwise.
        why: the reason for the end.  "done": the motion was completed; "stopped": it was ended early by a
            command or an input (ABORT, Z, STOP, another profile mode ...); "limit": a limit switch or the
            end of the position counter ended it; "changed": another motion replaced it before the motor
            came to rest; "cut": it was cut off immediately, even within a step (by K, by a reset, or because
            the motor or the supply was switched off).
    """

    time_ps: int
    position: int
    steps: int
    why: Why


@dataclass(frozen=True, slots=True)
class MotionStart:
    """A motion of an axis, available as soon as it begins.

    Attributes:
        time_ps: the instant at which the motion began, ps.
        text: the command that began the motion, in the words of the manual: "G", "UPDATE".
        rates: the rates in force at its start, keyed by name, in steps/s ("R = 80" -> 5978.0).
        notes: further parameters, keyed by name ("S" -> 200).
        changes: later rate changes: the instant of each, ps, and all rates in force after it.
        position: the position register at the start of the motion.
        direction: 1 clockwise, -1 counter-clockwise, 0 if the command does not determine it.
        end: the end of the motion; None while the motion is in progress.
        law: the function that computes `ideal`; None if the motion has no ideal.
    """

    time_ps: int
    text: str
    rates: Mapping[str, float] = field(default_factory=dict)
    notes: Mapping[str, object] = field(default_factory=dict)
    law: Callable[[], Ideal | None] | None = field(default=None, compare=False, repr=False)
    changes: tuple[tuple[int, Mapping[str, float]], ...] = ()
    position: int = 0
    direction: int = 0
    end: MotionEnd | None = None

    @property
    def ideal(self) -> Ideal | None:
        """The ideal of this motion, cut off at the instant at which the motion departs from it.

        It is None if the motion has no ideal, or if no step of the motion has begun.
        """
        # computed on request: a picture of an hour has thousands of motions
        return self.law() if self.law is not None else None


missing(
    MotionStart,
    **dict.fromkeys(("start", "begin", "time"), "motion.time_ps, and motion.position where it begins"),
    **dict.fromkeys(("stop", "duration"), "motion.end.time_ps, of one that has ended"),
    steps="motion.end.steps, of one that has ended",
)


@dataclass(frozen=True, slots=True)
class Mark:
    """An event on an axis, other than the start or the end of a motion.

    Attributes:
        time_ps: the instant of the event, ps.
        kind: "command", "limit", "home" or "event".
        text: the event, in the manual's words.
    """

    time_ps: int
    kind: str
    text: str


class MotionParameters(NamedTuple):
    """The parameters of a motion.

    Attributes:
        rates: the rates, keyed by name, in steps/s ("R = 80" -> 5978.0).
        notes: further parameters, keyed by name ("S" -> 200).
    """

    rates: Mapping[str, float] = {}
    notes: Mapping[str, object] = {}


@dataclass(slots=True)
class _Started:
    """A motion as stored; its parameters and its ideal are computed on request."""

    time_ps: int
    text: str
    parameters: Callable[[], MotionParameters]
    position: int
    travel: int
    direction: int
    ideal: Callable[[], Ideal | None] | None = None
    departed: int | None = None  # when it ceased to follow its ideal
    changes: tuple[tuple[int, Callable[[], Mapping[str, float]]], ...] = ()  # few motions have changes
    asked_to_stop: bool = False
    end: MotionEnd | None = None

    def law(self) -> Ideal | None:
        """Return the ideal, cut off where the motion departs from it; None if the motion has no ideal."""
        ideal = self.ideal() if self.ideal is not None else None
        return ideal.until(self.departed) if ideal is not None and self.departed is not None else ideal


_time = attrgetter("time_ps")


class Motions:
    """The motions and marks of one axis, in chronological order.

    The hook `on_begin` is called with the MotionStart of every motion as it begins, and `on_end` with its
    MotionEnd as it ends.

    Args:
        where: a function that returns the current position register and the travel, in steps.
        halt: a function that cuts off the step in progress.
    """

    __slots__ = ("_halt", "_marks", "_started", "_where", "kernel", "on_begin", "on_end")

    def __init__(self, kernel: Kernel, where: Callable[[], tuple[int, int]], halt: Callable[[], None]) -> None:
        self.kernel, self._where, self._halt = kernel, where, halt
        self.on_begin: Hook[[MotionStart]] = Hook()
        self.on_end: Hook[[MotionEnd]] = Hook()
        self._started: list[_Started] = []
        self._marks: list[Mark] = []

    # ----------------------------------------------------------------------------------------------- reports of a chip
    def begin(self, text: str, parameters: Callable[[], MotionParameters], direction: int = 0) -> None:
        """Record that the command `text` begins a motion now; a motion still in progress ends as "changed".

        `parameters` is called whenever the parameters of the motion are requested.
        """
        self.end("changed")
        self.depart()
        position, travel = self._where()
        self._started.append(_Started(self.kernel.now, text, parameters, position, travel, direction))
        if self.on_begin.listeners:
            self.on_begin(self._motion_start(self._started[-1]))

    @property
    def in_progress(self) -> bool:
        """True while a motion is in progress."""
        return bool(self._started) and self._started[-1].end is None

    def stop(self) -> None:
        """Record that the motion in progress has been ordered to end early; it ends when the motor is at rest."""
        if self._started:
            self._started[-1].asked_to_stop = True

    def end(self, why: Why | None = None) -> None:
        """End the motion in progress, if any.

        By default, the reason is "stopped" if the motion was ordered to end early, otherwise "done".
        """
        if not self.in_progress:
            return
        started = self._started[-1]
        position, travel = self._where()
        reason: Why = why or ("stopped" if started.asked_to_stop else "done")
        started.end = MotionEnd(self.kernel.now, position, travel - started.travel, reason)
        if reason == "cut":
            self.depart()
            self._halt()
        if self.on_end.listeners:
            self.on_end(started.end)

    def expect(self, ideal: Callable[[], Ideal | None]) -> None:
        """Set the ideal of the latest motion; the function `ideal` is called later to compute it."""
        if self._started:
            self._started[-1].ideal = ideal

    def depart(self) -> None:
        """Record that the latest motion departs from its ideal now, if it has not departed earlier."""
        if self._started and self._started[-1].departed is None:
            self._started[-1].departed = self.kernel.now

    def change(self, rates: Callable[[], Mapping[str, float]]) -> None:
        """Record that the rates of the latest motion change now.

        `rates` returns the new rates, keyed by name, in steps/s; it is called whenever they are requested.
        """
        if self._started:
            self._started[-1].changes += ((self.kernel.now, rates),)

    def mark(self, kind: str, text: str) -> None:
        """Record an event now; for `kind`, see `Mark`."""
        self._marks.append(Mark(self.kernel.now, kind, text))

    # ---------------------------------------------------------------------------------------------------------- queries
    def starts(self, start: int, stop: int) -> list[MotionStart]:
        """Return the motions that begin in start <= t <= stop (ps)."""
        first = bisect_left(self._started, start, key=_time)
        return [
            self._motion_start(started)
            for started in self._started[first : bisect_right(self._started, stop, key=_time)]
        ]

    def latest(self) -> MotionStart | None:
        """Return the motion that began last; None if none has begun."""
        return self._motion_start(self._started[-1]) if self._started else None

    def texts(self, start: int, stop: int) -> list[tuple[int, str]]:
        """Return the starts and ends of motions in start <= t <= stop (ps).

        Each is a pair: the instant (ps), and the command that began the motion, or "" for an end.
        """
        found: list[tuple[int, str]] = []
        first = max(bisect_left(self._started, start, key=_time) - 1, 0)
        for started in self._started[first : bisect_right(self._started, stop, key=_time)]:
            found.append((started.time_ps, started.text))
            if started.end is not None:
                found.append((started.end.time_ps, ""))
        return [entry for entry in found if start <= entry[0] <= stop]

    def marks(self, start: int, stop: int) -> list[Mark]:
        """Return the marks in start <= t <= stop (ps)."""
        first = bisect_left(self._marks, start, key=_time)
        return self._marks[first : bisect_right(self._marks, stop, key=_time)]

    def _motion_start(self, started: _Started) -> MotionStart:
        changes = tuple((since, rates()) for since, rates in started.changes)
        rates, notes = started.parameters()
        return MotionStart(
            started.time_ps,
            started.text,
            rates,
            notes,
            started.law,
            changes,
            started.position,
            started.direction,
            started.end,
        )

    def forget(self, before: int) -> None:
        """Drop the marks before an instant (ps), and the motions that began by then, except the last of these."""
        del self._started[: max(bisect_right(self._started, before, key=_time) - 1, 0)]
        del self._marks[: bisect_left(self._marks, before, key=_time)]
