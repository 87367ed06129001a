"""The protocols of parts on a serial line, from their data sheets: rates, formats, frames, ends of answers."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType

from ..core.datasheet.channel import AdaptiveLine, BusHandshake, Channel, SerialLine, row_for
from ..core.datasheet.table import Row, Sheet
from ..core.wires.serial import CharacterFormat
from ..errors import UsageError
from ..language.dialect import Command, spoken_as
from ..language.lines import KEPT, Lines, checksum, framed, parse
from ..language.text import CommandText, Verbatim
from ..parts.hosts.ends.shadow import TEXT
from .adapter import FramedSpeech
from .failures import DamagedAnswer
from .spoken import CR, Speech

FETCH_S = 50e-6  # per byte of memory, at most: the end of an endless line is searched for up to the end of the memory


class LineSpeech(Speech):
    """The protocol of a part that answers every line with one or more lines.

    `kept` is a mask of the bits that are set in every checksum of the part; for some old modules, it is 0.
    """

    kept = KEPT

    def __init__(
        self, sheet: Sheet, baud: int | None = None, checked: bool | None = None, address: int | None = None
    ) -> None:
        self.line = sheet.through(SerialLine)
        self.dialect = spoken_as(sheet, Lines)
        super().__init__(sheet, baud, checked, address)
        allowed = sorted(set(self.line.addresses.values()) | {0})
        if self.address not in allowed:
            raise UsageError(f"--address {address}: allowed {', '.join(map(str, allowed))} (0: no address is sent)")
        if checked and not self.line.checksum_pin:
            raise UsageError(f"--checksum: the {sheet.part.upper()} has no checksums; leave out --checksum")

    @property
    def word(self) -> CharacterFormat:
        return CharacterFormat(self.line.bits, self.line.parity, self.line.stop)

    @property
    def rates(self) -> tuple[int, ...]:
        """Rates that can be selected by straps, the highest first."""
        return tuple(sorted(self.line.bauds.values(), reverse=True))

    @property
    def probe(self) -> str:
        """Query that is used to check whether a module answers: the last of the part's queries."""
        if not self.questions:
            raise UsageError(f"{self.sheet.part}: its sheet has no queries; add `questions` to its dialect")
        return [*self.questions.values()][-1][0]

    @property
    def questions(self) -> Mapping[str, tuple[str, str]]:
        return self.dialect.questions

    def framed(self, command: str) -> bytes:
        """Return a command as a line with a carriage return, and with address and checksum if they are used."""
        if not command.isascii() or CR.decode() in command or not command:
            raise UsageError(f"command {command!r}; expected one line of ASCII, without a carriage return")
        return framed(f"{self.address or ''}{command}", self.checked, self.kept)

    def row(self, command: str) -> Row | None:
        found = parse(self.sheet, command)
        return found.row if isinstance(found, Command) else None

    def is_complete(self, command: str, received: bytes) -> bool:
        """Return whether the last line of an answer has arrived.

        A listing ends with a line that is itself one of the part's answers, such as END; no line of a program
        is equal to an answer.
        """
        if not received.endswith(CR):
            return False
        row = self.row(command)
        if row is None or row.role != "list":
            return True
        last = received[:-1].rpartition(CR)[2]
        return (last[:-1] if self.checked else last).decode("latin-1") in self.dialect.answers

    def longest(self, command: str) -> int:
        """Return the maximum number of characters in a command's answer; a listing may be of a full memory."""
        row = self.row(command)
        if row is None or row.role != "list":
            return super().longest(command)
        return (self.sheet.buffer_bytes + 1) * (self.dialect.longest or super().longest(command))

    def stripped(self, line: bytes) -> str:
        """Return a line of an answer without its checksum, if lines have checksums."""
        text = super().stripped(line)
        if not self.checked:
            return text
        if len(line) < 2 or line[-1] != checksum(line[:-1], self.kept):
            raise DamagedAnswer(f"{line!r}: its last character is not its checksum")
        return text[:-1]

    def refusal(self, line: str) -> str:
        """Return the sheet's text for an answer that is a refusal or reports "busy"; empty for any other answer."""
        return self.dialect.answers[line] if line in (*self.dialect.refusals, self.dialect.busy) else ""

    def is_garbled(self, line: str) -> bool:
        return line == self.dialect.garbled


