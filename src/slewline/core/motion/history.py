"""Values over time: histories, recorded as values change, and the quantities of parts.

    value      ______            ______         a history: each value holds until the next one
         _____|      |__________|
         note  note   note       note           at, changes: exact at any past instant

A part that is notified of every change records it in a history.  A part that can compute its value at
any past instant needs no history: its quantity calls two functions, one for values and one for changes
(`Staircase`).
"""

from __future__ import annotations

from array import array
from bisect import bisect_right
from collections.abc import Callable, Iterator
from math import nan
from typing import TYPE_CHECKING, Any, TypeAlias

from ...errors import UsageError
from ..time.timebase import readable
from .quantity import POINTS, Outline, Quantity, column_edges, exceeds, thinned

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..time.kernel import Kernel

    Values: TypeAlias = Callable[[NDArray[np.int64]], NDArray[np.float64]]
    Changes: TypeAlias = Callable[[int, int], tuple[NDArray[np.int64], NDArray[np.float64]]]
    Turns: TypeAlias = Callable[[int, int], list[int]]


KEPT = 1 << 20  # minimum number of changes kept; up to twice as many may be
LOOK_BACK_PS = 10**9  # for the last point of a line; farther when there is none


class Staircase(Quantity):
    """A quantity of a part that can compute its past: each value holds until the next one.

    Args:
        kernel: the kernel of the part; no instant after its current one can be queried.
        name, unit: as shown in pictures and waveform files.
        values: a function that returns the values at past instants (int64 ps), in any order: float64, same
            shape as its argument.
        changes: a function that returns every change in start < t <= stop: the instants, (n,) int64 ps,
            ascending, and the new values, (n,) float64.
        from_zero: True if pictures include the value 0.
        turns: for a count, a function that returns the instants in start <= t <= stop at which it may
            reverse or jump; between two of them the count only rises or only falls, by 1 at a time.  A
            picture of a long time then needs only a few of the changes.
    """

    is_staircase = True

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        unit: str,
        values: Values,
        changes: Changes,
        *,
        from_zero: bool = True,
        turns: Turns | None = None,
    ) -> None:
        self.kernel, self.name, self.unit, self.from_zero = kernel, name, unit, from_zero
        self._values, self._changes, self._turns = values, changes, turns

    def values_at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the values at past instants (ps), in any order: float64, same shape as `times_ps`."""
        last = int(times_ps.max(initial=0))
        if last > self.kernel.now:
            raise UsageError(f"{self.name}: {readable(last)} is in the future; the time is {readable(self.kernel.now)}")
        return self._values(times_ps)

    def changes(self, start: int, stop: int) -> Outline:
        """Return the value at `start`, followed by every change in start < t <= stop (ps)."""
        import numpy as np

        times, values = self._changes(start, min(stop, self.kernel.now))
        first = self._values(np.array([start]))
        return Outline(np.append(start, times), np.append(first, values))

    def outline(self, start: int, stop: int, columns: int) -> Outline:
        """Return the curve in start <= t <= stop (ps), reduced to a few points per column of a picture."""
        import numpy as np

        if self._turns is None:
            return thinned(self.changes(start, stop), start, stop, columns)
        stop = min(stop, self.kernel.now)
        turns = np.array([start, *self._turns(start + 1, stop), stop + 1], np.int64)
        passed = np.abs(self._values(turns[1:] - 1) - self._values(turns[:-1])).astype(np.int64)
        if not exceeds(passed.tolist(), POINTS * columns):
            return thinned(self.changes(start, stop), start, stop, columns)
        edges = np.array(column_edges(start, stop, columns))
        times = np.unique(np.concatenate([turns[:-1], turns[1:] - 1, edges, edges - 1]))
        times = times[times >= start]
        return thinned(Outline(times, self._values(times)), start, stop, columns)


class Polyline(Staircase):
    """A quantity that is linear between points, such as one that a part integrates.

    The argument `changes` returns the points at which the line bends; a jump is two points at the same
    instant.  In a waveform file, which cannot represent sloping lines, each value holds until the next
    point.
    """

    is_staircase = False

    def changes(self, start: int, stop: int) -> Outline:
        import numpy as np

        stop = min(stop, self.kernel.now)
        times, values = super().changes(start, stop)
        if times[-1] < stop:
            times, values = np.append(times, stop), np.append(values, self._values(np.array([stop])))
        return Outline(times, values)

    def staircase(self, start: int, stop: int) -> Outline:
        """Return the value at `start`, and every point in start < t <= stop (ps); each value holds until the next.

        The value at `start` is the value of the last point at or before `start`.
        """
        import numpy as np

        times, values = self._changes(start, min(stop, self.kernel.now))
        return Outline(np.append(start, times), np.append(self._point_before(start), values))

    def _point_before(self, ps: int) -> float:
        """Return the value at the last point at or before an instant (ps)."""
        import numpy as np

        back = LOOK_BACK_PS
        while True:
            values = self._changes(max(ps - back, -1), ps)[1]
            if len(values) or back > ps:
                return float(values[-1] if len(values) else self._values(np.array([0]))[0])
            back *= 16


class History:
    """Recorded changes of a value, 16 bytes each; to limit memory, all except the last `KEPT` may be dropped.

    Once changes have been dropped, the value at instants before the kept ones is NaN.

    Args:
        value: the value before the first change.
        since: the first known instant (ps); until changes are dropped, the value at earlier
            instants is that at `since`.
    """

    def __init__(self, value: float = 0.0, since: int = 0) -> None:
        self._times, self._values = array("q", [since]), array("d", [value])
        self._forgotten = 0  # the instant before which all values are dropped

    def __len__(self) -> int:
        return len(self._times)

    def __iter__(self) -> Iterator[tuple[int, float]]:
        """Yield the kept values in order, each with the instant (ps) from which it holds."""
        return zip(self._times, self._values, strict=True)

    @property
    def last(self) -> float:
        """The latest value."""
        return self._values[-1]

    def note(self, ps: int, value: float) -> None:
        """Record the value that holds from an instant (ps) on, which must not precede the last recorded instant.

        If several values are recorded for one instant, the last one counts.
        """
        times, values = self._times, self._values
        if times[-1] == ps:
            values[-1] = value
            if len(values) > 1 and values[-2] == value:  # the value returned within the instant
                del times[-1], values[-1]
        elif values[-1] != value:
            times.append(ps)
            values.append(value)
            self._bound()

    def note_many(self, times_ps: Any, values: Any) -> None:
        """Record values, each with the instant (ps) from which it holds, as two lists or two arrays.

        The instants must be ascending, and later than all recorded ones.
        """
        if isinstance(times_ps, list):
            self._times.extend(times_ps)
            self._values.extend(values)
        else:
            import numpy as np

            self._times.frombytes(np.asarray(times_ps, np.int64).tobytes())
            self._values.frombytes(np.asarray(values, np.float64).tobytes())
        self._bound()

    def _bound(self) -> None:
        if len(self._times) > 2 * KEPT:
            self.forget(self._times[-KEPT])

    def at(self, ps: int) -> float:
        """Return the value at one instant (ps); NaN if the values of that time have been dropped."""
        if ps < self._forgotten:
            return nan
        return self._values[max(bisect_right(self._times, ps) - 1, 0)]

    def values_at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the values at instants (ps) in any order: float64, same shape as `times_ps`.

        The value is NaN at instants whose values have been dropped.
        """
        import numpy as np

        times, values = np.array(self._times), np.array(self._values)
        found: NDArray[np.float64] = values[np.maximum(np.searchsorted(times, times_ps, side="right") - 1, 0)]
        found[times_ps < self._forgotten] = nan
        return found

    def changes(self, start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the kept changes in start < t <= stop (ps): instants, (n,) int64 ps, and new values, (n,) float64.

        The first kept value counts as a change at the instant from which it holds.
        """
        import numpy as np

        start = max(start, min(self._forgotten - 1, stop))
        part = slice(bisect_right(self._times, start), bisect_right(self._times, stop))
        return np.array(self._times[part], np.int64), np.array(self._values[part], np.float64)

    def forget(self, before: int) -> None:
        """Drop the values before an instant (ps), except the one in force at that instant."""
        first = max(bisect_right(self._times, before) - 1, 0)
        if first:
            del self._times[:first], self._values[:first]
            self._forgotten = self._times[0]

    def quantity(self, kernel: Kernel, name: str, unit: str, *, from_zero: bool = True) -> Staircase:
        """Return a quantity that has the values of this history; for the arguments, see `Staircase`."""
        return Staircase(kernel, name, unit, self.values_at, self.changes, from_zero=from_zero)
