"""Program buffer to text.  The text assembles to the same bytes; address and bytes stand behind it as a comment:

E
A$N 100         ; 00  4E 64 00
J A             ; 03  4A 00
Q
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ..core.datasheet.table import Sheet
from ..core.program import ProgramRow
from .assemble import entry_and_end, listed
from .dialect import Command, Note, dialect_of
from .statements import Instruction

COMMENT = 16  # column of the comments
SHOWN = 16  # equal bytes that are shown one by one


def instructions(stored: bytes, sheet: Sheet) -> list[Instruction]:
    """The buffer, cut into instructions from its first byte on.  A byte that is no opcode stands alone."""
    found: list[Instruction] = []
    at = 0
    while at < len(stored):
        found.append(instruction(stored, at, sheet))
        at += len(found[-1].data)
    return found


def instruction(stored: bytes, at: int, sheet: Sheet) -> Instruction:
    """The instruction that begins at an address of the buffer."""
    return dialect_of(sheet).cut(stored, at, sheet)


def text_at(stored: bytes, at: int, sheet: Sheet) -> str:
    """The instruction that begins at an address of the buffer, as it is written."""
    return _text(instruction(stored, at, sheet), sheet, {}, {})


def disassemble(
    stored: bytes, sheet: Sheet, labels: bool = False, known: Mapping[str, int] | None = None, frame: bool = True
) -> str:
    """The buffer as program text, with a line end after every line.

    Args:
        labels: name branch targets, as far as the letters go; the text then assembles with `resolve=True`.
        known: labels that are already defined, with their addresses, as a chip remembers them.
        frame: what begins and ends program entry stands before and behind the program.
    """
    program = instructions(stored, sheet)
    marks = dict(known or {})
    names = _names(program, sheet, marks) if labels and sheet.labels else {}
    marks |= {letter: address for address, letter in names.items()}
    shown = [_line(instruction, sheet, marks, names) for instruction in program]
    if frame:
        framing = [row.form for row in entry_and_end(sheet)]
        shown = [*framing[:1], *shown, *framing[1:]]
    return "".join(line + "\n" for line in shown)


def listing(stored: bytes, sheet: Sheet, known: Mapping[str, int] | None = None) -> str:
    """The buffer to look at: address, bytes and instruction, a line each.  `known` as for `disassemble`."""
    return "\n".join(listed(row.address, row.data, row.text, sheet) for row in program_rows(stored, sheet, known))


def program_rows(stored: bytes, sheet: Sheet, known: Mapping[str, int] | None = None) -> list[ProgramRow]:
    """The buffer, an instruction a row.  `known` as for `disassemble`."""
    program = instructions(stored, sheet)
    return [ProgramRow(each.address, each.data, _text(each, sheet, known or {}, {})) for each in program]


def commands(stream: bytes, sheet: Sheet) -> tuple[list[str], list[Note]]:
    """Return the commands of a binary stream, one a line, and what is wrong with it.

    A program is read as the chip keeps it: there the counts say nothing, and one count may announce all of it.
    """
    decoder = dialect_of(sheet).decoder(sheet)
    said: list[str] = []
    stored: bytes | None = None  # of the program that is being entered
    begun = 0  # of the command that is being read: which byte of the stream, counted from 0
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
            said += _entered(stored, sheet)
        said.append(found.text)
        stored = b"" if found.row.role == "enter" else None
    notes = decoder.take_notes()
    if not decoder.at_letter:
        rest = stream[begun:]
        more = "" if len(rest) <= 8 else " ..."
        where = f"from byte {begun} on, {_hex(rest[:8])}{more}"
        notes.append(Note("cut-short", f"the stream ends inside a command, which is left out: {where}"))
    return said + _entered(stored or b"", sheet), notes


def _entered(stored: bytes, sheet: Sheet) -> list[str]:
    return [_text(instruction, sheet, {}, {}) for instruction in instructions(stored, sheet)]


def _names(program: Sequence[Instruction], sheet: Sheet, marks: Mapping[str, int]) -> dict[int, str]:
    """Letters for the branch targets at which an instruction begins, in the order of their addresses."""
    targets = {value for instruction in program for value in _targets(instruction)}
    starts = [instruction.address for instruction in program if instruction.address in targets]
    free = [letter for letter in sheet.labels if letter not in marks and ord(letter) not in targets]
    return dict(zip(starts, free, strict=False))


def _targets(instruction: Instruction) -> list[int]:
    if instruction.row is None:
        return []
    return [value for arg, value in zip(instruction.row.args, instruction.values, strict=True) if arg.name == "target"]


def _line(instruction: Instruction, sheet: Sheet, marks: Mapping[str, int], names: Mapping[int, str]) -> str:
    text = _text(instruction, sheet, marks, names)
    return f"{text:<{COMMENT - 1}} ; {instruction.address:02}  {_hex(instruction.data)}"


def _text(instruction: Instruction, sheet: Sheet, marks: Mapping[str, int], names: Mapping[int, str]) -> str:
    address, data, row, _ = instruction
    dialect = dialect_of(sheet)
    before = "".join(dialect.label(letter) for letter, at in marks.items() if at == address)
    if row is None:
        return f"{before}??? {_hex(data)}"
    return before + dialect.shown(row, instruction, sheet.labels, names)


def _hex(data: bytes) -> str:
    """Bytes in hexadecimal; of many equal ones how many there are."""
    if len(data) > SHOWN and len(set(data)) == 1:
        return f"{data[:1].hex().upper()} ({len(data)} times)"
    return data.hex(" ").upper()
