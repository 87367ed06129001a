"""Cycle trains: a position that moves evenly within each controller cycle, and the resulting steps.

A chip that computes its trajectory once per cycle decides how far the position moves in each cycle.
Steps occur where the position passes whole numbers; PULSE rises half a step earlier:

    position                                       . 3        cycle i: from tick 8192 i, displacement d(i)
                                        .    '
                               .   '                          on the first tick with position
                        .  '                                      >= k + 1      step k begins, PULSE falls
                    . '        2                                  >= k + 1/2    PULSE rises
            .   '                                             (counting steps from 0, as all trains do)
    .  '        1
    |      cycle 0     |      cycle 1     |      cycle 2

One train has one law for the displacements d(i), in one direction: constant or changing evenly
(`Linear`), or an S-curve (s_curves.py).  Like any other train, it is queried rather than expanded.  All
positions are integers, in 1/65536 step, and every answer is exact.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol

from ....core.motion.step_views import TrainView
from ....core.motion.train import Playing, Train
from ....core.time.events import Events, When, before
from ....core.time.timebase import Clock

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

ONE = 1 << 16  # a step
CYCLE = 8192  # ticks
BLOCK = 3 << 12  # steps expanded at a time: they fit into the cache, and into allocated memory
STRETCH = 1 << 10  # cycles expanded at a time if steps are rare
NEAREST = 1.5 * 2.0**52  # a float plus this has no decimals; the sum's bits are then those of this plus the integer
NEAREST_BITS = 0x4338 << 48


# ------------------------------------------------------------------------------------------------------------- answers
@dataclass(frozen=True)
class Cycles:
    """The targets and velocities of an axis, cycle by cycle.

    Attributes:
        per_second: the number of cycles per second.
        numbers: the numbers of the cycles: (n,) int64.
        times_ps: the instant at which each cycle begins: (n,) int64, ps.
        targets: the target at the start of each cycle: (n,) int64, 1/65536 step.
        velocities: the velocity of the target in each cycle: (n,) int64, 1/65536 step per cycle.
        phases: the phase of the S-curve in each cycle, 1 to 7; 0 without an S-curve: (n,) int8.
    """

    per_second: float
    numbers: NDArray[np.int64]
    times_ps: NDArray[np.int64]
    targets: NDArray[np.int64]
    velocities: NDArray[np.int64]
    phases: NDArray[np.int8]

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def accelerations(self) -> NDArray[np.int64]:
        """The changes in velocity from each cycle to the next: (n-1,) int64."""
        import numpy as np

        return np.diff(self.velocities)

    @property
    def jerks(self) -> NDArray[np.int64]:
        """The changes in acceleration from each cycle to the next: (n-2,) int64."""
        import numpy as np

        return np.diff(self.velocities, 2)


# --------------------------------------------------------------------------------------------------------------- laws
class Law(Protocol):
    """A law of motion: the distance covered, 0 before cycle 0, grows by a displacement of 0 to 512 steps per cycle."""

    @property
    def steady(self) -> int:
        """The displacement of every cycle, if it is constant; otherwise 0."""

    @property
    def even(self) -> bool:
        """True if the displacement rises or falls by the same amount from each cycle to the next."""

    def travel(self, i: int) -> int:
        """Return the distance covered before cycle i, in 1/65536 step."""

    def travels(self, i: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the distances covered before cycles `i`, in any order, in 1/65536 step: int64, shaped like `i`."""

    def velocity(self, i: int) -> int:
        """Return the velocity in cycle i, in 1/65536 step per cycle, not affected by rounding of the displacements."""

    def velocities(self, i: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the velocities in the cycles `i`, in any order, in 1/65536 step per cycle: int64, shaped like `i`."""


class Linear:
    """A law under which the displacement of cycle i is `speed + i * change`."""

    __slots__ = ("change", "speed", "steady")
    even = True

    def __init__(self, speed: int, change: int = 0) -> None:
        self.speed, self.change = speed, change
        self.steady = 0 if change else speed

    def travel(self, i: Any) -> Any:
        """Return the distance covered before cycle i, or before each cycle of an array, in 1/65536 step."""
        return i * self.speed + i * (i - 1) // 2 * self.change

    travels = travel

    def velocity(self, i: Any) -> Any:
        """Return the displacement of cycle i, or of each cycle of an array, in 1/65536 step."""
        return self.speed + i * self.change

    velocities = velocity


# -------------------------------------------------------------------------------------------------------------- train
class CycleTrain(Train):
    """The steps of a number of cycles that follow one law.

    Args:
        origin: the tick at which cycle 0 begins.
        cycles: the number of cycles; OPEN for a constant speed without end.
        lead: the distance of the position beyond the last step when cycle 0 begins, in the direction of
            movement: less than a step, positive or negative.
        unit: the distance that counts as one step (1/65536 step); half a step for the edges of PULSE.
    """

    __slots__ = ("_near", "cycle", "cycles", "law", "lead", "unit")

    def __init__(
        self, clock: Clock, origin: int, law: Law, cycles: int, lead: int = 0, cycle: int = CYCLE, unit: int = ONE
    ) -> None:
        super().__init__(clock, origin)
        self.law, self.cycles, self.lead, self.cycle, self.unit = law, cycles, lead, cycle, unit
        self.steps = max((lead + law.travel(cycles)) // unit, 0)
        self.length = cycles * cycle
        self._near = (
            -1,
            0,
            0,
        )  # a cycle, the distance before and after it: a query for one is followed by one for the next

    @property
    def halves(self) -> CycleTrain:
        """The same movement in half steps, counted from 0: PULSE rises at even half steps and falls at odd ones."""
        return CycleTrain(self.clock, self.origin, self.law, self.cycles, self.lead, self.cycle, self.unit // 2)

    def positions(self, i: int, j: int) -> NDArray[np.int64]:
        """Return the positions at the starts of cycles i ... j-1: (n,) int64, 1/65536 step.

        Positions are counted from the last step before cycle 0, in the direction of movement, as `lead` is.
        """
        import numpy as np

        return self.lead + self.law.travels(np.arange(i, j))

    # ------------------------------------------------------------------------------------------------------ questions
    def end(self, k: int) -> int:
        distance = (k + 1) * self.unit - self.lead
        i, before, after = self._near
        if not before < distance <= after:
            if k >= self.steps:
                return self.origin + self.length
            if distance <= 0:  # the lead is more than half a step already
                return self.origin
            i, before, after = self._enter(self._cycle(distance))
        return self.origin + i * self.cycle - (before - distance) * self.cycle // (after - before)

    def few(self, numbers: list[int]) -> list[int]:
        speed, unit, lead, cycle = self.law.steady, self.unit, self.lead, self.cycle
        if not speed or numbers[:1] == [1]:  # step 1 may be due before the train begins
            return super().few(numbers)
        origin = self.origin
        return self.clock.ps_list([origin - -(k * unit - lead) * cycle // speed for k in numbers])

    def step_at(self, tick: int) -> int:
        """Return the number of steps that have begun by a tick, including a step that begins on this tick."""
        i, part = divmod(tick - self.origin, self.cycle)
        if i < 0:
            return 0
        if i >= self.cycles:
            return self.steps
        _, before, after = self._enter(i)
        return max((self.lead + before + (after - before) * part // self.cycle) // self.unit, 0)

    def steps_at(self, ticks: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return how many steps have begun by each of `ticks` (from `origin`, in any order): (n,) int64."""
        import numpy as np

        i, part = np.divmod(ticks, self.cycle)
        i = np.clip(i, 0, self.cycles)
        before = self.law.travels(i)
        after = self.law.travels(np.minimum(i + 1, self.cycles))
        n = (self.lead + before + (after - before) * part // self.cycle) // self.unit
        return np.where(ticks < 0, 0, np.maximum(n, 0))

    def velocities(self, since: int, to: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the velocities from tick `since` up to but excluding tick `to`, both counted from `origin`.

        Returns:
            Ticks counted from `origin`, (n,) int64, ascending, the first being `since`; the velocity from each
                tick to the next, steps/s, float64.
        """
        import numpy as np

        i, j = since // self.cycle, -(-to // self.cycle)
        if self.law.steady:
            j = i + 1
        ticks = np.arange(i, j) * self.cycle
        ticks[0] = since
        return ticks, np.diff(self.law.travels(np.arange(i, j + 1))) * self.clock.hz / (self.cycle * self.unit)

    def extremes(self, since: int, to: int) -> tuple[list[int], list[float]]:
        if not self.law.even:
            return super().extremes(since, to)
        i, j = since // self.cycle, (to - 1) // self.cycle
        first, last = (self.law.velocity(n) * self.clock.hz / (self.cycle * self.unit) for n in (i, j))
        return ([since, j * self.cycle], [first, last]) if j > i else ([since], [first])

    def pieces(self, since: int, to: int) -> int:
        return 1 if self.law.steady else (to - since) // self.cycle + 1

    def rests(self, until: int) -> int:
        return min(max(self.clock.ticks_from(until - 1) - self.origin, 0), self.length)

    def _cycle(self, distance: int) -> int:
        """Return the first cycle at whose end the distance covered is at least `distance`, which is above 0."""
        law = self.law
        if law.steady:
            return (distance - 1) // law.steady
        return bisect_left(range(self.cycles), distance, key=law.travel) - 1

    def _enter(self, i: int) -> tuple[int, int, int]:
        if self._near[0] != i:
            self._near = (i, self.law.travel(i), self.law.travel(i + 1))
        return self._near

    # --------------------------------------------------------------------------------------------------------- arrays
    def ends(self, first: int = 0, last: int | None = None) -> NDArray[np.int64]:
        import numpy as np

        last = self.steps if last is None else min(last, self.steps)
        out = np.empty(max(last - first, 0), np.int64)
        for since, part in self._parts(first, out):
            part += since
        return out

    def times(self, first: int, last: int, out: NDArray[np.int64] | None = None) -> NDArray[np.int64]:
        import numpy as np

        count = max(min(last, self.steps) - first + 1, 0)
        out = np.empty(count, np.int64) if out is None else out[:count]
        for since, part in self._parts(first - 1, out):
            self.clock.ps_array(part, self.origin + since, part)
        return out

    def _parts(self, first: int, out: NDArray[np.int64]) -> Iterator[tuple[int, NDArray[np.int64]]]:
        """Fill `out` with the start ticks of the steps from step `first` on, and yield it in parts.

        Each part comes with its origin, from which its ticks are counted.  Step m of a part, counted from 1, begins on
        tick ceil(x), where x = m * scale + rest.  Both scale and rest are fractions with the denominator d, the
        displacement of the step's cycle; so x is a multiple of 1/d.  Therefore ceil(x) is the integer nearest to
        y = x + 1/2 - 1/(2d), and y is at most 1/2 - 1/(2d) from it.  So y may be computed in floats, if the rounding
        error is less than 1/(2d).  This is so: m * scale and rest are at most 2^45/d each, and rest may also contain
        up to 2^23 whole ticks, so the error is less than 2^-6/d + 2^-28.

        Everything is done in place, because allocating memory for another array takes longer than filling it.
        """
        import numpy as np

        if first == 0 and len(out) and self.lead >= self.unit:
            out[0] = 0
            yield 0, out[:1]
            first, out = 1, out[1:]
        parts = self._steady if self.law.steady else self._uneven
        for count, since, scale, rest, steps in parts(first, first + len(out)):
            part, out = out[:count], out[count:]
            ticks = part.view("f8")
            np.multiply(_counting()[:count], scale if steps is None else scale.repeat(steps), out=ticks)
            ticks += rest if steps is None else rest.repeat(steps)
            ticks += NEAREST
            part -= NEAREST_BITS
            yield since, part

    def _steady(self, first: int, last: int) -> Iterator[tuple[int, int, Any, Any, None]]:
        """Yield the parts at constant speed: (number of steps, origin, scale and rest of all these steps, None)."""
        speed = self.law.steady
        for a in range(first, last, BLOCK):
            since, rest = divmod((a * self.unit - self.lead) * self.cycle, speed)
            yield min(BLOCK, last - a), since, self.unit * self.cycle / speed, (rest - 0.5) / speed + 0.5, None

    def _uneven(self, first: int, last: int) -> Iterator[tuple[int, int, Any, Any, Any]]:
        """Yield the parts at varying speed as (number of steps, origin, scales, rests, steps).

        The last three are arrays with an item for each cycle: its scale, its rest and its number of steps.
        """
        import numpy as np

        end = self._cycle(last * self.unit - self.lead) + 1
        for i in range(self._cycle((first + 1) * self.unit - self.lead), end, STRETCH):
            position = self.positions(i, min(i + STRETCH, end) + 1)
            begun = np.clip(position // self.unit, first, last)
            steps = np.diff(begun)
            displaced = np.maximum(np.diff(position), 1)  # a cycle at rest has no steps that would count this
            p = 0
            while p < len(steps):
                q = int(np.searchsorted(begun, begun[p] + BLOCK, side="right")) - 1
                scale = self.unit * self.cycle / displaced[p:q]
                rest = ((begun[p] * self.unit - position[p:q]) * self.cycle - 0.5) / displaced[p:q]
                rest += np.arange(0, (q - p) * self.cycle, self.cycle) + 0.5
                yield int(begun[q] - begun[p]), (i + p) * self.cycle, scale, rest, steps[p:q]
                p = q


@cache
def _counting() -> NDArray[np.float64]:
    import numpy as np

    return np.arange(1, BLOCK + 1, dtype=np.float64)


class SquareView(TrainView):
    """PULSE of a played cycle train: it is high in the second half of each step.

    If `high`, the preceding movement has left PULSE high, and it stays high until the first step.
    """

    __slots__ = ("halves", "high")

    def __init__(self, of: Playing, high: bool) -> None:
        train: Any = of.train
        self.halves: CycleTrain = train.halves
        self.of, self.high = of, high

    @property
    def rises(self) -> Events:
        """The rising edges of PULSE, one at every other half step."""
        return SquareRises(self)

    def level(self, ps: int) -> int:
        """Return the level at an instant (ps), edges at that instant included."""
        over = self.halves.count(self.of.within(ps))
        return over % 2 if over else int(self.high)

    def after(self, ps: int) -> When:
        """Return the next edge strictly after an instant (ps); None if none is planned."""
        halves = self.halves
        k = max(halves.count(ps), int(self.high))  # a high level does not rise
        if k >= halves.steps:
            return None
        return before(halves.clock.ps(halves.end(k)), self.of.until)

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges at start < t <= stop: (n,) int64 ps and (n,) int8 levels."""
        import numpy as np

        a = max(self.halves.count(start), int(self.high))
        times = self.halves.times(a + 1, self.halves.count(self.of.within(stop)))
        levels = np.empty(len(times), np.int8)
        levels[::2], levels[1::2] = (a + 1) % 2, a % 2
        return times, levels


class SquareRises(Events):
    """The rising edges of PULSE in a cycle train."""

    def __init__(self, view: SquareView) -> None:
        self.view, self.halves, self.high = view, view.halves, int(view.high)

    def count(self, ps: int) -> int:
        return max((self.halves.count(self.view.of.within(ps)) + 1) // 2 - self.high, 0)

    def time(self, k: int) -> When:
        """Return the instant (ps) of rising edge k; None if the train has fewer edges or is cut off before edge k."""
        return before(self.halves.time(2 * (k + self.high) - 1), self.view.until)

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of rising edges first ... last, all of which occur: (n,) int64 ps, ascending."""
        return self.halves.times(2 * (first + self.high) - 1, 2 * (last + self.high) - 1)[::2]

    def few(self, numbers: list[int]) -> list[int]:
        """Return the instants (ps) of the rising edges with the given numbers, all of which occur; ascending."""
        return self.halves.few([2 * (k + self.high) - 1 for k in numbers])