class QuerySpeech(Speech):
    """The protocol of a part that answers only queries, and detects the rate from two carriage returns."""

    wake = CR + CR
    answers_all = False

    def __init__(
        self, sheet: Sheet, baud: int | None = None, checked: bool | None = None, address: int | None = None
    ) -> None:
        self.line = sheet.through(AdaptiveLine)
        self.dialect = spoken_as(sheet, Verbatim)
        super().__init__(sheet, baud, checked, address)
        self._refuse(checked, address)

    @property
    def word(self) -> CharacterFormat:
        return CharacterFormat(self.line.bits, self.line.parity, self.line.stop)

    @property
    def rates(self) -> tuple[int, ...]:
        """Rates that the part detects, the highest first."""
        return tuple(sorted(self.line.bauds, reverse=True))

    @property
    def usual_baud(self) -> int:
        """Default rate: the second-highest one, because the highest one needs a fast crystal."""
        return self.rates[min(1, len(self.rates) - 1)]

    @property
    def probe(self) -> str:
        """Query that is used to check whether a module answers: the first of the part's queries."""
        return next(iter(self.questions.values()))[0]

    @property
    def questions(self) -> Mapping[str, tuple[str, str]]:
        """Queries and the patterns of their answers, keyed by the name of the register that the query reads."""
        names = {register.letter: register.name for register in self.sheet.registers} | dict(self.dialect.asked)
        return {
            names.get(letter, letter): (
                f"{self.dialect.query} {letter}",
                f"{letter}=([0-9]{{{digits}}})",
            )
            for letter, digits in self.dialect.queries.items()
        }

    def framed(self, command: str) -> bytes:
        """Return a command with its carriage return, unless the command needs none."""
        if not command.isascii() or CR.decode() in command or not command:
            raise UsageError(f"command {command!r}; expected one line of ASCII, without a carriage return")
        return self.dialect.sent(self.sheet, command)

    def again(self, command: str) -> bytes:
        """Return a query preceded by a carriage return, which ends the earlier attempt if only part of it arrived."""
        return CR + self.framed(command)

    def row(self, command: str) -> Row | None:
        """Return the sheet's row for a command; None if the text is not a command, or is incomplete."""
        decoder = self.dialect.decoder(self.sheet)
        found: CommandText | None = None
        for byte in self.framed(command):
            found = decoder.feed(byte, bool(TEXT))
        return None if found is None else found.row

    def is_complete(self, command: str, received: bytes) -> bool:
        """Return whether all lines of an answer have arrived; True for a command that is not answered."""
        if not self.answers(command):
            return True
        return received.endswith(CR) and received.count(CR) >= 1 + self.listed_lines(command)

    def answer_timeout(self, command: str) -> float:
        looked = self.sheet.buffer_bytes * FETCH_S if self.listed_lines(command) else 0.0
        return super().answer_timeout(command) + looked

    def longest(self, command: str) -> int:
        """Return the maximum number of characters in an answer; a listing may comprise the whole memory."""
        return super().longest(command) + self.sheet.buffer_bytes * bool(self.listed_lines(command))

    def listed_lines(self, command: str) -> int:
        """Return the number of memory lines that a query requests, not counting the line with the memory pointer.

        If the command does not list memory, the result is 0.
        """
        found = re.fullmatch(rf"{re.escape(self.dialect.query)} ?{self.dialect.listing}[ ,]+([0-9]+)", command)
        return int(found[1]) if found else 0


Kind = Callable[[Sheet, int | None, bool | None, int | None], Speech]

KINDS: Mapping[type[Channel], Kind] = MappingProxyType(
    {SerialLine: LineSpeech, AdaptiveLine: QuerySpeech, BusHandshake: FramedSpeech}
)


def speech_of(sheet: Sheet, baud: int | None = None, checked: bool | None = None, address: int | None = None) -> Speech:
    """Return the protocol of a part on a serial port.

    Args:
        baud, checked, address: as for `Speech`.

    Raises:
        UsageError: the part has no serial line and cannot be read back over a bus; it does not have the
            given rate or address; or `checked` is True, but the part has no checksums.
    """
    serial = next((channel for channel in sheet.channels if isinstance(channel, (*KINDS,))), None)
    if serial is None:
        kinds = " and ".join(channel.description for channel in sheet.channels)
        raise UsageError(
            f"{sheet.part} has {kinds}, but no serial line; allowed: a part that has a serial line, or that can be "
            "read back over its bus"
        )
    return row_for(serial, KINDS, "uses")(sheet, baud, checked, address)
