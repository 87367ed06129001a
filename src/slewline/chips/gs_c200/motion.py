"""How a GS-C module plays a plan: promise it whole, look just before each step, withdraw when an input departs.

    CLOCK   ‾‾‾‾|_|‾‾‾‾‾‾‾‾‾‾‾‾‾|_|‾‾‾‾‾‾      a step is the falling edge; low for 1.7 us
                b               b'             ENABLE, Z and the switches of a homing: as they were before b
    MOV     _|‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾|______      up with DIR, 10 us before the first step; down with the last pulse

A step that ENABLE holds is not lost: the profile goes by steps, so it waits, and goes on where it was.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.net import Driver, Net
from ...core.plan import Plan, tail
from ...core.step_views import StrobeView
from ...core.train import OPEN, Playing, StepTrain
from ...core.waits import first_of, level, polled, until
from . import profile

if TYPE_CHECKING:
    from .state import State

RAMPS = ("up", "down")


def input_name(net: Net) -> str:
    """The name of an input, as the sheet writes it."""
    return net.name.rpartition(".")[2].upper()


class Motion:
    """The stepping part of the firmware.  `moving` is true from MOV high to MOV low; `stopped` tells of the last motion
    whether it came to rest because it was told to."""

    def __init__(self, chip: State) -> None:
        self.chip, self.kernel = chip, chip.kernel
        self.moving = self.stopped = False
        self.playing: Playing | None = None
        self.fresh = False  # no step has been made
        self.number: int | None = None  # steps of the motion; None: no end but that of the counter
        self.limit = OPEN  # steps to that
        self.stop_net = Net(self.kernel, f"{chip.name}.stop")
        self.stop = Driver(self.stop_net, chip.name)  # 1: come to rest

    # ----------------------------------------------------------------------------------------------------- motions
    async def move(self, number: int, sign: int, text: str) -> None:
        """A move of so many steps."""
        self.number, self.limit = number, OPEN
        await self.through(profile.move(number, *self.chip.speeds_in_force(), self.chip.law), sign, text)

    async def through(self, plan: Plan, sign: int, text: str) -> None:
        """Play a plan to its end, and let the last interval pass."""
        self.begin(text)
        end = await self.play(plan, sign)
        self.rest()
        self.chip.motion_over(self.stopped)
        await until(self.kernel, end)
        if self.chip.options.mov_hold:
            self.outputs_rest()

    async def run(self, limit: int, sign: int, text: str, watched: Net | None) -> None:
        """Run until the stop net says so, until an input is low, or until `limit` steps are made."""
        kernel, chip = self.kernel, self.chip
        self.number, self.limit = None, limit
        plan = profile.endless(*chip.speeds_in_force(), chip.law, limit)
        if watched is None:
            await self.through(plan, sign, text)
            return

        async def watch() -> None:
            await until(kernel, kernel.now + chip.instruction_ps)  # the first look is over
            await polled(kernel, watched, 0, chip.instruction_ps)
            chip.axis1.log.mark("event", input_name(watched))
            self.stop.drive(1)

        watcher = kernel.spawn(watch(), f"{chip.name} watches {watched.name}")
        try:
            await self.through(plan, sign, text)
        finally:
            watcher.kill()

    async def home(self, sign: int, speed: int, text: str) -> None:
        """Find the end of travel, then the home position, at the start-stop speed."""
        chip = self.chip
        self.begin(text)
        for switch, way, kind in ((chip.eot, sign, "limit"), (chip.home, -sign, "home")):
            if switch.level != 0:
                await self.play(profile.steady(profile.period(speed)), way, switch)
            chip.axis1.log.mark(kind, input_name(switch))
        self.rest()
        self.outputs_rest()

    def begin(self, text: str) -> None:
        """A motion begins."""
        self.moving, self.stopped, self.text = True, False, text
        self.fresh = True
        self.stop.drive(0)
        self.chip.waits(f"{text} in motion")

    def rest(self) -> None:
        """The last pulse is over."""
        self.moving = False
        if not self.chip.options.mov_hold:
            self.outputs_rest()

    def outputs_rest(self) -> None:
        """MOV and RAMP fall together."""
        self.chip.mov.drive(0)
        self.chip.ramp.drive(0)

    async def kill(self) -> None:
        """No ramp, no further step; the pulse in progress is completed.  The counter keeps what was issued."""
        self.chip.departs()
        if self.moving and self.playing is not None:
            train, now = self.playing.train, self.kernel.now
            begun = self.playing.begun(now)
            end = max(now, train.begin(begun - 1) + self.chip.clock_ps) if begun else now
            self.end_by(end + 1)
            await until(self.kernel, end)
        self.chip.axis1.log.end("cut")
        self.moving = False
        self.outputs_rest()

    def cut(self) -> None:
        """The supply is gone: steps of this instant stand, later ones do not."""
        self.end_by(self.kernel.now + 1)
        self.chip.departs()
        self.chip.axis1.log.end("cut")
        self.moving = False

    def end_by(self, ps: int) -> None:
        """Bound the promise, unless it ends earlier."""
        if self.playing is not None and (self.playing.until is None or ps < self.playing.until):
            self.playing.until = ps
            self.chip.clock_pin.renew()

    # ------------------------------------------------------------------------------------------------ playing a plan
    async def play(self, plan: Plan, sign: int, switch: Net | None = None) -> int:
        """Play a plan, and what becomes of it, until its last pulse is over; returns when its last interval will be.

        Args:
            switch: an input that ends the motion when it is low just before a step.
        """
        chip, kernel = self.chip, self.kernel
        self.playing = None  # of this plan nothing is played yet
        chip.dir.drive(int(sign > 0))
        chip.mov.drive(1)
        chip.ramp.drive(int(bool(plan.steps) and plan.leg(0).name in RAMPS))
        await until(kernel, kernel.now + chip.dir_setup_ps)
        step, fresh, stopping = 0, True, False
        while step < plan.steps:
            if switch is not None and switch.level == 0:
                return kernel.now
            if self.stop_net.level == 1 and not stopping:
                chip.departs()
                room, plan = plan.steps - step, profile.stopped(plan, step)
                self.stopped = plan.steps <= room
                plan, step, fresh, stopping = profile.within(plan, room), 0, True, True
                continue
            if chip.enable.level == 0:
                chip.departs("event", "ENABLE")
                await self.held(not stopping)
                fresh = True
                continue
            leg = plan.leg(step)
            chip.ramp.drive(int(leg.name in RAMPS))
            if fresh:
                self.lay(plan, step, sign)
            step, fresh = await self.until_look(leg.end, plan.steps, switch), False
        if not plan.steps:
            return kernel.now
        assert self.playing is not None  # its steps have been played
        return self.playing.train.begin(plan.steps)

    def lay(self, plan: Plan, step: int, sign: int) -> None:
        """Promise a train whose first step begins now."""
        chip = self.chip
        if self.fresh:
            chip.first_step(sign, self.number, self.limit)
            self.fresh = False
        self.base = step
        self.playing = Playing(StepTrain(chip.clock, self.kernel.now, tail(plan.runs, step)))
        chip.axis1.follow(self.playing, sign, counted=not chip.homing, plan=plan, step=step)
        chip.clock_pin.play(StrobeView(self.playing, chip.clock_ps))

    async def until_look(self, stop: int, steps: int, switch: Net | None) -> int:
        """Let the promise run until a decision; returns the step of the plan that is about to begin.

        The decision is at the begin of step `stop`, or earlier when an input departs; the end of the last pulse is one.
        """
        kernel, playing = self.kernel, self.playing
        assert playing is not None
        train, chip = playing.train, self.chip
        last = stop >= steps
        playing.until = None if last else train.begin(stop - self.base)
        chip.clock_pin.renew()
        decision = None if steps >= OPEN and last else playing.until
        if last and steps < OPEN:
            decision = train.begin(steps - 1 - self.base) + chip.clock_ps
        watched: list[tuple[Net, int | None]] = [(chip.enable, 0)]
        if self.stop_net.level != 1:
            watched.append((self.stop_net, 1))
        if switch is not None:
            watched.append((switch, 0))
        if await first_of(kernel, decision, *watched) is None:
            return stop
        following = train.begun(kernel.now)
        if following + self.base >= stop:  # nothing begins before the decision
            await until(kernel, decision or kernel.now)
            return stop
        look = train.begin(following)
        playing.until = look
        chip.clock_pin.renew()
        await until(kernel, look)
        return self.base + following

    async def held(self, stoppable: bool) -> None:
        """ENABLE is low: the next step waits for it, or for a stop that may end the motion here."""
        chip, kernel = self.chip, self.kernel
        chip.waits(f"{self.text} held by enable=0")
        if stoppable:
            await first_of(kernel, None, (chip.enable, 1), (self.stop_net, 1))
            if chip.enable.level == 0:
                return
        else:
            await level(chip.enable, 1)
        await until(kernel, kernel.now + chip.release_ps)
        chip.waits(f"{self.text} in motion")
