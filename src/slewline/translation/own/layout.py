"""Instructions with symbolic jump targets -> text: labels become letters if the part has them, else addresses."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from ...core.datasheet.table import Row, Sheet
from ...language.dialect import Dialect, dialect_of
from ...language.statements import Statement

ROUNDS = 8  # addresses as text vary in length: the layout settles after a few passes


@dataclass(frozen=True, slots=True)
class Goto:
    """A jump target: an instruction, given by the name of its label."""

    name: str


@dataclass(slots=True)
class ResultPiece:
    """A line of the result before layout: an instruction or, if `row` is None, a line of any other kind.

    If an instruction has a `text`, that text is written unchanged, since `values` cannot contain a
    prefix, a string or "#".  `labels` name the instruction; `source` is the source line, `block` the stored
    program that the instruction belongs to, and `program` the program that it enters, leaves or runs.
    """

    row: Row | None = None
    values: tuple[int | Goto, ...] = ()
    text: str = ""
    comment: str = ""
    source: int = 0
    block: int = -1
    program: int = -1
    labels: list[str] = field(default_factory=list)


class ResultLayout:
    """The addresses and the labels of the result."""

    def __init__(self, sheet: Sheet, pieces: Sequence[ResultPiece]) -> None:
        self.sheet, self.pieces = sheet, pieces
        self.dialect = dialect_of(sheet)
        self.addresses: dict[tuple[int, str], int] = {}
        self.letters: dict[tuple[int, str], str] = {}
        blocks = dict.fromkeys(piece.block for piece in pieces if piece.block >= 0)
        for block in blocks:
            self._name(block)
        for _ in range(ROUNDS):
            before = dict(self.addresses)
            self.sizes = {block: self._place(block) for block in blocks}
            if before == self.addresses:
                break

    def text(self, piece: ResultPiece) -> str:
        """Return the text of a line of the result, without its comment."""
        if piece.row is None:
            return piece.text  # another text, or a line that does not fit
        names = [self.letters[piece.block, name] for name in piece.labels if (piece.block, name) in self.letters]
        marks = "".join(map(self.dialect.label, dict.fromkeys(names)))
        return marks + self._spelled(piece)

    def _spelled(self, piece: ResultPiece) -> str:
        assert piece.row is not None  # noqa: S101
        if piece.text:
            return piece.text
        values = [self._value(piece, value) for value in piece.values]
        labels = "".join(dict.fromkeys(self.letters.values()))
        return str(self.dialect.spell(piece.row, values, labels))

    def _value(self, piece: ResultPiece, value: int | Goto) -> int:
        if not isinstance(value, Goto):
            return value
        block = piece.block if piece.block >= 0 else max((each.block for each in self.pieces), default=0)
        if (letter := self.letters.get((block, value.name))) is not None and piece.block >= 0:
            return ord(letter)
        return self.addresses.get((block, value.name), 0)

    def _name(self, block: int) -> None:
        """Assign letters to a program's labels, keeping the source's if possible; assign none if there are too few."""
        inside = [piece for piece in self.pieces if piece.block == block and piece.row is not None]
        used = dict.fromkeys(
            value.name for piece in inside for value in piece.values if isinstance(value, Goto) and takes_label(piece)
        )
        if not used or len(used) > len(self.sheet.labels):
            return
        free = [letter for letter in self.sheet.labels if letter not in used]
        for name in used:
            self.letters[block, name] = name if name in self.sheet.labels else free.pop(0)

    def _place(self, block: int) -> int:
        """Assign addresses to the labels of a program; return the size of the program."""
        address = 0
        for piece in self.pieces:
            if piece.block != block:
                continue
            for name in piece.labels:
                self.addresses[block, name] = address
            if piece.row is not None:
                address += self._size(piece)
        return address

    def _size(self, piece: ResultPiece) -> int:
        assert piece.row is not None  # noqa: S101
        if not piece.row.stored:
            return 0
        statement = Statement(1, 1, self._spelled(piece), piece.row)
        return piece.row.size if has_tokens(self.dialect) else len(self.dialect.stored(statement))


def takes_label(piece: ResultPiece) -> bool:
    """Return whether the jump target of an instruction may be written as a letter."""
    return piece.row is not None and any(arg.label for arg in piece.row.args)


def has_tokens(dialect: Dialect[Row]) -> bool:
    """Return whether parts with this dialect store opcodes, rather than text, in the program memory."""
    return type(dialect).stored is Dialect.stored


def alone(pieces: Iterable[ResultPiece], source: int) -> list[ResultPiece]:
    """Return copies of the pieces with `source` as their source line."""
    return [replace(piece, source=source) for piece in pieces]
