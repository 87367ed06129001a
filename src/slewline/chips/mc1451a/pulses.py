"""The run of an axis in progress: what it makes of the registers, and the pulses that it promises.

A displacement chosen once often follows a law for thousands of cycles: a run.  Its pulses are promised whole, its
position is computed when somebody asks.  When it is cut, what it has left behind (part of a step, PULSE high or low) is
what the next one begins with.

    target    x0 ____----^^^^          x    PULSE rises where the target passes half a step, and falls, which is the
              |   run        | cut          step, where it passes a whole one
    cycle     since          n              lead: how far the target is beyond what has been emitted

Positions and displacements are in 1/65536 step.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from ...core.curves import SCurve
from ...core.cycles import CycleTrain, Law, SquareView
from ...core.history import History
from ...core.train import Playing
from ...errors import PlanError
from .enc import FilteredInput, QuadratureCounter
from .profile import Limits, Phases, Run
from .sheet import CYCLE_TICKS, HIGH_RANGE, STANDARD_RANGE
from .state import GEAR, NEGATIVE_LIMIT, ONE, POSITIVE_LIMIT, TRAPEZOIDAL, WRAPPED, AxisState, signed
from .verified import fault_of_curve, fault_of_run

if TYPE_CHECKING:
    from .motion import Motion

HALF = ONE // 2
RANGE = 1 << 47  # of the target: 2^31 steps


class Past(NamedTuple):
    """From cycle `first` on the target goes as a law says, from `x0` in cycle `since`; without a law it stays there.

    The law of an S-curve comes from its phases; other laws change by no more than an acceleration, but for jumps.
    """

    first: int
    since: int
    x0: int
    sign: int
    law: Law | None
    curve: Phases | None = None
    acceleration: int = 0


class Pulses:
    """One axis, and its run."""

    def __init__(self, motion: Motion, state: AxisState) -> None:
        self.motion, self.chip = motion, motion.chip
        self.kernel, self.state = motion.kernel, state
        chip = self.chip
        n = state.number
        self.axis = chip.axes[n - 1]
        self.pulse, self.dir, self.atrest = (chip.drivers[f"{name}{n}"] for name in ("pulse", "dir", "atrest"))
        self.home = FilteredInput(chip.pins[f"home{n}"], chip.clock)
        self.encoder: QuadratureCounter | None = None
        if chip.encoder:
            a, b = chip.pins[f"quada{n}"], chip.pins[f"quadb{n}"]
            self.encoder = QuadratureCounter(a, b, chip.clock, chip.finding)
        self.offsets = History()  # actual position minus counts
        self.past: list[Past] = []
        self.waiting: list[Callable[[], object]] = []  # for the next round
        self.axis.on_forget.add(self.forget)

    def begin(self, state: AxisState) -> None:
        """Reset is over: cycle 0 is due."""
        self.state = state
        self.home.begin()
        if self.encoder is not None:
            self.encoder.begin()
        self.mode = TRAPEZOIDAL  # in force
        self.aim = ""  # what moves the axis: point, curve, contour, stop; empty at rest
        self.limits = Limits(0, 0, 0)
        self.start_velocity = 0  # in force since the start from rest
        self.phases = Phases(1, 0, 0, 0, 0, 0, 0)
        self.done = 0  # cycles of an S-curve that were over when the run began
        self.since, self.cycles, self.landing = 0, 0, False
        self.law: Law | None = None  # the run, if there is one: its displacements
        self.sign = 1
        self.x0 = 0  # target at the start of the run; not wrapped within it
        self.turn = 0  # how often the run has wrapped
        self.lead, self.high = 0, False  # target minus emitted position, and PULSE, at the start of the run
        self.past = [Past(0, 0, 0, 1, None)]
        self.surplus = 0  # of the lead: what the pulses of this cycle have, but the target no longer
        self.playing: Playing | None = None
        self.fresh = False  # decide anew in step 3, run or no run
        self.was_off = False  # since the last cycle that was worked: the motor
        self.clamped = self.high_speed = False
        self.armed = {POSITIVE_LIMIT: True, NEGATIVE_LIMIT: True}
        self.counts = self.error8 = self.whole = 0  # encoder; error * 256; whole steps that it knows of
        self.offset = 0  # actual position minus counts
        self.offsets.note(self.kernel.now, 0)
        self.followed = self.backlog = 0  # gear: counts followed so far, displacement that waits
        self.suspended = False
        self.due = 0

    @property
    def range(self) -> int:
        """The greatest speed of the pulse range."""
        return (HIGH_RANGE if self.state.high_speed else STANDARD_RANGE) * ONE

    def sync(self, n: int) -> None:
        """Let the registers show cycle n, in which nothing is decided."""
        self._move(n)
        self._read_encoder(n)

    def _move(self, n: int) -> None:
        """Where the run has come to at the start of a cycle, and how fast: behind its end, how fast it was."""
        state, law = self.state, self.law
        if law is None:
            return
        i = n - self.since
        going = min(i, self.cycles - 1)
        state.velocity = self.sign * law.velocity(going)
        if isinstance(law, SCurve):
            state.phase = law.phase(going)
        self._show(self.x0 + self.sign * law.travel(i))

    def _show(self, x: int) -> None:
        """The target, and whether it has wrapped."""
        turn = (x + RANGE // 2) // RANGE
        if turn != self.turn:
            self.turn = turn
            self.state.events |= WRAPPED
            self.fresh |= self.aim == "point"  # the destination lies elsewhere now
        self.state.target = x - turn * RANGE

    def _read_encoder(self, n: int) -> None:
        """Counts up to the start of a cycle, and the position error."""
        state, encoder = self.state, self.encoder
        if encoder is None:
            return
        counts = encoder.counts_before(self.motion.tick(n))
        whole = (self.state.target + self.turn * RANGE) // ONE
        self.error8 += (counts - self.counts) * 256 - state.step_ratio * (whole - self.whole)
        self.counts, self.whole = counts, whole
        state.actual = signed(counts + self.offset, 31)
        state.error = self.error8 >> 8

    def cut(self, n: int) -> None:
        """End the run here: note where it has come to."""
        if self.law is None:
            return
        y = self.sign * self.lead + self.law.travel(n - self.since)
        steps = max(y // ONE, 0)
        rest = y - steps * ONE
        self.high = rest >= HALF or (self.high and not steps)
        self.lead = self.sign * rest - self.surplus
        self.law, self.surplus = None, 0
        self._base()
        self.remember(n)
        if self.playing is not None:
            self.playing.until = self.kernel.now + 1
            self.pulse.renew()
            self.playing = None

    def remember(self, n: int) -> None:
        """Keep what begins with cycle n, for who asks later."""
        curve = self.phases if isinstance(self.law, SCurve) else None
        acceleration = 0 if self.mode == GEAR else self.limits.acceleration
        entry = Past(n, self.since, self.x0, self.sign, self.law, curve, acceleration)
        if self.past[-1].first == n:
            self.past[-1] = entry
        else:
            self.past.append(entry)

    def forget(self, before: int) -> None:
        """Nobody asks for the cycles before an instant any more."""
        cycle = (self.chip.clock.ticks_until(before) - self.chip.origin) // CYCLE_TICKS
        self.offsets.forget(before)
        if self.encoder is not None:
            self.encoder.history.forget(self.chip.clock.ticks_until(before))
        del self.past[: max(bisect_right(self.past, cycle, key=lambda entry: entry.first) - 1, 0)]

    def _base(self) -> None:
        """Count from the target as it is, which lies within its range."""
        self.whole -= self.turn * (RANGE // ONE)
        self.x0, self.turn = self.state.target, 0

    def end(self) -> None:
        """Reset: whatever is promised ends with this instant."""
        self.law = None
        self.waiting.clear()
        if self.playing is not None:
            self.playing.until = self.kernel.now + 1
            self.pulse.renew()
            self.playing = None

    def lay(self, n: int, planned: tuple[Law, Run]) -> None:
        """Begin a run with cycle n; its pulses follow when whatever belongs to this instant is over."""
        law, run = planned
        sign = self.sign
        self.verify(n, law, run)
        self.cut(n)
        self.sign, self.law = sign, law
        self.since, self.cycles, self.landing = n, run.cycles, run.landing
        self._move(n)
        self.remember(n)
        if run.speed or isinstance(law, SCurve):
            self.soon(lambda: self.play(law))

    def verify(self, n: int, law: Law, run: Run) -> None:
        """Check a run once, before anything is promised.

        Raises:
            PlanError: the law of motion made a mistake (never the host).
        """
        state, before = self.state, abs(self.state.velocity)
        if self.mode == GEAR:  # it follows another machine, whatever that does
            fault = "" if run.speed <= self.range else f"displaces {run.speed}; allowed {self.range}"
        elif isinstance(law, SCurve):
            fault = fault_of_curve(law, run, self.phases, before)
        else:
            remaining = self.sign * (state.active.position * ONE - state.target)
            fault = fault_of_run(law, run, self.limits, before, remaining)
        if fault:
            raise PlanError(f"{self.chip.name} axis {state.number}, cycle {n}: {run} does not hold together: {fault}")

    def soon(self, what: Callable[[], object]) -> None:
        """Do something in the next round, when the old pulses of this instant are over; one thing after the other."""
        if not self.waiting:
            self.kernel.call_at(self.kernel.now, self._do)
        self.waiting.append(what)

    def _do(self) -> None:
        waiting, self.waiting = self.waiting, []
        for what in waiting:
            what()

    def play(self, law: Law) -> None:
        """Promise the pulses of a run, unless a reset in this very instant has ended it."""
        if self.law is not law:
            return
        train = CycleTrain(self.chip.clock, self.motion.tick(self.since), law, self.cycles, self.sign * self.lead)
        self.playing = Playing(train)
        self.axis.follow(self.playing, self.sign)
        if self.dir.next != int(self.sign > 0):
            self.dir.drive(int(self.sign > 0))
        self.pulse.play(SquareView(self.playing, self.high))

    def declare(self, n: int, value: int) -> None:
        """The target is a whole number of steps from now on, the position error zero; the pulses of cycle n go on."""
        state, law = self.state, self.law
        state.target = value * ONE
        if law is None:
            self.lead = 0
            self._base()
        else:
            travelled = law.travel(n - self.since)
            y = self.sign * self.lead + travelled
            self.surplus = self.sign * (y - max(y // ONE, 0) * ONE)
            self.x0, self.turn = value * ONE - self.sign * travelled, 0
            self.fresh = True
        self.remember(n)
        self.whole, self.error8, state.error, state.motion_error = value, 0, 0, False
        if self.encoder is not None:
            self.offset += value - state.actual
            self.offsets.note(self.chip.clock.ps(self.motion.tick(n)), self.offset)
            state.actual = value
        self.soon(lambda: self._load(n, value))

    def _load(self, n: int, value: int) -> None:
        """The emitted position becomes this, and what has been emitted since cycle n began."""
        if self.playing is not None:
            begun = self.playing.begun(self.kernel.now) - self.playing.begun(self.chip.clock.ps(self.motion.tick(n)))
            value += self.sign * begun
        self.axis.load(signed(value, 31))
