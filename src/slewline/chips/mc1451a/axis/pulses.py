"""An axis's run in progress: its effect on the registers, and the pulses that it promises.

Often the displacements of thousands of successive cycles follow a single law; such cycles are a run.
The pulses of a run are promised all together, and the position in the run is computed on request.  When
a run is cut short, the next run starts from its remainder: the part of a step that was not emitted, and
the level of PULSE.

    target    x0 ____----^^^^          x    PULSE rises where the target passes half a step; where
              |   run        | cut          it passes a whole step, PULSE falls: this is the step
    cycle     since          n              lead: the distance of the target beyond the emitted position

Positions and displacements are in 1/65536 step.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from typing import NamedTuple

from ....core.context import ChipContext
from ....core.motion.train import Playing
from ..cycle_clock import CycleClock
from ..profiles.cycle_train import CycleTrain, Law, SquareView
from ..profiles.profile import CycleRun, Phases
from ..profiles.s_curves import SCurve
from ..registers import ONE, WRAPPED, AxisState, signed

HALF = ONE // 2
RANGE = 1 << 47  # of the target: 2^31 steps


class TargetLaw(NamedTuple):
    """The law that an axis's target follows from cycle `first` on; `law` is None at rest.

    `law` counts its cycles from cycle `since`, and its distances from `x0`, the target at the start of that
    cycle.  `curve` holds the phases of an S-curve.  Under any other law, `acceleration` is the maximum
    change of speed per cycle; only a jump in speed, such as a start velocity, may exceed it.
    """

    first: int
    since: int
    x0: int
    sign: int
    law: Law | None
    curve: Phases | None = None
    acceleration: int = 0


class Pulses:
    """One axis's run, and its promised pulses.

    `law` is the law of the run's displacements, None at rest; `sign` is the run's direction.  `acceleration`
    is the maximum change of speed from one cycle to the next under that law; it is kept for later queries.
    """

    def __init__(self, chip: ChipContext, state: AxisState, cycle_clock: CycleClock) -> None:
        self.kernel, self.clock, self.cycle_clock, self.state = chip.kernel, chip.clock, cycle_clock, state
        n = state.number
        self.axis = chip.axes[n - 1]
        self.pulse, self.dir = chip.drivers[f"pulse{n}"], chip.drivers[f"dir{n}"]
        self.past: list[TargetLaw] = []
        self.waiting: list[Callable[[], object]] = []  # for the next round
        self.axis.on_forget.add(self.forget)

    def begin(self) -> None:
        """Begin at rest after reset."""
        self.law: Law | None = None
        self.since, self.cycles, self.landing = 0, 0, False
        self.sign = 1
        self.x0 = 0  # target at the start of the run; not wrapped within it
        self.turn = 0  # number of wraps of the run
        self.rounds = 0  # number of wraps of the target since a position was declared
        self.lead, self.high = 0, False  # target minus emitted position, and PULSE, at the start of the run
        self.surplus = 0  # part of the lead: output in this cycle for a target declared again since
        self.curve: Phases | None = None
        self.acceleration = 0
        self.past = [TargetLaw(0, 0, 0, 1, None)]
        self.playing: Playing | None = None

    def move(self, n: int) -> bool:
        """Set the target and the velocity at the start of cycle `n`; return whether the target has wrapped.

        The target has a range of 2^31 steps, and wraps at its ends.  If the run is already over, the velocity is
        that of the run's last cycle.
        """
        state, law = self.state, self.law
        if law is None:
            return False
        i = n - self.since
        going = min(i, self.cycles - 1)
        state.velocity = self.sign * law.velocity(going)
        if isinstance(law, SCurve):
            state.phase = law.phase(going)
        x = self.x0 + self.sign * law.travel(i)
        turn = (x + RANGE // 2) // RANGE
        state.target = x - turn * RANGE
        if turn == self.turn:
            return False
        self.rounds += turn - self.turn
        self.turn = turn
        state.events |= WRAPPED
        return True

    def cut(self, n: int) -> None:
        """End the run at the start of cycle `n`, and keep its final state as the start of the next run."""
        if self.law is None:
            return
        y = self.sign * self.lead + self.law.travel(n - self.since)
        steps = max(y // ONE, 0)
        rest = y - steps * ONE
        self.high = rest >= HALF or (self.high and not steps)
        self.lead = self.sign * rest - self.surplus
        self.law, self.curve, self.surplus = None, None, 0
        self.x0, self.turn = self.state.target, 0
        self.remember(n)
        self._withdraw()

    def _withdraw(self) -> None:
        """Withdraw the promised pulses that come after this instant."""
        if self.playing is not None:
            self.playing.until = self.kernel.now + 1
            self.pulse.renew()
            self.playing = None

    def remember(self, n: int) -> None:
        """Record the law that holds from cycle n, for later queries."""
        entry = TargetLaw(n, self.since, self.x0, self.sign, self.law, self.curve, self.acceleration)
        if self.past[-1].first == n:
            self.past[-1] = entry
        else:
            self.past.append(entry)

    def forget(self, before: int) -> None:
        """Discard the laws of the cycles before an instant (ps); no query needs them any more."""
        cycle = self.cycle_clock.cycle_at(before)
        del self.past[: max(bisect_right(self.past, cycle, key=lambda entry: entry.first) - 1, 0)]

    def end(self) -> None:
        """Handle a reset: load any position declared at this instant, then withdraw the pulses after this instant."""
        self.law = None
        self._do()
        self._withdraw()

    def schedule(self, n: int, law: Law, run: CycleRun, curve: Phases | None = None) -> None:
        """Begin a run with cycle `n`; its pulses are promised after all other work of this instant.

        Args:
            curve: the phases of an S-curve; None for any other law.
        """
        sign = self.sign
        self.cut(n)
        self.sign, self.law, self.curve = sign, law, curve
        self.since, self.cycles, self.landing = n, run.cycles, run.landing
        self.move(n)
        self.remember(n)
        if run.speed or curve is not None:
            self.soon(lambda: self.play(law))

    def soon(self, what: Callable[[], object]) -> None:
        """Call a function in the next round of this instant, after the last edges of the previous run's pulses.

        Several functions are called in the order in which they were requested.
        """
        if not self.waiting:
            self.kernel.call_at(self.kernel.now, self._do)
        self.waiting.append(what)

    def _do(self) -> None:
        waiting, self.waiting = self.waiting, []
        for what in waiting:
            what()

    def play(self, law: Law) -> None:
        """Promise the pulses of a run, unless a reset at this instant has ended it."""
        if self.law is not law:
            return
        train = CycleTrain(self.clock, self.cycle_clock.tick(self.since), law, self.cycles, self.sign * self.lead)
        self.playing = Playing(train)
        self.axis.follow(self.playing, self.sign)
        if self.dir.next != int(self.sign > 0):
            self.dir.drive(int(self.sign > 0))
        self.pulse.play(SquareView(self.playing, self.high))

    def declare(self, n: int, value: int) -> None:
        """Set the target to `value` whole steps immediately; the pulses of cycle `n`, now in progress, continue."""
        state, law = self.state, self.law
        state.target = value * ONE
        self.turn = self.rounds = 0
        if law is None:
            self.lead, self.x0 = 0, state.target
        else:
            travelled = law.travel(n - self.since)
            y = self.sign * self.lead + travelled
            self.surplus = self.sign * (y - max(y // ONE, 0) * ONE)
            self.x0 = state.target - self.sign * travelled
        self.remember(n)
        self.soon(lambda: self._load(n, value))

    def _load(self, n: int, value: int) -> None:
        """Set the emitted position to `value`, plus the steps emitted since cycle `n` began."""
        if self.playing is not None:
            begun = self.playing.count(self.kernel.now) - self.playing.count(self.cycle_clock.ps(n))
            value += self.sign * begun
        self.axis.load(signed(value, 31))
