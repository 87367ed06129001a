"""Outputs derived from the counts of a shaft, as promises: an encoder channel, and a switch."""

from __future__ import annotations

from bisect import bisect_right
from functools import cached_property
from typing import Any

from ...core.time.events import NotYet, When, ask_at
from ...core.wires.wave import Level, real_edges
from .shaft_counter import Counter

LOOKS = 4  # changes that a channel checks before it returns NotYet


class LevelPattern:
    """A repeating pattern of output levels, one level per count."""

    def __init__(self, *levels: int) -> None:
        self.levels = levels

    def __getitem__(self, count: int) -> int:
        return self.levels[count % len(self.levels)]

    def distance(self, count: int, sign: int) -> int:
        """Return the distance from a count to the next count with another level, forward (1) or backwards (-1)."""
        size, at = len(self.levels), count % len(self.levels)
        turns = self._turns
        if sign > 0:
            n = bisect_right(turns, at)
            return (turns[n] if n < len(turns) else turns[0] + size) - at
        n = bisect_right(turns, at) - 1
        return at - (turns[n] if n >= 0 else turns[-1] - size) + 1

    @cached_property
    def _turns(self) -> list[int]:
        """The counts, within one repetition, whose level differs from the level of the preceding count."""
        return [n for n, level in enumerate(self.levels) if level != self.levels[n - 1]]

    @cached_property
    def array(self) -> Any:
        """The levels: (n,) int8."""
        import numpy as np

        return np.array(self.levels, np.int8)


class EncoderChannel:
    """An encoder output, as a promise: its level follows the count."""

    __slots__ = ("code", "counter")
    until: int | None = None  # the assumptions of a motion are valid until the shaft has a new motion

    def __init__(self, counter: Counter, code: LevelPattern) -> None:
        self.counter, self.code = counter, code

    def level(self, ps: int) -> int:
        """Return the level at an instant (ps), including edges at that instant."""
        return self.code[self.counter.level(ps)]

    def after(self, ps: int) -> When:
        """Return the instant (ps) of the next edge strictly after `ps`; NotYet if unknown; None if not foreseen.

        If the shaft turns too fast, every jump of the count may end at the same level, so that there is never an
        edge.
        """
        counter, code, time = self.counter, self.code, ps
        count = counter.level(ps)
        here = code[count]
        for _ in range(LOOKS + 1):
            changes = code.distance(count, counter.direction) if counter.direction and code[count] == here else 1
            following = ask_at(counter.after(time, changes))
            if following is None:
                return None
            count, time = counter.level(following), following
            if code[count] != here:
                return time
        return NotYet(time)

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges at start < t <= stop (ps): two lists, or two arrays (int64 ps, int8 levels)."""
        times, counts = self.counter.edges(start, stop)
        levels = self.code.levels
        level, size = self.level(start), len(levels)
        if isinstance(times, list):
            return real_edges(times, [levels[count % size] for count in counts], level)
        return real_edges(times, self.code.array[counts % size], level)


class SwitchZone:
    """A switch, as a promise: closed between two positions.

    Its state depends on the count, which is the number of bounds at or below the present position:

        count     0    1    2    3    4
        bounds      |    |    |    |
        state    open      closed------>open      moving forward
                 open<-----closed      open       moving backwards

    `zones` holds the state for each count.  For a count with None, the state remains as it was: this is the
    hysteresis.  `closed` is the state at `since`, when the counter began; `levels` holds the levels of the
    open and of the closed switch.
    """

    __slots__ = ("_known", "closed", "counter", "levels", "since", "zones")
    until: int | None = None

    def __init__(
        self, counter: Counter, since: int, closed: bool, zones: tuple[bool | None, ...], levels: tuple[Level, Level]
    ) -> None:
        self.counter, self.since, self.closed, self.zones, self.levels = counter, since, closed, zones, levels
        self._known = since, closed

    @property
    def floats(self) -> bool:
        """True if the switch sometimes releases the wire."""
        return None in self.levels

    def closed_at(self, ps: int) -> bool:
        """Return whether the switch is closed at an instant (ps)."""
        since, closed = self._known if ps >= self._known[0] else (self.since, self.closed)
        _, counts = self.counter.edges(since, max(ps, since))
        closed = self._after([self.counter.level(since), *counts], closed)
        if ps > since:
            self._known = ps, closed
        return closed

    def _after(self, counts: list[int], closed: bool) -> bool:
        return next((state for n in reversed(counts) if (state := self.zones[n]) is not None), closed)

    def level(self, ps: int) -> Level:
        """Return the level at an instant (ps), including edges at that instant."""
        return self.levels[self.closed_at(ps)]

    def after(self, ps: int) -> When:
        """Return NotYet with the instant of the next count change after an instant (ps); None if none is foreseen."""
        following = ask_at(self.counter.after(ps))
        return None if following is None else NotYet(following)

    def edges(self, start: int, stop: int) -> tuple[list[int], list[Level]]:
        """Return the edges at start < t <= stop (ps), as two lists."""
        closed = self.closed_at(start)
        times, counts = self.counter.edges(start, stop)
        levels = []
        for count in counts:
            state = self.zones[int(count)]
            closed = closed if state is None else state
            levels.append(self.levels[closed])
        return real_edges([int(time) for time in times], levels, self.level(start))
