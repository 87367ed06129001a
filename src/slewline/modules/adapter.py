"""The protocol of a part on a bus, through an adapter that does the handshake and accepts lines of text.

The lines are those of `slewline serve --framing` (links/lines/framing.py): commands in text form, `?0`
to `?3` for the verify groups, `?` to query whether the part accepts commands.  Commands to the part are
not answered.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from ..core.datasheet.channel import BusHandshake
from ..core.datasheet.table import Row, Sheet
from ..core.wires.serial import CharacterFormat
from ..errors import UsageError
from ..language.dialect import Command, spoken_as
from ..language.text import Letters
from ..links.lines.framing import LONGEST
from ..parts.hosts.ends.shadow import TEXT
from .failures import DamagedAnswer
from .spoken import Speech

RATES = (115200, 57600, 38400, 19200, 9600, 4800, 2400, 1200)
USUAL_BAUD = 9600
END = b"\r\n"  # bytes of an answer
READY = "?"
POSITION, PROGRAM, STATUS, PARAMETERS = range(4)  # the verify groups
DIGITS = 5  # text of a position
BYTE = "[0-9A-F]{2}"


class FramedSpeech(Speech):
    """The protocol of a part on a bus, connected by an adapter with framing.

    Raises:
        UsageError: the part cannot be read back.
    """

    ends = b"\r\n"
    wake = b"\xff\r"  # the rest of an earlier host's line is no longer ASCII, so the adapter refuses it
    answers_all: ClassVar[bool] = False
    is_timed: ClassVar[bool] = False
    shows_entry: ClassVar[bool] = False
    word = CharacterFormat(8, "none", 1)
    rates = RATES
    usual_baud = USUAL_BAUD
    probe = READY
    busy = f"{READY} busy"

    def __init__(
        self, sheet: Sheet, baud: int | None = None, checked: bool | None = None, address: int | None = None
    ) -> None:
        bus = sheet.through(BusHandshake)
        if not bus.verify_bytes:
            raise UsageError(
                f"{sheet.part} is on a bus and cannot be read back; allowed: a part that has a serial line, or that "
                "can be read back over its bus"
            )
        self.dialect = spoken_as(sheet, Letters)
        self.bus = bus
        super().__init__(sheet, baud, checked, address)
        self._refuse(checked, address)

    @property
    def questions(self) -> Mapping[str, tuple[str, str]]:
        """Values that can be read, keyed by name: the query for each, and a pattern that captures it in the answer."""
        sizes = self.bus.verify_bytes
        found = {
            "adapter": (READY, rf"\{READY} (ready)"),
            "position": (f"?{POSITION}", rf"\?{POSITION} ({_bytes(DIGITS, '3[0-9]')}|{_bytes(2)})"),
        }
        at = 0
        for row in self.sheet.registers:
            if row.name != "position":
                found[row.name] = (f"?{PARAMETERS}", _part(PARAMETERS, sizes[PARAMETERS], at, row.bits // 8))
                at += row.bits // 8
        last = sizes[STATUS] - 1
        return MappingProxyType(found | {"direction": (f"?{STATUS}", _part(STATUS, last + 1, last, 1))})

    def value(self, what: str, reply: str) -> str:
        """Return the value named `what` as text, given the part of the answer that the query's pattern captures.

        A direction is returned as the command that sets it, any other value as a decimal number; the query of the
        adapter's state is returned unchanged.
        """
        if what == "adapter":
            return reply
        data = bytes.fromhex(reply)
        if what == "direction":
            name = "CCW" if data[-1] & self.bus.ccw_bit else "CW"
            return next(row.form for row in self.sheet.commands if row.name == name)
        return data.decode("ascii") if len(data) == DIGITS else str(int.from_bytes(data, "big"))

    def group(self, number: int, answer: str) -> bytes:
        """Return the bytes of a verify group, given its number and the answer to its query.

        Raises:
            DamagedAnswer: the answer does not contain this verify group.
        """
        shape = rf"\?{number} {_bytes(self.bus.verify_bytes[number])}"
        if not re.fullmatch(shape, answer):
            raise DamagedAnswer(f"{answer[:60]!r} does not have the {self.bus.verify_bytes[number]} bytes of ?{number}")
        return bytes.fromhex(answer[2:])

    def framed(self, command: str) -> bytes:
        """Return a command as a line of bytes, with a carriage return."""
        if not command.isascii() or not command or set(command) & set("\r\n") or len(command) > LONGEST:
            raise UsageError(f"command {command[:60]!r}; expected one line of ASCII, up to {LONGEST} characters")
        return command.encode("ascii") + b"\r"

    def answers(self, command: str) -> bool:
        """Return whether a command is answered: queries are, and so is "!", which discards all pending commands."""
        return self.is_question(command) or command == "!"

    def is_question(self, command: str) -> bool:
        """Return whether a line is a query, which the adapter answers itself and does not pass on to the part."""
        return command.startswith(READY)

    def moves(self, command: str) -> bool:
        """Return whether a line may make the motor step."""
        return not self.answers(command) and super().moves(command)

    def row(self, command: str) -> Row | None:
        """Return the row of the only command in a line.

        None if the line has no command or several commands, or is meant for the adapter itself.
        """
        if self.answers(command):
            return None
        decoder = self.dialect.decoder(self.sheet)
        sent = self.dialect.sent(self.sheet, command)
        found = [each.row for byte in sent if isinstance(each := decoder.feed(byte, bool(TEXT), False), Command)]
        return found[0] if len(found) == 1 else None

    def longest(self, command: str) -> int:
        """Return the maximum number of characters in an answer, with room for the largest verify group."""
        return super().longest(command) + 3 * max(self.bus.verify_bytes)

    def is_complete(self, command: str, received: bytes) -> bool:
        """Return whether the received bytes are a complete answer."""
        return received.endswith(END)

    def lines(self, received: bytes) -> list[str]:
        """Return the lines of an answer."""
        return [self.stripped(line) for line in received.removesuffix(END).split(END)]

    def refusal(self, line: str) -> str:
        """Return the reason why a line was not executed, given the answer to the line.

        The adapter may have refused the line, or the part may accept no commands now.  The text is empty if the
        answer is not a refusal.
        """
        if line == self.busy:
            return "the part is busy, or lines are waiting for it"
        return line[2:] if self.is_garbled(line) else ""

    def is_garbled(self, line: str) -> bool:
        """Return whether an answer is the adapter's refusal of a line, such as a query that arrived damaged."""
        return line.startswith("! ")


def _bytes(number: int, byte: str = BYTE) -> str:
    return " ".join([byte] * number)


def _part(group: int, size: int, at: int, number: int) -> str:
    """Return a regular expression for the answer with a verify group of `size` bytes.

    It captures `number` of these bytes, beginning with the byte at index `at`.
    """
    before, after = (_bytes(count) for count in (at, size - at - number))
    return rf"\?{group} " + " ".join(filter(None, (before, f"({_bytes(number)})", after)))
