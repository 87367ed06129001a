r"""Letters with numbers after them: bytes in, commands out.  No time, no pins; the caller says whether they are text.

Theory of operation.  Between commands the decoder is *at a letter*.  The command letter decides, together with the
mode sampled beside it, how the command goes on:

    ASCII     letter, a space, decimal arguments, carriage return           R 100\\r
    ASCII     label letter, mark, then at a letter again                    A$
    binary    letter, count of data bytes, data bytes                       52 01 64
    both      a letter alone that has no terminator (`Row.terminated`)

Each of these continuations is a state: a method that takes one byte.  Nothing here raises: whatever a host sends has
an answer, and what it did wrong becomes a note (code and text) for the caller to drain.  In program entry a binary
command is kept as it came, opcode and data bytes unchecked; that is how one count can load a whole program.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, cast

from ...core.datasheet.table import Arg, Row, Sheet
from ..dialect import Command, Note, dialect_of, number_meant, slip_remedy, unknown_remedy

CR, LF = 0x0D, 0x0A
NO_NAMES: Mapping[int, str] = MappingProxyType({})
LINE_LIMIT = 256  # characters of a command without its carriage return; the manuals set none
_BETWEEN = re.compile(rb" *, *| +")  # two arguments: a comma or a space


@dataclass(frozen=True, slots=True)
class Label:
    """A label mark: the next command is the instruction that it names."""

    letter: str


Decoded = Command | Label | None


def text_of(data: bytes | bytearray) -> str:
    """Return bytes as characters."""
    return data.decode("latin-1")


def shown(byte: int) -> str:
    """Return a character if it prints, else its code."""
    return chr(byte) if 0x20 < byte < 0x7F else f"0x{byte:02X}"


class Incremental:
    """Takes the bytes of commands one by one.

    `at_letter` is true between commands.  `notes` collects what the host did wrong until `take_notes` drains it.
    """

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet
        self.notes: list[Note] = []
        self.reset()

    def reset(self) -> None:
        """Forget a half-received command.  Notes that were not drained are kept."""
        self.at_letter = True
        self._state: Callable[[int], Any]  # takes a byte after the letter
        self._row: Row | None = None  # of the command in progress; None: a letter without a command
        self._line = bytearray()  # what follows the letter: text in ASCII, data bytes in binary
        self._left = 0  # data bytes still to come

    def take_notes(self) -> list[Note]:
        """The notes so far, which are then forgotten."""
        notes, self.notes = self.notes, []
        return notes

    def _count(self, byte: int) -> Any:
        self._left = byte
        self._state = self._data
        return None if byte else self._block_end()

    def _data(self, byte: int) -> Any:
        self._line.append(byte)
        self._left -= 1
        return None if self._left else self._block_end()

    def _block_end(self) -> Any:
        """The last byte of a binary command has come."""
        raise NotImplementedError

    def _note(self, code: str, text: str, remedy: str = "") -> None:
        self.notes.append(Note(code, f"{text}; {remedy}" if remedy else text))


class Decoder(Incremental):
    """Incremental decoder of one chip's command port."""

    def __init__(self, sheet: Sheet) -> None:
        mark = dialect_of(sheet).mark
        self._label_mark = ord(mark) if mark else -1
        self._rows = {ord(row.form): row for row in sheet.commands}
        self._line_feeds = False  # one has come within a line, and been reported
        super().__init__(sheet)

    def reset(self) -> None:
        """Forget the characters so far, as after a reset of the part."""
        super().reset()
        self._state = self._in_line
        self._alone: Row | None = None  # the command before, if it has no terminator
        self._entering = False  # program entry as it was with the letter; no command changes it half-way
        self._entry_empty = True  # no command since program entry began

    @property
    def unfinished(self) -> str:
        """The line that has come so far; nothing between commands, and in binary, where a count says the end."""
        if self.at_letter or self._state not in (self._in_line, self._skip_line):
            return ""
        return (self._row.form if self._row is not None else "") + text_of(self._line)

    def feed(self, byte: int, ascii: bool, entering: bool) -> Decoded:
        """Take one byte.  `ascii` (pin 36 high) counts with the letter only; `entering`: program entry is on."""
        decoded = self._letter(byte, ascii, entering) if self.at_letter else self._state(byte)
        if decoded is not None and entering:
            self._entry_empty = False
        return decoded

    # ------------------------------------------------------------------------------------------------- the letter

    def _letter(self, byte: int, ascii: bool, entering: bool) -> Decoded:
        alone, self._alone = self._alone, None
        self._entering = entering
        self._entry_empty |= not entering
        row = self._row = self._rows.get(byte)
        if row is None:
            self._stranger(byte, ascii, alone)
        elif not row.terminated:
            self._alone = row
            stored = row.pack(()) if row.stored else b""
            return Command(row, (), 0, stored, spell(row, ()))
        else:
            self.at_letter = False
            self._line.clear()
            self._state = self._in_line if ascii else self._count
        return None

    def _stranger(self, byte: int, ascii: bool, alone: Row | None) -> None:
        """A byte that is no command letter.  No case folding: commands are upper case."""
        if ascii and byte == CR:
            if alone is not None:
                self._note("q-terminated", f"a carriage return after {alone.form}, which ends by itself")
            else:
                self._note("empty-line", "a carriage return without a command")
            return
        self.at_letter = False
        if not ascii:
            self._note("unknown-command", f"{shown(byte)} is not a command; its count and data are ignored")
            self._state = self._count
            return
        if byte == LF:
            self._note(
                "line-feed",
                "a line feed where a command letter belongs: the command after it is lost; send \\r alone",
            )
        else:
            self._note(
                "unknown-command",
                f"{shown(byte)} is not a command; the line is ignored",
                unknown_remedy(self.sheet, chr(byte)),
            )
        self._state = self._skip_line

    # ---------------------------------------------------------------------------------------------------- ASCII

    def _skip_line(self, byte: int) -> Decoded:
        if byte == CR:
            self.at_letter = True
        elif byte == LF:
            self._line_feed()
        return None

    def _line_feed(self) -> None:
        """A line feed within a line: report once what it says about the host."""
        if not self._line_feeds:
            self._line_feeds = True
            self._note(
                "line-end", "the host ends its lines with LF, but this part expects CR: send \\r alone, without \\n"
            )

    def _in_line(self, byte: int) -> Decoded:
        if byte == CR:
            self.at_letter = True
            return self._line_end()
        if byte == self._label_mark:
            return self._mark()
        if byte == LF:
            self._line_feed()
        if len(self._line) >= LINE_LIMIT - 1:
            self._note("too-long", f"a command of more than {LINE_LIMIT} characters; the line is ignored")
            self._state = self._skip_line
        else:
            self._line.append(byte)
        return None

    def _mark(self) -> Decoded:
        """A letter is a label only when the mark follows it directly."""
        letter = cast("Row", self._row).form
        if letter in self.sheet.labels and not self._line:
            self.at_letter = True
            return Label(letter)
        self._note(
            "unknown-command",
            f"{letter}{text_of(self._line)}{chr(self._label_mark)} is not a label; the line is ignored",
        )
        self._state = self._skip_line
        return None

    def _line_end(self) -> Decoded:
        row, body = cast("Row", self._row), bytes(self._line)
        argument = body.strip(b" ")
        if row.args:
            return self._with_arguments(row, body, argument)
        if argument:
            remedy = slip_remedy(self.sheet, text_of(argument), row)
            self._note("extra-argument", f"{row.name} takes no argument; {text_of(argument)} is ignored", remedy)
        elif body:
            self._note("spacing", f"spaces after {row.form}")
        return Command(row, (), 0, row.pack(()), spell(row, ()))

    def _with_arguments(self, row: Row, body: bytes, argument: bytes) -> Decoded:
        last = len(row.args) - 1
        fields = _BETWEEN.split(argument, last) if last else [argument]
        if len(fields) <= last or not all(fields):
            self._note(
                "missing-argument",
                f"{row.name} needs {row.takes}; ignored",
                slip_remedy(self.sheet, text_of(argument), row),
            )
            return None
        if not body.startswith(b" ") or len(body) != 1 + last + sum(map(len, fields)):
            self._note("spacing", f"{row.form}{text_of(body)}: expected one space between letter and argument")
        values, digits = [], 0
        for arg, field in zip(row.args, fields, strict=True):
            if field.isdigit():
                values.append(self._fit(row, arg, int(field)))
                digits += len(field)
            elif self._is_label(arg, field):
                values.append(field[0])
            else:
                remedy = number_meant(text_of(field)) or slip_remedy(self.sheet, text_of(field))
                self._note("bad-number", f"{row.name} {text_of(field)}: not a decimal number; ignored", remedy)
                return None
        shown = [str(value) if field.isdigit() else text_of(field) for value, field in zip(values, fields, strict=True)]
        return Command(row, tuple(values), digits, row.pack(values), spell(row, shown))

    def _is_label(self, arg: Arg, field: bytes) -> bool:
        return arg.label and len(field) == 1 and chr(field[0]) in self.sheet.labels

    def _fit(self, row: Row, arg: Arg, number: int) -> int:
        """Cut a number to the bytes of its argument, whatever its range; the command deals with what is left."""
        self._check(row, arg, number)
        return arg.fit(number)

    # --------------------------------------------------------------------------------------------------- binary

    def _block_end(self) -> Decoded:
        self.at_letter = True
        row, data = self._row, bytes(self._line)
        if row is None:
            return None
        values = row.unpack(data)
        surplus = len(data) - row.data_bytes
        # A whole program may follow its first opcode under one count, so there the count is not a mistake.
        if surplus and not (self._entering and self._entry_empty):
            self._note("count", f"{row.name} takes {row.data_bytes} data bytes; {len(data)} were announced")
        if surplus >= 0 or not self._entering:
            for arg, value in zip(row.args, values, strict=True):
                self._check(row, arg, value)
        text = spell(row, values)
        if not self._entering:
            return Command(row, values, 0, row.pack(values), text)
        if surplus:
            text += f" ({len(data)} data bytes)"
        return Command(row, values, 0, bytes([row.code]) + data, text)

    # --------------------------------------------------------------------------------------------------- endings

    def _check(self, row: Row, arg: Arg, number: int) -> None:
        if not arg.low <= number <= arg.high:
            self._note("range", f"{row.name} {arg.name} {number}: allowed {arg.low}..{arg.high}")


