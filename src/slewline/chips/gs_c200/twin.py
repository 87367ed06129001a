r"""The GS-C modules' motion, step by step: the slow and obvious reference for the fast path.

The fast path plans whole moves and promises step trains.  This twin counts the steps made and the steps to make,
samples the pins just before each step, and drives every edge when it is due; it reports no findings.

             setup                index 0         index 1
           |<----->|           |<------------>|<--------->|
    MOV  __/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾ ...
    DIR  ==X====================================
    CLOCK ‾‾‾‾‾‾‾‾‾\_/‾‾‾‾‾‾‾‾‾‾‾‾‾\_/‾‾‾‾‾‾‾‾‾\_ ...
                  sample         sample      sample: Z, input, ENABLE (when homing: EOT or HOME, ENABLE)

In a move of n steps, step i is followed by the period of the rate at ramp index min(i, n-2-i, R), and the
last step by a start-stop period.  If a stop is requested when i steps have been made, n is reduced so
that min(i, R+1) more steps follow, as many as the acceleration took.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isqrt

from ...core.context import ChipContext
from ...core.motion.plan import Leg, Plan
from ...core.motion.train import Playing, StepTrain
from ...core.wires.net import Driver, Net
from ...core.wires.waits import first_of, level, until
from .stepping.driver_lines import StepLines
from .stepping.position_counter import PositionCounter

SECOND = 10**12


def nearest(number: int, by: int) -> int:
    """Return `number` / `by`, rounded to the nearest whole number."""
    return (2 * number + by) // (2 * by)


class Stepwise:
    """The slow twin, which plays every motion step by step."""

    def __init__(
        self, chip: ChipContext, times_ps: Mapping[str, int], lines: StepLines, counter: PositionCounter
    ) -> None:
        self.chip, self.kernel, self.times_ps = chip, chip.kernel, times_ps
        self.lines, self.counter = lines, counter
        self.moving = self.stopped = False
        self.stop = Driver(Net(chip.kernel, f"{chip.name}.(stop)", pull=0), chip.name)
        self.made = 0  # steps of this motion
        self.number: int | None = None  # steps to make; None: endless
        self.begun_ps = 0  # start of the last step
        self.start_stop = self.top = self.ramp = 0  # S, T and R of this motion
        self.law = counter.law
        self.exact = chip.options.law == "constant acceleration"

    # ------------------------------------------------------------------------------------------------------- motions
    async def move(self, number: int, sign: int, text: str) -> None:
        """Make a move of `number` steps; `sign` is 1 clockwise, -1 counter-clockwise."""
        self.number = number
        await self.go(sign, text, number)

    async def run(self, limit: int, sign: int, text: str, watched: Net | None) -> None:
        """Step until a stop request, a low level of `watched`, or the end of the position counter."""
        self.number = None
        watcher = self.kernel.spawn(self.watch, watched, name="a low input stops") if watched is not None else None
        try:
            await self.go(sign, text, limit)
        finally:
            if watcher is not None:
                watcher.kill()

    async def watch(self, net: Net) -> None:
        """Sample an input once per instruction time until it is low; then request a stop."""
        while True:
            await until(self.kernel, self.kernel.now + self.times_ps["instruction"])
            if net.level == 0:
                self.counter.log.mark("event", net.name[-3:].upper())
                self.stop.drive(1)
                return

    async def go(self, sign: int, text: str, limit: int) -> None:
        """Make a motion, from the rising edge of MOV to the end of the last step period."""
        counter = self.counter
        self.made = 0
        self.start_stop, self.top, self.ramp = counter.registers.speeds
        if self.top <= self.start_stop:
            self.start_stop, self.ramp = self.top, 0
        self.stop.drive(0)
        self.chip.waits(f"{text} in motion")
        self.moving, self.stopped = True, False
        self.lines.ramp.drive(self.ramping())
        await self.set_out(sign)
        while await self.may_step(limit):
            self.lines.ramp.drive(self.ramping())
            if not self.made:
                counter.first_step(sign, self.number, limit)
            await self.step(self.period(self.index(self.made)), sign, self.made + 1 in (self.number, limit))
        self.rest()
        counter.over(self.stopped)

    async def home(self, sign: int, text: str) -> None:
        """Move to the end of travel, and back to the home position."""
        lines, speed = self.lines, self.counter.made.start_stop
        self.chip.waits(f"{text}: at the end of travel")
        self.moving = True
        self.ramp, self.number = 0, None
        for switch, direction, found in (
            (lines.eot, sign, ("limit", "EOT")),
            (lines.home, -sign, ("home", "HOME")),
        ):
            if switch.level == 1:
                await self.set_out(direction)
            while await self.wait_until_step_allowed(switch):
                await self.step(nearest(SECOND, 10 * speed), direction, False)
            self.counter.log.mark(*found)
        self.rest()

    def come_to_rest(self) -> None:
        """Z: end the motion with a ramp down."""
        self.stop.drive(1)

    async def kill(self) -> None:
        """Output no further step; a pulse that has begun is completed."""
        self.counter.mark_deviation()
        if self.moving:
            await until(self.kernel, self.begun_ps + self.times_ps["clock"])
            self.lines.clock.drive(1)
        self.counter.cut()
        self.rest()

    def cut(self) -> None:
        """Stop immediately at power-down."""
        self.counter.mark_deviation()
        self.counter.cut()
        self.moving = False

    # --------------------------------------------------------------------------------------------------------- steps
    async def set_out(self, sign: int) -> None:
        """Drive MOV and DIR, and let the time to the first step pass."""
        self.lines.mov.drive(1)
        self.lines.dir.drive(1 if sign > 0 else 0)
        await until(self.kernel, self.kernel.now + self.times_ps["dir_setup"])

    async def step(self, period: int, sign: int, last: bool) -> None:
        """Output a pulse, then wait until the next one is due."""
        clock, counter = self.lines.clock, self.counter
        begin = self.begun_ps = self.kernel.now
        leg = Leg(self.leg(self.made), ((period, 1),), 0, 1)
        self.made += 1
        clock.drive(0)
        playing = Playing(StepTrain(self.chip.clock, begin, leg.runs))
        counter.axis.follow(playing, sign, not counter.homing, Plan((leg,)))
        await until(self.kernel, begin + self.times_ps["clock"])
        clock.drive(1)
        if last:
            self.moving = False
            counter.over(self.stopped)
            if not self.chip.options.mov_hold:
                self.rest()
        await until(self.kernel, begin + period)

    def rest(self) -> None:
        """Lower MOV and RAMP at the end of a motion."""
        self.lines.mov.drive(0)
        self.lines.ramp.drive(0)
        self.moving = False

    def index(self, step: int) -> int:
        """Return the ramp index of the interval after a step."""
        down = self.number - 2 - step if self.number is not None else self.ramp
        return max(min(step, down, self.ramp), 0)

    def leg(self, step: int) -> str:
        """Return the leg to which the interval after a step belongs: "up", "slew" or "down"."""
        if self.ramp == 0 or self.number == 1:
            return "slew"
        if self.number is not None and step >= max(self.number - 1 - self.ramp, self.number // 2):
            return "down"
        return "up" if step < self.ramp else "slew"

    def ramping(self) -> int:
        """Return the level of RAMP during the next step; a single step has no ramp."""
        return int(self.number != 1 and self.index(self.made) < self.ramp)

    def period(self, index: int) -> int:
        """Return the step period at a ramp index, in ps; computed with integers if the acceleration is constant."""
        if self.ramp == 0:
            return nearest(SECOND, 10 * self.start_stop)
        if not self.exact:
            return round(SECOND / self.law(10.0 * self.start_stop, 10.0 * self.top, self.ramp, index))
        low, high = (10 * self.start_stop) ** 2, (10 * self.top) ** 2
        squared = 4 * SECOND**2 * self.ramp // (low * self.ramp + (high - low) * index)
        return nearest(isqrt(squared), 2)

    # ------------------------------------------------------------------------------------------------------- samples
    async def may_step(self, limit: int) -> bool:
        """Wait, just before a step, until it may be made; return False if there is no further step."""
        stop, enable = self.stop.net, self.lines.enable
        while True:
            if stop.level == 1:
                if self.made not in (self.number, limit):
                    self.counter.mark_deviation()
                end = self.made + (min(self.made, self.ramp + 1) if self.ramp else 0)
                self.number = end if self.number is None else min(self.number, end)
                self.stopped = self.number <= limit
            if self.made in (self.number, limit):
                return False
            if enable.level == 1:
                return True
            self.counter.mark_deviation("event", "ENABLE")
            if stop.level == 1:
                await level(enable, 1)
            else:
                await first_of(self.kernel, None, (stop, 1), (enable, 1))
            if enable.level == 1:
                await until(self.kernel, self.kernel.now + self.times_ps["release"])

    async def wait_until_step_allowed(self, switch: Net) -> bool:
        """Wait until a step of a homing run may be made; return False once the switch is active."""
        enable = self.lines.enable
        while switch.level == 1:
            if enable.level == 1:
                return True
            self.counter.mark_deviation("event", "ENABLE")
            await level(enable, 1)
            await until(self.kernel, self.kernel.now + self.times_ps["release"])
        return False
