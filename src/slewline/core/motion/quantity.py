"""Quantities over time: the curves of an axis in a picture or a waveform, exact at every instant.

    velocity, steps/s                                   position, steps
        ________                                                 _   .. a load: a break
       |        |_____        step: as long as             __|‾   |_|
    ___|              |____   the train specifies     ____|
       first step     rest: 0

The velocity is that of the step train being played (train.py): in a train of steps, 1/interval of the
step in progress; in a train of cycles, the displacement in a cycle divided by its duration.  A step
lasts as long as its train specifies; this includes the extra time if a read-out lengthens the step.  If
the next step has to wait longer (STEP INHIBIT, ENABLE, the end of the move), the motor is at rest, and
the velocity is 0.  The velocity is never derived from the time between two steps.

An outline is a quantity reduced for a picture: a few points per column, each of them exact: the first,
lowest, highest and last point in the column.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Sequence
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, NamedTuple, overload

from ..time.timebase import Time, moments
from .axis import staircase

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .axis import Axis

POINTS = 4  # per column: first, lowest, highest, last


class Outline(NamedTuple):
    """The points of a quantity in a window: each value holds until the next, or a line joins it to the next.

    A break is a pair of points at one instant: NaN (nothing is drawn up to here), then the new value.
    """

    times_ps: NDArray[np.int64]  # (m,) ascending; the first is the start of the window
    values: NDArray[np.float64]  # (m,)


class Quantity:
    """A value that is defined at every instant.

    Attributes:
        name: "velocity", "position", "current" ...
        unit: the unit of its values: "steps/s", "A" ...
        is_staircase: True if each value holds until the next one, as in a staircase; False if intermediate
            values are interpolated linearly.
        from_zero: True if pictures include the value 0, as for a velocity; False if they need not, as for a
            position.
        check_kept: a function that raises NotRecorded for an instant (ps) that is no longer kept; None if
            everything is kept.
    """

    name: str
    unit: str
    is_staircase: bool
    from_zero: bool = True
    check_kept: Callable[[int], object] | None = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self.name}, {self.unit}>"

    @overload
    def at(self, times: Time) -> float: ...  # type: ignore[overload-overlap]  # a text is no sequence of times
    @overload
    def at(self, times: Sequence[Time] | NDArray[np.int64]) -> NDArray[np.float64]: ...
    def at(self, times: Time | Sequence[Time] | NDArray[np.int64]) -> float | NDArray[np.float64]:
        """Return the value at one past instant, or the values at several: float64, same shape as `times`.

        Args:
            times: "3 ms" or picoseconds, a list of them, or an array of int64 picoseconds, in any order.

        Raises:
            TimeError: an instant is not a time.
            UsageError: an instant is in the future.
            NotRecorded: the past is no longer kept that far back (`Bench(keep=)`).
        """
        import numpy as np

        instants = moments(times)
        if self.check_kept is not None and np.size(instants):
            self.check_kept(int(np.min(instants)))
        if isinstance(instants, int):
            return float(self.values_at(np.array([instants]))[0])
        return self.values_at(instants)

    def values_at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the values at past instants (int64 ps), in any order: float64, same shape as `times_ps`."""
        raise NotImplementedError

    def changes(self, start: int, stop: int) -> Outline:
        """Return the value at `start`, and every change in start < t <= stop (ps)."""
        raise NotImplementedError

    def staircase(self, start: int, stop: int) -> Outline:
        """Return the value at `start`, and every change in start < t <= stop (ps); each value holds until the next.

        A quantity that changes linearly becomes a series of small steps, the same for every window.
        """
        return self.changes(start, stop)

    def outline(self, start: int, stop: int, columns: int) -> Outline:
        """Return the curve in start <= t <= stop (ps), reduced to at most about 4 points per column of a picture."""
        return thinned(self.changes(start, stop), start, stop, columns)


