"""A host computer that speaks in lines to the modules on a serial line, as they are strapped."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, ClassVar

from ...core.time.kernel import Kernel
from ...core.wires.bell import Bell
from ...core.wires.serial import Character, Straps, Word
from ...core.wires.waits import first_of, until
from ...errors import ChecksumError, Timeout, UsageError
from ...language.dialect import spoken_as
from ...language.lines import Lines, checksum, framed
from ..lines.rs232 import POWER_UP_PS, SILENCE_PS
from .line_host import LineHost

if TYPE_CHECKING:
    from ...core.datasheet.channel import SerialLine
    from ...core.time.timebase import Time
    from .connection import Connection


class SerialHost(LineHost):
    """A host computer on the serial line of one module, or of several that share it.

    It follows the straps of the module: rate, checksum, address.  `ask` sends a command and returns the answer.

    Args:
        baud: another rate than the module's.
    """

    for_users: ClassVar[tuple[str, ...]] = (
        "answers",
        "straps",
        "space",
    )

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[Connection], *, baud: int | None = None) -> None:
        port = straps_of(chips[0]).port
        bits, parity, stop = port.bits, port.parity, port.stop
        super().__init__(
            kernel,
            name,
            baud=straps_of(chips[0]).baud if baud is None else baud,
            bits=bits,
            parity=parity,
            stop=stop,
            ttl=False,
        )
        self.join(chips)
        self.port = port
        self.far.ears = {chip.name: straps_of(chip) for chip in chips}
        self.fixed_baud: int | str | None = baud
        self.up_ps = max(chip.up_ps for chip in chips)  # since when all modules are switched on
        self.answers: list[str] = []
        self.line = bytearray()
        self.line_end = Bell(kernel, f"{name}.(line end)")

    def switched_on(self) -> None:
        """Note that a module has been switched on, at this instant: it looks at its straps."""
        self.up_ps, self.far.compared = self.kernel.now, False

    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Take another rate or format, whatever the module is strapped for."""
        super().change_line(baud, bits, parity, stop)
        self.fixed_baud = baud

    async def before_sending(self) -> None:
        """Wait until the modules can listen."""
        await until(self.kernel, self.up_ps + POWER_UP_PS)

    # --------------------------------------------------------------------------------------------- what straps say
    @property
    def straps(self) -> Straps:
        """The straps of the module that it speaks to."""
        return straps_of(self.chip)

    def follow_straps(self) -> SerialLine:
        """Take the rate that the module is strapped for, and has looked at."""
        baud = self.fixed_baud or self.straps.setting.baud
        if baud != self.baud:
            self.set_line(baud, self.word)
        return self.port

    # ------------------------------------------------------------------------------------------------------ sending
    def send(self, data: str | bytes) -> None:
        """Queue characters as they are, without address and checksum; they go out one behind the other.

        Raises:
            UsageError: text that is not ASCII, or neither text nor bytes.
        """
        self.write(data)

    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters, at the rate that the module is strapped for; they go out one behind the other."""
        self.follow_straps()
        super().write(data, fault)

    def framed(self, command: str) -> bytes:
        """Return a command as it goes over the wire: address, checksum and carriage return added."""
        if not isinstance(command, str) or not command.isascii():
            raise UsageError(f"{self.name}: command {command!r}; expected text such as 'V1'")
        if "\r" in command:
            raise UsageError(f"{self.name}: command {command!r}; one at a time, the carriage return is added")
        straps = self.straps
        return framed(f"{straps.address or ''}{command}", straps.checked, straps.kept)

    def ask(self, command: str, timeout: Time = "5 s") -> str:
        r"""Send a command, wait for the answer, and return it without checksum and carriage return.

        A program that is listed comes as its lines, "\r" between them.

        Raises:
            ChecksumError: the answer has a wrong checksum, or a character of it came with a fault.
            Timeout: no answer; the message says who waits for what.
        """
        self.answers.clear()
        self.line.clear()
        before = self.faulty
        self.send(self.framed(command))
        self._let_pass(lambda: self._answered(command), f"an answer to {command!r}", timeout)
        if self.faulty != before:
            raise ChecksumError(f"{self.name}: parity or framing fault in the answer to {command!r}: {self.answers!r}")
        return "\r".join(self.stripped(line) for line in self.answers)

    def spoken(self, command: str) -> bytes:
        """Return a command as it goes over the wire, and speak as the module is strapped from now on."""
        self.fixed_baud = None
        self.set_line(self.baud, Word(self.port.bits, self.port.parity, self.port.stop))
        self.follow_straps()
        return self.framed(command)

    def lent(self) -> Callable[[], object]:
        """Return what restores rate and format, and who has chosen the rate."""
        restore, fixed = super().lent(), self.fixed_baud

        def restored() -> None:
            self.fixed_baud = fixed
            restore()

        return restored

    def ends(self, command: str, data: bytes) -> bool:
        """Return whether these characters may end the answer to a command."""
        return data.endswith(b"\r")

    def answer_in(self, command: str, data: bytes) -> str:
        """Return the answer to a command, of these characters.

        Raises:
            ChecksumError: a checksum does not fit.
        """
        return "\r".join(self.stripped(line) for line in data.decode("latin-1").split("\r")[:-1])

    async def exchange(self, command: str | bytes) -> list[str]:
        """Send a command in a task; return its answers: none, if the line is silent for longer than any answer takes.

        Args:
            command: text is framed; bytes go out as they are.
        """
        self.answers.clear()
        self.line.clear()
        with self.kernel.outside.nested():  # in the script that asks
            self.send(command if isinstance(command, bytes) else self.framed(command))
        while not self._answered(command if isinstance(command, str) else ""):
            limit = self.kernel.now + self.backlog * self.clock.ps(self.word.ticks) + SILENCE_PS
            if await first_of(self.kernel, limit, (self.line_end.net, None)) is None:
                break
        return [self.stripped(line) for line in self.answers]

    def _answered(self, command: str) -> bool:
        if not self.answers:
            return False
        sheet = self.chip.sheet
        row = sheet.commands.by_form.get(command)
        if row is None or row.role != "list":
            return True
        last = self.answers[-1][:-1] if self.straps.checked else self.answers[-1]
        return last in spoken_as(sheet, Lines).answers  # a line of the program is no answer

    def _let_pass(self, met: Callable[[], bool], what: str, timeout: Time) -> None:
        try:
            self.kernel.outside.wait(met, f"{self.name}: {what}", timeout)
        except Timeout as error:
            self.give_up()
            if not (why := self.far.disagreement):
                raise
            raise Timeout(f"{error}\n  {why}") from None

    def rest(self) -> None:
        """Forget what is queued and what has come in part, and put the line to mark."""
        super().rest()
        self.line.clear()
        self.answers.clear()

    def stripped(self, line: str) -> str:
        """Return an answer without its checksum."""
        straps = self.straps
        if not straps.checked or not line:
            return line
        text, found = line[:-1], ord(line[-1])
        expected = checksum(text.encode("latin-1"), straps.kept)
        if found != expected:
            raise ChecksumError(f"{self.name}: {line!r} ends in {found:#04x}; its checksum is {expected:#04x}")
        return text

    def take(self, character: Character) -> None:
        """Receive a character; a carriage return ends an answer."""
        super().take(character)
        if character.byte == 0x0D:
            self.answers.append(self.line.decode("latin-1"))
            self.line.clear()
            self.line_end.ring()
        else:
            self.line.append(character.byte)


def straps_of(chip: Connection) -> Straps:
    """Return the straps of a module; the bench hands a host on a line only modules."""
    assert chip.straps is not None
    return chip.straps
