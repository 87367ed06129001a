"""The base class of the parsers for one line of program text; each dialect has its own parser."""

from __future__ import annotations

from ..core.datasheet.table import Row
from .problems import Place
from .statements import Operand, Source, Statement


class Reader:
    """A parser of one line of a text; `at`, `begin` and `end` in its methods are indices into the line."""

    def __init__(self, source: Source, number: int, column: int, text: str) -> None:
        self.source = source
        self.sheet = source.sheet
        self.number = number
        self.column = column
        self.text = text

    def spot(self, at: int, end: int) -> Place:
        """Return the place, in the text, of the characters of the line from `at` up to, but not including, `end`."""
        return Place(self.number, self.column + at, end - at)

    def error(
        self, at: int, end: int, code: str, found: str, allowed: str = "", section: str = "", remedy: str = ""
    ) -> None:
        """Report an error in the characters of the line from `at` up to, but not including, `end`."""
        place = self.spot(at, end)
        self.source.report(place, code, "error", found, allowed=allowed, section=section, remedy=remedy)

    def add(self, begin: int, end: int, row: Row, operands: tuple[Operand, ...], labels: tuple[str, ...]) -> None:
        """Add to the items of the source a command that is written from `begin` to `end` in the line."""
        place = self.spot(begin, end)
        self.source.items.append(Statement(place.line, place.column, self.text[begin:end], row, operands, labels))

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        """Add the commands of the line to the source; `labels` from the line above name the first command.

        Returns:
            Labels at the end of the line, which name the first command of the next line.
        """
        raise NotImplementedError

    def end(self, labels: tuple[str, ...]) -> None:
        """Report labels that name no command because the text ends after them."""
