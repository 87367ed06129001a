"""The UART of a computer: characters out on txd, characters in on rxd, at the line rate."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from ...core.time.inputs import from_outside
from ...core.wires.characters import begin_line, frames_of
from ...core.wires.pin import Condition, GotCondition
from ...core.wires.receiver import Character, CharacterHook, Receiver
from ...core.wires.serial import CharacterFormat, LineSetting, bit_clock
from ...core.wires.waits import suspended, until
from ...errors import UsageError
from ..base.written_data import Data, as_bytes
from .far_end import FarEnd

if TYPE_CHECKING:
    from ...core.time.kernel import Task
    from ..base.part import Part
    from ..base.recent import Recent

FAULTS = ("parity", "framing", "late")
LATE_PS = 10**11  # delay of a late character
BURST = 16  # characters whose edges are promised together
SILENCE_PS = 5 * 10**12  # maximum time for a reply
POWER_UP_PS = 10**9  # pause after power-up: during its RESET pulse a module would not receive


class HostUart:
    """A UART that adds the pins txd and rxd to a part.

    The calls of a user are recorded as inputs of the part.

    Args:
        part: the part.
        setting: the initial rate and format.
        mark: the level of an idle line.
    """

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
        self.sending = False
        self._received = bytearray()
        self._recent = part.keep_recent(self._received)
        self.faulty = 0  # characters with a parity or framing fault
        self.on_character = CharacterHook()  # a character has arrived

    # ------------------------------------------------------------------------------------------------ rate and format
    @property
    def setting(self) -> LineSetting:
        """Present rate and format."""
        return LineSetting(self.baud, self.word)

    def set_line(self, baud: int | str, word: CharacterFormat) -> None:
        """Use another rate or format, starting with the next character."""
        self.clock, self.word, self.baud = bit_clock(baud, self.name), word.checked(self.name), baud
        self.frames = frames_of(self.clock.hz, word, self.mark)
        self.far.compared = False
        if self.receiver is not None:
            self.receiver.set_line(self.clock, self.word)

    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Use another rate or format; this call is recorded as an input of the part."""
        self.set_line(baud, CharacterFormat(bits, parity, stop))
        self.part.input("change_line", baud, bits, parity, stop)

    def lent(self) -> Callable[[], object]:
        """Return a function that restores the present rate and format after another program has used the UART."""
        baud, word = self.baud, self.word
        return lambda: self.set_line(baud, word)

    def opened_at(self, baud: int) -> None:
        """Report, once, that a program opens this port at a rate that is ignored here, but would fail on a cable."""
        self.part.input("opened_at", baud)
        self.far.opened_at(baud)

    # ------------------------------------------------------------------------------------------------------- sending
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters, to be sent one after another; this call is recorded as an input of the part.

        Raises:
            UsageError: the text is not ASCII, the data are neither text nor bytes, or the fault is unknown.
        """
        data = as_bytes(self.name, data)
        if fault and fault not in FAULTS:
            raise UsageError(f"{self.name}: fault {fault!r}; allowed {', '.join(FAULTS)}")
        self.part.input("write", data, fault)
        if data[:1] == b"\xff":
            self.far.look_for_telnet(data)
        self.outgoing += [(burst, fault) for burst in self.bursts(data, fault)]
        if self.sender is None or not self.sender.alive:
            self.sender = self.kernel.spawn(self._send, name=f"{self.name} sends")
        elif not self.sending:
            self.kernel.wake(self.sender)
        self.sending = True

    def bursts(self, data: bytes, fault: str) -> list[bytes]:
        """Return the parts of `data` that are each sent as one line of characters."""
        length = 1 if fault == "late" else BURST  # every character is late
        return [data[at : at + length] for at in range(0, len(data), length)]

    def drop(self, verb: str) -> None:
        """Drop the queued characters, except the burst being sent.

        This call is recorded as an input of the part, under the name `verb`.
        """
        self.part.input(verb)
        while len(self.outgoing) > 1:
            self.outgoing.pop()

    def space(self, on: bool) -> None:
        """Begin (True) or end (False) a break: the line is held at space, and nothing may be sent meanwhile.

        This call is recorded as an input of the part.
        """
        self.part.input("space", on)
        self.driver.drive(1 - self.mark if on else self.mark)
        self.kernel.settle()

    def rest(self) -> None:
        """Drop the queued characters, and set the line to mark."""
        if self.sender is not None:
            self.sender.kill()
        self.outgoing.clear()
        self.driver.drive(self.mark)

    def may_send_ps(self) -> int:
        """Return the instant (ps) from which the host may send."""
        return 0

    async def before_burst(self) -> None:
        """Wait until the host may send the next burst of characters."""

    def after_burst(self, data: bytes) -> None:
        """Record that a burst of characters has been sent."""

    async def _send(self) -> None:
        while True:
            if (ps := self.may_send_ps()) > self.kernel.now:
                await until(self.kernel, ps)
            while self.outgoing:
                if self.outgoing[0][1] == "late":
                    await until(self.kernel, self.kernel.now + LATE_PS)
                await self.before_burst()
                data, fault = self.outgoing[0]
                if not self.far.compared:
                    self.far.compare()
                if self.far.addressed:
                    self.far.look_at_addresses(data)
                await until(self.kernel, begin_line(self.driver, self.frames, data, fault))
                self.after_burst(self.outgoing[0][0])
                self.outgoing.popleft()
            self.sending = False
            await suspended()

    @property
    def backlog(self) -> int:
        """Number of characters not yet sent, including those of the burst being sent."""
        return sum(len(data) for data, _ in self.outgoing)

    @property
    def idle(self) -> bool:
        """True while no character is waiting to be sent."""
        return not self.outgoing

    @property
    def waiting(self) -> str:
        """Description of the activity: the number of characters still to be sent."""
        return f"{self.name}: {self.backlog} characters to send"

    # ----------------------------------------------------------------------------------------------------- receiving
    def listen(self) -> None:
        """Start to receive characters."""
        receiver = Receiver(self.rxd.net, self.clock, self.word, self.mark)
        self.receiver = self.on_character.receiver = receiver
        self.kernel.spawn(receiver.receive, self.take, self.passed, self._acts, name=f"{self.name} receives")

    def catch_up(self) -> None:
        """Receive the characters that have arrived so far, but have been held back to be processed together."""
        if self.receiver is not None:
            self.receiver.catch_up()

    @property
    def received(self) -> bytearray:
        """Data bits of all characters received, including characters with a fault."""
        self.catch_up()
        return self._received

    @property
    def recent(self) -> Recent:
        """The latest characters received, and the total number of characters received so far."""
        self.catch_up()
        return self._recent

    def _acts(self, data: bytes, at: int) -> int:
        return at if self.on_character.listeners else self.acts(data, at)

    def acts(self, data: bytes, at: int) -> int:
        """Return the index, `at` or later, of the next character in `data` on which this end acts; -1 if none."""
        return -1

    def passed(self, data: bytes) -> None:
        """Receive characters that have no fault, and on which this end does not act."""
        self._received += data

    def take(self, character: Character) -> None:
        """Receive one character."""
        self._received.append(character.byte)
        self.faulty += character.parity_wrong or character.framing_wrong
        if self.on_character.listeners:
            self.on_character(character)

    def discard(self) -> None:
        """Discard the characters received: a listener has taken them, one by one."""
        self._received.clear()

    def got(self, data: Data) -> Condition:
        """Return a condition for `bench.run_until`: these bytes have been received, consecutively."""
        mute = "" if self.rxd.net.drivers else " (nothing drives its rxd: the other end only receives)"
        return GotCondition(f"{self.name}{mute}", self.received, as_bytes(self.name, data), (self.rxd.net,))


class OverUart:
    """Mixin for parts with a UART; provides the calls that users make to operate the UART."""

    uart: HostUart

    def rewired(self) -> None:
        """Start to receive, now that the part is wired."""
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
        """Return a condition for `bench.run_until`: these bytes have been received, consecutively."""
        return self.uart.got(data)

    @from_outside
    def change_line(self, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        """Change the rate and format of this end only.

        Args:
            baud: the rate, such as 9600 or "37.5"; sixteen times the rate must be a whole number of hertz.
            bits: the number of data bits, 5 to 8.
            parity: "none", "odd" or "even".
            stop: the number of stop bits: 1, "1.5" or 2.

        Raises:
            UsageError: the rate or format is not allowed.
        """
        self.uart.change_line(baud, bits, parity, stop)

    @from_outside
    def opened_at(self, baud: int) -> None:
        """Report, once, that a program opens this port at a rate that is ignored here, but would fail on a cable."""
        self.uart.opened_at(baud)

    @from_outside
    def write(self, data: str | bytes, fault: str = "") -> None:
        """Queue characters to be sent unchanged, at the rate of the line.

        Args:
            data: the characters.
            fault: "parity", "framing" or "late": every character is sent with this fault.

        Raises:
            UsageError: the text is not ASCII, the data are neither text nor bytes, or the fault is unknown.
        """
        self.uart.write(data, fault)

    @from_outside
    def space(self, on: bool) -> None:
        """Begin (True) or end (False) a break, which holds the line at space; send nothing during the break."""
        self.uart.space(on)
