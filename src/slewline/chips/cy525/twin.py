"""The CY525's motion, step by step: ramps, ABORT, rates on the fly and read-outs, each input sampled when it is due.

This module shares only the two fields of `Law` with motion.py and profile.py.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import cast

from ...core.motion.ideal_motion import Ideal
from ...core.motion.motions import MotionParameters
from ...core.wires.net import Wave
from ..cy5xx.stepping import twin
from ..cy5xx.stepping.twin import CRAWL, DOWN, SAME, SLEW, UP, TwinStep
from . import sheet
from .ideal import at_start
from .instructions import Registers
from .profile import Law


def step_of(kind: str, rate: int) -> TwinStep:
    """Return a step of the given kind at a rate parameter."""
    return TwinStep(kind, rate, sheet.STEP_TICKS[rate])


class Stepwise(twin.Stepwise):
    """The slow twin of motion.py, which plays every motion step by step."""

    registers: Registers
    law: Law
    endless = continuous = False  # slewing follows the plan without end, even when aborted

    # ------------------------------------------------------------------------------------------ before the first step
    async def move(self, number: int, sign: int, text: str) -> None:
        self.ordered_steps, self.by_command = number, text == "G"
        await super().move(number, sign, text)

    async def play(self) -> None:
        """Output step after step, beginning now; report an H without effect, or a motion that only RESET can end."""
        if self.asked_endless:
            if not self.endless:
                self.chip.finding("halt-without-effect", "too few steps to slew")
            elif not self.abort_enabled:
                self.chip.finding("abort-low-at-start", "only RESET ends this motion")
        self.changes = self.request.changes
        await super().play()

    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        self.motion_made = at_start(self.chip.crystal_hz, self.registers.values, number, self.law)
        return self.motion_made.parameters

    async def ordered(self) -> None:
        """Wait until I/O REQUEST is high; if ABORT is low at that time, ignore ABORT during this motion."""
        await self.chip.polled(self.request, 1, 1)
        self.abort_enabled = self.abort.level == 1
        if not self.ordered_steps and self.by_command:
            self.chip.finding("no-steps", "N is 0")

    def expected(self) -> Callable[[], Ideal]:
        slews = self.endless or any(step.kind == SLEW for step in self.plan)
        return partial(self.motion_made.ideal, self.kernel.now, self.axis.position, self.sign, slews, self.endless)

    def over(self) -> None:
        """Clear the flag that H sets, which applies to one motion only."""
        self.registers.continuous = False

    # ------------------------------------------------------------------------------------------------------- the plan
    def prepare(self) -> None:
        """Plan the steps that the motion makes if no input disturbs it."""
        number, self.abort_used, self.served = self.number, False, False
        self.ramped_over = self.hold_reported = False
        self.asked_endless = self.registers.continuous
        self.first = min(self.registers.values["firstrate"], sheet.RATE_TOP)
        self.top = max(min(self.registers.values["rate"], sheet.RATE_TOP), self.first)  # R below F: the whole move at F
        up = self.ramp_up(self.first, self.top, number)
        if 2 * len(up) > number:  # too short to reach R: turn in the middle
            up = up[: number // 2]
        rest = number - 2 * len(up)
        slews = rest if rest >= sheet.SHORT_SLEW_STEPS else 0
        self.continuous = self.endless = self.registers.continuous and slews > 0
        self.registers.continuous = self.continuous
        self.plan = deque(step_of(UP, rate) for rate in up)
        if not self.endless:
            self.plan.extend([step_of(SLEW, self.top)] * slews)
            self.plan.extend(step_of(DOWN, rate) for rate in reversed(up))
            self.plan.extend([step_of(CRAWL, self.first)] * (rest - slews))

    def ramp_up(self, low: int, high: int, most: int | None = None) -> list[int]:
        """Return the rate parameters of the steps from `low` up to, but not including, `high`; at most `most` steps."""
        unit = (self.registers.values["divisor"] or 256) * (256 - self.registers.values["slope"]) * self.law.unit
        rates: list[int] = []
        rate, ramp_time = low, 0
        while rate < high and (most is None or len(rates) < most):
            rates.append(rate)
            ramp_time += sheet.STEP_TICKS[rate]
            due = low + ramp_time // unit
            rate = due if self.law.jumps else min(rate + 1, due)
        return rates

    def coming(self) -> TwinStep | None:
        if self.plan:
            return self.plan[0]
        return step_of(SLEW, self.top) if self.endless else None

    # ------------------------------------------------------------------------------------------------------- one step
    def stretched(self, step: TwinStep) -> int:
        """Read out the position if I/O SELECT is high; return the number of clocks by which this lengthens the step."""
        if self.select.level == 0:
            return 0
        if self.request.level == 0:
            self.chip.finding("request-and-select", "no read-out while I/O REQUEST is low")
            return 0
        self.read_out((self.axis.position + self.sign) % 65536)
        return self.ticks["readout_stretch"] if step.kind in (UP, DOWN) else 0

    def read_out(self, position: int) -> None:
        """Put the position on the bus, high byte first, as I/O SELECT requests while the motor is stepping.

        The read-out ends long before the step does.
        """
        chip, ps = self.chip, self.chip.clock.ps
        high, width = chip.tick + self.ticks["readout_delay"], self.ticks["strobe_width"]
        low = high + self.ticks["readout_spacing"]
        falls = high + self.ticks["readout_spacing"] // 2
        rises = falls + self.ticks["readout_spacing"]
        self.port.outstrobe.play(Wave(1, (ps(high), ps(high + width), ps(low), ps(low + width)), (0, 1, 0, 1)))
        self.port.motion_complete.play(Wave(1, (ps(falls), ps(rises)), (0, 1)))
        both = (0xFF, position >> 8), (0xFF, position & 0xFF)
        chip.bus_driver.play(Wave(None, (ps(high), ps(falls), ps(rises)), (*both, None)))

    # ------------------------------------------------------------------------------------- samples between two steps
    async def should_continue(self, just: TwinStep) -> bool:
        # 1. the target
        if self.coming() is None:
            return False
        # 2. ABORT, once per motion
        aborts = self.abort_enabled and not self.abort_used and self.abort.level == 0
        if aborts:
            self.abort_used = True
            self.mark_deviation("command", "ABORT")
            if just.kind == CRAWL or not self.turned_down(just):
                self.asked_to_halt()
                return False
        coming = cast("TwinStep", self.coming())
        # 3. the bottom of the ramp of an abort
        if self.abort_used and just.kind == DOWN and coming.kind != DOWN:
            if self.abort.level == 0:
                if aborts:
                    self.asked_to_halt()
                return False
            if self.continuous:
                self.chip.finding("abort-released", "the motion continues to its target")
        # 4. a rate request
        if not self.continuous:
            if self.request.level == 0:
                self.mark_deviation("command", "I/O REQUEST")
            return not self.asked_to_halt()
        return aborts or await self.requested(just, coming)

    def asked_to_halt(self) -> bool:
        """Return whether I/O REQUEST halts the motion, as it does if low in a normal one; report a finding if so."""
        if self.continuous or self.request.level == 1:
            return False
        self.chip.finding("fly-rate-outside-continuous", "a normal motion accepts no rate requests")
        return True

    async def requested(self, just: TwinStep, coming: TwinStep) -> bool:
        """Handle I/O REQUEST in a continuous motion; return False if ABORT ended the motion at rate 0."""
        changes, self.changes = self.request.changes - self.changes, self.request.changes
        if self.request.level == 1:
            if self.ramped_over or changes > 1:
                self.chip.finding("request-withdrawn", "a request was missed")
            self.served = self.ramped_over = self.hold_reported = False
        elif coming.kind != SLEW and not self.served:
            self.ramped_over = True
        elif coming.kind == SLEW and self.served and not self.hold_reported:
            self.hold_reported = True
            self.chip.finding("request-held", "a request is served only once")
        if self.request.level == 0 and self.endless and not self.served and SLEW in (just.kind, coming.kind):
            self.served, self.ramped_over = True, False
            return await self.rate_request()
        return True

    def turned_down(self, just: TwinStep) -> bool:
        """Plan the stop ramp of ABORT, then steps at the first rate to the target; return False if there is no ramp."""
        if just.kind == DOWN:  # it already decelerates
            down = [step for step in self.plan if step.kind == DOWN]
        elif not (down := [step_of(DOWN, rate) for rate in reversed(self.ramp_up(self.first, just.rate))]):
            return False
        remaining = self.number - self.made
        if self.continuous:  # the target comes round every 65536 steps
            remaining = remaining % 65536 or 65536
            if remaining < len(down):
                self.chip.finding("target-in-ramp", "the target is within the stop ramp")
        down = down[:remaining]
        self.plan = deque(down + [step_of(CRAWL, self.first)] * (remaining - len(down)))
        self.endless = False
        return True

    # ----------------------------------------------------------------------------------------------- rates on the fly
    def taken_rate(self) -> int:
        """Return the rate parameter on the bus, 127 at most, and acknowledge it by an INSTROBE pulse."""
        chip, now, over = self.chip, self.chip.tick, self.chip.tick + self.ticks["strobe_width"]
        self.port.instrobe.play(Wave(1, (chip.clock.ps(now), chip.clock.ps(over)), (0, 1)))
        if chip.bus.byte > sheet.RATE_TOP:
            chip.finding("range", "a rate above 127")
        rate = min(chip.bus.byte, sheet.RATE_TOP)
        self.mark_deviation("command", f"R {rate}")
        return rate

    def ramp_up_to(self, rate: int) -> None:
        """Plan the steps from the present rate parameter up to a higher one, at which the motor then slews."""
        self.plan = deque(step_of(UP, each) for each in self.ramp_up(self.top, rate))
        self.slews_at(rate)

    def slews_at(self, rate: int) -> None:
        """Record the rate parameter at which the motor slews from now on."""
        self.top = rate
        self.axis.log.change(partial(self.motion_made.rates, self.first, rate))

    async def rate_request(self) -> bool:
        """Handle I/O REQUEST low while slewing; return False if ABORT ended the motion at rate 0."""
        rate = self.taken_rate()
        if rate == 0:
            return await self.zero_rate()
        if rate > self.top:
            self.ramp_up_to(rate)
        elif rate < self.top:
            self.plan = deque(step_of(DOWN, each) for each in reversed(self.ramp_up(rate, self.top)))
            self.first = rate
            self.slews_at(rate)
        else:
            self.plan = deque([step_of(SAME, rate)])
            self.slews_at(rate)
        return True

    async def zero_rate(self) -> bool:
        """Slew at 0 steps/s; return True when a rate above the previous one arrives, False when ABORT goes low."""
        chip, ps, every = self.chip, self.chip.clock.ps, self.ticks["wait_poll"]
        self.outputs.slew.play(Wave(0, (ps(chip.tick), ps(chip.tick + self.ticks["slew_blink"])), (1, 0)))
        self.port.motion_complete.drive(0)
        self.axis.log.change(dict)  # no rate is in effect
        ends = ((self.abort, 0),) if self.abort_enabled else ()
        rate = 0
        while rate <= self.top:
            for level in (1, 0):  # high again first, then low
                if await chip.polled(self.request, level, every, *ends) is not self.request:
                    return False
            rate, self.changes = self.taken_rate(), self.request.changes
            if rate <= self.top:
                chip.finding("fly-zero-low", "the rate is not higher than before: it has no effect")
        self.outputs.slew.drive(1)
        await chip.polled(self.inhibit, 0, self.ticks["inhibit_poll"])
        self.port.motion_complete.drive(1)
        self.ramp_up_to(rate)
        return True
