r"""The parallel side: bytes in and out over the data bus, with a handshake for each (ch. 16, The Parallel Handshake).

A byte from the host (left), and a byte to the host (right), with times at 12 MHz:

    IO_REQUEST  ‾‾‾\__________/‾‾‾‾‾‾‾‾‾     FPL         ‾\__________________/‾‾‾‾‾   CY545: up before BUSY falls
    bus         --<   byte   >----------     IO_REQUEST  ‾‾‾\_________/‾‾‾‾‾‾‾‾‾‾‾‾
    BUSY        ‾‾‾‾‾‾‾\____________/‾‾‾     bus         ---<   byte  >------------
                   |25 µs|     |25 µs|       BUSY        ‾‾‾‾‾‾‾‾\_________/‾‾‾‾‾‾
                                                            |25 µs| |25 µs|

BUSY falls only as an answer to the host: a host that has lowered IO_REQUEST takes any falling edge as the answer.  The
bus also connects memory, display and switches, so the host drives it only from its request until BUSY falls.  If a
program may be running when a command arrives, the host does not drive the bus in the first handshake of that command;
an undriven bus reads as FF.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Protocol

from ....core.datasheet.channel import FlowBus
from ....core.wires.handshake import Handshakes, HandshakeStage
from ....core.wires.handshaken_bytes import ByteTimes, HandshakenBytes
from ....core.wires.waits import first_of, level, next_round, suspended, until

if TYPE_CHECKING:
    from ....core.context import ChipContext
    from ....core.time.kernel import Task
    from ....core.wires.net import Net
    from .user_bits import UserBits

CR = 0x0D
LETTER, REST = "a command letter", "the rest of a command on the bus"
RISE = "waiting for io_request=1 (then BUSY rises)"
EMPTY = 0xFF  # value of an undriven bus, by its pull-ups


class FlowReader(Protocol):
    """A reader that assembles commands from the received bytes."""

    @property
    def at_letter(self) -> bool:
        """True if a command begins with the next byte."""

    def kept(self, data: bytes, at: int) -> int:
        """Return how many bytes of `data`, from index `at` on, the chip would only store as part of a command.

        Return -1 if the bytes must arrive singly, not combined into one value (handshake.py).
        """


class ParallelPort:
    """The chip's side of the parallel interface to the host: IO_REQUEST, BUSY, FPL and the data bus."""

    def __init__(self, chip: ChipContext, ticks: Mapping[str, int], bits: UserBits) -> None:
        self.chip, self.kernel, self.clock, self.ticks, self.bits = chip, chip.kernel, chip.clock, ticks, bits
        channel = chip.sheet.through(FlowBus)
        self.late = channel.ends == "after"  # FPL goes high after the rise of IO_REQUEST for the last byte
        self.bus, self.bus_driver, self.busy = chip.bus, chip.bus_driver, chip.drivers["busy"]
        self.request = chip.pins["io_request"].net
        self.request.latched = True  # the chip uses `changes` and `changed_at`
        # Bytes sent as one value (handshake.py): their exchange, the bytes, and the bytes received but not yet used.
        delay = ticks["busy_delay"]
        self.byte_times = ByteTimes(delay, delay, delay, delay + ticks["busy_end"])
        self.ready, self.instrobe = self.busy, None
        self.watches: tuple[tuple[Net, Callable[[Net], object]], ...] = ()
        self.awaited: tuple[tuple[Net, int | None], ...] = ()
        self.watched_nets: tuple[Net, ...] = ()
        self.reader: FlowReader
        self.exchange: Handshakes | None = None
        self.request.ends = (self,)
        self.reset()

    def reset(self) -> None:
        """Discard the byte in progress; drive BUSY and FPL high."""
        if self.exchange is not None:
            self.exchange.withdraw()
        self.coming: HandshakenBytes | None = None
        self.come: deque[int] = deque()
        self.halfway: tuple[int, int, int] | None = None  # a requested byte: tick, byte, changes
        self.rose: int | None = None  # when IO_REQUEST rose for a byte that the chip has already processed (ps)
        self.stage, self.awaiting, self.first, self.token = HandshakeStage.AWAITED, False, False, 0
        self.open = False  # BUSY is low for a byte from the host
        self.host_is_next = False  # the chip waits for IO_REQUEST, in the middle of a command or of a message
        self.served = -1  # changes of IO_REQUEST when that byte was requested
        self.rest(True)
        self.bits.fpl(1)

    def rest(self, powered: bool) -> None:
        """Drive BUSY high or, without supply, release it; release the bus in either case."""
        self.busy.drive(self.busy.inactive_level if powered else None)
        self.bus_driver.drive(None)

    @property
    def asked(self) -> bool:
        """True while the host requests a handshake that the chip has not begun."""
        if self.come or self.halfway:
            return True
        if self.exchange is not None:  # all bytes arrive as one value
            return False
        return self.request.is_active and not (self.open and self.request.changes == self.served)

    # --------------------------------------------------------------------------------------------------------- bytes in
    async def byte(self, running: bool = False) -> int:
        """Answer the active request, and return the byte; -1 if the request was withdrawn before BUSY fell.

        Args:
            running: a program runs, so this must be the empty handshake.
        """
        chip, request = self.chip, self.request
        if self.come:
            return self._take()
        fell, seen = request.changes, self.bus.byte
        if self.halfway is None:
            chip.sync_forward()
        else:
            (chip.tick, seen, fell), self.halfway = self.halfway, None
        await chip.ticks(self.ticks["busy_delay"])
        if request.changes != fell:
            chip.finding("short-request", "IO_REQUEST rose before BUSY fell: the byte is lost")
            return -1
        byte: int = self.bus.byte
        if byte != seen:
            chip.finding("byte-changed", f"the byte changed from {seen:#04x} before BUSY fell; {byte:#04x} is used")
        if running and byte != EMPTY:
            chip.finding(
                "missing-ff",
                f"byte {byte:#04x} in the first handshake while a program runs; the host should not drive the bus then",
            )
        self.busy.activate()
        self.open, self.served = True, fell
        chip.waits("handling a byte")
        return byte

    async def done(self, tick: int = 0) -> None:
        """End the handshake of the byte in progress, if there is one: BUSY rises, at `tick` or later.

        BUSY never rises before IO_REQUEST does.
        """
        chip, request = self.chip, self.request
        await chip.at_tick(tick)
        if not self.open:
            return
        if self.exchange is not None and self.kernel.seen < self.kernel.now == request.changed_at:
            await next_round(self.kernel)  # by then the host has answered, or another output keeps IO_REQUEST low
        if request.changes == self.served:
            chip.waits(RISE)
            await self.until_request(False)
        rose, self.rose = self.rose, None
        if rose is None:
            rose = request.changed_at if request.changes == self.served + 1 else self.kernel.now
        chip.sync_forward()
        if (end := self.clock.ticks_from(rose) + self.ticks["busy_end"]) >= chip.tick:
            chip.tick = end
            await until(self.kernel, self.clock.ps(end))
        self.open = False
        if self.exchange is not None:
            self.exchange.opens()
            return
        if request.is_active:
            chip.finding("early-request", "IO_REQUEST was lowered while BUSY was low: it is served now")
        self.busy.deactivate()

    # --------------------------------------------------------------------------------- bytes as a value (handshake.py)
    @property
    def task(self) -> Task:
        """The firmware task."""
        return self.chip.task  # type: ignore[return-value]  # only queried while the firmware waits

    @property
    def at_letter(self) -> bool:
        """True if a command begins with the next byte."""
        return self.reader.at_letter

    async def requested(self, *others: tuple[Net, int | None]) -> None:
        """Wait between two bytes until the host has lowered IO_REQUEST, or an input of `others` reaches its level.

        For an input with level None, any change ends the wait.  During this wait, several bytes may arrive
        together, as one value (handshake.py).
        """
        request = self.request
        self.awaited, self.first = (request.when_active, *others), bool(others)
        self.host_is_next = not others and not request.is_active
        self.awaiting, self.token = True, self.task.token
        try:
            await (suspended() if self.exchange is not None else first_of(self.kernel, None, *self.awaited))
        finally:
            self.awaiting = self.host_is_next = False
        if (coming := self.coming) is not None:  # not withdrawn
            self.reached(len(coming.data) - 1, HandshakeStage.TAKEN)
            self.counted(False)
            self.exchange.taken()  # type: ignore[union-attr]

    def takes(self, data: bytes, at: int) -> int:
        """Return how many bytes of `data`, from index `at` on, the port accepts as one value; 0 if none.

        These bytes arrive together, without events for the edges of their handshakes (handshake.py).  The chip
        only stores them, except the last one, on which it acts.
        """
        if not self.awaiting or self.token != self.task.token:  # woken, and about to continue
            return 0
        if self.first is not self.at_letter or self.bits.shared == "CTS":
            return 0
        return min(self.reader.kept(data, at) + 1, len(data) - at)

    def begins(self, coming: HandshakenBytes) -> None:
        """Begin to receive bytes that are sent together, as one value (handshake.py)."""
        self.coming, self.was_idle = coming, self.chip.idle
        self.chip.idle = self.host_is_next = False

    def reached(self, number: int, stage: HandshakeStage) -> int | None:
        """Continue from a stage of the handshake of byte `number`; all bytes before that one have been received.

        Returns the time at which the firmware continues (ps); None if it waits for IO_REQUEST.
        """
        chip, coming, self.stage = self.chip, self.coming, stage
        self.coming, self.awaiting = None, stage is HandshakeStage.AWAITED and number == 0
        if coming is None:
            return None
        taken = stage in (HandshakeStage.READ, HandshakeStage.TAKEN)
        self.come.extend(coming.data[: number + taken])
        self._show_handshake(coming, number, taken)
        tick = coming.tick + number * self.byte_times.kept
        if stage is HandshakeStage.AWAITED:
            if self.awaiting:
                chip.idle, self.host_is_next = self.was_idle, not self.first
                return None
            chip.tick = tick
        elif taken:
            chip.tick = tick + self.byte_times.busy
            busy = coming.instant(number, self.byte_times.busy)
            self.rose = busy if stage is HandshakeStage.READ and busy <= self.kernel.seen else None
        else:
            self.halfway = tick, coming.data[number], self.request.changes
        return self.kernel.now

    def counted(self, low: bool) -> None:
        """Record how many times IO_REQUEST had changed when it fell for the last byte.

        If `low` is false, IO_REQUEST has risen since that fall; the rise is not counted.
        """
        self.served = self.request.changes - (not low)

    def _take(self) -> int:
        byte = self.come.popleft()
        if not self.come:
            self.open = self.stage in (HandshakeStage.READ, HandshakeStage.TAKEN)
        return byte

    def kept(self) -> bytes:
        """Remove and return all bytes that have arrived as one value, except the last one, on which the chip acts."""
        return bytes([self.come.popleft() for _ in range(len(self.come) - 1)])

    def catch_up(self) -> str:
        """Return, as text, the bytes received up to now that the firmware has not used yet, without a leading FF.

        The text that describes the progress of the handshake is brought up to date as well.
        """
        coming, seen, before = self.coming, self.kernel.seen, bytes(self.come).removeprefix(b"\xff").decode("latin-1")
        if coming is None or coming.start > seen:
            return before
        number = coming.current(seen)
        taken = coming.passed(seen, self.byte_times.busy)
        self._show_handshake(coming, number, taken > number)
        return coming.data[:taken].removeprefix(b"\xff").decode("latin-1")

    def _show_handshake(self, coming: HandshakenBytes, number: int, taken: bool) -> None:
        """Set the text that describes the progress of the handshake of byte `number`."""
        if taken:
            self.chip.waits(RISE, coming.instant(number, self.byte_times.busy))
        elif number:
            what = LETTER if coming.data[:number] == b"\xff" else REST
            self.chip.waits(f"waiting for {what}", coming.request_of(number))

    # -------------------------------------------------------------------------------------------------------- bytes out
    async def send(self, message: bytes, each: bool) -> None:
        """Send bytes to the host, however long this takes; a handshake in progress is completed first.

        Args:
            each: FPL goes high after every byte (binary); otherwise after each carriage return and after the last byte.
        """
        for number, byte in enumerate(message, 1):
            self.bits.fpl(0)
            await self.done()
            while not await self._give(byte, each or byte == CR or number == len(message)):
                pass

    async def _give(self, byte: int, last: bool) -> bool:
        """Send a byte; return whether the host received it.

        The host has not received the byte if it withdrew its request before BUSY fell.
        """
        chip, request = self.chip, self.request
        chip.waits("waiting for io_request=0 (FPL is low: the host has to read)")
        await next_round(self.kernel)  # a host with a request (a letter) already active releases the bus as FPL falls
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
        self.bus.resolve(self.kernel.seen)  # detects a host that drives the bus too, even if nothing samples the bus
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
        if last:  # FPL is seen high, however soon more follows
            await chip.ticks(lead)
        return True

    async def until_request(self, active: bool) -> None:
        """Wait until the host has lowered IO_REQUEST or, if not `active`, raised it."""
        request, wanted = self.request.when_active if active else self.request.when_inactive
        self.host_is_next = request.level != wanted
        await level(request, wanted)
        self.host_is_next = False
