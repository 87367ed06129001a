"""The motor outputs that show a step train, as waveforms promised to their nets in advance.

begin k                begin k+1
  |______________      ___|______
__|              |____|                 PulseView: high for the last `high` ticks of each step
                 |<-->| high
__       _________________          _
  |_____|                 |________|    StrobeView: low for the first `low` ticks of each step
  |<--->| low
__ _______________________ __________
__X_______________________X__________   PatternView: changes to the next phase at the start of each step
__           _____________           _
  |_________|             |_________|   SquareView: high in the second half of each step, for a train of cycles
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..time.events import Events, Since, When, before
from .train import Playing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class TrainView:
    """The waveform of an output that shows the train being played."""

    __slots__ = ("of",)
    of: Playing

    @property
    def until(self) -> int | None:
        """The instant (ps) before which this waveform is promised; None if it is promised forever."""
        return self.of.until

    @property
    def rises(self) -> Events:
        """The rising edges of the output."""
        raise NotImplementedError

    def clock(self, level: int, since: int) -> Events:
        """Return the edges to `level` after the instant `since` (ps): for 1, the rises; for 0, the starts of steps."""
        return Since(self.rises if level else self.of, since)


class StepView(TrainView):
    """An output that shows each step of the train being played.

    It is low from the start of a step until the tick that `rise` returns for this step, and otherwise high.
    """

    __slots__ = ()

    @property
    def rises(self) -> Events:
        """The rising edges of the output, one per step."""
        return Rises(self)

    def rise(self, k: int) -> int:
        """Return the clock tick at which the output rises in step k; steps are counted from 0."""
        raise NotImplementedError

    def rise_ticks(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the ticks, counted from the train's `origin`, at which the output rises in steps first ... last-1.

        The result is (n,) int64; steps are counted from 0.
        """
        raise NotImplementedError

    def level(self, ps: int) -> int:
        """Return the level of the output at an instant (ps), after any edge at that instant."""
        train = self.of.train
        tick = train.clock.ticks_until(self.of.within(ps))
        k = train.step_at(tick)
        return 1 if k == 0 or tick >= self.rise(k - 1) else 0

    def after(self, ps: int) -> When:
        """Return the instant (ps) of the first edge after a given instant (ps); None if no edge is foreseen."""
        train = self.of.train
        tick = train.clock.ticks_until(ps)
        k = train.step_at(tick)
        if k and tick < (rise := self.rise(k - 1)):
            edge = rise
        elif k < train.steps:
            edge = train.end(k)
        else:
            return None
        return before(train.clock.ps(edge), self.of.until)


class Rises(Events):
    """The rising edges of an output that shows each step of a train."""

    def __init__(self, view: StepView) -> None:
        self.view, self.clock = view, view.of.train.clock

    def count(self, ps: int) -> int:
        of, tick = self.view.of, self.clock.ticks_until(self.view.of.within(ps))
        k = of.train.step_at(tick)
        return k - 1 if k and tick < self.view.rise(k - 1) else k

    def time(self, k: int) -> When:
        """Return the instant (ps) of rise k, counted from 1.

        It is None if the train has fewer than k rises, or is cut off before rise k.
        """
        of = self.view.of
        return before(self.clock.ps(self.view.rise(k - 1)), of.until) if k <= of.train.steps else None

    def times(self, first: int, last: int) -> NDArray[np.int64]:
        """Return the instants of rises first ... last: (n,) int64 ps, ascending.

        Rises are counted from 1; all of these must exist.
        """
        ticks = self.view.rise_ticks(first - 1, last)
        return self.clock.ps_array(ticks, self.view.of.train.origin, ticks)


