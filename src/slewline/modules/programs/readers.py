"""Reading of a program: from a listing, from a memory (line by line), or from the bytes of a buffer.

A program is read until two readings agree, because a serial line without checksums may hide a fault.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeVar, cast

from ...core.datasheet.table import Row, Sheet
from ...errors import UsageError
from ...language.dialect import Command, dialect_of, spoken_as
from ...language.disassemble import instruction, text_at
from ...language.lines import parse
from ...language.text import Verbatim
from ..adapter import PROGRAM, FramedSpeech
from ..deviations import deviations
from ..failures import DamagedAnswer, ListingDiffers, ModuleFailure, NoAnswer
from ..module import Module
from ..spoken import CR

READINGS = 8  # readings, of which two must agree
LONGEST_LINE = 1024  # characters; more without a carriage return are not a program
ERASED = 0xFF
Report = Callable[[str], object]
T = TypeVar("T")


class ProgramReading(NamedTuple):
    """A program that was read: its instructions as text and as the assembler stores them, and notes on it."""

    program: tuple[str, ...]
    stored: bytes
    notes: tuple[str, ...] = ()


def agreed(where: str, read: Callable[[], T | None], alone: Callable[[T], bool] = lambda _found: False) -> T:
    """Read several times; return the first result on which two readings agree.

    Args:
        where: a name of the object that is read, for messages.
        read: reads once, and returns the result; None if the answer belongs to another query.
        alone: returns whether a result needs no second reading.

    Raises:
        ListingDiffers: no two readings agree, and none failed.
        NoAnswer, DamagedAnswer: no two readings agree, and at least one failed; or two failed readings
            received the same characters.
    """
    failure: ModuleFailure = ListingDiffers(f"{where}: no two of {READINGS} readings agree; check the line for noise")
    seen: list[T] = []
    for _ in range(READINGS):
        try:
            found = read()
        except (NoAnswer, DamagedAnswer) as error:
            if came_twice(failure, error):
                raise
            failure = error
            continue
        if found is not None and (found in seen or alone(found)):
            return found
        if found is not None:
            seen.append(found)
    raise failure


def came_twice(before: ModuleFailure | None, now: ModuleFailure) -> bool:
    """Return whether two failed readings received the same characters, so that the cause cannot be noise."""
    received = getattr(now, "received", b"")
    return bool(received) and getattr(before, "received", b"") == received


def _check_base(sheet: Sheet, base: int | None) -> None:
    """Check that no start address other than 0 is given, for a part whose programs always begin at 0."""
    if base:
        raise UsageError(f"--from {base}: the program of a {sheet.part.upper()} begins at 0; leave out --from")


# ------------------------------------------------------------------------------------------------------ whole listings
def read_listing(module: Module, base: int | None = None, report: Report = lambda _text: None) -> ProgramReading:
    """Return the program that a module lists, after two listings have agreed.

    Raises:
        ListingDiffers: no two listings agree.
        NoAnswer: no listing was complete.
        DamagedAnswer: the listing is not a program of the part.
        UsageError: `base` is given, and is not 0.
    """
    sheet = module.speech.sheet
    _check_base(sheet, base)
    (listing,) = sheet.acting("list")
    seen: list[tuple[str, ...]] = []
    failure: NoAnswer | None = None
    for _ in range(READINGS):
        try:
            found = module.ask(listing.form).lines
        except NoAnswer as silence:
            if not seen and (not silence.received or came_twice(failure, silence)):
                raise
            failure = silence
            continue
        if found in seen:
            return _listed(module, found)
        seen.append(found)
    if failure is not None and not seen:
        raise failure
    raise ListingDiffers(f"{module.name}: no two of {READINGS} listings agree; check the line for noise")


def _listed(module: Module, lines: tuple[str, ...]) -> ProgramReading:
    """Return the program in the lines of a listing; the last line is the end mark of the listing.

    Raises:
        DamagedAnswer: a line before the end mark is not an instruction.
    """
    sheet = module.speech.sheet
    stored = b""
    for line in lines[:-1]:
        command = parse(sheet, line)
        if not (isinstance(command, Command) and command.row.stored):
            (listing,) = sheet.acting("list")
            why = deviations(module.speech, listing.form, "".join(f"{each}\r" for each in lines).encode("latin-1"))
            raise DamagedAnswer(
                f"{module.name}: it lists {line!r}, which is not an instruction of the {sheet.part.upper()}"
                f"{': ' * bool(why)}{why}; check --chip"
            )
        stored += command.stored
    return ProgramReading(lines[:-1], stored)


# -------------------------------------------------------------------------------------------------- lines of memory
class ProgramReader:
    """A base class of readers that read a program instruction by instruction, as far as execution can reach."""

    def __init__(self, module: Module, report: Report) -> None:
        self.module, self.report = module, report
        self.sheet = module.speech.sheet

    def program(self, base: int) -> ProgramReading:
        """Return the program from the address `base` up to the last instruction that execution can reach."""
        dialect = dialect_of(self.sheet)
        found: list[bytes] = []
        notes: tuple[str, ...] = ()
        address, furthest, ends = base, base, False
        while not ends or address <= furthest:
            data = self.instruction(address)
            cut = dialect.cut(data, 0, self.sheet) if data else None
            if cut is None or cut.row is None or len(cut.data) != len(data):
                if found or data:
                    notes = (self.stopped(address, data),)
                break
            found.append(data)
            address += len(data)
            if "t" in cut.row.flow:
                furthest = max(furthest, self.target(cut.values[-1], cut.row, address))
            ends = "n" not in cut.row.flow
        return ProgramReading(tuple(self.written(data) for data in found), b"".join(found), notes)

    def instruction(self, address: int) -> bytes:
        """Return the stored bytes of the instruction at an address; empty if there is none."""
        raise NotImplementedError

    def target(self, value: int, row: Row, end: int) -> int:
        """Return the target of a branch with the operand `value`; `end` is the address after the branch."""
        raise NotImplementedError

    def written(self, data: bytes) -> str:
        """Return an instruction as text, given its stored bytes."""
        raise NotImplementedError

    def stopped(self, address: int, data: bytes) -> str:
        """Return a note that reading has stopped at an address, where `data` is not an instruction."""
        shown = repr(data[:24]) if data and data[0] != ERASED else "erased memory"
        return f"at {address} is {shown}, not an instruction: the rest was not read"


class MemoryReader(ProgramReader):
    """A reader that reads a program, line by line, from a memory with addresses.

    Erased memory contains no ends of lines.  A request to list one line there therefore lists all bytes up to the end
    of the memory, which takes a minute.
    """

    def __init__(self, module: Module, report: Report) -> None:
        super().__init__(module, report)
        self.dialect = spoken_as(self.sheet, Verbatim)
        (self.pointer,) = self.sheet.acting("pointer")

    def written(self, data: bytes) -> str:
        """Return an instruction as text, without its carriage return."""
        return data[: -len(CR)].decode("latin-1")

    def target(self, value: int, row: Row, end: int) -> int:
        if row.args[-1].size > 1:
            return value
        return end // self.dialect.page * self.dialect.page + value

    def instruction(self, address: int) -> bytes:
        """Return the line at an address, with its carriage return; empty if the memory is erased there.

        If the line contains a string that continues on the following lines, these lines are returned, too.
        """
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
        """Return a memory line on which two readings agree; empty if the memory at the address is erased.

        Raises:
            ListingDiffers, NoAnswer, DamagedAnswer: as for `agreed`.
        """
        return agreed(f"{self.module.name}: address {address}", lambda: self.read(address), lambda line: not line)

    def read(self, address: int) -> bytes | None:
        """Read the memory line at an address once, and return it; empty if the memory is erased there.

        Returns:
            The line with its carriage return; None if the answer is for another address.
        """
        module = self.module
        module.ask(f"{self.pointer.form} {address}")
        answer = module.once(
            f"{self.dialect.query} {self.dialect.listing},1", enough=_shows_erased, longest=LONGEST_LINE
        )
        shown, line = answer.lines[:2]
        if shown != f"{self.pointer.form}={address:05}":
            return None
        if line[:1].encode("latin-1") != bytes([ERASED]):
            return line.encode("latin-1") + CR
        seconds = (self.sheet.buffer_bytes - address) * module.speech.character_s
        self.report(
            f"{module.name}: the memory is erased from {address} on; the module is listing the rest of it, which "
            f"takes at most {seconds:.0f} s"
        )
        module.tidy(self.sheet.buffer_bytes - address)
        return b""


def _shows_erased(received: bytes) -> bool:
    """Return whether the received data shows erased memory directly after the line with the memory pointer."""
    return received.partition(CR)[2][:1] == bytes([ERASED])


def read_memory(module: Module, base: int | None = None, report: Report = lambda _text: None) -> ProgramReading:
    """Return the program in a memory with addresses; reset the module's memory pointer to its earlier address.

    Args:
        base: the address at which the program begins; None: 0.
    """
    reader = MemoryReader(module, report)
    what = next(name for name, (command, _) in module.speech.questions.items() if command[-1] == reader.pointer.form)
    pointer = int(module.value(what))
    try:
        return reader.program(base or 0)
    finally:
        module.ask(f"{reader.pointer.form} {pointer}")


# ------------------------------------------------------------------------------------------- first bytes of a buffer
class BufferReader(ProgramReader):
    """A reader of a program from the bytes of a buffer; a part may report only the first bytes of its buffer.

    Before a program has run, its branches contain the letters of labels instead of addresses, so that their
    targets are unknown.
    """

    def __init__(self, module: Module, report: Report, stored: bytes) -> None:
        super().__init__(module, report)
        self.stored = stored
        self.labels = ""

    def instruction(self, address: int) -> bytes:
        """Return the bytes of the instruction at an address; empty if the address is after the reported bytes."""
        return instruction(self.stored, address, self.sheet).data if address < len(self.stored) else b""

    def target(self, value: int, row: Row, end: int) -> int:
        """Return the target of a branch; for a label of unknown address, return the end of the reported bytes."""
        if value < self.sheet.buffer_bytes:
            return value
        self.labels += chr(value) if chr(value) not in self.labels else ""
        return len(self.stored)

    def written(self, data: bytes) -> str:
        return text_at(data, 0, self.sheet)

    def stopped(self, address: int, data: bytes) -> str:
        """Return a note that reading stopped where there is no instruction, or at the end of the reported bytes."""
        if address + len(data) < len(self.stored):
            return super().stopped(address, data)
        given, room = len(self.stored), self.sheet.buffer_bytes
        return f"the program continues at {address}; the part reports only the first {given} of its {room} bytes"

    def whole(self) -> ProgramReading:
        """Return the program, with notes on its unreported bytes and unknown labels."""
        if not any(self.stored):
            return ProgramReading((), b"", (f"all {len(self.stored)} bytes that the part reports are 00: no program",))
        found = self.program(0)
        if not self.labels:
            return found
        surplus = len(found.stored) - len(found.stored.rstrip(b"\0")) - 1  # commands 0 after the one that ends it
        kept = found.program[: len(found.program) - max(surplus, 0)]
        note = (
            f"it has not run yet, so the addresses of its labels are unknown ({', '.join(self.labels)}): write "
            f"{dialect_of(self.sheet).label(self.labels[0])} before the instruction; its end is a guess"
        )
        return ProgramReading(kept, found.stored[: len(found.stored) - max(surplus, 0)], (*found.notes, note))


def read_buffer(module: Module, base: int | None = None, report: Report = lambda _text: None) -> ProgramReading:
    """Return the program of a part with an adapter, as far as the part reports the program.

    Raises:
        ListingDiffers, NoAnswer, DamagedAnswer: as for `agreed`.
        UsageError: `base` is given, and is not 0.
    """
    _check_base(module.speech.sheet, base)
    speech = cast("FramedSpeech", module.speech)
    command = f"?{PROGRAM}"
    stored = agreed(f"{module.name}: {command}", lambda: speech.group(PROGRAM, module.once(command).text))
    found = BufferReader(module, report, stored).whole()
    for note in found.notes:
        report(f"{module.name}: {note}")
    return found
