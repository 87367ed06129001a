"""The pulses that a motor follows, found on request from the edges of its clock.

    pulse       |   |   |  | | | |  |   |   |        a pulse is followed if its rate, measured from the
    followed    1   2   3  4         5   6   7        preceding pulse, is at most `pull_in`, or at most
                                                      the rate reachable in one step from the
                                                      present rate

While every pulse is followed, the pulses are processed in arrays; after a lost pulse they are processed
one by one until a pulse is followed again.  The runs of followed pulses are kept, so that past steps can
be queried as well.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace
from math import sqrt
from typing import TYPE_CHECKING, Any

from ...core.time.events import Events, NotYet, When
from ...core.time.timebase import PS_PER_S
from ...core.wires.clocking import BLOCK, LOOKS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

FEW = 16  # pulses that are processed together at first, and after a lost pulse


@dataclass(frozen=True, slots=True)
class PulseFollowing:
    """State of a motor after its pulses so far."""

    pulses: int = 0
    lost: int = 0
    sign: int = 0  # direction of the last pulse
    rate: float = 0.0  # steps/s; 0: at rest
    pulsed_ps: int = -PS_PER_S  # the last pulse
    arrives_ps: int = 0  # when the last followed step is completed
    direction: int = 0  # and the sign of that step
    follows: bool = False  # whether the last pulse was followed


@dataclass(frozen=True)
class MotorLimits:
    """Limits of a motor: step duration, maximum rate from rest, and acceleration.

    `loses` are the numbers of the pulses that the motor misses in any case; the first pulse is number 1.
    """

    lag_ps: int
    pull_in: float
    acceleration: float
    loses: frozenset[int]

    @property
    def free(self) -> bool:
        """True if every pulse becomes a step, without delay."""
        return not (self.lag_ps or self.pull_in or self.loses)

    def shortest_ps(self, rate: float) -> int:
        """Return the shortest interval (ps) to the next pulse that a motor at a given rate (steps/s) can follow."""
        if not self.pull_in:
            return 0
        return int(PS_PER_S / max(self.pull_in, sqrt(rate * rate + 2 * self.acceleration)))

    def after(self, of: PulseFollowing, ps: int, sign: int) -> PulseFollowing:
        """Return the state after a pulse at an instant (ps) in the direction `sign`; `of` is the state before it."""
        pulses, interval = of.pulses + 1, ps - of.pulsed_ps
        rate = of.rate if sign == of.sign else 0.0
        follows = ps >= of.arrives_ps and pulses not in self.loses and interval >= self.shortest_ps(rate)
        return PulseFollowing(
            pulses,
            of.lost + (not follows),
            sign,
            PS_PER_S / interval if follows and interval else 0.0,
            ps,
            ps + self.lag_ps if follows else of.arrives_ps,
            sign if follows else of.direction,
            follows,
        )

    def followed(self, of: PulseFollowing, times: NDArray[np.int64]) -> int:
        """Return the number of pulses that are followed before the first lost one.

        The caller must know that the first pulse is followed, so the result is 1 or more.  `times` are the
        instants of the pulses: (n,) int64 ps, n >= 1.
        """
        import numpy as np

        intervals = np.diff(times)
        good = intervals >= self.lag_ps
        if self.pull_in:
            first = (PS_PER_S / (int(times[0]) - of.pulsed_ps),)
            rates = np.concatenate((first, PS_PER_S / intervals[:-1])) if len(intervals) else np.empty(0)
            reached = np.maximum(self.pull_in, np.sqrt(rates * rates + 2 * self.acceleration))
            good &= intervals >= (PS_PER_S / reached).astype(np.int64)
        missed = [n - of.pulses - 1 for n in self.loses if of.pulses + 1 < n <= of.pulses + len(times)]
        good[[n - 1 for n in missed]] = False
        return len(times) if good.all() else int(np.argmin(good)) + 1


class FollowedSteps(Events):
    """Clock edges that become steps: the instants of the pulses that a motor follows.

    `_firsts` and `_lasts` are the numbers, from 1, of the first and last pulse of each run of followed
    pulses; `_before` is the number of steps before each run.
    """

    def __init__(self, clock: Events, limits: MotorLimits, of: PulseFollowing, sign: int) -> None:
        self.clock, self.limits, self.of, self.sign = clock, limits, of, sign
        self._known, self._state = 0, of  # processed pulses, and the state after them
        self._firsts: list[int] = []
        self._lasts: list[int] = []
        self._before: list[int] = []
        self._many = FEW

    def _made(self, n: int) -> int:
        """Return the number of followed pulses among the first n, all of which have been processed."""
        i = bisect_right(self._firsts, n) - 1
        return 0 if i < 0 else self._before[i] + min(n, self._lasts[i]) - self._firsts[i] + 1

    def _work(self, n: int) -> None:
        """Process the pulses up to and including pulse n, counted from 1."""
        while self._known < n:
            last = min(n, self._known + BLOCK)
            times: Any = [self.clock.time(last)] if last == self._known + 1 else self.clock.times(self._known + 1, last)
            done = 0
            while done < len(times):
                done += self._work_some(times[done : done + self._many])

    def _work_some(self, times: Any) -> int:
        """Process the first pulse if it is lost, else the run of followed pulses; return the number processed."""
        state = self.limits.after(self._state, int(times[0]), self.sign)
        if not state.follows:
            self._state, self._known, self._many = state, self._known + 1, FEW
            return 1
        run = 1 if len(times) == 1 else self.limits.followed(self._state, times)
        self._many = min(self._many * 4, BLOCK) if run == len(times) else FEW
        self._follow(run)
        if run > 1:
            now, before = int(times[run - 1]), int(times[run - 2])
            state = replace(
                state, pulses=state.pulses + run - 1, rate=PS_PER_S / (now - before), pulsed_ps=now,
                arrives_ps=now + self.limits.lag_ps,
            )  # fmt: skip
        self._state = state
        return run

    def _follow(self, run: int) -> None:
        """Record the next `run` pulses as followed."""
        if self._lasts and self._lasts[-1] == self._known:
            self._lasts[-1] += run
        else:
            self._before.append(self._made(self._known))
            self._firsts.append(self._known + 1)
            self._lasts.append(self._known + run)
        self._known += run

    def _pulse(self, k: int) -> int:
        """Return the number of the pulse that causes step k; both are counted from 1."""
        i = bisect_right(self._before, k - 1) - 1
        return self._firsts[i] + k - 1 - self._before[i]

    # ---------------------------------------------------------------------------------------------- the steps made
    def count(self, ps: int) -> int:
        """Return the number of steps made by an instant (ps), including a step at that instant."""
        n = self.clock.count(ps)
        self._work(n)
        return self._made(n)

    def time(self, k: int) -> When:
        """Return the instant (ps) of step k; NotYet if it is not found yet; None if no such step is foreseen."""
        following: When = None
        for _ in range(LOOKS):
            if k <= self._made(self._known):
                break
            following = self.clock.time(self._known + 1)
            if not isinstance(following, int):
                return following
            self._work(self._known + 1)
        if k <= self._made(self._known):
            return self.clock.time(self._pulse(k))
        return NotYet(following) if isinstance(following, int) else None

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of steps first ... last, which must all occur: (n,) int64 ps, ascending."""
        import numpy as np

        if last < first:
            return np.empty(0, np.int64)
        k = np.arange(first, last + 1)
        i = np.searchsorted(np.array(self._before, np.int64), k - 1, side="right") - 1
        pulses = np.array(self._firsts, np.int64)[i] + k - 1 - np.array(self._before, np.int64)[i]
        times: NDArray[np.int64] = self.clock.times(int(pulses[0]), int(pulses[-1]))[pulses - pulses[0]]
        return times

    def onward(self, ps: int) -> PulseFollowing:
        """Return the state of the motor at an instant (ps), after any pulse at that instant."""
        n = self.clock.count(ps)
        self._work(n)
        if n == self._known:
            return self._state
        if n == 0:
            return self.of
        made = self._made(n)
        times = self.clock.times(max(n - 1, 1), n)
        last, before = int(times[-1]), int(times[0]) if n > 1 else self.of.pulsed_ps
        follows = made > self._made(n - 1)
        arrives, direction = self.of.arrives_ps, self.of.direction
        if made:
            pulse = self._pulse(made)
            arrives, direction = int(self.clock.times(pulse, pulse)[0]) + self.limits.lag_ps, self.sign
        return PulseFollowing(
            self.of.pulses + n, self.of.lost + n - made, self.sign, PS_PER_S / (last - before) if follows else 0.0,
            last, arrives, direction, follows,
        )  # fmt: skip
