r"""The local bus: cycles on the data bus that reach memory, display and switches (ch.16).

    phase           0      1      2      3      4      5      6      7      8      9      10
    data bus        | high        | low         | read: nothing; write: the byte       |
    XMEM_SEL               \____________________________________________________/
    ALE                           /------\
    RD                                               \____________________/
    WR                                               \_____________/

Only the memory has a high address byte, which it takes as XMEM_SEL falls; low addresses are taken as ALE falls.  A
cycle takes `fetch` clocks, of which a phase is a tenth (inferred).  What a cycle does is promised as it begins; the
byte of a read is sampled just before RD rises.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ....core.wires.net import Level, Wave
from ....core.wires.waits import level, until

if TYPE_CHECKING:
    from ....core.context import ChipContext
    from .user_bits import UserBits

PHASES = 10  # of a cycle
SELECT, LOW, LATCH, DATA, STROBE, WRITTEN, READ, DESELECT = 1, 2, 3, 4, 5, 7, 8, 9
AT_REST = {"xmem_sel": 1, "sw_sel": 1, "ale": 0, "rd": 1, "wr": 1}
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
        self.drivers = {name: chip.drivers[name] for name in AT_REST}
        self.busy, self.request = chip.pins["busy"].net, chip.pins["io_request"].net

    # --------------------------------------------------------------------------------------------------------- memory
    async def read(self, address: int) -> int:
        """Return the byte that the memory has at an address, 0 to 65535; FF, where there is none."""
        start = await self._begin()
        self._select("xmem_sel", start)
        return await self._read(start, address & 0xFF, address >> 8)

    async def write(self, address: int, byte: int) -> bool:
        """Write a byte and read it back until it is right; returns whether it became so within `verify_timeout`.

        Finding verify-timeout: it did not; the chip goes on all the same (quirk CY545-UND-TIMEOUT).
        """
        await self.chip.ticks(self.before)
        start = await self._begin()
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

    def _ps(self, start: int, phase: int) -> int:
        """The instant of a phase, ps."""
        return self.chip.clock.ps(start + self._at(phase))

    async def _begin(self) -> int:
        """Return the tick of a cycle that begins now, once a host has its byte off the bus.

        A host that has been answered keeps its byte until it raises IO_REQUEST; one that has not leaves the bus open.
        """
        chip = self.chip
        if self.busy.level == 0 and self.request.level == 0:
            await level(self.request, 1)
            chip.sync_forward()
        await until(chip.kernel, chip.clock.ps(chip.tick))  # the count may be ahead of this instant
        return chip.tick

    async def _end(self, start: int) -> None:
        await self.chip.at_tick(start + self.fetch)
        self.bits.bus_used()

    def _select(self, pin: str, start: int, cycles: int = 1) -> None:
        """Promise a select line for so many cycles."""
        rises = self.chip.clock.ps(start + self.fetch * (cycles - 1) + self._at(DESELECT))
        self.drivers[pin].wave(1, (self._ps(start, SELECT), rises), (0, 1))

    def _strobe(self, pin: str, start: int, rises: int) -> None:
        self.drivers[pin].wave(1, (self._ps(start, STROBE), self._ps(start, rises)), (0, 1))

    def _address(self, start: int, low: int, high: int | None, data: Level) -> None:
        """Promise both bytes of an address, ALE, and what stands on the bus after them."""
        self.drivers["ale"].wave(0, (self._ps(start, LOW), self._ps(start, LATCH)), (1, 0))
        upper = None if high is None else (0xFF, high)
        times = [self._ps(start, phase) for phase in (LOW, DATA, READ)]
        self.chip.bus_driver.play(Wave(upper, tuple(times), ((0xFF, low), data, None)))

    async def _read(self, start: int, low: int, high: int | None = None) -> int:
        """A read cycle, but for its select line."""
        self._address(start, low, high, None)
        self._strobe("rd", start, READ)
        await self.chip.at_tick(start + self._at(READ))
        byte = self.chip.bus.byte
        await self._end(start)
        return byte
