"""How commands are written, sent and stored: the interface of every dialect.  A sheet names its dialect.

    text/        a letter and its arguments, as text or binary                R 100        52 01 64
    lines/       a line of text, and a line for its answer                    jc1,18
    packets/     a command byte and words, written as a mnemonic              SET_POS 12345

The assembler, disassembler, linter and reference query the dialect for the differences, and know no part by name.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from ..core.datasheet.table import Row, Sheet
from ..errors import SheetError, UsageError
from .statements import Instruction, Source, Statement

if TYPE_CHECKING:
    from .line_reader import Reader

Check = Callable[[Source], None]
"""A rule: looks at the text and reports what it finds with `source.report`."""


@dataclass(frozen=True, slots=True)
class Note:
    """A host's mistake; the chip model reports it as a finding."""

    code: str
    text: str


@dataclass(frozen=True, slots=True)
class Command:
    """A complete command.

    `values` are numbers (a label is represented by the code of its letter); `digits` is the number of
    decimal digits that had to be converted, which costs the chip time; `stored` are the bytes that program
    entry puts into the buffer; `text` is the command in a transcript.
    """

    row: Row
    values: tuple[int, ...]
    digits: int
    stored: bytes
    text: str


@dataclass(frozen=True, slots=True)
class Refusal:
    """The reason why a line is no command; `code` is "unknown", "argument" (it does not fit) or "range".

    `text` has the details.  The other fields are the place of the problem (characters `at` to `end`), the
    text found there, the allowed values, and the remedy.
    """

    code: str
    text: str
    at: int
    end: int
    found: str
    allowed: str
    remedy: str = ""


R = TypeVar("R", bound=Row)


class Dialect(Generic[R]):
    """The written, sent and stored form of commands.  Unless overridden, an instruction is an opcode with arguments."""

    name = ""
    row_type: type[Row] = Row  # type of its commands
    mark = ""  # mark after the letter of a label
    streams = False  # True if it has a binary form
    longest = 0  # maximum line length, characters; 0: the manual states no limit
    where = ""  # the section of the manual that describes it
    answers: Mapping[str, str] = MappingProxyType({})  # the answers of a part, and their meaning
    constant_bit: int | None = None  # bit of a character that noise on a line must leave intact to be detected

    @property
    def rules(self) -> Sequence[Check]:
        """The lint rules of this dialect, in addition to those for all parts."""
        return ()

    # --------------------------------------------------------------------------------------------------- program text
    def reader(self, source: Source, number: int, column: int, text: str) -> Reader:
        """Return a parser for a line of a text."""
        raise NotImplementedError

    def directs(self, text: str) -> bool:
        """Return whether a line without an @ is nevertheless a directive to the host."""
        return False

    def refusal(self, sheet: Sheet, text: str, crystal_hz: int) -> Refusal | None:
        """Return the reason why no host can send a line; None if a host can send it.

        A line that a host can send may still contain mistakes, to which the part responds.
        """
        return None

    def label(self, letter: str) -> str:
        """Return a label as written before its instruction."""
        return f"{letter}{self.mark}"

    def spell(self, row: R, values: Sequence[int], labels: str = "", names: Mapping[int, str] | None = None) -> str:
        """Return the text of a command.

        Args:
            labels: letters that can be labels; where a label is allowed, their codes are written as letters.
            names: labels by address.
        """
        raise NotImplementedError

    def meaning_of(self, answer: str) -> str:
        """Return the sheet's text about an answer; empty if the answer needs no explanation."""
        return self.answers.get(answer, "")

    # -------------------------------------------------------------------------------------------------- program buffer
    def stored(self, statement: Statement) -> bytes:
        """Return an instruction as stored in the program buffer, or, for a part without one, as a host sends it."""
        return statement.row.pack(statement.values)

    def start(self, statements: Sequence[Statement]) -> int:
        """Return the address at which a program begins if it is entered after these statements."""
        return 0

    def placed(self, statement: Statement) -> Statement:
        """Return a statement with its branch address completed; this depends on the statement's own address."""
        return statement

    def shown(self, row: R, instruction: Instruction, labels: str, names: Mapping[int, str]) -> str:
        """Return the text of an instruction in the buffer; `labels` and `names` are those of `spell`."""
        return self.spell(row, instruction.values, labels, names)

    def cut(self, stored: bytes, at: int, sheet: Sheet) -> Instruction:
        """Return the instruction at a buffer address; it has no row if the byte there is not an opcode."""
        row = sheet.commands.by_code.get(stored[at])
        data = bytes(stored[at : at + (row.size if row else 1)])
        if row and len(data) == row.size:
            return Instruction(at, data, row, row.unpack(data[1:], data[0]))
        return Instruction(at, data, None, ())

    def longest_instruction(self, sheet: Sheet) -> int:
        """Return the number of bytes of the longest instruction."""
        return max(row.size for row in sheet.commands)

    def shorter(self, sheet: Sheet) -> str:
        """Return the remedy for a program that is too long."""
        return ""

    # ------------------------------------------------------------------------------------------------------- streams
    def decoder(self, sheet: Sheet) -> Any:
        """Return a decoder for a part that receives commands byte by byte.

        Raises:
            UsageError: the part does not receive a stream of bytes.
        """
        raise UsageError(f"the {sheet.part} accepts {self.name}, not a stream of bytes")

    def entered(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], checked: bool = False
    ) -> bytes:
        """Return the text that a host sends to enter a program; if `checked`, each line has its checksum."""
        raise NotImplementedError

    def entered_binary(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], single_count: bool = False
    ) -> bytes:
        """Return the bytes that a host sends to enter a program in binary form, with addresses in place of labels.

        Raises:
            UsageError: the part has no binary form.
        """
        raise UsageError(f"the {sheet.part.upper()} has no binary commands; choose ascii, the form that a host sends")

    def parted(self, lines: list[str], sheet: Sheet) -> list[str]:
        """Return lines of hexadecimal bytes from a host, rearranged as one command per line; by default, unchanged."""
        return lines

    def check_stream(self, sheet: Sheet) -> None:
        """Raise UsageError if the part has no binary form of commands."""
        raise UsageError(
            f"--stream: the {sheet.part.upper()} has no binary mode, so the output of its host is text; omit the option"
        )

    # ------------------------------------------------------------------------------------------------------ reference
    def meant(self, sheet: Sheet, text: str) -> list[Row]:
        """Return the commands that may be meant by a text that is neither a form nor a name of a command."""
        return []

    def table(self, sheet: Sheet) -> str:
        """Return all commands as a table, with remarks."""
        raise NotImplementedError

    def in_full(self, sheet: Sheet, row: R) -> str:
        """Return the full description of a command."""
        raise NotImplementedError

    def labels_in_full(self, sheet: Sheet) -> str:
        """Return the full description of labels."""
        raise NotImplementedError

    def chapters(self, sheet: Sheet) -> list[str]:
        """Return this dialect's own chapters of the reference, in addition to those for all dialects."""
        return []


