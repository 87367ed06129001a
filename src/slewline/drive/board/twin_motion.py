r"""The step-by-step motion of a board: records, brake and tail, reflexes and outputs, and their events.

When a board brakes, it first sends the step that is already scheduled (after an underrun there is none).
If the following step is less than 640 ticks later, the board sends this step, too.  Then it sends the
tail: steps from the table that the host sent last.  The number of tail steps, and the first entry used,
follow from the record of the scheduled step, if that record has WAY (RAMP_LEFT in records.py).  WAY is
the number of steps in the stop ramp; it changes by -1, 0 or 1 with each step.  So a board ramps down
from any step as the emulated chip would, without knowing how the chip computes its ramps:

    rate        ________
              _/        \_           up          part of the table, longer with each step or level
            _/            \_         at the top  the whole table
           /                \        down        the rest of the plan's stop ramp, shorter with each step
    WAY    0 1 2 .. N N N .. 2 1 0

    table    (i0, 3) (i1, 2) (i2, 4)    WAY 5  ->  i1 i2 i2 i2 i2, the last five steps; WAY 0 -> no steps

A table interval that is shorter than the last interval made is lengthened to it: a brake does not
accelerate the motor.  If the last interval is less than 640 ticks, the next one is at least 1/8 longer,
to give the board time.  After the first step of a run there is no stop ramp.

If the record has no WAY (motions that begin while the motor moves, ramps without levels, pauses), the
rate decides: the tail consists of all entries with intervals longer than the last one made; without a
table, each interval is 1/16 longer than the previous one, up to the interval at which the motor may
stop.

Ticks are whole numbers that do not wrap; on the wire they are modulo 2^32.  Times that a twin cannot
know are inputs: when the main loop takes a frame, when it sees an input edge, when it checks for
silence.
"""

from __future__ import annotations

from collections import deque

from . import wire
from .boards import FAST_TICKS, SOONEST_TICKS, BoardModel
from .records import DOWN, HALF, OUT, PAUSE, REST, Record
from .twin_power import TwinPower
from .wire import ENABLE, HOST, BoardConfig, BoardEvent, BoardState, DriverFlag, Happening, Reflex

IDLE, RUN, BRAKE, HALT, BOOT = BoardState
KEPT_EVENTS = 8


