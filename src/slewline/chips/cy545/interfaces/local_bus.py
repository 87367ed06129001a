r"""The local bus: cycles on the data bus that reach memory, display and switches (ch.16).

    phase           0      1      2      3      4      5      6      7      8      9      10
    data bus        | high        | low         | read: nothing; write: the byte       |
    XMEM_SEL               \____________________________________________________/
    ALE                           /------\
    RD                                               \____________________/
    WR                                               \_____________/

Only the memory has a high address byte, which it takes as XMEM_SEL falls; low addresses are taken as ALE falls.  A
cycle takes `fetch` clocks, of which a phase is a tenth (inferred).  What a cycle does is promised as it begins; the
byte of a read is sampled just before RD rises.  While nothing else looks at the bus, a read of the memory is a value.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

from ....core.wires.exchange import End, Exchange, Leader
from ....core.wires.net import Level, Wave
from ....core.wires.waits import level, until
from ....core.wires.wave import Edges

if TYPE_CHECKING:
    from ....core.context import ChipContext
    from ....core.wires.net import Driver, Net
    from .user_bits import UserBits

PHASES = 10  # of a cycle
SELECT, LOW, LATCH, DATA, STROBE, WRITTEN, READ, DESELECT = 1, 2, 3, 4, 5, 7, 8, 9
CONTROLS = ("xmem_sel", "sw_sel", "ale", "rd", "wr")
ADDRESSES = 0x3F  # of the display, whose address lines are six


class LocalBus:
    """The only writer of XMEM_SEL, SW_SEL, ALE, RD and WR, and of the data bus during cycles.

    Every cycle begins at the tick at which the chip is, and has ended when its call returns.
    """

    def __init__(self, chip: ChipContext, ticks: Mapping[str, int], bits: UserBits) -> None:
        self.chip, self.bits = chip, bits
        self.fetch = max(ticks["fetch"], PHASES)  # edges keep their order, however short a cycle is
        self.before = max(ticks["store"] - 2 * self.fetch, 1)  # of a byte that is stored, before it is written
        self.poll = max(ticks["verify_poll"], self.fetch)
        self.timeout = ticks["verify_timeout"]
        self.drivers = {name: chip.drivers[name] for name in CONTROLS}
        self.value = MemoryRead(self)
        self.busy, self.request = chip.pins["busy"].net, chip.pins["io_request"].net

    # --------------------------------------------------------------------------------------------------------- memory
    async def read(self, address: int) -> int:
        """Return the byte that the memory has at an address, 0 to 65535; FF, where there is none."""
        start = await self._begin()
        if self.value.begin(start, address):
            await self.chip.at_tick(start + self.fetch)
            self.bits.bus_used()
            return self.value.byte
        self._select("xmem_sel", start)
        return await self._read(start, address & 0xFF, address >> 8)

    async def write(self, address: int, byte: int) -> bool:
        """Write a byte and read it back until it is right; returns whether it became so within `verify_timeout`.

        Finding verify-timeout: it did not; the chip goes on all the same (quirk CY545-UND-TIMEOUT).
        """
        await self.chip.ticks(self.before)
        start = await self._begin()
        self.value.leave()
        self._select("xmem_sel", start)
        self._address(start, address & 0xFF, address >> 8, (0xFF, byte))
        self._strobe("wr", start, WRITTEN)
        last = start + self.fetch + self.timeout
        looks = start + self.fetch
        while True:
            await self.chip.at_tick(looks)
            found = await self.read(address)
            if found == byte:
                return True
            looks += self.poll
            if looks > last:
                break
        self.chip.finding("verify-timeout", f"address {address}: {byte:02X} was written, {found:02X} is read back")
        return False

    # ------------------------------------------------------------------------------------------ switches and display
    async def digits(self, letter: str, count: int) -> list[int]:
        """Return the digits on the thumbwheel switches for a command, most significant first, 0 to 15 each.

        The address of a digit is inferred (quirk CY545-UND-THUMB-ADDRESS): the low five bits of the letter, and three
        bits that count the digits.

        Args:
            letter: of the command.
            count: 3, 5 or 8, by the width of the number.
        """
        start = await self._begin()
        self.value.leave()
        self._select("sw_sel", start, count)
        found = []
        for digit in range(count):
            byte = await self._read(self.chip.tick, (ord(letter) & 0x1F) << 3 | digit)
            found.append(byte & 0x0F)
        return found

    async def show(self, address: int, data: bytes) -> None:
        """Write bytes to ascending addresses of the display, 0 to 63, one HP_SEL cycle each."""
        for place, byte in enumerate(data, address):
            start = await self._begin()
            self.value.leave()
            self.bits.hp_sel(0)
            self._address(start, place & ADDRESSES, None, (0xFF, byte))
            self._strobe("wr", start, WRITTEN)
            await self.chip.at_tick(start + self._at(DESELECT))
            self.bits.hp_sel(1)
            await self._end(start)

    # ---------------------------------------------------------------------------------------------- parts of a cycle
    def _at(self, phase: int) -> int:
        """The clocks from the start of a cycle to a phase."""
        return self.fetch * phase // PHASES

    def ps(self, start: int, phase: int) -> int:
        """The instant of a phase, ps."""
        return self.chip.clock.ps(start + self._at(phase))

    async def _begin(self) -> int:
        """Return the tick of a cycle that begins now, once a host has its byte off the bus.

        A host that has been answered keeps its byte until it raises IO_REQUEST; one that has not leaves the bus open.
        """
        chip = self.chip
        if self.busy.is_active and self.request.is_active:
            await level(*self.request.when_inactive)
            chip.sync_forward()
        await until(chip.kernel, chip.clock.ps(chip.tick))  # the count may be ahead of this instant
        return chip.tick

    async def _end(self, start: int) -> None:
        await self.chip.at_tick(start + self.fetch)
        self.bits.bus_used()

    def _select(self, pin: str, start: int, cycles: int = 1) -> None:
        """Promise a select line for so many cycles."""
        self.drivers[pin].wave(*self.select_wave(pin, start, cycles))

    def _strobe(self, pin: str, start: int, rises: int) -> None:
        self.drivers[pin].wave(*self.strobe_wave(pin, start, rises))

    def _address(self, start: int, low: int, high: int | None, data: Level) -> None:
        """Promise both bytes of an address, ALE, and what stands on the bus after them."""
        self.drivers["ale"].wave(*self.ale_wave(start))
        self.chip.bus_driver.play(Wave(*self.bus_wave(start, low, high, data)))

    # ---------------------------------------------------------------------------- the waves of a cycle, from its start
    def select_wave(self, pin: str, start: int, cycles: int = 1) -> Edges:
        """Return what a select line shows for so many cycles."""
        rises = self.chip.clock.ps(start + self.fetch * (cycles - 1) + self._at(DESELECT))
        return self.drivers[pin].pulses(self.ps(start, SELECT), rises)

    def ale_wave(self, start: int) -> Edges:
        """Return what ALE shows."""
        return self.drivers["ale"].pulses(self.ps(start, LOW), self.ps(start, LATCH))

    def strobe_wave(self, pin: str, start: int, rises: int) -> Edges:
        """Return what RD or WR shows."""
        return self.drivers[pin].pulses(self.ps(start, STROBE), self.ps(start, rises))

    def bus_wave(self, start: int, low: int, high: int | None, data: Level) -> Edges:
        """Return what the chip has on the data bus: both bytes of an address, and what is to be written."""
        times = tuple(self.ps(start, phase) for phase in (0, LOW, DATA, READ))
        return None, times, (None if high is None else (0xFF, high), (0xFF, low), data, None)

    async def _read(self, start: int, low: int, high: int | None = None) -> int:
        """A read cycle, but for its select line."""
        self._address(start, low, high, None)
        self._strobe("rd", start, READ)
        await self.chip.at_tick(start + self._at(READ))
        byte = self.chip.bus.byte
        await self._end(start)
        return byte


class BusEnd(End, Protocol):
    """A memory, a display or switches on the local bus."""

    high: int  # in the address latches
    low: int
    driver: Driver  # on the data bus
    select: Net
    by_address: bool  # all that it does follows from the address in the latches

    def read(self) -> int | None:
        """Return the byte at the address; None: nothing is there."""


class MemoryRead(Leader[Exchange]):
    """Reads of the memory as values: what all lines of the bus show of the last one, or of the one in progress."""

    def __init__(self, bus: LocalBus) -> None:
        super().__init__(bus.drivers["ale"].net)
        self.bus, self.chip = bus, bus.chip
        self.start = 0
        self.latched = 0, 0  # in the latches of the memory before the read in progress
        self.first = True  # it is the first one since the parts have watched the bus themselves
        self.sampled = 0xFF  # what the chip saw on the bus in the last read that was withdrawn

    def begin(self, start: int, address: int) -> bool:
        """Read as a value from a tick on, if nothing else looks at the bus; else return false."""
        if self.chip.bus_driver.pending:  # with a bit of the bus, which the cycle takes back
            self.leave()
        exchange = self.possible()
        if exchange is None:
            return False
        self.first = not exchange.by_value
        if self.first and any(end.select.is_active for end in self.ends):
            return False
        memory = self.memory
        latched = memory.high, memory.low
        memory.high, memory.low = address >> 8, address & 0xFF
        if not exchange.begin((start, address, memory.read())):
            memory.high, memory.low = latched
            return False
        self.start, self.latched = start, latched
        return True

    @property
    def byte(self) -> int:
        """The byte that has been read."""
        if self.exchange is None or not self.exchange.by_value:
            return self.sampled
        return 0xFF if (byte := self.memory.read()) is None else byte

    # ---------------------------------------------------------------------------------------- what goes by value at all
    def made(self, ends: tuple[BusEnd, ...]) -> Exchange | None:
        """Return the reads that the parts on the bus make possible; None: no memory is there, or one that does more."""
        wire = self.bus.drivers["xmem_sel"].net
        selected = [end for end in ends if end.select.root is wire]
        if len(selected) != 1 or not selected[0].by_address or selected[0].driver.net is not self.chip.bus.root:
            return None
        (self.memory,) = selected
        bus, drivers = self.bus, self.bus.drivers
        led = {
            drivers["xmem_sel"]: lambda state: Wave(*bus.select_wave("xmem_sel", state[0])),
            drivers["ale"]: lambda state: Wave(*bus.ale_wave(state[0])),
            drivers["rd"]: lambda state: Wave(*bus.strobe_wave("rd", state[0], READ)),
            self.chip.bus_driver: lambda state: Wave(*bus.bus_wave(state[0], state[1] & 0xFF, state[1] >> 8, None)),
        }
        return Exchange(led, {self.memory.driver: self._answer}, ends, self._withdrawn)

    def _answer(self, state: tuple[int, int, int | None]) -> Wave:
        """Return what the memory shows on the bus in a read: its first tick, the address and the byte there."""
        start, _, byte = state
        _, times, _ = self.bus.strobe_wave("rd", start, READ)
        return Wave(None, times, (None if byte is None else (0xFF, byte), None))

    def _withdrawn(self, seen: int) -> None:
        """The parts go on by themselves, with what they have latched so far; the chip looks at the bus in time."""
        read, latch = (self.bus.ps(self.start, phase) for phase in (READ, LATCH))
        memory, (high, low) = self.memory, self.latched
        if self.chip.kernel.now >= read:  # the chip looks before anything changes in that instant
            self.sampled = 0xFF if (byte := memory.read()) is None else byte
        else:
            self.chip.kernel.call_at(read, self._sample)
        if seen >= latch:
            low = memory.low
        elif seen < self.bus.ps(self.start, SELECT):
            memory.high = high
        for end in self.ends if seen >= latch or not self.first else (memory,):
            end.low = low

    def _sample(self) -> None:
        self.sampled = self.chip.bus.byte
