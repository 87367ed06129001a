"""A serial line into the parallel port (s.10, fig. 10.16): the sender of a host, and a receive-only UART.

    line   ‾‾‾‾\\_____/  d0 |  d1 | ... |  dn | parity | stop ‾‾‾‾‾       TTL levels, idle high, lowest bit first
               start  ^     ^           ^      ^         ^
                      the UART looks in the middle of each bit, on a clock of sixteen times the baud rate

    DAV, inverted -> I/O REQUEST     INSTROBE -> RDE: low puts the byte on the bus     READY -> RDAV: low clears DAV

RDAV is a level: while READY is low, DAV cannot be set, and a character that is complete by then is lost.  The link has
no way to stop the host; it must pause by itself around motions, delays and waits.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from types import MappingProxyType

from ..core.kernel import Kernel
from ..core.net import Net, Wave
from ..core.timebase import Clock, picoseconds
from ..core.waits import level, until
from ..errors import UsageError
from .part import Part
from .worker import Data, Worker, as_bytes

OVERSAMPLING = 16
GENERATOR_HZ = 2_457_600
STAGES = 12  # of the CD4040 behind the oscillator


def _text(baud: Fraction) -> str:
    return str(baud.numerator) if baud.denominator == 1 else f"{float(baud):g}"


# baud rate: clock of the UART in hertz, at the outputs of the counter
GENERATOR = MappingProxyType(
    {_text(Fraction(GENERATOR_HZ, OVERSAMPLING << stage)): GENERATOR_HZ >> stage for stage in range(1, STAGES + 1)}
)
PARITIES = ("none", "odd", "even")


@dataclass(frozen=True, slots=True)
class Word:
    """A word format: 5 to 8 data bits, parity, and 1, 1.5 or 2 stop bits."""

    bits: int
    parity: str
    stop: int | str

    def checked(self, owner: str) -> Word:
        """The format itself, if it is one."""
        if self.bits not in range(5, 9) or self.parity not in PARITIES or str(self.stop) not in ("1", "1.5", "2"):
            raise UsageError(
                f"{owner}: {self.bits} bits, parity {self.parity!r}, {self.stop} stop bits; "
                f"allowed 5 to 8, {' or '.join(PARITIES)}, and 1, '1.5' or 2"
            )
        return self

    @property
    def stop_ticks(self) -> int:
        """Length of the stop bits in ticks of the clock."""
        return int(OVERSAMPLING * Fraction(str(self.stop)))

    def parity_bit(self, byte: int) -> int:
        """The bit that makes the number of ones odd or even."""
        return (byte.bit_count() + (self.parity == "odd")) % 2

    def levels(self, byte: int) -> list[int]:
        """Start bit, data bits, parity."""
        data = [byte >> n & 1 for n in range(self.bits)]
        return [0, *data] + ([] if self.parity == "none" else [self.parity_bit(byte & (1 << self.bits) - 1)])


class SerialSender(Worker):
    """The serial output of a host: it sends without asking anybody.

    Args:
        baud: any rate of which sixteen times is whole hertz, for example 9600 or "37.5".
        gap: what the host pauses after each character.
    """

    wiring = MappingProxyType({"txd": "rxd"})

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        baud: int | str = 9600,
        bits: int = 8,
        parity: str = "none",
        stop: int | str = 1,
        gap: str | int = 0,
    ) -> None:
        super().__init__(kernel, name)
        self.word = Word(bits, parity, stop).checked(name)
        try:
            rate = OVERSAMPLING * Fraction(str(baud))
        except ValueError:
            rate = Fraction(0)
        if rate < 1 or rate.denominator != 1:
            raise UsageError(f"{name}: baud {baud!r}; expected 9600, '37.5' ...: sixteen times the rate in whole hertz")
        self.clock = Clock(rate.numerator)
        self.gap_ps = picoseconds(gap)
        self.add_pin("txd", "out", "serial data, TTL level", initial=1)

    def send(self, data: Data) -> None:
        """Queue characters; they go out one behind the other."""
        data = as_bytes(self.name, data)
        self.input("send", data)
        for byte in data:
            self.work(f"sends {byte:#04x}", lambda byte=byte: self._character(byte))  # type: ignore[misc]

    def pause(self, time: str | int) -> None:
        """Queue a pause: the host gives the chip time."""
        ps = picoseconds(time)
        self.input("pause", ps)

        async def wait() -> None:
            await until(self.kernel, self.kernel.now + ps)

        self.work("pauses", wait)

    async def _character(self, byte: int) -> None:
        clock, levels = self.clock, self.word.levels(byte)
        start = clock.ticks_from(self.kernel.now)
        await until(self.kernel, clock.ps(start))
        end = start + OVERSAMPLING * len(levels)
        times = tuple(clock.ps(start + OVERSAMPLING * n) for n in range(len(levels) + 1))
        self.drivers["txd"].play(Wave(1, times, (*levels, 1)))
        await until(self.kernel, clock.ps(end + self.word.stop_ticks) + self.gap_ps)


class Uart(Part):
    """Receive-only UART whose mode is strapped (no command word), with its baud rate generator.

    Args:
        baud: an output of the generator: 76800, 38400, 19200, 9600 ... 150, 75 or "37.5".
        bits, parity, stop: the straps; they must match the host.
    """

    wiring = MappingProxyType({"db": "db", "request": "io_request", "rde": "instrobe", "rdav": "ready"})

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        baud: int | str = 9600,
        bits: int = 8,
        parity: str = "none",
        stop: int | str = 1,
    ) -> None:
        super().__init__(kernel, name)
        self.word = Word(bits, parity, stop).checked(name)
        if str(baud) not in GENERATOR:
            raise UsageError(f"{name}: baud {baud!r}; the generator has {', '.join(GENERATOR)}")
        self.clock = Clock(GENERATOR[str(baud)])
        self.add_bus("db", "received data, driven while RDE is low")
        self.add_pin("rxd", "in", "serial data, TTL level", pull=1)
        self.add_pin("rde", "in", "low: received data on the bus", pull=1)
        self.add_pin("rdav", "in", "low: clears DAV and holds it clear", pull=1)
        self.add_pin("dav", "out", "high: a character is available", initial=0)
        self.add_pin("request", "out", "DAV through an inverter", initial=1)
        for flag, says in (("pe", "parity error"), ("fe", "framing error"), ("oe", "overrun")):
            self.add_pin(flag, "out", f"high: {says} in the last character", initial=0)
        self.held = 0
        self.available = self.receiving = False

    def rewired(self) -> None:
        self.pin("rdav").net.watch(lambda net: self._set(False) if net.level == 0 else None)
        self.pin("rde").net.watch(lambda _: self._put())
        self.kernel.spawn(self._receive(), self.name)

    @property
    def idle(self) -> bool:
        return not self.receiving

    @property
    def waiting(self) -> str:
        return f"{self.name}: {'in a character' if self.receiving else 'a start bit'}"

    # ------------------------------------------------------------------------------------------------ parallel side
    def _put(self) -> None:
        self.drivers["db"].drive(None if self.high("rde") else (0xFF, self.held))

    def _set(self, available: bool) -> None:
        self.available = available
        self.drivers["dav"].drive(int(available))
        self.drivers["request"].drive(int(not available))

    # -------------------------------------------------------------------------------------------------- serial side
    async def _receive(self) -> None:
        line, clock = self.pin("rxd").net, self.clock
        while True:
            self.receiving = False
            await level(line, 0)
            self.receiving = True
            middle = clock.ticks_until(self.kernel.now) + 1 + OVERSAMPLING // 2  # the fall is seen at the next clock
            if await self._look(line, middle):
                continue  # a spike, no start bit
            byte = 0
            for n in range(self.word.bits):
                middle += OVERSAMPLING
                byte |= await self._look(line, middle) << n
            wrong = False
            if self.word.parity != "none":
                middle += OVERSAMPLING
                wrong = await self._look(line, middle) != self.word.parity_bit(byte)
            stop = await self._look(line, middle + OVERSAMPLING)
            self._complete(byte, wrong, not stop)
            if not stop:
                await level(line, 1)

    async def _look(self, line: Net, tick: int) -> int:
        await until(self.kernel, self.clock.ps(tick))
        return int(line.level != 0)

    def _complete(self, byte: int, parity: bool, framing: bool) -> None:
        for flag, wrong, code, text in (
            (
                "pe",
                parity,
                "uart-parity",
                f"wrong parity of {byte:#04x}: the word formats differ, or the line is noisy",
            ),
            ("fe", framing, "uart-framing", f"no stop bit behind {byte:#04x}: baud rates or word formats differ"),
            (
                "oe",
                self.available,
                "uart-overrun",
                f"{byte:#04x} came before {self.held:#04x} was taken, which is lost",
            ),
        ):
            self.drivers[flag].drive(int(wrong))
            if wrong:
                self.finding(code, text)
        self.held = byte
        if self.high("rdav"):
            self._set(True)
        else:
            self.finding("uart-lost", f"{byte:#04x} was complete while READY was low: it is lost; let the host pause")
        self._put()
