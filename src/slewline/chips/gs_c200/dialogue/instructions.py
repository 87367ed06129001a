"""Effects of program instructions: one method for each, named after its sheet row (do_delay for DELAY)."""

from __future__ import annotations

from collections.abc import Awaitable, Mapping
from typing import Protocol

from ....core.context import ChipContext
from ....core.wires.net import Net
from ....core.wires.waits import polled, until
from ..registers import Registers
from ..stepping.driver_lines import StepLines, UserLines
from ..stepping.position_counter import PositionCounter
from .program_memory import Program


class Moves(Protocol):
    """The object that moves the motor: `Motion` in motion.py, or its slow twin in twin.py.

    A motion uses the parameters that `PositionCounter` recorded just before the motion.  `sign` is 1 for
    clockwise, -1 for counter-clockwise.  `moving` is True while MOV is high; `stopped` is True if the last
    motion was stopped by a command.
    """

    moving: bool
    stopped: bool

    def move(self, number: int, sign: int, text: str) -> Awaitable[None]:
        """Return an awaitable that makes a move of `number` steps."""

    async def run(self, limit: int, sign: int, text: str, watched: Net | None) -> None:
        """Run until a command stops the motion, `watched` (an input) is low, or `limit` steps have been made."""

    async def home(self, sign: int, text: str) -> None:
        """Find the end of travel in the direction of `sign`, then the home position in the opposite direction."""

    def come_to_rest(self) -> None:
        """End the motion with a ramp down."""

    async def kill(self) -> None:
        """End the motion without a ramp; the pulse in progress is completed."""

    def cut(self) -> None:
        """End the motion at power-down; a step at this very instant counts, and all later steps are dropped."""


