"""Quantities over time: what a picture or a waveform draws of an axis, exact at every instant.

    velocity, steps/s                                   position, steps
        ________                                                 _   .. a load: a break
       |        |_____        step: as long as             __|‾   |_|
    ___|              |____   the train says          ____|
       first step     rest: 0

The velocity is that of the train that is played: of a train of steps 1/interval of the step in progress, of a train of
cycles what the position is displaced in the cycle.  A step takes as long as its train says, a read-out that lengthens
it included; if the next one has to wait beyond that (STEP INHIBIT, ENABLE, the end of the move), the motor stands, and
the velocity is 0.  Nothing is concluded from the distance of steps.

An outline is what a picture needs of a quantity: a few points a column, each of them exact, and in each column the
first, lowest, highest and last one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .axis import Axis

POINTS = 4  # that a column shows: first, lowest, highest, last


class Outline(NamedTuple):
    """A quantity over a window: each value holds, or begins a line, from its instant to the next.

    A break is a pair of points at one instant: NaN (nothing is drawn up to here), then the new value.
    """

    times_ps: NDArray[np.int64]  # (m,) ascending; the first is the start of the window
    values: NDArray[np.float64]  # (m,)


class Quantity:
    """Something that has a value at every instant.

    `held`: a staircase, each value holds until the next one; else straight lines lead from point to point.
    """

    name: str
    unit: str
    held: bool

    def at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the values at instants of the past, in any order: float64, shape as `times_ps` (int64 ps)."""
        raise NotImplementedError

    def changes(self, start: int, stop: int) -> Outline:
        """Return every change at start < t <= stop (ps), after the value at `start`."""
        raise NotImplementedError

    def outline(self, start: int, stop: int, columns: int) -> Outline:
        """Return what a picture of so many columns shows of the window (ps): at most some four points a column."""
        return thinned(self.changes(start, stop), start, stop, columns)


class Velocity(Quantity):
    """The velocity of an axis, negative counter-clockwise."""

    name, unit, held = "velocity", "steps/s", True

    def __init__(self, axis: Axis) -> None:
        self.axis = axis

    def at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        return self.axis.velocities_at(times_ps)

    def changes(self, start: int, stop: int) -> Outline:
        return Outline(*self.axis.velocities(start, stop))


class Position(Quantity):
    """The position register of an axis.  Where it is loaded, or wraps round, there is a break."""

    name, unit, held = "position", "steps", True

    def __init__(self, axis: Axis) -> None:
        self.axis = axis

    def at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        import numpy as np

        return self.axis.positions_at(times_ps).astype(np.float64)

    def changes(self, start: int, stop: int) -> Outline:
        import numpy as np

        axis = self.axis
        steps = axis.steps(start + 1, stop)
        loads = np.array([since for since, _ in axis.offsets[1:] if start < since <= stop], np.int64)
        times = np.concatenate([[start], steps.times_ps, loads])
        values = np.concatenate([[axis.position_at(start)], steps.positions, axis.positions_at(loads)])
        loaded = np.arange(len(times)) > len(steps)
        order = np.argsort(times, kind="stable")
        times, values, loaded = times[order], values[order], loaded[order]
        last = np.append(times[1:] != times[:-1], True)  # of what happens in one instant
        times, values, loaded = times[last], values[last], loaded[last]
        rise = np.diff(values)
        changed = np.append(True, rise != 0)
        broken = np.append(False, np.abs(rise) > axis.modulus // 2) | (loaded & changed)
        points = np.repeat(np.flatnonzero(changed), 1 + broken[changed])
        out = values[points].astype(np.float64)
        out[np.flatnonzero(broken[points])[::2]] = np.nan
        return Outline(times[points], out)


def thinned(outline: Outline, start: int, stop: int, columns: int) -> Outline:
    """Return points that look the same in a picture of the window: in each column first, lowest, highest and last."""
    import numpy as np

    times, values = outline
    if len(times) <= POINTS * columns:
        return outline
    real = np.flatnonzero(~np.isnan(values))
    column = columns_of(times[real], start, stop, columns)
    last = np.flatnonzero(np.append(column[1:] != column[:-1], True))
    first = np.append(0, last[:-1] + 1)
    by_height = np.lexsort((values[real], column))
    kept = real[np.unique(np.concatenate([first, last, by_height[first], by_height[last]]))]
    breaks = np.flatnonzero(np.isnan(values))  # between two points that are kept, the last break is
    before = np.searchsorted(kept, breaks)
    kept = np.sort(np.append(kept, breaks[np.append(before[1:] != before[:-1], True)[: len(breaks)]]))
    return Outline(times[kept], values[kept])


def columns_of(times: NDArray[np.int64], start: int, stop: int, columns: int) -> NDArray[np.int64]:
    """In which column of a picture each instant lies: (n,) int64, 0 to columns - 1."""
    import numpy as np

    return np.clip(((times - start) * (columns / max(stop - start, 1))).astype(np.int64), 0, columns - 1)
