r"""Bytes in, commands out.  No time, no pins; the caller says whether commands are text.

    ASCII     letter, a space, arguments, carriage return                 R 87H\r   L #,16\r   ? P\r   "done"\r
    ASCII     a slash in front of a letter                                /B 2\r
    binary    letter, count of data bytes, data bytes, low bytes first    52 01 87
    both      a letter alone that has no terminator (`Row.terminated`)

Nothing here raises: whatever a host sends has an answer, and what it did wrong becomes a note for the caller to drain.
A byte FF where a letter belongs is none: an open bus reads so.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

from ...core.datasheet.table import Arg, Row, Sheet
from ..dialect import Command, spoken_as, unknown_remedy
from ..letters.decoder import Incremental, shown, text_of
from .forms import Forms
from .grammar import BETWEEN, CR, LF, LINE_LIMIT, OPEN_BUS, hint, number


@dataclass(frozen=True, slots=True)
class CommandText(Command):
    """A command with what is not a number in it: the characters of a string, the letter that is asked for.

    `switched`: the first value comes from switches; `flips` are bits of the first value that a prefix inverts.
    """

    data: bytes = b""
    switched: bool = False
    flips: int = 0


class Decoder(Incremental):
    """Incremental decoder of one chip."""

    def __init__(self, sheet: Sheet) -> None:
        self.dialect = spoken_as(sheet, Forms)
        self._ascii = {ord(row.form): row for row in sheet.commands}
        self._binary = {row.code: row for row in sheet.commands}
        super().__init__(sheet)

    def reset(self) -> None:
        """Forget the characters so far, as after a reset of the part."""
        super().reset()
        self._state: Callable[[int], CommandText | None] = self._skip_line
        self._slash = False

    @property
    def unfinished(self) -> str:
        """The line that has come so far; nothing between commands, and in binary."""
        if self.at_letter or self._state in (self._count, self._data):
            return ""
        return self._head + text_of(self._line)

    @property
    def in_string(self) -> bool:
        """Does the line that has come so far lack the quotation mark that ends its string?"""
        return not self.at_letter and self._state == self._in_string

    @property
    def _head(self) -> str:
        return self.dialect.negate * self._slash + (self._row.form if self._row is not None else "")

    def feed(self, byte: int, ascii: bool, entering: bool = False) -> CommandText | None:
        """Take one byte.  `ascii` counts with the letter only; program entry changes nothing: its bytes are kept."""
        if not self.at_letter:
            return self._state(byte)
        self._slash = False
        self._line.clear()
        return self._letter(byte, ascii)

    # ------------------------------------------------------------------------------------------------- the letter
    def _letter(self, byte: int, ascii: bool) -> CommandText | None:
        if byte == OPEN_BUS or (ascii and byte == CR):
            return None
        row = self._row = (self._ascii if ascii else self._binary).get(byte)
        if row is not None and not row.terminated:
            self.at_letter = True
            return CommandText(row, (), 0, row.form.encode(), row.form)
        self.at_letter = False
        if row is None:
            self._stranger(byte, ascii)
        elif not ascii:
            self._state = self._count
        else:
            self._state = self._in_string if row.form == self.dialect.quote else self._in_line
        return None

    def _stranger(self, byte: int, ascii: bool) -> None:
        """A byte that is no command letter, or the prefix.  Commands are upper case."""
        if not ascii:
            self._note("unknown-command", f"{shown(byte)} is not a command; its count and data are ignored")
            self._state = self._count
        elif chr(byte) == self.dialect.negate:
            self._slash = True
            self._state = self._prefixed
        elif byte == LF:
            self._note("line-feed", "a line feed where a command letter belongs: the command after it is lost")
            self._state = self._skip_line
        else:
            remedy = unknown_remedy(self.sheet, chr(byte))
            self._note("unknown-command", f"{shown(byte)} is not a command; the line is ignored", remedy)
            self._state = self._skip_line

    def _prefixed(self, byte: int) -> CommandText | None:
        """The letter after a slash."""
        if byte == CR:
            self._note("missing-argument", f"{self.dialect.negate} without a command; ignored")
            self.at_letter = True
            return None
        if chr(byte) == self.dialect.negate:
            return None
        found = self._letter(byte, True)
        row = self._row
        if row is not None and row.form not in self.dialect.negated:
            self._note("slash", f"{self.dialect.negate} in front of {row.name}, which takes no bits: it is ignored")
        return found

    # ----------------------------------------------------------------------------------------------------- ASCII
    def _skip_line(self, byte: int) -> None:
        self.at_letter = byte == CR

    def _in_line(self, byte: int) -> CommandText | None:
        if byte == CR:
            self.at_letter = True
            return self._line_end()
        self._keep(byte)
        return None

    def _in_string(self, byte: int) -> None:
        if chr(byte) == self.dialect.quote:
            self._state = self._behind_string
        else:
            self._keep(byte)

    def _behind_string(self, byte: int) -> CommandText | None:
        row = cast("Row", self._row)
        if byte != CR:
            self._note("extra-argument", f"{shown(byte)} after a string is ignored")
            return None
        self.at_letter = True
        quote, data = self.dialect.quote, bytes(self._line)
        text = f"{quote}{text_of(data)}{quote}"
        return CommandText(row, (), 0, data, text, data)

    def _keep(self, byte: int) -> None:
        if len(self._line) >= LINE_LIMIT:
            self._note("too-long", f"a command of more than {LINE_LIMIT} characters; the line is ignored")
            self._state = self._skip_line
        else:
            self._line.append(byte)

    def _line_end(self) -> CommandText | None:
        row, body = cast("Row", self._row), text_of(self._line)
        argument = body.strip(" ")
        words = BETWEEN.split(argument) if argument else []
        if row.form == self.dialect.query:
            return self._query(row, body, words)
        if row.form == self.dialect.display:
            return self._to_display(row, body, words)
        needed = len(row.args)
        if len(words) < needed or not all(words[:needed]):
            self._note("missing-argument", f"{row.name} needs {row.takes}; ignored")
            return None
        if len(words) > needed:
            behind = " ".join(words[needed:])
            self._note("extra-argument", f"{row.name} takes {row.takes}; {behind} is ignored")
        self._spacing(row, body, words[:needed] if needed else [])
        return self._with_numbers(row, body, words[:needed])

    def _spacing(self, row: Row, body: str, words: Sequence[str]) -> None:
        """The printed form has one space after the letter, and a comma or a space between two arguments."""
        printed = 1 + sum(map(len, words)) + len(words) - 1 if words else 0
        if (
            words
            and (not body.startswith(" ") or len(body) != printed)
            and len(BETWEEN.split(body.strip())) == len(words)
        ):
            self._note("spacing", f"{row.form}{body}: expected one space between letter and argument")
        elif not words and body and not body.strip():
            self._note("spacing", f"spaces after {row.form}")

    def _with_numbers(self, row: Row, body: str, words: Sequence[str]) -> CommandText | None:
        values, digits, switched = [], 0, False
        for arg, word in zip(row.args, words, strict=True):
            if word == self.dialect.switches and arg is row.args[0]:
                switched = True
                values.append(0)
                continue
            found = number(word)
            if found is None:
                only = word == self.dialect.switches
                remedy = "switches give the first argument only" if only else hint(word)
                self._note("bad-number", f"{row.name} {word}: not a number; ignored", remedy)
                return None
            digits += len(word)
            values.append(self._fit(row, arg, found))
        flips = self.dialect.flips if self._slash and row.form in self.dialect.negated else 0
        return CommandText(row, tuple(values), digits, b"", self._head + body, b"", switched, flips)

    def _query(self, row: Row, body: str, words: Sequence[str]) -> CommandText | None:
        """? R, or ? M,3: which letters may be asked for is not decided here."""
        if not words or len(words[0]) != 1:
            self._note("missing-argument", f"{row.name} needs a letter; ignored")
            return None
        needed = 2 if words[0] == self.dialect.listing else 1
        counts = [number(word) for word in words[1:needed]]
        if None in counts:
            self._note("bad-number", f"{row.name} {words[1]}: not a number; ignored", hint(words[1]))
            return None
        if len(words) > needed:
            behind = " ".join(words[needed:])
            self._note("extra-argument", f"{row.name} {words[0]} takes no more; {behind} is ignored")
        self._spacing(row, body, words[:needed])
        values = tuple(self._low_byte(row, count) for count in counts if count is not None)
        return CommandText(row, values, 0, b"", row.form + body, words[0].encode("latin-1"))

    def _to_display(self, row: Row, body: str, words: Sequence[str]) -> CommandText | None:
        """[38H,2,65,66: address, count, data; a bracket that closes may stand after them."""
        last = [words[-1].removesuffix("]")] if words else []
        numbers = [number(word) for word in [*words[:-1], *last] if word]
        if len(numbers) < 2 or None in numbers:
            self._note("bad-number", f"{row.form}{body}: address, count and data are numbers; ignored")
            return None
        address, count, *data = (self._low_byte(row, found) for found in numbers if found is not None)
        digits = sum(map(len, words))
        return CommandText(row, (address, count), digits, b"", row.form + body, self._data_of(row, count, bytes(data)))

    def _data_of(self, row: Row, count: int, data: bytes) -> bytes:
        """The data of a display command: the shorter one counts, of those announced and those there."""
        if count != len(data):
            self._note("count", f"{row.form}: {count} values announced, {len(data)} found; the smaller number counts")
        return data[:count]

    # --------------------------------------------------------------------------------------------------- binary
    def _block_end(self) -> CommandText | None:
        self.at_letter = True
        row, data = self._row, bytes(self._line)
        if row is None:
            return None
        if row.form == self.dialect.quote:
            return CommandText(row, (), 0, b"", f"{row.form}{text_of(data)}{row.form}", data)
        if row.form in (self.dialect.query, self.dialect.display):
            return self._binary_text(row, data)
        if len(data) != row.data_bytes:
            self._note("count", f"{row.name} takes {row.data_bytes} data bytes; {len(data)} were announced")
        values = row.unpack(data)
        for arg, value in zip(row.args, values, strict=True):
            self._check(row, arg, value)
        return CommandText(row, values, 0, b"", self.dialect.spell(row, values))

    def _binary_text(self, row: Row, data: bytes) -> CommandText | None:
        """A query, or a display command, whose arguments are no numbers of fixed size."""
        least = 1 if row.form == self.dialect.query else 2
        if len(data) < least:
            self._note("count", f"{row.name} takes {least} data bytes and more, {len(data)} were announced; ignored")
            return None
        if least == 1:
            listed = "".join(f",{count}" for count in data[1:2])
            return CommandText(row, tuple(data[1:2]), 0, b"", f"{row.form} {shown(data[0])}{listed}", data[:1])
        text = f"{row.form}{','.join(map(str, data))}"
        return CommandText(row, tuple(data[:2]), 0, b"", text, self._data_of(row, data[1], data[2:]))

    # --------------------------------------------------------------------------------------------------- endings
    def _fit(self, row: Row, arg: Arg, found: int) -> int:
        """Cut a number to the bytes of its argument, whatever its range."""
        self._check(row, arg, found)
        return arg.fit(found)

    def _low_byte(self, row: Row, found: int) -> int:
        """Cut a number to a byte, where it is no argument of the table."""
        if found > 0xFF:
            self._note("range", f"{row.name} {found}: allowed 0..255{_cut(found, found & 0xFF)}")
        return found & 0xFF

    def _check(self, row: Row, arg: Arg, found: int) -> None:
        if not arg.low <= found <= arg.high:
            self._note(
                "range", f"{row.name} {arg.name} {found}: allowed {arg.low}..{arg.high}{_cut(found, arg.fit(found))}"
            )


def _cut(found: int, taken: int) -> str:
    """Return what is made of a number that does not fit its bytes, for a note; empty: it stays as it is."""
    return f"; its low bits count, so {taken} is taken" if taken != found else ""


class Entry:
    """Distinguishes the letter that ends program entry from the same letter within a program.

    In ASCII it counts as the first character of a line, in binary where a letter belongs, so counts are followed.
    """

    def __init__(self, leave: Row, ascii: bool) -> None:
        self.leave, self.ascii = ord(leave.form), ascii
        self.at_letter, self.counted, self.left = True, False, 0

    def ends(self, byte: int) -> bool:
        """Take a byte; return whether it ends program entry, else it is one to be stored."""
        if self.at_letter and byte == self.leave:
            return True
        if self.ascii:
            self.at_letter = byte == CR
        elif self.at_letter:
            self.at_letter, self.counted = byte == OPEN_BUS, False
        elif not self.counted:
            self.counted, self.left = True, byte
            self.at_letter = not byte
        else:
            self.left -= 1
            self.at_letter = not self.left
        return False
