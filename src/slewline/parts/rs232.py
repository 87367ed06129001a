"""RS-232: the serial connector of a computer, and a host that speaks to modules through one.

computer   txd --------> rxd   module          three wires; mark, the idle state, is the negative voltage,
           rxd <-------- txd                   which is level 0 here
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from types import MappingProxyType
from typing import Any

from ..core.channel import Channel, SerialLine
from ..core.hook import Hook
from ..core.kernel import Kernel, Task
from ..core.net import Driver, Net
from ..core.option import Option
from ..core.pin import Condition, GotCondition, strapped
from ..core.serial import BAUD, RS232, TTL, Character, LinePartner, Receiver, Word, bit_clock, transmit, word_options
from ..core.timebase import Time
from ..core.waits import first_of, until
from ..errors import ChecksumError, Timeout, UsageError
from ..language.lines import checksum, framed
from .part import served
from .worker import Worker, as_bytes

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
        if self.receiver is not None:
            self.receiver.clock, self.receiver.word = self.clock, self.word

    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """The same, for who stands outside."""
        self.set_line(baud, Word(bits, parity, stop))
        self.input("change_line", baud, bits, parity, stop)

    def rewired(self) -> None:
        self.kernel.spawn(self._receive(), f"{self.name} receives")

    # ------------------------------------------------------------------------------------------------------ sending
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters; they go out one behind the other.

        Args:
            fault: "parity", "framing" or "late": every one of them goes out with this fault.
        """
        data = as_bytes(self.name, data)
        if fault and fault not in FAULTS:
            raise UsageError(f"{self.name}: fault {fault!r}; allowed {', '.join(FAULTS)}")
        self.input("write", data, fault)
        burst = 1 if fault == "late" else BURST  # every one of them is late
        self.outgoing.extend((data[at : at + burst], fault) for at in range(0, len(data), burst))
        if self.outgoing and (self.sender is None or not self.sender.alive):
            self.sender = self.kernel.spawn(self._send(), f"{self.name} sends")

    def drop(self) -> None:
        """Forget what is to be sent, except what is on the line already."""
        self.input("drop")
        while len(self.outgoing) > 1:
            self.outgoing.pop()

    def space(self, on: bool) -> None:
        """Begin or end a break: space on the line for longer than a character; nothing is to be sent meanwhile."""
        self.input("space", on)
        self.drivers["txd"].drive(1 - self.mark if on else self.mark)
        self.kernel.settle()

    async def before_sending(self) -> None:
        """What a computer waits for before it begins to send."""

    async def _send(self) -> None:
        driver = self.drivers["txd"]
        await self.before_sending()
        while self.outgoing:
            data, fault = self.outgoing[0]
            if fault == "late":
                await until(self.kernel, self.kernel.now + LATE_PS)
            await transmit(driver, self.clock, self.word, data, self.mark, fault)
            self.outgoing.popleft()

    @property
    def backlog(self) -> int:
        """Characters that are still to be sent."""
        return sum(len(data) for data, _ in self.outgoing)

    @property
    def idle(self) -> bool:
        return not self.outgoing and super().idle

    @property
    def waiting(self) -> str:
        if self.outgoing and super().idle:
            return f"{self.name}: {self.backlog} characters to send"
        return super().waiting

    # ---------------------------------------------------------------------------------------------------- receiving
    async def _receive(self) -> None:
        receiver = self.receiver = Receiver(self.pins["rxd"].net, self.clock, self.word, self.mark)
        while True:
            self.take(await receiver.character())

    def take(self, character: Character) -> None:
        """A character has come in."""
        self.received.append(character.byte)
        self.faulty += not character.good
        self.on_character(character)

    def got(self, data: bytes) -> Condition:
        """Condition: these bytes have been received."""
        return GotCondition(self.name, self.received, bytes(data))


