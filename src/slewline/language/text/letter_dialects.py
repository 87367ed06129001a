"""The two dialects in which a command is a letter and its arguments: reading of lines, storage of programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Never

from ...core.datasheet.command_rows import TextRow
from ...core.datasheet.table import Arg, Row, Sheet
from ...errors import UsageError
from ..dialect import Check, number_meant, slip_remedy
from ..line_reader import Reader
from ..statements import Instruction, Source, Statement
from . import text_reference
from .command_text import CR, OPEN_BUS, Label, spell
from .decoder import Decoder
from .forms import END, TextDialect
from .written_values import BETWEEN, hint, number


class ReadAlike:
    """The common base of both dialects: the parser of a line, and the description of a command."""

    def reader(self, source: Source, number: int, column: int, text: str) -> Reader:
        """Return a parser of `text`, which is on line `number` of the source and begins at `column`."""
        from .text_reader import TextReader

        return TextReader(source, number, column, text)

    def table(self, sheet: Sheet) -> str:
        """Return the table of commands, in Markdown."""
        return text_reference.command_table(sheet)

    def in_full(self, sheet: Sheet, row: TextRow) -> str:
        """Return the full description of a command, in Markdown."""
        return text_reference.in_full(sheet, row)


@dataclass(frozen=True, eq=False)
class Letters(ReadAlike, TextDialect):
    """The dialect in which a command is a letter followed by numbers, and a program is stored as opcodes.

    Attributes:
        mark: the character after the letter of a label.
    """

    mark: str = "$"

    name = "letters"
    tokens = line_ends = True
    encoding = "ascii"
    numbers, no_number = "decimal number", "write decimal digits only"
    line_limit, argument_limit = 256, 255

    def words(self, row: Row, argument: str) -> list[str]:
        """Return the arguments in a text, at most as many as the command takes; the last includes any further text."""
        return BETWEEN.split(argument, len(row.args) - 1 or -1)

    def value(self, word: str) -> int | None:
        """Return the decimal number in a word; None if it is not a number."""
        return int(word) if word.isascii() and word.isdigit() else None

    def other(self, sheet: Sheet, row: Row, arg: Arg, word: str) -> int | None:
        """Return the code of a label's letter, if this argument may be a label; otherwise None."""
        return ord(word) if arg.label and len(word) == 1 and word in sheet.labels else None

    def instead(self, sheet: Sheet, word: str) -> str:
        return number_meant(word) or slip_remedy(sheet, word)

    def slip(self, sheet: Sheet, argument: str, row: Row) -> str:
        return slip_remedy(sheet, argument, row)

    def byte(self, row: Row) -> int:
        return ord(row.form)

    def typed(self, statement: Statement) -> str:
        """Return a statement as the text that a host sends during program entry, with its labels.

        Each number is written as the value that the chip stores.
        """
        shown = spell(statement.row, [operand.label or operand.value for operand in statement.operands])
        return "".join([*map(self.label, statement.labels), shown])

    def binary(self, sheet: Sheet, statements: Sequence[Statement], single_count: bool) -> bytes:
        if single_count and statements:
            rest = b"".join(map(self.stored, statements))[1:]
            return bytes([self.byte(statements[0].row), len(rest)]) + rest
        rows = sheet.rows(TextRow)
        return b"".join(self.block(rows[each.row.form], each.row.pack(each.values)[1:]) for each in statements)

    def shorter(self, sheet: Sheet) -> str:
        """Return advice on how to shorten a program."""
        enter = f": set them before {sheet.enter.form}" if sheet.enter is not None else ""
        return f"parameters that do not change need no room in the program{enter}"

    def labels_in_full(self, sheet: Sheet) -> str:
        """Return the full description of labels, in Markdown."""
        return text_reference.labels_in_full(sheet)

    def decoder(self, sheet: Sheet) -> Decoder[Label]:
        """Return a decoder of the characters that a part receives."""
        return Decoder(sheet, self)

    @property
    def rules(self) -> Sequence[Check]:
        """The lint rules for programs that are stored as opcodes."""
        from .rules import FOR_TOKENS  # running a chip does not load the linter

        return FOR_TOKENS


