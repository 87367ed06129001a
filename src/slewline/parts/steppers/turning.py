"""The shaft of a motor whose motion is integrated; parts designed for other shafts fit it unchanged."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

from ...core.motion.history import Polyline
from ...core.time.events import Events, When, later
from ...errors import UsageError
from ..shafts.shaft import Place, Shaft
from ..shafts.shaft_counter import CountScale
from .linkage import Linkage
from .passing import Passings

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import numpy as np
    from numpy.typing import NDArray

    from ...core.time.kernel import Kernel
    from ..motors.law import MotorLaw
    from ..shafts.shaft_counter import Counter
    from .motor_run import Run

FINEST = Fraction(1, 1 << 20)  # step, the resolution of positions returned as fractions
ROTOR = Linkage()
HALF = 0.5  # count, offset of an encoder, so that the rotor does not rest where the count changes


@dataclass(frozen=True)
class LinkageMotion:
    """The motion of a shaft that a rotor turns, valid for the rest of a run.

    The class has the interface of a `ShaftMotion` (`parts/shafts/shaft_motion.py`).
    """

    run: Run
    linkage: Linkage = ROTOR

    @property
    def since(self) -> int:
        """The instant from which the motion is valid (ps)."""
        return self.run.stretches[0].first.t

    def steps_at(self, ps: int) -> Fraction:
        """Return the position at an instant (ps), in steps, rounded to 1/2**20 of a step."""
        return round(Fraction(self.place(ps)) / FINEST) * FINEST

    def place(self, ps: int) -> float:
        """Return the position at an instant (ps), in steps."""
        if self.linkage.simple:
            return float(self.linkage.begun(self.run.state(ps)[0] / self.run.law.motor.step, 0.0)[-1])
        return passings_of(self.run, self.linkage, CountScale(), 0.0).place(ps)

    def places(self, times: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the positions at instants (int64 ps), in steps: (n,) float64."""
        import numpy as np

        return np.array([self.place(int(ps)) for ps in times])

    def edges(self, start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the instants of the integration in start < t <= stop (ps), and the positions at these instants.

        The instants are (n,) int64 ps, and the positions (n,) float64, in steps.
        """
        import numpy as np

        times, places = [np.empty(0, np.int64)], [np.empty(0)]
        for part in self.run.between(start, stop):
            rotor = part.columns[1][:, 0] / part.law.motor.step
            times.append(part.columns[0])
            if self.linkage.simple:
                places.append(self.linkage.begun(rotor, 0.0)[-1])
            else:  # after its first point it moves with the rotor
                first = passings_of(self.run, self.linkage, CountScale(), 0.0).places(int(part.columns[0][0]))
                places.append(self.linkage.gone(first, rotor[0], rotor)[-1])
        return np.concatenate(times), np.concatenate(places)

    def counter(self, scale: CountScale, lag_ps: int) -> Counter:
        """Return the counter of this motion on a scale; it shows each count `lag_ps` later."""
        return RunCounter(passings_of(self.run, self.linkage, scale, HALF if scale.per_step else 0.0), scale, lag_ps)

    def lost(self, ps: int) -> int:
        """Return 0, because the motor model itself counts the lost steps."""
        return 0

    def moved(self, k: int) -> int:
        """Return 0, because no clock edges drive the motion."""
        return 0

    def count(self, ps: int) -> int:
        """Return 0, because no clock edges drive the motion."""
        return 0

    def onward(self, ps: int) -> LinkageMotion:
        """Return this motion itself: it takes its positions from the run, so it is also valid after `ps`."""
        return self

    def geared(self, ratio: Fraction) -> LinkageMotion:
        """Return the motion of a geared shaft: `ratio` times as far; a negative `ratio` reverses the direction."""
        return replace(self, linkage=Linkage(factor=float(ratio), under=self.linkage))

    def played(self, here: LinkageMotion, play: Fraction, offset: Fraction) -> LinkageMotion:
        """Return the motion of a load that this motion drives with backlash.

        The initial position of the load is that of the driving shaft plus `offset` steps.
        """
        return replace(self, linkage=Linkage(play=float(play), offset=float(offset), under=self.linkage))


def passings_of(run: Run, linkage: Linkage, scale: CountScale, zero: float) -> Passings:
    """Return the `Passings` of a run, for a linkage and a scale; calls with equal arguments share one object."""
    key = linkage, scale, zero
    if key not in run.along:
        run.along[key] = Passings(run, linkage, scale, zero)
    found: Passings = run.along[key]
    return found


class RunCounter:
    """A `Counter` (`parts/shafts/shaft_counter.py`) of a linkage: its counts, shown on a wire `lag_ps` later."""

    def __init__(self, passings: Passings, scale: CountScale, lag_ps: int) -> None:
        self.passings, self.scale, self.lag_ps = passings, scale, lag_ps

    def level(self, ps: int) -> int:
        """Return the count shown at an instant (ps)."""
        return self.passings.level(ps - self.lag_ps)

    def after(self, ps: int, changes: int = 1) -> When:
        """Return when (ps) the count shown will have changed `changes` times after an instant (ps).

        Return NotYet if this has not been found yet, None if no such change is foreseen.
        """
        return later(self.passings.after(ps - self.lag_ps, changes), self.lag_ps)

    def edges(self, start: int, stop: int) -> tuple[list[int], list[int]]:
        """Return the changes shown at start < t <= stop (ps): their instants, and the counts after them."""
        times, counts = self.passings.edges(start - self.lag_ps, stop - self.lag_ps)
        return [time + self.lag_ps for time in times], counts

    direction = 0  # the rotor may reverse

    def onward(self, ps: int) -> RunCounter:
        """Return this counter itself: it takes its counts from the run, so it is also valid after `ps`."""
        return self

    def on(self, motion: object, now: int) -> RunCounter:
        """Return the same counter, for the motion of the shaft after `now` (ps)."""
        return self


def pushed(law: MotorLaw, state: Mapping[str, float], by: float) -> dict[str, float]:
    """Return the positions (rad) of rotor and load after a manual turn by `by` rad, or up to a hard stop."""
    places = {name: state[name] for name in ("theta", "theta2") if name in state}
    last_place = list(places.values())[-1]
    if by > 0.0 and law.load.high is not None:
        by = min(by, max(law.load.high - last_place, 0.0))
    elif by < 0.0 and law.load.low is not None:
        by = max(by, min(law.load.low - last_place, 0.0))
    return {name: place + by for name, place in places.items()}


class MotorShaft(Shaft):
    """The shaft of a motor whose motion is integrated.

    Args:
        run: the rotor's run.
        alter: a function that changes the law or the state of the run at the last committed instant, in
            order to set hard stops, to block or free the shaft by hand, or to push it (by steps).
    """

    def __init__(self, kernel: Kernel, run: Run, alter: Callable[..., None]) -> None:
        super().__init__(kernel, run.law.motor.full_steps)
        self.run, self._alter = run, alter
        self.rotor = LinkageMotion(run)
        self.motion = self.rotor  # type: ignore[assignment]

    def cut(self, ps: int) -> None:
        """End the foreseen motion at an instant (ps)."""
        self.on_cut(ps)

    def turned(self) -> None:
        """Notify all parts on the shaft that the rotor no longer follows the foreseen motion."""
        self.on_turn()

    def turn(self, drive: Events, sign: int, since: int) -> None:
        """Refuse, because the rotor turns the shaft.

        Raises:
            NotImplementedError: always.
        """
        raise NotImplementedError("this shaft is turned by its rotor")

    def block(self) -> None:
        """Block the shaft, so that the rotor stops and loses steps."""
        self._alter(blocked=True)

    def free(self) -> None:
        """Free the shaft, so that the rotor turns again from its present position."""
        self._alter(blocked=False)

    def slip(self, steps: Fraction) -> None:
        """Refuse, because a rotor slips by itself when its load is too great.

        Raises:
            UsageError: always.
        """
        raise UsageError("a stepper slips only when its load is too great; change the load, or block the shaft")

    def push(self, steps: Fraction) -> None:
        """Turn the rotor immediately by some steps, backwards if negative."""
        self._alter(push=float(steps))

    def stop_at(self, low: Place, high: Place) -> None:
        self.stops.append((low, high))
        self._alter(stops=self._bounds)

    def quantity(self, name: str, unit: str = "steps", scale: float = 1.0) -> Polyline:
        motion = self.rotor

        def changes(start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
            times, places = motion.edges(start, stop)
            return times, places * scale

        return Polyline(self.kernel, name, unit, lambda times: motion.places(times) * scale, changes, from_zero=False)

    def forget(self, before: int) -> None:
        self.run.forget(before)
