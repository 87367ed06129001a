"""The dialect of parts that keep a program as it was sent, character for character, in a memory of their own.

A command is a letter with numbers after it, as in the dialect of letters.  Beside it there are hexadecimal numbers, a
prefix that negates, numbers from switches, queries of a letter, and strings.  Branches go to bytes: no labels.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ...core.datasheet.table import Row, Sheet
from ...errors import UsageError
from ..dialect import Check
from ..reader import Reader
from ..statements import Instruction, Source, Statement
from .decoder import CommandText, Decoder, Entry
from .forms import Forms
from .grammar import CR, OPEN_BUS

__all__ = ["CommandText", "Decoder", "Entry", "Verbatim"]


@dataclass(frozen=True, eq=False)
class Verbatim(Forms):
    """The dialect in which a command is a letter with numbers after it, stored as it was written.

    Attributes:
        queries: the letters that can be queried, each with the number of digits in its answer.
        asked: what a query returns, in words, for letters that set no register.
        answer_bytes: the number of bytes in a binary answer, by the number of digits in text.
        listing: the letter that queries lines of the memory.
        query: the form of the command that queries.
        quote: the form of the command that sends a string.
        display: the form of the command that writes to a display.
        negate: the prefix that inverts the bits `flips` of the first argument of the commands `negated`.
        negated: the commands that can have this prefix.
        flips: the bits that it inverts, as a mask.
        switches: the character that stands for a first argument read from switches.
        page: the number of bytes that a branch with a one-byte address can reach.
    """

    name = "verbatim"
    streams = True

    @property
    def rules(self) -> Sequence[Check]:
        """Return the linter's rules for programs that are stored as text."""
        from .rules import RULES  # a chip that is only run does not load the linter

        return RULES

    def reader(self, source: Source, number: int, column: int, text: str) -> Reader:
        """Return a reader of one line that begins at a column of the source."""
        from .reader import VerbatimReader

        return VerbatimReader(source, number, column, text)

    def decoder(self, sheet: Sheet) -> Decoder:
        """Return a decoder of the characters that a part receives."""
        return Decoder(sheet)

    def spell(self, row: Row, values: Sequence[int], labels: str = "", names: Mapping[int, str] | None = None) -> str:
        """Return a command as text: its form, and its values after a blank."""
        return f"{row.form} {','.join(map(str, values))}" if values else row.form

    # --------------------------------------------------------------------------------------------------------- sent
    def sent(self, sheet: Sheet, line: str) -> bytes:
        """Return a line as a host sends it: with a carriage return, unless a command ends it that has none."""
        row = sheet.commands.by_form.get(line[:1])
        data = line.encode("latin-1")
        return data if row is not None and not row.terminated and len(line) == 1 else data + bytes([CR])

    def sent_binary(self, sheet: Sheet, line: str) -> bytes:
        """Return the same in binary form: letter, count, data.

        Raises:
            UsageError: the line is no command, or one that binary does not have.
        """
        decoder = self.decoder(sheet)
        found = [decoder.feed(byte, True) for byte in self.sent(sheet, line)]
        command = next((each for each in found if each is not None), None)
        if command is None:
            raise UsageError(f"{line!r} is not a command, so it has no binary form; @bytes sends any bytes")
        if command.switched:
            raise UsageError(f"{line!r}: {self.switches} is text only; binary has no form for switches")
        return self.encoded(command)

    def encoded(self, command: CommandText) -> bytes:
        """Return a command in binary form."""
        row, values = command.row, command.values
        if not row.terminated:
            return bytes([row.code])
        if row.form == self.quote:
            data = command.data
        elif row.form == self.query:
            data = command.data + bytes(values)
        elif row.form == self.display:
            data = bytes(values) + command.data
        else:
            first = values[:1] and (values[0] ^ command.flips,)
            data = b"".join(arg.pack(value) for arg, value in zip(row.args, (*first, *values[1:]), strict=True))
        return bytes([row.code, len(data)]) + data

    # ------------------------------------------------------------------------------------------------- program memory
    def stored(self, statement: Statement) -> bytes:
        """Return the bytes of a statement in the memory: its text and a carriage return."""
        return statement.text.encode("latin-1") + bytes([CR])

    def start(self, said: Sequence[Statement]) -> int:
        """Return the pointer after some commands: where a program that is entered now begins."""
        pointer = 0
        for statement in said:
            if statement.block >= 0:
                pointer = statement.end
            elif statement.row.role == "pointer":
                pointer = statement.values[0]
            elif statement.row.name == "INITIALIZE":
                pointer = 0
        return pointer

    def placed(self, statement: Statement) -> Statement:
        """Return a statement of a program with the address to which it branches: one in the page after it."""
        target = statement.target
        if target is None or statement.row.args[-1].size > 1:
            return statement
        page = statement.end // self.page * self.page
        operands = (*statement.operands[:-1], replace(target, value=page + target.value))
        return replace(statement, operands=operands)

    def cut(self, stored: bytes, at: int, sheet: Sheet) -> Instruction:
        """Return the instruction that begins at an address of the memory; empty cells are one without a row."""
        if stored[at] == OPEN_BUS:  # as many as there are, one after the other
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

    def shown(self, row: Row, instruction: Instruction, labels: str, names: Mapping[int, str]) -> str:
        """Return the text of an instruction in the memory, without its carriage return."""
        return instruction.data.rstrip(b"\r").decode("latin-1")

    def longest_instruction(self, sheet: Sheet) -> int:
        """Return the most bytes that an instruction takes."""
        return 12

    def shorter(self, sheet: Sheet) -> str:
        """Return advice on how a program gets shorter."""
        return "leave out leading zeros, and what the program sets again to the same"

    # -------------------------------------------------------------------------------------------------------- streams
    def entered(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], checked: bool = False
    ) -> bytes:
        """Return the bytes that enter a program as text, with the commands before and after it."""
        program = b"".join(self.stored(statement) for statement in statements)
        before, behind = self.framed(sheet, framing, statements)
        return b"".join(self.sent(sheet, line) for line in before) + program + self.sent(sheet, behind)

    def entered_binary(
        self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement], single_count: bool = False
    ) -> bytes:
        """Return the bytes that enter a program in binary form, with the commands before and after it."""
        if single_count:
            raise UsageError(f"{sheet.part}: every command of a program has its own count")
        before, behind = self.framed(sheet, framing, statements)
        lines = [*before, *(statement.text for statement in statements), behind]
        return b"".join(self.sent_binary(sheet, line) for line in lines)

    def framed(self, sheet: Sheet, framing: Sequence[Row], statements: Sequence[Statement]) -> tuple[list[str], str]:
        """Return the lines in front of a program, with its address unless that is 0, and the one after it."""
        address = statements[0].address if statements else 0
        pointer = [f"{sheet.acting('pointer')[0].form} {address}"] if address else []
        return [*pointer, framing[0].form], framing[-1].form

    def check_stream(self, sheet: Sheet) -> None:
        """Accept every part: each has a text and a binary stream."""
        return

    # ------------------------------------------------------------------------------------------------------ reference
    def table(self, sheet: Sheet) -> str:
        """Return the table of commands, in Markdown."""
        from .reference import command_table

        return str(command_table(sheet))

    def in_full(self, sheet: Sheet, row: Row) -> str:
        """Return all that is known of a command, in Markdown."""
        from .reference import in_full

        return in_full(sheet, row)

    def chapters(self, sheet: Sheet) -> list[str]:
        """Return chapters for the data sheet, in Markdown."""
        from .reference import chapters

        return chapters(sheet)
