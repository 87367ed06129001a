r"""A serial link to the parallel port (s.10, fig. 10.16): a host's sender, and a receive-only UART.

    line   ‾‾‾‾\_____/  d0 |  d1 | ... |  dn | parity | stop ‾‾‾‾‾       TTL levels, idle high, lowest bit first
               start  ^     ^           ^      ^         ^
                      the UART samples in the middle of each bit, with a clock of sixteen times the baud rate

    DAV, inverted -> I/O REQUEST     INSTROBE -> RDE: low puts the byte on the bus     READY -> RDAV: low clears DAV

RDAV acts as a level: while READY is low, DAV cannot be set, and a character completed in that time is lost.  The link
cannot stop the host, which must itself pause during motions, delays and waits.
"""

from __future__ import annotations

from fractions import Fraction
from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Clock, Time, picoseconds
from ...core.wires.characters import frames_of, transmit
from ...core.wires.receiver import Character, Receiver
from ...core.wires.serial import BAUD, OVERSAMPLING, TTL, CharacterFormat, LineSetting, bit_clock, word_options
from ...core.wires.waits import until
from ..base.part import Part
from ..base.request_queue import RequestQueue
from ..base.written_data import Data, as_bytes

GENERATOR_HZ = 2_457_600
STAGES = 12  # outputs of the CD4040 after the oscillator


def _spelled(baud: Fraction) -> int | str:
    return baud.numerator if baud.denominator == 1 else f"{float(baud):g}"


# baud rate: clock of the UART in hertz, at the outputs of the counter
GENERATOR = MappingProxyType(
    {_spelled(Fraction(GENERATOR_HZ, OVERSAMPLING << stage)): GENERATOR_HZ >> stage for stage in range(1, STAGES + 1)}
)


class SerialSender(Part):
    """The serial output of a host, without any handshake."""

    _for_users = ("send", "pause")
    wiring = MappingProxyType({"txd": "serial_in"})
    options = (
        BAUD,
        *word_options(8, "none", 1),
        Option("gap", "time", 0, "pause of the host after each character"),
    )

    def __init__(
        self, kernel: Kernel, name: str, *, baud: int | str, bits: int, parity: str, stop: int | str, gap: Time
    ) -> None:
        super().__init__(kernel, name)
        self.queue: RequestQueue = RequestQueue(kernel, name)
        word = CharacterFormat(bits, parity, stop).checked(name)
        self._frames = frames_of(bit_clock(baud, name).hz, word, TTL)
        self._gap_ps = picoseconds(gap)
        self.add_pin("txd", "out", "serial data, TTL level", initial=1, role="computer_out", active=0)

    @from_outside
    def send(self, data: Data) -> None:
        """Queue characters; they are sent one after another."""
        data = as_bytes(self.name, data)
        self.input("send", data)
        for byte in data:
            self.queue.post(f"sending {byte:#04x}", lambda byte=byte: self._character(byte))  # type: ignore[misc]

    @from_outside
    def pause(self, time: Time) -> None:
        """Queue a pause, to give the chip time."""
        ps = picoseconds(time)
        self.input("pause", f"{ps} ps")

        async def wait() -> None:
            await until(self.kernel, self.kernel.now + ps)

        self.queue.post("pausing", wait)

    async def _character(self, byte: int) -> None:
        await transmit(self.drivers["txd"], self._frames, bytes([byte]))
        await until(self.kernel, self.kernel.now + self._gap_ps)


class Uart(Part):
    """A receive-only UART, whose mode is set by straps (no command word), and its baud rate generator.

    The straps (bits, parity, stop) must match the host.
    """

    _for_users = ("held",)
    wiring = MappingProxyType({"db": "data", "request": "request", "rde": "in_strobe", "rdav": "ready"})
    options = (
        Option("baud", "choice", 9600, "rate of the baud rate generator", choices=tuple(GENERATOR)),
        *word_options(8, "none", 1),
    )

    def __init__(self, kernel: Kernel, name: str, *, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        super().__init__(kernel, name)
        self.setting = LineSetting(baud, CharacterFormat(bits, parity, stop).checked(name))
        self._word, self._clock = self.setting.word, Clock(GENERATOR[baud])
        self.add_bus("db", "received data, driven while RDE is low", role="data")
        self.add_pin("rxd", "in", "serial data, TTL level", pull=1, role="serial_in", active=0)
        self.add_pin("rde", "in", "low: received data on the bus", pull=1)
        self.add_pin("rdav", "in", "low: clears DAV and holds it clear", pull=1)
        self.add_pin("dav", "out", "high: a character is available", initial=0)
        self.add_pin("request", "out", "DAV through an inverter", initial=1)
        for flag, meaning in (("pe", "parity error"), ("fe", "framing error"), ("oe", "overrun")):
            self.add_pin(flag, "out", f"high: {meaning} in the last character", initial=0)
        self.held = 0
        self._available = False
        self._receiver: Receiver | None = None

    def rewired(self) -> None:
        """Start to receive, and to follow the pins of the parallel side, now that the UART is wired."""
        self.pin("rdav").net.watch(lambda net: self._set(False) if net.level == 0 else None)
        self.pin("rde").net.watch(lambda _: self._put())
        self.kernel.spawn(self._receive, name=self.name)

    @property
    def set_by(self) -> str:
        """Text that names the options by which the rate and the format are set."""
        return "its options baud, bits, parity, stop"

    def instead(self, baud: int | str) -> str:
        """Return the option that would set the UART to another rate; "" if the generator does not have this rate."""
        return f"the option baud={baud!r}" if baud in GENERATOR else ""

    @property
    def idle(self) -> bool:
        """True while no character is being received."""
        return self._receiver is None or not self._receiver.receiving

    @property
    def waiting(self) -> str:
        return f"{self.name}: {'waiting for a start bit' if self.idle else 'receiving a character'}"

    # ------------------------------------------------------------------------------------------------ parallel side
    def _put(self) -> None:
        self.drivers["db"].drive(None if self.high("rde") else (0xFF, self.held))

    def _set(self, available: bool) -> None:
        self._available = available
        self.drivers["dav"].drive(int(available))
        self.drivers["request"].drive(int(not available))

    # -------------------------------------------------------------------------------------------------- serial side
    async def _receive(self) -> None:
        self._receiver = Receiver(self.pin("rxd").net, self._clock, self._word, TTL)
        await self._receiver.receive(self._complete)

    def _complete(self, character: Character) -> None:
        byte = character.byte
        for flag, wrong, code, text in (
            (
                "pe",
                character.parity_wrong,
                "uart-parity",
                f"wrong parity of {byte:#04x}: the UART is set to {self.setting}; set the host to the same, or check "
                "the line for noise",
            ),
            (
                "fe",
                character.framing_wrong,
                "uart-framing",
                f"no stop bit after {byte:#04x}: the UART is set to {self.setting}; set the host to the same",
            ),
            (
                "oe",
                self._available,
                "uart-overrun",
                f"{byte:#04x} arrived before {self.held:#04x} was read: {self.held:#04x} is lost",
            ),
        ):
            self.drivers[flag].drive(int(wrong))
            if wrong:
                self.finding(code, text)
        self.held = byte
        if self.high("rdav"):
            self._set(True)
        else:
            self.finding(
                "uart-lost",
                f"{byte:#04x} arrived while READY was low, and is lost; let the host pause between characters",
            )
        self._put()