class MovingTwin:
    """The part of a simulated board that works without the host: steps, phases, outputs and events.

    All of them are recorded with their ticks: the events as frames in `sent`, the others in the lists
    `steps`, `phases` and `outputs`.

    Attributes:
        pulses: the ticks of the steps that produce an edge on STEP; there are none in a dry run.
    """

    def __init__(self, model: BoardModel) -> None:
        self.model = model
        self.steps: list[tuple[int, int, int]] = []
        self.pulses: list[int] = []
        self.phases: list[tuple[int, int]] = []
        self.outputs: list[tuple[int, int]] = []
        self.enable: list[tuple[int, int | None]] = []
        self.sent = bytearray()
        self.inputs = 0x3F  # levels; open inputs are high
        self.power_up()

    def power_up(self, tick: int = 0) -> None:
        """Clear everything except the input levels; the ticks restart at `tick`, and event 0 reports the power-up."""
        self.now = tick
        self.sent.clear()
        self.state: BoardState = BOOT
        self.position = self.output = self.phase = self.index = 0
        self._shown: tuple[int, int | None] = (0, None)
        self.power = TwinPower(lambda on, at: self._set_outputs(ENABLE, ENABLE * on, at))
        self.config = BoardConfig(0)
        self.queue: deque[Record] = deque()
        self.table: list[tuple[int, int]] = []
        self._events: deque[bytes] = deque(maxlen=KEPT_EVENTS)
        self._event = 0  # number of the next one
        self._forget_the_run()
        self._report_event(Happening.BOOT, HOST, tick)

    def _forget_the_run(self) -> None:
        self.queue.clear()
        self.record: Record | None = None  # the present record, or the last one before a tail
        self.left = 0  # its remaining steps
        self.time = self.interval = 0  # 1/65536 tick: last instant, and interval to the next one
        self.last_step: int | None = None  # of this run
        self.pace: int | None = None
        self.tail: deque[int] | None = None  # ticks of the remaining steps, once known
        self.one_more = False  # step after the scheduled one, before the tail begins

    def run(self, tick: int) -> None:
        """Run up to and including a tick."""
        while (at := self.next_time()) is not None and at <= tick:
            self.now = at
            self._happen(at)
            self._show(at)
        self.now = max(self.now, tick)

    def next_time(self) -> int | None:
        """Return the tick of the next step, or of the end of a pause; None if there is none."""
        if self.state == BRAKE and self.tail is not None:
            return self.tail[0]
        if self.state in (RUN, BRAKE):
            return (self.time + self.interval) >> 16
        return None

    def set_input(self, number: int, level: int, tick: int) -> None:
        """Sample the level of an input at a tick.

        If several inputs change at the same time, call this for each of them, in order of `number`.
        """
        self.run(tick)
        if self.inputs >> number & 1 == bool(level):
            return
        self.inputs ^= 1 << number
        before = self._event
        self._edge(number, tick)
        if self._event == before and self.config.report >> number & 1:
            self._report_event(Happening.INPUT, number, tick)
        self._show(tick)

    # ------------------------------------------------------------------------------------------------------- motion
    def _load(self) -> None:
        """Load the next record, which begins at `time`."""
        record = self.record = self.queue.popleft()
        self.left, self.interval = record.count, record.first
        if record.flags & PAUSE and self.last_step is not None:
            end = (self.time + record.first) >> 16
            if end - self.last_step >= self.config.start_stop:
                self.pace = self.last_step = None  # the motor is at rest: the next step is the first one of a run

    def _happen(self, tick: int) -> None:
        """Execute the step, or the end of a pause, that is due at a tick."""
        assert self.record is not None  # noqa: S101
        if self.tail is not None:
            self.tail.popleft()
            self._step(tick)
            if not self.tail:
                self._halt()
                self._report_event(Happening.HALTED, HOST, tick)
            return
        self.time += self.interval
        if not self.record.flags & PAUSE:
            self._step(tick)
            self.interval += self.record.growth
            self.left -= 1
            if self.state == BRAKE and self.one_more:
                self.one_more = False
            elif self.state == BRAKE:
                self._begin_tail(tick, tick)
                if not self.tail:
                    self._halt()
                    self._report_event(Happening.HALTED, HOST, tick)
                return
            if self.left:
                return
        elif self.record.flags & OUT:
            self._set_outputs(self.record.count >> 8, self.record.count & 255, tick)
        self._next_record(tick)

    def _next_record(self, tick: int) -> None:
        """Load the next record after one that ended at a tick; if there is none, come to rest, or brake (underrun)."""
        before = self.record
        assert before is not None  # noqa: S101
        if self.queue:
            self._load()
            assert self.record is not None  # noqa: S101
            if (before.flags ^ self.record.flags) & DOWN:
                for number in self._active():
                    if self._is(Reflex.STOP, number) or self._is(Reflex.BRAKE, number):
                        self._active_edge(number, tick)
        elif before.flags & REST:
            self._forget_the_run()
            self.state = IDLE
            self._report_event(Happening.REST, HOST, tick)
        else:
            self._brake(Happening.UNDERRUN, HOST, tick)

    def _step(self, tick: int) -> None:
        assert self.record is not None  # noqa: S101
        direction = -1 if self.record.flags & DOWN else 1
        self.position = (self.position + direction + 2**31) % 2**32 - 2**31
        self.steps.append((tick, direction, self.position))
        if not self.config.driver & DriverFlag.DRY:
            self.pulses.append(tick)
        self.pace = None if self.last_step is None else tick - self.last_step
        self.last_step = tick
        self.index = (self.index + direction * (1 if self.record.flags & HALF else 2)) % wire.PHASES
        self._set_phases(tick)

    def _brake(self, kind: Happening, which: int, tick: int) -> None:
        """Begin to ramp down to a halt along the tail, and report the cause; called in the state RUN."""
        assert self.record is not None  # noqa: S101
        playing = not self.record.flags & PAUSE and self.left
        if playing:
            self.state = BRAKE  # the step that is scheduled is made, then the tail begins
            self.one_more = self._following() < FAST_TICKS
        elif self.last_step is not None:
            # after the last step of a record, the first step of the tail may be near; in and after a pause it may not
            earliest = tick + SOONEST_TICKS if self.record.flags & PAUSE else tick
            self._begin_tail(self.last_step, earliest)
            self.state = BRAKE
        if not playing and not self.tail:
            self._halt()
        self._report_event(kind, which, tick)

    def _following(self) -> int:
        """Return the number of ticks from the scheduled step to the next one.

        It is 2^31 if no step follows in the same direction.
        """
        assert self.record is not None  # noqa: S101
        if self.left > 1:
            return (self.interval + self.record.growth) >> 16
        if not self.queue or self.queue[0].flags & PAUSE or (self.queue[0].flags ^ self.record.flags) & DOWN:
            return 2**31
        return self.queue[0].interval

    def _begin_tail(self, last_step: int, earliest: int) -> None:
        """Schedule the tail, timed from the last step; if its first step is before `earliest`, delay all its steps."""
        ticks = [last_step + each for each in self._stop_ramp()]
        late = max(0, earliest - ticks[0]) if ticks else 0
        self.tail = deque(each + late for each in ticks)

    def _stop_ramp(self) -> list[int]:
        """Return the times of the tail steps, in ticks after the last step made."""
        pace, start_stop = self.pace, self.config.start_stop
        out, time = [], 0
        ramp_left = None if self.record is None else self.record.ramp_left(self.record.count - self.left - 1)
        if pace is None or ramp_left == 0:
            return []
        least = pace + pace // 8 if pace < FAST_TICKS else pace
        if ramp_left is not None and self.table:
            for interval in [interval for interval, count in self.table for _ in range(count)][-ramp_left:]:
                time += max(interval, least << 8)
                out.append(time >> 8)
            return out
        if pace >= start_stop:
            return []
        if self.table:
            first = next((at for at, (interval, _) in enumerate(self.table) if interval > least << 8), len(self.table))
            for interval, count in self.table[first:]:
                for _ in range(count):
                    time += interval
                    out.append(time >> 8)
            return out
        while (pace := pace + (pace >> 4)) <= start_stop:
            time += pace
            out.append(time)
        return out

    def _halt(self) -> None:
        self._forget_the_run()
        self.state = HALT

    # ------------------------------------------------------------------------------------------------------- inputs
    def _active(self) -> list[int]:
        """Return the numbers of the inputs that are active."""
        levels = ~(self.inputs ^ self.config.active)
        return [number for number in range(wire.INPUTS) if levels >> number & 1]

    @property
    def estop(self) -> bool:
        """True while an emergency stop input is active."""
        return any(self._is(Reflex.ESTOP, each) for each in self._active())

    def _is(self, reflex: Reflex, number: int) -> bool:
        return self.config.reflex[number] & 15 == reflex

    def _fits(self, number: int) -> bool:
        """Return whether the reflex of an input applies to the direction of the present record."""
        directions = self.config.reflex[number] & (Reflex.UPWARDS | Reflex.DOWNWARDS)
        down = self.record is not None and self.record.flags & DOWN
        return not directions or bool(directions & (Reflex.DOWNWARDS if down else Reflex.UPWARDS))

    def _edge(self, number: int, tick: int) -> None:
        if self.state == BOOT:
            return
        if number in self._active():
            self._active_edge(number, tick)

    def _active_edge(self, number: int, tick: int, *, starting: bool = False) -> None:
        reflex = self.config.reflex[number] & 15
        if reflex == Reflex.ESTOP:
            self.power.cut(self.state in (RUN, BRAKE), self.now)
            self._halt()
            self._report_event(Happening.ESTOP, number, tick)
        elif reflex == Reflex.STOP and self.state in (RUN, BRAKE) and self._fits(number):
            self._halt()
            self._report_event(Happening.STOPPED, number, tick)
        elif reflex == Reflex.BRAKE and self.state == RUN and self._fits(number):
            self._brake(Happening.BRAKED, number, tick)
        elif reflex == Reflex.MARK and not starting:
            self._report_event(Happening.MARK, number, tick)

    # ------------------------------------------------------------------------------------------------------- outputs
    def _set_outputs(self, mask: int, value: int, tick: int) -> None:
        self.output = self.output & ~mask | value & mask
        self.power.on = bool(self.output & ENABLE)
        self._show(tick)

    def _show(self, tick: int) -> None:
        """Update the pins: outputs, lamps and ENABLE."""
        config, (outputs, level) = self.config, self._shown
        fault, power = 1 << config.fault_output >> 1, 1 << config.power_output >> 1
        output = self.output & ~(fault | power) | fault * (self.state in (HALT, BOOT)) | power * self.power.on
        now = int(self.power.on) ^ config.polarity >> 1 if config.driver & DriverFlag.ENABLE else None
        if output != outputs:
            self.outputs.append((tick, output))
        if now != level:
            self.enable.append((tick, now))
        self._shown = output, now

    def _set_phases(self, tick: int) -> None:
        phase = 0 if self.config.driver & DriverFlag.DRY else self.config.pattern[self.index] & 15
        if phase != self.phase:
            self.phase = phase
            self.phases.append((tick, phase))

    def _report_event(self, kind: Happening, which: int, tick: int, position: int | None = None) -> None:
        position = self.position if position is None else position
        event = BoardEvent(self._event % 256, kind, which, self.state, self.inputs, position, tick)
        self._event += 1
        frame = wire.event_frame(event)
        self._events.append(frame)
        self.sent += frame
