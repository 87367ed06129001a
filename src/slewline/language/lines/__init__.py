"""The lines dialect: every command and every answer is a line of text."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ...core.datasheet.command_rows import LineRow
from ...core.datasheet.table import Row, Sheet, Trust
from ..dialect import Command, Dialect, Refusal, spoken_as
from ..line_reader import Reader
from ..statements import Operand, Source, Statement
from .line_grammar import KEPT, checksum, framed, parse, places, range_of, spell, usage
from .line_reference import line_in_full, line_table
from .remedies import alike, refusal, remedy

__all__ = ["KEPT", "Lines", "Refusal", "checksum", "framed", "parse", "places", "range_of", "refusal", "spell", "usage"]


class LineReader(Reader):
    """A parser of a line that contains one command."""

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        dialect, text = spoken_as(self.sheet, Lines), self.text
        if 0 < dialect.longest < len(text):
            self.error(0, len(text), "too-long", f"{len(text)} characters", f"{dialect.longest}", dialect.where)
            return ()
        found = parse(self.sheet, text)
        if isinstance(found, Refusal):
            self.refused(found)
            return ()
        pairs = zip(places(found.row, text), found.values, strict=True)
        operands = tuple(Operand(*self.spot(at, end), value) for (at, end), value in pairs)
        self.add(0, len(text), found.row, operands, ())
        return ()

    def refused(self, found: Refusal) -> None:
        """Report a line that the chip would refuse."""
        code = {"unknown": "unknown-command", "argument": "bad-argument"}.get(found.code, found.code)
        forms = alike(self.sheet, self.text)
        where = "" if found.code == "unknown" else forms[0].where
        self.error(found.at, found.end, code, found.found, found.allowed, where, remedy(self.sheet, self.text, found))


@dataclass(frozen=True, eq=False)
class Lines(Dialect[LineRow]):
    """The dialect in which every command and every answer is a line of text.

    Attributes:
        longest: the maximum number of characters in a line; 0 means no limit.
        answers: the meaning of each answer, as text, keyed by the answer.
        accepted: the answer to a command that was accepted.
        busy: the answer of a part that cannot execute a command yet.
        garbled: the answer to a line that was received with errors and is ignored.
        refusals: the answers to commands that were not executed.
        questions: the commands that query a value and change nothing, keyed by the name of the value, each
            with the pattern of its answer.
        where: the section of the manual that describes the lines.
        opcodes: the origin of the opcodes: "stated" by the manual, or "chosen" for the model.
    """

    longest: int = 0
    answers: Mapping[str, str] = field(default_factory=dict)
    accepted: str = "Y"
    busy: str = "B"
    garbled: str = "E1"
    refusals: tuple[str, ...] = ()
    questions: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    where: str = ""
    opcodes: Trust = "stated"

    name = "lines"
    row_type = LineRow
    constant_bit = KEPT.bit_length() - 1  # an error in this bit would pass the checksum

    def reader(self, source: Source, number: int, column: int, text: str) -> Reader:
        """Return a parser of `text`, which is on line `number` of the source and begins at `column`."""
        return LineReader(source, number, column, text)

    def spell(
        self, row: LineRow, values: Sequence[int], labels: str = "", names: Mapping[int, str] | None = None
    ) -> str:
        """Return a command as text: its head and its values."""
        return spell(row, values)

    def meaning_of(self, answer: str) -> str:
        """Return the meaning of an answer, as text; "" for the answer that means only that the line was accepted."""
        return "" if answer == self.accepted else super().meaning_of(answer)

    def shorter(self, sheet: Sheet) -> str:
        """Return advice on how to shorten a program."""
        return "use a loop for repeated commands"

    def entered(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], checked: bool = False
    ) -> bytes:
        """Return the bytes that a host sends to enter a program, line by line, including the commands in `framing`.

        If `checked`, each line has its checksum.
        """
        enter, leave = framing
        texts = [enter.form, *(statement.text for statement in statements), leave.form]
        return b"".join(framed(text, checked) for text in texts)

    def meant(self, sheet: Sheet, text: str) -> list[Row]:
        """Return the row of the command in a line, as a list; the list is empty if the line is not a command."""
        found = parse(sheet, text)
        return [found.row] if isinstance(found, Command) else []

    def table(self, sheet: Sheet) -> str:
        """Return the table of commands, in Markdown."""
        own = "Opcodes are the model's own: the sheet states none. " if self.opcodes == "chosen" else ""
        return f"{line_table(sheet.rows(LineRow))}\n\n{own}A carriage return ends a line."

    def in_full(self, sheet: Sheet, row: LineRow) -> str:
        """Return the full description of a command, in Markdown."""
        return line_in_full(sheet, row)
