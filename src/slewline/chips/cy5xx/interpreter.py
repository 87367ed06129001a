"""Execution of commands: the host's commands as they arrive, the stored program, and live commands.

A command takes effect shortly before READY rises; motions, delays and waits begin when READY would
otherwise rise.  An instruction of a running program acts at the end of its execution time, so signals
change between two instructions.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping

from ...core.context import ChipContext
from ...core.datasheet.table import Row
from ...core.wires.net import Net
from ...language.dialect import Command, spoken_as
from ...language.text import CommandText, Label, Letters
from .instructions import Instructions
from .interfaces.command_port import BusPort
from .program_buffer import Program

UNKNOWN_US = 40  # time of a byte of the program that is not an opcode


class Interpreter:
    """The interpreter of commands, which is the firmware's main loop, beginning at reset."""

    lasting = frozenset(("GO", "POSITION", "DELAY", "UNTIL", "WAIT"))  # these last for as long as they take
    announces = True  # READY is low for motions of a program

    def __init__(
        self, chip: ChipContext, ticks: Mapping[str, int], port: BusPort, program: Program, instructions: Instructions
    ) -> None:
        self.chip, self.ticks, self.port, self.program = chip, ticks, port, program
        self.instructions = instructions
        self.decoder = spoken_as(chip.sheet, Letters).decoder(chip.sheet)
        self.per_us = chip.sheet.crystal_hz // 1_000_000  # clocks
        stored = [row for row in chip.sheet.commands if row.stored]
        self.rows = {row.code: row for row in stored}
        self.handlers: dict[int, Callable[..., Awaitable[None] | None]] = {
            row.code: getattr(instructions, row.handler) for row in stored
        }
        port.select.watch(self._selected)
        port.decoder, port.keep = self.decoder, self.keep

    def _selected(self, _net: Net) -> None:
        if self.chip.task is not None and self.chip.pins["ready"].net.is_inactive and not self.program.motion.moving:
            self.chip.finding(
                "select-while-busy", "I/O SELECT changed while READY was low: it takes effect at the next READY"
            )

    def lead(self, row: Row) -> int:
        """Return how many clocks before its due time a command begins.

        A motion begins early, because it sets READY and DIRECTION before its first step.
        """
        return self.ticks["step_lead"] if row.motion else 0

    async def run(self) -> None:
        """Execute commands as they arrive, and a program when one is started."""
        while True:
            command = await self.next_command()
            await self.execute(command)
            if self.program.pc is not None:
                await self.run_program()

    # ------------------------------------------------------------------------------------------------------- commands
    async def next_command(self) -> Command:
        """Return the next command to execute; during program entry, store commands instead, until Q."""
        chip, port, program, decoder = self.chip, self.port, self.program, self.decoder
        while True:
            byte = await self.next_byte()
            found = decoder.feed(byte, port.ascii, program.entering)
            if decoder.notes:
                for note in decoder.take_notes():
                    chip.finding(note.code, note.text)
            if type(found) is CommandText:
                if not program.entering or found.row.role == "leave":
                    return found
                chip.on_command(found.text)
                program.store(found)
                await port.finish(port.busy_from + self.ticks["store"] + found.digits * self.ticks["digit"])
                chip.on_command("")
                continue
            if type(found) is Label:
                program.mark(found.letter)
            await port.finish(port.requested + self.ticks["letter"])

    def next_byte(self) -> Awaitable[int]:
        """Return an awaitable for the next byte from the host."""
        return self.port.next_byte(self.program.pc is None, self.program.live)

    def keep(self, data: bytes) -> None:
        """Add bytes to the incomplete command; none of them may end the command or be a mistake."""
        self.decoder.keep(data, self.port.ascii, self.program.entering)

    async def execute(self, command: Command) -> None:
        """Execute a host command, and end its handshake."""
        chip, row = self.chip, command.row
        end = self.port.busy_from + row.time_us * self.per_us + command.digits * self.ticks["digit"]
        chip.waits(f"{command.text} in progress")
        chip.on_command(command.text)
        if row.role == "leave":
            await chip.at_tick(end - self.ticks["effect_lead"])
            self.instructions.do_quit()
        elif row.name in self.lasting:
            await chip.at_tick(end - self.lead(row))
            await self.perform(row.code, command.values)
            end = chip.tick
        else:
            await chip.at_tick(end - self.ticks["effect_lead"])
            await self.perform(row.code, command.values)
        await self.port.finish(end)
        chip.on_command("")

    async def perform(self, code: int, values: tuple[int, ...]) -> None:
        """Call the handler of the command whose opcode is `code`, and wait until the command has ended."""
        work = self.handlers[code](*values)
        if work is not None:
            await work

    # --------------------------------------------------------------------------------------------- the stored program
    async def run_program(self) -> None:
        """Fetch and execute instructions until command 0, command I or a reset ends the program.

        PROG/LIVE is sampled between instructions (s.7).
        """
        chip, program = self.chip, self.program
        due = program.run_fell + self.ticks["first_instruction"]
        while program.pc is not None:
            program.at = program.pc
            if program.prog_in.is_active:
                await self.live_commands()
                due = chip.tick
                continue
            if not 0 <= program.pc < len(program.buffer):
                await self.no_instruction(program.pc)
                continue
            await self.instruction(program.pc, due)
            due = chip.tick

    async def no_instruction(self, at: int) -> None:
        """Report that the program has no instruction at an address, and wait until PROG/LIVE is low."""
        chip, program = self.chip, self.program
        chip.on_command("")
        room = chip.sheet.buffer_bytes
        if at >= room and at != program.following:
            where = f"byte {at} is outside the program buffer (0 to {room - 1})"
            chip.finding("bad-target", f"{where}: the chip is in run mode with nothing to execute")
        else:
            chip.finding(
                "end-of-program", f"no instruction at byte {at}: the chip is in run mode with nothing to execute"
            )
        awaited = "a live 0 or RESET" if program.takes_live else "RESET"
        chip.waits(f"run mode with nothing to execute, waiting for {awaited}")
        await chip.polled(*program.prog_in.when_active, self.ticks["wait_poll"])

    async def instruction(self, at: int, due: int) -> None:
        """Wait for the execution time of the instruction at an address, then execute it.

        The first instruction of a program acts at the tick `due` instead, 60 µs after RUN falls.
        """
        chip, program, buffer = self.chip, self.program, self.program.buffer
        program.began()
        code = buffer[at]
        row = self.rows.get(code)
        first = due > chip.tick
        if row is None:
            chip.finding("unknown-opcode", f"byte {at} of the program, {code:02X}, is not an opcode: it is skipped")
            program.pc = program.following = at + 1
            chip.waits(f"byte {at}, {code:02X}, is skipped")
            await chip.ticks(UNKNOWN_US * self.per_us)
            return
        values = row.unpack(bytes(buffer[at + 1 : at + row.size]))
        program.pc = program.following = at + row.size
        chip.waits(f"{row.form} at byte {at} in progress")
        await chip.at_tick((due if first else chip.tick + row.program_us * self.per_us) - self.lead(row))
        if not (row.motion and self.announces):
            await self.perform(code, values)
            return
        self.port.close()
        await self.perform(code, values)
        self.port.open()

    async def live_commands(self) -> None:
        """Execute host commands until the program ends, or until PROG/LIVE (now low) is found high after a command."""
        program = self.program
        program.live = True
        self.chip.on_command("")
        try:
            while program.pc is not None:
                command = await self.next_command()
                await self.execute(command)
                if program.prog_in.is_inactive:
                    break
        finally:
            program.live = False
        self.chip.sync()
