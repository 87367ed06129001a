"""The steps that a motor loses: found in the points of its run, on request.

    lag, steps   0 . . 1 . 2 . . 4 . . . 8 . . . 12 12 12
                           ^ out of step              ^ 12 steps lost

A rotor two steps (half an electrical turn) from the place of its command may go either way.  Once it has come to the
next place that attracts it, it has lost four steps; they come in fours, since it settles nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..motors.law import Law
    from .run import Run

NEXT = 0.1  # steps from the next place, where a step is lost
BACK_PS = 20_000_000_000  # so long in one place, and the rotor is in step again


class Losses:
    """Where a rotor has fallen out of step, and what it has lost.

    Attributes:
        lost: full steps up to the last question, more than 0: the rotor is behind.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.lost = 0
        self._done = run.stretches[0].first.t
        self._since: int | None = None  # it has been out of step from this instant on
        self._last: tuple[int, float, int] | None = None  # the last point: instant, lag, steps from place to place
        self._away: tuple[int, float] | None = None  # since when, and how fast then, it has been half of them off
        self._held = False  # at a hard stop
        self._settled: tuple[int, int] | None = None  # where it has been since when, while it is out of step

    def look(self, ps: int) -> Iterator[tuple[int, str, str]]:
        """Yield what has happened up to an instant (ps), the last committed one at most: when, code and text."""
        import numpy as np

        if ps <= self._done:
            return
        for law, columns in self.run.between(self._done, ps):
            period = law.period
            times, states, commands, _ = columns
            lag = commands / law.micro - states[:, 0] / law.motor.step
            speed = states[:, 1] / law.motor.step
            # It rests where points are farther apart than the grid, whether somebody has asked there or not.
            if self._last is not None and times[0] - self._last[0] > law.step_ps:
                yield from self._rests(*self._last)
            ends = [*(np.flatnonzero(np.diff(times) > law.step_ps) + 1).tolist(), len(times)]
            for begin, end in zip([0, *ends], ends, strict=False):
                part = slice(begin, end)
                yield from self._along(period, times[part], lag[part], speed[part])
                self._last = int(times[end - 1]), float(lag[end - 1]), period
                if end < len(times):
                    yield from self._rests(*self._last)
            yield from self._stops(law, times, states[:, 0])
        self._done = ps
        if self._last is not None and self.run.rests(ps):
            yield from self._rests(*self._last)
        elif self._settled is not None and ps - self._settled[0] >= BACK_PS:
            yield from self._back(self._settled[0] + BACK_PS)

    def _stops(self, law: Law, times: Any, theta: Any) -> Iterator[tuple[int, str, str]]:
        """Where it has come to a hard stop."""
        import numpy as np

        low, high = law.load.low, law.load.high
        held = np.zeros(len(theta), bool)
        for stop in (low, high):
            if stop is not None:
                held |= theta == stop
        for n in np.flatnonzero(held & ~np.append(self._held, held[:-1])).tolist():
            yield int(times[n]), "hard-stop", f"the shaft runs into a stop at {theta[n] / law.motor.step:g} steps"
        self._held = bool(held[-1])

    def _along(self, period: int, times: Any, lag: Any, speed: Any) -> Iterator[tuple[int, str, str]]:
        import numpy as np

        n = 0
        while n < len(times):
            if self._since is None:
                off = np.abs(lag[n:] - self.lost)
                gone = np.flatnonzero(off >= period - NEXT)
                near = np.flatnonzero(off[: int(gone[0]) if len(gone) else len(off)] < period / 2)
                fell = n + (int(near[-1]) + 1 if len(near) else 0)
                if len(near) or self._away is None:
                    self._away = (int(times[fell]), float(speed[fell])) if fell < len(times) else None
                if not len(gone) or self._away is None:
                    return
                first = n + int(gone[0])
                self._since, rate = self._away
                way = "behind" if lag[first] > self.lost else "ahead of"
                text = f"at {abs(rate):.0f} steps/s the rotor is {period // 2} steps {way} its command"
                yield self._since, "out-of-step", f"{text}: it loses steps"
                n = first
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

    def _rests(self, ps: int, lag: float, period: int) -> Iterator[tuple[int, str, str]]:
        """It rests from an instant on."""
        if self._since is not None:
            self._settled = ps, round(lag / period) * period
            yield from self._back(ps)

    def _back(self, ps: int) -> Iterator[tuple[int, str, str]]:
        """It is in step again."""
        if self._settled is not None:
            _, place = self._settled
            gone = place - self.lost
            self.lost, self._since, self._settled, self._away = place, None, None, None
            if gone:
                says = f"{abs(gone)} steps lost" if gone > 0 else f"{abs(gone)} steps too many"
            else:
                says = "no step lost"
            yield ps, "steps-lost", f"in step again: {says}"
