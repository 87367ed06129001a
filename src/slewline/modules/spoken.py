"""The base class of all protocols of parts on a real port.

Each kind of line has a protocol class of its own.  A protocol object is made from a part's sheet; it
performs no input or output.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from ..core.datasheet.table import Row, Sheet
from ..core.wires.serial import OVERSAMPLING, CharacterFormat, LineSetting
from ..errors import UsageError
from .failures import DamagedAnswer

CR = b"\r"
FAULTY = 0  # replacement for a character with a parity or framing fault
ANSWER_S = 1.0  # silence after which no answer is expected; no sheet states a time
STORED_S = 15.0  # the same for a command that writes an EEPROM
LONGEST = 80  # maximum length of an answer that is not a listing, in characters
SLACK_S = 5.0  # time for an exchange, in addition to twice the time of its characters


class Speech:
    """The protocol of a part: the base class, from which each kind of protocol is derived.

    Args:
        sheet: the sheet of the part.
        baud: the rate; None: `usual_baud`.
        checked: whether every line ends with its checksum; None: no.
        address: the address of the module on a shared line; None or 0: no address is sent.

    Raises:
        UsageError: the part does not have this rate or address; or `checked` is True, but the part has no
            checksums.
    """

    ends = CR  # each of these characters ends a line
    wake = b""  # sent before the first command
    answers_all: ClassVar[bool] = True  # every command is answered
    is_timed: ClassVar[bool] = True  # the delay of an answer is that of the part
    shows_entry: ClassVar[bool] = True  # open program entry can be detected before a move is entered

    def __init__(
        self, sheet: Sheet, baud: int | None = None, checked: bool | None = None, address: int | None = None
    ) -> None:
        self.sheet, self.checked, self.address = sheet, bool(checked), address or 0
        rates = self.rates
        self.baud = baud or self.usual_baud
        if self.baud not in rates:
            allowed = ", ".join(map(str, rates))
            raise UsageError(f"--baud {baud}: not a rate of the {sheet.part.upper()}; allowed {allowed}")
        self.setting = LineSetting(self.baud, self.word)
        self.character_s = self.word.ticks / OVERSAMPLING / self.baud

    # ------------------------------------------------------------------------------------------------ kinds of protocol
    @property
    def word(self) -> CharacterFormat:
        """Format of the characters on the line."""
        raise NotImplementedError

    @property
    def rates(self) -> tuple[int, ...]:
        """Possible rates, the highest first."""
        raise NotImplementedError

    @property
    def usual_baud(self) -> int:
        """Default rate."""
        return self.rates[0]

    @property
    def probe(self) -> str:
        """Query that is used to check whether a module answers; it may be sent at any time and changes nothing."""
        raise NotImplementedError

    @property
    def questions(self) -> Mapping[str, tuple[str, str]]:
        """Commands that query a value, each with the pattern of its answer, keyed by the name of the value."""
        raise NotImplementedError

    def framed(self, command: str) -> bytes:
        """Return a command in the form sent over the wire.

        Raises:
            UsageError: the text has no command, or more than one.
        """
        raise NotImplementedError

    def again(self, command: str) -> bytes:
        """Return a query in the form in which it is sent again after it was not answered."""
        return self.framed(command)

    def row(self, command: str) -> Row | None:
        """Return the sheet's row for a command; None if the text is not a command."""
        raise NotImplementedError

    def is_complete(self, command: str, received: bytes) -> bool:
        """Return whether these characters are a complete answer to a command."""
        raise NotImplementedError

    def stripped(self, line: bytes) -> str:
        """Return a line of an answer without its checksum, if there is one.

        Args:
            line: the line without its carriage return.

        Raises:
            DamagedAnswer: a character arrived with a fault, or the checksum does not match.
        """
        if FAULTY in line:
            raise DamagedAnswer(f"{line!r}: a character arrived with a parity or framing error")
        return line.decode("latin-1")

    def refusal(self, line: str) -> str:
        """Return the sheet's text for an answer, if it is a refusal; empty if not."""
        return ""

    @property
    def busy(self) -> str | None:
        """Answer of a module that is executing a program or a motion; None if the part has no such answer."""
        return getattr(self.sheet.dialect, "busy", None)

    def value(self, what: str, reply: str) -> str:
        """Return a queried value as text; `reply` is the part of the answer that the query's pattern captures."""
        return reply

    def is_garbled(self, line: str) -> bool:
        """Return whether an answer states that the command arrived damaged and had no effect."""
        return False

    # -----------------------------------------------------------------------------------------------common to all kinds
    def _refuse(self, checked: bool | None, address: int | None) -> None:
        """Raise a UsageError if a checksum or an address is given, because lines for the part have neither."""
        for name, value in (("--checksum", checked), ("--address", address)):
            if value:
                raise UsageError(f"{name}: not supported by the {self.sheet.part.upper()}; leave out {name}")

    @property
    def shows_faults(self) -> bool:
        """True if characters have a parity bit, which reveals damage."""
        return self.word.parity != "none"

    def answers(self, command: str) -> bool:
        """Return whether the part answers a command."""
        row = self.row(command)
        return self.answers_all or (row is not None and row.role == "question")

    def is_question(self, command: str) -> bool:
        """Return whether a command changes nothing, so that it may be repeated."""
        row = self.row(command)
        return row is not None and row.role in ("question", "list")

    def moves(self, command: str) -> bool:
        """Return whether a command may step the motor outside program entry; True for an unknown command."""
        row = self.row(command)
        return row is None or row.may_step

    def answer_timeout(self, command: str) -> float:
        """Return the length of silence, in seconds, after which an answer to a command is no longer expected."""
        row = self.row(command)
        silence = STORED_S if row is not None and row.role == "store" else ANSWER_S
        return silence + (len(command) + 4) * self.character_s

    def longest(self, command: str) -> int:
        """Return the maximum number of characters in the answer to a command."""
        return LONGEST

    def seconds(self, characters: int, silence: float) -> float:
        """Return the time limit (s) for an exchange: the exchange then ends, even if characters still arrive.

        Args:
            characters: the maximum number of characters in both directions together.
            silence: the silence before the first character, in seconds.
        """
        return 2 * characters * self.character_s + max(SLACK_S, silence)

    def lines(self, received: bytes) -> list[str]:
        """Return the lines of an answer, without checksums.

        Raises:
            DamagedAnswer: a line is damaged.
        """
        return [self.stripped(line) for line in received.removesuffix(CR).split(CR)]
