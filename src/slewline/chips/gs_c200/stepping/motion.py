"""The plan player of a GS-C module: it promises a plan's pulses, and withdraws them if an input changes.

    CLOCK   ‾‾‾‾|_|‾‾‾‾‾‾‾‾‾‾‾‾‾|_|‾‾‾‾‾‾      a step is the falling edge; low for 1.7 µs
                b               b'             ENABLE, Z and homing switches: sampled just before b
    MOV     _|‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾|______      up with DIR, 10 µs before the first step; down with the last pulse

A step that ENABLE delays is not lost: the profile waits, and then continues with this step.
"""

from __future__ import annotations

from collections.abc import Awaitable, Mapping

from ....core.context import ChipContext
from ....core.motion.plan import Plan, tail
from ....core.motion.step_views import StrobeView
from ....core.motion.train import OPEN, Playing, StepTrain, Train
from ....core.wires.net import Driver, Net, Wave
from ....core.wires.waits import first_of, level, polled, until
from .. import profile
from .driver_lines import StepLines
from .position_counter import PositionCounter

RAMPS = ("up", "down")


def input_name(net: Net) -> str:
    """Return the sheet's name of an input."""
    return net.name.rpartition(".")[2].upper()


class Motion:
    """The stepping part of the firmware.

    `moving` is True while MOV is high; `stopped` is True if the last motion was stopped by a command.
    """

    def __init__(
        self, chip: ChipContext, times_ps: Mapping[str, int], lines: StepLines, counter: PositionCounter
    ) -> None:
        self.chip, self.kernel, self.clock = chip, chip.kernel, chip.clock
        self.lines, self.counter, self.mov_hold = lines, counter, chip.options.mov_hold
        self.width, self.setup = times_ps["clock"], times_ps["dir_setup"]
        self.release, self.instruction = times_ps["release"], times_ps["instruction"]
        self.moving = self.stopped = False
        self.playing: Playing | None = None
        self.fresh = False  # no step has been made so far
        self.number: int | None = None  # steps of the motion; None: endless, up to the end of the counter
        self.limit = OPEN  # steps to the end of the counter
        self.stop_net = Net(self.kernel, f"{chip.name}.stop", active=1)
        self.stop = Driver(self.stop_net, chip.name)  # active: decelerate to a stop

    # ----------------------------------------------------------------------------------------------------- motions
    def move(self, number: int, sign: int, text: str) -> Awaitable[None]:
        """Return an awaitable that makes a move of `number` steps; `sign` is 1 clockwise, -1 counter-clockwise."""
        self.number, self.limit = number, OPEN
        return self.through(profile.move(number, *self.counter.made), sign, text)

    async def through(self, plan: Plan, sign: int, text: str) -> None:
        """Play a whole plan, and wait for the end of its last interval."""
        self.begin(text)
        end = await self.play(plan, sign)
        self.rest()
        self.counter.over(self.stopped)
        await until(self.kernel, end)
        if self.mov_hold:
            self.lines.rest()

    async def run(self, limit: int, sign: int, text: str, watched: Net | None) -> None:
        """Run until the stop net is active, until the input `watched` is low, or until `limit` steps are made."""
        kernel, every = self.kernel, self.instruction
        self.number, self.limit = None, limit
        plan = profile.endless(*self.counter.made, limit)
        if watched is None:
            await self.through(plan, sign, text)
            return

        async def watch() -> None:
            await until(kernel, kernel.now + every)  # the first sample is over
            await polled(kernel, watched, 0, every)
            self.counter.log.mark("event", input_name(watched))
            self.stop.activate()

        watcher = kernel.spawn(watch, name=f"{self.chip.name} watches {watched.name}")
        try:
            await self.through(plan, sign, text)
        finally:
            watcher.kill()

    async def home(self, sign: int, text: str) -> None:
        """Find the end of travel in direction `sign`, then, in reverse at the same rate, the home position."""
        lines = self.lines
        self.begin(text)
        self.counter.axis.homing = sign
        try:
            for switch, direction, kind in ((lines.eot, sign, "limit"), (lines.home, -sign, "home")):
                if not switch.is_active:
                    await self.play(profile.steady(profile.period(self.counter.made.start_stop)), direction, switch)
                self.counter.log.mark(kind, input_name(switch))
        finally:
            self.counter.axis.homing = 0
        self.rest()
        self.lines.rest()

    def begin(self, text: str) -> None:
        """Begin a motion."""
        self.moving, self.stopped, self.text = True, False, text
        self.fresh = True
        self.stop.deactivate()
        self.chip.waits(f"{text} in motion")

    def rest(self) -> None:
        """End a motion at the end of its last pulse."""
        self.moving = False
        if not self.mov_hold:
            self.lines.rest()

    def come_to_rest(self) -> None:
        """Z: end the motion with a ramp down."""
        self.stop.activate()

    async def kill(self) -> None:
        """End the motion without a ramp; the pulse in progress is completed.  The counter includes all steps output."""
        self.counter.mark_deviation()
        if self.moving and self.playing is not None:
            train, now = self.playing.train, self.kernel.now
            begun = self.playing.count(now)
            end = max(now, train.end(begun - 1) + self.width) if begun else now
            self.end_by(end + 1)
            await until(self.kernel, end)
        self.counter.cut()
        self.moving = False
        self.lines.rest()

    def cut(self) -> None:
        """End the motion at power-down; a step at this very instant counts, and all later steps are dropped."""
        self.end_by(self.kernel.now + 1)
        self.counter.mark_deviation()
        self.counter.cut()
        self.moving = False

    def end_by(self, ps: int) -> None:
        """End the promised pulses at a time (ps), unless they end earlier."""
        if self.playing is not None and (self.playing.until is None or ps < self.playing.until):
            self.playing.until = ps
            self.lines.clock.renew()

    # ------------------------------------------------------------------------------------------------ playing a plan
    async def play(self, plan: Plan, sign: int, switch: Net | None = None) -> int:
        """Play a plan, or its replacement after a stop, to the last pulse; return the end of the last interval, ps.

        Args:
            switch: an input that ends the motion if it is low just before a step.
        """
        lines, counter, kernel = self.lines, self.counter, self.kernel
        playing = self.playing = None  # no step of this plan has been played
        lines.dir.drive(int(sign > 0))
        lines.mov.activate()
        lines.ramp.activate(bool(plan.steps) and plan.legs[0].name in RAMPS)
        await until(kernel, kernel.now + self.setup)
        step, fresh, stopping = 0, True, False
        while step < plan.steps:
            if switch is not None and switch.is_active:
                return kernel.now
            if self.stop_net.is_active and not stopping:
                counter.mark_deviation()
                room, plan = plan.steps - step, profile.stopped(plan, step)
                self.stopped = plan.steps <= room
                plan, step, fresh, stopping = profile.within(plan, room), 0, True, True
                continue
            if lines.enable.is_inactive:
                counter.mark_deviation("event", "ENABLE")
                await self.hold(not stopping)
                fresh = True
                continue
            if fresh or playing is None:
                playing = self.schedule(plan, step, sign)
            self.show_ramps(plan, step, playing.train)
            step, fresh = await self.until_sample(playing, plan.steps, switch), False
        return kernel.now if playing is None else playing.train.end(plan.steps)

    def schedule(self, plan: Plan, step: int, sign: int) -> Playing:
        """Promise a pulse train that begins now, with step `step` of a plan, and return it."""
        counter = self.counter
        if self.fresh:
            counter.first_step(sign, self.number, self.limit)
            self.fresh = False
        self.base = step
        runs = tail(plan.runs, step) if step else plan.runs
        self.playing = playing = Playing(StepTrain(self.clock, self.kernel.now, runs))
        counter.axis.follow(playing, sign, counted=not counter.homing, plan=plan, step=step)
        self.lines.clock.play(StrobeView(playing, self.width))
        return playing

    def show_ramps(self, plan: Plan, step: int, train: Train) -> None:
        """Promise the edges of RAMP from a step, which begins now, to the end of its plan."""
        ramp, times, levels = self.lines.ramp, [], []
        level = shown = ramp.at(self.kernel.seen)
        for leg in plan.legs:
            if step < leg.end and (wanted := ramp.level_when(leg.name in RAMPS)) != level:
                times.append(train.end(leg.first - self.base))
                levels.append(level := wanted)
        if times and times[0] > self.kernel.now:
            ramp.wave(shown, tuple(times), tuple(levels))
        elif times:
            ramp.drive(Wave(shown, tuple(times), tuple(levels)))

    async def until_sample(self, playing: Playing, steps: int, switch: Net | None) -> int:
        """Wait until the next decision, while pulses are output; return the number of the step that is due then.

        The decision is due at the end of the last pulse of the plan, which has `steps` steps.  If an input changes
        earlier, the decision is due at the start of the first step after this change.
        """
        kernel, train, lines = self.kernel, playing.train, self.lines
        if playing.until is not None:  # the input has changed back
            playing.until = None
            lines.clock.renew()
        decision = train.end(steps - 1 - self.base) + self.width if steps < OPEN else None
        watched: list[tuple[Net, int | None]] = [lines.enable.when_inactive]
        if not self.stop_net.is_active:
            watched.append(self.stop_net.when_active)
        if switch is not None:
            watched.append(switch.when_active)
        if await first_of(kernel, decision, *watched) is None:
            return steps
        following = train.count(kernel.now)
        if following + self.base >= steps:  # nothing begins before the decision
            await until(kernel, decision or kernel.now)
            return steps
        look = train.end(following)
        playing.until = look
        lines.clock.renew()
        lines.ramp.drive(lines.ramp.at(kernel.now))
        await until(kernel, look)
        return self.base + following

    async def hold(self, stoppable: bool) -> None:
        """Wait before the next step while ENABLE is low; if `stoppable`, only until a stop is requested."""
        chip, kernel, enable = self.chip, self.kernel, self.lines.enable
        chip.waits(f"{self.text} held by enable=0")
        if stoppable:
            await first_of(kernel, None, enable.when_active, self.stop_net.when_active)
            if enable.is_inactive:
                return
        else:
            await level(*enable.when_active)
        await until(kernel, kernel.now + self.release)
        chip.waits(f"{self.text} in motion")
