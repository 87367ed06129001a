"""The bytes of a command over a two-line handshake, and the waveforms of its wires (handshake.py has their picture)."""

from __future__ import annotations

from typing import NamedTuple

from ..time.timebase import Clock
from .wave import Level, Wave


class ByteTimes(NamedTuple):
    """The edge times of a byte, in clock ticks after the request for the byte.

    Attributes:
        strobe: INSTROBE falls.
        sample: INSTROBE rises, and the bus is read.
        busy: READY falls.
        kept: READY returns high, after a byte that is only stored.
    """

    strobe: int
    sample: int
    busy: int
    kept: int


def alternating(first: list[int], second: list[int]) -> tuple[int, ...]:
    """Return the elements of two lists of equal length alternately."""
    both = first + second
    both[::2], both[1::2] = first, second
    return tuple(both)


class HandshakenBytes:
    """Consecutive bytes, each with its handshake; the bytes are numbered from 0.

    Attributes:
        start: the instant of the first request, ps.
        tick: the clock tick at which the chip detects the first request.
        before: the host's level on the bus before the first byte.
        released: True if the host releases the bus when the last byte is accepted.
        opened: the instant (ps) at which READY returns high after the last byte; None if not known yet.
    """

    __slots__ = ("_request", "before", "clock", "data", "last", "opened", "released", "start", "tick", "times")

    def __init__(self, data: bytes, start: int, before: Level, released: bool, times: ByteTimes, clock: Clock) -> None:
        self.data, self.start, self.before, self.released, self.times, self.clock = (
            data, start, before, released, times, clock,
        )  # fmt: skip
        self.tick = clock.ticks_from(start)
        self.last = clock.ps(self.tick + (len(data) - 1) * times.kept + times.busy)  # READY falls for the last byte
        self.opened: int | None = None
        self._request: Wave | None = None

    def instant(self, number: int, clocks: int) -> int:
        """Return the instant (ps) that is `clocks` clock ticks after the request of a byte."""
        return self.clock.ps(self.tick + number * self.times.kept + clocks)

    def passed(self, ps: int, clocks: int) -> int:
        """Return the number of bytes whose requests were made at least `clocks` clock ticks before an instant (ps)."""
        number = (self.clock.ticks_until(ps) - self.tick - clocks) // self.times.kept + 1
        return max(min(number, len(self.data)), 0)

    def current(self, ps: int) -> int:
        """Return the number, counted from 0, of the byte that is in progress at an instant (ps)."""
        return min(self.passed(ps, self.times.kept), len(self.data) - 1)

    def latest_edge(self, ps: int) -> int:
        """Return the instant (ps) of the last I/O REQUEST edge at or before `ps`, or of the first if all are later."""
        number = self.current(ps)
        risen = self.instant(number, self.times.busy)
        return risen if risen <= ps else self.request_of(number)

    def _instants(self, clocks: int) -> list[int]:
        """Return `instant(number, clocks)` for all bytes."""
        first, kept, n, d = self.tick + clocks, self.times.kept, self.clock.n, self.clock.d
        return [tick * n // d for tick in range(first, first + len(self.data) * kept, kept)]

    @property
    def _requests(self) -> list[int]:
        return [self.start, *self._instants(0)[1:]]

    def request_of(self, number: int) -> int:
        """Return the instant (ps) at which I/O REQUEST falls for a byte."""
        return self.instant(number, 0) if number else self.start

    @property
    def on_bus(self) -> Level:
        """The level that the host drives on the bus after the last byte; None if it releases the bus."""
        return None if self.released else (0xFF, self.data[-1])

    def request(self) -> Wave:
        """Return the waveform of I/O REQUEST."""
        if self._request is None:  # the chip reads it several times in a motion
            edges = alternating(self._requests, self._instants(self.times.busy))
            self._request = Wave(1, edges, (0, 1) * len(self.data))
        return self._request

    def bus(self) -> Wave:
        """Return the waveform of the host's output on the bus."""
        levels: tuple[Level, ...] = tuple((0xFF, byte) for byte in self.data)
        if not self.released:
            return Wave(self.before, tuple(self._requests), levels)
        return Wave(self.before, (*self._requests, self.last), (*levels, None))

    def strobe(self, active: int) -> Wave:
        """Return the waveform of INSTROBE, given the active level of INSTROBE."""
        times = alternating(self._instants(self.times.strobe), self._instants(self.times.sample))
        return Wave(1 - active, times, (active, 1 - active) * len(self.data))

    def ready(self) -> Wave:
        """Return the waveform of READY."""
        between = alternating(self._instants(self.times.busy)[:-1], self._requests[1:])
        times = (*between, self.last) if self.opened is None else (*between, self.last, self.opened)
        return Wave(1, times, ((0, 1) * len(self.data))[: len(times)])
