"""The parts of a program text: statements with places, directives, programs and problems."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from ..core.datasheet.table import Row, Sheet
from .problems import HasPlace, Problem, Severity


@dataclass(frozen=True, slots=True)
class Operand:
    """An argument as written in a text, and its value as stored.

    `value` is the number, cut to the size of the argument in bytes; for a label, it is the code of the
    letter.
    """

    line: int
    column: int
    length: int
    value: int
    label: str = ""


@dataclass(frozen=True, slots=True)
class Statement:
    """A command in a text.

    `block` is the index of the program that contains it, `address` its address in that program, `size` its
    number of bytes; in command mode, `block` and `address` are -1.
    """

    line: int
    column: int
    text: str
    row: Row
    operands: tuple[Operand, ...] = ()
    labels: tuple[str, ...] = ()
    block: int = -1
    address: int = -1
    size: int = 0

    @property
    def length(self) -> int:
        """The number of characters in the command's text."""
        return len(self.text)

    @property
    def values(self) -> tuple[int, ...]:
        """The operands as numbers, ready to be packed."""
        return tuple(operand.value for operand in self.operands)

    @property
    def end(self) -> int:
        """The address of the byte after the command."""
        return self.address + self.size

    @property
    def target(self) -> Operand | None:
        """The operand that is the branch target; None if there is none."""
        pairs = zip(self.row.args, self.operands, strict=True)
        return next((operand for arg, operand in pairs if arg.name == "target"), None)


@dataclass(frozen=True, slots=True)
class Directive:
    """A line that begins with @, or is otherwise directed at the host; it is not for the chip."""

    line: int
    column: int
    text: str

    @property
    def length(self) -> int:
        """The number of characters in the line."""
        return len(self.text)

    @property
    def verb(self) -> str:
        """The first word, without the @; it names the action."""
        return "".join(self.text.removeprefix("@").split(maxsplit=1)[:1])


Item = Statement | Directive


class Instruction(NamedTuple):
    """An instruction in the buffer; if `row` is None, a byte that is not an opcode, or an incomplete instruction."""

    address: int
    data: bytes
    row: Row | None
    values: tuple[int, ...]


@dataclass(slots=True)
class Block:
    """A stored program, from the command that begins its entry to the command that ends its entry.

    The first address of the program is `base`.
    """

    statements: list[Statement] = field(default_factory=list)
    labels: dict[str, int] = field(default_factory=dict)
    entry: Statement | None = None
    quit: Statement | None = None
    base: int = 0

    @property
    def end(self) -> int:
        """The address after the program's last instruction."""
        return self.statements[-1].end if self.statements else self.base

    @property
    def size(self) -> int:
        """The number of bytes that the program takes up in the buffer."""
        return self.end - self.base

    def address_of(self, target: Operand) -> int | None:
        """Return the address of a branch target; None if its label is not defined."""
        return self.labels.get(target.label) if target.label else target.value

    def loop_start(self, loop: Statement) -> int:
        """Return the address where a loop without a target starts: after the last loop mark above it, or 0."""
        marks = (s.end for s in self.statements if s.row.role == "mark" and s.address < loop.address)
        return max(marks, default=0)


@dataclass(slots=True)
class Source:
    """A parsed text: its items in order, its programs and its problems."""

    sheet: Sheet
    items: list[Item] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)

    @property
    def statements(self) -> list[Statement]:
        """The commands, without the directives."""
        return [item for item in self.items if isinstance(item, Statement)]

    def report(
        self,
        spot: HasPlace,
        code: str,
        severity: Severity,
        found: str,
        *,
        allowed: str = "",
        section: str = "",
        remedy: str = "",
    ) -> None:
        """Add a problem at a statement, an operand, a directive or any other place."""
        where = f"{self.sheet.part.upper()} manual, {section}" if section else ""
        place = spot.line, spot.column, spot.length
        self.problems.append(Problem(*place, code, severity, found, allowed, where, remedy))
