"""Lost steps of a motor, found on request in the grid points of its run.

    lag, steps   0 . . 1 . 2 . . 4 . . . 8 . . . 12 12 12
                           ^ out of step              ^ 12 steps lost

A rotor two steps (half an electrical turn) from its commanded position may turn either way.  Once it has
reached the next stable position it has lost four steps; steps are lost in fours, since stable positions
are four steps apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ..motors.law import LEVELS

if TYPE_CHECKING:
    from ..motors.law import MotorLaw
    from .motor_run import Run

BACK_PS = 20_000_000_000  # after this time in one position the rotor is in step again


class Losses:
    """The times at which a rotor was out of step, and the steps that it lost.

    Attributes:
        lost: full steps lost up to the last query; positive: the rotor lags.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.lost = 0
        self._done = run.stretches[0].first.t - 1  # the rotor may be held by hand in its first instant
        self._since: int | None = None  # the instant since which it has been out of step
        self._far: tuple[int, float] | None = None  # instant and speed halfway to the next stable position
        self._at_stop = False  # at a hard stop
        self._settled: tuple[int, int] | None = None  # its position, and since when it is there, while out of step
        self._last = self._done + 1, 0.0  # last grid point, and the lag there

    def look(self, ps: int) -> Iterator[tuple[int, str, str]]:
        """Yield the time (ps), code and text of each event up to an instant.

        The instant (ps) is at most the last committed one.
        """
        if ps <= self._done:
            return
        for law, columns, _ in self.run.between(self._done, ps):
            times, states, commands, codes = columns
            on = codes < len(law.table) // len(LEVELS) * LEVELS.index("off")  # without current nothing is followed
            lag = commands / law.micro - states[:, 0] / law.motor.step
            yield from self._along(law, times[on], lag[on], states[on, 1] / law.motor.step)
            yield from self._stops(law, times, states)
        self._done = ps
        law = self.run.stretch_at(ps).law
        if ps - self._last[0] > law.step_ps:
            yield from self._rested(law)
        elif self._settled is not None and ps - self._settled[0] >= BACK_PS:
            yield from self._back(self._settled[0] + BACK_PS)

    def _stops(self, law: MotorLaw, times: Any, states: Any) -> Iterator[tuple[int, str, str]]:
        """Yield an event for each arrival at a hard stop."""
        import numpy as np

        theta = states[:, law.names.index("theta2" if "theta2" in law.names else "theta")]
        at_stop = np.zeros(len(theta), bool)
        for stop in (law.load.low, law.load.high):
            if stop is not None:
                at_stop |= theta == stop
        for n in np.flatnonzero(at_stop & ~np.append(self._at_stop, at_stop[:-1])).tolist():
            yield int(times[n]), "hard-stop", f"the shaft hits a hard stop at {theta[n] / law.motor.step:g} steps"
        self._at_stop = bool(at_stop[-1])

    def _along(self, law: MotorLaw, times: Any, lag: Any, speed: Any) -> Iterator[tuple[int, str, str]]:
        """Process consecutive grid points; if two are more than one grid step apart, the rotor rested in between."""
        import numpy as np

        rests = np.flatnonzero(np.diff(times, prepend=self._last[0]) > law.step_ps).tolist()
        for begin, end in zip([0, *rests], [*rests, len(times)], strict=True):
            if begin in rests:
                yield from self._rested(law)
            if end > begin:
                yield from self._moving(law, times[begin:end], lag[begin:end], speed[begin:end])
                self._last = int(times[end - 1]), float(lag[end - 1])

    def _rested(self, law: MotorLaw) -> Iterator[tuple[int, str, str]]:
        """Record that the rotor came to rest at the last grid point; yield an event if it had been out of step."""
        if self._since is not None:
            ps, lag = self._last
            if self._settled is not None and ps - self._settled[0] >= BACK_PS:
                ps = self._settled[0] + BACK_PS
            else:
                self._settled = ps, round(lag / law.period) * law.period
            yield from self._back(ps)

    def _moving(self, law: MotorLaw, times: Any, lag: Any, speed: Any) -> Iterator[tuple[int, str, str]]:
        import numpy as np

        n, period = 0, law.period
        while n < len(times):
            if self._since is None:
                off = np.abs(lag[n:] - self.lost)
                gone = np.flatnonzero(off >= law.lost_at)
                before = off[: int(gone[0])] if len(gone) else off
                near = np.flatnonzero(before < period / 2)
                fell = n + int(near[-1]) + 1 if len(near) else n
                if len(near):
                    self._far = None
                if self._far is None and fell < len(times):
                    self._far = int(times[fell]), float(speed[fell])
                if not len(gone) or self._far is None:
                    return
                n += int(gone[0])
                self._since, rate = self._far
                self._far = None
                relation = "behind" if lag[n] > self.lost else "ahead of"
                text = f"at {abs(rate):.0f} steps/s the rotor is {period / 2:g} steps {relation} its command"
                yield self._since, "out-of-step", f"{text}: it loses steps"
            places = np.round(lag[n:] / period).astype(np.int64) * period
            inside = np.abs(lag[n:] - places) < period / 4
            while n < len(times):
                place = int(places[0]) if inside[0] else None
                if self._settled is None or place != self._settled[1]:
                    if self._settled is not None and int(times[n]) - self._settled[0] >= BACK_PS:
                        yield from self._back(self._settled[0] + BACK_PS)
                        break
                    self._settled = None if place is None else (int(times[n]), place)
                ends = np.flatnonzero((places != places[0]) | (inside != inside[0]))
                run = int(ends[0]) if len(ends) else len(places)
                n, places, inside = n + run, places[run:], inside[run:]

    def _back(self, ps: int) -> Iterator[tuple[int, str, str]]:
        """Record that the rotor is in step again, and yield this as an event."""
        if self._settled is not None:
            _, place = self._settled
            gone = place - self.lost
            self.lost, self._since, self._settled = place, None, None
            if gone:
                message = f"{abs(gone)} steps lost" if gone > 0 else f"{abs(gone)} steps too many"
            else:
                message = "no step lost"
            yield ps, "steps-lost", f"back in step: {message}"
