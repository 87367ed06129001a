"""How a part is spoken to over a real port, as its data sheet has it: rate and format, frames, ends of answers, waits.

A speech is made from a sheet, one kind for each kind of serial line; it does no input and no output.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import ClassVar

from ..core.datasheet.channel import AdaptiveLine, Channel, SerialLine, row_for
from ..core.datasheet.table import Row, Sheet
from ..core.wires.serial import OVERSAMPLING, CharacterFormat, LineSetting
from ..errors import UsageError
from ..language.dialect import Command, spoken_as
from ..language.lines import KEPT, Lines, checksum, framed, parse
from ..language.verbatim import CommandText, Verbatim
from ..parts.hosts.ends.shadow import TEXT
from .failures import DamagedAnswer

CR = b"\r"
FAULTY = 0  # what a driver makes of a character with a parity or framing fault
ANSWER_S = 1.0  # of silence after which no answer comes any more; no sheet states a time
STORED_S = 15.0  # the same, of a command that writes an EEPROM
FETCH_S = 50e-6  # of a byte of memory, at most: a line that has no end is looked for up to the end of the memory


class Speech:
    """How a part is spoken to.

    Args:
        sheet: of the part.
        baud: the rate; None: `usual_baud`.
        checked: lines end in their checksums; None: they do not.
        address: that of the module on a line of several; None or 0: none is sent.

    Raises:
        UsageError: a rate, checksums or an address that the part does not have.
    """

    end = CR  # of a line
    wake = b""  # what is sent first
    answers_all: ClassVar[bool] = True  # is every command answered?

    def __init__(
        self, sheet: Sheet, baud: int | None = None, checked: bool | None = None, address: int | None = None
    ) -> None:
        self.sheet, self.checked, self.address = sheet, bool(checked), address or 0
        rates = self.rates
        self.baud = baud or self.usual_baud
        if self.baud not in rates:
            allowed = ", ".join(map(str, rates))
            raise UsageError(f"--baud {baud}: no rate of the {sheet.part.upper()}; allowed {allowed}")
        self.setting = LineSetting(self.baud, self.word)
        self.character_s = self.word.ticks / OVERSAMPLING / self.baud

    # ----------------------------------------------------------------------------------------------- what a kind brings
    @property
    def word(self) -> CharacterFormat:
        """The format of its characters."""
        raise NotImplementedError

    @property
    def rates(self) -> tuple[int, ...]:
        """The rates that it may have, the highest first."""
        raise NotImplementedError

    @property
    def usual_baud(self) -> int:
        """The rate at which it is spoken to, unless another is asked for."""
        return self.rates[0]

    @property
    def probe(self) -> str:
        """A question that may be asked at any time, and changes nothing."""
        raise NotImplementedError

    @property
    def questions(self) -> Mapping[str, tuple[str, str]]:
        """The commands that ask for a value, each with the pattern of its answer, by what they ask for."""
        raise NotImplementedError

    def framed(self, command: str) -> bytes:
        """Return a command as it goes over the wire.

        Raises:
            UsageError: no command, or more than one.
        """
        raise NotImplementedError

    def again(self, command: str) -> bytes:
        """Return a question as it is sent once more, after one that was not answered."""
        return self.framed(command)

    def row(self, command: str) -> Row | None:
        """Return the row of a command; None: it is none."""
        raise NotImplementedError

    def is_complete(self, command: str, received: bytes) -> bool:
        """Return whether these characters are a whole answer to a command."""
        raise NotImplementedError

    def stripped(self, line: bytes) -> str:
        """Return a line of an answer without its checksum, where there is one.

        Args:
            line: without its carriage return.

        Raises:
            DamagedAnswer: a character came with a fault, or the checksum does not fit.
        """
        if FAULTY in line:
            raise DamagedAnswer(f"{line!r}: a character came with a parity or framing fault")
        return line.decode("latin-1")

    def refusal(self, line: str) -> str:
        """Return what the sheet says of an answer, where it is a refusal; empty: it is none."""
        return ""

    def is_garbled(self, line: str) -> bool:
        """Return whether an answer says that the command came damaged, and that nothing was done."""
        return False

    # ----------------------------------------------------------------------------------------------------- of all kinds
    def answers(self, command: str) -> bool:
        """Return whether a command is answered."""
        row = self.row(command)
        return self.answers_all or (row is not None and row.role == "question")

    def is_question(self, command: str) -> bool:
        """Return whether a command changes nothing, so that it may be asked again."""
        row = self.row(command)
        return row is not None and row.role in ("question", "list")

    def moves(self, command: str) -> bool:
        """Return whether a command may make the motor step, if it comes outside program entry; one unknown may."""
        row = self.row(command)
        return row is None or row.may_step

    def patience(self, command: str) -> float:
        """Return the silence, in seconds, after which an answer to a command does not come any more."""
        row = self.row(command)
        silence = STORED_S if row is not None and row.role == "store" else ANSWER_S
        return silence + (len(command) + 4) * self.character_s

    def lines(self, received: bytes) -> list[str]:
        """Return the lines of an answer, without checksums.

        Raises:
            DamagedAnswer: one of them came damaged.
        """
        return [self.stripped(line) for line in received.removesuffix(CR).split(CR)]


class LineSpeech(Speech):
    """A part that answers every line with lines.

    `kept` are the bits that its checksums always have; some old modules have none.
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
            raise UsageError(f"--address {address}: allowed {', '.join(map(str, allowed))} (0: none is sent)")
        if checked and not self.line.checksum_pin:
            raise UsageError(f"--checksum: lines for the {sheet.part.upper()} have none; leave it out")

    @property
    def word(self) -> CharacterFormat:
        """The format of its characters."""
        return CharacterFormat(self.line.bits, self.line.parity, self.line.stop)

    @property
    def rates(self) -> tuple[int, ...]:
        """The rates for which it may be strapped, the highest first."""
        return tuple(sorted(self.line.bauds.values(), reverse=True))

    @property
    def probe(self) -> str:
        """The last of its questions."""
        if not self.questions:
            raise UsageError(f"{self.sheet.part}: its sheet names no question; give its dialect some `questions`")
        return [*self.questions.values()][-1][0]

    @property
    def questions(self) -> Mapping[str, tuple[str, str]]:
        """The commands that ask for a value, each with the pattern of its answer, by what they ask for."""
        return self.dialect.questions

    def framed(self, command: str) -> bytes:
        """Return a line with address, checksum and carriage return, where they belong."""
        if not command.isascii() or CR.decode() in command or not command:
            raise UsageError(f"command {command!r}; allowed one line of ASCII, without its carriage return")
        return framed(f"{self.address or ''}{command}", self.checked, self.kept)

    def row(self, command: str) -> Row | None:
        """Return the row of a command; None: it is none."""
        found = parse(self.sheet, command)
        return found.row if isinstance(found, Command) else None

    def is_complete(self, command: str, received: bytes) -> bool:
        """Return whether the last line has come: of a listing that is one that no program has."""
        if not received.endswith(CR):
            return False
        row = self.row(command)
        if row is None or row.role != "list":
            return True
        last = received[:-1].rpartition(CR)[2]
        return (last[:-1] if self.checked else last).decode("latin-1") in self.dialect.answers

    def stripped(self, line: bytes) -> str:
        """Return a line without its checksum."""
        text = super().stripped(line)
        if not self.checked:
            return text
        if len(line) < 2 or line[-1] != checksum(line[:-1], self.kept):
            raise DamagedAnswer(f"{line!r}: its last character is not its checksum")
        return text[:-1]

    def refusal(self, line: str) -> str:
        """Return what the sheet says of an answer, where it is a refusal."""
        return self.dialect.answers[line] if line in (*self.dialect.refusals, self.dialect.busy) else ""

    def is_garbled(self, line: str) -> bool:
        """Return whether an answer says that the command came damaged, and that nothing was done."""
        return line == self.dialect.garbled


