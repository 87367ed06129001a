"""The progress of virtual time in a server: with the wall clock, or in lockstep with the clients.

    paced       virtual time follows the wall clock:
                virtual = virtual at the start + rate * (wall - wall at the start).
                Whenever the loop wakes, the bench runs up to the present instant; then the loop sleeps
                until the instant of the next event.  A bench that falls behind catches up; one that
                falls behind by more than a second (a machine that was asleep, a rate that is too high)
                skips its lag, which is reported.

    lockstep    virtual time runs only while a wait needs it: until the bytes on a line have been
                sent and answered, or during an `advance` or an `until`.  An endless motion advances
                only during waits.

A pause stops time in both modes.  During a pause, time runs only for a wait whose `pushes` is True, such
as the wait for the end of a single step.  In both modes, time runs in slices of a few wall-clock
milliseconds, so that clients are served in between.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from operator import attrgetter
from time import perf_counter_ns
from typing import TYPE_CHECKING

from ...bench.runner import Wait
from ...errors import UsageError
from ...parts.lines.host_uart import POWER_UP_PS

if TYPE_CHECKING:
    from ...bench import Bench
    from ...bench.runner import Runner

PS_PER_NS = 1000
NS_PER_S = 10**9
SLICE_NS = 20_000_000
LATE_NS = 1_000_000  # an event later than this counts as late
LOST_NS = NS_PER_S  # a longer lag is skipped
_limit = attrgetter("limit_ps")


@dataclass
class Lag:
    """The delays of events: how much later than due, by the wall clock, they come.

    `events` counts all events, and `late` the ones that came more than 1 ms late.  `worst_ns` is the longest
    delay, and `lost_ns` the time skipped.
    """

    events: int = 0
    late: int = 0
    worst_ns: int = 0
    lost_ns: int = 0

    def note(self, late_ns: int) -> None:
        """Count an event that was due `late_ns` of wall-clock time ago."""
        self.events += 1
        self.late += late_ns > LATE_NS
        self.worst_ns = max(self.worst_ns, late_ns)


class Pace:
    """The common base of `Paced` and `Lockstep`; `goal` limits the progress of time.

    Args:
        clock: returns the wall-clock time in nanoseconds.
    """

    lockstep = False

    def __init__(self, bench: Bench | Runner, clock: Callable[[], int] = perf_counter_ns) -> None:
        self.bench, self.kernel, self.clock = bench, bench.kernel, clock
        self.waits: list[Wait] = []
        self.stop_ns = 0
        self.lag = Lag()
        self.paused = False

    def move(self, bench: Bench) -> None:
        """Switch to another bench, which is at the same instant."""
        self.bench, self.kernel = bench, bench.kernel

    def start(self) -> None:
        """Start serving: power up the chips before a client can reach them."""
        self.kernel.run(self.kernel.now + POWER_UP_PS)

    def pause_time(self) -> None:
        """Stop virtual time at the present instant, until `go`."""
        self.paused = True

    def go(self) -> None:
        """Let virtual time run again, after `pause_time`."""
        self.paused = False

    def goal(self) -> int:
        """Return the latest instant (ps) that time may reach now."""
        return self._pushed() if self.paused else self._goal()

    def _goal(self) -> int:
        """Return the goal that would apply without a pause (ps)."""
        raise NotImplementedError

    def _pushed(self) -> int:
        """Return the latest instant (ps) that time may reach during a pause.

        This is the latest time limit of the waits whose `pushes` is True; if there are none, the current instant.
        """
        return max((wait.limit_ps for wait in self.waits if wait.pushes), default=self.kernel.now)

    def pause(self) -> float | None:
        """Return the number of seconds that the loop may sleep once the goal is reached; None for no limit.

        Without a limit, the loop sleeps until a byte arrives.
        """
        raise NotImplementedError

    def present(self) -> None:
        """Bring the bench to the present instant of the wall clock, for an external input; in lockstep, do nothing."""

    def wait(self, wait: Wait) -> None:
        """Begin a wait; from now on, check whether it is met or has timed out."""
        wait.begin()
        self.waits.append(wait)

    def forget(self, wait: Wait) -> None:
        """Remove a wait, whether met or not."""
        if wait in self.waits:
            self.waits.remove(wait)
            wait.end()

    def pass_time(self) -> bool:
        """Run time up to the goal, for at most one slice; return whether the goal has been reached."""
        self.stop_ns = self.clock() + SLICE_NS
        kernel = self.kernel
        kernel.settle()
        while True:
            whole = self.goal()
            goal = self._bounded(whole) if self.waits else whole
            if kernel.run_while(self._enough, goal):
                kernel.run(goal)
            self._answer()
            if kernel.now >= whole or kernel.now >= self.goal():
                return True
            if self.clock() >= self.stop_ns:
                return False

    def _enough(self) -> bool:
        for wait in self.waits:
            if wait.met():
                return True
        return self.clock() >= self.stop_ns

    def _bounded(self, goal: int) -> int:
        """Return the goal (ps), or an earlier instant at which a wait must be checked.

        Each wait must be checked at its time limit.  A wait that can predict when it is met must also be checked
        at the predicted instant, and at the next event, which may change the prediction.
        """
        for wait in self.waits:
            goal = min(goal, max(wait.limit_ps, self.kernel.now))
            if wait.when is not None:
                times = (wait.when(), self.kernel.next_time())
                goal = min([goal, *(max(time, self.kernel.now) for time in times if time is not None)])
        return goal

    def _answer(self) -> None:
        """End the waits that are met or have timed out, and call their `done`."""
        for wait in list(self.waits):
            met = wait.met()
            if met or wait.limit_ps <= self.kernel.now:
                self.forget(wait)
                wait.done(met)


def rate_of(rate: str | float) -> Fraction:
    """Return a rate as a fraction, in virtual seconds per wall-clock second.

    Raises:
        UsageError: the rate is not a number above 0.
    """
    try:
        found = Fraction(str(rate))
    except (ValueError, ZeroDivisionError):
        found = Fraction(0)
    if found <= 0:
        raise UsageError(f"rate {rate!r}; expected virtual seconds per second of the wall clock, such as 1 or 0.1")
    return found


class Paced(Pace):
    """Virtual time that follows the wall clock.

    Args:
        rate: virtual seconds per wall-clock second, such as 1 or "0.1".
    """

    def __init__(self, bench: Bench, rate: str | float = 1, clock: Callable[[], int] = perf_counter_ns) -> None:
        super().__init__(bench, clock)
        self.rate = rate_of(rate)
        self.origin_ps = self.origin_ns = 0

    def start(self) -> None:
        """Start serving: power up the chips, then let virtual time follow the wall clock from this instant."""
        super().start()
        self._begin()

    def _begin(self) -> None:
        """Make the present instant of virtual time correspond to the present instant of the wall clock."""
        self.origin_ps, self.origin_ns = self.kernel.now, self.clock()

    def go(self, rate: str | float | None = None) -> None:
        """Let time follow the wall clock, starting at this instant; without `rate`, at the same rate as before."""
        self.rate = self.rate if rate is None else rate_of(rate)
        self._begin()
        super().go()

    def _goal(self) -> int:
        """Return the virtual instant that corresponds to the present instant of the wall clock (ps)."""
        passed, (virtual, wall) = self.clock() - self.origin_ns, self.rate.as_integer_ratio()
        return self.origin_ps + passed * PS_PER_NS * virtual // wall

    def nanoseconds(self, ps: int) -> int:
        """Return the wall-clock duration in ns that corresponds to a virtual duration in ps, rounded up."""
        virtual, wall = self.rate.as_integer_ratio()
        return -(-ps * wall // (PS_PER_NS * virtual))

    def pass_time(self) -> bool:
        """Run time up to the goal set by the wall clock, for at most one slice; return whether it has been reached."""
        due = self.kernel.next_time()
        if due is not None and not self.paused and due <= (goal := self.goal()):
            lag_ns = self.nanoseconds(goal - due)
            self.lag.note(lag_ns)
            if lag_ns > LOST_NS:
                self.lag.lost_ns += lag_ns
                self.origin_ns += lag_ns
        return super().pass_time()

    def present(self) -> None:
        """Run time up to the wall clock's present instant, for at most one slice, before an external input."""
        self.pass_time()

    def pause(self) -> float | None:
        """Return the wall-clock seconds until the next event or end of a wait; None to sleep until a byte arrives."""
        self.kernel.settle()
        if self.paused:
            return 0 if self.goal() > self.kernel.now else None
        times: list[int | None] = [self.kernel.next_time()]
        for wait in self.waits:
            times += [wait.limit_ps, wait.when() if wait.when is not None else None]
        ahead = [time for time in times if time is not None]
        if not ahead:
            return None
        at = self.origin_ns + self.nanoseconds(min(ahead) - self.origin_ps)
        return max(at - self.clock(), 0) / NS_PER_S


class Lockstep(Pace):
    """Virtual time that passes only while a wait needs it."""

    lockstep = True

    def _goal(self) -> int:
        """Return the latest limit of the waits (ps), where time must stop; without waits, the current instant."""
        return max(map(_limit, self.waits), default=self.kernel.now)

    def pause(self) -> float | None:
        """Return None: the loop may sleep until a byte arrives, because only requests of clients let time run."""
        return None