@dataclass(frozen=True, eq=False)
class Verbatim(ReadAlike, TextDialect):
    """The dialect in which a command is a letter followed by numbers, and a program is stored as text.

    Attributes:
        queries: the letters that can be queried, each with the number of digits in its answer.
        asked: names of the queried values, keyed by letter, for letters that set no register.
        answer_bytes: the number of bytes in a binary answer, keyed by the number of digits in the same
            answer as text.
        listing: the letter that queries memory lines.
        query: the form of the command that queries.
        quote: the form of the command that sends a string.
        display: the form of the command that writes to a display.
        negate: the character that can precede a command, to invert bits of its first argument.
        negated: the commands that this prefix can precede.
        flips: the bits that the prefix inverts, as a mask.
        switches: the character that stands for a first argument read from switches.
        page: the size in bytes of a memory page; a branch with a one-byte address stays within one page.
    """

    queries: Mapping[str, int] = field(default_factory=dict)
    asked: Mapping[str, str] = field(default_factory=dict)
    answer_bytes: Mapping[int, int] = field(default_factory=dict)
    listing: str = "M"
    query: str = "?"
    quote: str = '"'
    display: str = "["
    negate: str = "/"
    negated: tuple[str, ...] = ("B", "T", "W", "H")
    flips: int = 0x10
    switches: str = "#"
    page: int = 256

    name = "verbatim"
    line_limit = argument_limit = 1024

    def value(self, word: str) -> int | None:
        """Return the decimal or hexadecimal number in a word; None if it is not a number."""
        return number(word)

    def other(self, sheet: Sheet, row: Row, arg: Arg, word: str) -> int | None:
        """Return 0 if `word` is the character that stands for switches and this argument may be read from them.

        Otherwise return None.
        """
        return 0 if word == self.switches and arg is row.args[0] else None

    def instead(self, sheet: Sheet, word: str) -> str:
        return "switches can set the first argument only" if word == self.switches else hint(word)

    def binary(self, sheet: Sheet, statements: Sequence[Statement], single_count: bool) -> bytes:
        """Return statements in binary form, each with its own byte count.

        Raises:
            UsageError: a single count for all statements is requested.
        """
        if single_count:
            raise UsageError(f"{sheet.part}: each command of a program has its own byte count; leave out single_count")
        return b"".join(self.sent_binary(sheet, statement.text) for statement in statements)

    # ------------------------------------------------------------------------------------------------- program memory
    def stored(self, statement: Statement) -> bytes:
        """Return the bytes that a statement occupies in the memory: its text and a carriage return."""
        return statement.text.encode("latin-1") + END

    def start(self, statements: Sequence[Statement]) -> int:
        """Return the memory pointer after these statements: the start address of a program entered after them."""
        pointer = 0
        for statement in statements:
            if statement.block >= 0:
                pointer = statement.end
            elif statement.row.role == "pointer":
                pointer = statement.values[0]
            elif statement.row.name == "INITIALIZE":
                pointer = 0
        return pointer

    def placed(self, statement: Statement) -> Statement:
        """Return a program statement with its full branch address.

        A one-byte address is completed with the page of the byte after the statement.
        """
        target = statement.target
        if target is None or statement.row.args[-1].size > 1:
            return statement
        page = statement.end // self.page * self.page
        operands = (*statement.operands[:-1], replace(target, value=page + target.value))
        return replace(statement, operands=operands)

    def cut(self, stored: bytes, at: int, sheet: Sheet) -> Instruction:
        """Return the instruction at a memory address; adjacent empty cells form one instruction, whose row is None."""
        if stored[at] == OPEN_BUS:  # all adjacent empty cells
            erased = len(stored) - at - len(stored[at:].lstrip(bytes([OPEN_BUS])))
            return Instruction(at, bytes(stored[at : at + erased]), None, ())
        decoder = self.decoder(sheet)
        for end, byte in enumerate(stored[at : at + 4096], at + 1):
            if byte > 0x7E or (byte < 0x20 and byte != CR):
                break
            found = decoder.feed(byte, True)
            if found is not None:
                if not found.row.stored:
                    break
                return Instruction(at, bytes(stored[at:end]), found.row, found.values)
            if decoder.at_letter:
                break
        return Instruction(at, bytes(stored[at : at + 1]), None, ())

    def shown(self, row: TextRow, instruction: Instruction, labels: str, names: Mapping[int, str]) -> str:
        """Return the text of an instruction in the memory, without its carriage return."""
        return instruction.data.rstrip(b"\r").decode("latin-1")

    def longest_instruction(self, sheet: Sheet) -> int:
        """Return the maximum number of bytes in an instruction."""
        return 12

    def shorter(self, sheet: Sheet) -> str:
        """Return advice on how to shorten a program."""
        return "omit leading zeros, and repeated settings of the same value"

    def chapters(self, sheet: Sheet) -> list[str]:
        """Return chapters for the data sheet, in Markdown."""
        return text_reference.chapters(sheet)

    def decoder(self, sheet: Sheet) -> Decoder[Never]:
        """Return a decoder of the characters that a part receives."""
        return Decoder(sheet, self)

    @property
    def rules(self) -> Sequence[Check]:
        """The lint rules for programs that are stored as text."""
        from .rules import FOR_TEXT  # running a chip does not load the linter

        return FOR_TEXT
