"""The assembler: translates program text to program buffer contents and to the bytes a host would send.

A text is either assembled or refused as a whole: one exception lists all problems, each with its place,
the line in which this place is marked, and a remedy.  Warnings do not prevent assembly; they are listed
in `Assembly.findings`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

from ..core.datasheet.table import Row, Sheet
from ..errors import ProgramError, UsageError
from .dialect import dialect_of
from .problems import Problem, picture
from .source import commented, mended, read
from .statements import Block, Source, Statement

SCRIPT = 1000  # bytes of a script that fit into their columns of a listing


class RefusedProgram(ProgramError):
    """A program text with errors; `problems` lists them in text order."""

    def __init__(self, problems: list[Problem], text: str, where: str) -> None:
        super().__init__("\n\n".join(picture(problem, text, where, severity=False) for problem in problems))
        self.problems = problems


class ListingLine(NamedTuple):
    """A line of a listing."""

    address: int
    number: int
    source: str


@dataclass(frozen=True)
class Assembly:
    """An assembled program.

    `stored` is the program buffer; `lines` gives the address of each instruction, `labels` that of each label; `preset`
    contains the commands outside program entry, which a host sends in command mode; `findings` lists the warnings.
    `framing` contains the commands that begin and end program entry.  For a part that receives packets and stores none
    of them, `stored` is the output of the host.
    """

    sheet: Sheet
    stored: bytes
    lines: tuple[ListingLine, ...]
    labels: dict[str, int]
    preset: tuple[str, ...]
    findings: tuple[Problem, ...]
    statements: tuple[Statement, ...]
    framing: tuple[Row, ...]

    @property
    def base(self) -> int:
        """The address of the first byte of the program."""
        return self.statements[0].address if self.statements else 0

    def data_of(self, statement: Statement) -> bytes:
        """Return the bytes of an instruction."""
        return self.stored[statement.address - self.base : statement.end - self.base]

    def listing(self) -> str:
        """Return address, bytes and source of every instruction."""
        parts = ((s.address, self.data_of(s), s.text) for s in self.statements)
        return "\n".join(listed(*part, self.sheet) for part in parts)


def assemble(text: str, sheet: Sheet, where: str = "<text>", resolve: bool = False) -> Assembly:
    """Assemble one program; return the bytes that are stored, with addresses, labels and warnings.

    Args:
        text: the program, one command per line; if it has no commands that begin and end program entry, the
            whole text is the program.
        sheet: the data sheet of the part.
        where: the name of the text in messages.
        resolve: store addresses in place of labels; otherwise store the labels' letters, which the chip
            keeps until it executes the instruction.

    Raises:
        ProgramError: the text has errors, all of which the exception lists in `problems`.
    """
    source = read(text, sheet, bare=True)
    link(source)
    for extra in filter(None, (block.entry for block in source.blocks[1:])):
        found, remedy = f"a second {extra.text}", "assemble one program at a time"
        source.report(extra, "second-program", "error", found, remedy=remedy)
    errors = sorted(problem for problem in mended(source.problems, text) if problem.severity == "error")
    if errors:
        raise RefusedProgram(errors, text, where)
    block = source.blocks[0]
    dialect = dialect_of(sheet)
    stored = b"".join(dialect.stored(_resolved(s, block) if resolve else s) for s in block.statements)
    outside = [s.text for s in source.statements if s.block < 0 and s not in (block.entry, block.quit)]
    framing = entry_and_end(sheet) if block.quit is None else (entry_and_end(sheet)[0], block.quit.row)
    lines = tuple(ListingLine(s.address, s.line, s.text) for s in block.statements)
    findings = tuple(sorted([*source.problems, *commented(text, sheet)]))
    return Assembly(sheet, stored, lines, block.labels, tuple(outside), findings, tuple(block.statements), framing)


def link(source: Source) -> None:
    """Report problems that concern a whole program: undefined labels and a buffer overflow."""
    sheet, room = source.sheet, source.sheet.buffer_bytes
    dialect, section = dialect_of(sheet), sheet.sections.get("labels", "")
    for block in source.blocks:
        for statement in block.statements:
            target = statement.target
            if target is not None and block.address_of(target) is None:
                found = f"label {target.label} is not defined"
                remedy = f"write {dialect.label(target.label)} in front of its instruction"
                source.report(target, "missing-label", "error", found, section=section, remedy=remedy)
        over = next((statement for statement in block.statements if statement.end > room > 0), None)
        if over is not None:
            begin = f" from address {block.base} on" if block.base else ""
            found = f"{block.size} {units(sheet)} of program{begin}; this instruction does not fit"
            where, allowed = sheet.buffer_where, f"{room - block.base}"
            remedy = "start it at a lower address" if begin else dialect.shorter(sheet)
            source.report(over, "overflow", "error", found, allowed=allowed, section=where, remedy=remedy)


def entry_and_end(sheet: Sheet) -> tuple[Row, ...]:
    """Return the commands that begin and end program entry; empty for a part without programs."""
    return () if sheet.enter is None else (sheet.enter, *sheet.leave[-1:])


def units(sheet: Sheet) -> str:
    """Return the manual's unit for program memory, in the plural, such as "bytes"."""
    return f"{sheet.memory_unit}s"


def listed(address: int, data: bytes, text: str, sheet: Sheet) -> str:
    """Return a line of a listing: the address, the bytes and the text of an instruction."""
    digits, widest = len(str((sheet.buffer_bytes or SCRIPT) - 1)), 3 * dialect_of(sheet).longest_instruction(sheet) - 1
    return f"{address:0{digits}}  {data.hex(' ').upper():<{widest}}  {text}"


def to_ascii(assembly: Assembly, check: bool = False) -> bytes:
    """Return the characters that an ASCII host sends to begin program entry, enter the program, and end entry.

    `check`: send every line with its checksum, for a part that uses checksums.

    Raises:
        UsageError: the part stores no program.
    """
    _enterable(assembly.sheet)
    return dialect_of(assembly.sheet).entered(assembly.sheet, assembly.framing, assembly.statements, check)


def to_binary(assembly: Assembly, single_count: bool = False) -> bytes:
    """Return the bytes that a binary host sends to enter the program, with addresses in place of labels.

    `single_count`: send the first opcode, then one count of all further bytes, then these bytes as stored.

    Raises:
        UsageError: the part has no binary mode, or stores no program.
    """
    _enterable(assembly.sheet)
    block = Block(list(assembly.statements), assembly.labels, base=assembly.base)
    resolved = [_resolved(statement, block) for statement in assembly.statements]
    return dialect_of(assembly.sheet).entered_binary(assembly.sheet, assembly.framing, resolved, single_count)


def _enterable(sheet: Sheet) -> None:
    if sheet.enter is None:
        part = sheet.part.upper()
        raise UsageError(f"the {part} has no program entry; use format hex or bin for the bytes that a host sends")


def _resolved(statement: Statement, block: Block) -> Statement:
    """Return the statement with addresses in place of labels."""
    found = (
        replace(operand, value=block.address_of(operand) or 0, label="") if operand.label else operand
        for operand in statement.operands
    )
    return replace(statement, operands=tuple(found))
