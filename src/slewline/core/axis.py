"""Where a motor is: the position register of one axis, exact at every instant, and its whole past.

The past is a list of stretches, each following one train; undisturbed travel of any length is one stretch.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..errors import UsageError
from .kernel import Kernel
from .train import Playing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Steps:
    """Steps of a chip: instants (n,) int64 ps, directions (n,) int8 +1/-1, positions after each step (n,) int64."""

    times_ps: NDArray[np.int64]
    directions: NDArray[np.int8]
    positions: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.times_ps)


@dataclass(slots=True)
class Stretch:
    """A stretch of travel: from an instant on, `playing` moves the axis by `sign` a step, starting from `travel`.

    `count` is `travel` without those steps that the position register did not count; it counts `counts` a step.
    """

    start: int
    travel: int
    count: int
    sign: int
    counts: int
    playing: Playing | None


class Axis:
    """Position of one motor: exact at every instant, through the bounded promise, and its whole past.

    `travel` counts steps without wrap-around; `position` is the register, which holds one of `positions` and wraps.
    A motion may leave the register alone.
    """

    def __init__(self, kernel: Kernel, positions: range, position: int) -> None:
        self.kernel, self.positions = kernel, positions
        self.modulus, self.low = len(positions), positions[0]
        self.offset = position - self.low  # position - low = offset + counted, modulo
        self.past = [Stretch(0, 0, 0, 1, 1, None)]
        self.offsets = [(0, self.offset)]
        self.watchers: list[Callable[[], object]] = []  # called when a plan or the register changes

    @property
    def travel(self) -> int:
        """Steps clockwise minus steps counter-clockwise, at the last committed instant."""
        now = self.past[-1]
        return now.travel + (now.sign * now.playing.begun(self.kernel.seen) if now.playing is not None else 0)

    @property
    def counted(self) -> int:
        """The same, of those steps that the position register counts."""
        now = self.past[-1]
        return now.count + (now.counts * now.playing.begun(self.kernel.seen) if now.playing is not None else 0)

    @property
    def position(self) -> int:
        """The position register at the last committed instant."""
        return self.low + (self.offset + self.counted) % self.modulus

    @property
    def moving(self) -> bool:
        """Does the present promise have steps to come?"""
        now = self.past[-1].playing
        return now is not None and now.begun(1 << 80) > now.begun(self.kernel.seen)

    def load(self, position: int) -> None:
        """Declare the present position."""
        self.offset = (position - self.low - self.counted) % self.modulus
        if self.offsets[-1][0] == self.kernel.now:
            self.offsets[-1] = (self.kernel.now, self.offset)
        else:
            self.offsets.append((self.kernel.now, self.offset))
        for watcher in self.watchers:
            watcher()

    def follow(self, playing: Playing | None, sign: int, counted: bool = True) -> None:
        """From this instant on, the axis follows a train; what was played before stays as it is.

        Args:
            counted: false: the position register does not count these steps.
        """
        counts = sign if counted else 0
        self.past.append(Stretch(self.kernel.now, self.travel, self.counted, sign, counts, playing))
        for watcher in self.watchers:
            watcher()

    def arrives(self, position: int) -> int | None:
        """When the present promise reaches a position; None if it does not."""
        time, playing = self.would_arrive(position), self.past[-1].playing
        if time is None or playing is None or (playing.until is not None and time >= playing.until):
            return None
        return time

    def would_arrive(self, position: int) -> int | None:
        """When the present train reaches a position if nothing interferes; None if it does not."""
        now = self.past[-1]
        if now.playing is None or not now.counts:
            return None
        train = now.playing.train
        begun = now.playing.begun(self.kernel.seen)
        missing = (position - self.position) * now.sign % self.modulus or self.modulus
        step = begun + missing - 1
        return train.clock.ps(train.begin(step)) if step < train.steps else None

    def forget(self, before: int) -> None:
        """Drop the past before an instant."""
        keep = next((i for i in range(len(self.past) - 1, 0, -1) if self.past[i].start <= before), 0)
        del self.past[:keep]

    def _windows(self, start: int, stop: int) -> Iterator[tuple[Stretch, int, int]]:
        """Stretches that overlap start <= t <= stop, with the part of the window that each covers (inclusive)."""
        for i, stretch in enumerate(self.past):
            end = self.past[i + 1].start if i + 1 < len(self.past) else stop
            if stretch.playing is not None and stretch.start <= stop and end >= start:
                bound = stretch.playing.until
                last = min(stop, bound - 1 if bound is not None else stop)
                yield stretch, start, last

    def count(self, start: int, stop: int) -> int:
        """How many steps there are at start <= t <= stop."""
        trains = ((stretch.playing, first, last) for stretch, first, last in self._windows(start, stop))
        return sum(max(playing.begun(last) - playing.begun(first - 1), 0) for playing, first, last in trains if playing)

    def steps(self, start: int, stop: int) -> Steps:
        """Steps at start <= t <= stop."""
        import numpy as np

        times, signs, positions = [], [], []
        for stretch, first, last in self._windows(start, stop):
            playing = stretch.playing
            assert playing is not None
            a, b = playing.train.begun(first - 1), playing.train.begun(last)
            if b > a:
                begins = playing.train.begins(a, b)
                times.append(begins)
                signs.append(np.full(b - a, stretch.sign, np.int8))
                positions.append(stretch.count + stretch.counts * np.arange(a + 1, b + 1) + self._offsets_at(begins))
        if not times:
            return Steps(np.empty(0, np.int64), np.empty(0, np.int8), np.empty(0, np.int64))
        return Steps(np.concatenate(times), np.concatenate(signs), self.low + np.concatenate(positions) % self.modulus)

    def _offsets_at(self, times: NDArray[np.int64]) -> NDArray[np.int64]:
        import numpy as np

        since = np.array([since for since, _ in self.offsets], np.int64)
        values = np.array([value for _, value in self.offsets], np.int64)
        return values[np.maximum(np.searchsorted(since, times, side="right") - 1, 0)]

    def position_at(self, ps: int) -> int:
        """The position register at one instant of the past."""
        stretch = self.past[max(bisect_right(self.past, ps, key=lambda stretch: stretch.start) - 1, 0)]
        count = stretch.count + (stretch.counts * stretch.playing.begun(ps) if stretch.playing is not None else 0)
        since = max(bisect_right(self.offsets, ps, key=lambda offset: offset[0]) - 1, 0)
        return self.low + (self.offsets[since][1] + count) % self.modulus

    def positions_at(self, times: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        """The position register at many instants of the past: (n,) int64, shape as `times`."""
        import numpy as np

        at = np.asarray(times)
        if at.dtype.kind not in "iu" or (at.size and int(at.max()) > self.kernel.now):
            raise UsageError(
                f"instants of the past are int64 picoseconds up to {self.kernel.now}, not {at.dtype} or later ones"
            )
        starts = np.array([stretch.start for stretch in self.past], np.int64)
        which = np.maximum(np.searchsorted(starts, at, side="right") - 1, 0)
        out = np.empty(at.shape, np.int64)
        for index in np.unique(which):
            stretch, chosen = self.past[index], which == index
            out[chosen] = stretch.count
            if stretch.playing is not None:
                out[chosen] += stretch.counts * stretch.playing.begun_many(at[chosen])
        return self.low + (out + self._offsets_at(at)) % self.modulus
