"""The shaft of a motor that is integrated, and how it turns: what sits on a shaft sits on this one unchanged."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

from ...core.motion.history import Polyline
from ...core.wires.clocking import ClockEdges
from ...errors import UsageError
from ..shafts.shaft import Place, Shaft
from .passing import Passings, RunCounter, Track

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from ...core.time.kernel import Kernel
    from ..shafts.counter import Counter, CountScale
    from .run import Run

FINEST = Fraction(1, 1 << 20)  # step, of places that are told as fractions
ROTOR = Track()
HALF = 0.5  # count, by which an encoder is turned: at rest the rotor is not where it counts


@dataclass(frozen=True)
class TrackMotion:
    """The motion of a shaft that a rotor turns: for the rest of a run, whatever comes.

    It has the interface of a `ShaftMotion` (`parts/shafts/shaft_motion.py`).
    """

    run: Run
    track: Track = ROTOR

    @property
    def since(self) -> int:
        """The instant from which on it holds (ps)."""
        return self.run.stretches[0].first.t

    def steps_at(self, ps: int) -> Fraction:
        """Return the place at an instant (ps), in steps, to a millionth."""
        return round(Fraction(self.place(ps)) / FINEST) * FINEST

    def place(self, ps: int) -> float:
        """Return the place at an instant (ps), in steps."""
        return places_of(self.run, self.track).place(ps)

    def places(self, times: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the places at instants (int64 ps), in steps: (n,) float64."""
        import numpy as np

        return np.array([self.place(int(ps)) for ps in times])

    def changes(self, start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the grid points at start < t <= stop: (n,) int64 ps, and the places there, (n,) float64 steps."""
        import numpy as np

        found = [columns for _, columns in self.run.between(start, stop)]
        times = np.concatenate([np.empty(0, np.int64), *(columns[0] for columns in found)])
        angles = np.concatenate([np.empty(0), *(columns[1][:, 0] for columns in found)])
        return times, places_of(self.run, self.track).along(times, angles)

    def counter(self, scale: CountScale, lag_ps: int) -> Counter:
        """Return what passes on a scale, `lag_ps` later."""
        return RunCounter(passings_of(self.run, self.track, scale, HALF if scale.per_step else 0.0), scale, lag_ps)

    def lost(self, ps: int) -> int:
        """Return 0: what a rotor loses, its part finds."""
        return 0

    def moved(self, k: int) -> int:
        """Return 0: it has no edges."""
        return 0

    def edges(self, ps: int) -> int:
        """Return 0: it has no edges."""
        return 0

    def onward(self, ps: int) -> TrackMotion:
        """Return the motion from an instant (ps) on: it is the same, since a run keeps its past."""
        return self

    def geared(self, ratio: Fraction) -> TrackMotion:
        """Return the motion of a shaft that a gear drives: it turns `ratio` times as far, negative: the other way."""
        return replace(self, track=Track(factor=float(ratio), under=self.track))

    def played(self, here: TrackMotion, play: Fraction, offset: Fraction) -> TrackMotion:
        """Return the motion of what is moved with a play, and began `offset` above this one."""
        return replace(self, track=Track(play=float(play), offset=float(offset), under=self.track))


class Places:
    """The place of a track at any instant: with a play it depends on the way there."""

    def __init__(self, run: Run, track: Track) -> None:
        self.run, self.track = run, track
        first = run.stretches[0]
        self._step = first.law.motor.step
        begun = track.begun(first.first.state[0] / self._step, 0.0)
        self._known = [(first.first.t, begun)]
        run.cuts.append(self._cut)

    def _cut(self, ps: int) -> None:
        while len(self._known) > 1 and self._known[-1][0] >= ps:
            self._known.pop()

    def forget(self, before: int) -> None:
        """Drop what is known of the time before an instant (ps)."""
        if not self.track.simple:
            self.place(before)
            n = max(bisect_right(self._known, before, key=lambda known: known[0]) - 1, 0)
            del self._known[:n]

    def place(self, ps: int) -> float:
        """Return the place at an instant (ps), in steps."""
        if self.track.simple:
            return self.track.begun(self.run.state(ps)[0] / self._step, 0.0)[-1]
        n = len(self._known) - 1
        while n and self._known[n][0] > ps:
            n -= 1
        since, places = self._known[n]
        for _, columns in self.run.between(since, ps):
            for theta in columns[1][:, 0].tolist():
                places = self.track.follow(places, theta / self._step, 0.0)
        places = self.track.follow(places, self.run.state(ps)[0] / self._step, 0.0)
        self._keep(ps, places)
        return places[-1]

    def along(self, times: NDArray[np.int64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the places, in steps, at grid points one after the other: (n,) ps, and the angles there, (n,) rad."""
        import numpy as np

        found = np.empty(len(times))
        if not len(times):
            return found
        self.place(int(times[0]))
        known = [places for ps, places in self._known if ps <= times[0]][-1]
        for n, angle in enumerate((angles / self._step).tolist()):
            known = self.track.begun(angle, 0.0) if self.track.simple else self.track.follow(known, angle, 0.0)
            found[n] = known[-1]
            if n % 1024 == 0:
                self._keep(int(times[n]), known)
        return found

    def _keep(self, ps: int, places: tuple[float, ...]) -> None:
        if ps > self._known[-1][0]:
            self._known.append((ps, places))
            if len(self._known) > 1024:
                del self._known[1:512]


def places_of(run: Run, track: Track) -> Places:
    """Return the places of a track, one and the same for all that ask."""
    found: Places | None = run.along.get(track)
    if found is None:
        found = run.along[track] = Places(run, track)
    return found


def passings_of(run: Run, track: Track, scale: CountScale, zero: float) -> Passings:
    """Return the changes of a count along a track, one and the same for all that ask."""
    key = track, scale, zero
    found: Passings | None = run.along.get(key)
    if found is None:
        found = run.along[key] = Passings(run, track, scale, zero)
    return found


class MotorShaft(Shaft):
    """The shaft of a motor that is integrated.

    Args:
        run: of the rotor.
        alter: changes the law of the run, or its state, at the last committed instant: hard stops, a hand that holds
            the shaft, a push (steps).
    """

    def __init__(self, kernel: Kernel, run: Run, alter: Callable[..., None]) -> None:
        super().__init__(kernel, run.law.motor.full_steps)
        self.run, self._alter = run, alter
        self.rotor = TrackMotion(run)
        self.motion = self.rotor  # type: ignore[assignment]

    def cut(self, ps: int) -> None:
        """End what was foreseen at an instant (ps)."""
        self.on_cut(ps)

    def turned(self) -> None:
        """Tell all that sit on it that the rotor goes on otherwise than foreseen."""
        self.on_turn()

    def turn(self, drive: ClockEdges, sign: int, since: int) -> None:
        """Refuse: the rotor turns it.

        Raises:
            NotImplementedError: always.
        """
        raise NotImplementedError("its rotor turns it")

    def block(self) -> None:
        """Hold it: the rotor stands, and steps are lost."""
        self._alter(blocked=True)

    def free(self) -> None:
        """Let it turn again, from where it is."""
        self._alter(blocked=False)

    def slip(self, steps: Fraction) -> None:
        """Refuse: a rotor slips by itself, when its load is too great.

        Raises:
            UsageError: always.
        """
        raise UsageError("a motor with physics slips by itself; change its load, or block it")

    def push(self, steps: Fraction) -> None:
        """Turn the rotor at once, so many steps, less than 0: back."""
        self._alter(push=float(steps))

    def stop_at(self, low: Place, high: Place) -> None:
        """Set hard stops at two places, in steps; None: no stop on that side."""
        self.stops.append((low, high))
        self._alter(stops=self._bounds)

    def quantity(self, name: str, unit: str = "steps", scale: float = 1.0) -> Polyline:
        """Return the place over time as a quantity, a step being `scale` units."""
        motion = self.rotor

        def changes(start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
            times, places = motion.changes(start, stop)
            return times, places * scale

        return Polyline(self.kernel, name, unit, lambda times: motion.places(times) * scale, changes, from_zero=False)

    def forget(self, before: int) -> None:
        """Keep nothing of what was over before an instant (ps)."""
        self.run.forget(before)
