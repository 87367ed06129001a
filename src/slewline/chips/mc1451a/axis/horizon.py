"""The next cycle in which an axis must be processed, if no input changes and no command arrives before it."""

from __future__ import annotations

from bisect import bisect_left

from .. import sheet
from ..profiles.cycle_train import Law
from ..registers import GEAR, ONE, AxisState, signed
from .enc import FilteredInput
from .feedback import Feedback
from .gear import ElectronicGear
from .generator import ProfileGenerator
from .pulses import RANGE

NEVER = 1 << 80


class Horizon:
    """The forecast of one axis's next due cycle: the next one that must be processed."""

    def __init__(
        self,
        state: AxisState,
        generator: ProfileGenerator,
        feedback: Feedback,
        gear: ElectronicGear,
        home: FilteredInput,
    ) -> None:
        self.state, self.generator, self.pulses = state, generator, generator.pulses
        self.feedback, self.gear, self.home = feedback, gear, home
        self.counts_per_cycle = sheet.CYCLE_TICKS // sheet.FILTER_TICKS + 1  # no more edges leave the filter

    def after(self, n: int) -> int:
        """Return the first cycle that needs a decision after `n`, the last one processed; NEVER if none does."""
        state, pulses, encoder = self.state, self.pulses, self.feedback.encoder
        if state.update or state.was_off:
            return n + 1
        due = NEVER
        if pulses.law is not None:
            end = RANGE // 2 if pulses.sign > 0 else RANGE // 2 + 1
            due = min(pulses.since + pulses.cycles, self.passes(pulses.law, end, pulses.turn * pulses.sign))
        if self.generator.mode == GEAR and ((encoder is not None and not encoder.quiet) or self.gear.is_lagging):
            return n + 1
        return min(due, self.breakpoint_due(n), self.error_due(n))

    def passes(self, law: Law, distance: int, turns: int = 0) -> int:
        """Return the first cycle at whose start the present run has reached a position; NEVER if there is none.

        The position is `distance`, in 1/65536 step, plus `turns` times the range of the target (2^31 steps).  It
        is counted from position 0, and is positive in the direction of the run.  The result is also NEVER if
        the run began at the position or beyond it.
        """
        pulses = self.pulses
        missing = distance + turns * RANGE - pulses.sign * pulses.x0
        if missing <= 0:
            return NEVER
        if law.steady:
            return pulses.since - (-missing // law.steady)
        if law.travel(pulses.cycles) < missing:
            return NEVER
        return pulses.since + bisect_left(range(pulses.cycles + 1), missing, key=law.travel)

    def breakpoint_due(self, n: int) -> int:
        """Return the first cycle after `n` in which the breakpoint may be met; NEVER if no such cycle is foreseen."""
        state, pulses, encoder = self.state, self.pulses, self.feedback.encoder
        value = signed(state.comparison, 32)
        match state.breakpoint:
            case "time":
                return n + ((state.comparison - n - 1) % (1 << 32)) + 1
            case "pos" | "neg" if pulses.law is not None:
                if (state.breakpoint == "pos") is not (pulses.sign > 0):
                    return NEVER  # moving away: it is met only past the end of the range, where a cycle is due
                edge = value * ONE if pulses.sign > 0 else -((value + 1) * ONE) + 1
                return max(self.passes(pulses.law, edge, pulses.turn * pulses.sign), n + 1)
            case "actl_pos" | "actl_neg" if encoder is not None and not encoder.quiet:
                wraps = RANGE // ONE // 2 - abs(state.actual)  # a position past the end of the range may meet it too
                return n + max(min(abs(value - state.actual), wraps) // self.counts_per_cycle, 1)
            case "ext" if not self.home.quiet:
                return n + 1
        return NEVER

    def error_due(self, n: int) -> int:
        """Return the first cycle after `n` in which the position error may begin or cease to exceed its limit.

        The result is NEVER if no such cycle is foreseen.
        """
        state, feedback, encoder = self.state, self.feedback, self.feedback.encoder
        if encoder is None or not state.step_ratio:
            return NEVER
        if encoder.quiet:
            rate = self.generator.fastest * state.step_ratio  # 2^-24 counts per cycle
            if not rate:
                return NEVER
            margin = abs(state.pos_err - abs(state.error)) - state.step_ratio // 256 - 2  # a step counts all
            return n + max((margin << 24) // rate, 1)
        if encoder.window is None:  # a finding is about to occur, and must be reported at its time
            return n + 1
        beyond = abs(feedback.errors_coming(n, encoder.window)) > state.pos_err
        passes = (beyond != state.motion_error).nonzero()[0]
        return n + (1 + int(passes[0]) if len(passes) else len(beyond))
