"""What a program text is made of: statements with places, directives, the programs in it, and what is wrong with it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

from ..core.datasheet.table import Row, Sheet
from .problems import HasPlace, Problem, Severity


@dataclass(frozen=True, slots=True)
class Operand:
    """An argument as written.  `value` fits the argument's bytes; for a label it is the code of the letter."""

    line: int
    column: int
    length: int
    value: int
    label: str = ""


@dataclass(frozen=True, slots=True)
class Statement:
    """A command.

    `block` numbers the program that it belongs to, `address` is its byte there, `size` how many bytes it takes; in
    command mode both numbers are -1.
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
        """Characters."""
        return len(self.text)

    @property
    def values(self) -> tuple[int, ...]:
        """The operands as numbers, ready to be packed."""
        return tuple(operand.value for operand in self.operands)

    @property
    def end(self) -> int:
        """The address after it."""
        return self.address + self.size

    @property
    def target(self) -> Operand | None:
        """The operand that says where to branch."""
        pairs = zip(self.row.args, self.operands, strict=True)
        return next((operand for arg, operand in pairs if arg.name == "target"), None)


@dataclass(frozen=True, slots=True)
class Directive:
    """A line that begins with @, or is directed at the host otherwise: not the chip's business."""

    line: int
    column: int
    text: str

    @property
    def length(self) -> int:
        """Characters."""
        return len(self.text)

    @property
    def verb(self) -> str:
        """The word that says what to do."""
        return "".join(self.text.removeprefix("@").split(maxsplit=1)[:1])


Item = Statement | Directive


class Instruction(NamedTuple):
    """An instruction of the buffer.  Without a row: a byte that is no opcode, or an instruction cut short."""

    address: int
    data: bytes
    row: Row | None
    values: tuple[int, ...]


@dataclass(slots=True)
class Block:
    """A stored program, from the command that begins its entry to the one that ends it, and from address `base` on."""

    statements: list[Statement] = field(default_factory=list)
    labels: dict[str, int] = field(default_factory=dict)
    entry: Statement | None = None
    quit: Statement | None = None
    base: int = 0

    @property
    def end(self) -> int:
        """The address after its last instruction."""
        return self.statements[-1].end if self.statements else self.base

    @property
    def size(self) -> int:
        """Bytes in the buffer."""
        return self.end - self.base

    def address_of(self, target: Operand) -> int | None:
        """Where a branch goes; None if its label is nowhere."""
        return self.labels.get(target.label) if target.label else target.value

    def loop_start(self, loop: Statement) -> int:
        """Where a loop without a target begins: after the mark above it, or at location 0."""
        marks = (s.end for s in self.statements if s.row.role == "mark" and s.address < loop.address)
        return max(marks, default=0)


@dataclass(slots=True)
class Source:
    """A text that was read: its items in order, its programs, its problems."""

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
        """Note a problem at a statement, an operand, a directive or a bare place."""
        where = f"{self.sheet.part.upper()} manual, {section}" if section else ""
        place = spot.line, spot.column, spot.length
        self.problems.append(Problem(*place, code, severity, found, allowed, where, remedy))
