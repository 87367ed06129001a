"""Program text to program buffer, and to the byte streams that a host would send for it.

A text is assembled whole or refused whole: one exception carries all problems, each with place, picture and remedy.
What is merely odd is no reason to refuse; it is kept in `Assembly.findings`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..core.table import Sheet
from ..errors import ProgramError
from .dialects import encode_binary, spell
from .problems import Problem, picture
from .source import LABELS, Block, Source, Statement, read

BUFFER = "s.5"  # the manual's section about the program buffer


class RefusedProgram(ProgramError):
    """The text has errors.  `problems` lists them, in the order of the text."""

    def __init__(self, problems: list[Problem], text: str, where: str) -> None:
        super().__init__("\n\n".join(picture(problem, text, where, severity=False) for problem in problems))
        self.problems = problems


class Line(NamedTuple):
    """A line of a listing."""

    address: int
    number: int
    source: str


@dataclass(frozen=True)
class Assembly:
    """An assembled program.

    `stored` is the program buffer, `lines` says which instruction stands where, `labels` the address of each label;
    `preset` are the commands outside E..Q, which a host sends in command mode; `findings` is what was odd.
    """

    sheet: Sheet
    stored: bytes
    lines: tuple[Line, ...]
    labels: dict[str, int]
    preset: tuple[str, ...]
    findings: tuple[Problem, ...]
    statements: tuple[Statement, ...]

    def listing(self) -> str:
        """Address, bytes and source of every instruction."""
        shown = []
        for statement, line in zip(self.statements, self.lines, strict=True):
            data = self.stored[statement.address : statement.end].hex(" ").upper()
            shown.append(f"{line.address:02}  {data:<8}  {line.source}")
        return "\n".join(shown)


def assemble(text: str, sheet: Sheet, where: str = "<text>", resolve: bool = False) -> Assembly:
    """Assemble one program.

    Args:
        text: a command a line; E and Q around the program may be left out together, then all of it is the program.
        where: the name of the text in messages.
        resolve: store addresses where a label is meant; else letters, as the chip keeps them until the instruction
            is executed (s.3).

    Raises:
        ProgramError: the text has errors; all of them are in `.problems`.
    """
    source = read(text, sheet, bare=True)
    link(source)
    for extra in source.blocks[1:]:
        assert extra.entry is not None  # only a text without E has a program without E, and then just one
        source.report(extra.entry, "second-program", "error", "a second E", remedy="assemble one program at a time")
    errors = sorted(problem for problem in source.problems if problem.severity == "error")
    if errors:
        raise RefusedProgram(errors, text, where)
    block = source.blocks[0]
    stored = b"".join(s.row.pack(_resolved(s, block) if resolve else s.values) for s in block.statements)
    outside = [s.text for s in source.statements if s.block < 0 and s not in (block.entry, block.quit)]
    lines = tuple(Line(s.address, s.line, s.text) for s in block.statements)
    findings = tuple(sorted(source.problems))
    return Assembly(sheet, stored, lines, block.labels, tuple(outside), findings, tuple(block.statements))


def link(source: Source) -> None:
    """Report what shows only when a program is seen whole: labels that are nowhere, and a buffer that overflows."""
    room = source.sheet.buffer_bytes
    for block in source.blocks:
        for statement in block.statements:
            target = statement.target
            if target is not None and block.address_of(target) is None:
                remedy = f"write {target.label}$ in front of the instruction that is meant"
                source.report(
                    target, "missing-label", "error", f"label {target.label} is nowhere", section=LABELS, remedy=remedy
                )
        over = next((statement for statement in block.statements if statement.end > room), None)
        if over is not None:
            found = f"{block.size} bytes of program; this instruction does not fit"
            remedy = "parameters that stay the same need no room in the program: set them before E"
            source.report(over, "overflow", "error", found, allowed=f"{room}", section=BUFFER, remedy=remedy)


def to_ascii(assembly: Assembly) -> bytes:
    """What an ASCII host sends to enter the program: from E to Q, labels as labels."""
    commands = assembly.sheet.commands
    stream = [commands.named("ENTER").form, "\r"]
    for statement in assembly.statements:
        stream += [f"{letter}$" for letter in statement.labels]
        stream += [spell(statement.row, [operand.label or operand.value for operand in statement.operands]), "\r"]
    return "".join([*stream, commands.named("QUIT").form]).encode()


def to_binary(assembly: Assembly, single_count: bool = False) -> bytes:
    """What a binary host sends to enter the program: from E to Q, labels as addresses, since binary has none (s.3).

    `single_count`: one count for all bytes behind the first opcode, which are sent as they are stored (s.5).
    """
    commands = assembly.sheet.commands
    enter, leave = encode_binary(commands.named("ENTER")), encode_binary(commands.named("QUIT"))
    block = Block(list(assembly.statements), assembly.labels)
    program = [encode_binary(s.row, _resolved(s, block)) for s in block.statements]
    if single_count and program:
        stored = b"".join(s.row.pack(_resolved(s, block)) for s in block.statements)
        program = [program[0][:1], bytes([len(stored) - 1]), stored[1:]]
    return enter + b"".join(program) + leave


def _resolved(statement: Statement, block: Block) -> tuple[int, ...]:
    """The operands, addresses where a label was written."""
    return tuple(block.address_of(operand) or 0 if operand.label else operand.value for operand in statement.operands)
