"""The program memory: the stored instructions, and the present location of a run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ....core.datasheet.table import Row, Sheet
from ....core.wires.net import Net
from ....language.dialect import Command
from ..registers import Registers

if TYPE_CHECKING:
    from ....core.program import ProgramRow

SPEEDS = {"S": "start_stop", "T": "top_speed", "R": "ramp"}  # the registers that a motion needs, by command


def set_first(missing: str) -> str:
    """Return a hint to set the `missing` registers (such as "S, T") at the start of the program."""
    return f"set {missing} at the start of the program"


class Program:
    """The stored program, in instruction codes that are the model's own, and the state of its run.

    `pc` is the location of the next instruction; `at` is the location of the instruction in progress, or
    None while no program runs.
    """

    def __init__(self, sheet: Sheet, registers: Registers) -> None:
        self.sheet, self.registers = sheet, registers
        self.by_code: dict[int, Row] = sheet.commands.by_code
        self.memory = bytearray()
        self.clear()

    def clear(self) -> None:
        """Erase the program and its state, because the supply is off."""
        self.memory.clear()
        self.entering = False  # programming mode
        self.kept = False  # M has saved the entered program in the EEPROM
        self.at: int | None = None
        self.begin()

    # --------------------------------------------------------------------------------------------------- programming
    def store(self, command: Command) -> bool:
        """Append an instruction to the program; return whether it fits."""
        fits = len(self.memory) + command.row.size <= self.sheet.buffer_bytes
        if fits:
            self.memory += command.stored
            self.kept = False
        return fits

    def load(self, data: bytes) -> None:
        """Replace the program in the memory by `data`."""
        self.memory[:] = data

    def accepts(self, data: bytes) -> bool:
        """Return whether `data` is a complete program of valid instructions that fits into the memory."""
        at = 0
        while at < len(data) and (row := self.by_code.get(data[at])) is not None:
            values = row.unpack(data[at + 1 : at + row.size], data[at])
            if not all(arg.allows(value) for arg, value in zip(row.args, values, strict=True)):
                return False
            at += row.size
        return at == len(data) <= self.sheet.buffer_bytes

    # --------------------------------------------------------------------------------------------------------- a run
    def begin(self) -> None:
        """Prepare a run from the start of the program."""
        self.pc = 0
        self.ending = False  # the run ends after the instruction in progress
        self.loops: list[list[int]] = []  # [location of the start, passes made]
        self.loop_reported = False  # a loop end without a start has been reported
        self.until: Net | None = None  # U at location 0 repeats the program while this input is 1

    def fetched(self) -> Iterator[tuple[int, Row, tuple[int, ...]]]:
        """Yield the location, the row in the sheet and the argument values of every instruction."""
        data, at = bytes(self.memory), 0
        while at < len(data):
            row = self.by_code[data[at]]
            end = at + row.size
            yield at, row, row.unpack(data[at + 1 : end], data[at])
            at = end

    @property
    def homing_speed(self) -> int:
        """The homing speed in units of 10 steps/s: from an S that begins the program, else register S; 0 for none."""
        for _, row, values in self.fetched():
            return values[0] if row.form == "S" else self.registers.start_stop
        return self.registers.start_stop

    def unset_before_motion(self) -> str:
        """Return which of S, T and R are not set before the program's first motion, as letters; "" if all are set."""
        known = {letter for letter, name in SPEEDS.items() if getattr(self.registers, name)}
        for _, row, _ in self.fetched():
            if row.motion and len(known) < len(SPEEDS):
                return "".join(letter for letter in SPEEDS if letter not in known)
            known |= {row.form} & set(SPEEDS)
        return ""

    # ----------------------------------------------------------------------------------------------- public properties
    def rows(self) -> list[ProgramRow]:
        """Return the program, one instruction per row: location, bytes and text."""
        from ....language.disassemble import program_rows

        return program_rows(bytes(self.memory), self.sheet)

    def text_at(self, at: int) -> str:
        """Return the instruction at a location as text."""
        from ....language.disassemble import text_at

        return text_at(bytes(self.memory), at, self.sheet)