class QuerySpeech(Speech):
    """A part that answers nothing but queries, and finds its rate by two carriage returns."""

    wake = CR + CR
    answers_all = False

    def __init__(
        self, sheet: Sheet, baud: int | None = None, checked: bool | None = None, address: int | None = None
    ) -> None:
        self.line = sheet.through(AdaptiveLine)
        self.dialect = spoken_as(sheet, Verbatim)
        super().__init__(sheet, baud, checked, address)
        for name, value in (("--checksum", checked), ("--address", address)):
            if value:
                raise UsageError(f"{name}: lines for the {sheet.part.upper()} have none; leave it out")

    @property
    def word(self) -> CharacterFormat:
        """The format of its characters."""
        return CharacterFormat(self.line.bits, self.line.parity, self.line.stop)

    @property
    def rates(self) -> tuple[int, ...]:
        """The rates that it finds, the highest first."""
        return tuple(sorted(self.line.bauds, reverse=True))

    @property
    def usual_baud(self) -> int:
        """The second highest: the highest one needs a fast crystal."""
        return self.rates[min(1, len(self.rates) - 1)]

    @property
    def probe(self) -> str:
        """The first of its questions."""
        return next(iter(self.questions.values()))[0]

    @property
    def questions(self) -> Mapping[str, tuple[str, str]]:
        """The queries, by the registers for which they ask."""
        names = {register.letter: register.name for register in self.sheet.registers} | dict(self.dialect.asked)
        return {
            names.get(letter, letter): (
                f"{self.dialect.query} {letter}",
                f"{letter}=([0-9]{{{digits}}})",
            )
            for letter, digits in self.dialect.queries.items()
        }

    def framed(self, command: str) -> bytes:
        """Return a command with its carriage return, unless it has none."""
        if not command.isascii() or CR.decode() in command or not command:
            raise UsageError(f"command {command!r}; allowed one line of ASCII, without its carriage return")
        return self.dialect.sent(self.sheet, command)

    def again(self, command: str) -> bytes:
        """Return a question after the end of the line that was not answered: it may have come in part."""
        return CR + self.framed(command)

    def row(self, command: str) -> Row | None:
        """Return the row of a command; None: it is none, or none whole."""
        decoder = self.dialect.decoder(self.sheet)
        found: CommandText | None = None
        for byte in self.framed(command):
            found = decoder.feed(byte, bool(TEXT))
        return None if found is None else found.row

    def is_complete(self, command: str, received: bytes) -> bool:
        """Return whether a query has all the lines of its answer."""
        if not self.answers(command):
            return True
        return received.endswith(CR) and received.count(CR) >= 1 + self.listed_lines(command)

    def patience(self, command: str) -> float:
        """Return the silence, in seconds, after which an answer does not come any more."""
        looked = self.sheet.buffer_bytes * FETCH_S if self.listed_lines(command) else 0.0
        return super().patience(command) + looked

    def listed_lines(self, command: str) -> int:
        """Return how many lines of memory a query asks for, besides the pointer."""
        found = re.fullmatch(rf"{re.escape(self.dialect.query)} ?{self.dialect.listing}[ ,]+([0-9]+)", command)
        return int(found[1]) if found else 0


Kind = Callable[[Sheet, int | None, bool | None, int | None], Speech]
KINDS: Mapping[type[Channel], Kind] = MappingProxyType({SerialLine: LineSpeech, AdaptiveLine: QuerySpeech})


def speech_of(sheet: Sheet, baud: int | None = None, checked: bool | None = None, address: int | None = None) -> Speech:
    """Return how a part is spoken to over a serial port.

    Args:
        baud, checked, address: as for `Speech`.

    Raises:
        UsageError: the part has no serial line, or not that rate, checksum or address.
    """
    serial = next((channel for channel in sheet.channels if isinstance(channel, (*KINDS,))), None)
    if serial is None:
        says = " and ".join(channel.says for channel in sheet.channels)
        raise UsageError(
            f"{sheet.part}: has {says}, and no serial line; allowed a part with a serial line: one on a bus needs an "
            "adapter of its own, and lists no program"
        )
    return row_for(serial, KINDS, "speaks over")(sheet, baud, checked, address)
