"""The packets dialect: a command is a byte and words, written in a text as a mnemonic and a number."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ...core.datasheet.command_rows import PacketRow
from ...core.datasheet.table import Row, Sheet
from ...errors import UsageError
from ..dialect import Refusal, spoken_as
from ..line_reader import Reader
from ..statements import Instruction, Operand, Source
from .packet_grammar import (
    DIRECTS,
    LONGEST,
    Sibling,
    Words,
    checksum,
    command,
    counted,
    fields,
    number,
    numbers,
    parse,
    range_of,
    row,
    shown,
    spell,
    status_bit,
    usage,
    values,
    words,
)
from .packet_reference import packet_in_full, packet_table, words_of

# fmt: off
__all__ = [
    "DIRECTS", "LONGEST", "Packets", "Sibling", "Words", "checksum", "command", "counted", "fields", "number",
    "numbers", "parse", "range_of", "row", "shown", "spell", "status_bit", "usage", "values", "words",
]
# fmt: on


class PacketReader(Reader):
    """A parser of a line that contains one packet."""

    def take(self, labels: tuple[str, ...]) -> tuple[str, ...]:
        found = parse(self.sheet, self.text)
        if isinstance(found, Refusal):
            where = spoken_as(self.sheet, Words).where
            self.error(found.at, found.end, found.code, found.found, found.allowed, where, found.remedy)
            return ()
        at = len(self.text) - len(self.text.split()[-1])
        operands = tuple(Operand(*self.spot(at, len(self.text)), value) for value in found.values)
        self.add(0, len(self.text), found.row, operands, ())
        return ()


@dataclass(frozen=True, eq=False)
class Packets(Words):
    """The dialect in which a command is a packet: a command byte, words to and from the part, and a checksum.

    A code that is neither in the command table nor in `illegal`, `reserved` or `siblings` has no data.

    Attributes:
        illegal: the codes that are answered with checksum 0.
        reserved: codes without data or effect.
        siblings: the commands of sister parts, keyed by code; they have no effect on this part.
        version: the version word of the part.
        status: the fields of an axis's status word.
        mode: the fields of an axis's mode word.
        slips: names in the manual's text that are not commands, each with the intended command.
        where: the section of the manual that describes the packets.
    """

    name = "packets"

    def reader(self, source: Source, number: int, column: int, text: str) -> Reader:
        """Return a parser of `text`, which is on line `number` of the source and begins at `column`."""
        return PacketReader(source, number, column, text)

    def directs(self, text: str) -> bool:
        """Return whether a line is a directive for the host rather than a command for the part."""
        return text.split(maxsplit=1)[0].lower() in DIRECTS

    def refusal(self, sheet: Sheet, text: str, crystal_hz: int) -> Refusal | None:
        """Return the reason why a line is not a packet; None if the line is a packet."""
        found = parse(sheet, text, crystal_hz)
        return found if isinstance(found, Refusal) else None

    def spell(
        self, row: PacketRow, values: Sequence[int], labels: str = "", names: Mapping[int, str] | None = None
    ) -> str:
        """Return a command as text: its name and its values."""
        return spell(row, values)

    def parted(self, lines: list[str], sheet: Sheet) -> list[str]:
        """Return the packets in lines of hexadecimal bytes, one packet per line.

        If any of the lines contains anything else, all lines are returned unchanged.
        """
        try:
            data = bytes.fromhex(" ".join(lines))
        except ValueError:
            return lines
        found, at = [], 0
        while at < len(data):
            found.append(self.cut(data, at, sheet).data)
            at += len(found[-1])
        return [packet.hex(" ") for packet in found]

    def cut(self, stored: bytes, at: int, sheet: Sheet) -> Instruction:
        """Return the packet that begins at an address, as an `Instruction`.

        For a command of a sister part, the instruction has the bytes of the whole packet, but its row is None.
        """
        found, sibling = super().cut(stored, at, sheet), self.siblings.get(stored[at])
        if found.row is None and sibling is not None:
            return Instruction(at, bytes(stored[at : at + 1 + 2 * sibling.writes]), None, ())
        return found

    def check_stream(self, sheet: Sheet) -> None:
        """Raise UsageError, because packets have no second, binary form."""
        raise UsageError(f"--stream: the {sheet.part.upper()} has no binary mode; omit the option")

    def meant(self, sheet: Sheet, text: str) -> list[Row]:
        """Return a list with the row of the command that a text gives by its hexadecimal code or by its name.

        Raises:
            UnknownName: the part has no such command.
        """
        coded = re.fullmatch(r"(?:0x|\$)?([0-9a-f]{2})", text.lower())
        found = sheet.commands.by_code.get(int(coded[1], 16)) if coded else None
        return [found or row(sheet, "".join(text.split()[:1]))]

    def table(self, sheet: Sheet) -> str:
        """Return the table of commands, in Markdown."""
        return packet_table(sheet)

    def in_full(self, sheet: Sheet, row: PacketRow) -> str:
        """Return the full description of a command, in Markdown."""
        return packet_in_full(sheet, row)

    def chapters(self, sheet: Sheet) -> list[str]:
        """Return chapters for the data sheet: status, mode and version words, and the codes that are not commands."""
        return words_of(self)