class SerialHost(SerialPort):
    """A host computer on the serial line of one module, or of several that share it.

    It follows the straps of the module: rate, checksum, address.  `ask` sends a command and returns the answer.

    Args:
        baud: another rate than the module's.
    """

    def __init__(self, kernel: Kernel, name: str, chips: Sequence[LinePartner], *, baud: int | None = None) -> None:
        port = chips[0].sheet.channel(SerialLine)
        assert port is not None  # the bench chooses the host by the channel
        bits, parity, stop = port.bits, port.parity, port.stop
        super().__init__(
            kernel, name, baud=9600 if baud is None else baud, bits=bits, parity=parity, stop=stop, ttl=False
        )
        self.port = port
        self.channel: Channel = port
        self.fixed_baud: int | str | None = baud
        self.chips: dict[str, Any] = {chip.name: chip for chip in chips}
        self.chip: Any = chips[0]
        self.answers: list[str] = []
        self.line = bytearray()
        self.line_end = Driver(Net(kernel, f"{name}.(line end)"), name)  # changes with every complete line
        self.on_event: Hook[[str]] = Hook()  # what it does, in words: a line of a script, an answer

    def to(self, chip: str | LinePartner) -> SerialHost:
        """From now on, speak to this module."""
        self.chip = served(self.name, self.chips, chip)
        return self

    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Take another rate or format, whatever the module is strapped for."""
        super().change_line(baud, bits, parity, stop)
        self.fixed_baud = baud

    async def before_sending(self) -> None:
        up = max(chip.up_ps for chip in self.chips.values())
        await until(self.kernel, up + POWER_UP_PS)

    # --------------------------------------------------------------------------------------------- what straps say
    def follow_straps(self) -> SerialLine:
        """Take the rate that the module is strapped for."""
        port = self.port
        baud = self.fixed_baud or port.bauds[strapped(self.chip.pins, port.baud_pins)]
        if baud != self.baud:
            self.set_line(baud, self.word)
        return port

    @property
    def checked(self) -> bool:
        """Does the module want checksums?"""
        return bool(self.port.checksum_pin) and strapped(self.chip.pins, [self.port.checksum_pin]) == (1,)

    @property
    def kept(self) -> int:
        """The bits that a checksum always has."""
        return int(self.chip.kept)

    @property
    def address(self) -> str:
        """What stands in front of a command on a shared line."""
        address = self.chip.strapped_address()
        return str(address) if address else ""

    # ------------------------------------------------------------------------------------------------------ sending
    def send(self, data: str | bytes) -> None:
        """Queue characters as they are, without address and checksum; they go out one behind the other."""
        self.follow_straps()
        self.write(data)

    def framed(self, command: str) -> bytes:
        """A command as it goes over the wire: address, checksum and carriage return added."""
        if not isinstance(command, str) or not command.isascii():
            raise UsageError(f"{self.name}: command {command!r}; expected text such as 'V1'")
        if "\r" in command:
            raise UsageError(f"{self.name}: command {command!r}; one at a time, the carriage return is added")
        return framed(self.address + command, self.checked, self.kept)

    def ask(self, command: str, timeout: Time = "5 s") -> str:
        """Send a command, wait for the answer, and return it without checksum and carriage return.

        The listing of Q comes as its lines, "\\r" between them.

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

    async def exchange(self, command: str | bytes) -> list[str]:
        """The same in a task: the answers; none, if the line is silent for longer than any answer takes.

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
        return command != "Q" or self.answers[-1].startswith(("END", "B", "E1", "E2", "E4"))

    def _let_pass(self, met: Callable[[], bool], what: str, timeout: Time) -> None:
        try:
            self.kernel.outside.wait(met, f"{self.name}: {what}", timeout)
        except Timeout as error:
            self.drop()
            heard = self.chip.baud
            if heard == self.baud:
                raise
            raise Timeout(
                f"{error}\n  {self.name} speaks {self.baud} baud, {self.chip.name} listens at {heard}"
            ) from None

    def stripped(self, line: str) -> str:
        """An answer without its checksum."""
        if not self.checked or not line:
            return line
        text, found = line[:-1], ord(line[-1])
        expected = checksum(text.encode("latin-1"), self.kept)
        if found != expected:
            raise ChecksumError(f"{self.name}: {line!r} ends in {found:#04x}; its checksum is {expected:#04x}")
        return text

    def take(self, character: Character) -> None:
        super().take(character)
        if character.byte == 0x0D:
            self.answers.append(self.line.decode("latin-1"))
            self.line.clear()
            self.line_end.drive(len(self.received))
        else:
            self.line.append(character.byte)
