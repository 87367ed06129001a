"""How commands are written, sent and stored: the face that every dialect has.  A sheet names its own.

    text/        a letter and its arguments, as text or binary                R 100        52 01 64
    lines/       a line of text, its answer another one                       jc1,18
    packets/     a command byte and words, written as a mnemonic              SET_POS 12345

Assembler, disassembler, linter and reference ask the dialect for what differs, and know no part by name.
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
    """What a host did wrong; the chip model makes a finding of it."""

    code: str
    text: str


@dataclass(frozen=True, slots=True)
class Command:
    """A complete command.

    `values` are numbers, a label operand being the code of its letter; `digits` is how many decimal digits had to be
    converted, since that takes the chip time; `stored` is what program entry puts into the buffer; `text` is how a
    transcript shows the command.
    """

    row: Row
    values: tuple[int, ...]
    digits: int
    stored: bytes
    text: str


@dataclass(frozen=True, slots=True)
class Refusal:
    """A line that is no command: "unknown", or its "argument" does not fit or is out of "range"; `text` says how.

    The rest is for showing the place: characters `at` to `end`, what was found there, what would be allowed, and
    what to do.
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
    """How commands are written, sent and stored.  Instructions are tokens, opcode and arguments, unless overridden."""

    name = ""
    row_type: type[Row] = Row  # of its commands
    mark = ""  # follows the letter of a label
    streams = False  # has it a binary form?
    longest = 0  # characters of a line that a part takes; 0: its manual sets no limit
    where = ""  # the section of the manual that describes it
    answers: Mapping[str, str] = MappingProxyType({})  # what a part answers, and what that means
    constant_bit: int | None = None  # the bit of a character that noise on a line must spare to be found

    @property
    def rules(self) -> Sequence[Check]:
        """Rules of the linter, besides those for all parts."""
        return ()

    # --------------------------------------------------------------------------------------------------- program text
    def reader(self, source: Source, number: int, column: int, text: str) -> Reader:
        """Return what takes a line of a text apart."""
        raise NotImplementedError

    def directs(self, text: str) -> bool:
        """Is a line directed at the host, though it does not begin with @?"""
        return False

    def refusal(self, sheet: Sheet, text: str, crystal_hz: int) -> Refusal | None:
        """Return why no host can send a line; None: it can, and the part answers for what is wrong with it."""
        return None

    def label(self, letter: str) -> str:
        """Return a label as it stands in front of its instruction."""
        return f"{letter}{self.mark}"

    def spell(self, row: R, values: Sequence[int], labels: str = "", names: Mapping[int, str] | None = None) -> str:
        """Return a command as it is written.

        Args:
            labels: letters whose codes stand for themselves where a label may stand.
            names: labels of addresses.
        """
        raise NotImplementedError

    def said(self, answer: str) -> str:
        """Return what the sheet says of an answer; empty where that goes without saying."""
        return self.answers.get(answer, "")

    # -------------------------------------------------------------------------------------------------- program buffer
    def stored(self, statement: Statement) -> bytes:
        """Return an instruction as the program buffer keeps it, or as a host writes it, if none is kept."""
        return statement.row.pack(statement.values)

    def start(self, said: Sequence[Statement]) -> int:
        """Return the address at which a program begins that is entered after these statements."""
        return 0

    def placed(self, statement: Statement) -> Statement:
        """Return a statement that has its address in a program, with the address to which it branches."""
        return statement

    def shown(self, row: R, instruction: Instruction, labels: str, names: Mapping[int, str]) -> str:
        """Return an instruction of the buffer, of a row, as it is written; `labels` and `names` as for `spell`."""
        return self.spell(row, instruction.values, labels, names)

    def cut(self, stored: bytes, at: int, sheet: Sheet) -> Instruction:
        """Return the instruction that begins at an address of the buffer; without a row, a byte that is no opcode."""
        row = sheet.commands.by_code.get(stored[at])
        data = bytes(stored[at : at + (row.size if row else 1)])
        if row and len(data) == row.size:
            return Instruction(at, data, row, row.unpack(data[1:], data[0]))
        return Instruction(at, data, None, ())

    def longest_instruction(self, sheet: Sheet) -> int:
        """Return the bytes of the longest instruction."""
        return max(row.size for row in sheet.commands)

    def shorter(self, sheet: Sheet) -> str:
        """Return what to do about a program that is too long."""
        return ""

    # ------------------------------------------------------------------------------------------------------- streams
    def decoder(self, sheet: Sheet) -> Any:
        """Return a decoder of what comes in byte by byte, for a part that takes commands so."""
        raise UsageError(f"the {sheet.part} takes no stream of bytes, but {self.name}")

    def entered(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], checked: bool = False
    ) -> bytes:
        """Return what a host sends in text to enter a program, each line with its checksum if `checked`."""
        raise NotImplementedError

    def entered_binary(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], single_count: bool = False
    ) -> bytes:
        """Return what a host sends in binary form to enter a program, whose labels are addresses.

        Raises:
            UsageError: the part has no binary form.
        """
        raise UsageError(
            f"the {sheet.part.upper()} takes no binary commands; choose ascii, which is what a host sends it"
        )

    def parted(self, lines: list[str], sheet: Sheet) -> list[str]:
        """Return lines of bytes in hexadecimal as a host sends them, one thing at a time."""
        return lines

    def check_stream(self, sheet: Sheet) -> None:
        """Raise UsageError if the part has no binary form of commands."""
        raise UsageError(f"--stream: the {sheet.part.upper()} has no binary mode; what a host sends it is text already")

    # ------------------------------------------------------------------------------------------------------ reference
    def meant(self, sheet: Sheet, text: str) -> list[Row]:
        """Return the rows that a text means which is neither form nor name of a command."""
        return []

    def table(self, sheet: Sheet) -> str:
        """Return all commands as a table, with what must be said of it."""
        raise NotImplementedError

    def in_full(self, sheet: Sheet, row: R) -> str:
        """Return all about a command."""
        raise NotImplementedError

    def labels_in_full(self, sheet: Sheet) -> str:
        """Return all about labels."""
        raise NotImplementedError

    def chapters(self, sheet: Sheet) -> list[str]:
        """Return further chapters of the reference."""
        return []


