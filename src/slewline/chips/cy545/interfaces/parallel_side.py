r"""The parallel side: bytes in and out over the data bus, a handshake each (ch. 16, The Parallel Handshake).

A byte of the host, and one for the host (times at 12 MHz):

    IO_REQUEST  ‾‾‾\__________/‾‾‾‾‾‾‾‾‾     FPL         ‾\__________________/‾‾‾‾‾   CY545: up before BUSY falls
    bus         --<   byte   >----------     IO_REQUEST  ‾‾‾\_________/‾‾‾‾‾‾‾‾‾‾‾‾
    BUSY        ‾‾‾‾‾‾‾\____________/‾‾‾     bus         ---<   byte  >------------
                   |25 µs|     |25 µs|       BUSY        ‾‾‾‾‾‾‾‾\_________/‾‾‾‾‾‾
                                                            |25 µs| |25 µs|

BUSY falls as an answer to the host and for nothing else: a host that has lowered IO_REQUEST takes it for that.  The
bus is that of memory, display and switches as well: the host drives it from its request to the fall of BUSY, and leaves
it open in the first handshake of a command that may meet a running program, which reads as FF.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ....core.datasheet.channel import FlowBus
from ....core.wires.waits import level, next_round

if TYPE_CHECKING:
    from ....core.context import ChipContext
    from .user_bits import UserBits

CR = 0x0D
EMPTY = 0xFF  # what a bus that nothing drives reads as, by its pull-ups


class ParallelPort:
    """IO_REQUEST, BUSY, FPL and the data bus, towards the host."""

    def __init__(self, chip: ChipContext, ticks: Mapping[str, int], bits: UserBits) -> None:
        self.chip, self.kernel, self.clock, self.ticks, self.bits = chip, chip.kernel, chip.clock, ticks, bits
        channel = chip.sheet.through(FlowBus)
        self.late = channel.ends == "after"  # FPL goes high after the rise of IO_REQUEST for the last byte
        self.bus, self.bus_driver, self.busy = chip.bus, chip.bus_driver, chip.drivers["busy"]
        self.request = chip.pins["io_request"].net
        self.request.latched = True  # `changes` and `changed_at` are what the chip goes by
        self.reset()

    def reset(self) -> None:
        """No byte is in progress; BUSY and FPL are high."""
        self.open = False  # BUSY is low for a byte of the host
        self.host_is_next = False  # the chip waits for IO_REQUEST, in the middle of a command or of a message
        self.served = -1  # changes of IO_REQUEST when that byte was asked for
        self.rest(True)
        self.bits.fpl(1)

    def rest(self, powered: bool) -> None:
        """Let BUSY be high, or go without supply; and let go of the bus."""
        self.busy.drive(self.busy.inactive_level if powered else None)
        self.bus_driver.drive(None)

    @property
    def asked(self) -> bool:
        """Does the host ask for a handshake that has not begun?"""
        return self.request.is_active and not (self.open and self.request.changes == self.served)

    # --------------------------------------------------------------------------------------------------------- bytes in
    async def byte(self, running: bool = False) -> int:
        """Answer the request that stands, and return the byte; -1: it was withdrawn before BUSY fell.

        Args:
            running: a program runs, so this is to be the empty handshake.
        """
        chip, request = self.chip, self.request
        fell, seen = request.changes, self.bus.byte
        chip.sync_forward()
        await chip.ticks(self.ticks["busy_delay"])
        if request.changes != fell:
            chip.finding("short-request", "IO_REQUEST rose before BUSY fell: the byte is lost")
            return -1
        byte: int = self.bus.byte
        if byte != seen:
            chip.finding("byte-changed", f"the byte changed from {seen:#04x} before BUSY fell; {byte:#04x} counts")
        if running and byte != EMPTY:
            chip.finding(
                "missing-ff",
                f"a program runs, and the first handshake brought {byte:#04x}; the host should leave the bus open",
            )
        self.busy.activate()
        self.open, self.served = True, fell
        chip.waits("handling a byte")
        return byte

    async def done(self, tick: int = 0) -> None:
        """End the handshake of the byte in progress, if there is one: BUSY rises, at a tick or later.

        It does not rise before IO_REQUEST has.
        """
        chip, request = self.chip, self.request
        await chip.at_tick(tick)
        if not self.open:
            return
        if request.changes == self.served:
            chip.waits("waiting for io_request=1 (then BUSY rises)")
            await self.until_request(False)
        rose = request.changed_at if request.changes == self.served + 1 else self.kernel.now
        chip.sync_forward()
        await chip.at_tick(self.clock.ticks_from(rose) + self.ticks["busy_end"])
        if request.is_active:
            chip.finding("early-request", "IO_REQUEST was lowered while BUSY was low: it is served now")
        self.open = False
        self.busy.deactivate()

    # -------------------------------------------------------------------------------------------------------- bytes out
    async def send(self, message: bytes, each: bool) -> None:
        """Give bytes to the host, for as long as it takes; a handshake in progress ends first.

        Args:
            each: FPL goes high after every byte (binary), else after each return and after the last byte.
        """
        for number, byte in enumerate(message, 1):
            self.bits.fpl(0)
            await self.done()
            while not await self._give(byte, each or byte == CR or number == len(message)):
                pass

    async def _give(self, byte: int, last: bool) -> bool:
        """Give a byte; False: the request was withdrawn before BUSY fell, so the host has not got it."""
        chip, request = self.chip, self.request
        chip.waits("waiting for io_request=0 (FPL is low: the host has to read)")
        await next_round(self.kernel)  # a host that asks already, with a letter, lets go of the bus as FPL falls
        await self.until_request(True)
        fell, delay, lead = request.changes, self.ticks["output_delay"], self.ticks["flow_lead"]
        chip.sync_forward()
        answer = chip.tick + delay
        self.bus_driver.drive((0xFF, byte))
        if last and not self.late:
            await chip.at_tick(answer - lead)
            self.bits.fpl(1)
        await chip.at_tick(answer)
        if request.changes != fell:
            chip.finding("short-request", "IO_REQUEST rose before BUSY fell: the byte is offered again")
            self.bus_driver.drive(None)
            self.bits.fpl(0)
            return False
        self.busy.activate()
        self.bus.resolve(
            self.kernel.seen
        )  # a host that drives the bus as well is found, whether anything samples it or not
        chip.waits("waiting for io_request=1 (the host has to read the byte on the bus)")
        await self.until_request(False)
        self.bus_driver.drive(None)
        self.bits.bus_used()
        chip.sync_forward()
        end = chip.tick + self.ticks["busy_end"]
        if last and self.late:
            await chip.at_tick(end - lead)
            self.bits.fpl(1)
        await chip.at_tick(end)
        self.busy.deactivate()
        if last:  # FPL is seen high, however soon there is more
            await chip.ticks(lead)
        return True

    async def until_request(self, active: bool) -> None:
        """Wait until the host has lowered IO_REQUEST, or raised it."""
        request, wanted = self.request.when_active if active else self.request.when_inactive
        self.host_is_next = request.level != wanted
        await level(request, wanted)
        self.host_is_next = False
