"""RS-232: the serial connector of a computer, and a host that speaks to modules through one.

computer   txd --------> rxd   module          three wires; mark, the idle state, is the negative voltage,
           rxd <-------- txd                   which is level 0 here
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from ..core.bell import Bell
from ..core.hook import Hook
from ..core.inputs import from_outside
from ..core.kernel import Kernel, Task
from ..core.option import Option
from ..core.pin import Condition, GotCondition
from ..core.serial import (
    BAUD,
    RS232,
    TTL,
    Character,
    Ear,
    Receiver,
    Setting,
    Straps,
    Word,
    bit_clock,
    disagreement,
    transmit,
    word_options,
)
from ..core.waits import first_of, until
from ..errors import ChecksumError, Timeout, UsageError
from ..language.dialect import spoken_as
from ..language.lines import Lines, checksum, framed
from .computer import Computer
from .worker import Data, Worker, as_bytes

if TYPE_CHECKING:
    from ..core.channel import SerialLine
    from ..core.timebase import Time
    from .connection import Connection

FAULTS = ("parity", "framing", "late")
LATE_PS = 10**11  # how much later than it could a late character begins
BURST = 16  # characters whose edges are promised together
SILENCE_PS = 5 * 10**12  # no answer takes longer
POWER_UP_PS = 10**9  # a host gives a module a millisecond after power-up, whose RESET pulse it would not hear through


class SerialPort(Worker):
    """A serial connector: characters out on txd, characters in on rxd, at the speed of the line.

    `set_line` changes the line later.
    """

    wiring = MappingProxyType({"txd": "serial_in", "rxd": "serial_out"})
    optional = frozenset({"rxd"})  # of a receiver
    burst = BURST
    options = (
        BAUD,
        *word_options(7, "odd", 2),
        Option("ttl", "bool", False, "TTL levels (mark is 1) instead of RS-232 ones"),
    )

    def __init__(
        self, kernel: Kernel, name: str, *, baud: int | str, bits: int, parity: str, stop: int | str, ttl: bool
    ) -> None:
        super().__init__(kernel, name)
        self.mark = TTL if ttl else RS232
        self.receiver: Receiver | None = None
        self.ears: dict[str, Ear] = {}  # what listens at the other end, by its name, as far as that is known
        self.told: set[str] = set()  # in which ways its settings have been found to differ
        self.set_line(baud, Word(bits, parity, stop))
        space = 1 - self.mark
        self.add_pin("txd", "out", "serial data out", initial=self.mark, role="computer_out", active=space)
        self.add_pin("rxd", "in", "serial data in", pull=self.mark, role="computer_in", active=space)
        self.outgoing: deque[tuple[bytes, str]] = deque()  # bursts of characters, each with its fault
        self.sender: Task | None = None
        self.received = bytearray()  # the data bits of every character, good or not
        self.faulty = 0  # characters with a parity or framing fault
        self.on_character: Hook[[Character]] = Hook()  # one has come in

    def set_line(self, baud: int | str, word: Word) -> None:
        """Take another rate or format, from the next character on."""
        self.clock, self.word, self.baud = bit_clock(baud, self.name), word.checked(self.name), baud
        self.compared = False  # with what listens
        if self.receiver is not None:
            self.receiver.clock, self.receiver.word = self.clock, self.word

    @from_outside
    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Change rate and format from the next character on; a journal keeps it."""
        self.set_line(baud, Word(bits, parity, stop))
        self.input("change_line", baud, bits, parity, stop)

    @property
    def disagreement(self) -> str:
        """In which way the two ends of the line are set differently, and what to do; empty: they agree."""
        mine = Setting(self.baud, self.word)
        return "; ".join(filter(None, (disagreement(self.name, mine, name, ear) for name, ear in self.ears.items())))

    def compare(self) -> None:
        """Report a disagreement of the settings, each one once."""
        self.compared = True
        text = self.disagreement
        if text and text not in self.told:
            self.told.add(text)
            self.finding("format", text)

    @from_outside
    def opened_at(self, baud: int) -> None:
        """Report a rate that a program has set on a port where it changes nothing, if on a cable it would."""
        self.input("opened_at", baud)
        mine = Setting(baud, self.word)
        for name, ear in self.ears.items():
            text = disagreement("the program", mine, name, ear)
            if text and text not in self.told:
                self.told.add(text)
                self.finding("format", f"{text}; this port passes characters at any rate, a cable does not")

    def rewired(self) -> None:
        """Start to listen."""
        self.kernel.spawn(self._receive, name=f"{self.name} receives")

    # ------------------------------------------------------------------------------------------------------ sending
    @from_outside
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters; they go out one behind the other.

        Args:
            fault: "parity", "framing" or "late": every one of them goes out with this fault.
        """
        data = as_bytes(self.name, data)
        if fault and fault not in FAULTS:
            raise UsageError(f"{self.name}: fault {fault!r}; allowed {', '.join(FAULTS)}")
        self.input("write", data, fault)
        burst = 1 if fault == "late" else self.burst  # every one of them is late
        self.outgoing.extend((data[at : at + burst], fault) for at in range(0, len(data), burst))
        if self.outgoing and (self.sender is None or not self.sender.alive):
            self.sender = self.kernel.spawn(self._send, name=f"{self.name} sends")

    @from_outside
    def drop(self) -> None:
        """Forget what is to be sent, except what is on the line already."""
        self.input("drop")
        self.forget_characters()

    def forget_characters(self) -> None:
        """Forget what is to be sent behind what is on the line."""
        while len(self.outgoing) > 1:
            self.outgoing.pop()

    @from_outside
    def space(self, on: bool) -> None:
        """Begin or end a break: space on the line for longer than a character; nothing is to be sent meanwhile."""
        self.input("space", on)
        self.drivers["txd"].drive(1 - self.mark if on else self.mark)
        self.kernel.settle()

    async def before_sending(self) -> None:
        """Wait for what a computer waits for before it begins to send."""

    async def before_burst(self) -> None:
        """Wait for what a computer waits for before each burst of characters."""

    def after_burst(self, data: bytes) -> None:
        """Note that characters have gone out."""

    async def _send(self) -> None:
        driver = self.drivers["txd"]
        await self.before_sending()
        while self.outgoing:
            data, fault = self.outgoing[0]
            if fault == "late":
                await until(self.kernel, self.kernel.now + LATE_PS)
            await self.before_burst()
            if not self.compared:
                self.compare()
            await transmit(driver, self.clock, self.word, data, self.mark, fault)
            self.after_burst(data)
            self.outgoing.popleft()

    @property
    def backlog(self) -> int:
        """Characters that are still to be sent."""
        return sum(len(data) for data, _ in self.outgoing)

    @property
    def idle(self) -> bool:
        """Nothing is to be sent, and nothing else is queued."""
        return not self.outgoing and super().idle

    @property
    def waiting(self) -> str:
        """What the port waits for, in words."""
        if self.outgoing and super().idle:
            return f"{self.name}: {self.backlog} characters to send"
        return super().waiting

    # ---------------------------------------------------------------------------------------------------- receiving
    async def _receive(self) -> None:
        receiver = self.receiver = Receiver(self.pins["rxd"].net, self.clock, self.word, self.mark)
        while True:
            self.take(await receiver.character())

    def take(self, character: Character) -> None:
        """Receive a character."""
        self.received.append(character.byte)
        self.faulty += not character.good
        self.on_character(character)

    def got(self, data: Data) -> Condition:
        """Return a condition for `bench.run_until`: these bytes have been received, one behind the other."""
        mute = "" if self.pins["rxd"].net.drivers else " (whose rxd nobody drives: what listens there only receives)"
        return GotCondition(f"{self.name}{mute}", self.received, as_bytes(self.name, data))


class LineHost(SerialPort, Computer):
    """A host computer on a serial line."""

    for_users: ClassVar[tuple[str, ...]] = (
        "write",
        "change_line",
        "faulty",
        "baud",
        "word",
    )

    @from_outside
    def give_up(self) -> None:
        """Take back the last command, which was not answered in time."""
        self.input("give_up")
        self.forget_characters()

    def drop(self) -> None:
        """Forget what is queued; characters that are on the line already, and the command asked last, go on."""
        super().drop()
        self.take_back(1, "drop()")

    def lent(self) -> Callable[[], object]:
        """Return what restores rate and format, when somebody else has spoken over this line (`spoken`)."""
        baud, word = self.baud, self.word
        return lambda: self.set_line(baud, word)

    def rest(self) -> None:
        """Forget what is queued, and put the line to mark."""
        if self.sender is not None:
            self.sender.kill()
        self.outgoing.clear()
        self.drivers["txd"].drive(self.mark)


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
        self.ears = {chip.name: straps_of(chip) for chip in chips}
        self.fixed_baud: int | str | None = baud
        self.up_ps = max(chip.up_ps for chip in chips)  # since when all modules are switched on
        self.answers: list[str] = []
        self.line = bytearray()
        self.line_end = Bell(kernel, f"{name}.(line end)")

    def switched_on(self) -> None:
        """Note that a module has been switched on, at this instant: it looks at its straps."""
        self.up_ps, self.compared = self.kernel.now, False

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
            if not self.disagreement:
                raise
            raise Timeout(f"{error}\n  {self.disagreement}") from None

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
