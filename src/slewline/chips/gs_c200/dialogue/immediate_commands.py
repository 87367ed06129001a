"""Effects and answers of the host's commands: one method per immediate command, named after its sheet row.

The checks, in this order, with the answer if one fails: no run or EEPROM write is in progress (B), the
command is known (E4), its argument is valid (E2), the command is allowed now (E4), and it fits into the
memory (E3).  Some commands are allowed during a run.  Choices where the sheet is silent are in
quirks.py.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from ....core.context import ChipContext
from ....core.time.kernel import Task
from ....language.dialect import Command, Refusal, dialect_of, state_remedy
from ....language.lines import parse, refusal
from ..eeprom import ProgramEeprom
from ..registers import Registers
from ..stepping.driver_lines import UserLines
from .interpreter import Interpreter
from .program_memory import set_first

QUESTIONS = ("V", "Q")  # states in which the answer is B


class HostDialogue:
    """The dialogue with the host, for lines received without faults.

    Args:
        answer_later: sends the answer to M once the EEPROM has been written.
        homing_erases: True if a homing run commanded by the host erases the program.
    """

    def __init__(
        self,
        chip: ChipContext,
        registers: Registers,
        user: UserLines,
        interpreter: Interpreter,
        eeprom: ProgramEeprom,
        answer_later: Callable[[str], None],
        homing_erases: bool,
    ) -> None:
        self.chip, self.options = chip, chip.options
        self.registers, self.user, self.interpreter, self.eeprom = registers, user, interpreter, eeprom
        self.program, self.counter = interpreter.program, interpreter.counter
        self.answer_later, self.homing_erases = answer_later, homing_erases
        self.busy_run: Task | None = None  # the run in which a busy module was reported
        others = (row for row in chip.sheet.commands if row.form not in interpreter.handlers)
        self.handlers = interpreter.handlers | {row.form: getattr(self, row.handler) for row in others}

    async def answer(self, text: str) -> str:
        """Execute a line, and return the answer: Y, B, R, E2 to E6, or V with data; empty if the answer follows later.

        The lines of the answer to Q are separated by CR.
        """
        command = parse(self.chip.sheet, "Po" if self.options.lenient and text == "P0" else text)
        if self.eeprom.writing:
            return "B"
        if self.interpreter.running:
            if isinstance(command, Command) and "r" in command.row.when:
                return await self.perform(command)
            self.report_busy(command, text)
            return "B"
        if not isinstance(command, Command):
            message = refusal(self.chip.sheet, text, command)
            return self.mistake("E4", message) if command.code == "unknown" else self.mistake("E2", message)
        if ("p" if self.program.entering else "i") in command.row.when:
            return await self.perform(command)
        if self.program.entering and command.row.stored:
            return self.store(command)
        if self.options.direct and command.row.stored:
            self.interpreter.run(partial(self.interpreter.perform, command))
            return "Y"
        entering = self.program.entering
        state = "during program entry" if entering else "outside a program"
        return self.mistake("E4", f"{text} {state}; {state_remedy(self.chip.sheet, entering)}")

    def report_busy(self, command: Command | Refusal, text: str) -> None:
        """Report, once per run, a host command that has no effect during the run; queries are not reported."""
        form = command.row.form if isinstance(command, Command) else ""
        if self.busy_run is self.interpreter.task or form in QUESTIONS:
            return
        self.busy_run = self.interpreter.task
        remedy = "wait until F is answered with R, or end it with K or Z"
        quoted = command.text if form else f"{text!r}, which is not a command,"
        self.chip.finding("busy", f"{quoted} is answered with B and ignored while a program runs; {remedy}")

    def mistake(self, code: str, text: str) -> str:
        """Report a host's mistake or an EEPROM fault; return `code`, which is the answer."""
        self.chip.finding(code, text)
        return code

    async def perform(self, command: Command) -> str:
        """Execute a command; return its answer, which is usually Y."""
        answer = await self.handlers[command.row.form](*command.values)
        return "Y" if answer is None else answer

    def store(self, command: Command) -> str:
        """Store an instruction, in programming mode, if it fits; return the answer."""
        if self.program.store(command):
            return "Y"
        sheet = self.chip.sheet
        room = f"{len(self.program.memory)} of {sheet.buffer_bytes} locations are used"
        return self.mistake("E3", f"{command.text} does not fit: {room}; {dialect_of(sheet).shorter(sheet)}")

    # ------------------------------------------------------------------------------------------------- the program
    async def do_program(self) -> None:
        """Po: clear the program and begin program entry."""
        self.program.entering, self.program.kept = True, False
        self.program.memory.clear()

    async def do_program_end(self) -> None:
        """Px: end program entry without running the program."""
        self.program.entering = False

    async def do_execute(self) -> str:
        """E: run the program from its start; return the answer."""
        self.program.entering = False
        missing = self.program.unset_before_motion()
        if not self.program.memory or missing:
            if missing:
                named = ", ".join(missing)
                return self.mistake("E4", f"E is refused without {named}; {set_first(named)}")
            return self.mistake(
                "E4", f"E is refused, because the program is empty; {state_remedy(self.chip.sheet, entering=False)}"
            )
        self.registers.overflow = False
        self.interpreter.run(self.interpreter.execute)
        return "Y"

    async def do_kill(self) -> None:
        """K: end the program and the motion immediately."""
        if self.interpreter.running:
            await self.interpreter.kill("K")

    async def do_zero_speed(self) -> None:
        """Z: ramp down and end the program."""
        await self.interpreter.come_to_rest()

    async def do_home(self, direction: int) -> str:
        """H: start a homing run in a direction, 1 or -1; return the answer."""
        speed = self.program.homing_speed
        if not speed:
            return self.mistake("E4", f"H is refused without a start-stop speed; {set_first('S')}")
        self.interpreter.run(partial(self._home, direction, speed))
        return "Y"

    async def _home(self, direction: int, speed: int) -> None:
        await self.interpreter.home(direction, speed)
        if self.homing_erases:
            self.program.memory.clear()

    # --------------------------------------------------------------------------------------------------- questions
    async def do_feedback(self) -> str:
        """F: return the module's state: busy (B), ready (R), or an error that F has not yet reported (E5, E6)."""
        if self.interpreter.running:
            return "B"
        for flag, answer in (("overflow", "E5"), ("failed", "E6")):
            if getattr(self.registers, flag):
                setattr(self.registers, flag, False)
                return answer
        return "R"

    async def do_query(self) -> str:
        """Q: return the program's instructions, one per line, and END."""
        return "\r".join([*(row.text for row in self.program.rows()), "END"])

    async def do_verify(self, what: int) -> str:
        """V: return the position (`what` is 1), or the levels of the user inputs and outputs (2)."""
        if what == 2:
            return f"V{self.user.read_inputs()}{self.user.read_outputs()}"
        if self.counter.wraps:
            return f"V{self.counter.position:+d}"
        return f"V{self.counter.position:0{7 if self.options.pad7 else 1}d}"

    # ------------------------------------------------------------------------------------------------------ EEPROM
    async def do_memorize(self) -> str:
        """M: write the program to the EEPROM; return "" (the answer follows the write), or Y with option early_y."""
        self.program.kept = True
        self.eeprom.write(self._written)
        return "Y" if self.options.early_y else ""

    def _written(self, good: bool) -> None:
        """Answer M at the end of the EEPROM write; if Y has been sent early, record a failure for F instead."""
        if self.options.early_y:
            self.registers.failed = not good
        else:
            self.answer_later("Y" if good else "E6")

    async def do_exchange(self) -> str:
        """X: load the program from the EEPROM; return the answer."""
        fault = self.eeprom.recall()
        return self.mistake("E6", fault) if fault else "Y"
