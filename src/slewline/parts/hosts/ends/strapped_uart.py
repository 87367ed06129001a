"""The UART of a host that sends commands to modules on a serial line, in the form set by their straps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from ....core.wires.receiver import Character
from ....core.wires.serial import RS232, CharacterFormat, LineSetting, Straps
from ....core.wires.waiters import Event
from ....core.wires.waits import first_of
from ....errors import ChecksumError, UsageError
from ....language.dialect import spoken_as
from ....language.lines import Lines, checksum, framed
from ...lines.host_uart import POWER_UP_PS, SILENCE_PS, HostUart

if TYPE_CHECKING:
    from ..connection import Connection
    from ..host import Host


class StrappedUart(HostUart):
    """A host's UART that follows the straps of the selected module: rate, checksum, address.

    `answers` contains the lines received since the last call of `begin`.

    Args:
        host: the host, whose `chip` is the selected module.
        chips: the connections to all modules on the line.
        baud: a fixed rate, used regardless of the straps; None: the module's rate.

    Attributes:
        straps: the straps of the selected module.
    """

    def __init__(self, host: Host, chips: Sequence[Connection], baud: int | None) -> None:
        self.straps = straps_of(chips[0])
        self.port = self.straps.port
        super().__init__(host, LineSetting(self.straps.baud if baud is None else baud, self.usual_word), RS232)
        self.far.receivers = {chip.name: straps_of(chip) for chip in chips}
        self.host = host
        self.fixed_baud: int | str | None = baud
        self.up_ps = max(chip.up_ps for chip in chips)  # when the last module was switched on
        self.answers: list[str] = []
        self.recent_answers = host.keep_recent(self.answers)
        self.line = bytearray()
        self.line_end = Event(self.kernel, f"{self.name}.(line end)")

    def switched_on(self) -> None:
        """Record that a module is switched on at this instant, and therefore reads its straps now."""
        self.up_ps, self.far.compared = self.kernel.now, False

    def may_send_ps(self) -> int:
        """Return the instant (ps) from which the modules can receive."""
        return self.up_ps + POWER_UP_PS

    # ------------------------------------------------------------------------------------------------ rate and format
    @property
    def usual_word(self) -> CharacterFormat:
        """Character format of the modules on the line."""
        return CharacterFormat(self.port.bits, self.port.parity, self.port.stop)

    def follow_straps(self) -> None:
        """Use the rate that the selected module has read from its straps, unless the host has a fixed rate."""
        baud = self.fixed_baud or self.straps.rate
        if baud != self.baud:
            self.set_line(baud, self.word)

    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Use another rate or format, regardless of the straps; this call is recorded as an input of the part."""
        super().change_line(baud, bits, parity, stop)
        self.fixed_baud = baud

    def lent(self) -> Callable[[], object]:
        """Return a function that restores the present settings: the rate, whether it is fixed, and the format."""
        restore, fixed = super().lent(), self.fixed_baud

        def restored() -> None:
            self.fixed_baud = fixed
            restore()

        return restored

    # --------------------------------------------------------------------------------------------- commands and answers
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters to be sent at the fixed rate, or else at the module's rate.

        This call is recorded as an input of the part.
        """
        self.follow_straps()
        super().write(data, fault)

    def begin(self) -> None:
        """Drop earlier answers, and start to collect new ones."""
        self.catch_up()
        self.recent_answers.clear()
        self.line.clear()

    def rest(self) -> None:
        """Drop the queued characters and all answers, complete or not, and set the line to mark."""
        super().rest()
        self.begin()

    def framed(self, command: str) -> bytes:
        """Return a command as bytes with carriage return, and with address and checksum if the straps select them.

        Raises:
            UsageError: the text is not ASCII, or contains more than one command.
        """
        if not isinstance(command, str) or not command.isascii():
            raise UsageError(f"{self.name}: command {command!r}; expected text such as 'V1'")
        if "\r" in command:
            raise UsageError(f"{self.name}: command {command!r}; expected one command without a carriage return")
        straps = self.straps
        return framed(f"{straps.address or ''}{command}", straps.checked, straps.kept)

    def stripped(self, line: str) -> str:
        """Return a line of an answer without its checksum; unchanged if the straps select no checksum.

        Raises:
            ChecksumError: the checksum is wrong.
        """
        straps = self.straps
        if not straps.checked or not line:
            return line
        text, found = line[:-1], ord(line[-1])
        expected = checksum(text.encode("latin-1"), straps.kept)
        if found != expected:
            raise ChecksumError(f"{self.name}: {line!r} ends in checksum {found:#04x}; expected {expected:#04x}")
        return text

    def answered(self, command: str) -> Callable[[], bool]:
        """Return a function that returns whether the answer to a command is complete.

        The answer to a listing command has several lines.
        """
        sheet, answers = self.host.chip.sheet, self.answers
        row = sheet.commands.by_form.get(command)
        if row is None or row.role != "list":
            return partial(bool, answers)
        last_lines, cut = spoken_as(sheet, Lines).answers, -1 if self.straps.checked else None
        return lambda: bool(answers) and answers[-1][:cut] in last_lines  # a program line is not an answer

    async def exchange(self, command: str | bytes) -> list[str]:
        """Send a command from a task, and return the lines of its answer.

        If the line is silent for too long, return only the lines received until then.

        Args:
            command: text, to be framed (`framed`), or bytes, which are sent unchanged.
        """
        self.begin()
        with self.kernel.outside.nested():  # in the calling script
            self.write(command if isinstance(command, bytes) else self.framed(command))
        answered = self.answered(command if isinstance(command, str) else "")
        while not answered():
            limit = self.kernel.now + self.backlog * self.clock.ps(self.word.ticks) + SILENCE_PS
            if await first_of(self.kernel, limit, (self.line_end.net, None)) is None:
                break
        return [self.stripped(line) for line in self.answers]

    def acts(self, data: bytes, at: int) -> int:
        return data.find(b"\r", at)

    def passed(self, data: bytes) -> None:
        super().passed(data)
        self.line += data

    def take(self, character: Character) -> None:
        """Receive a character; a carriage return ends an answer."""
        super().take(character)
        if character.byte == 0x0D:
            self.answers.append(self.line.decode("latin-1"))
            self.line.clear()
            if self.line_end.net.waiters:  # a task of a script; a call checks the answers
                self.line_end.set()
        else:
            self.line.append(character.byte)

    # ----------------------------------------------------------------------------------------- for tests
    def spoken(self, command: str) -> bytes:
        """Follow the straps of the module from now on, and return the bytes to send for a command."""
        self.fixed_baud = None
        self.set_line(self.baud, self.usual_word)
        self.follow_straps()
        return self.framed(command)

    def ends(self, command: str, data: bytes) -> bool:
        """Return whether the characters in `data` may be the complete answer to a command."""
        return data.endswith(b"\r")

    def answer_in(self, command: str, data: bytes) -> str:
        """Return the answer to a command, given the characters received, with the checksum removed from each line.

        Raises:
            ChecksumError: a checksum is wrong.
        """
        return "\r".join(self.stripped(line) for line in data.decode("latin-1").split("\r")[:-1])


def straps_of(chip: Connection) -> Straps:
    """Return the straps of a module.

    Raises:
        UsageError: the chip has no straps, so it is not a module for a serial line.
    """
    if chip.straps is None:
        raise UsageError(f"{chip.name} has no straps; a host on a serial line needs a chip with a SerialLine")
    return chip.straps
