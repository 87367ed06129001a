"""The program buffer: program entry, the execution address, and the PROG/LIVE and RUN pins."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from ...core.context import ChipContext
from ...core.wires.net import Net
from ...language.dialect import Command
from .interfaces.command_port import BusPort
from .interfaces.family_lines import line_in, line_out

if TYPE_CHECKING:
    pass


class Moves(Protocol):
    """The object that moves the motor: motion.py, or its slow twin."""

    moving: bool

    async def move(self, number: int, sign: int, text: str) -> None:
        """Output `number` steps in a direction; return when READY may rise."""

    def killed(self) -> None:
        """Handle a reset: end any motion; the steps begun so far count, and no more steps follow."""


class Program:
    """The stored program, its labels and its program counter, and the state of its entry and execution.

    `pc` is the address of the next instruction, None while no program runs; `at` is the address of the
    running instruction.  `entering` is True during program entry; `live` is True while the host sends
    commands to a running program (PROG/LIVE).
    """

    def __init__(self, chip: ChipContext, port: BusPort, motion: Moves) -> None:
        self.chip, self.port, self.motion, self.sheet = chip, port, motion, chip.sheet
        self.prog, self.run = line_out(chip, "prog"), line_out(chip, "run")
        self.takes_live = chip.sheet.takes_live
        self.prog_in = line_in(chip, "prog" if self.takes_live else "live")  # pulled low by the host
        self.prog_rest = None if self.takes_live else self.prog.inactive_level
        self.pc: int | None = None
        self.waits = False  # U or W, which sample I/O REQUEST themselves, is in progress
        self.run_fell = 0  # tick at which RUN fell
        self.at = self.following = 0  # addresses of the running instruction and of the one after it
        self.clear()

    def clear(self) -> None:
        """Erase the program and end its execution or entry, for RESET and the command I."""
        self.end()
        self.erase()
        self.loop: tuple[int, int] | None = None  # (address of the L that counts, remaining count)
        self.entering = self.live = self.waits = False

    def erase(self) -> None:
        """Empty the buffer, and discard all labels."""
        self.buffer = bytearray()
        self.labels: dict[str, int] = {}
        self.overflowed = False

    # ------------------------------------------------------------------------------------------------- program entry
    def enter(self) -> None:
        """E: erase the program, and begin to store commands."""
        self.erase()
        self.entering = True
        self.prog.activate()

    def quit(self) -> None:
        """Q: end program entry, so that commands are executed again."""
        self.entering = False
        self.rest()

    def rest(self) -> None:
        """Set PROG/LIVE to the level that it has outside program entry."""
        self.prog.drive(self.prog_rest)

    def store(self, command: Command) -> None:
        """Store a command; drop the bytes that do not fit into the buffer."""
        room = self.sheet.buffer_bytes
        self.buffer += command.stored
        if len(self.buffer) > room:
            del self.buffer[room:]
            if not self.overflowed:
                self.chip.finding(
                    "overflow", f"{command.text} does not fit into the {room} bytes of the program buffer"
                )
            self.overflowed = True

    def mark(self, letter: str) -> None:
        """`A$`: make a letter (here A) the label of the instruction that will be stored next."""
        if not self.entering:
            self.chip.finding("label-outside-program", f"{letter}$ is ignored outside program entry")
            return
        if letter in self.labels:
            self.chip.finding("label-twice", f"{letter}$ is repeated: the last one is used")
        self.labels[letter] = len(self.buffer)

    # ------------------------------------------------------------------------------------------------------- running
    @property
    def running(self) -> bool:
        """True while the instruction in progress comes from the program, not from the host."""
        return self.pc is not None and not self.live

    @property
    def counter(self) -> int | None:
        """Address of the instruction in progress or, during live commands, of the next one; None if no program runs."""
        return self.pc if self.pc is None or self.live else self.at

    def begin(self, target: int) -> None:
        """Start the program at an address, or branch to it."""
        if self.pc is None or self.live:
            self.loop = None
        if self.pc is None:
            self.run_fell, self.at = self.chip.tick, target
            self.run.activate()
            self.port.request.watch(self._requested)
        self.pc, self.following = target, 0

    def end(self) -> None:
        """End the program if one runs."""
        if self.pc is not None:
            self.pc = None
            self.chip.on_command("")
            self.run.deactivate()
            self.port.request.unwatch(self._requested)

    def _requested(self, net: Net) -> None:
        """Report a low I/O REQUEST that is missed because a program runs.

        This is called at each edge of I/O REQUEST while a program runs.
        """
        if net.is_active and self.prog_in.is_inactive and not (self.live or self.motion.moving or self.waits):
            self.port.ignore()
            how = " without PROG/LIVE" * self.takes_live
            self.chip.finding(
                "request-while-running", f"I/O REQUEST was lowered while a program was running{how}: it is not answered"
            )

    def resolved(self, target: int) -> int:
        """Return the address of a branch target, which is an address or the code of a label.

        In a running program, a label is also replaced in the buffer by its address (s.3).
        """
        if target < self.sheet.buffer_bytes or chr(target) not in self.sheet.labels:
            return target
        address = self.labels.get(chr(target))
        if address is None:
            self.chip.finding("missing-label", f"label {chr(target)} was never defined")
            return target
        if self.pc is not None and not self.live:
            self.buffer[self.pc - 1] = address
        return address

    # ----------------------------------------------------------------------------------------------- public properties
    def began(self) -> None:
        """Notify the chip's observers of the instruction in progress."""
        if self.chip.on_instruction:
            self.chip.on_instruction(self.at)
        if self.chip.on_command:
            from ...language.disassemble import text_at

            self.chip.on_command(text_at(bytes(self.buffer), self.at, self.sheet))