D = TypeVar("D", bound=Dialect[Any])
LIKE_DIGITS = str.maketrans("OolI", "0011")
IN_DIGITS = "in digits: the letters O and l are not digits"
HEXADECIMAL = re.compile(r"(?:0[xX]|\$|#)([0-9A-Fa-f]{1,8})|([0-9][0-9A-Fa-f]{0,7})[hH]")


def dialect_of(sheet: Sheet) -> Dialect[Any]:
    """Return the dialect of a sheet.

    Raises:
        SheetError: the sheet names no dialect.
    """
    return spoken_as(sheet, Dialect)


def spoken_as(sheet: Sheet, kind: type[D]) -> D:
    """Return the dialect of a sheet, which must be of a given kind.

    Raises:
        SheetError: the dialect is of another kind.
    """
    if not isinstance(sheet.dialect, kind):
        found = "no dialect" if sheet.dialect is None else f"the dialect {sheet.dialect.name}"
        raise SheetError(f"{sheet.part}: {found}; expected a {kind.__name__}")
    return sheet.dialect


def slip_remedy(sheet: Sheet, written: str, row: Row | None = None) -> str:
    """Return the remedy for text that does not fit `row`; empty if none is known.

    The remedy for a character that the manual uses but the chip does not accept takes precedence over the
    remedy for the command, because it explains more.
    """
    odd = next((letter for letter in written if letter in sheet.slips and letter not in sheet.commands.by_form), "")
    return sheet.slips.get(odd or (row.form if row else ""), "")


def digits_meant(word: str) -> str:
    """Return the remedy for a number with the letter O or l among its digits; empty for any other word."""
    digits = word.translate(LIKE_DIGITS)
    meant = digits != word and digits.isascii() and digits.isdigit()
    return f"write {digits}, {IN_DIGITS}" if meant else ""


def number_meant(word: str) -> str:
    """Return the remedy for a word that should be decimal, but is hexadecimal or has O or l in it; else ""."""
    found = HEXADECIMAL.fullmatch(word)
    return digits_meant(word) or (f"write {int(found[1] or found[2], 16)}, in decimal" if found else "")


def state_remedy(sheet: Sheet, entering: bool) -> str:
    """Return the remedy for a command in the wrong place: inside program entry if `entering`, else outside it.

    It is empty for a command that belongs inside program entry, if the part has no programs.
    """
    if entering:
        if sheet.enter is None:
            return f"the {sheet.part.upper()} stores no programs: its host sends the lines, as slewline run does"
        return f"end program entry first, with {' or '.join(row.form for row in sheet.leave)}"
    return f"begin program entry with {sheet.enter.form}" if sheet.enter is not None else ""


def unknown_remedy(sheet: Sheet, letter: str) -> str:
    """Return the remedy for a letter that is not a command; empty if none is known."""
    if letter.upper() in sheet.commands.by_form:
        return f"write {letter.upper()}: command letters are upper case"
    return sheet.slips.get(letter, "")
