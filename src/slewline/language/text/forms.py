"""The base of both dialects in which a command is a letter with arguments: special characters, bytes sent."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.table import Arg, Row, Sheet
from ...errors import UsageError
from ..dialect import Dialect
from ..statements import Statement
from .command_text import CR, NO_NAMES, CommandText, Label, letters_for, spell
from .written_values import BETWEEN

END = bytes([CR])


class TextDialect(Dialect[TextRow]):
    """A dialect in which a command is a letter and its arguments.

    An attribute for a special character, such as `negate`, is "" if the dialect has no such character.
    """

    streams = True
    row_type = TextRow
    tokens = False  # True if a program is stored as opcodes and arguments, not as text
    line_ends = False  # True if a line feed of the host is reported
    encoding = "latin-1"
    numbers = "number"
    no_number = ""  # default remedy
    line_limit = argument_limit = 0  # characters of a command without its carriage return; of the text after its letter
    query = quote = display = negate = switches = listing = ""
    negated: tuple[str, ...] = ()
    flips = page = 0
    queries: Mapping[str, int] = MappingProxyType({})

    # ---------------------------------------------------------------------------------------------------- arguments
    def words(self, row: Row, argument: str) -> list[str]:
        """Return the arguments in a non-empty text, each as a word."""
        return BETWEEN.split(argument)

    def value(self, word: str) -> int | None:
        """Return the number in a word; None if it is not a number."""
        raise NotImplementedError

    def other(self, sheet: Sheet, row: Row, arg: Arg, word: str) -> int | None:
        """Return the value of a word that is not a number, such as a label; None if the word is not allowed here."""
        raise NotImplementedError

    def instead(self, sheet: Sheet, word: str) -> str:
        """Return the remedy for a word that is not a valid argument; empty if none is known."""
        raise NotImplementedError

    def slip(self, sheet: Sheet, argument: str, row: Row) -> str:
        """Return the remedy for arguments that do not fit a command; empty if none is known."""
        return ""

    # --------------------------------------------------------------------------------------------------------- sent
    def spell(
        self, row: TextRow, values: Sequence[int], labels: str = "", names: Mapping[int, str] | None = None
    ) -> str:
        """Return a command as text: its letter and its values.

        A letter replaces a value that is the code of a label, and an address that has a name.  `labels` are the
        letters that can be labels; `names` are the letters of named addresses, keyed by address.
        """
        return spell(row, letters_for(row, values, labels, names or NO_NAMES))

    def sent(self, sheet: Sheet, line: str) -> bytes:
        """Return a line as a host sends it, with a carriage return if its last command must end with one."""
        at = 0
        while self.mark and line[at + 1 : at + 2] == self.mark:
            at += 2
        row = sheet.rows(TextRow).by_form.get(line[at : at + 1])
        if row is not None and not row.terminated:
            rest = line[at + 1 :]
            return line[: at + 1].encode(self.encoding) + (self.sent(sheet, rest) if rest else b"")
        return line.encode(self.encoding) + (END if at < len(line) or not self.mark else b"")

    def sent_binary(self, sheet: Sheet, line: str) -> bytes:
        """Return a line in binary form: letter, count, data.

        Raises:
            UsageError: the line is not a command, or contains a label or an argument that does not exist in binary.
        """
        decoder, out = self.decoder(sheet), b""
        for byte in self.sent(sheet, line):
            found = decoder.feed(byte, True)
            if isinstance(found, Label):
                where = f" ({about})" if (about := sheet.sections.get("labels")) else ""
                raise UsageError(
                    f"found a label while ASCII/BINARY is low; in binary programs, branch to addresses{where}"
                )
            if found is not None and found.switched:
                raise UsageError(
                    f"{line!r}: {self.switches} (read from switches) exists only in text commands; give a number"
                )
            out += self.encoded(found) if found is not None else b""
        if not out:
            raise UsageError(f"{line!r} is not a command, so it has no binary form; to send other bytes, use @bytes")
        return out

    def encoded(self, command: CommandText) -> bytes:
        """Return a command in binary form."""
        row, values, data = command.row, command.values, command.data
        if row.form == self.query:
            data += bytes(values)
        elif row.form == self.display:
            data = bytes(values) + data
        elif row.form != self.quote:
            data = row.pack((*(value ^ command.flips for value in values[:1]), *values[1:]))[1:]
        return self.block(row, data)

    def block(self, row: TextRow, data: bytes) -> bytes:
        """Return a command in binary form: its letter and, if it has data, the byte count and the data."""
        return bytes([self.byte(row)]) + (bytes([len(data)]) + data if row.terminated else b"")

    def byte(self, row: Row) -> int:
        """Return the byte with which a command begins in binary form."""
        return row.code

    # -------------------------------------------------------------------------------------------------------- streams
    def entered(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], checked: bool = False
    ) -> bytes:
        """Return the bytes that a host sends to enter a program as text, including the commands that frame it."""
        before, after = self.framed(sheet, framing, statements)
        text = "".join(f"{self.typed(statement)}\r" for statement in statements).encode(self.encoding)
        return b"".join(self.sent(sheet, line) for line in before) + text + self.sent(sheet, after)

    def entered_binary(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], single_count: bool = False
    ) -> bytes:
        """Return the bytes that a host sends to enter a program in binary form.

        They include the commands that begin and end program entry.  If `single_count` is True, all statements
        share one byte count.
        """
        before, after = self.framed(sheet, framing, statements)
        program = self.binary(sheet, statements, single_count)
        return b"".join(self.sent_binary(sheet, line) for line in before) + program + self.sent_binary(sheet, after)

    def framed(self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement]) -> tuple[list[str], str]:
        """Return the lines that a host sends before a program, and the line that it sends after the program.

        If the program's address is not 0, the first line sets the address.
        """
        address = statements[0].address if statements else 0
        pointer = [f"{sheet.acting('pointer')[0].form} {address}"] if address else []
        return [*pointer, framing[0].form], framing[-1].form

    def typed(self, statement: Statement) -> str:
        """Return a statement as the text that a host sends during program entry."""
        return statement.text

    def binary(self, sheet: Sheet, statements: Sequence[Statement], single_count: bool) -> bytes:
        """Return statements in binary form; if `single_count` is True, all of them share one byte count."""
        raise NotImplementedError

    def check_stream(self, sheet: Sheet) -> None:
        """Accept every part, because every part with such a dialect has a text stream and a binary stream."""
        return
