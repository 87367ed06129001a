r"""The local bus: cycles on the data bus that reach memory, display and switches (ch.16).

    phase           0      1      2      3      4      5      6      7      8      9      10
    data bus        | high        | low         | read: nothing; write: the byte       |
    XMEM_SEL               \____________________________________________________/
    ALE                           /------\
    RD                                               \____________________/
    WR                                               \_____________/

Only the memory has a high address byte, latched as XMEM_SEL falls; low addresses are latched as ALE falls.  A cycle
takes `fetch` clocks; a phase is a tenth of them (inferred).  The outputs of a cycle are promised as it begins; the
byte of a read is sampled just before RD rises.  While no other part watches the bus, a memory read is handled as a
single value.
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
ADDRESSES = 0x3F  # of the display, which has six address lines


class LocalBus:
    """The only writer of XMEM_SEL, SW_SEL, ALE, RD and WR, and of the data bus during cycles.

    Every cycle begins at the chip's present tick, and has ended when the call returns.
    """

    def __init__(self, chip: ChipContext, ticks: Mapping[str, int], bits: UserBits) -> None:
        self.chip, self.bits = chip, bits
        self.fetch = max(ticks["fetch"], PHASES)  # keeps the order of edges, however short a cycle is
        self.before = max(ticks["store"] - 2 * self.fetch, 1)  # time before a stored byte is written
        self.poll = max(ticks["verify_poll"], self.fetch)
        self.timeout = ticks["verify_timeout"]
        self.drivers = {name: chip.drivers[name] for name in CONTROLS}
        self.value = MemoryRead(self)
        self.busy, self.request = chip.pins["busy"].net, chip.pins["io_request"].net

    # --------------------------------------------------------------------------------------------------------- memory
    async def read(self, address: int) -> int:
        """Return the memory byte at an address, 0 to 65535; FF if no memory answers."""
        start = await self._begin()
        if self.value.begin(start, address):
            await self.chip.at_tick(start + self.fetch)
            self.bits.bus_used()
            return self.value.byte
        self._select("xmem_sel", start)
        return await self._read(start, address & 0xFF, address >> 8)

    async def write(self, address: int, byte: int) -> bool:
        """Write a byte, then read it back until it is correct; return whether this succeeds within `verify_timeout`.

        Otherwise, the finding verify-timeout is reported, and the chip continues regardless (quirk
        CY545-UND-TIMEOUT).
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
        self.chip.finding("verify-timeout", f"address {address}: {byte:02X} was written, but {found:02X} was read back")
        return False

    # ------------------------------------------------------------------------------------------ switches and display
    async def digits(self, letter: str, count: int) -> list[int]:
        """Return the digits set on the thumbwheel switches for a command, most significant first, 0 to 15 each.

        The address of a digit is inferred (quirk CY545-UND-THUMB-ADDRESS): the low five bits of the letter and three
        bits that contain the number of the digit.

        Args:
            letter: the letter of the command.
            count: 3, 5 or 8, depending on the width of the number.
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
        """Write bytes to the display at ascending addresses (0 to 63) from `address` on, one HP_SEL cycle per byte."""
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
        """Return the clocks from the start of a cycle to a phase."""
        return self.fetch * phase // PHASES

    def ps(self, start: int, phase: int) -> int:
        """Return the instant (ps) of a phase of the cycle that begins at tick `start`."""
        return self.chip.clock.ps(start + self._at(phase))

    async def _begin(self) -> int:
        """Wait until the host has removed its byte from the bus; return the tick at which the cycle can begin.

        While BUSY is low, a host keeps its byte on the bus until it raises IO_REQUEST.  While BUSY is high, no
        host drives the bus, so there is nothing to wait for.
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
        """Promise one pulse of a select line, which lasts for a number of cycles."""
        self.drivers[pin].wave(*self.select_wave(pin, start, cycles))

    def _strobe(self, pin: str, start: int, rises: int) -> None:
        self.drivers[pin].wave(*self.strobe_wave(pin, start, rises))

    def _address(self, start: int, low: int, high: int | None, data: Level) -> None:
        """Promise both bytes of an address, the ALE pulse, and `data`, the level of the bus after the address."""
        self.drivers["ale"].wave(*self.ale_wave(start))
        self.chip.bus_driver.play(Wave(*self.bus_wave(start, low, high, data)))

    # ---------------------------------------------------------------------------- the waves of a cycle, from its start
    def select_wave(self, pin: str, start: int, cycles: int = 1) -> Edges:
        """Return the edges of a select line whose pulse lasts for a number of cycles."""
        rises = self.chip.clock.ps(start + self.fetch * (cycles - 1) + self._at(DESELECT))
        return self.drivers[pin].pulses(self.ps(start, SELECT), rises)

    def ale_wave(self, start: int) -> Edges:
        """Return the edges of ALE in a cycle."""
        return self.drivers["ale"].pulses(self.ps(start, LOW), self.ps(start, LATCH))

    def strobe_wave(self, pin: str, start: int, rises: int) -> Edges:
        """Return the edges of RD or WR in a cycle; `rises` is the phase at which the pulse ends."""
        return self.drivers[pin].pulses(self.ps(start, STROBE), self.ps(start, rises))

    def bus_wave(self, start: int, low: int, high: int | None, data: Level) -> Edges:
        """Return the levels driven on the data bus by the chip: one or two address bytes, and any byte it writes."""
        times = tuple(self.ps(start, phase) for phase in (0, LOW, DATA, READ))
        return None, times, (None if high is None else (0xFF, high), (0xFF, low), data, None)

    async def _read(self, start: int, low: int, high: int | None = None) -> int:
        """Run a read cycle and return its byte; the select line is driven by the caller."""
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
    by_address: bool  # its output depends only on the address in the latches

    def read(self) -> int | None:
        """Return the byte at the latched address; None if there is no byte."""


