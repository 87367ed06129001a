"""The CY525's motion, one step at a time: the oracle of the fast path, slow and obvious.

The fast path plans whole moves and promises step trains.  This twin plans nothing but a list of single steps, drives
every edge when it comes, looks at the pins when the chip looks, and so gives a second opinion that shares no code with
the first.  It reports no findings.

    move:  READY low -> I/O REQUEST high? -> direction -> STEP INHIBIT low? -> [step -> looks] ... -> over -> READY

    one step (a look reads the levels from before the instant):

        begin                                       end = begin of the next
          |                                           |
          |_________________________________      ____|
        ‾‾|                                 |‾‾‾‾|    PULSE
          |                                 |    |
          phases, position, SLEW,           |    looks: target? ABORT? bottom of the ramp? I/O REQUEST?
          I/O SELECT?                       STEP INHIBIT?
"""

from __future__ import annotations

from collections import deque
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from ...core.net import Wave
from ...core.plan import Leg, Plan
from ...core.train import Playing, StepTrain
from . import sheet

if TYPE_CHECKING:
    from .firmware import Cy525

T = {name: time.ticks for name, time in sheet.TIMES.items()}

UP, SLEW, DOWN = "up", "slew", "down"
CRAWL = "crawl"  # at the first rate, SLEW high, up to the target
SAME = "same"  # the one step with SLEW high that answers a request for the present rate


class Step(NamedTuple):
    """One step that is to be made."""

    kind: str
    rate: int


