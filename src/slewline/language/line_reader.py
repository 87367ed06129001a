"""Takes a line of a program text apart; each dialect has a reader of its own."""

from __future__ import annotations

from ..core.datasheet.table import Row
from .problems import Place
from .statements import Operand, Source, Statement


class Reader:
    """A line of a text; `at` is an index into it."""

    def __init__(self, source: Source, number: int, column: int, text: str) -> None:
        self.source = source
        self.sheet = source.sheet
        self.number = number
        self.column = column
        self.text = text

    def spot(self, at: int, end: int) -> Place:
        """Return the place of some of its characters."""
        return Place(self.number, self.column + at, end - at)

    def error(
        self, at: int, end: int, code: str, found: str, allowed: str = "", section: str = "", remedy: str = ""
    ) -> None:
        """Report what is wrong with some of its characters."""
        place = self.spot(at, end)
        self.source.report(place, code, "error", found, allowed=allowed, section=section, remedy=remedy)

    def add(self, begin: int, end: int, row: Row, operands: tuple[Operand, ...], labels: tuple[str, ...]) -> None:
        """Note a command."""
        place = self.spot(begin, end)
        self.source.items.append(Statement(place.line, place.column, self.text[begin:end], row, operands, labels))

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        """Read the commands of the line, of which the first is named by labels of the line above.

        Returns:
            Labels at the end of the line, which name the first command of the next one.
        """
        raise NotImplementedError

    def end(self, labels: tuple[str, ...]) -> None:
        """Report labels after which no line comes."""
