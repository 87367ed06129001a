"""The clock of a board as seen by its host: an estimate of its present tick, from round trips alone.

The board takes a frame at some instant between the transmission of the frame and the arrival of its
answer.  Plotted against host time, the ticks form a line, and the tick in each answer gives two bounds
on it: an upper bound at the transmission, and a lower bound at the arrival.  The tightest bounds of each
second are kept for a minute or two.  The rate is the middle of the rates that satisfy all bounds, and
the line is the middle of the lines with this rate.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from statistics import median

import numpy as np

WIDEST_PPM = 6000  # a resonator, before its rate is known: 0.5 % and a reserve
KEPT = 128  # bounds
EACH, EACH_AT_FIRST = 1_000_000_000, 100_000_000  # least distance of bounds, ns
SOON = 6_000_000_000  # ns; before that they are closer, and the rate is computed at each round trip
ROUND_TRIPS = 64
WRAP = 2**32
JUMP_S = 1.0  # a board is never further off, except for the crystal error since the last round trip


@dataclass(slots=True)
class TickBounds:
    """The tightest upper bound and the tightest lower bound on the board's tick, within a period of time.

    The period begins at `start`.  The tick is at most `above` at the time `early`, and at least `below` at
    the time `late`.  `start`, `early` and `late` are host times in ns.
    """

    start: int
    early: int
    above: int
    late: int
    below: int


def _nearest(tick: int, other: int) -> int:
    """Return the tick nearest to `other` that equals `tick` modulo 2^32."""
    return tick + (other - tick + WRAP // 2) // WRAP * WRAP


class BoardClock:
    """The relation between board ticks, which do not wrap here, and host nanoseconds.

    Attributes:
        known: True if a round trip has been recorded since the board's power-up.
        jumps: the number of impossible board times.  They occur after a sleep of the host computer, for
            example, because the host's clock then stops, and the board's does not.
    """

    def __init__(self, hz: int = 16_000_000) -> None:
        self.hz = hz
        self._nominal = self._rate = hz / 1e9  # ticks per nanosecond
        self._bounds: deque[TickBounds] = deque(maxlen=KEPT)
        self._trips: deque[int] = deque(maxlen=ROUND_TRIPS)
        self.worst_round_trip_ns = 0
        self.jumps = 0
        self._noted_ns = 0  # the last round trip
        self._lives = 0  # ns of board time before this power-up
        self._board_ns = 0  # ns of board time
        self._forget()

    def _forget(self) -> None:
        self.known = False
        self._bounds.clear()
        self._origin = 0  # origin of the line: an instant of the host, its tick, and the uncertainty
        self._tick = self._doubt = 0.0
        self._newest = self._first = self._last = 0

    def restart(self) -> None:
        """Handle a restart of the board: its ticks restart at 0, while board time continues."""
        self._lives = self._board_ns
        self._forget()

    # ------------------------------------------------------------------------------------------------ recorded bounds
    def note(self, sent_ns: int, received_ns: int, tick: int) -> None:
        """Record that the board was at a tick (u32) at some instant between transmission and arrival (host ns)."""
        self._trips.append(received_ns - sent_ns)
        self.worst_round_trip_ns = max(self.worst_round_trip_ns, received_ns - sent_ns)
        if self.known:
            expected = self._at((sent_ns + received_ns) // 2)
            unwrapped = _nearest(tick, expected)  # the silence may have been long
            apart = JUMP_S + (received_ns - sent_ns + (received_ns - self._noted_ns) * WIDEST_PPM / 1e6) / 1e9
            if abs(unwrapped - expected) > apart * self.hz:
                self.jumps += 1
                self.restart()
            else:
                tick = unwrapped
        if self.known:
            self._newest = max(self._newest, tick)
        else:
            self.known = True
            self._newest = self._first = self._last = tick
            self._origin = sent_ns
        self._noted_ns = received_ns
        self._keep(sent_ns, received_ns, tick)
        while not self._drawn() and len(self._bounds) > 1:
            # the rate changed, or the clock of the host jumped: older bounds are useless
            for _ in range((len(self._bounds) + 1) // 2):
                self._bounds.popleft()
        if self._doubt < 0:
            self._bounds[0] = TickBounds(received_ns, sent_ns, tick, received_ns, tick)
            self._drawn()

    def _keep(self, sent: int, received: int, tick: int) -> None:
        last = self._bounds[-1] if self._bounds else None
        each = EACH_AT_FIRST if last and last.start - self._bounds[0].start < SOON else EACH
        if last is None or received - last.start >= each:
            self._bounds.append(TickBounds(received, sent, tick, received, tick))
            return
        if tick - last.above < (sent - last.early) * self._rate:
            last.early, last.above = sent, tick
        if tick - last.below > (received - last.late) * self._rate:
            last.late, last.below = received, tick

    def _drawn(self) -> bool:
        """Calculate the line of ticks against host time; return whether any line satisfies all bounds."""
        rows = np.array([(each.early, each.above, each.late, each.below) for each in self._bounds], dtype=np.int64)
        early, above, late, below = rows.T
        early, late = early.astype(np.float64) - self._origin, late.astype(np.float64) - self._origin
        above, below = above - self._first, below - self._first
        newest = self._bounds[-1]
        if newest.start - self._bounds[0].start < SOON or newest.late == newest.start:
            apart = late[None, :] - early[:, None]
            risen = below[None, :] - above[:, None]
            with np.errstate(divide="ignore", invalid="ignore"):
                rates = risen / apart
            doubt = self._nominal * WIDEST_PPM / 1e6
            low = max(self._nominal - doubt, rates[apart > 0].max(initial=-np.inf))
            high = min(self._nominal + doubt, rates[apart < 0].min(initial=np.inf))
            self._rate = float(low + high) / 2
        top, bottom = float((above - self._rate * early).min()), float((below - self._rate * late).max())
        self._tick, self._doubt = self._first + (top + bottom) / 2, (top - bottom) / 2
        return self._doubt >= 0

    def unwrap(self, tick: int) -> int:
        """Return the tick that equals `tick` modulo 2^32 and is nearest to the latest known tick."""
        return _nearest(tick, self._newest)

    # --------------------------------------------------------------------------------------------------- present time
    def _at(self, now_ns: int) -> int:
        return round(self._tick + (now_ns - self._origin) * self._rate)

    def ticks(self, now_ns: int) -> int:
        """Return the board tick at an instant of host time (ns); it never decreases, and is 0 while unknown."""
        if self.known:
            self._last = max(self._last, self._at(now_ns))
        return self._last

    def at_ns(self, tick: int) -> int:
        """Return the instant of host time (ns) at which the board is at a tick."""
        return self._origin + round((tick - self._tick) / self._rate)

    def nanoseconds(self, now_ns: int) -> int:
        """Return the board time at a host time (ns): ns of its crystal since the first message from the board.

        It never decreases.  After a restart of the board, it stops until the board has answered.
        """
        if self.known:
            self._board_ns = max(
                self._board_ns, self._lives + (self.ticks(now_ns) - self._first) * 1_000_000_000 // self.hz
            )
        return self._board_ns

    # ----------------------------------------------------------------------------------------------------- accuracy
    @property
    def doubt_ns(self) -> float:
        """The uncertainty of the tick at the last round trip, in ns; it includes any constant delay of the answers."""
        return self._doubt / self._rate

    @property
    def offset_ppm(self) -> float:
        """The deviation of the board's crystal from the host's clock, in ppm; positive if the crystal is faster."""
        return (self._rate * 1e9 / self.hz - 1) * 1e6

    @property
    def round_trip_ns(self) -> tuple[int, int, int]:
        """The round-trip times, ns: the last, the worst, and the median of the last 64; zeros before the first."""
        if not self._trips:
            return 0, 0, 0
        return self._trips[-1], self.worst_round_trip_ns, int(median(self._trips))