# ------------------------------------------------------------------------------------------------------------ encoders


def spell(row: Row, shown: Sequence[int | str]) -> str:
    """A command as it is written: "R 100", "L 3,B"."""
    return f"{row.form} {','.join(map(str, shown))}" if shown else row.form


def letters_for(row: Row, values: Sequence[int], labels: str, names: Mapping[int, str] = NO_NAMES) -> list[int | str]:
    """The values, with a letter where an operand is the code of one of `labels`, or an address in `names`."""
    pairs = zip(row.args, values, strict=True)
    return [
        names.get(value) or (chr(value) if chr(value) in labels else value) if arg.label else value
        for arg, value in pairs
    ]


def encode_ascii(row: Row, values: Sequence[int] = (), labels: str = "") -> bytes:
    """A command as an ASCII host sends it.  Operands that are codes of `labels` go out as letters."""
    return spell(row, letters_for(row, values, labels)).encode() + (b"\r" if row.terminated else b"")


def encode_binary(row: Row, values: Sequence[int] = ()) -> bytes:
    """A command as a binary host sends it: letter, count, data; low bytes first."""
    data = b"".join(arg.pack(value) for arg, value in zip(row.args, values, strict=True))
    return row.form.encode() + (bytes([len(data)]) + data if row.terminated else b"")