D = TypeVar("D", bound=Dialect[Any])
LIKE_DIGITS = str.maketrans("OolI", "0011")
IN_DIGITS = "in digits: the letters O and l are not digits"
HEXADECIMAL = re.compile(r"(?:0[xX]|\$|#)([0-9A-Fa-f]{1,8})|([0-9][0-9A-Fa-f]{0,7})[hH]")


def dialect_of(sheet: Sheet) -> Dialect[Any]:
    """Return the dialect of a sheet.

    Raises:
        SheetError: it names none.
    """
    return spoken_as(sheet, Dialect)


def spoken_as(sheet: Sheet, kind: type[D]) -> D:
    """Return the dialect of a sheet, of a kind.

    Raises:
        SheetError: it is of another kind.
    """
    if not isinstance(sheet.dialect, kind):
        found = "no dialect" if sheet.dialect is None else f"the dialect {sheet.dialect.name}"
        raise SheetError(f"{sheet.part}: {found}; expected a {kind.__name__}")
    return sheet.dialect


def slip_remedy(sheet: Sheet, written: str, row: Row | None = None) -> str:
    """Return the remedy where something else than `row` takes was written; empty: none is known.

    A character that the manual prints and the chip does not take explains more than the command does.
    """
    odd = next((letter for letter in written if letter in sheet.slips and letter not in sheet.commands.by_form), "")
    return sheet.slips.get(odd or (row.form if row else ""), "")


def digits_meant(word: str) -> str:
    """Return the remedy for a number with letters O or l among its digits; empty: it is something else."""
    digits = word.translate(LIKE_DIGITS)
    meant = digits != word and digits.isascii() and digits.isdigit()
    return f"write {digits}, {IN_DIGITS}" if meant else ""


def number_meant(word: str) -> str:
    """Return the remedy for a word where decimal digits belong: letters among them, hexadecimal; empty: none."""
    found = HEXADECIMAL.fullmatch(word)
    return digits_meant(word) or (f"write {int(found[1] or found[2], 16)}, in decimal" if found else "")


def state_remedy(sheet: Sheet, entering: bool) -> str:
    """Return what lets a command come that belongs outside program entry, or into it; empty: it stores no program."""
    if entering:
        if sheet.enter is None:
            return f"the {sheet.part.upper()} stores no programs: its host sends the lines, as slewline run does"
        return f"end program entry first, with {' or '.join(row.form for row in sheet.leave)}"
    return f"begin program entry with {sheet.enter.form}" if sheet.enter is not None else ""


def unknown_remedy(sheet: Sheet, letter: str) -> str:
    """Return the remedy for a letter that is no command; empty: none is known."""
    if letter.upper() in sheet.commands.by_form:
        return f"write {letter.upper()}: command letters are upper case"
    return sheet.slips.get(letter, "")