class Velocity(Quantity):
    """The velocity of an axis, negative counter-clockwise."""

    name, unit, is_staircase = "velocity", "steps/s", True

    def __init__(self, axis: Axis) -> None:
        self.axis = axis

    def values_at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the velocities at past instants (ps), in any order: float64 steps/s, same shape as `times_ps`."""
        return self.axis.velocities_at(times_ps)

    def changes(self, start: int, stop: int) -> Outline:
        """Return the velocity at `start`, followed by every change in start < t <= stop (ps)."""
        return Outline(*self.axis.velocities(start, stop))

    def outline(self, start: int, stop: int, columns: int) -> Outline:
        """Return the curve in start <= t <= stop (ps), reduced to a few points per column of a picture."""
        import numpy as np

        driven = self.axis.driven(start, stop)
        if not exceeds((playing.pieces(since, end - 1) for since, end, _, playing in driven), POINTS * columns):
            return thinned(self.changes(start, stop), start, stop, columns)
        edges = column_edges(start, stop, columns)
        times, speeds = [start], [0.0]
        for since, end, sign, playing in driven:
            inside = edges[bisect_right(edges, since) : bisect_left(edges, end)]
            for begin, over in pairwise([since, *inside, end]):
                changes, found = playing.extremes(begin, over - 1)
                times += changes
                speeds += [sign * speed for speed in found]
        whole = staircase(np.array(times, np.int64), np.array(speeds) + 0.0)
        return thinned(Outline(*whole), start, stop, columns)


class Position(Quantity):
    """The position register of an axis.  Its curve has a break where the register is loaded or wraps around."""

    name, unit, is_staircase, from_zero = "position", "steps", True, False

    def __init__(self, axis: Axis) -> None:
        self.axis = axis

    def values_at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the positions at past instants (ps), in any order: float64, same shape as `times_ps`."""
        import numpy as np

        return self.axis.positions_at(times_ps).astype(np.float64)

    def changes(self, start: int, stop: int) -> Outline:
        """Return the position at `start`, followed by every change in start < t <= stop (ps)."""
        import numpy as np

        axis = self.axis
        steps, loads = axis.steps(start + 1, stop), axis.loads(start, stop)
        times = np.unique(np.concatenate([[start], steps.times_ps, np.array(loads, np.int64)]))
        return self._broken(times, axis.unwrapped_at(times), times, loads)

    def outline(self, start: int, stop: int, columns: int) -> Outline:
        """Return the curve in start <= t <= stop (ps), reduced to a few points per column of a picture."""
        import numpy as np

        axis = self.axis
        if not exceeds((b - a for _, _, a, b in axis.played(start + 1, stop)), POINTS * columns):
            return thinned(self.changes(start, stop), start, stop, columns)
        turns = np.array([start, *axis.turns(start + 1, stop)])
        edges = np.array(column_edges(start, stop, columns))
        times = np.unique(np.concatenate([turns, turns - 1, edges, edges - 1, [stop]]))
        times = times[times >= start]
        unwrapped = axis.unwrapped_at(times)
        wraps = np.array(self._wraps(times, unwrapped, turns), np.int64)
        if len(wraps):
            around = np.concatenate([wraps, wraps - 1])
            times, first = np.unique(np.append(times, around), return_index=True)
            unwrapped = np.append(unwrapped, axis.unwrapped_at(around))[first]
        outline = self._broken(times, unwrapped, np.append(wraps, turns), axis.loads(start, stop))
        return thinned(outline, start, stop, columns)

    def _wraps(self, times: NDArray[np.int64], unwrapped: NDArray[np.int64], turns: NDArray[np.int64]) -> list[int]:
        """Return the instant (ps) of the first wrap-around in each interval between consecutive `times`.

        Intervals without a wrap-around are skipped, and so are intervals that end at one of `turns`.

        Args:
            times: ascending instants, ps, which include all of `turns`.
            unwrapped: the values of `Axis.unwrapped_at` at `times`.
            turns: the instants at which a train begins or the register is loaded, ps.
        """
        import numpy as np

        axis = self.axis
        rounds = unwrapped // axis.modulus
        wrapped = np.flatnonzero(rounds[1:] != rounds[:-1])
        out = []
        for n in wrapped[~np.isin(times[wrapped + 1], turns)].tolist():
            upward = bool(rounds[n + 1] > rounds[n])
            end = (int(rounds[n]) + upward) * axis.modulus  # the register wraps from modulus - 1 to 0, or back
            out.append(axis.reached(end if upward else end - 1, int(times[n])))
        return out

    def _broken(
        self, times: NDArray[np.int64], unwrapped: NDArray[np.int64], steps: NDArray[np.int64], loads: list[int]
    ) -> Outline:
        import numpy as np

        rounds, values = np.divmod(unwrapped, self.axis.modulus)
        changed = np.append(True, values[1:] != values[:-1])
        wrapped = np.append(False, rounds[1:] != rounds[:-1]) & np.isin(times, steps)
        broken = changed & (wrapped | np.isin(times, loads))
        broken[0] = False
        points = np.repeat(np.flatnonzero(changed), 1 + broken[changed])
        out = (self.axis.low + values[points]).astype(np.float64)
        out[np.flatnonzero(broken[points])[::2]] = np.nan
        return Outline(times[points], out)


def exceeds(counts: Iterable[int], limit: int) -> bool:
    """Return whether the counts add up to more than a limit; the iteration ends as soon as they do."""
    return any(total > limit for total in accumulate(counts))


def thinned(outline: Outline, start: int, stop: int, columns: int) -> Outline:
    """Return an outline reduced to the points that its picture needs.

    These are the first, lowest, highest and last point in each column, and the breaks between them.
    """
    import numpy as np

    times, values = outline
    if len(times) <= POINTS * columns:
        return outline
    real = np.flatnonzero(~np.isnan(values))
    column = np.searchsorted(column_edges(start, stop, columns), times[real], side="right")
    last = np.flatnonzero(np.append(column[1:] != column[:-1], True))
    first = np.append(0, last[:-1] + 1)
    by_height = np.lexsort((values[real], column))
    kept = real[np.unique(np.concatenate([first, last, by_height[first], by_height[last]]))]
    breaks = np.flatnonzero(np.isnan(values))  # the last break between two kept points is kept
    before = np.searchsorted(kept, breaks)
    kept = np.sort(np.append(kept, breaks[np.append(before[1:] != before[:-1], True)[: len(breaks)]]))
    return Outline(times[kept], values[kept])


def column_edges(start: int, stop: int, columns: int) -> list[int]:
    """Return the instants (ps) at which the columns begin in a picture that shows start <= t <= stop (ps)."""
    return [start + (stop - start) * column // columns for column in range(columns)]
