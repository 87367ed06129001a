r"""Characters in, commands out.  No time, no pins; the caller selects ASCII or binary.

Theory of operation.  Between commands the decoder is *at a letter*.  The command letter decides,
together with the mode (ASCII or binary) when it arrives, how the command continues:

    ASCII     letter, a space, arguments, carriage return                   R 100\r   R 87H\r   L #,16\r   ? P\r
    ASCII     label letter, mark, then at a letter again                    A$
    ASCII     a slash in front of a letter; a string                        /B 2\r   "done"\r
    binary    letter, count of data bytes, data bytes, low bytes first      52 01 64
    both      a single letter without a terminator (`TextRow.terminated`)

Each of these continuations is a state: a method that processes one byte.  The dialect defines which continuations
exist, and the form of an argument.  No method raises: every input from a host has an answer, and mistakes become notes
(code and text) for the caller to drain.  In program entry a binary command is stored as received, with opcode and data
bytes unchecked; therefore one count can load a whole program.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar, cast

from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.table import Arg, Sheet
from ..dialect import Note, unknown_remedy
from .command_text import CR, LF, OPEN_BUS, CommandText, Label, spell
from .forms import TextDialect
from .written_values import hint, number

L_co = TypeVar("L_co", covariant=True)  # Label, or Never for a dialect without labels


LINES_KNOWN = 1000


def text_of(data: bytes | bytearray) -> str:
    """Return bytes as characters."""
    return data.decode("latin-1")


def shown(byte: int) -> str:
    """Return a printable character unchanged, or the code of any other character."""
    return chr(byte) if 0x20 < byte < 0x7F else f"0x{byte:02X}"


class Decoder(Generic[L_co]):
    """The incremental decoder of one chip's command port.

    `at_letter` is True between commands.  `notes` collects the host's mistakes until `take_notes` drains them.
    """

    def __init__(self, sheet: Sheet, dialect: TextDialect) -> None:
        self.sheet, self.dialect = sheet, dialect
        self.notes: list[Note] = []
        self._in_ascii = {ord(row.form): row for row in sheet.rows(TextRow)}
        self._in_binary = {dialect.byte(row): row for row in sheet.rows(TextRow)}
        self._label_mark = ord(dialect.mark) if dialect.mark else -1
        self._lines: dict[tuple[str, bytes], CommandText] = {}  # decoded lines, except lines that need a note
        self._line_feeds = not dialect.line_ends  # True if line feeds need no report, or one was reported
        self.reset()

    def reset(self) -> None:
        """Discard the characters of an unfinished command, as at a reset of the part; keep the notes not drained."""
        self.at_letter = True
        self._state: Callable[[int], CommandText | L_co | None] = self._skip_line  # takes a byte after the letter
        self._row: TextRow | None = None  # of the command in progress; None: a letter without a command
        self._before: TextRow | None = None  # the command before, if it has no terminator
        self._slash = False  # a slash precedes the letter
        self._line = bytearray()  # input after the letter: text in ASCII, data bytes in binary
        self._left = 0  # data bytes still to come
        self._entering = False  # program entry at the time of the letter; it does not change within a command
        self._entry_empty = True  # no command since program entry began

    def take_notes(self) -> list[Note]:
        """Return the notes collected since the last call, and delete them."""
        notes, self.notes = self.notes, []
        return notes

    @property
    def unfinished(self) -> str:
        """The part of a line received so far; empty between commands, and in binary, where a count marks the end."""
        if self.at_letter or self._state in (self._count, self._data):
            return ""
        return self._head + text_of(self._line)

    @property
    def in_string(self) -> bool:
        """True while a string is being received as text, before the quotation mark that ends it."""
        return not self.at_letter and self._state == self._in_string

    @property
    def _head(self) -> str:
        return self.dialect.negate * self._slash + (self._row.form if self._row is not None else "")

    def feed(self, byte: int, ascii: bool, entering: bool = False) -> CommandText | L_co | None:
        """Process a byte; return the command or label that it completes, or None; `ascii` matters only at a letter."""
        if not self.at_letter:
            found = self._state(byte)
        else:
            self._line.clear()
            self._slash, self._entering = False, entering
            self._entry_empty |= not entering
            found = self._letter(byte, ascii)
        if found is not None and entering:
            self._entry_empty = False
        return found

    def kept(self, data: bytes, at: int, ascii: bool) -> int:
        """Return how many bytes, from index `at` on, `keep` may store: they neither end a command nor are mistakes."""
        begin, state, left = at, self._state, len(data) - at
        if self.at_letter:
            row = (self._in_ascii if ascii else self._in_binary).get(data[at])
            if row is None or not row.terminated or (ascii and row.form == self.dialect.quote):
                return 0
            if not ascii:
                return min(left, 1 + data[at + 1]) if left > 1 and data[at + 1] else 1
            begin, room = at + 1, self.dialect.argument_limit
        elif state == self._data:
            return min(left, self._left - 1)
        elif state == self._count:
            return min(left, data[at])
        elif state == self._in_line:
            room = self.dialect.argument_limit - len(self._line)
        else:
            return 0
        end = min(at + left, begin + room)
        for sign in (CR, self._label_mark, -1 if self._line_feeds else LF):
            if sign >= 0 and (found := data.find(sign, begin, end)) >= 0:
                end = found
        return end - at

    def keep(self, data: bytes, ascii: bool, entering: bool = False) -> None:
        """Store bytes that neither end a command nor are mistakes; `kept` returns the number of such bytes."""
        if self.at_letter:
            self.feed(data[0], ascii, entering)
            data = data[1:]
        if self._state == self._in_line:
            self._line += data
        else:
            for byte in data:
                self.feed(byte, ascii, entering)

    # ------------------------------------------------------------------------------------------------- the letter
    def _letter(self, byte: int, ascii: bool) -> CommandText | L_co | None:
        before, self._before = self._before, None
        row = self._row = (self._in_ascii if ascii else self._in_binary).get(byte)
        if row is None:
            self._foreign_byte(byte, ascii, before)
        elif not row.terminated:
            self.at_letter, self._before = True, row
            return CommandText(row, (), 0, row.pack(()) if row.stored else b"", row.form)
        else:
            self.at_letter = False
            in_line = self._in_string if row.form == self.dialect.quote else self._in_line
            self._state = in_line if ascii else self._count
        return None

    def _foreign_byte(self, byte: int, ascii: bool, before: TextRow | None) -> None:
        """Process a byte that is not a command letter; `before`: a command without terminator directly before it."""
        if ascii and byte == CR:
            if before is not None and self.dialect.line_ends:
                self._note("q-terminated", f"a carriage return after {before.form}, which ends by itself")
            elif self.dialect.line_ends:
                self._note("empty-line", "a carriage return without a command")
        elif byte != OPEN_BUS or self.dialect.tokens:  # a program that is read as text has empty cells
            self.at_letter = False
            self._state = self._skip_line if ascii else self._count
            self._begin(byte, ascii)

    def _begin(self, byte: int, ascii: bool) -> None:
        """Process a byte that is not a command letter: begin a command with a prefix, or report the byte."""
        if not ascii:
            self._note("unknown-command", f"{shown(byte)} is not a command; its count and data are ignored")
        elif chr(byte) == self.dialect.negate:
            self._slash, self._state = True, self._prefixed
        elif byte == LF:
            text = "a line feed in place of a command letter: the command after it is lost"
            self._note("line-feed", text, "send \\r alone" if self.dialect.line_ends else "")
        else:
            remedy = unknown_remedy(self.sheet, chr(byte))
            self._note("unknown-command", f"{shown(byte)} is not a command; the line is ignored", remedy)

    def _prefixed(self, byte: int) -> CommandText | L_co | None:
        """Process the byte after a slash; return a command if the byte is a letter that is a command by itself."""
        sign = self.dialect.negate
        if chr(byte) == sign:
            return None
        if byte == CR:
            self._note("missing-argument", f"{sign} without a command; ignored")
            self.at_letter = True
            return None
        found = self._letter(byte, True)
        if self._row is not None and self._row.form not in self.dialect.negated:
            self._note("slash", f"{sign} in front of {self._row.name}, which takes no bits: it is ignored")
        return found

    # ---------------------------------------------------------------------------------------------------- ASCII
    def _skip_line(self, byte: int) -> None:
        self.at_letter = byte == CR
        self._line_feed(byte)

    def _line_feed(self, byte: int) -> None:
        """Report the first line feed within a line: it shows that the host ends lines with line feeds."""
        if byte == LF and not self._line_feeds:
            self._line_feeds = True
            self._note(
                "line-end", "the host ends its lines with LF, but this part expects CR: send \\r alone, without \\n"
            )

    def _in_line(self, byte: int) -> CommandText | L_co | None:
        if byte == CR:
            self.at_letter = True
            line, number = (self._head, bytes(self._line)), len(self.notes)
            found = self._lines.get(line)
            if found is None:
                found = self._line_end(cast("TextRow", self._row), text_of(self._line))
                if found is not None and len(self.notes) == number and len(self._lines) < LINES_KNOWN:
                    self._lines[line] = found
            return found
        if byte == self._label_mark:
            return self._mark()
        self._line_feed(byte)
        self._keep(byte)
        return None

    def _keep(self, byte: int) -> None:
        if len(self._line) < self.dialect.argument_limit:
            self._line.append(byte)
            return
        self._note("too-long", f"a command of more than {self.dialect.line_limit} characters; the line is ignored")
        self._state = self._skip_line

    def _mark(self) -> L_co | None:
        """Return a label if its mark directly follows its letter; otherwise report the line, which is ignored."""
        letter = self._head
        if letter in self.sheet.labels and not self._line:
            self.at_letter = True
            return cast("L_co", Label(letter))
        found = f"{letter}{text_of(self._line)}{self.dialect.mark}"
        self._note("unknown-command", f"{found} is not a label; the line is ignored")
        self._state = self._skip_line
        return None

    def _in_string(self, byte: int) -> None:
        if chr(byte) == self.dialect.quote:
            self._state = self._after_string
        else:
            self._keep(byte)

    def _after_string(self, byte: int) -> CommandText | None:
        if byte != CR:
            self._note("extra-argument", f"{shown(byte)} after a string is ignored")
            return None
        self.at_letter = True
        return self._string(cast("TextRow", self._row), bytes(self._line))

    def _string(self, row: TextRow, data: bytes) -> CommandText:
        return CommandText(row, (), 0, b"", f"{row.form}{text_of(data)}{row.form}", data)

    def _line_end(self, row: TextRow, body: str) -> CommandText | None:
        argument = body.strip(" ")
        words = self.dialect.words(row, argument) if argument else []
        if row.form == self.dialect.query:
            return self._query(row, body, words)
        if row.form == self.dialect.display:
            return self._to_display(row, body, words)
        needed = len(row.args)
        if len(words) < needed or not all(words[:needed]):
            remedy = self.dialect.slip(self.sheet, argument, row)
            self._note("missing-argument", f"{row.name} needs {row.takes}; ignored", remedy)
            return None
        self._look(f"{row.name} takes {row.takes}", row, body, words, needed)
        return self._with_numbers(row, body, words[:needed])

    def _look(self, takes: str, row: TextRow, body: str, words: Sequence[str], needed: int) -> None:
        """Report excess words or wrong spacing: one space belongs before the words, a space or comma between them."""
        if len(words) > needed:
            extra = " ".join(words[needed:])
            self._note("extra-argument", f"{takes}; {extra} is ignored", self.dialect.slip(self.sheet, extra, row))
        elif words and (not body.startswith(" ") or len(body) != len(words) + sum(map(len, words))):
            self._note("spacing", f"{row.form}{body}: expected one space between letter and argument")
        elif body and not words:
            self._note("spacing", f"spaces after {row.form}")

    def _with_numbers(self, row: TextRow, body: str, words: Sequence[str]) -> CommandText | None:
        spoken, values, digits, written = self.dialect, list[int](), 0, list[int | str]()
        for arg, word in zip(row.args, words, strict=True):
            value, other = spoken.value(word), spoken.other(self.sheet, row, arg, word)
            if value is not None:
                digits += len(word)
                values.append(self._fit(row, arg, value))
            elif other is not None:
                values.append(other)
            else:
                remedy = spoken.instead(self.sheet, word)
                self._note("bad-number", f"{row.name} {word}: not a {spoken.numbers}; ignored", remedy)
                return None
            written.append(values[-1] if value is not None else word)
        flips = spoken.flips if self._slash and row.form in spoken.negated else 0
        stored, text = (row.pack(values), spell(row, written)) if spoken.tokens else (b"", self._head + body)
        return CommandText(row, tuple(values), digits, stored, text, b"", spoken.switches in words, flips)

    def _query(self, row: TextRow, body: str, words: Sequence[str]) -> CommandText | None:
        """Decode a query such as ? R, or ? M,3; whether the letter can be queried is checked later by the chip."""
        if not words or len(words[0]) != 1:
            self._note("missing-argument", f"{row.name} needs a letter; ignored")
            return None
        needed = 2 if words[0] == self.dialect.listing else 1
        counts = [number(word) for word in words[1:needed]]
        if None in counts:
            self._note("bad-number", f"{row.name} {words[1]}: not a number; ignored", hint(words[1]))
            return None
        self._look(f"{row.name} {words[0]} takes no more", row, body, words, needed)
        values = tuple(self._low_byte(row, count) for count in counts if count is not None)
        return CommandText(row, values, 0, b"", row.form + body, words[0].encode("latin-1"))

    def _to_display(self, row: TextRow, body: str, words: Sequence[str]) -> CommandText | None:
        """Decode a display command such as [38H,2,65,66: address, count, data; a closing bracket may follow."""
        last = [words[-1].removesuffix("]")] if words else []
        numbers = [number(word) for word in [*words[:-1], *last] if word]
        if len(numbers) < 2 or None in numbers:
            self._note("bad-number", f"{row.form}{body}: address, count and data are numbers; ignored")
            return None
        address, count, *data = (self._low_byte(row, found) for found in numbers if found is not None)
        digits = sum(map(len, words))
        return CommandText(row, (address, count), digits, b"", row.form + body, self._data_of(row, count, bytes(data)))

    def _data_of(self, row: TextRow, count: int, data: bytes) -> bytes:
        """Return a display command's data bytes, cut to the announced count; report a count that does not match."""
        if count != len(data):
            self._note("count", f"{row.form}: {count} values announced, {len(data)} found; the smaller number is used")
        return data[:count]

    # --------------------------------------------------------------------------------------------------- binary
    def _count(self, byte: int) -> CommandText | None:
        self._left = byte
        self._state = self._data
        return None if byte else self._block_end()

    def _data(self, byte: int) -> CommandText | None:
        self._line.append(byte)
        self._left -= 1
        return None if self._left else self._block_end()

    def _block_end(self) -> CommandText | None:
        self.at_letter = True
        row, data, spoken = self._row, bytes(self._line), self.dialect
        if row is None:
            return None
        if row.form == spoken.quote:
            return self._string(row, data)
        if row.form in (spoken.query, spoken.display):
            return self._binary_text(row, data)
        values, surplus, entering = row.unpack(data), len(data) - row.data_bytes, self._entering and spoken.tokens
        # A whole program may follow its first opcode under one count, so there the count is not a mistake.
        if surplus and not (entering and self._entry_empty):
            self._note("count", f"{row.name} takes {row.data_bytes} data bytes; {len(data)} were announced")
        if surplus >= 0 or not entering:
            for arg, value in zip(row.args, values, strict=True):
                self._check(row, arg, value)
        more = f" ({len(data)} data bytes)" if entering and surplus else ""
        stored = bytes([row.code]) + data if entering else row.pack(values) if spoken.tokens else b""
        return CommandText(row, values, 0, stored, f"{spell(row, values)}{more}")

    def _binary_text(self, row: TextRow, data: bytes) -> CommandText | None:
        """Decode a query or a display command in binary."""
        least = 1 if row.form == self.dialect.query else 2
        if len(data) < least:
            self._note("count", f"{row.name} takes at least {least} data bytes, {len(data)} were announced; ignored")
            return None
        if least == 1:
            listed = "".join(f",{count}" for count in data[1:2])
            return CommandText(row, tuple(data[1:2]), 0, b"", f"{row.form} {shown(data[0])}{listed}", data[:1])
        text = f"{row.form}{','.join(map(str, data))}"
        return CommandText(row, tuple(data[:2]), 0, b"", text, self._data_of(row, data[1], data[2:]))

    # --------------------------------------------------------------------------------------------- ends of lines
    def _note(self, code: str, text: str, remedy: str = "") -> None:
        self.notes.append(Note(code, f"{text}; {remedy}" if remedy else text))

    def _fit(self, row: TextRow, arg: Arg, found: int) -> int:
        """Return a number cut to the size of its argument in bytes; report a number out of range."""
        self._check(row, arg, found)
        return arg.fit(found)

    def _check(self, row: TextRow, arg: Arg, found: int) -> None:
        if not arg.low <= found <= arg.high:
            named = f"{row.name} {arg.name} {found}" if len(row.args) > 1 else f"{row.name} {found}"
            self._range(f"{named}: allowed {arg.low}..{arg.high}", found, arg.fit(found))

    def _low_byte(self, row: TextRow, found: int) -> int:
        """Return the low byte of a number that has no `Arg` in the command table; report a number above 255."""
        if found > 0xFF:
            self._range(f"{row.name} {found}: allowed 0..255", found, found & 0xFF)
        return found & 0xFF

    def _range(self, text: str, found: int, taken: int) -> None:
        cut = taken != found and not self.dialect.tokens
        self._note("range", text, f"only its low bits are used: {taken}" if cut else "")
