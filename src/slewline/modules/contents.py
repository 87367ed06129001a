"""What a module holds, and how that is asked for: its program by its listing, position and registers by questions.

A program is read until two readings agree, since a line without checksums does not show every fault.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from ..core.datasheet.channel import AdaptiveLine, Channel, SerialLine, row_for
from ..core.datasheet.table import Row, Sheet
from ..errors import ProgramError, UsageError
from ..language.assemble import assemble, units
from ..language.dialect import Command, spoken_as
from ..language.lines import parse
from ..language.verbatim import Verbatim
from .failures import DamagedAnswer, ListingDiffers, ModuleFailure, NoAnswer
from .module import Module
from .speech import CR

READINGS = 6  # of a listing, of which two in a row must agree
LONGEST_LINE = 1024  # characters; more without a carriage return are no program
ERASED = 0xFF
Say = Callable[[str], object]


@dataclass(frozen=True)
class Contents:
    """What a module holds.

    Args:
        program: an instruction each, as it is written.
        base: where it begins.
        values: the answers to the questions of the sheet, by what they ask for.
        notes: what a reader of the program should know.
    """

    sheet: Sheet
    program: tuple[str, ...] = ()
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
    def stored(self) -> bytes:
        """The program as the assembler stores it."""
        return assemble(self.text, self.sheet, self.sheet.part).stored

    @property
    def size(self) -> str:
        """How long the program is, in words."""
        where = f" from {self.base} on" if self.base else ""
        count = len(self.program)
        return f"{count} instruction{'s' * (count != 1)}, {len(self.stored)} {units(self.sheet)}{where}"


def harmless_end(sheet: Sheet) -> Row | None:
    """Return the command that ends program entry and does nothing else; None: each of them runs the program."""
    return next((row for row in reversed(sheet.leave) if not row.may_step), None)


def read_contents(module: Module, base: int | None = None, say: Say = lambda _text: None) -> Contents:
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
    program, notes = reader(module, base, say)
    return Contents(module.speech.sheet, tuple(program), base or 0, values, tuple(notes))


def _serial(sheet: Sheet) -> Channel:
    return next(channel for channel in sheet.channels if isinstance(channel, (*READERS,)))


# ------------------------------------------------------------------------------------------------------- what lists all
def read_listing(module: Module, base: int | None = None, say: Say = lambda _text: None) -> tuple[list[str], list[str]]:
    """Return the program that a module lists, an instruction each, and no notes.

    Raises:
        ListingDiffers: no two listings in a row agree.
        DamagedAnswer: what it lists is no program of the part.
        UsageError: `base` is given.
    """
    sheet = module.speech.sheet
    if base:
        raise UsageError(f"--from {base}: the program of a {sheet.part.upper()} begins at 0; leave it out")
    (listing,) = sheet.acting("list")
    before: list[str] | None = None
    found: list[str] = []
    for _ in range(READINGS):
        try:
            found = [*module.ask(listing.form).lines[:-1]]
            strange = next((line for line in found if not _is_instruction(sheet, line)), None)
            if found == before and strange is not None:
                raise DamagedAnswer(
                    f"{module.name}: {listing.form} lists {strange!r}, which is no instruction of the "
                    f"{sheet.part.upper()}; is --part the right part?"
                )
        except NoAnswer as silence:
            if before is None and not silence.received:
                raise
            continue
        if found == before:
            return found, []
        before = found
    raise ListingDiffers(f"{module.name}: {READINGS} listings, no two in a row agree; check the line for noise")


def _is_instruction(sheet: Sheet, line: str) -> bool:
    command = parse(sheet, line)
    return isinstance(command, Command) and command.row.stored


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

    def program(self, base: int) -> tuple[list[str], list[str]]:
        """Return the instructions from an address on, up to where no run of them goes on, and what should be noted."""
        found: list[str] = []
        notes: list[str] = []
        address, furthest, ends = base, base, False
        while not ends or address <= furthest:
            data = self.instruction(address)
            cut = self.dialect.cut(data, 0, self.sheet) if data else None
            if cut is None or cut.row is None or len(cut.data) != len(data):
                if found or data:
                    shown = repr(data[:24]) if data and data[0] != ERASED else "erased memory"
                    notes.append(f"at {address} is {shown}, no instruction: read no further")
                break
            found.append(data[: -len(CR)].decode("latin-1"))
            address += len(data)
            if "t" in cut.row.flow:
                furthest = max(furthest, self.target(cut.values[-1], cut.row, address))
            ends = "n" not in cut.row.flow
        return found, [*notes, *self.unsaid(found, base)]

    def target(self, value: int, row: Row, end: int) -> int:
        """Return where a branch goes that ends at an address."""
        if row.args[-1].size > 1:
            return value
        return end // self.dialect.page * self.dialect.page + value

    def unsaid(self, program: list[str], base: int) -> list[str]:
        """Return what a program text cannot say of a program: blanks at the end of a line, a semicolon in a string."""
        contents = Contents(self.sheet, tuple(program), base)
        try:
            if contents.stored == b"".join(line.encode("latin-1") + CR for line in program):
                return []
        except ProgramError as error:
            return [f"the assembler does not take this text: {' '.join(str(error).split())}"]
        return ["blanks around the lines are not kept in this text"]

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
        """Return a line of memory, which two readings in a row agree on; empty: the memory is erased there.

        Raises:
            ListingDiffers: no two readings in a row agree.
            NoAnswer, DamagedAnswer: the last one failed.
        """
        where = f"{self.module.name}: address {address}"
        failure: ModuleFailure = ListingDiffers(
            f"{where}: {READINGS} readings, no two in a row agree; check the line for noise"
        )
        before: bytes | None = None
        for _ in range(READINGS):
            found: bytes | None = None
            try:
                found = self.read(address)
            except (NoAnswer, DamagedAnswer) as error:
                failure = error
            if found is not None and (found == before or not found):
                return found
            before = found
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


def read_memory(module: Module, base: int | None = None, say: Say = lambda _text: None) -> tuple[list[str], list[str]]:
    """Return the program in a memory with addresses, an instruction each, and notes; the pointer is as it was.

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


Reader = Callable[[Module, "int | None", Say], "tuple[list[str], list[str]]"]
READERS: Mapping[type[Channel], Reader] = MappingProxyType({SerialLine: read_listing, AdaptiveLine: read_memory})
