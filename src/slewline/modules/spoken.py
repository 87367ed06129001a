"""How a part is spoken to over a real port: what all kinds of it have in common.

A speech is made from a sheet, one kind for each kind of line; it does no input and no output.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from ..core.datasheet.table import Row, Sheet
from ..core.wires.serial import OVERSAMPLING, CharacterFormat, LineSetting
from ..errors import UsageError
from .failures import DamagedAnswer

CR = b"\r"
FAULTY = 0  # what a driver makes of a character with a parity or framing fault
ANSWER_S = 1.0  # of silence after which no answer comes any more; no sheet states a time
STORED_S = 15.0  # the same, of a command that writes an EEPROM
LONGEST = 80  # characters of an answer that is no listing
SLACK_S = 5.0  # for an exchange, besides twice the time that its characters take


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

    ends = CR  # each of these characters ends a line
    wake = b""  # what is sent first
    answers_all: ClassVar[bool] = True  # is every command answered?
    is_timed: ClassVar[bool] = True  # is it the part that takes the time of an answer?
    shows_entry: ClassVar[bool] = True  # can it be seen that program entry is open, before a move is entered?

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

    @property
    def busy(self) -> str | None:
        """The answer that a program or a motion is under way; None: there is none."""
        return getattr(self.sheet.dialect, "busy", None)

    def value(self, what: str, said: str) -> str:
        """Return a value as it is written, of what the pattern of its question has found in an answer."""
        return said

    def is_garbled(self, line: str) -> bool:
        """Return whether an answer says that the command came damaged, and that nothing was done."""
        return False

    # ----------------------------------------------------------------------------------------------------- of all kinds
    def _refuse(self, checked: bool | None, address: int | None) -> None:
        """Refuse checksums and addresses, of a part that has none."""
        for name, value in (("--checksum", checked), ("--address", address)):
            if value:
                raise UsageError(f"{name}: lines for the {self.sheet.part.upper()} have none; leave it out")

    @property
    def shows_faults(self) -> bool:
        """Does a character show that it has come damaged, by its parity?"""
        return self.word.parity != "none"

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

    def longest(self, command: str) -> int:
        """Return how many characters the answer to a command may have."""
        return LONGEST

    def seconds(self, characters: int, silence: float) -> float:
        """Return the time, in seconds, within which an exchange is over, however much comes.

        Args:
            characters: how many go to and fro, at most.
            silence: in seconds, before the first one comes.
        """
        return 2 * characters * self.character_s + max(SLACK_S, silence)

    def lines(self, received: bytes) -> list[str]:
        """Return the lines of an answer, without checksums.

        Raises:
            DamagedAnswer: one of them came damaged.
        """
        return [self.stripped(line) for line in received.removesuffix(CR).split(CR)]
