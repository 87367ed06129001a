"""The disassembler: translates a program buffer to text, with the bytes as comments.

The text assembles to the same bytes:

E
A$N 100         ; 00  4E 64 00
J A             ; 03  4A 00
Q
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from ..core.datasheet.table import Sheet
from ..core.program import ProgramRow
from .assemble import entry_and_end, listed
from .dialect import Command, Note, dialect_of
from .statements import Instruction

COMMENT = 16  # column of the comments
SHOWN = 16  # equal bytes shown individually
NO_NAMES: Mapping[int, str] = MappingProxyType({})


def instructions(stored: bytes, sheet: Sheet) -> list[Instruction]:
    """Return the instructions in the buffer, from its first byte on; a non-opcode byte is a separate item."""
    found: list[Instruction] = []
    at = 0
    while at < len(stored):
        found.append(instruction(stored, at, sheet))
        at += len(found[-1].data)
    return found


def instruction(stored: bytes, at: int, sheet: Sheet) -> Instruction:
    """Return the instruction that begins at an address in the buffer."""
    return dialect_of(sheet).cut(stored, at, sheet)


def text_at(stored: bytes, at: int, sheet: Sheet) -> str:
    """Return the text of the instruction that begins at an address in the buffer."""
    return _text(instruction(stored, at, sheet), sheet)


def disassemble(stored: bytes, sheet: Sheet, labels: bool = False) -> str:
    """Return the buffer as program text, including the commands that begin and end program entry.

    Every line ends with a line feed.  `labels`: name branch targets with letters, until no letters are left;
    the text then assembles with `resolve=True`.
    """
    program = instructions(stored, sheet)
    names = _names(program, sheet) if labels and sheet.labels else {}
    framing = [row.form for row in entry_and_end(sheet)]
    shown = [_line(instruction, sheet, names) for instruction in program]
    return "".join(line + "\n" for line in [*framing[:1], *shown, *framing[1:]])


def listing(stored: bytes, sheet: Sheet) -> str:
    """Return a stored program as text, one instruction per line: address, bytes, text."""
    return "\n".join(listed(row.address, row.data, row.text, sheet) for row in program_rows(stored, sheet))


def program_rows(stored: bytes, sheet: Sheet) -> list[ProgramRow]:
    """Return a stored program, one instruction per row."""
    return [ProgramRow(each.address, each.data, _text(each, sheet)) for each in instructions(stored, sheet)]


def commands(stream: bytes, sheet: Sheet) -> tuple[list[str], list[Note]]:
    """Return the commands of a binary stream, one per line, and the problems found in it.

    Byte counts within a program are ignored, as the chip ignores them when it stores the program, because
    one count may cover the whole program.
    """
    decoder = dialect_of(sheet).decoder(sheet)
    texts: list[str] = []
    stored: bytes | None = None  # of the program being entered
    begun = 0  # of the command being read: index of the byte in the stream
    for place, byte in enumerate(stream, 1):
        found = decoder.feed(byte, False, stored is not None)
        if decoder.at_letter:
            begun = place
        if not isinstance(found, Command):
            continue
        if stored is not None and found.row.stored:
            stored += found.stored
            continue
        if stored is not None:
            texts += _entered(stored, sheet)
        texts.append(found.text)
        stored = b"" if found.row.role == "enter" else None
    notes = decoder.take_notes()
    if not decoder.at_letter:
        rest = stream[begun:]
        more = "" if len(rest) <= 8 else " ..."
        where = f"from byte {begun} on, {_hex(rest[:8])}{more}"
        notes.append(Note("cut-short", f"the stream ends inside a command, which is omitted: {where}"))
    return texts + _entered(stored or b"", sheet), notes


def _entered(stored: bytes, sheet: Sheet) -> list[str]:
    return [_text(instruction, sheet) for instruction in instructions(stored, sheet)]


def _names(program: Sequence[Instruction], sheet: Sheet) -> dict[int, str]:
    """Return a label letter for each branch target, keyed by address, in ascending order of the addresses.

    A target has no letter if no instruction begins there, or if no letters are left.
    """
    targets = {value for instruction in program for value in _targets(instruction)}
    starts = [instruction.address for instruction in program if instruction.address in targets]
    free = [letter for letter in sheet.labels if ord(letter) not in targets]
    return dict(zip(starts, free, strict=False))


def _targets(instruction: Instruction) -> list[int]:
    if instruction.row is None:
        return []
    return [value for arg, value in zip(instruction.row.args, instruction.values, strict=True) if arg.name == "target"]


def _line(instruction: Instruction, sheet: Sheet, names: Mapping[int, str]) -> str:
    text = _text(instruction, sheet, names)
    return f"{text:<{COMMENT - 1}} ; {instruction.address:02}  {_hex(instruction.data)}"


def _text(instruction: Instruction, sheet: Sheet, names: Mapping[int, str] = NO_NAMES) -> str:
    address, data, row, _ = instruction
    dialect = dialect_of(sheet)
    before = dialect.label(names[address]) if address in names else ""
    if row is None:
        return f"{before}??? {_hex(data)}"
    return before + dialect.shown(row, instruction, sheet.labels, names)


def _hex(data: bytes) -> str:
    """Return bytes in hexadecimal; more than 16 bytes, all equal, become one byte and their number."""
    if len(data) > SHOWN and len(set(data)) == 1:
        return f"{data[:1].hex().upper()} ({len(data)} times)"
    return data.hex(" ").upper()