class Stepwise:
    """Plays every motion step by step."""

    def __init__(self, chip: Cy525) -> None:
        self.chip = chip
        self.moving = False
        self.plan: deque[Step] = deque()  # the steps to come, one by one
        self.sign = 1
        self.number = self.made = 0  # steps of the move, and made so far
        self.first = self.top = 0  # the effective F and the rate of slewing
        self.continuous = False  # a motion without end, even when aborted
        self.endless = False  # the plan is followed by slewing without end
        self.abort_enabled = self.abort_used = False
        self.served = False  # the present low of I/O REQUEST has had its answer

    def killed(self) -> None:
        """Reset in mid-motion: whatever has begun by now stands, nothing follows."""
        self.chip.axis1.log.end("cut")
        self.moving = False

    def departs(self, kind: str, text: str) -> None:
        """The motion becomes another one than it was to be."""
        self.chip.axis1.log.depart()
        self.chip.axis1.log.mark(kind, text)

    # ------------------------------------------------------------------------------------------------ a whole motion
    async def move(self, number: int, sign: int, text: str) -> None:
        """A motion from READY low to the moment when READY may return; in a program it does return."""
        chip = self.chip
        self.moving = True
        chip.waits(f"{text} in motion")
        made = chip.made(number)
        self.rates = made.rates
        chip.axis1.log.begin(text, made.parameters, sign)
        chip.ready.drive(0)
        chip.motion_complete.drive(1)
        chip.set_direction(sign > 0)
        await chip.ticks(T["step_lead"])
        await chip.polled(chip.request, 1, 1)
        if number > 0:
            self.prepare(number, sign)
            self.abort_enabled = chip.abort.level == 1
            await chip.polled(chip.inhibit, 0, T["inhibit_poll"])
            slews = self.endless or any(step.kind == SLEW for step in self.plan)
            ideal = partial(made.ideal, chip.kernel.now, chip.position, sign, slews, self.endless)
            chip.axis1.log.expect(ideal)
            await self.play()
        chip.pulse.drive(1)
        chip.slew.drive(1)
        chip.motion_complete.drive(0)
        chip.axis1.log.end()
        chip.continuous = False
        self.moving = False
        await chip.ticks(T["ready_after_motion"])
        if chip.in_program():
            chip.ready.drive(1)

    async def play(self) -> None:
        """Step after step, until the looks between two of them say that it is over."""
        while (step := self.coming()) is not None:
            if self.plan:
                self.plan.popleft()
            await self.step(step)
            if not await self.goes_on(step):
                if self.coming() is not None:
                    self.chip.axis1.log.stop()
                return

    # ------------------------------------------------------------------------------------------------------- the plan
    def prepare(self, number: int, sign: int) -> None:
        """The plan of an undisturbed motion."""
        chip = self.chip
        self.number, self.sign, self.made, self.abort_used, self.served = number, sign, 0, False, False
        self.first = min(chip.reg["firstrate"], sheet.RATE_TOP)
        self.top = max(min(chip.reg["rate"], sheet.RATE_TOP), self.first)  # R below F: the whole move at F
        up = self.way_up(self.first, self.top, number)
        if 2 * len(up) > number:  # too short to reach R: turn in the middle
            up = up[: number // 2]
        rest = number - 2 * len(up)
        slews = rest if rest >= sheet.SHORT_SLEW_STEPS else 0
        self.continuous = self.endless = chip.continuous and slews > 0
        chip.continuous = self.continuous
        self.plan = deque(Step(UP, rate) for rate in up)
        if not self.endless:
            self.plan.extend([Step(SLEW, self.top)] * slews)
            self.plan.extend(Step(DOWN, rate) for rate in reversed(up))
            self.plan.extend([Step(CRAWL, self.first)] * (rest - slews))

    def way_up(self, low: int, high: int, most: int | None = None) -> list[int]:
        """Rates of the steps, one by one, that lead from one rate to (not including) another; at most so many."""
        unit = (self.chip.reg["divisor"] or 256) * (256 - self.chip.reg["slope"]) * self.chip.law.unit
        rates: list[int] = []
        rate, ramp_time = low, 0
        while rate < high and (most is None or len(rates) < most):
            rates.append(rate)
            ramp_time += sheet.STEP_TICKS[rate]
            due = low + ramp_time // unit
            rate = due if self.chip.law.jumps else min(rate + 1, due)
        return rates

    def coming(self) -> Step | None:
        """The step that comes next as things stand; None: the target is reached."""
        if self.plan:
            return self.plan[0]
        return Step(SLEW, self.top) if self.endless else None

    # ------------------------------------------------------------------------------------------------------- one step
    async def step(self, step: Step) -> None:
        """From the fall of PULSE to the end of its high time."""
        chip = self.chip
        begin, period = chip.tick, sheet.STEP_TICKS[step.rate]
        chip.slew.drive(0 if step.kind == SLEW else 1)
        if chip.select.level == 1 and chip.request.level == 1:
            self.read_out((chip.position + self.sign) % 65536)
            if step.kind in (UP, DOWN):
                period += T["readout_stretch"]
        chip.pulse.drive(0)
        chip.phase = (chip.phase + self.sign) % len(sheet.PHASES)
        for driver, level in zip(chip.phase_pins, sheet.PHASES[chip.phase], strict=True):
            driver.drive(level)
        leg = Leg(UP if step.kind == SAME else step.kind, ((period, 1),), 0, 1)
        playing = Playing(StepTrain(chip.clock, begin, leg.runs), until=None)
        chip.axis1.follow(playing, self.sign, plan=Plan((leg,)))
        self.made += 1
        await chip.at_tick(begin + period - T["pulse_high"])
        if chip.inhibit.level == 1:
            self.departs("event", "STEP INHIBIT")
        await chip.polled(chip.inhibit, 0, T["inhibit_poll"])
        chip.pulse.drive(1)
        await chip.ticks(T["pulse_high"])

    def read_out(self, position: int) -> None:
        """I/O SELECT while stepping: the position on the bus, high byte first; all is over long before the step is."""
        chip, ps = self.chip, self.chip.clock.ps
        high, width = chip.tick + T["readout_delay"], T["strobe_width"]
        low = high + T["readout_spacing"]
        falls = high + T["readout_spacing"] // 2
        rises = falls + T["readout_spacing"]
        chip.outstrobe.play(Wave(1, (ps(high), ps(high + width), ps(low), ps(low + width)), (0, 1, 0, 1)))
        chip.motion_complete.play(Wave(1, (ps(falls), ps(rises)), (0, 1)))
        both = (0xFF, position >> 8), (0xFF, position & 0xFF)
        chip.bus_driver.play(Wave(None, (ps(high), ps(falls), ps(rises)), (*both, None)))

    # ----------------------------------------------------------------------------------- the looks between two steps
    async def goes_on(self, just: Step) -> bool:
        """Look at everything at the end of a step, in the chip's order; false: the motion is over."""
        chip = self.chip
        # 1. the target
        if self.coming() is None:
            return False
        # 2. ABORT, once per motion
        if self.abort_enabled and not self.abort_used and chip.abort.level == 0:
            self.abort_used = True
            self.departs("command", "ABORT")
            if just.kind == CRAWL or not self.turned_down(just):
                return False
        coming = self.coming()
        assert coming is not None
        # 3. the bottom of the ramp of an abort
        if self.abort_used and just.kind == DOWN and coming.kind != DOWN and chip.abort.level == 0:
            return False
        # 4. a rate request
        if not self.continuous:
            if chip.request.level == 0:
                self.departs("command", "I/O REQUEST")
            return bool(chip.request.level == 1)
        if chip.request.level == 1:
            self.served = False
        elif self.endless and not self.served and SLEW in (just.kind, coming.kind):
            self.served = True
            return await self.rate_request()
        return True

    def turned_down(self, just: Step) -> bool:
        """ABORT is low: plan the way down, and steps at the first rate to the target; false: there is no way down."""
        if just.kind == DOWN:  # it goes down already
            down = [step for step in self.plan if step.kind == DOWN]
        elif not (down := [Step(DOWN, rate) for rate in reversed(self.way_up(self.first, just.rate))]):
            return False
        remaining = self.number - self.made
        if self.continuous:  # the target comes round every 65536 steps
            remaining = remaining % 65536 or 65536
        down = down[:remaining]
        self.plan = deque(down + [Step(CRAWL, self.first)] * (remaining - len(down)))
        self.endless = False
        return True

    # ----------------------------------------------------------------------------------------------- rates on the fly
    def taken_rate(self) -> int:
        """The byte on the bus, acknowledged by INSTROBE."""
        chip, now, over = self.chip, self.chip.tick, self.chip.tick + T["strobe_width"]
        chip.instrobe.play(Wave(1, (chip.clock.ps(now), chip.clock.ps(over)), (0, 1)))
        rate = min(chip.bus.byte, sheet.RATE_TOP)
        self.departs("command", f"R {rate}")
        return rate

    def ramp_up_to(self, rate: int) -> None:
        self.plan = deque(Step(UP, way) for way in self.way_up(self.top, rate))
        self.slews_at(rate)

    def slews_at(self, rate: int) -> None:
        self.top = rate
        self.chip.axis1.log.change(partial(self.rates, self.first, rate))

    async def rate_request(self) -> bool:
        """I/O REQUEST low while slewing; false: the motion ended in the zero-rate state."""
        rate = self.taken_rate()
        if rate == 0:
            return await self.zero_rate()
        if rate > self.top:
            self.ramp_up_to(rate)
        elif rate < self.top:
            self.plan = deque(Step(DOWN, way) for way in reversed(self.way_up(rate, self.top)))
            self.first = rate
            self.slews_at(rate)
        else:
            self.plan = deque([Step(SAME, rate)])
            self.slews_at(rate)
        return True

    async def zero_rate(self) -> bool:
        """Slewing at zero steps per second, until a higher rate than before comes (true) or ABORT (false)."""
        chip, ps, every = self.chip, self.chip.clock.ps, T["wait_poll"]
        chip.slew.play(Wave(0, (ps(chip.tick), ps(chip.tick + T["slew_blink"])), (1, 0)))
        chip.motion_complete.drive(0)
        chip.axis1.log.change(dict)  # no rate is in force
        ends = ((chip.abort, 0),) if self.abort_enabled else ()
        rate = 0
        while rate <= self.top:
            for level in (1, 0):  # high again first, then low
                if await chip.polled(chip.request, level, every, *ends) is not chip.request:
                    return False
            rate = self.taken_rate()
        chip.slew.drive(1)
        await chip.polled(chip.inhibit, 0, T["inhibit_poll"])
        chip.motion_complete.drive(1)
        self.ramp_up_to(rate)
        return True
