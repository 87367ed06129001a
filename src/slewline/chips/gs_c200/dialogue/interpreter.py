"""The execution of the stored program, of a homing run, and of an instruction outside a program.

An instruction acts at the end of its execution time.  Therefore an output is active for a visible time
even if one instruction activates it and the next instruction clears it.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping

from ....core.context import ChipContext
from ....core.time.kernel import Task
from ....core.wires.waits import until
from ....language.dialect import Command
from ..activity import PROGRAM, Activity
from ..stepping.position_counter import PositionCounter
from .instructions import Instructions, Moves
from .program_memory import Program

Handler = Callable[..., Awaitable[str | None]]


class Interpreter:
    """The executor of one piece of work at a time; it calls `refresh_idle` when a piece of work begins or ends."""

    def __init__(
        self,
        chip: ChipContext,
        refresh_idle: Callable[[], None],
        times_ps: Mapping[str, int],
        activity: Activity,
        counter: PositionCounter,
        program: Program,
        motion: Moves,
        instructions: Instructions,
    ) -> None:
        self.refresh_idle = refresh_idle
        self.chip, self.kernel, self.instruction_ps = chip, chip.kernel, times_ps["instruction"]
        self.activity, self.counter, self.program, self.motion = activity, counter, program, motion
        self.handlers: dict[str, Handler] = {
            row.form: getattr(instructions, row.handler)
            for row in chip.sheet.commands
            if hasattr(instructions, row.handler)
        }
        self.task: Task | None = None

    @property
    def running(self) -> bool:
        """True while a program, a homing run or an instruction outside a program is in progress."""
        return self.task is not None

    @property
    def under_way(self) -> str:
        """The program instruction in progress, or other work in progress, as text; "" for none."""
        return self.activity.text if self.program.at is None else self.program.text_at(self.program.at)

    # ------------------------------------------------------------------------------------------------ begin and end
    def run(self, work: Callable[[], Awaitable[None]]) -> None:
        """Begin a piece of work: the stored program (`execute`), a homing run or a single instruction."""
        self.task = self.kernel.spawn(self._run, work, name=f"{self.chip.name} runs")
        self.activity.begin(PROGRAM)
        self.refresh_idle()

    async def _run(self, work: Callable[[], Awaitable[None]]) -> None:
        await work()
        self._end()

    def _end(self) -> None:
        """End the work."""
        self.task = self.program.at = None
        self.activity.works_on("")
        self.chip.waits("waiting for a command")
        self.activity.end(PROGRAM)
        self.refresh_idle()

    async def kill(self, letter: str) -> None:
        """End all work immediately, on command K, or on Z if there is no motion that can decelerate."""
        if self.motion.moving:
            self.counter.log.mark("command", letter)
        if self.task is not None:
            self.task.kill()
        await self.motion.kill()
        self._end()

    async def come_to_rest(self) -> None:
        """Z: end the program as soon as its motion has decelerated.

        If no motion is in progress, or during a homing run, end all work immediately.
        """
        if self.motion.moving and not self.counter.homing:
            self.counter.log.mark("command", "Z")
            self.counter.log.stop()
            self.program.ending = True
            self.motion.come_to_rest()
        elif self.running:
            await self.kill("Z")

    def cut(self) -> None:
        """End all work at power-down; a step at this very instant counts, and all later steps are dropped."""
        if self.task is not None:
            self.task.kill()
            self.task = None
        self.motion.cut()

    # ----------------------------------------------------------------------------------------------------- execution
    async def execute(self) -> None:
        """Execute instruction after instruction, from location 0 to the end of the program."""
        chip, kernel, program = self.chip, self.kernel, self.program
        program.begin()
        size = len(program.memory)
        starts = {at: (row.form, at + row.size, values) for at, row, values in program.fetched()}
        while not program.ending:
            at = program.pc
            if at >= size:
                if program.until is None or program.until.level == 0:
                    return
                program.pc = 0
                await until(kernel, kernel.now + self.instruction_ps)
                continue
            if at not in starts:
                chip.finding("jump-inside", f"a jump to location {at} leads into an instruction: the program stops")
                return
            form, following, values = starts[at]
            program.at = at
            if chip.on_instruction.listeners:
                chip.on_instruction(at)
            if chip.on_command.listeners:
                chip.on_command(self.under_way)
            chip.waits(f"{form} at location {at} in progress")
            await until(kernel, kernel.now + self.instruction_ps)
            program.pc = following
            await self.handlers[form](*values)

    async def perform(self, command: Command) -> None:
        """Execute one instruction outside a program (option `direct`)."""
        self.program.begin()
        self.activity.works_on(command.text)
        await self.handlers[command.row.form](*command.values)

    async def home(self, direction: int, speed: int) -> None:
        """Find the home position; the position counter does not count during this run, and is cleared at the end.

        Args:
            direction: the direction towards the end of travel: 1 is clockwise, -1 is counter-clockwise.
            speed: the speed, in units of 10 steps/s.
        """
        text = "H+" if direction > 0 else "H-"
        self.activity.works_on(text)
        self.counter.set_out(text, direction, homing=speed)
        await self.motion.home(direction, text)
        self.counter.homed()
        self.activity.works_on("")