class Instructions:
    """The handlers of all commands that act within a program; the handlers of I and f also act outside one."""

    def __init__(
        self,
        chip: ChipContext,
        times_ps: Mapping[str, int],
        registers: Registers,
        steps: StepLines,
        user: UserLines,
        counter: PositionCounter,
        program: Program,
        motion: Moves,
    ) -> None:
        self.chip, self.kernel, self.times_ps = chip, chip.kernel, times_ps
        self.registers, self.steps, self.user = registers, steps, user
        self.counter, self.program, self.motion = counter, program, motion
        rows = chip.sheet.commands
        self.until_size, self.loop_size = rows["U"].size, rows["L"].size
        self.velocity = next(row.head for row in rows if row.name == "VELOCITY")

    # ------------------------------------------------------------------------------------------- outputs, inputs, time
    async def do_activate(self, output: int) -> None:
        """A: drive a user output, 1 to 3, high."""
        self.user.outputs[output - 1].drive(1)

    async def do_clear(self, output: int) -> None:
        """C: drive a user output, 1 to 3, low."""
        self.user.outputs[output - 1].drive(0)

    async def do_delay(self, tenths: int) -> None:
        """D: pause for a number of tenths of a second."""
        self.chip.waits(f"waiting {tenths / 10:g} s (D{tenths})")
        await until(self.kernel, self.kernel.now + tenths * self.times_ps["delay_unit"])

    async def do_wait(self, number: int) -> None:
        """W: wait until a user input, 1 to 3, is high."""
        self.chip.waits(f"waiting for ui{number}=1 (W{number})")
        await polled(self.kernel, self.user.inputs[number - 1], 1, self.times_ps["instruction"])

    async def do_until(self, number: int) -> None:
        """U: repeat the program from its start until a user input, 1 to 3, is low."""
        program, net = self.program, self.user.inputs[number - 1]
        high = net.level != 0
        if program.pc == self.until_size and not self.chip.options.plain_u:
            program.until = net if high else None  # at the start of the program it is tested again at the end
        elif high:
            program.pc = 0

    # ---------------------------------------------------------------------------------------------- loops and jumps
    async def do_loop_start(self) -> None:
        """L0: make the next instruction the start of a loop."""
        program = self.program
        outside = program.pc if self.chip.options.nested_loops else 0
        program.loops = [loop for loop in program.loops if loop[0] < outside]
        program.loops.append([program.pc, 0])

    async def do_loop(self, passes: int) -> None:
        """L: repeat from the loop start until the given number of passes, 1 to 255, is complete."""
        program = self.program
        if not program.loops:
            self._check_start(passes)
            program.loops.append([0, 0])
        loop = program.loops[-1]
        loop[1] += 1
        if loop[1] < passes:
            program.pc = loop[0]
        else:
            program.loops.pop()

    def _check_start(self, passes: int) -> None:
        """Report, once, a loop end that follows another loop end and has no start of its own."""
        here = self.program.pc - self.loop_size
        before = [row.name for at, row, _ in self.program.fetched() if at < here and row.name in ("LOOP_START", "LOOP")]
        if not self.program.loop_reported and before and before[-1] == "LOOP":
            self.program.loop_reported = True
            self.chip.finding("loop-without-start", f"L{passes} has no L0 of its own: it repeats from location 0")

    async def do_jump(self, target: int) -> None:
        """j: continue at a location, 0 to 118."""
        self.program.pc = target

    async def do_jump_on(self, inputs: int, target: int) -> None:
        """jc: continue at a location if the levels of the user inputs equal `inputs` (bit 0 is input 1)."""
        if self.user.read_inputs() == inputs:
            self.program.pc = target

    # ------------------------------------------------------------------------------------------------------- motion
    async def do_start_stop(self, speed: int) -> None:
        """S: load the start-stop speed, in units of 10 steps/s."""
        self.registers.start_stop = speed

    async def do_top_speed(self, speed: int) -> None:
        """T: load the top speed, in units of 10 steps/s."""
        self.registers.top_speed = speed

    async def do_ramp(self, length: int) -> None:
        """R: load the length of both ramps, 1 to 999 steps."""
        self.registers.ramp = length

    def do_move(self, steps: int) -> Awaitable[None]:
        """+ or -: return an awaitable that moves by a number of steps."""
        return self._move_by(steps, f"{steps:+d}")

    def do_goto(self, position: int) -> Awaitable[None]:
        """G: return an awaitable that moves to a position."""
        return self._move_by(position - self.counter.position, f"G{position}")

    async def _move_by(self, steps: int, text: str) -> None:
        if not steps or self._speeds_missing():
            return
        if self.counter.room(steps) < abs(steps):
            self._overflow(f"{text} from {self.counter.position} exceeds the position counter")
            return
        direction = 1 if steps > 0 else -1
        self.counter.set_out(text, direction)
        await self.motion.move(abs(steps), direction, text)

    async def do_velocity(self, direction: int) -> None:
        """g: run in a direction, 1 or -1, until K or Z."""
        await self._run_endless(direction, None)

    async def do_controlled_velocity(self, direction: int, number: int) -> None:
        """Handle g with a user input: run in `direction` (1 or -1) until input `number` (1 to 3) is low."""
        await self._run_endless(direction, number)

    async def _run_endless(self, direction: int, number: int | None) -> None:
        if self._speeds_missing():
            return
        watched = None if number is None else self.user.inputs[number - 1]
        if watched is not None and watched.level == 0:
            return
        limit = self.counter.room(direction)
        text = "a run" + (f" until ui{number}=0" if number else " until K or Z")
        if limit:
            spelled = f"{self.velocity}{'+' if direction > 0 else '-'}{number or ''}"
            self.counter.set_out(spelled, direction, endless=True)
            await self.motion.run(limit, direction, text, watched)
        if not limit or self.counter.full(direction, self.motion.stopped):
            self._overflow("an endless motion has reached the end of the position counter")

    def _overflow(self, text: str) -> None:
        self.chip.finding("E5", text)
        self.registers.overflow = self.program.ending = True

    def _speeds_missing(self) -> bool:
        """Return whether any of S, T and R is not set; if so, report a finding and end the program."""
        if all(self.registers.speeds):
            return False
        self.chip.finding("no-speed", "a jump leads to a motion before S, T and R are set: the program ends")
        self.program.ending = True
        return True

    # ------------------------------------------------------------------------------------------------ position counter
    async def do_force(self, position: int) -> None:
        """f: load the position counter."""
        self.counter.load(position, f"f{position}")

    async def do_initialize(self, what: int) -> None:
        """I: clear the position counter and reset the driver (1), clear the user outputs (2), or do both (3)."""
        if what & 2:
            self.user.clear()
        if what & 1:
            self.counter.load(0, f"I{what}")
            await self.steps.pulse_reset()
