"""The clock of a board as seen from its host: which tick it is now, from round trips alone.

A frame is taken by the board between the instant at which it was sent and that at which its answer came.  So each
round trip says between which bounds the board's time is, and all of them together say it better: the bounds are
intersected, after those of before have grown by as much as the two clocks may have drifted apart since.
"""

from __future__ import annotations

from collections import deque
from statistics import median

WIDEST_PPM = 6000.0  # a resonator, before its rate is known; 0.5 % and a reserve
DRIFT_PPM = 20.0  # how much a rate may change, by temperature
REMEMBERED = 64  # marks, one a second, over which the rate is measured
BETWEEN_MARKS = 1_000_000_000  # ns
ROUND_TRIPS = 64
WRAP = 2**32


class BoardClock:
    """Board ticks, which do not wrap here, and host nanoseconds.

    `known` is whether a round trip has been noted since the board's power-up.
    """

    def __init__(self, hz: int = 16_000_000) -> None:
        self.hz = hz
        self._rate = hz / 1e9  # ticks a nanosecond
        self._rate_doubt = WIDEST_PPM / 1e6
        self._marks: deque[tuple[int, int, float]] = deque(maxlen=REMEMBERED)  # host ns, tick, doubt in ticks
        self._trips: deque[int] = deque(maxlen=ROUND_TRIPS)
        self.worst_round_trip_ns = 0
        self._lives = 0  # ns of board time before this power-up
        self._told = 0  # ns of board time
        self._forget()

    def _forget(self) -> None:
        self.known = False
        self._host = self._tick = 0  # the reference: an instant, and the tick that it was, within a doubt
        self._doubt = 0.0
        self._newest = 0
        self._first = 0
        self._last = 0
        self._marks.clear()

    def restart(self) -> None:
        """The board began anew, and its ticks at 0; board time goes on from where it was."""
        self._lives = self._told
        self._forget()

    # -------------------------------------------------------------------------------------------------- what is noted
    def note(self, sent_ns: int, received_ns: int, tick: int) -> None:
        """Note that the board was at a tick (u32) not before the first instant and not after the second one."""
        self._trips.append(received_ns - sent_ns)
        self.worst_round_trip_ns = max(self.worst_round_trip_ns, received_ns - sent_ns)
        middle = (sent_ns + received_ns) // 2
        doubt = (received_ns - sent_ns) / 2 * self._rate + 1
        if not self.known:
            self.known = True
            self._host, self._tick, self._doubt = middle, tick, doubt
            self._newest = self._first = self._last = tick
            self._marks.append((middle, tick, doubt))
            return
        tick = self.unwrap(tick)
        self._newest = max(self._newest, tick)
        # both pairs of bounds at the later of the two instants
        now = max(middle, self._host)
        old, old_doubt = self._at(now), self._doubt + (now - self._host) * self._rate * self._rate_doubt
        new, new_doubt = tick + (now - middle) * self._rate, doubt + (now - middle) * self._rate * self._rate_doubt
        low, high = max(old - old_doubt, new - new_doubt), min(old + old_doubt, new + new_doubt)
        if low > high:  # the host's clock jumped, or the rate did: only the new one is sure
            low, high = new - new_doubt, new + new_doubt
            self._marks.clear()
            self._rate_doubt = WIDEST_PPM / 1e6
        self._host, self._tick, self._doubt = now, round((low + high) / 2), (high - low) / 2
        if not self._marks or now - self._marks[-1][0] >= BETWEEN_MARKS:
            self._marks.append((now, self._tick, self._doubt))
        self._measure_rate()

    def _measure_rate(self) -> None:
        """Take the rate from the two marks that leave least doubt, in case it is better than what is known."""
        host, tick, doubt = self._marks[0]
        elapsed = self._host - host
        if elapsed < BETWEEN_MARKS // 10:
            return
        rate = (self._tick - tick) / elapsed
        rate_doubt = (doubt + self._doubt) / (elapsed * rate) + DRIFT_PPM / 1e6 if rate > 0 else 1.0
        if rate_doubt <= self._rate_doubt or len(self._marks) == REMEMBERED:
            self._rate, self._rate_doubt = rate, min(rate_doubt, WIDEST_PPM / 1e6)

    def unwrap(self, tick: int) -> int:
        """Return the tick nearest to the newest one known that is the same modulo 2^32."""
        return tick + (self._newest - tick + WRAP // 2) // WRAP * WRAP

    # ------------------------------------------------------------------------------------------------- what it is now
    def _at(self, now_ns: int) -> int:
        return self._tick + round((now_ns - self._host) * self._rate)

    def ticks(self, now_ns: int) -> int:
        """Return the tick of the board at an instant of the host; never less than it was.  0 before it is known."""
        if self.known:
            self._last = max(self._last, self._at(now_ns))
        return self._last

    def at_ns(self, tick: int) -> int:
        """Return the instant of the host at which the board is at a tick."""
        return self._host + round((tick - self._tick) / self._rate)

    def nanoseconds(self, now_ns: int) -> int:
        """Return how long the board has run since it was first heard, in ns of its crystal; never less than it was.

        It stands while a board that began anew has not been heard.
        """
        if self.known:
            self._told = max(self._told, self._lives + (self.ticks(now_ns) - self._first) * 1_000_000_000 // self.hz)
        return self._told

    # ----------------------------------------------------------------------------------------------------- how good
    @property
    def doubt_ns(self) -> float:
        """How far the time may be off, at the last round trip, in ns; what is the same on all ways back is in it."""
        return self._doubt / self._rate

    @property
    def offset_ppm(self) -> float:
        """How much faster the board's crystal is than the host's clock, in millionths."""
        return (self._rate * 1e9 / self.hz - 1) * 1e6

    @property
    def round_trip_ns(self) -> tuple[int, int, int]:
        """The last round trip, the worst one of all, and the median of the last 64; zeros before there was one."""
        if not self._trips:
            return 0, 0, 0
        return self._trips[-1], self.worst_round_trip_ns, int(median(self._trips))
