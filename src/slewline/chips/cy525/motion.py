"""How a CY525 plays a plan: promise it whole, look at the inputs where the manual says so, withdraw when one departs.

When the chip looks, on a step from its begin b to the begin of the next:

    b                                   r    b'
    |___________________________________|‾‾‾‾|      PULSE
    |                                   |
    ABORT, I/O REQUEST, I/O SELECT      STEP INHIBIT: while it is high here, PULSE stays low

A plan is promised to the next look that matters.  When a watched input departs from the level it had, the promise is
withdrawn to the first look strictly after the change; there the firmware reads the levels from before that instant
and decides: play on, replan from the step that is about to begin, or stop.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from ...core.net import Net, Wave
from ...core.step_views import PatternView, PulseView
from ...core.train import OPEN, Playing, StepTrain
from ...core.waits import first_of
from . import profile, sheet
from .profile import Plan

if TYPE_CHECKING:
    from .firmware import Cy525

T = {name: time.ticks for name, time in sheet.TIMES.items()}
HIGH = T["pulse_high"]
WRAP = 1 << 16


class Motion:
    """The stepping part of the firmware.  `moving` is true from READY low to MOTION COMPLETE."""

    def __init__(self, chip: Cy525) -> None:
        self.chip = chip
        self.moving = False
        self.playing: Playing | None = None

    # ------------------------------------------------------------------------------------------------- a whole motion
    async def move(self, number: int, sign: int, text: str) -> None:
        """Take `number` steps, or run until aborted after H; READY is low from here to the end.

        Args:
            number: steps to the target, 0 to 65535.
            sign: +1 clockwise, -1 counter-clockwise.
            text: what the host said, for `waiting`.
        """
        chip = self.chip
        self.begin(number, sign, text)
        chip.set_direction(sign > 0)
        await chip.ticks(T["step_lead"])
        if chip.request.level == 0:
            chip.waits(f"{text}: io_request=1 before the first step")
            await chip.polled(chip.request, 1, 1)
        if number:
            self.abortable = chip.abort.level == 1  # "initially" (s.7, case II): before a hold, which may last
            await self.uninhibited()
            plan = self.planned()
            self.expect(plan)
            chip.waits(self.progress)
            await self.play(plan)
        elif text == "G":
            chip.finding("no-steps", "G with N 0: no step to take")
        await self.end()

    def begin(self, number: int, sign: int, text: str) -> None:
        """Take over the parameters for this motion."""
        chip = self.chip
        self.moving = True
        self.number, self.sign, self.text = number, sign, text
        self.done = 0  # steps of this motion that are over
        self.first = min(chip.reg["firstrate"], sheet.RATE_TOP)  # effective F: requests change it
        self.top = max(self.first, min(chip.reg["rate"], sheet.RATE_TOP))
        self.continuous, self.aborted = chip.continuous, False
        self.crawling = False  # ABORT was released: on to the target
        self.served = self.pending = self.told_held = False
        self.request_changes = chip.request.changes  # by the latest look
        self.made = chip.made(number)
        chip.axis1.log.begin(text, self.made.parameters, sign)
        chip.ready.drive(0)
        chip.motion_complete.drive(1)

    def expect(self, plan: Plan) -> None:
        """The ideal of this motion, whose first step begins now."""
        slews = any(leg.name == "slew" for leg in plan.legs)
        now, position = self.chip.kernel.now, self.chip.position
        ideal = partial(self.made.ideal, now, position, self.sign, slews, self.continuous)
        self.chip.axis1.log.expect(ideal)

    def departs(self, kind: str, text: str) -> None:
        """Something makes the motion another one than it was to be."""
        self.chip.axis1.log.depart()
        self.chip.axis1.log.mark(kind, text)

    async def uninhibited(self) -> None:
        """Before the first step: STEP INHIBIT high holds it, with PULSE high."""
        chip = self.chip
        if chip.inhibit.level == 1:
            chip.waits(f"{self.text} held by step_inhibit=1")
            await chip.polled(chip.inhibit, 0, T["inhibit_poll"])

    def planned(self) -> Plan:
        """The plan of this motion; a continuous one slews without end if it comes to slewing at all (s.7)."""
        chip = self.chip
        plan = profile.move(self.number, self.first, self.top, chip.reg["slope"], chip.reg["divisor"], chip.law)
        if self.continuous:
            if any(leg.name == "slew" for leg in plan.legs):
                if not self.abortable:
                    chip.finding("abort-low-at-start", "a continuous motion begun with ABORT low ends by RESET only")
                return profile.steady(self.top, ("up", self.ramp(self.first, self.top)))
            chip.finding("halt-without-effect", "H has no effect: the motion is too short to slew")
            self.continuous = False
        return plan

    async def end(self) -> None:
        """The last step is over: outputs rest, MOTION COMPLETE falls, READY follows."""
        chip = self.chip
        self.settle()
        chip.continuous = False
        chip.pulse.drive(1)
        chip.slew.drive(1)
        chip.motion_complete.drive(0)
        chip.axis1.log.end()
        self.moving = False
        chip.waits(f"READY after {self.text}")
        await chip.ticks(T["ready_after_motion"])
        if chip.in_program():
            chip.ready.drive(1)

    def killed(self) -> None:
        """Reset in mid-motion: steps of this instant stand, later ones do not."""
        if self.playing is not None and self.moving:
            bound = self.chip.kernel.now + 1
            if self.playing.until is None or bound < self.playing.until:
                self.playing.until = bound
            self.settle()
        self.chip.axis1.log.end("cut")
        self.moving = False

    # ------------------------------------------------------------------------------------------------- playing a plan
    async def play(self, plan: Plan) -> None:
        """Play a plan, and what becomes of it, until the motion is over."""
        chip = self.chip
        step, fresh = 0, True  # `step` of the plan is about to begin at chip.tick
        while True:
            if self.done:
                changed = await self.look(plan, step)
                if changed is not plan:
                    plan, step, fresh = changed, 0, True
            if step >= plan.steps:
                if plan is STOP:
                    chip.axis1.log.stop()
                return
            leg = plan.leg(step)
            chip.slew.drive(0 if leg.name == "slew" else 1)
            stretch = self.read_out(leg.name)
            if fresh or stretch:
                self.lay(plan, step, stretch)
                self.base = step
            stop = step + 1 if chip.select.level == 1 else leg.end
            over = step
            step, fresh = await self.until_look(stop)
            self.done += step - over

    def lay(self, plan: Plan, step: int, stretch: int = 0) -> None:
        """Promise a train whose first step, one of a plan, begins now and is `stretch` clocks longer than planned."""
        chip, runs = self.chip, profile.tail(plan.runs, step)
        self.settle()
        if stretch:
            runs = ((runs[0][0] + stretch, 1), *profile.tail(runs, 1))
        self.train = StepTrain(chip.clock, chip.tick, runs)
        self.playing = Playing(self.train)
        chip.axis1.follow(self.playing, self.sign, plan=plan, step=step)
        chip.pulse.play(PulseView(self.playing, HIGH))
        for levels, driver in zip(PHASE_LEVELS, chip.phase_pins, strict=True):
            driver.play(PatternView(self.playing, levels, chip.phase, self.sign, driver.at(chip.kernel.seen)))

    def settle(self) -> None:
        """The train so far is over: keep where it left the phases."""
        if self.playing is not None:
            chip = self.chip
            steps = self.playing.begun(chip.kernel.seen)
            if steps:
                chip.phase = (chip.phase + self.sign * steps) % 4
                for driver, level in zip(chip.phase_pins, sheet.PHASES[chip.phase], strict=True):
                    driver.drive(level)
            self.playing = None

    # ----------------------------------------------------------------------------------------------- until a decision
    async def until_look(self, stop: int) -> tuple[int, bool]:
        """Let the promise run until a decision: at the begin of step `stop` of the plan, or at an earlier look.

        Returns the step of the plan that is about to begin, and whether it needs a new train (after a hold).
        """
        chip, train, playing = self.chip, self.train, self.playing
        assert playing is not None
        departures = self.watched()
        while True:
            last = None if stop >= OPEN else train.begin(stop - self.base)
            rise = False
            watched = departures
            while True:
                bound = None if last is None else chip.clock.ps(last)
                playing.until = bound
                chip.renew_outputs()
                departed = await first_of(chip.kernel, bound, *watched)
                if departed is None:
                    break
                watched = [pair for pair in watched if pair[0] is not departed]
                look, is_rise = self.look_after(departed)
                if last is None or look < last:
                    last, rise = look, is_rise
            assert last is not None
            chip.tick = last
            if not rise:
                return self.base + train.begun_by(last - 1), False
            if chip.inhibit.level == 1:
                return await self.hold(self.base + train.begun_by(last)), True

    def watched(self) -> list[tuple[Net, int]]:
        """The inputs whose change matters now, each with the level that would be a change."""
        chip = self.chip
        pairs = [(chip.inhibit, 1), (chip.request, 1 - chip.request.level if self.done else 0)]
        if chip.select.level == 0:
            pairs.append((chip.select, 1))
        if self.abortable and not self.aborted:
            pairs.append((chip.abort, 0))
        return pairs

    def look_after(self, net: Net) -> tuple[int, bool]:
        """The first look at a net strictly after this instant: its tick, and whether it is that at the end of PULSE."""
        chip, train = self.chip, self.train
        step = train.begun(chip.kernel.now)  # steps begun; the running one is step - 1
        end = train.begin(step)
        if net is not chip.inhibit:
            return end, False
        if chip.clock.ps(end - HIGH) > chip.kernel.now:
            return end - HIGH, True
        return (train.begin(step + 1) - HIGH, True) if step < train.steps else (end, False)

    async def hold(self, step: int) -> int:
        """STEP INHIBIT is high at the end of a step: PULSE stays low until it is low, then the step ends."""
        chip = self.chip
        chip.waits(f"{self.text} held by step_inhibit=1")
        self.departs("event", "STEP INHIBIT")
        await chip.polled(chip.inhibit, 0, T["inhibit_poll"])
        chip.pulse.drive(1)
        await chip.ticks(HIGH)
        chip.waits(self.progress)
        return step

    @property
    def progress(self) -> str:
        """What a running motion waits for."""
        if self.crawling:
            return f"{self.text} aborted, abort=1 at rate {self.first}: on to its target"
        if self.aborted:
            return f"{self.text} aborted: down to rate {self.first}, and on to its target unless abort=0 there"
        if self.continuous:
            return f"{self.text} runs until {'abort=0' if self.abortable else 'RESET, abort being low from the start'}"
        return f"{self.text} in motion, {self.number} steps"

    # -------------------------------------------------------------------------- what the chip decides between two steps
    async def look(self, plan: Plan, step: int) -> Plan:
        """Look at ABORT and I/O REQUEST before a step begins; returns the plan to go on with (an empty one: stop)."""
        chip = self.chip
        if step >= plan.steps:
            return plan  # on the target
        over, leg = plan.leg(step - 1), plan.leg(step)
        if self.abortable and not self.aborted and chip.abort.level == 0:
            down = self.way_down(plan, step)
            return down if self.continuous else await self.rate_request(down, 0)
        if self.aborted and leg.name != "down" and over.name == "down":  # the bottom of the ramp
            if chip.abort.level == 0:
                return STOP
            self.crawling = True
            chip.waits(self.progress)
            if self.continuous:
                chip.finding("abort-released", "ABORT released in a continuous motion: on to its nominal target at F")
        return await self.rate_request(plan, step)

    def way_down(self, plan: Plan, step: int) -> Plan:
        """ABORT has gone low: ramp down to the first rate from where the motion is; the target may lie on the way."""
        chip = self.chip
        self.aborted = True
        self.departs("command", "ABORT")
        chip.waits(self.progress)
        over = plan.leg(step - 1)
        if over.name == "down":
            runs = profile.tail(over.runs, step - over.first)
        else:
            runs = profile.mirrored(self.ramp(self.first, profile.rate(plan, step - 1)))
        if not runs:
            return STOP
        left = self.number - self.done
        if self.continuous:
            left = left % WRAP or WRAP
            if left < profile.steps(runs):
                chip.finding(
                    "target-in-ramp", f"the nominal target lies in the down ramp: abrupt stop after {left} steps"
                )
        down = profile.head(runs, left)
        rest = left - profile.steps(down)
        return profile.plan(("down", down), ("crawl", ((sheet.STEP_TICKS[self.first], rest),))).verified(left)

    def ramp(self, low: int, high: int) -> profile.Runs:
        """The way up between two rates with the S and Z of now."""
        return profile.ramp(low, high, self.chip.reg["slope"], self.chip.reg["divisor"], self.chip.law)

    async def rate_request(self, plan: Plan, step: int) -> Plan:
        """I/O REQUEST low between two steps: a new rate in a continuous motion that slews, a halt in a normal one."""
        chip = self.chip
        low = chip.request.level == 0
        if not self.continuous:
            if low:
                if plan is not STOP:
                    self.departs("command", "I/O REQUEST")
                chip.finding("fly-rate-outside-continuous", "I/O REQUEST low in a normal motion: it halts without ramp")
                return STOP
            return plan
        missed = chip.request.changes - self.request_changes > 1  # low and high again between two looks
        self.request_changes = chip.request.changes
        if not low:
            if self.pending or missed:
                when = "while the motor was ramping" if self.pending else "within one step"
                chip.finding("request-withdrawn", f"a rate request came and went {when}: not seen")
            self.pending = self.served = self.told_held = False
            return plan
        ramping = plan.leg(step).name != "slew"
        self.pending = ramping and not self.served
        if ramping:
            return plan
        if self.served:
            if not self.told_held:
                self.told_held = True
                chip.finding(
                    "request-held", "I/O REQUEST still low after SLEW went high: ignored until it has been high"
                )
            return plan
        return await self.change_rate(profile.rate(plan, step))

    async def change_rate(self, current: int) -> Plan:
        """Take a new rate from the bus (s.7): up changes replace R, down changes replace F, for this motion."""
        rate = self.taken_rate()
        if rate == 0:
            return await self.zero_rate(current)
        if rate < current:
            self.first = rate
        self.slews_at(rate)
        if rate > current:
            return profile.steady(rate, ("up", self.ramp(current, rate)))
        if rate < current:
            return profile.steady(rate, ("down", profile.mirrored(self.ramp(rate, current))))
        return profile.steady(rate, ("up", ((sheet.STEP_TICKS[rate], 1),)))  # SLEW blinks for one step

    def slews_at(self, rate: int) -> None:
        """From now on the motion is to slew at another rate."""
        self.chip.axis1.log.change(partial(self.made.rates, self.first, rate))

    def taken_rate(self) -> int:
        """Read the rate byte, with one INSTROBE pulse; the request counts as served until it has been high."""
        chip = self.chip
        self.served = True
        byte: int = chip.bus.byte
        end = chip.clock.ps(chip.tick + T["strobe_width"])
        chip.instrobe.play(Wave(1, (chip.kernel.now, end), (0, 1)))
        if byte > sheet.RATE_TOP:
            chip.finding("range", f"rate {byte} on the fly: 127 is used")
        rate = min(byte, sheet.RATE_TOP)
        self.departs("command", f"R {rate}")
        return rate

    async def zero_rate(self, old: int) -> Plan:
        """Rate 0 on the fly: no further step; a higher rate goes on, ABORT ends the motion (s.7)."""
        chip = self.chip
        chip.slew.play(Wave(1, (chip.clock.ps(chip.tick + T["slew_blink"]),), (0,)))
        chip.axis1.log.change(dict)  # no rate is in force
        chip.motion_complete.drive(0)
        higher, ending = [f"a rate above {old}"] * (old < sheet.RATE_TOP), ["abort=0"] * self.abortable
        ways = ", or ".join(higher + ending) or "RESET"
        chip.waits(f"{self.text} at rate 0: {ways}")
        poll = T["wait_poll"]
        abort = ((chip.abort, 0),) if self.abortable else ()
        while True:
            if await chip.polled(chip.request, 1, poll, *abort) is chip.abort:
                return STOP
            if await chip.polled(chip.request, 0, poll, *abort) is chip.abort:
                return STOP
            rate = self.taken_rate()
            self.request_changes = chip.request.changes
            if rate > old:
                break
            chip.finding("fly-zero-low", f"rate {rate} at rate 0 changes nothing: it takes {ways}")
        chip.slew.drive(1)
        await self.uninhibited()
        chip.waits(self.progress)
        chip.motion_complete.drive(1)
        self.slews_at(rate)
        return profile.steady(rate, ("up", self.ramp(old, rate)))

    # ------------------------------------------------------------------------------------------- position on the fly
    def read_out(self, leg: str) -> int:
        """I/O SELECT is high as a step begins: put the position on the bus, high byte, low byte (fig. 6.5).

        Returns how many clocks longer the step becomes: none at a steady rate, 20 us (11 MHz) in a ramp.
        """
        chip = self.chip
        if chip.select.level != 1:
            return 0
        if chip.request.level == 0:
            chip.finding(
                "request-and-select", "I/O REQUEST and I/O SELECT together: the rate request goes first, no read-out"
            )
            return 0
        position = (chip.position + self.sign) % WRAP
        ps, width, apart = chip.clock.ps, T["strobe_width"], T["readout_spacing"]
        high = chip.tick + T["readout_delay"]
        low = high + apart
        falls = high + apart // 2  # MOTION COMPLETE, between the two strobes
        chip.outstrobe.play(Wave(1, (ps(high), ps(high + width), ps(low), ps(low + width)), (0, 1, 0, 1)))
        chip.motion_complete.play(Wave(1, (ps(falls), ps(falls + apart)), (0, 1)))
        levels = ((0xFF, position >> 8), (0xFF, position & 0xFF), None)
        chip.bus_driver.play(Wave(None, (ps(high), ps(falls), ps(falls + apart)), levels))
        return T["readout_stretch"] if leg in ("up", "down") else 0


STOP = Plan(())
PHASE_LEVELS = tuple(tuple(pattern[n] for pattern in sheet.PHASES) for n in range(4))
