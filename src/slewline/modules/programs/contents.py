"""What a module holds, and how that is asked for: its program by its listing, position and registers by questions.

A program is read until two readings agree, since a line without checksums does not show every fault.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import NamedTuple

from ...core.datasheet.channel import AdaptiveLine, Channel, SerialLine, row_for
from ...core.datasheet.table import Row, Sheet
from ...errors import ProgramError, UsageError
from ...language.assemble import assemble, units
from ...language.dialect import Command, spoken_as
from ...language.lines import parse
from ...language.verbatim import Verbatim
from ..failures import DamagedAnswer, ListingDiffers, ModuleFailure, NoAnswer
from ..module import Module
from ..speech import CR

READINGS = 8  # of a listing, of which two must agree
LONGEST_LINE = 1024  # characters; more without a carriage return are no program
ERASED = 0xFF
Say = Callable[[str], object]


@dataclass(frozen=True)
class ModuleContents:
    """What a module holds.

    Args:
        program: an instruction each, as it is written.
        stored: the same as the assembler stores it.
        base: where it begins.
        values: the answers to the questions of the sheet, by what they ask for.
        notes: what a reader of the program should know.
    """

    sheet: Sheet
    program: tuple[str, ...] = ()
    stored: bytes = b""
    base: int = 0
    values: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """All of it as the text of a program, which `slewline asm` and `slewline push` take."""
        sheet = self.sheet
        settable = {name: row for name, row in self._rows().items() if name in self.values}
        head = [f"; {sheet.part}, as slewline pull has read it"]
        head += [f"; {name} {value}" for name, value in self.values.items() if name not in settable]
        before = [f"{row.form} {int(self.values[name])}" for name, row in settable.items() if row.role != "pointer"]
        pointer = next(iter(sheet.acting("pointer")), None)
        if self.base and pointer is not None:
            before.append(f"{pointer.form} {self.base}")
        after = [f"{row.form} {int(self.values[name])}" for name, row in settable.items() if row.role == "pointer"]
        enter = [] if sheet.enter is None else [sheet.enter.form]
        ends = harmless_end(sheet)
        end = [ends.form] if ends is not None else [f"; {sheet.leave[-1].form}: {sheet.leave[-1].says}"]
        lines = [*head, *before, *enter, *self.program, *end, *after, *(f"; {note}" for note in self.notes)]
        return "".join(f"{line}\n" for line in lines)

    def _rows(self) -> dict[str, Row]:
        """Return the commands that set what the questions ask for, by its name."""
        by_letter = {row.form: row for row in self.sheet.commands if len(row.form) == 1 and len(row.args) == 1}
        found = ((each.name, by_letter.get(each.letter)) for each in self.sheet.registers if each.letter)
        return {name: row for name, row in found if row is not None and not row.may_step}

    @property
    def unsaid(self) -> str:
        """What `text` cannot say of the program, such as blanks at the end of a line; empty: it says all."""
        try:
            if assemble(self.text, self.sheet, self.sheet.part).stored == self.stored:
                return ""
        except ProgramError as error:
            return f"the assembler does not take it: {' '.join(str(error).split())}"
        return "blanks around a line are not kept in it"

    @property
    def image(self) -> bytes:
        """The memory from address 0 to the end of the program."""
        return bytes([ERASED]) * self.base + self.stored

    @property
    def size(self) -> str:
        """How long the program is, in words."""
        where = f" from {self.base} on" if self.base else ""
        count = len(self.program)
        return f"{count} instruction{'s' * (count != 1)}, {len(self.stored)} {units(self.sheet)}{where}"


def harmless_end(sheet: Sheet) -> Row | None:
    """Return the command that ends program entry and does nothing else; None: each of them runs the program."""
    return next((row for row in reversed(sheet.leave) if not row.may_step), None)


def read_contents(module: Module, base: int | None = None, say: Say = lambda _text: None) -> ModuleContents:
    """Return what a module holds; nothing in it changes.

    Args:
        base: where to begin in a memory with addresses; None: at its start.
        say: told what takes long.

    Raises:
        UsageError: the memory of the part has no addresses.
        RefusedCommand: it is busy.
        NoAnswer, DamagedAnswer, ListingDiffers, PortLost: it could not be read.
    """
    values = {what: module.value(what) for what in module.speech.questions}
    reader = row_for(_serial(module.speech.sheet), READERS, "reads a program over")
    found = reader(module, base, say)
    return ModuleContents(module.speech.sheet, found.program, found.stored, base or 0, values, found.notes)


def _serial(sheet: Sheet) -> Channel:
    return next(channel for channel in sheet.channels if isinstance(channel, (*READERS,)))


class ProgramReading(NamedTuple):
    """A program that was read: an instruction each, as the assembler stores them, and what should be noted."""

    program: tuple[str, ...]
    stored: bytes
    notes: tuple[str, ...] = ()


# ------------------------------------------------------------------------------------------------------- what lists all
def read_listing(module: Module, base: int | None = None, say: Say = lambda _text: None) -> ProgramReading:
    """Return the program that a module lists.

    Raises:
        ListingDiffers: no two listings agree.
        DamagedAnswer: what it lists is no program of the part.
        UsageError: `base` is given.
    """
    sheet = module.speech.sheet
    if base:
        raise UsageError(f"--from {base}: the program of a {sheet.part.upper()} begins at 0; leave it out")
    (listing,) = sheet.acting("list")
    seen: list[tuple[str, ...]] = []
    for _ in range(READINGS):
        try:
            found = module.ask(listing.form).lines[:-1]
        except NoAnswer as silence:
            if not seen and not silence.received:
                raise
            continue
        if found in seen:
            return ProgramReading(found, b"".join(_instruction(module, line).stored for line in found))
        seen.append(found)
    raise ListingDiffers(f"{module.name}: {READINGS} listings, and no two agree; check the line for noise")


def _instruction(module: Module, line: str) -> Command:
    """Return a line of a listing as an instruction.

    Raises:
        DamagedAnswer: it is none.
    """
    sheet = module.speech.sheet
    command = parse(sheet, line)
    if isinstance(command, Command) and command.row.stored:
        return command
    raise DamagedAnswer(
        f"{module.name}: it lists {line!r}, which is no instruction of the {sheet.part.upper()}; is --part the right "
        "part?"
    )


# ------------------------------------------------------------------------------------------- what shows lines of memory
class MemoryReader:
    """Reads a memory line by line, where its program goes.

    An erased memory has no lines: it would be read to its end, which takes a minute.
    """

    def __init__(self, module: Module, say: Say) -> None:
        self.module, self.say = module, say
        self.sheet = module.speech.sheet
        self.dialect = spoken_as(self.sheet, Verbatim)
        (self.pointer,) = self.sheet.acting("pointer")

    def program(self, base: int) -> ProgramReading:
        """Return the instructions from an address on, up to where no run of them goes on."""
        found: list[bytes] = []
        notes: tuple[str, ...] = ()
        address, furthest, ends = base, base, False
        while not ends or address <= furthest:
            data = self.instruction(address)
            cut = self.dialect.cut(data, 0, self.sheet) if data else None
            if cut is None or cut.row is None or len(cut.data) != len(data):
                if found or data:
                    shown = repr(data[:24]) if data and data[0] != ERASED else "erased memory"
                    notes = (f"at {address} is {shown}, no instruction: nothing after it was read",)
                break
            found.append(data)
            address += len(data)
            if "t" in cut.row.flow:
                furthest = max(furthest, self.target(cut.values[-1], cut.row, address))
            ends = "n" not in cut.row.flow
        return ProgramReading(tuple(data[: -len(CR)].decode("latin-1") for data in found), b"".join(found), notes)

    def target(self, value: int, row: Row, end: int) -> int:
        """Return where a branch goes that ends at an address."""
        if row.args[-1].size > 1:
            return value
        return end // self.dialect.page * self.dialect.page + value

    def instruction(self, address: int) -> bytes:
        """Return the line at an address, with its carriage return; of a string all its lines; empty: there is none."""
        data = b""
        decoder = self.dialect.decoder(self.sheet)
        while line := self.line(address + len(data)):
            data += line
            for byte in line:
                decoder.feed(byte, True)
            if not decoder.in_string or len(data) > LONGEST_LINE:
                break
        return data

    def line(self, address: int) -> bytes:
        """Return a line of memory, on which two readings agree; empty: the memory is erased there.

        Raises:
            ListingDiffers: no two readings agree.
            NoAnswer, DamagedAnswer: the last one failed.
        """
        where = f"{self.module.name}: address {address}"
        failure: ModuleFailure = ListingDiffers(
            f"{where}: {READINGS} readings, and no two agree; check the line for noise"
        )
        seen: list[bytes] = []
        for _ in range(READINGS):
            try:
                found = self.read(address)
            except (NoAnswer, DamagedAnswer) as error:
                failure = error
                continue
            if found is not None and (found in seen or not found):
                return found
            if found is not None:
                seen.append(found)
        raise failure

    def read(self, address: int) -> bytes | None:
        """Return a line of memory; empty: erased; None: the module speaks of another address."""
        module = self.module
        module.ask(f"{self.pointer.form} {address}")
        answer = module.once(f"{self.dialect.query} {self.dialect.listing},1", enough=_shows_erased)
        shown, line = answer.lines[:2]
        if shown != f"{self.pointer.form}={address:05}":
            return None
        if line[:1].encode("latin-1") != bytes([ERASED]):
            return line.encode("latin-1") + CR
        seconds = (self.sheet.buffer_bytes - address) * module.speech.character_s
        self.say(f"{module.name}: erased from {address} on; the module sends it to its end, {seconds:.0f} s at most")
        module.tidy()
        return b""


def _shows_erased(received: bytes) -> bool:
    """Return whether the line of memory that has begun is none: the memory is erased."""
    return received.partition(CR)[2][:1] == bytes([ERASED])


def read_memory(module: Module, base: int | None = None, say: Say = lambda _text: None) -> ProgramReading:
    """Return the program in a memory with addresses; the pointer is as it was.

    Args:
        base: where it begins; None: 0.
    """
    reader = MemoryReader(module, say)
    what = next(name for name, (command, _) in module.speech.questions.items() if command[-1] == reader.pointer.form)
    pointer = int(module.value(what))
    try:
        return reader.program(base or 0)
    finally:
        module.ask(f"{reader.pointer.form} {pointer}")


Reader = Callable[[Module, "int | None", Say], ProgramReading]
READERS: Mapping[type[Channel], Reader] = MappingProxyType({SerialLine: read_listing, AdaptiveLine: read_memory})
