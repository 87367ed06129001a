"""The electronic gear of one axis: another machine's encoder displaces the axis by the gear ratio."""

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
    """The gear, which follows encoder counts.

    A stop, a limit switch or the motor can suspend it until an update (`suspended`).
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
        """Begin without a displacement to follow, after reset."""
        self.followed = self.backlog = 0  # counts so far, deferred displacement
        self.suspended = False

    @property
    def is_lagging(self) -> bool:
        """True if some displacement is left to follow."""
        return bool(self.backlog or self.followed != self.feedback.counts)

    def enter(self, cause: str) -> None:
        """Change to the gear mode, starting from the present counts."""
        self.followed, self.backlog = self.feedback.counts, 0
        self.suspended = self.state.awaits_update or self.switches.flagged
        self.set_out(cause)

    def update(self, cause: str) -> None:
        """Follow again after an update, from the present counts, unless a limit switch or the motor prevents it."""
        if self.suspended and not self.state.awaits_update and not self.switches.flagged:
            self.suspended = False
            self.followed = self.feedback.counts
        self.set_out(cause)

    def set_out(self, cause: str) -> None:
        """Begin to follow; if the gear is suspended, end the motion immediately."""
        begins(self.chip, self.state, cause, 0, self.generator.pulse_range)
        if self.suspended:
            self.generator.log.end("limit" if self.switches.flagged else "cut")

    def follow(self, n: int) -> None:
        """Displace the axis in a cycle; the part of the displacement beyond the pulse range is deferred."""
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
