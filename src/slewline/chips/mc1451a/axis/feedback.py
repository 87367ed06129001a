"""Encoder position feedback of one axis: the actual position, and its distance from the target."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....core.context import ChipContext
from ....core.motion.history import History
from ..cycle_clock import CycleClock
from ..registers import ONE, AxisState, signed
from .enc import CountWindow, QuadratureCounter
from .pulses import RANGE, Pulses

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

STEPS = RANGE // ONE  # of one turn of the target


class Feedback:
    """The position from the encoder; without an encoder, the actual position never changes."""

    def __init__(self, chip: ChipContext, state: AxisState, cycle_clock: CycleClock, pulses: Pulses) -> None:
        self.kernel, self.clock, self.cycle_clock = chip.kernel, chip.clock, cycle_clock
        self.state, self.pulses = state, pulses
        self.encoder: QuadratureCounter | None = None
        if chip.sheet.encoder:
            a, b = (chip.pins[f"quad{channel}{state.number}"] for channel in "ab")
            self.encoder = QuadratureCounter(a, b, chip.clock, chip.finding)
        self.offsets = History()  # actual position minus counts
        pulses.axis.on_forget.add(self.forget)

    def begin(self) -> None:
        """Start counting from 0, after a reset."""
        if self.encoder is not None:
            self.encoder.begin()
        self.counts = self.error8 = self.whole = 0  # of the encoder; error * 256; steps of the target included in it
        self.offset = 0
        self.offsets.note(self.kernel.now, 0)

    def read(self, n: int) -> None:
        """Read the encoder's count at the start of cycle `n`, and compare the actual position with the target."""
        encoder = self.encoder
        if encoder is None:
            return
        state = self.state
        counts = encoder.counts_before(self.cycle_clock.tick(n))
        whole = state.target // ONE + self.pulses.rounds * STEPS
        self.error8 += (counts - self.counts) * 256 - state.step_ratio * (whole - self.whole)
        self.counts, self.whole = counts, whole
        state.actual = signed(counts + self.offset, 31)
        state.error = self.error8 >> 8

    def errors_coming(self, n: int, window: CountWindow) -> NDArray[np.int64]:
        """Return the position errors that `read` will compute in the cycles after `n`, within the window: int64.

        `n` is the last cycle that was read.  The errors are valid if the present run lasts for the
        whole window.  If it ends earlier, they are wrong from that point on, but the axis is processed when a
        run ends in any case.
        """
        import numpy as np

        clock, pulses, law = self.cycle_clock, self.pulses, self.pulses.law
        cycles = np.arange(n, clock.cycle_at_tick(window.stop) + 1)
        error8 = (window.coming(clock.origin + cycles * clock.cycle_ticks) - self.counts) * 256
        if law is not None:
            whole = (pulses.x0 + pulses.sign * law.travels(cycles - pulses.since)) // ONE
            error8 -= self.state.step_ratio * (whole - whole[0])
        found: NDArray[np.int64] = np.clip(self.error8 + error8[1:] >> 8, -0x8000, 0x7FFF)  # as in `saturated`
        return found

    def declare(self, n: int, value: int) -> None:
        """Set the actual position to `value`, the new target, from cycle `n` on; the position error becomes 0."""
        state = self.state
        self.whole, self.error8, state.error, state.motion_error = value, 0, 0, False
        if self.encoder is not None:
            self.offset += value - state.actual
            self.offsets.note(self.cycle_clock.ps(n), self.offset)
            state.actual = value

    def forget(self, before: int) -> None:
        """Discard the data from before an instant (ps); no query needs them any more."""
        self.offsets.forget(before)
        if self.encoder is not None:
            self.encoder.history.forget(self.clock.ticks_until(before))
