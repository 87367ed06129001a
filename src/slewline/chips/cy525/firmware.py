"""What the CY525 does: commands as they come, the stored program, live commands.

The effect of a command shows shortly before READY returns; motions, delays and waits begin where READY would return.
An instruction of a running program takes its time first and then acts, so signals between two instructions exist.
Where the manual is silent see quirks.py.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any

from ...core.kernel import Kernel
from ...core.table import Row
from ...language.dialect import Command
from ...language.letters import Label
from . import sheet
from .instructions import Instructions
from .motion import Motion
from .port import LETTER
from .profile import Law
from .state import TICKS_PER_US, T

LETTERS = {row.code: row for row in sheet.COMMANDS if row.stored}
LASTING = "GPDUW"  # these go on for as long as they take


def lead(row: Row) -> int:
    """How many clocks before its time a command begins: motions set READY and DIRECTION ahead of the first step."""
    return T["step_lead"] if row.motion else 0


class Cy525(Instructions):
    """A CY525 on a bench."""

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        self.law = Law(self.options.ramp_unit, self.options.ramp_jumps)
        self.handlers: dict[int, Callable[..., Awaitable[None] | None]] = {
            row.code: getattr(self, row.handler) for row in sheet.COMMANDS if row.stored
        }
        if self.options.stepwise:
            from .stepwise import Stepwise

            self.motion = Stepwise(self)
        else:
            self.motion = Motion(self)
        self.watch_inputs()
        if not sheet.SHEET.crystal_low_hz <= self.crystal_hz <= sheet.SHEET.crystal_high_hz:
            self.finding(
                "crystal", f"{self.crystal_hz / 1e6:g} MHz is outside the 1 to 11 MHz of Table VIII; times scale"
            )
        if self.powered:
            self.start()

    async def run(self) -> None:
        """The firmware from reset on: commands as they come, a program when one is started."""
        while True:
            command = await self.next_command()
            await self.execute(command)
            if self.pc is not None:
                await self.run_program()

    # ------------------------------------------------------------------------------------------------------- commands
    async def next_command(self) -> Command:
        """The next command that is to be executed; in program entry commands are stored instead, until Q."""
        while True:
            byte = await self.next_byte()
            decoder = self.decoder
            found = decoder.feed(byte, self.ascii, self.entering)
            if decoder.notes:
                for note in decoder.take_notes():
                    self.finding(note.code, note.text)
            if type(found) is Command:
                if not self.entering or found.row.form == "Q":
                    return found
                self.on_command(found.text)
                self.store(found)
                await self.finish(self.busy_from + T["store"] + found.digits * T["digit"])
                self.on_command("")
                continue
            if type(found) is Label:
                self.mark(found.letter)
            await self.finish(self.requested + LETTER)

    async def execute(self, command: Command) -> None:
        """Perform a command given by the host, and end its handshake."""
        row = command.row
        end = self.busy_from + row.time_us * TICKS_PER_US + command.digits * T["digit"]
        self.waits(f"{command.text} in work")
        self.on_command(command.text)
        if row.form == "Q":
            await self.at_tick(end - T["effect_lead"])
            self.do_quit()
        elif row.form in LASTING:
            await self.at_tick(end - lead(row))
            await self.perform(row.code, command.values)
            end = self.tick
        else:
            await self.at_tick(end - T["effect_lead"])
            await self.perform(row.code, command.values)
        await self.finish(end)
        self.on_command("")

    async def perform(self, code: int, values: tuple[int, ...]) -> None:
        """Call the handler of a command, and wait for it if it takes time."""
        work = self.handlers[code](*values)
        if work is not None:
            await work

    def store(self, command: Command) -> None:
        """Program entry: keep the command; what does not fit is dropped."""
        self.buffer += command.stored
        if len(self.buffer) > sheet.BUFFER_BYTES:
            del self.buffer[sheet.BUFFER_BYTES :]
            if not self.overflowed:
                self.finding(
                    "overflow", f"{command.text} does not fit into the {sheet.BUFFER_BYTES} bytes of the program buffer"
                )
            self.overflowed = True

    def mark(self, letter: str) -> None:
        """`A$`: name the next instruction of the program."""
        if not self.entering:
            self.finding("label-outside-program", f"{letter}$ outside program entry: ignored")
            return
        if letter in self.labels:
            self.finding("label-twice", f"{letter}$ again: the last one counts")
        self.labels[letter] = len(self.buffer)

    # --------------------------------------------------------------------------------------------- the stored program
    async def run_program(self) -> None:
        """Fetch and perform instructions until 0, I or reset; between two of them PROG/LIVE is looked at (s.7)."""
        due = self.run_fell + T["first_instruction"]
        self.sync()
        while self.pc is not None:
            self.at = self.pc
            if self.prog_in.level == 0:
                await self.live_commands()
                due = self.tick
                continue
            if not 0 <= self.pc < len(self.buffer):
                self._no_instruction()
                await self.polled(self.prog_in, 0, T["wait_poll"])
                continue
            await self.instruction(due)
            due = self.tick

    def _no_instruction(self) -> None:
        assert self.pc is not None
        self.on_command("")
        if self.pc >= sheet.BUFFER_BYTES and self.pc != self.following:
            self.finding(
                "bad-target", f"byte {self.pc} is outside the program buffer (0 to 59): run mode, nothing to execute"
            )
        else:
            self.finding("end-of-program", f"no instruction at byte {self.pc}: run mode, nothing to execute")
        self.waits("run mode with nothing to execute: a live 0 or RESET")

    async def instruction(self, due: int) -> None:
        """One instruction: its time passes first, then it acts.  The first one acts 60 us after RUN fell."""
        assert self.pc is not None
        at = self.pc
        self.instruction_begins()
        code = self.buffer[at]
        row = LETTERS.get(code)
        first = due > self.tick
        if row is None:
            self.finding("unknown-opcode", f"byte {at} of the program, {code:02X}: skipped")
            self.pc = self.following = at + 1
            self.waits(f"byte {at}, {code:02X}, is skipped")
            await self.ticks(40 * TICKS_PER_US)
            return
        values = row.unpack(bytes(self.buffer[at + 1 : at + row.size]))
        self.pc = self.following = at + row.size
        self.waits(f"{row.form} at byte {at} in work")
        await self.at_tick((due if first else self.tick + row.program_us * TICKS_PER_US) - lead(row))
        await self.perform(code, values)

    async def live_commands(self) -> None:
        """PROG/LIVE is low: take commands from the host until it is high after one of them."""
        self.live = True
        self.on_command("")
        try:
            while self.pc is not None:
                command = await self.next_command()
                await self.execute(command)
                if self.prog_in.level == 1:
                    break
        finally:
            self.live = False
        self.sync()
