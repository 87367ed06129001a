"""The electronic gear of one axis: the axis follows another machine's encoder, according to the gear ratio."""

from __future__ import annotations

from ....core.context import ChipContext
from ..profiles.cycle_train import Linear
from ..profiles.ideal import begins
from ..profiles.profile import CycleRun
from ..registers import NEGATIVE_LIMIT, ONE, POSITIVE_LIMIT, AxisState
from .feedback import Feedback
from .generator import ProfileGenerator
from .switches import LimitSwitches


class ElectronicGear:
    """The gear, which makes the axis follow the counts of its encoder input.

    A stop, a limit switch, or switching the motor off suspends the gear until an update (`suspended`).
    """

    def __init__(
        self,
        chip: ChipContext,
        state: AxisState,
        generator: ProfileGenerator,
        feedback: Feedback,
        switches: LimitSwitches,
    ) -> None:
        self.chip, self.state, self.generator, self.pulses = chip, state, generator, generator.pulses
        self.feedback, self.switches = feedback, switches
        self.at_rest = chip.drivers[f"atrest{state.number}"]

    def begin(self) -> None:
        """Begin after a reset, with no displacement left to follow."""
        self.followed = self.backlog = 0  # counts so far, deferred displacement
        self.suspended = False

    @property
    def is_lagging(self) -> bool:
        """True while the axis still has to follow some counts, or a deferred displacement."""
        return bool(self.backlog or self.followed != self.feedback.counts)

    def enter(self, cause: str) -> None:
        """Enter the gear mode by the command `cause`; the axis follows all changes from the present count."""
        self.followed, self.backlog = self.feedback.counts, 0
        self.suspended = self.state.awaits_update or self.switches.flagged
        self.set_out(cause)

    def update(self, cause: str) -> None:
        """Resume the gear from the present counts at an update, unless a limit has tripped or the motor is off."""
        if self.suspended and not self.state.awaits_update and not self.switches.flagged:
            self.suspended = False
            self.followed = self.feedback.counts
        self.set_out(cause)

    def set_out(self, cause: str) -> None:
        """Log the beginning of a motion; if the gear is suspended, also log the immediate end of this motion."""
        begins(self.chip, self.state, cause, 0, self.generator.pulse_range)
        if self.suspended:
            self.generator.log.end("limit" if self.switches.flagged else "cut")

    def follow(self, n: int) -> None:
        """Move the axis in cycle `n` by the new encoder counts times the gear ratio.

        In each cycle, the axis moves no further than the pulse range allows; the rest of the displacement follows
        in later cycles.  A displacement towards an active limit switch is dropped; so are all counts while the
        gear is suspended.
        """
        state, pulses, counts = self.state, self.pulses, self.feedback.counts
        new, self.followed = counts - self.followed, counts
        if self.suspended or self.feedback.encoder is None:
            self.backlog = displaced = 0
        else:
            waited, range_ = self.backlog, self.generator.pulse_range
            self.backlog += new * state.active.ratio
            displaced = max(min(self.backlog, range_), -range_)
            ahead = POSITIVE_LIMIT if displaced > 0 else NEGATIVE_LIMIT
            if displaced and self.switches.active(ahead):
                self.backlog = displaced = 0
            self.backlog -= displaced
            if self.backlog and not waited:
                text = f"axis {state.number}: the encoder exceeds the pulse range; the missing steps follow later"
                self.chip.finding("gear-backlog", text)
        pulses.cut(n)
        state.velocity = displaced
        if displaced:
            pulses.sign = 1 if displaced > 0 else -1
            self.generator.schedule(n, Linear(abs(displaced)), CycleRun(1, abs(displaced)))
        stepped = pulses.sign * pulses.lead + abs(displaced) >= ONE
        rest = self.at_rest.level_when(not stepped)
        if self.at_rest.next != rest:
            self.at_rest.drive(rest)
