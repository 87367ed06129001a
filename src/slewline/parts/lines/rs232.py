"""RS-232: the serial connector of a computer.

computer   txd --------> rxd   module          three wires; mark, the idle state, is the negative voltage,
           rxd <-------- txd                   which is level 0 here
"""

from __future__ import annotations

from collections import deque
from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.time.hook import Hook
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel, Task
from ...core.wires.pin import Condition, GotCondition
from ...core.wires.serial import BAUD, RS232, TTL, Character, Receiver, Setting, Word, bit_clock, transmit, word_options
from ...core.wires.waits import until
from ...errors import UsageError
from ..base.worker import Data, Worker, as_bytes
from .far_end import FarEnd

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
        self.far = FarEnd(self)
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
        self.far.compared = False
        if self.receiver is not None:
            self.receiver.clock, self.receiver.word = self.clock, self.word

    @from_outside
    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Change rate and format from the next character on; a journal keeps it."""
        self.set_line(baud, Word(bits, parity, stop))
        self.input("change_line", baud, bits, parity, stop)

    @property
    def setting(self) -> Setting:
        """Rate and format."""
        return Setting(self.baud, self.word)

    @from_outside
    def opened_at(self, baud: int) -> None:
        """Report a rate that a program has set on a port where it changes nothing, if on a cable it would."""
        self.input("opened_at", baud)
        self.far.opened_at(baud)

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
            if not self.far.compared:
                self.far.compare()
            if self.far.addressed:
                self.far.look_at_addresses(data)
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
