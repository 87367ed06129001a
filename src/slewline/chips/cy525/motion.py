"""The CY525's motions: ramps, continuous motion, ABORT, and the host's requests while the motor turns.

ABORT, I/O REQUEST and I/O SELECT are sampled at the beginning of each step, STEP INHIBIT at its end.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ...core.motion.ideal_motion import Ideal
from ...core.motion.motions import MotionParameters
from ...core.motion.plan import Plan, Runs, head, mirrored, steps, tail
from ...core.wires.net import Net, Wave
from ..cy5xx.stepping import motion
from ..cy5xx.stepping.motion import STOP
from . import profile, sheet
from .ideal import at_start
from .instructions import Registers
from .profile import Law

WRAP = 1 << 16


class Motion(motion.Motion):
    """The stepping part of the firmware.  `moving` is True from the falling edge of READY to MOTION COMPLETE."""

    registers: Registers
    law: Law

    # -------------------------------------------------------------------------------------------- before the first step
    def parameters(self, number: int) -> Callable[[], MotionParameters]:
        """Load the parameters of this motion; return a function that computes those to be shown in pictures."""
        values = self.registers.values
        self.first = min(values["firstrate"], sheet.RATE_TOP)  # effective F: requests change it
        self.top = max(self.first, min(values["rate"], sheet.RATE_TOP))
        self.continuous, self.aborted = self.registers.continuous, False
        self.crawling = False  # ABORT was released: continue to the target
        self.served = self.pending = self.hold_reported = False
        self.at_start = at_start(self.chip.crystal_hz, values, number, self.law)
        return self.at_start.parameters

    async def ordered(self) -> None:
        """Wait until I/O REQUEST is high; if ABORT is low at that time, ignore ABORT during this motion."""
        if self.request.is_active:
            self.chip.waits(f"waiting for io_request=1 before the first step ({self.text})")
            await self.chip.polled(*self.request.when_inactive, 1)
        self.abortable = self.abort.is_inactive  # "initially" (s.7, case II): before STEP INHIBIT, which may last

    def expected(self, plan: Plan) -> Callable[[], Ideal]:
        slews = any(leg.name == "slew" for leg in plan.legs)
        return partial(self.at_start.ideal, self.kernel.now, self.axis.position, self.sign, slews, self.continuous)

    def planned(self) -> Plan:
        """Return the plan of this motion; a continuous motion that reaches its slew rate slews without end (s.7)."""
        chip = self.chip
        values = self.registers.values
        self.request_changes = self.request.changes  # at the latest sample
        plan = profile.move(self.number, self.first, self.top, values["slope"], values["divisor"], self.law)
        if self.continuous:
            if any(leg.name == "slew" for leg in plan.legs):
                if not self.abortable:
                    chip.finding("abort-low-at-start", "only RESET ends a continuous motion begun with ABORT low")
                return profile.steady(self.top, ("up", self.ramp(self.first, self.top)))
            chip.finding("halt-without-effect", "H has no effect: the motion is too short to slew")
            self.continuous = False
        return plan

    async def end(self) -> None:
        """Clear the flag that H sets, which applies to one motion only."""
        self.registers.continuous = False
        await super().end()

    # --------------------------------------------------------------------------------------------------------- samples
    def watched(self) -> list[tuple[Net, int]]:
        request = self.request
        withdrawn = self.done and request.is_active
        pairs = [self.inhibit.when_active, request.when_inactive if withdrawn else request.when_active]
        if self.select.level == 0:
            pairs.append((self.select, 1))
        if self.abortable and not self.aborted:
            pairs.append(self.abort.when_active)
        return pairs

    @property
    def each(self) -> bool:
        """True while I/O SELECT is high: the position is read out at each step."""
        return bool(self.select.level == 1)

    @property
    def progress(self) -> str:
        if self.crawling:
            return f"{self.text} aborted, abort=1 at rate {self.first}: continues to its target"
        if self.aborted:
            then = "it then continues to its target unless abort=0"
            return f"{self.text} aborted: decelerating to rate {self.first} ({then})"
        if self.continuous:
            end = "abort=0" if self.abortable else "RESET, because abort was low at the start"
            return f"{self.text} in motion (until {end})"
        return f"{self.text} in motion ({self.number} steps)"

    # -------------------------------------------------------------------------------------- decisions between two steps
    async def look(self, plan: Plan, step: int) -> Plan:
        """Sample ABORT and I/O REQUEST before a step; return the plan of the remaining motion, empty if it stops."""
        chip = self.chip
        if step >= plan.steps:
            return plan  # at the target
        over, leg = plan.leg(step - 1), plan.leg(step)
        if self.abortable and not self.aborted and self.abort.is_active:
            down = self.stop_ramp(plan, step)
            return down if self.continuous else await self.rate_request(down, 0)
        if self.aborted and leg.name != "down" and over.name == "down":  # the bottom of the ramp
            if self.abort.is_active:
                return STOP
            self.crawling = True
            chip.waits(self.progress)
            if self.continuous:
                chip.finding(
                    "abort-released",
                    "ABORT was released in a continuous motion: the motion continues at F to its nominal target",
                )
        return await self.rate_request(plan, step)

    def stop_ramp(self, plan: Plan, step: int) -> Plan:
        """Return the plan after ABORT: a ramp down to the first rate, then steps at that rate up to the target.

        If the target is within the ramp, the motion ends at the target.
        """
        chip = self.chip
        self.aborted = True
        self.mark_deviation("command", "ABORT")
        chip.waits(self.progress)
        over = plan.leg(step - 1)
        if over.name == "down":
            runs = tail(over.runs, step - over.first)
        else:
            runs = mirrored(self.ramp(self.first, profile.rate(plan, step - 1)))
        if not runs:
            return STOP
        left = self.number - self.done
        if self.continuous:
            left = left % WRAP or WRAP
            if left < steps(runs):
                chip.finding(
                    "target-in-ramp",
                    f"the nominal target is within the stop ramp: the motor stops abruptly after {left} steps",
                )
        down = head(runs, left)
        rest = left - steps(down)
        return profile.plan(("down", down), ("crawl", ((sheet.STEP_TICKS[self.first], rest),))).verified(left)

    def ramp(self, low: int, high: int) -> Runs:
        """Return the ramp from the rate parameter `low` up to `high`, with the present S and Z."""
        values = self.registers.values
        return profile.ramp(low, high, values["slope"], values["divisor"], self.law)

    async def rate_request(self, plan: Plan, step: int) -> Plan:
        """Return the plan after a sample of I/O REQUEST between two steps.

        If it is low, a continuous motion changes to a new rate, and a normal motion halts.
        """
        chip = self.chip
        requested = self.request.is_active
        if not self.continuous:
            if requested:
                if plan is not STOP:
                    self.mark_deviation("command", "I/O REQUEST")
                chip.finding(
                    "fly-rate-outside-continuous",
                    "I/O REQUEST is low in a normal motion: the motor halts without a ramp",
                )
                return STOP
            return plan
        missed = self.request.changes - self.request_changes > 1  # low and high again between two samples
        self.request_changes = self.request.changes
        if not requested:
            if self.pending or missed:
                when = "while the motor was ramping" if self.pending else "within one step"
                chip.finding("request-withdrawn", f"a rate request began and ended {when}: it was missed")
            self.pending = self.served = self.hold_reported = False
            return plan
        ramping = plan.leg(step).name != "slew"
        self.pending = ramping and not self.served
        if ramping:
            return plan
        if self.served:
            if not self.hold_reported:
                self.hold_reported = True
                chip.finding(
                    "request-held",
                    "I/O REQUEST is still low after SLEW went high: it is ignored; raise it before the next request",
                )
            return plan
        return await self.change_rate(profile.rate(plan, step))

    async def change_rate(self, current: int) -> Plan:
        """Read a new rate from the bus (s.7) and return the new plan.

        For the rest of this motion, a rate above `current` replaces R; a rate below it replaces both F and R.
        """
        rate = self.taken_rate()
        if rate == 0:
            return await self.zero_rate(current)
        if rate < current:
            self.first = rate
        self.slews_at(rate)
        if rate > current:
            return profile.steady(rate, ("up", self.ramp(current, rate)))
        if rate < current:
            return profile.steady(rate, ("down", mirrored(self.ramp(rate, current))))
        return profile.steady(rate, ("up", ((sheet.STEP_TICKS[rate], 1),)))  # SLEW blinks for one step

    def slews_at(self, rate: int) -> None:
        """Record the rate parameter at which the motor slews from now on."""
        self.axis.log.change(partial(self.at_start.rates, self.first, rate))

    def taken_rate(self) -> int:
        """Return the rate byte, at most 127, read with one INSTROBE pulse; ignore I/O REQUEST until it is high."""
        self.served = True
        byte = self.port.taken()
        if byte > sheet.RATE_TOP:
            self.chip.finding("range", f"on-the-fly rate {byte} is above 127: 127 is used")
        rate = min(byte, sheet.RATE_TOP)
        self.mark_deviation("command", f"R {rate}")
        return rate

    async def zero_rate(self, old: int) -> Plan:
        """Handle a new rate of 0 (s.7): output no step until a rate above `old` resumes the motion or ABORT ends it."""
        chip = self.chip
        slew = self.outputs.slew
        blinks = chip.clock.ps(chip.tick + self.ticks["slew_blink"])
        slew.play(Wave(slew.inactive_level, (blinks,), (slew.active_level,)))
        self.axis.log.change(dict)  # no rate is in effect
        self.port.motion_complete.activate()
        higher, commands_that_end = [f"a rate above {old}"] * (old < sheet.RATE_TOP), ["abort=0"] * self.abortable
        commands = ", or ".join(higher + commands_that_end) or "RESET"
        chip.waits(f"{self.text} at rate 0, waiting for {commands}")
        poll = self.ticks["wait_poll"]
        abort = (self.abort.when_active,) if self.abortable else ()
        while True:
            if await chip.polled(*self.request.when_inactive, poll, *abort) is self.abort:
                return STOP
            if await chip.polled(*self.request.when_active, poll, *abort) is self.abort:
                return STOP
            rate = self.taken_rate()
            self.request_changes = self.request.changes
            if rate > old:
                break
            chip.finding("fly-zero-low", f"a request for rate {rate} has no effect at rate 0; required: {commands}")
        slew.deactivate()
        await self.uninhibited()
        chip.waits(self.progress)
        self.port.motion_complete.deactivate()
        self.slews_at(rate)
        return profile.steady(rate, ("up", self.ramp(old, rate)))

    # ------------------------------------------------------------------------------------------- position on the fly
    def stretched(self, leg: str) -> int:
        """Put the position on the bus, first the high byte, then the low byte, if I/O SELECT is high (fig. 6.5).

        Returns the number of clocks by which this lengthens the step that begins now: none at a constant rate, 20 µs
        (at 11 MHz) in a ramp.
        """
        if self.select.level != 1:
            return 0
        if self.request.is_active:
            self.chip.finding(
                "request-and-select",
                "I/O REQUEST and I/O SELECT are active together: the rate request has priority; no read-out follows",
            )
            return 0
        position = (self.axis.position + self.sign) % WRAP
        self.port.show(position, self.ticks["readout_delay"], self.ticks["readout_spacing"])
        return self.ticks["readout_stretch"] if leg in ("up", "down") else 0