class MemoryRead(Leader[Exchange]):
    """The reader of memory bytes, which handles each read as one value.

    It provides all bus levels of the read in progress or, between two reads, of the last one.
    """

    def __init__(self, bus: LocalBus) -> None:
        super().__init__(bus.drivers["ale"].net)
        self.bus, self.chip = bus, bus.chip
        self.start = 0
        self.latched = 0, 0  # latches of the memory before the read in progress
        self.first = True  # the first read after the parts have watched the bus themselves
        self.sampled = 0xFF  # the byte sampled in the last read that was withdrawn

    def begin(self, start: int, address: int) -> bool:
        """Begin, at tick `start`, a read that is handled as one value; return False if this is not possible."""
        if self.chip.bus_driver.pending:  # a pending bit of the bus, which the cycle cancels
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
        """The byte that was read last."""
        if self.exchange is None or not self.exchange.by_value:
            return self.sampled
        return 0xFF if (byte := self.exchange.state[2]) is None else byte  # whatever would change it withdraws first

    # -------------------------------------------------------------------------------------------- conditions for values
    def made(self, ends: tuple[BusEnd, ...]) -> Exchange | None:
        """Return an `Exchange` that handles each memory read as one value; None if this is not possible.

        It is possible only if exactly one memory is on the bus, and the output of this memory depends only on
        the latched address.  `ends` are all parts on the bus.
        """
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
        """Return the memory's output levels in a read, given its first tick, the address and the byte there."""
        start, _, byte = state
        _, times, _ = self.bus.strobe_wave("rd", start, READ)
        return Wave(None, times, (None if byte is None else (0xFF, byte), None))

    def _withdrawn(self, seen: int) -> None:
        """Stop handling a read as one value, so that the parts on the bus act by themselves again.

        Each part gets the address that it would have latched by `seen` (ps).  The chip then samples the bus in
        real time.
        """
        read, latch = (self.bus.ps(self.start, phase) for phase in (READ, LATCH))
        memory, (high, low) = self.memory, self.latched
        if self.chip.kernel.now >= read:  # the chip samples before any change in that instant
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