class PulseView(StepView):
    """The PULSE output of a train: high during the last `high` ticks of each step."""

    __slots__ = ("high",)

    def __init__(self, of: Playing, high: int) -> None:
        self.of, self.high = of, high

    def rise(self, k: int) -> int:
        return self.of.train.end(k + 1) - self.high

    def rise_ticks(self, first: int, last: int) -> NDArray[np.int64]:
        import numpy as np

        train = self.of.train
        ends = train.ends(first + 1, last + 1)
        return (np.append(ends, train.length) if last >= train.steps else ends) - self.high

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop (ps): instants, (n,) int64 ps, and new levels, (n,) int8."""
        import numpy as np

        train, clock = self.of.train, self.of.train.clock
        stop = self.of.within(stop)
        a, b = train.count(start), train.count(stop)
        ends = train.ends(max(a - 1, 0), min(b + 1, train.steps))  # begins around the window
        falls = train.window(a + 1, b)
        first = max(a - 1, 0)  # the step that runs at `start` may still rise inside
        last_begin = np.append(ends, train.length) if b + 1 > train.steps else ends
        rises = clock.ps_array(last_begin[1 : b - first + 1] - self.high, train.origin)
        rises = rises[(rises > start) & (rises <= stop)]
        times = np.empty(len(falls) + len(rises), np.int64)
        levels = np.empty(len(times), np.int8)
        rise_first = int(len(rises) > 0 and (len(falls) == 0 or rises[0] < falls[0]))  # after that, they alternate
        times[1 - rise_first :: 2], times[rise_first::2] = rises, falls
        levels[1 - rise_first :: 2], levels[rise_first::2] = 1, 0
        return times, levels


class StrobeView(StepView):
    """A step clock output of a train: low during the first `low` ticks of each step."""

    __slots__ = ("low",)

    def __init__(self, of: Playing, low: int) -> None:
        self.of, self.low = of, low

    def rise(self, k: int) -> int:
        return self.of.train.end(k) + self.low

    def rise_ticks(self, first: int, last: int) -> NDArray[np.int64]:
        return self.of.train.ends(first, last) + self.low

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop (ps): instants, (n,) int64 ps, and new levels, (n,) int8."""
        import numpy as np

        train, stop = self.of.train, self.of.within(stop)
        a, b = train.count(start), train.count(stop)
        first = max(a - 1, 0)  # the step that runs at `start` may still rise inside
        falls = train.times(first + 1, b)
        rises = train.clock.ps_array(train.ends(first, b) + self.low, train.origin)
        times = np.empty(2 * len(falls), np.int64)
        levels = np.empty(len(times), np.int8)
        times[::2], times[1::2] = falls, rises
        levels[::2], levels[1::2] = 0, 1
        inside = (times > start) & (times <= stop)
        return times[inside], levels[inside]


class PatternView(TrainView):
    """A phase output of a train: `levels[(index + sign * begun) % len(levels)]` after `begun` steps have begun.

    Args:
        of: the train that is played.
        levels: the levels of the phase in one cycle of the step pattern, 0 or 1.
        index: the index in `levels` before the first step.
        sign: 1 to step forwards through `levels`, -1 to step backwards.
        before: the level until the first step begins.
    """

    __slots__ = ("before", "index", "levels", "sign")

    def __init__(self, of: Playing, levels: tuple[int, ...], index: int, sign: int, before: int) -> None:
        self.of, self.levels, self.index, self.sign, self.before = of, levels, index, sign, before

    def _after_steps(self, k: int) -> int:
        return self.levels[(self.index + self.sign * k) % len(self.levels)] if k else self.before

    def level(self, ps: int) -> int:
        """Return the level of the output at an instant (ps), after any edge at that instant."""
        return self._after_steps(self.of.count(ps))

    def after(self, ps: int) -> When:
        """Return the instant (ps) of the first edge after a given instant (ps); None if no edge is foreseen."""
        train = self.of.train
        k = train.count(ps)
        here = self._after_steps(k)
        for step in range(k, min(k + len(self.levels) + 1, train.steps)):
            if self._after_steps(step + 1) != here:
                return before(train.clock.ps(train.end(step)), self.of.until)
        return None

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop (ps): instants, (n,) int64 ps, and new levels, (n,) int8."""
        import numpy as np

        train = self.of.train
        a, b = train.count(start), self.of.count(stop)
        if b <= a:
            return np.empty(0, np.int64), np.empty(0, np.int8)
        cycle = [self._after_steps(k) for k in range(a + 1, a + 1 + len(self.levels))]  # further steps repeat the cycle
        changes = [level != before for level, before in zip(cycle, (cycle[-1], *cycle), strict=False)]
        cycles = -(-(b - a) // len(cycle))
        keep = np.tile(np.array(changes), cycles)[: b - a]
        keep[0] = cycle[0] != self._after_steps(a)
        return train.window(a + 1, b)[keep], np.tile(np.array(cycle, np.int8), cycles)[: b - a][keep]
