"""Conversion of the steps of a chip's axis into records for a board: each step is output one horizon later.

    model     m0 ........ steps that are final .......| present
    board     | START ... base: end of the queue .....|..... H ....|
                               [open record, kept back]

Each turn fits records to the steps that the model has made since the previous turn.  The last record is kept back as
long as the board has three quarters of the horizon queued before it, so that steps of later turns may join it.  While
the model is at rest, pauses fill the queue up to the model's current time, so an underrun always means trouble.  The
end of a motion is followed by a pause after which the motor may stop (REST).

Names with the suffix 16 are in 1/65536 tick.  `base16` is calculated as on the board, so errors do not accumulate.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, NamedTuple, Protocol

from .board.boards import FAST_TICKS, SOONEST_TICKS
from .board.records import DOWN, HALF, MOST_STEPS, OUT, PAUSE, REST, Record, fit

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..core.motion.axis import Axis, Segment
    from ..core.time.kernel import Kernel
    from .ticks import TickMap

TOLERANCE_TICKS = 8  # the timing tolerance of every step
LEAST_PAUSE = SOONEST_TICKS << 16  # also from a pause to a step
REST_TICKS = SOONEST_TICKS  # from the last step to the instant at which the motor may stop
SLACK_TICKS = 32  # beyond the shortest interval, between a pause and an unknown step
FIRST_INTERVAL_TICKS = 4096  # before the first step, while the second one is unknown
FIRST_RECORDS = 5  # records sent before START, the others after it: a full queue without START would block
LONGEST_PRODUCT = 1 << 62


class RecordSink(Protocol):
    """A receiver of records, which keeps their order; for example `Link`."""

    def push(self, records: list[Record]) -> object:
        """Queue records."""

    def start(self, tick: int) -> object:
        """Start the queued records; the first interval begins at the given tick."""

    def restart(self, tick: int) -> object:
        """Start, at a tick, the records already on the board, before sending any that wait for free slots."""


class PlannedSteps(NamedTuple):
    """Steps in one direction, at instants in 1/65536 tick."""

    flags: int
    ticks16: NDArray[np.int64]
    ramp_left: int  # the number of steps in a stop ramp that starts at the first of these steps; -1: unknown
    slope: int  # the change of this number for each further step: -1, 0 or 1


class PlannedOutput(NamedTuple):
    """A change of outputs at a tick (in 1/65536 tick): a mask of the outputs that change, and their new levels."""

    tick16: int
    mask: int
    value: int


class Feeder:
    """A converter of the steps of one axis into records for a board.

    Args:
        axis: the axis of the chip.
        kernel: the kernel of the chip's bench, which is idle during a turn.
        link: the receiver of the records.
        ticks: the conversion of instants into ticks.
        horizon: the delay, in ticks, from a step of the model to the same step of the motor.
        shortest: the minimum interval between two steps, in ticks.
        put: called with each output change that occurs at rest, or between two steps too close for a pause.
        half: a function that returns whether the chip makes half steps now.
        ramps: a function that divides a range of steps into pieces (`RampPiece`) that state each step's stop ramp.
        wake: called before a motion is started.
    """

    def __init__(
        self,
        axis: Axis,
        kernel: Kernel,
        link: RecordSink,
        ticks: TickMap,
        horizon: int,
        shortest: int,
        put: Callable[[PlannedOutput], object] = lambda _output: None,
        half: Callable[[], bool] = lambda: False,
        ramps: Callable[[Segment, int, int], Iterable[tuple[int, int, int, int]]] = lambda _, a, b: [(a, b, -1, 0)],
        wake: Callable[[], object] = lambda: None,
    ) -> None:
        import numpy as np

        self.axis, self.kernel, self.link, self.ticks, self.horizon = axis, kernel, link, ticks, horizon
        self._put, self._half, self.ramps, self.wake, self.shortest = put, half, ramps, wake, shortest
        self._none: NDArray[np.int64] = np.empty(0, np.int64)
        self.taken_ps = kernel.now  # the steps before this instant are taken
        self.running = False  # there are queued steps after which the board has not come to rest
        self.stopped = False  # steps are not queued: the board is in HALT, or the position of the motor is unknown
        self.lost = 0  # net steps of the model since the board's count was last taken over
        self.steps = self.records = 0  # queued so far
        self.net = 0  # steps up minus steps down queued so far
        self.first_interval16 = 0  # for the last motion queued: from its first step to its second
        self._changes: list[tuple[int, int, int]] = []
        self._forget()

    def _forget(self) -> None:
        self.base16 = 0
        self.running = self._rested = False  # the last record queued is REST
        self._flags = 0
        self._items: deque[PlannedSteps | PlannedOutput] = deque()
        self._open, self._record = self._none, Record(0, 0, 0, 0, 0)
        self._interval16 = self._add = 0  # continuation of the last record; 0: unknown
        self._ramp_left, self._slope = -1, 0  # of the first open step
        self._rests: deque[int] = deque()
        self._batch: list[Record] = []
        self._start: int | None = None
        self.started: int | None = None  # the tick of the last START; None: none since the board was opened or halted

    # ----------------------------------------------------------------------------------------------------- interface
    @property
    def busy(self) -> bool:
        """True from the model's first step until the board has come to rest after the last; False if `stopped`."""
        if self.stopped:
            return False
        now = self.kernel.now
        return self.running or bool(self._items) or next(self.axis.played(self.taken_ps, now), None) is not None

    @property
    def interval16(self) -> int:
        """The last interval queued, in 1/65536 tick; 0 if none was queued since a pause."""
        return self._record.last if len(self._open) else self._interval16

    @property
    def shortest(self) -> int:
        """The minimum interval between two steps, in ticks."""
        return self._shortest16 >> 16

    @shortest.setter
    def shortest(self, ticks: int) -> None:
        self._shortest16 = ticks << 16
        self._margin16 = (max(ticks, SOONEST_TICKS) + SLACK_TICKS) << 16

    def change(self, mask: int, value: int) -> None:
        """Change the outputs in `mask` to the bits of `value`, at the current instant of the model."""
        self._changes.append((self.kernel.now, mask, value))

    def turn(self, tick: int) -> None:
        """Queue the new steps and output changes of the model; `tick` is the current tick of the board."""
        self._take()
        if not self.stopped:
            self._lay()
            self._keep_up(tick)
        self._send()

    def rest(self, tick: int) -> None:
        """Record that the board is at rest at a tick, after a REST record; start any records queued after that."""
        while self._rests and self._rests[0] < tick:
            self._rests.popleft()
        if not self._rests or self._rests[0] != tick:
            return
        self._rests.popleft()
        if self._rests or not self._rested:  # records after it came too late to join
            self._send()
            self.started = tick
            self.link.start(tick)
        else:
            self.running = False

    def delay(self, ticks: int) -> None:
        """Delay all further output by a number of ticks, because the board could not start in time."""
        more = ticks << 16
        self.ticks.origin16 += more
        self.base16 += more
        self._open = self._open + more
        self._rests = deque(at + ticks for at in self._rests)
        self._start = None if self._start is None else self._start + ticks
        self._items = deque(
            item._replace(ticks16=item.ticks16 + more)
            if isinstance(item, PlannedSteps)
            else item._replace(tick16=item.tick16 + more)
            for item in self._items
        )

    def restart(self, tick: int) -> None:
        """Start the board's records later, at a tick, because START came late; delay all further output equally."""
        if self.started is not None:
            self.delay(tick - self.started)
            self.started = tick
            self.link.restart(tick)

    def counted(self) -> None:
        """Reset the number of lost steps to 0, because the model now has the position of the motor."""
        self._take()
        self.lost = 0

    def halt(self) -> None:
        """Clear the queue, and queue no more steps, because the board has halted."""
        self._forget()
        self.stopped, self.lost = True, 0

    def go_on(self) -> None:
        """Queue the steps that the model makes from now on."""
        self._take()
        self.stopped = False

    def resume(self, since_ps: int) -> None:
        """Queue the model's steps from an instant (ps) on: a past one if the model has switched to another run."""
        self._changes.clear()
        self.stopped, self.lost, self.taken_ps = False, 0, since_ps

    # ------------------------------------------------------------------------------------------------ from the model
    def _take(self) -> None:
        """Take over the steps and output changes that the model made before its current time: they are final."""
        start, now = self.taken_ps, self.kernel.now
        if now <= start:
            return
        self.taken_ps = now
        changes, self._changes = self._changes, []
        horizon16 = self.horizon << 16
        outputs = deque(PlannedOutput(self.ticks.at(ps) + horizon16, mask, value) for ps, mask, value in changes)
        for stretch, train, a, b in self.axis.played(start, now - 1):
            if self.stopped:
                self.lost += stretch.sign * (b - a)  # the model continues, the motor does not
                continue
            flags = (HALF if self._half() else 0) | (DOWN if stretch.sign < 0 else 0)
            for first, end, ramp_left, slope in self.ramps(stretch, a, b):
                ticks16 = self.ticks.many(train.times(first + 1, end)) + horizon16
                while outputs and outputs[0].tick16 < ticks16[-1]:
                    before = int(ticks16.searchsorted(outputs[0].tick16, "right"))
                    if before:
                        self._items.append(PlannedSteps(flags, ticks16[:before], ramp_left, slope))
                    self._items.append(outputs.popleft())
                    ticks16, ramp_left = ticks16[before:], ramp_left + before * slope
                self._items.append(PlannedSteps(flags, ticks16, ramp_left, slope))
        self._items.extend(outputs)

    # -------------------------------------------------------------------------------------------------- to the board
    @property
    def _present16(self) -> int:
        """The tick (in 1/65536 tick) up to which output is final; any new step is at least `_margin16` later."""
        return self.ticks.at(self.taken_ps) + (self.horizon << 16) - self._margin16

    def _lay(self) -> None:
        items = self._items
        while items:
            item = items.popleft()
            if isinstance(item, PlannedSteps):
                self._queue_steps(*item)
            elif not self._queue_output(item):
                items.appendleft(item)
                break

    def _queue_steps(self, flags: int, ticks16: NDArray[np.int64], ramp_left: int, slope: int) -> None:
        goes_on = self._ramp_left + self._slope * len(self._open), self._slope
        if flags != self._flags or (ramp_left, slope) != goes_on:
            self._close()
            self._interval16 = 0
            self._ramp_left, self._slope = ramp_left, slope
        self._flags = flags
        if self._rested or not self.running:
            self._begin(ticks16)
        self.steps += len(ticks16)
        self.net += -len(ticks16) if flags & DOWN else len(ticks16)
        for at in range(0, len(ticks16), MOST_STEPS):
            part = ticks16[at : at + MOST_STEPS]
            if not self._join(part):
                self._fit(part)

    def _begin(self, ticks16: NDArray[np.int64]) -> None:
        """Start the board, or continue after a rest; the first interval is as long as the second, within limits."""
        first = int(ticks16[0])
        interval = int(ticks16[1]) - first if len(ticks16) > 1 else FIRST_INTERVAL_TICKS << 16
        self.first_interval16 = interval if len(ticks16) > 1 else 0
        interval = min(max(interval, self._margin16), self.horizon << 14)
        begin = first - interval >> 16 << 16
        if not self.running:
            self.base16, self._start, self.running = begin, begin >> 16, True
        elif begin - self.base16 >= LEAST_PAUSE:
            self._pause(begin)
        self._rested, self._interval16 = False, 0

    def _join(self, ticks16: NDArray[np.int64]) -> bool:
        """Append steps to the open record, or to a new one after the last record; return False if not all fit.

        So a long slew takes only a few array operations.  In a ramp, `_fit` makes longer records than `_join`.
        """
        import numpy as np

        interval, add, made = self._interval16, self._add, 0
        if len(self._open):
            record = self._record
            interval, add, made = record.first, record.add, record.count
        if not interval:
            return False
        count = made + len(ticks16)
        if count > min(MOST_STEPS, LONGEST_PRODUCT // interval):
            return False
        if not self._shortest16 <= interval + (count - 1) * add < 1 << 47:
            return False
        k = np.arange(made + 1, count + 1)
        ends = self.base16 + k * interval + k * (k - 1) // 2 * add
        if (np.abs(ends - ticks16) > TOLERANCE_TICKS << 16).any():
            return False
        self._record = Record(self._flags, count, interval >> 16, interval & 0xFFFF, add)
        self._open = np.concatenate((self._open, ticks16))
        return True

    def _fit(self, ticks16: NDArray[np.int64]) -> None:
        """Fit records to the open steps and the new ones; the last record remains open."""
        import numpy as np

        steps = np.concatenate((self._open, ticks16))
        limits = {"tolerance": TOLERANCE_TICKS << 16, "shortest": self.shortest}
        *whole, self._record = fit(steps, self.base16, **limits, flags=self._flags, even=self._ramp_left >= 0)
        for record in whole:
            self._push(record)
        self._open = steps[len(steps) - self._record.count :]

    def _queue_output(self, output: PlannedOutput) -> bool:
        """Queue an output change in a pause, or pass it to `put`; return False while an unknown step may precede it."""
        if not self.running:
            self._put(output)
            return True
        following = next((int(item.ticks16[0]) for item in self._items if isinstance(item, PlannedSteps)), None)
        if following is None and self._present16 < output.tick16:
            return False
        self._close()
        at = max(output.tick16, self.base16 + LEAST_PAUSE)
        if following is not None:
            at = min(at, following - self._margin16)
        if at - self.base16 < LEAST_PAUSE:
            self._put(output)
        else:
            self._pause(at, OUT, output.mask << 8 | output.value)
        return True

    def _keep_up(self, tick: int) -> None:
        """Push the records that the board needs soon, and fill its queue up to the current time of the model."""
        if not self.running or self._items:
            return
        if not self.axis.moving:
            self._close()
            rest16 = self.base16 + (REST_TICKS << 16) + 0xFFFF >> 16 << 16
            if not self._rested and rest16 <= self._present16:
                self._pause(rest16, REST)
                self._rests.append(rest16 >> 16)
                self._rested = True
        elif self._low(tick):
            self._close()
            if self._low(tick) and self._present16 - self.base16 >= LEAST_PAUSE:
                self._pause(self._present16)

    def _low(self, tick: int) -> bool:
        """Return whether the board's queue ends less than three quarters of the horizon after its current tick."""
        return (self.base16 >> 16) - tick < 3 * self.horizon // 4

    def _close(self) -> None:
        """Push the open record."""
        if len(self._open):
            self._open = self._none
            self._push(self._record)

    def _pause(self, end16: int, flag: int = 0, count: int = 0) -> None:
        """Push a pause that ends at a tick, in 1/65536 tick."""
        interval = end16 - self.base16
        self._batch.append(Record(self._flags | PAUSE | flag, count, interval >> 16, interval & 0xFFFF, 0))
        self.base16 = end16
        self._interval16, self._rested = 0, False

    def _push(self, record: Record) -> None:
        """Push a record of steps, with the length of its stop ramp if that is known."""
        if self._ramp_left < 0:
            self._batch.append(record)
        else:  # at fast steps a brake makes one more step, so the ramp is one step shorter
            more = 1 + self._slope if record.interval < FAST_TICKS else 0
            self._batch.append(record.with_ramp_left(max(self._ramp_left - more, 0), self._slope))
            self._ramp_left += self._slope * record.count
        self.base16 += record.length
        self._interval16, self._add = record.last + record.add, record.add

    def _send(self) -> None:
        """Pass the records queued in this turn on to the link."""
        batch, self._batch = self._batch, []
        self.records += len(batch)
        if batch and self._start is not None:
            self.wake()
            self.link.push(batch[:FIRST_RECORDS])
            self.link.start(self._start)
            self.started, self._start, batch = self._start, None, batch[FIRST_RECORDS:]
        if batch:
            self.link.push(batch)
