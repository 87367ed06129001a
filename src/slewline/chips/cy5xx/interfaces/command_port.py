r"""The command port: bytes in by the two-line handshake, verify bytes out.  No other object drives READY.

Reception of a byte (fig. 7.3; times of the CY525 at 11 MHz):

    I/O REQUEST  ‾‾‾\______________________/‾‾‾‾‾‾‾‾‾‾‾‾‾‾
    INSTROBE     ‾‾‾‾‾‾‾‾‾‾\_/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾
    READY        ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\___________________/‾‾‾
                    |15 µs   |1|10 µs|   decoding, effect  |   READY waits for I/O REQUEST high, however long

The bus is read at the rising edge of INSTROBE.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from ....core.context import ChipContext
from ....core.time.kernel import Task
from ....core.wires.handshake import Handshakes, HandshakeStage
from ....core.wires.handshaken_bytes import ByteTimes, HandshakenBytes
from ....core.wires.net import Level, Net, Wave
from ....core.wires.waits import first_of, level, suspended, until
from .family_lines import line_in, line_out
from .readout import ReadOut

COMMANDS = "a command", "a live command"


class BusDecoder(Protocol):
    """The decoder of the received bytes.

    Attributes:
        at_letter: True if a command begins with the next byte.
    """

    at_letter: bool

    def kept(self, data: bytes, at: int, ascii: bool) -> int:
        """Return how many bytes of `data`, from index `at` on, the chip would only store as part of a command."""


class BusPort:
    """The lines READY, I/O REQUEST, I/O SELECT, INSTROBE, OUTSTROBE, MOTION COMPLETE, and the data bus."""

    def __init__(self, chip: ChipContext, ticks: Mapping[str, int], readout: ReadOut) -> None:
        self.chip, self.kernel, self.clock, self.readout = chip, chip.kernel, chip.clock, readout
        self.bus, self.bus_driver = chip.bus, chip.bus_driver
        self.request, self.select = line_in(chip, "io_request"), line_in(chip, "io_select", 0)
        self.mode = line_in(chip, "ascii_binary")
        names = ("ready", "instrobe", "outstrobe", "motion_complete")
        self.ready, self.instrobe, self.outstrobe, self.motion_complete = (line_out(chip, name) for name in names)
        self.strobe, self.width, self.busy = (ticks[name] for name in ("instrobe_delay", "strobe_width", "busy_delay"))
        self.strobed = self.instrobe.active_level, self.instrobe.inactive_level  # at a strobe
        self.sample = self.strobe + self.width  # the bus is read at the rising edge of INSTROBE
        self.request.latched = self.select.latched = True  # `value` is the level at a sample
        self.ascii = True  # level of pin 36 at the command letter
        self.requested = self.busy_from = self.busy_ps = 0  # of the byte in progress: its request, READY low
        self.unanswered = -1  # count of changes of I/O REQUEST when it fell in a running program
        # Bytes sent as one value (handshake.py): their exchange, the bytes, how many of them the decoder has.
        self.byte_times = ByteTimes(self.strobe, self.sample, self.sample + self.busy, ticks["letter"])
        self.watches: tuple[tuple[Net, Callable[[Net], object]], ...] = ()
        self.awaited, self.watched_nets = (self.request.when_active,), (self.select, self.mode)
        self.decoder: BusDecoder
        self.keep: Callable[[bytes], None]  # adds bytes, as counted by `decoder.kept`, to the command
        self.exchange: Handshakes | None = None
        self.coming: HandshakenBytes | None = None
        self.read = self.byte = self.token = 0
        self.stage, self.awaiting, self.idle = HandshakeStage.AWAITED, False, False
        self.completed: Level = None  # level of MOTION COMPLETE until the first of these bytes
        self.request.ends = (self,)
        self.begin()

    def begin(self) -> None:
        """Discard the received bytes, for a reset."""
        if self.exchange is not None:
            self.exchange.withdraw()
        self.coming = None
        self.others: tuple[tuple[Net, int], ...] = ()  # inputs that end the wait for a command, each with its level
        self.accepted = self.ended_wait = -1  # changes of I/O REQUEST: with the last byte, when it ended U or W

    # ----------------------------------------------------------------------------------------------------------- READY
    def rest(self, powered: bool) -> None:
        """Drive READY high or, without supply, release it; in both cases, release the bus."""
        self.ready.drive(self.ready.active_level if powered else None)
        self.bus_driver.drive(None)

    def close(self) -> None:
        """Drive READY low, because the chip is busy with a motion."""
        self.ready.deactivate()

    def open(self) -> None:
        """Drive READY high, so that the next byte may arrive."""
        self.ready.activate()

    async def finish(self, tick: int) -> None:
        """End the handshake: READY rises at a tick or, if I/O REQUEST has not risen by then, when it does (s.7)."""
        chip, request = self.chip, self.request
        if tick > chip.tick:
            chip.tick = tick
            await until(self.kernel, self.clock.ps(tick))
        if request.changes > self.accepted:
            if request.changed_at < self.busy_ps:
                chip.finding("short-request", "I/O REQUEST rose before READY fell; the byte is valid")
        elif request.is_active:
            chip.waits("waiting for io_request=1 (then READY rises)")
            await level(*request.when_inactive)
            chip.sync()
        if self.exchange is not None:
            self.exchange.opens()
        else:
            self.ready.put(self.ready.active_level)

    # ------------------------------------------------------------------------------------------------------------ bytes
    async def next_byte(self, idle: bool, live: bool) -> int:
        """Output any verify bytes requested; return the next byte from the host.

        Return -1 if one of the inputs in the attribute `others` ends the wait for a command.

        Args:
            idle: the chip has nothing to do until the byte arrives.
            live: a running program waits for the byte, between two instructions.
        """
        chip, request, kernel, ps = self.chip, self.request, self.kernel, self.clock.ps
        while True:
            stage = HandshakeStage.AWAITED
            if request.value != request.active_level:
                chip.idle = idle
                letter = self.decoder.at_letter
                chip.waits(f"waiting for {COMMANDS[live]}" if letter else "waiting for the rest of a command")
                others, asked = self.others if letter else (), request.when_active
                if others:
                    woken = await first_of(kernel, None, asked, *others)
                    if woken is not None and woken is not request:
                        chip.idle = False
                        return -1
                else:
                    stage = await self._requested(asked)
                chip.idle = False
            elif request.changes == self.ended_wait and not live:
                chip.waits("waiting for io_request=1 (its low ended a wait)")
                await level(*request.when_inactive)  # it has had its effect and has no byte
                continue
            else:
                self.early(live)
            if stage is HandshakeStage.AWAITED:
                self.requested = chip.tick = tick = self.clock.ticks_from(kernel.now)
                if self.select.value == 1:
                    await self.output_byte()
                    continue
                chip.tick = tick + self.sample
                at = ps(chip.tick)
                self.instrobe.wave(self.strobed[1], (ps(tick + self.strobe), at), self.strobed)
                await until(kernel, at)
                stage = HandshakeStage.REQUESTED
            if stage is HandshakeStage.REQUESTED:
                if request.value == request.when_inactive[1]:
                    chip.finding("short-request", "I/O REQUEST rose before INSTROBE ended: the byte is lost")
                    continue
                self.byte = self.accept(self.decoder.at_letter)
                await until(kernel, self.busy_ps)
                stage = HandshakeStage.ACCEPTED
            if stage is HandshakeStage.ACCEPTED:
                self.ready.put(self.ready.inactive_level)
                stage = HandshakeStage.TAKEN
            if stage is HandshakeStage.TAKEN:
                return self.byte
            if stage is HandshakeStage.READ:
                await self.finish(self.requested + self.byte_times.kept)

    def early(self, live: bool) -> None:
        """Report an I/O REQUEST that is low before the chip begins to wait for it, if this is the host's mistake."""
        if self.request.changes == self.unanswered:  # READY may have been high: a program lowers it only for motions
            self.chip.finding("request-while-running", "I/O REQUEST is still low as the program ends: it is served now")
        elif self.accepted >= 0 and not live:
            self.chip.finding("early-request", "I/O REQUEST was lowered while READY was low: it is served now")

    def accept(self, letter: bool) -> int:
        """Read the byte on the bus and, for a letter, the mode pin; set `busy_ps`, the time (ps) of READY's fall."""
        chip = self.chip
        self.accepted = self.request.changes
        if letter:
            self.ascii = self.mode.level == 1
        chip.tick = self.busy_from = chip.tick + self.busy
        self.busy_ps = self.clock.ps(chip.tick)
        chip.waits("handling a byte")
        if self.motion_complete.at(self.kernel.seen) != self.motion_complete.inactive_level:
            self.motion_complete.deactivate()
        byte: int = self.bus.byte
        return byte

    # --------------------------------------------------------------------------------- bytes as a value (handshake.py)
    @property
    def task(self) -> Task:
        """The firmware task."""
        return self.chip.task  # type: ignore[return-value]  # only queried while the firmware waits

    @property
    def at_letter(self) -> bool:
        """True if a command begins with the next byte."""
        return self.decoder.at_letter

    async def _requested(self, asked: tuple[Net, int]) -> HandshakeStage:
        """Wait for I/O REQUEST, or for bytes that arrive together as one value (handshake.py).

        Return the stage that the handshake of the last byte has reached.
        """
        self.awaiting, self.stage, self.token = True, HandshakeStage.AWAITED, self.chip.task.token  # type: ignore[union-attr]
        try:
            await (level(*asked) if self.exchange is None else suspended())
        finally:
            self.awaiting = False
        if (coming := self.coming) is not None:  # not withdrawn
            self.reached(len(coming.data) - 1, HandshakeStage.TAKEN)
            self.counted(False)
            self.exchange.taken()  # type: ignore[union-attr]
        return self.stage

    def takes(self, data: bytes, at: int) -> int:
        """Return how many bytes of `data`, from index `at` on, the port accepts as one value; 0 if none.

        These bytes arrive together, without events for the edges of their handshakes (handshake.py).  The chip
        only stores them, except the last one, on which it acts.
        """
        if not self.awaiting or self.token != self.chip.task.token:  # type: ignore[union-attr]  # woken, and about to continue
            return 0
        if self.select.value == 1 or self.byte_times.kept <= self.byte_times.busy:
            return 0
        ascii = self.mode.level == 1 if self.decoder.at_letter else self.ascii
        return min(self.decoder.kept(data, at, ascii) + 1, len(data) - at)

    def begins(self, coming: HandshakenBytes) -> None:
        """Begin to receive bytes that are sent together, as one value (handshake.py)."""
        self.coming, self.read, self.idle, self.chip.idle = coming, 0, self.chip.idle, False
        if self.decoder.at_letter:
            self.ascii = self.mode.level == 1
        complete = self.motion_complete
        self.completed = complete.level if complete.promise is None else complete.at(self.kernel.seen)
        if self.completed != complete.inactive_level:  # until the first byte is read
            complete.wave(self.completed, (coming.instant(0, self.sample),), (complete.inactive_level,))

    def reached(self, number: int, stage: HandshakeStage) -> int | None:
        """Continue from a stage of the handshake of byte `number`; all bytes before that one have been received.

        Returns the time at which the firmware continues (ps); None if it waits for I/O REQUEST.
        """
        chip, coming, self.stage, self.awaiting = self.chip, self.coming, stage, stage is HandshakeStage.AWAITED
        self.coming = None
        if coming is None:
            return None
        self._keep(coming, number + (stage is HandshakeStage.READ))
        self._show_handshake(coming, number, stage not in (HandshakeStage.AWAITED, HandshakeStage.REQUESTED))
        self.requested = coming.tick + number * self.byte_times.kept
        if number == 0 and stage in (HandshakeStage.AWAITED, HandshakeStage.REQUESTED):
            self.motion_complete.drive(self.completed)
        if stage is HandshakeStage.AWAITED:
            chip.idle = self.idle
            return None
        if stage is HandshakeStage.REQUESTED:
            chip.tick = self.requested + self.sample
            return self.clock.ps(chip.tick)
        self.byte = coming.data[number]
        chip.tick = self.busy_from = self.requested + self.byte_times.busy
        self.busy_ps = self.clock.ps(chip.tick)
        return self.busy_ps

    def counted(self, low: bool) -> None:
        """Record how many times I/O REQUEST had changed when it fell for the last byte.

        If `low` is false, I/O REQUEST has risen since that fall; the rise is not counted.
        """
        self.accepted = self.request.changes - (not low)

    def catch_up(self) -> None:
        """Process the bytes received up to now, so that a query of the chip's state includes them."""
        coming, seen = self.coming, self.kernel.seen
        if coming is not None and coming.start <= seen:
            number, last = coming.current(seen), len(coming.data) - 1
            self._keep(coming, min(coming.passed(seen, self.byte_times.busy), last))
            self._show_handshake(coming, number, coming.instant(number, self.sample) <= seen)

    def _keep(self, coming: HandshakenBytes, number: int) -> None:
        """Pass the bytes before byte `number` to the decoder, except any that it already has."""
        if number > self.read:
            self.keep(coming.data[self.read : number])
            self.read = number

    def _show_handshake(self, coming: HandshakenBytes, number: int, accepted: bool) -> None:
        """Set the text that describes the handshake of byte `number`, which has been read if `accepted` is True."""
        if accepted:
            self.chip.waits("handling a byte", coming.instant(number, self.sample))
        elif number:
            self.chip.waits("waiting for the rest of a command", coming.request_of(number))

    async def output_byte(self) -> None:
        """Output the next byte of the verify group on the bus until I/O REQUEST rises (fig. 7.1)."""
        chip, request, ps, width = self.chip, self.request, self.clock.ps, self.width
        byte = self.readout.next()
        self.accepted = request.changes
        strobe = chip.tick + self.strobe
        self.bus_driver.play(Wave(None, (ps(strobe - width),), ((0xFF, byte),)))
        self.outstrobe.strobe(ps(strobe), ps(strobe + width))
        self.busy_from = strobe + width + self.busy
        self.busy_ps = ps(self.busy_from)
        self.ready.wave(self.ready.active_level, (self.busy_ps,), (self.ready.inactive_level,))
        self.motion_complete.deactivate()
        chip.waits("waiting for io_request=1 (after a verify byte)")
        await chip.at_tick(self.busy_from + width)
        self.bus.resolve(self.kernel.seen)  # detects a host that drives the bus too, even if nothing samples the bus
        if request.changes > self.accepted and request.changed_at < self.busy_ps:
            chip.finding("short-request", "I/O REQUEST rose before READY fell; the byte was on the bus nevertheless")
        if request.changes == self.accepted:
            await level(*request.when_inactive)
            chip.sync()
        strobe = chip.tick + self.strobe
        self.outstrobe.strobe(ps(strobe), ps(strobe + width))
        self.bus_driver.play(Wave((0xFF, byte), (ps(strobe + width),), (None,)))
        await chip.at_tick(strobe + width + self.busy)
        self.bus_driver.drive(None)
        self.ready.activate()

    # ---------------------------------------------------------------------------------------- requests without a byte
    def ignore(self) -> None:
        """Ignore the present request, made while a program runs; record it, as it may outlast the program."""
        self.unanswered = self.request.changes

    def spend(self, handshake: bool) -> None:
        """Treat the present request as answered, because it has ended a wait (U or W) and carries no byte.

        If `handshake` is True, READY rises only after the request has ended.
        """
        self.ended_wait = self.request.changes
        if handshake:
            self.accepted = self.ended_wait

    # ------------------------------------------------------------------------------------------------------ in motion
    def taken(self) -> int:
        """Return the byte that is on the bus now, and output one INSTROBE pulse."""
        byte: int = self.bus.byte
        end = self.clock.ps(self.chip.tick + self.width)
        self.instrobe.strobe(self.kernel.now, end)
        return byte

    def show(self, word: int, delay: int, apart: int) -> None:
        """Output a word on the bus: high byte, low byte, each with OUTSTROBE; MOTION COMPLETE low marks the low byte.

        Args:
            delay: clocks from now to the first strobe.
            apart: clocks between the two strobes.
        """
        ps, width = self.clock.ps, self.width
        high = self.chip.tick + delay
        low = high + apart
        falls = high + apart // 2  # MOTION COMPLETE, between the two strobes
        self.outstrobe.strobe(ps(high), ps(high + width), ps(low), ps(low + width))
        self.motion_complete.strobe(ps(falls), ps(falls + apart))
        levels = ((0xFF, word >> 8), (0xFF, word & 0xFF), None)
        self.bus_driver.play(Wave(None, (ps(high), ps(falls), ps(falls + apart)), levels))
