"""Execution of commands: host commands from either side, program commands, and jog steps between them.

    idle:     the first byte of a command, from the side that begins one, or else a jog step
    program:  on the CY545B a host command, if one has begun; else the next command from memory

A host command acts when its execution time, counted from its last byte, is over; then BUSY rises.  If the command
begins a motion, a delay or a wait, BUSY rises when that ends.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import TYPE_CHECKING

from ...core.datasheet.channel import FlowBus
from ...core.wires.waits import first_of
from ...language.dialect import spoken_as
from ...language.text import CommandText, Entry, Verbatim
from . import sheet

if TYPE_CHECKING:
    from ...core.context import ChipContext
    from .external_program import Program
    from .instructions import Instructions
    from .interfaces.arbiter import InputArbiter
    from .interfaces.local_bus import LocalBus
    from .registers import Registers
    from .stepping.jog import Jog

ERASED = 0xFF  # a byte of the memory that is not a command, like the value of an open bus
WITH_DATA = frozenset('?["')  # commands that contain more than numbers
REFUSED = frozenset("EQXYJLTZ")  # commands refused while a program runs (quirk CY545-UND-IMM-SET)


class Interpreter:
    """The firmware, which executes commands; it begins at reset."""

    def __init__(
        self,
        chip: ChipContext,
        ticks: Mapping[str, int],
        registers: Registers,
        arbiter: InputArbiter,
        local_bus: LocalBus,
        program: Program,
        instructions: Instructions,
        jog: Jog,
    ) -> None:
        self.chip, self.ticks, self.registers, self.arbiter = chip, ticks, registers, arbiter
        self.local_bus, self.program, self.instructions, self.jog = local_bus, program, instructions, jog
        channel = chip.sheet.channel(FlowBus)
        self.live = channel is not None and channel.live  # immediate commands are executed while a program runs
        self.decoder = spoken_as(chip.sheet, Verbatim).decoder(chip.sheet)
        self.reported_mode = -1  # modes for which it has been reported that answers go elsewhere
        self.handlers: dict[str, Callable[..., Awaitable[None] | None]] = {
            row.form: getattr(instructions, row.handler) for row in chip.sheet.commands
        }
        arbiter.port.reader = arbiter.serial.reader = self
        arbiter.port.watched_nets = arbiter.serial.arrived, arbiter.port.bits.pins[6], *(net for net, _ in jog.watched)

    async def run(self) -> None:
        """Execute commands as they arrive, and a program when one is started."""
        if self.chip.options.autostart:
            self.program.begin()
            await self.run_program()
        while True:
            command = await self.command()
            if command is None:
                await self.arbiter.release(self.chip.tick)
                continue
            await self.execute(command)

    # ------------------------------------------------------------------------------------------- commands of the host
    async def command(self) -> CommandText | None:
        """Return the host's next command; None for an invalid line, or for a request withdrawn while a program runs."""
        running = self.program.running
        byte = await (self.arbiter.letter(running=True) if running else self.first_letter())
        if byte < 0:
            return None
        found = self.feed(byte)
        while found is None and not self.decoder.at_letter:
            byte = await self.arbiter.byte()
            if self.arbiter.port.come:
                self.keep(bytes([byte]) + self.arbiter.port.kept())
            else:
                found = self.feed(byte)
        return found

    @property
    def at_letter(self) -> bool:
        """True if a command begins with the next byte."""
        return self.decoder.at_letter

    def kept(self, data: bytes, at: int) -> int:
        """Return how many bytes of `data`, from index `at` on, neither complete a command nor are mistakes.

        The chip only stores such bytes.  Return -1 if the bytes must arrive singly, not combined into one value
        (handshake.py).
        """
        if self.program.entering or self.program.running:
            return -1
        return self.decoder.kept(data, at, self.registers.ascii)

    def keep(self, data: bytes) -> None:
        """Store bytes, as counted by `kept`, in the command in progress."""
        self.decoder.keep(data, self.registers.ascii)

    def feed(self, byte: int) -> CommandText | None:
        """Pass a byte to the decoder, and report faults in the command; return the command if this completes it."""
        found = self.decoder.feed(byte, self.registers.ascii)
        if self.decoder.notes:
            for note in self.decoder.take_notes():
                self.chip.finding(note.code, note.text)
        return found

    async def first_letter(self) -> int:
        """Return the first byte of the host's next command; until it arrives, sample JOG and make any jog steps."""
        chip, arbiter, jog = self.chip, self.arbiter, self.jog
        due = chip.tick + self.ticks["jog_test"]
        while True:
            direction = jog.direction
            if direction is None or arbiter.pending:
                byte = await arbiter.letter(*jog.watched)
                if byte >= 0:
                    return byte
                due = max(due, chip.clock.ticks_from(chip.kernel.now))
            elif chip.tick < due:
                chip.waits("waiting for the next sample of JOG")
                watched = (arbiter.port.request.when_active, (arbiter.serial.arrived, None), *jog.watched)
                await first_of(chip.kernel, chip.clock.ps(due), *watched)
            else:
                await jog.step(direction)
            chip.sync_forward()

    async def execute(self, command: CommandText) -> None:
        """Execute and finish a host command; if it has started a program, run the program as well."""
        chip, arbiter = self.chip, self.arbiter
        chip.waits(f"{command.text} in progress")
        chip.on_command(command.text)
        arbiter.executing(True)
        time = command.digits * self.ticks["digit"] + (0 if command.row.motion else self.ticks["command"])
        await chip.ticks(time)
        started = not self.program.running
        if command.row.role == "enter" and started:
            await self.enter()
        else:
            self.report_elsewhere(command)
            await self.perform(command)
        arbiter.executing(False)
        if self.program.running and started:
            await self.start()
        await arbiter.release(chip.tick)
        if not self.program.running:
            chip.on_command("")

    def report_elsewhere(self, command: CommandText) -> None:
        """Report, once for each value of the mode, that the answer to a query from RXD is not sent on TXD."""
        mode, device = self.registers.values["mode"], self.instructions.display.device
        asked = command.row.form == "?" and self.arbiter.owner is self.arbiter.serial
        if asked and device in ("parallel", "hp") and mode != self.reported_mode:
            self.reported_mode = mode
            where = "the parallel port" if device == "parallel" else "the HP display"
            remedy = f"O {mode & ~sheet.MB_PARALLEL} sends answers to TXD"
            self.chip.finding(
                "answer-elsewhere", f"{command.text} arrived on RXD, but its answer goes to {where}: {remedy}"
            )

    async def start(self) -> None:
        """Run a program that the host has started; on the CY545, BUSY stays low until the program has stopped."""
        if self.live:
            await self.arbiter.release(self.chip.tick)
        await self.run_program()

    async def perform(self, command: CommandText) -> None:
        """Call the handler of a command, and wait until the effect of the command has ended."""
        row, values = command.row, command.values
        if command.switched:
            digits = {1: 3, 2: 5, 3: 8}[row.args[0].size]
            found = await self.local_bus.digits(row.form, digits)
            number = sum(digit * 10 ** (digits - 1 - n) for n, digit in enumerate(found))
            if number >= row.args[0].modulus:
                text = f"{command.text}: the switches are set to {number}; only the low bits are used"
                self.chip.finding("range", text)
            values = (number % row.args[0].modulus, *values[1:])
        if command.flips:
            values = (values[0] ^ command.flips, *values[1:])
        named = {"data": command.data} if row.form in WITH_DATA else {}
        work = self.handlers[row.form](*values, **named)
        if work is not None:
            await work

    async def enter(self) -> None:
        """E: store in the memory all bytes from the side that has sent E, until Q arrives."""
        chip, registers, arbiter = self.chip, self.registers, self.arbiter
        entry = Entry(chip.sheet.leave[-1], registers.ascii)
        self.program.entering = True
        chip.on_command("")
        while True:
            arbiter.executing(False)
            byte = await arbiter.byte()
            if entry.ends(byte):
                self.program.entering = False
                return
            arbiter.executing(True)
            chip.waits(f"storing a byte at {registers.pointer}")
            await chip.ticks(self.ticks["fetch"])  # the host has released the bus by then
            await self.local_bus.write(registers.pointer, byte)
            registers.pointer += 1

    # ---------------------------------------------------------------------------------------------------- the program
    async def run_program(self) -> None:
        """Fetch and execute commands until the program stops; on the CY545B, execute host commands between them."""
        program, arbiter = self.program, self.arbiter
        self.skipped = 0  # consecutive bytes FF
        arbiter.executing(not self.live)
        while program.running:
            if self.live and arbiter.pending:
                await self.immediate()
            else:
                await self.instruction()
        arbiter.executing(False)
        self.chip.on_command("")

    async def immediate(self) -> None:
        """Execute a host command between two program commands; report and ignore one that is in `REFUSED`."""
        program = self.program
        program.immediate = True
        try:
            command = await self.command()
            if command is None:
                await self.arbiter.release(self.chip.tick)
            elif command.row.form in REFUSED:
                self.chip.finding("not-immediate", f"{command.text} is ignored while a program runs")
                await self.arbiter.release(self.chip.tick)
            else:
                await self.execute(command)
        finally:
            program.immediate = False

    async def instruction(self) -> None:
        """Process one command from memory: read it, let its time pass, execute it."""
        chip, program, registers = self.chip, self.program, self.registers
        program.at = registers.pointer
        chip.waits(f"fetching the command at {program.at}")
        byte = await self.fetch()
        if byte == ERASED:
            self.skip()
            return
        self.skipped = 0
        chip.on_instruction(program.at)
        found = self.feed(byte)
        while found is None and not self.decoder.at_letter:
            found = self.feed(await self.fetch())
        if found is None:
            return
        chip.waits(f"{found.text} at {program.at} in progress")
        chip.on_command(found.text)
        self.arbiter.executing(True)
        if not found.row.motion:
            await chip.ticks(self.ticks["program_command"])
        await self.perform(found)
        self.arbiter.executing(not self.live)

    async def fetch(self) -> int:
        """Return the byte at the pointer, and increment the pointer, which wraps."""
        registers = self.registers
        pointer = registers.pointer
        byte: int = await self.local_bus.read(pointer)
        registers.pointer = pointer + 1
        return byte

    def skip(self) -> None:
        """Skip an FF found where a command should begin; if all the memory is FF, end the program.

        This is by analogy with the empty handshake, whose FF is skipped as well.
        """
        program = self.program
        program.finding_once("erased-memory", f"FF at address {program.at} in place of a command is skipped")
        self.skipped += 1
        if self.skipped >= sheet.MEMORY_BYTES:
            self.skipped = 0
            self.chip.finding("no-program", "the whole memory reads FF: the program ends")
            program.end()
