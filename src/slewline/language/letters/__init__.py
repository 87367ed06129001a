"""The dialect of letters: a command is a letter with numbers after it, as text or in binary form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...core.datasheet.table import Row, Sheet
from ...errors import UsageError
from ..dialect import Check, Command, Dialect
from ..reader import Reader
from ..statements import Source, Statement
from .decoder import NO_NAMES, Decoder, Label, encode_ascii, encode_binary, letters_for, spell
from .reader import LetterReader

__all__ = ["Decoder", "Label", "Letters", "encode_ascii", "encode_binary", "spell"]


@dataclass(frozen=True, eq=False)
class Letters(Dialect):
    """The dialect in which a command is a letter with numbers after it.

    Attributes:
        mark: the character after the letter of a label.
    """

    mark: str = "$"

    name = "letters"
    streams = True

    @property
    def rules(self) -> Sequence[Check]:
        """Return the linter's rules for programs of letters."""
        from .rules import RULES  # a chip that is only run does not load the linter

        return RULES

    def reader(self, source: Source, number: int, column: int, text: str) -> Reader:
        """Return a reader of one line that begins at a column of the source."""
        return LetterReader(source, number, column, text)

    def decoder(self, sheet: Sheet) -> Decoder:
        """Return a decoder of the characters that a part receives."""
        return Decoder(sheet)

    def spell(self, row: Row, values: Sequence[int], labels: str = "", names: Mapping[int, str] | None = None) -> str:
        """Return a command as text: its letter, its values, and the labels it names."""
        return spell(row, letters_for(row, values, labels, names or NO_NAMES))

    def sent(self, sheet: Sheet, line: str) -> bytes:
        """Return a line as a host sends it: with a carriage return, if a command ends it that has one."""
        at = 0
        while self.mark and line[at + 1 : at + 2] == self.mark:
            at += 2
        row = sheet.commands.by_form.get(line[at : at + 1])
        if row is not None and not row.terminated:
            rest = line[at + 1 :]
            return line[: at + 1].encode("ascii") + (self.sent(sheet, rest) if rest else b"")
        return line.encode("ascii") + (b"\r" if at < len(line) else b"")

    def sent_binary(self, sheet: Sheet, line: str) -> bytes:
        """Return the same in binary form: letter, count, data.

        Raises:
            UsageError: the line is no command, or has a label.
        """
        decoder, out = self.decoder(sheet), b""
        for byte in self.sent(sheet, line):
            found = decoder.feed(byte, True, False)
            if isinstance(found, Command):
                out += encode_binary(found.row, found.values)
            elif found is not None:
                where = f" ({about})" if (about := sheet.sections.get("labels")) else ""
                raise UsageError(f"a label, while ASCII/BINARY is low: binary programs branch to addresses{where}")
        if not out:
            raise UsageError(f"{line!r} is not a command, so it has no binary form; @bytes sends any bytes")
        return out

    def shorter(self, sheet: Sheet) -> str:
        """Return advice on how a program gets shorter."""
        enter = f": set them before {sheet.enter.form}" if sheet.enter is not None else ""
        return f"parameters that stay the same need no room in the program{enter}"

    def entered(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], checked: bool = False
    ) -> bytes:
        """Return the bytes that enter a program as text, between the commands that open and close entry."""
        enter, leave = framing
        stream = [enter.form, "\r"]
        for statement in statements:
            stream += [self.label(letter) for letter in statement.labels]
            stream += [spell(statement.row, [operand.label or operand.value for operand in statement.operands]), "\r"]
        return "".join([*stream, leave.form]).encode()

    def entered_binary(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], single_count: bool = False
    ) -> bytes:
        """Return the bytes that enter a program in binary form; `single_count`: one byte count for all of it."""
        enter, leave = (encode_binary(row) for row in framing)
        program = [encode_binary(statement.row, statement.values) for statement in statements]
        if single_count and program:
            stored = b"".join(self.stored(statement) for statement in statements)
            program = [program[0][:1], bytes([len(stored) - 1]), stored[1:]]
        return enter + b"".join(program) + leave

    def check_stream(self, sheet: Sheet) -> None:
        """Accept every part: each has a text and a binary stream."""
        return

    def table(self, sheet: Sheet) -> str:
        """Return the table of commands, in Markdown."""
        from .reference import letter_table

        return letter_table(sheet)

    def in_full(self, sheet: Sheet, row: Row) -> str:
        """Return all that is known of a command, in Markdown."""
        from .reference import in_full

        return in_full(sheet, row)

    def labels_in_full(self, sheet: Sheet) -> str:
        """Return how labels work, in Markdown."""
        from .reference import labels_in_full

        return labels_in_full(sheet)
