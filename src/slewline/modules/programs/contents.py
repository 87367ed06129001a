"""The content of a module, and how it is read: the program by `readers.py`, position and registers by queries."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from ...core.datasheet.channel import AdaptiveLine, BusHandshake, Channel, SerialLine, row_for
from ...core.datasheet.table import Row, Sheet
from ...errors import ProgramError
from ...language.assemble import assemble, units
from ..failures import ListingDiffers
from ..module import Module
from .readers import ERASED, READINGS, ProgramReading, Report, read_buffer, read_listing, read_memory

SAVING_S = 3.0  # writing time of an EEPROM: an earlier session may have been interrupted after M


@dataclass(frozen=True)
class ModuleContents:
    """The content of a module.

    Args:
        program: the instructions, each as text.
        stored: the same instructions, as the assembler stores them.
        base: the address at which the program begins.
        values: the values read by the queries of the sheet, keyed by name.
        notes: notes for people who read the program, such as that its end could not be read.
    """

    sheet: Sheet
    program: tuple[str, ...] = ()
    stored: bytes = b""
    base: int = 0
    values: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """Content as a program text, which `slewline asm` and `slewline push` accept."""
        sheet, settings = self.sheet, self._settings()
        head = [f"; {sheet.part}, as read by slewline pull"]
        head += [f"; {name} {value}" for name, value in self.values.items() if name not in settings]
        before = [line for row, line in settings.values() if row.role != "pointer"]
        pointer = next(iter(sheet.acting("pointer")), None)
        if self.base and pointer is not None:
            before.append(f"{pointer.form} {self.base}")
        after = [line for row, line in settings.values() if row.role == "pointer"]
        enter = [] if sheet.enter is None else [sheet.enter.form]
        ends = harmless_end(sheet)
        end = [ends.form] if ends is not None else [f"; {sheet.leave[-1].form}: {sheet.leave[-1].description}"]
        lines = [*head, *before, *enter, *self.program, *end, *after, *(f"; {note}" for note in self.notes)]
        return "".join(f"{line}\n" for line in lines)

    def _settings(self) -> dict[str, tuple[Row, str]]:
        """Return the commands that restore the queried values: the row and the text of each, keyed by value name.

        A value that no command can set is left out; a register may have such a value after power-up.
        """
        by_form = {row.form: row for row in self.sheet.commands if len(row.args) < 2 and not row.may_step}
        letters = {each.name: each.letter for each in self.sheet.registers}
        letters["direction"] = self.values.get("direction", "")
        found = {}
        for name, letter in letters.items():
            value, row = self.values.get(name), by_form.get(letter)
            if value is not None and row is not None and (not row.args or row.args[0].allows(int(value))):
                found[name] = row, f"{row.form} {int(value)}" if row.args else row.form
        return found

    @property
    def unsaid(self) -> str:
        """Reason why `text` cannot represent all of the program, such as spaces at the ends of lines; "" if it can."""
        try:
            if assemble(self.text, self.sheet, self.sheet.part).stored == self.stored:
                return ""
        except ProgramError as error:
            return f"the assembler does not accept the text: {' '.join(str(error).split())}"
        return "spaces at the start or end of a line are lost"

    @property
    def image(self) -> bytes:
        """Bytes of the memory from address 0 to the program's end; those before the program appear as erased."""
        return bytes([ERASED]) * self.base + self.stored

    @property
    def size(self) -> str:
        """Length of the program, as text with units."""
        where = f" from {self.base} on" if self.base else ""
        count = len(self.program)
        return f"{count} instruction{'s' * (count != 1)}, {len(self.stored)} {units(self.sheet)}{where}"


def harmless_end(sheet: Sheet) -> Row | None:
    """Return the command that ends program entry without other effects; None if every such command runs the program."""
    return next((row for row in reversed(sheet.leave) if not row.may_step), None)


def read_contents(module: Module, base: int | None = None, report: Report = lambda _text: None) -> ModuleContents:
    """Read the content of a module without changing it; return the content.

    Args:
        base: the address at which the program begins, in a memory with addresses; None: 0.
        report: called with a message if there is a long wait.

    Raises:
        UsageError: `base` is given and is not 0, but programs of the part always begin at 0.
        RefusedCommand: the module is busy, and remains so.
        NoAnswer, DamagedAnswer, ListingDiffers, PortLost: the content could not be read.
    """
    if module.speech.busy is not None:
        module.wait_until_ready(SAVING_S)
    values = {what: _believed(module, what) for what in module.speech.questions}
    reader = row_for(_serial(module.speech.sheet), READERS, "reads a program over")
    found = reader(module, base, report)
    return ModuleContents(module.speech.sheet, found.program, found.stored, base or 0, values, found.notes)


def _believed(module: Module, what: str) -> str:
    """Return the value read by a query; on a line without parity bits, query until two values in a row agree."""
    value = module.value(what)
    if module.speech.shows_faults:
        return value
    for _ in range(READINGS):
        before, value = value, module.value(what)
        if value == before:
            return value
    raise ListingDiffers(
        f"{module.name}: no two of {READINGS} readings of {what} agree; check whether the module is busy"
    )


def _serial(sheet: Sheet) -> Channel:
    return next(channel for channel in sheet.channels if isinstance(channel, (*READERS,)))


Reader = Callable[[Module, "int | None", Report], ProgramReading]
READERS: Mapping[type[Channel], Reader] = MappingProxyType(
    {SerialLine: read_listing, AdaptiveLine: read_memory, BusHandshake: read_buffer}
)
