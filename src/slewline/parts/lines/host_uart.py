"""The UART of a computer: characters out on txd, characters in on rxd, at the speed of the line."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from ...core.time.inputs import from_outside
from ...core.wires.characters import Character, CharacterHook, Receiver, frames_of, transmit
from ...core.wires.pin import Condition, GotCondition
from ...core.wires.serial import CharacterFormat, LineSetting, bit_clock
from ...core.wires.waits import until
from ...errors import UsageError
from ..base.written_data import Data, as_bytes
from .far_end import FarEnd

if TYPE_CHECKING:
    from ...core.time.kernel import Task
    from ..base.part import Part
    from ..base.recent import Recent

FAULTS = ("parity", "framing", "late")
LATE_PS = 10**11  # how much later than it could a late character begins
BURST = 16  # characters whose edges are promised together
SILENCE_PS = 5 * 10**12  # no answer takes longer
POWER_UP_PS = 10**9  # a host gives a module a millisecond after power-up, whose RESET pulse it would not hear through


class HostUart:
    """A UART on the pins txd and rxd of a part, which it makes.  What a user asks of it is an input of the part.

    Args:
        mark: the level of a line at rest.
    """

    burst = BURST

    def __init__(self, part: Part, setting: LineSetting, mark: int) -> None:
        self.part, self.kernel, self.name, self.mark = part, part.kernel, part.name, mark
        self.finding = part.finding
        self.receiver: Receiver | None = None
        self.far = FarEnd(self)
        self.set_line(*setting)
        self.txd = part.add_pin("txd", "out", "serial data out", initial=mark, role="computer_out", active=1 - mark)
        self.rxd = part.add_pin("rxd", "in", "serial data in", pull=mark, role="computer_in", active=1 - mark)
        self.driver = part.drivers["txd"]
        self.outgoing: deque[tuple[bytes, str]] = deque()  # bursts of characters, each with its fault
        self.sender: Task | None = None
        self._received = bytearray()
        self._recent = part.keep_recent(self._received)
        self.faulty = 0  # characters with a parity or framing fault
        self.on_character = CharacterHook()  # one has come in

    # ------------------------------------------------------------------------------------------------ rate and format
    @property
    def setting(self) -> LineSetting:
        """Rate and format."""
        return LineSetting(self.baud, self.word)

    def set_line(self, baud: int | str, word: CharacterFormat) -> None:
        """Take another rate or format, from the next character on."""
        self.clock, self.word, self.baud = bit_clock(baud, self.name), word.checked(self.name), baud
        self.frames = frames_of(self.clock.hz, word, self.mark)
        self.far.compared = False
        if self.receiver is not None:
            self.receiver.set_line(self.clock, self.word)

    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Take another rate or format, as an input."""
        self.set_line(baud, CharacterFormat(bits, parity, stop))
        self.part.input("change_line", baud, bits, parity, stop)

    def lent(self) -> Callable[[], object]:
        """Return what restores rate and format, when another program has used this line."""
        baud, word = self.baud, self.word
        return lambda: self.set_line(baud, word)

    def opened_at(self, baud: int) -> None:
        """Report a rate that a program has set on a port where it changes nothing, if on a cable it would."""
        self.part.input("opened_at", baud)
        self.far.opened_at(baud)

    # ------------------------------------------------------------------------------------------------------- sending
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters, as an input; they go out one after the other.

        Raises:
            UsageError: text that is not ASCII, or neither text nor bytes; or no fault that there is.
        """
        data = as_bytes(self.name, data)
        if fault and fault not in FAULTS:
            raise UsageError(f"{self.name}: fault {fault!r}; allowed {', '.join(FAULTS)}")
        self.part.input("write", data, fault)
        if data[:1] == b"\xff":
            self.far.look_for_telnet(data)
        burst = 1 if fault == "late" else self.burst  # every one of them is late
        self.outgoing.extend((data[at : at + burst], fault) for at in range(0, len(data), burst))
        if self.outgoing and (self.sender is None or not self.sender.alive):
            self.sender = self.kernel.spawn(self._send, name=f"{self.name} sends")

    def drop(self, verb: str) -> None:
        """Forget what is to be sent after what is on the line already, as this input."""
        self.part.input(verb)
        while len(self.outgoing) > 1:
            self.outgoing.pop()

    def space(self, on: bool) -> None:
        """Begin or end a break, as an input: space on the line; nothing is to be sent meanwhile."""
        self.part.input("space", on)
        self.driver.drive(1 - self.mark if on else self.mark)
        self.kernel.settle()

    def rest(self) -> None:
        """Forget what is to be sent, and put the line to mark."""
        if self.sender is not None:
            self.sender.kill()
        self.outgoing.clear()
        self.driver.drive(self.mark)

    async def before_sending(self) -> None:
        """Wait for what a computer waits for before it begins to send."""

    async def before_burst(self) -> None:
        """Wait for what a computer waits for before each burst of characters."""

    def after_burst(self, data: bytes) -> None:
        """Note that characters have gone out."""

    async def _send(self) -> None:
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
            await transmit(self.driver, self.frames, data, fault)
            self.after_burst(data)
            self.outgoing.popleft()

    @property
    def backlog(self) -> int:
        """Characters that are still to be sent."""
        return sum(len(data) for data, _ in self.outgoing)

    @property
    def idle(self) -> bool:
        """Is nothing to be sent?"""
        return not self.outgoing

    @property
    def waiting(self) -> str:
        """What is to be sent, in words."""
        return f"{self.name}: {self.backlog} characters to send"

    # ----------------------------------------------------------------------------------------------------- receiving
    def listen(self) -> None:
        """Start to listen."""
        self.kernel.spawn(self._receive, name=f"{self.name} receives")

    async def _receive(self) -> None:
        receiver = Receiver(self.rxd.net, self.clock, self.word, self.mark)
        self.receiver = self.on_character.receiver = receiver
        await receiver.receive(self.take, self.passed, self._acts)

    def catch_up(self) -> None:
        """Receive what has come, if it has not been received yet: part of a line that is taken as a whole."""
        if self.receiver is not None:
            self.receiver.catch_up()

    @property
    def received(self) -> bytearray:
        """The data bits of every character, good or not."""
        self.catch_up()
        return self._received

    @property
    def recent(self) -> Recent:
        """How much has been received, and which of it is still there."""
        self.catch_up()
        return self._recent

    def _acts(self, data: bytes, at: int) -> int:
        """Return the number of the next character of a line that must be taken at its instant."""
        return at if self.on_character.listeners else self.acts(data, at)

    def acts(self, data: bytes, at: int) -> int:
        """Return the number of the next character, of those from `at` on, at which this end acts; -1: of none."""
        return -1

    def passed(self, data: bytes) -> None:
        """Receive good characters, at which this end does not act."""
        self._received += data

    def take(self, character: Character) -> None:
        """Receive a character."""
        self._received.append(character.byte)
        self.faulty += not character.good
        self.on_character(character)

    def got(self, data: Data) -> Condition:
        """Return a condition: these bytes have been received, one after the other."""
        mute = "" if self.rxd.net.drivers else " (nothing drives its rxd: what is connected there only receives)"
        return GotCondition(f"{self.name}{mute}", self.received, as_bytes(self.name, data), (self.rxd.net,))


class OverUart:
    """The calls of a part that has a UART."""

    uart: HostUart

    def rewired(self) -> None:
        """Start to listen."""
        self.uart.listen()

    @property
    def baud(self) -> int | str:
        """The rate, in baud."""
        return self.uart.baud

    @property
    def word(self) -> CharacterFormat:
        """The format of a character: data bits, parity, stop bits."""
        return self.uart.word

    @property
    def received(self) -> bytearray:
        """The characters received."""
        return self.uart.received

    @property
    def faulty(self) -> int:
        """The number of characters received with a parity or framing error."""
        return self.uart.faulty

    def got(self, data: Data) -> Condition:
        """Return a condition for `bench.run_until`: these bytes have been received, with nothing in between."""
        return self.uart.got(data)

    @from_outside
    def space(self, on: bool) -> None:
        """Begin (True) or end (False) a break: the line is held at space; send nothing during it."""
        self.uart.space(on)
