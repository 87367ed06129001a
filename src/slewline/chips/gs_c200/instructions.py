"""The instructions of a program, and the run of one.

An instruction takes its time first and then acts, so that a pulse between two instructions exists.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING

from ...core.table import Row
from ...core.waits import polled, until
from .sheet import TENTH_PS
from .state import State

if TYPE_CHECKING:
    from .motion import Motion
    from .twin import Stepwise

Handler = Callable[..., Awaitable[str | None]]
PARAMETERS = {"S": "start_stop", "T": "top_speed", "R": "ramp"}


class Instructions(State):
    """What each delayed command does: a method for each, named after its row."""

    motion: Motion | Stepwise
    handlers: dict[str, Handler]
    in_work = False  # a line is in work

    # ---------------------------------------------------------------------------------------------------- the program
    def run_program(self, work: Awaitable[None] | None = None) -> None:
        """Begin to run the program, or a homing."""
        self.running, self.ending = True, False
        self.rdy.drive(0)
        self.program_task = self.kernel.spawn(self._run(work), f"{self.name} runs")
        self.tasks.append(self.program_task)
        self.refresh_idle()

    async def _run(self, work: Awaitable[None] | None) -> None:
        await (work if work is not None else self._execute())
        self.end_program()

    async def end_now(self) -> None:
        """K, or Z without motion: whatever runs is over."""
        if self.program_task is not None:
            self.program_task.kill()
        await self.motion.kill()
        self.end_program()

    def end_program(self) -> None:
        """Nothing runs any more."""
        self.program_task = None
        self.at, self.other_work = None, ""
        self.on_command("")
        self.tasks = [task for task in self.tasks if task.alive]
        self.running = False
        if not self.in_work:
            self.rdy.drive(None)
        self.waits("a command")
        self.refresh_idle()

    async def _execute(self) -> None:
        """Instruction after instruction, to the end of the program."""
        self.begin_run()
        program = bytes(self.memory)
        starts = {each.address: self._fetch(program, each.address) for each in self.program_rows()}
        while not self.ending:
            at = self.pc
            if at >= len(program):
                if self.until_input is None or self.inputs[self.until_input - 1].level == 0:
                    return
                self.pc = 0
                await self._instruction_time()
                continue
            if at not in starts:
                self.finding("jump-inside", f"a jump to location {at}, inside an instruction: the program stops")
                return
            row, values = starts[at]
            self.at = at
            if self.on_instruction:
                self.on_instruction(at)
            if self.on_command:
                self.on_command(self.under_way)
            self.waits(f"{row.form} at location {at} in work")
            await self._instruction_time()
            self.pc = at + row.size
            await self.handlers[row.form](*values)

    def begin_run(self) -> None:
        """What a run starts with."""
        self.pc = 0
        self.loops: list[list[int]] = []  # [where it begins, passes made]
        self.loop_told = False  # a loop end without a start has been told of
        self.until_input: int | None = None  # U at location 0 repeats the program while this input is 1

    def _fetch(self, program: bytes, at: int) -> tuple[Row, tuple[int, ...]]:
        row = self.rows[program[at]]
        return row, row.unpack(program[at + 1 : at + row.size], program[at])

    async def _instruction_time(self) -> None:
        await until(self.kernel, self.kernel.now + self.instruction_ps)

    def unset_before_motion(self) -> str:
        """Which of S, T, R a motion of the stored program would lack, in the order of the listing."""
        known = {letter for letter, name in PARAMETERS.items() if getattr(self.state, name)}
        at = 0
        while at < len(self.memory):
            row = self.rows[self.memory[at]]
            if row.motion and len(known) < len(PARAMETERS):
                return "".join(letter for letter in PARAMETERS if letter not in known)
            known |= {row.form} & set(PARAMETERS)
            at += row.size
        return ""

    # ------------------------------------------------------------------------------------------- outputs, inputs, time
    async def do_activate(self, output: int) -> None:
        self.outputs[output - 1].drive(1)

    async def do_clear(self, output: int) -> None:
        self.outputs[output - 1].drive(0)

    async def do_delay(self, tenths: int) -> None:
        self.waits(f"D{tenths}")
        await until(self.kernel, self.kernel.now + tenths * TENTH_PS)

    async def do_wait(self, number: int) -> None:
        self.waits(f"W{number}: ui{number}=1")
        await polled(self.kernel, self.inputs[number - 1], 1, self.instruction_ps)

    async def do_until(self, number: int) -> None:
        high = self.inputs[number - 1].level != 0
        if self.pc == self.rows[ord("U")].size and not self.options.plain_u:
            self.until_input = number if high else None  # at the head of the program it is tested again at the end
        elif high:
            self.pc = 0

    # ---------------------------------------------------------------------------------------------- loops and jumps
    async def do_loop_start(self) -> None:
        outside = self.pc if self.options.nested_loops else 0
        self.loops = [loop for loop in self.loops if loop[0] < outside]
        self.loops.append([self.pc, 0])

    async def do_loop(self, passes: int) -> None:
        if not self.loops:
            self._check_start(passes)
            self.loops.append([0, 0])
        loop = self.loops[-1]
        loop[1] += 1
        if loop[1] < passes:
            self.pc = loop[0]
        else:
            self.loops.pop()

    def _check_start(self, passes: int) -> None:
        """Tell once of a loop end that stands behind another one, without a start of its own."""
        here = self.pc - self.rows[ord("L")].size
        before = [row.text for row in self.program_rows() if row.address < here and row.text.startswith("L")]
        if not self.loop_told and before and before[-1] != "L0":
            self.loop_told = True
            self.finding("loop-without-start", f"L{passes} has no L0 of its own: it repeats from location 0")

    async def do_jump(self, target: int) -> None:
        self.pc = target

    async def do_jump_on(self, inputs: int, target: int) -> None:
        if self.read_inputs() == inputs:
            self.pc = target

    # ------------------------------------------------------------------------------------------------------- motion
    async def do_start_stop(self, speed: int) -> None:
        self.state.start_stop = speed

    async def do_top_speed(self, speed: int) -> None:
        self.state.top_speed = speed

    async def do_ramp(self, length: int) -> None:
        self.state.ramp = length

    async def do_move(self, steps: int) -> None:
        await self._move_by(steps, f"{steps:+d}")

    async def do_goto(self, position: int) -> None:
        await self._move_by(position - self.position, f"G{position}")

    async def _move_by(self, steps: int, text: str) -> None:
        if steps and self._may_move():
            if self.counter.room(steps) < abs(steps):
                self._overflow(f"{text} from {self.position} leaves the position counter")
                return
            direction = 1 if steps > 0 else -1
            self.counter.set_out(text, direction)
            await self.motion.move(abs(steps), direction, text)

    async def do_velocity(self, direction: int) -> None:
        await self._run_endless(direction, None)

    async def do_controlled_velocity(self, direction: int, number: int) -> None:
        await self._run_endless(direction, number)

    async def _run_endless(self, direction: int, number: int | None) -> None:
        if not self._may_move():
            return
        watched = None if number is None else self.inputs[number - 1]
        if watched is not None and watched.level == 0:
            return
        limit = self.counter.room(direction)
        text = "a run" + (f" until ui{number}=0" if number else " until K or Z")
        if limit:
            spelled = f"{self.rows[ord('g')].head}{'+' if direction > 0 else '-'}{number or ''}"
            self.counter.set_out(spelled, direction, endless=True)
            await self.motion.run(limit, direction, text, watched)
        if not limit or self.counter.full(direction, self.motion.stopped):
            self._overflow("an endless motion has reached the end of the position counter")

    def _overflow(self, text: str) -> None:
        self.finding("E5", text)
        self.state.overflow = self.ending = True

    def _may_move(self) -> bool:
        if all(self.state.speeds):
            return True
        self.finding("no-speed", "a jump leads to a motion before S, T and R are set: the program ends")
        self.ending = True
        return False

    # ------------------------------------------------------------------------------------------------ position counter
    async def do_force(self, position: int) -> None:
        self.counter.load(position, f"f{position}")

    async def do_initialize(self, what: int) -> None:
        if what & 2:
            for driver in self.outputs:
                driver.drive(0)
        if what & 1:
            self.counter.load(0, f"I{what}")
            await self.pulse_reset()

    async def pulse_reset(self) -> None:
        """The RESET output: 400 us low."""
        self.reset_pin.drive(0)
        await until(self.kernel, self.kernel.now + self.reset_ps)
        self.reset_pin.drive(1)
