"""A shaft: an object of its own between the part that turns it and the parts that sit on it.

A motor turns a shaft; any number of encoders, switches, gears and carriages may be mounted on it at any
time.  The part that turns the shaft announces a change in two stages, so that no promise is queried
after it has been withdrawn:

    shaft.cut(now - 1)              immediately, while old levels are known: the motion ends here
    shaft.turn(edges, sign, now)    in the next round of the same instant: the motion after `now`

All parts on the shaft receive both announcements: in `on_cut` they follow the old motion until it ends,
in `on_turn` they promise their outputs again.  Outputs of parts on a shaft change later than the step
that moves it, if only by 1 ps, so no edge causes another edge at the same instant, and the order of
rounds within an instant does not matter.

A shaft has no events of its own.  Positions are in steps; one revolution is `per_turn` steps.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Protocol, cast

from ...core.motion.history import Staircase
from ...core.time.events import Events, Listed
from ...core.time.hook import Hook
from ...core.time.inputs import from_outside
from .shaft_counter import counter_of
from .shaft_motion import BLOCKED, Once, ShaftMotion, common

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from ...core.motion.quantity import Quantity
    from ...core.time.kernel import Kernel
    from .shaft_counter import Counter, CountScale

Place = Fraction | None
KEPT = 1 << 14  # minimum number of past motions kept; at most twice as many
SINGLE = 256  # steps made one by one in a past motion


class Shaft:
    """A shaft that a part turns.

    `on_cut` is called with the instant up to which the motion is valid, `on_turn` when there is a new
    motion.  If steps were lost at a stop, `on_lost` is called on request (`look`) or when the motion is cut;
    its arguments are the instant of the first lost step, the number of lost steps, and whether the shaft has
    moved to the stop since the last call.
    """

    def __init__(self, kernel: Kernel, per_turn: int = 200) -> None:
        self.kernel, self.per_turn = kernel, per_turn
        self.motion = ShaftMotion(since=kernel.now)
        self.on_cut: Hook[[int]] = Hook()
        self.on_turn: Hook[[]] = Hook()
        self.on_lost: Hook[[int, int, bool]] = Hook()
        self.source: object = None  # the part that turns it
        self.stops: list[tuple[Place, Place]] = []  # hard stops of the loads: lowest and highest position
        self.past: list[ShaftMotion] = []  # past motions, oldest first
        self.lost = 0  # steps lost at stops
        self._counted = 0  # lost steps of this motion that are already included in `lost`
        self._lost_at_rest = False  # whether the shaft has lost steps at its present position

    # ---------------------------------------------------------------------------------------------- driving the shaft
    def cut(self, ps: int) -> None:
        """End the motion at an instant (ps).

        Until `turn` is called, a motion with the same drive continues from there.
        """
        motion = self.motion
        if ps > motion.since:
            self.look(ps)
            self.on_cut(ps)
            self._counted = 0
            self.motion = motion.onward(ps)
            if self.motion is not motion:
                self._keep(motion, ps)

    def turn(self, drive: Events, sign: int, since: int) -> None:
        """Follow the edges of `drive` after an instant (ps), forward (`sign` 1) or backwards (-1)."""
        motion = self.motion
        self._take(ShaftMotion(drive, since, motion.place, sign, motion.step, motion.unit, motion.slack, None))

    def step(self, ps: int, sign: int) -> None:
        """Make one step, forward or backwards, at an instant (ps) that is not before the last `cut`."""
        self.cut(ps - 1)
        self.turn(Once(ps), sign, ps - 1)
        self.cut(ps)

    # -------------------------------------------------------------------------------------------------- turning by hand
    def block(self) -> None:
        """Block the shaft, so that steps are lost."""
        self._slacken(BLOCKED)

    def free(self) -> None:
        """Free the shaft, which then follows its drive again from its present position."""
        self._slacken(0)

    def slip(self, steps: Fraction) -> None:
        """Let the shaft miss the next `steps` steps, in either direction."""
        self._prepare(steps)
        self._slacken(self.motion.slack + int(steps * self.motion.unit))

    def push(self, steps: Fraction) -> None:
        """Turn the shaft immediately by some steps (negative: backwards), but no further than a stop."""
        here = self.place
        low, high = self._bounds
        if steps > 0 and high is not None:
            steps = min(steps, max(high - here, Fraction(0)))
        elif steps < 0 and low is not None:
            steps = max(steps, min(low - here, Fraction(0)))
        self._prepare(steps)
        self._take(replace(self.motion, place=self.motion.place + int(steps * self.motion.unit)))

    def _prepare(self, steps: Fraction) -> None:
        """Bring the motion up to date, and refine its unit until `steps` is a whole number of units."""
        self.cut(self.kernel.seen)
        self.motion = common(self.motion, steps.denominator)

    def _slacken(self, slack: int) -> None:
        self.cut(self.kernel.seen)
        self._take(replace(self.motion, slack=slack))

    def stop_at(self, low: Place, high: Place) -> None:
        """Add hard stops of a load at two positions, in steps; None: there is no stop on that side."""
        self.cut(self.kernel.seen)
        self.stops.append((low, high))
        self._take(self.motion)

    def _take(self, motion: ShaftMotion) -> None:
        self._counted = 0
        self.motion = motion.within(*self._bounds)
        self.on_turn()

    @property
    def _bounds(self) -> tuple[Place, Place]:
        """Range of the shaft, in steps: the innermost stops of all loads; None: no stop on that side."""
        lows, highs = zip(*self.stops, strict=True) if self.stops else ((), ())
        low = max((place for place in lows if place is not None), default=None)
        return low, min((place for place in highs if place is not None), default=None)

    # --------------------------------------------------------------------------------------------- parts on the shaft
    def counter(self, scale: CountScale, lag_ps: int) -> Counter:
        """Return a counter of the present motion on a scale; it shows each count `lag_ps` later."""
        return counter_of(self.motion, scale, lag_ps)

    @property
    def place(self) -> Fraction:
        """Position at the last committed instant, in steps from the start."""
        return self.motion.steps_at(self.kernel.seen)

    def look(self, ps: int) -> None:
        """Report the steps lost up to an instant (ps), or up to the last committed instant if that is earlier."""
        motion, counted = self.motion, self._counted
        new = motion.lost(ps) - counted
        self._lost_at_rest &= not motion.moved(motion.count(ps)) or bool(counted)
        if new > 0:
            first = cast("int", motion.time((motion.room or 0) + counted + 1))
            is_new, self._lost_at_rest = not self._lost_at_rest, True
            self._counted += new
            self.lost += new
            self.on_lost(first, new, is_new)

    # --------------------------------------------------------------------------------------------------------- the past
    def place_at(self, times: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the positions at instants of the past (int64 ps), in any order, in steps: (n,) float64.

        For an instant before the oldest position that is kept, return that position.
        """
        import numpy as np

        motions = [*self.past, self.motion]
        begins = np.array([motion.since for motion in motions], np.int64)
        which = np.maximum(np.searchsorted(begins, times, "right") - 1, 0)
        places = np.empty(len(times), np.float64)
        for n in np.unique(which):
            places[which == n] = motions[n].places(times[which == n])
        return places

    def changes(self, start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the instants of the steps at start < t <= stop, and the positions after these steps.

        The instants are (n,) int64 ps, and the positions (n,) float64, in steps.
        """
        import numpy as np

        found, before = [], None
        for motion, until in self._motions(start, stop):
            times, places = motion.edges(max(start, motion.since), until)
            if motion.since > start and before is not None:
                place = Fraction(motion.place, motion.unit)
                if before.steps_at(motion.since) != place:  # it was pushed
                    times, places = np.append(motion.since, times), np.append(float(place), places)
            found.append((times, places))
            before = motion
        return np.concatenate([times for times, _ in found]), np.concatenate([places for _, places in found])

    def turns(self, start: int, stop: int) -> list[int]:
        """Return the instants at start <= t <= stop (ps) at which the shaft may have reversed or been pushed.

        Between two of these instants the shaft turns in one direction.
        """
        return [motion.since for motion, _ in self._motions(start, stop) if motion.since >= start]

    def quantity(self, name: str, unit: str = "steps", scale: float = 1.0) -> Staircase:
        """Return the position over time as a quantity; a step is `scale` units."""

        def changes(start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
            times, places = self.changes(start, stop)
            return times, places * scale

        return Staircase(self.kernel, name, unit, lambda times: self.place_at(times) * scale, changes, turns=self.turns)

    def _motions(self, start: int, stop: int) -> list[tuple[ShaftMotion, int]]:
        """Return the motions in effect at start <= t <= stop, each with its last instant (ps)."""
        motions = [*self.past, self.motion]
        untils = [min(motion.since, stop) for motion in motions[1:]] + [stop]
        return [
            (motion, until)
            for motion, until in zip(motions, untils, strict=True)
            if motion.since <= stop and until >= start
        ]

    def forget(self, before: int) -> None:
        """Drop the past before an instant (ps)."""
        n = bisect_right(self.past, before, key=lambda motion: motion.since) - 1
        del self.past[: max(0, n)]

    def _keep(self, motion: ShaftMotion, ps: int) -> None:
        """Keep a past motion; merge successive single steps in the same direction into one motion.

        A motion without steps may be left out.
        """
        if len(self.past) > 2 * KEPT:
            del self.past[:-KEPT]
        last = self.past[-1] if self.past else None
        if last is None or not isinstance(last.drive, Listed):
            self.past.append(motion)
        elif last.level(motion.since) * motion.unit == motion.place * last.unit:
            if not motion.count(ps):
                return
            if isinstance(motion.drive, Once) and motion.moved(1) == motion.step:
                made = last.drive.instants
                if (
                    isinstance(made, list)
                    and len(made) < SINGLE
                    and (last.sign, last.step) == (motion.sign, motion.step)
                ):
                    made += motion.drive.instants
                    return
                motion = replace(motion, drive=Listed([*motion.drive.instants]), room=None)
            self.past.append(motion)
        else:
            self.past.append(motion)


class HasShaft(Protocol):
    """A part with a shaft: either the part drives the shaft, or the shaft drives the part."""

    shaft: Shaft


def shaft_quantities(self: HasShaft) -> tuple[Quantity, ...]:
    """Return the position of the shaft over time; parts with a shaft use this as their `quantities`."""
    return (self.shaft.quantity("position"),)


def forget_shaft(self: HasShaft, before: int) -> None:
    """Drop the positions of the shaft before an instant (ps); parts with a shaft use this as their `forget`."""
    self.shaft.forget(before)


class Blockable:
    """Mixin for parts whose shaft a user may block and free; list it before `Part` among the base classes."""

    shaft: Shaft
    kernel: Kernel
    input: Callable[..., None]

    @from_outside
    def block(self) -> None:
        """Block the shaft, so that it stops and loses steps."""
        self.input("block")
        self.shaft.block()
        self.kernel.settle()

    @from_outside
    def free(self) -> None:
        """Free the shaft, so that it turns again from its present position."""
        self.input("free")
        self.shaft.free()
        self.kernel.settle()


class DrivenShaft(Shaft):
    """A shaft driven by another through a gear or with backlash: its motion follows from the driving shaft's motion."""

    def __init__(self, under: Shaft) -> None:
        super().__init__(under.kernel, under.per_turn)
        self.under, self.source = under, under.source
        under.on_cut.add(self.cut)
        under.on_turn.add(self._follow)

    def _follow(self) -> None:
        self._counted = 0
        self.motion = self.derived(self.under.motion)
        self.on_turn()

    def derived(self, motion: ShaftMotion) -> ShaftMotion:
        """Return the motion of this shaft, derived from a motion of the driving shaft."""
        raise NotImplementedError

    def below(self, steps: Fraction) -> Fraction:
        """Return the number of steps of the driving shaft that corresponds to a number of steps of this shaft."""
        return steps

    def turn(self, drive: Events, sign: int, since: int) -> None:
        """Refuse, because the driving shaft turns this shaft.

        Raises:
            NotImplementedError: always.
        """
        raise NotImplementedError("this shaft is turned by its driving shaft")

    def block(self) -> None:
        """Block the driving shaft."""
        self.under.block()

    def free(self) -> None:
        """Free the driving shaft."""
        self.under.free()

    def slip(self, steps: Fraction) -> None:
        """Let the driving shaft miss the steps that correspond to `steps` steps of this shaft."""
        self.under.slip(abs(self.below(steps)))

    def push(self, steps: Fraction) -> None:
        """Turn the driving shaft immediately by the steps that correspond to `steps` steps of this shaft."""
        self.under.push(self.below(steps))


class GearedShaft(DrivenShaft):
    """A shaft driven by a gear: it turns `ratio` times as far; a negative `ratio` reverses the direction."""

    def __init__(self, under: Shaft, ratio: Fraction) -> None:
        super().__init__(under)
        self.ratio = ratio
        self.motion = self.derived(under.motion)

    def derived(self, motion: ShaftMotion) -> ShaftMotion:
        """Return the motion of this shaft, `ratio` times that of the driving shaft."""
        return motion.geared(self.ratio)

    def below(self, steps: Fraction) -> Fraction:
        return steps / self.ratio

    def stop_at(self, low: Place, high: Place) -> None:
        """Set hard stops at two positions, in steps of this shaft; they block the driving shaft."""
        ends = [None if place is None else place / self.ratio for place in (low, high)]
        self.under.stop_at(*(ends if self.ratio > 0 else reversed(ends)))


class BacklashShaft(DrivenShaft):
    """A shaft driven by another with backlash: after a reversal it stops until the backlash is taken up.

    Initially, at `start`, the backlash is taken up in the forward direction.  After a forward move, the shaft has
    the same offset from the driving shaft as initially; after a backward move, the offset is up to `play` larger.
    """

    def __init__(self, under: Shaft, play: Fraction, start: Fraction) -> None:
        super().__init__(under)
        self.play, self.offset = play, start - under.place
        self.motion = replace(self.motion, place=start.numerator, step=start.denominator, unit=start.denominator)
        self.motion = self.derived(under.motion.onward(self.kernel.seen))

    def derived(self, motion: ShaftMotion) -> ShaftMotion:
        """Return the motion of this shaft, which starts to move when the backlash has been taken up."""
        return motion.played(self.motion, self.play, self.offset)

    def stop_at(self, low: Place, high: Place) -> None:
        """Set hard stops at two positions, in steps of this shaft; they block the driving shaft."""
        low = None if low is None else low - self.play - self.offset
        self.under.stop_at(low, None if high is None else high - self.offset)
