"""How long an axis has nothing to decide, if no input departs and no command comes."""

from __future__ import annotations

from bisect import bisect_left

from .pulses import RANGE
from .sheet import HIGH_RANGE
from .state import GEAR, ONE, signed
from .updates import Updates

NEVER = 1 << 80
COUNTS_PER_CYCLE = 8192 // 12 + 1  # the filter lets no more pass


class Horizon(Updates):
    """One axis, and when it is due."""

    def horizon(self, n: int) -> int:
        """The next cycle in which something is to be decided, if no input departs and no command comes."""
        state = self.state
        if state.update or (not state.motor_on and self.law is not None):
            return n + 1
        due = NEVER if self.law is None else self.since + self.cycles
        if self.law is not None:
            due = min(due, self.passes(RANGE // 2 if self.sign > 0 else RANGE // 2 + 1, self.turn * self.sign))
        if self.mode == GEAR and self.encoder is not None and not self.encoder.quiet:
            return n + 1
        if self.mode == GEAR and (self.backlog or self.followed != self.counts):
            return n + 1
        return min(due, self.breakpoint_due(n), self.error_due(n))

    def passes(self, distance: int, turns: int = 0) -> int:
        """The cycle at which the run comes to lie so far from zero in its direction, `turns` ranges further."""
        assert self.law is not None
        missing = distance + turns * RANGE - self.sign * self.x0
        if missing <= 0:
            return NEVER
        if self.law.steady:
            return self.since - (-missing // self.law.steady)
        if self.law.travel(self.cycles) < missing:
            return NEVER
        return self.since + bisect_left(range(self.cycles + 1), missing, key=self.law.travel)

    def breakpoint_due(self, n: int) -> int:
        """When the breakpoint may be met."""
        state, value = self.state, signed(self.state.comparison, 32)
        match state.breakpoint:
            case "time":
                return n + ((state.comparison - n - 1) % (1 << 32)) + 1
            case "pos" | "neg" if self.law is not None:
                if (state.breakpoint == "pos") is not (self.sign > 0):
                    return NEVER  # moving away: it is met only behind the end of the range, where work is due
                edge = value * ONE if self.sign > 0 else -((value + 1) * ONE) + 1
                return max(self.passes(edge, self.turn * self.sign), n + 1)
            case "actl_pos" | "actl_neg" if self.encoder is not None and not self.encoder.quiet:
                wraps = RANGE // ONE // 2 - abs(state.actual)  # what lies behind the end of the range may meet it too
                return n + max(min(abs(value - state.actual), wraps) // COUNTS_PER_CYCLE, 1)
            case "ext" if not self.home.quiet:
                return n + 1
        return NEVER

    def error_due(self, n: int) -> int:
        """When the position error may pass its limit, one way or the other."""
        state = self.state
        if self.encoder is None or not state.step_ratio:
            return NEVER
        rate = self.fastest * state.step_ratio  # 2^-24 counts per cycle
        if not self.encoder.quiet:
            rate += COUNTS_PER_CYCLE << 24
        if not rate:
            return NEVER
        margin = abs(state.pos_err - abs(state.error)) - state.step_ratio // 256 - 2  # a step counts all at once
        return n + max((margin << 24) // rate, 1)

    @property
    def fastest(self) -> int:
        """No cycle of the run displaces by more."""
        if self.law is None:
            return 0
        if self.aim == "curve":
            return min(self.state.active.velocity, HIGH_RANGE * ONE)
        return max(self.limits.velocity, abs(self.state.velocity))
