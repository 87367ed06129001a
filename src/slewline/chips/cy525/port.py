"""The command port of the CY525: bytes in by the two-line handshake, verify bytes out.

A byte comes in (fig. 7.3; times at 11 MHz):

    I/O REQUEST  ‾‾‾\\______________________/‾‾‾‾‾‾‾‾‾‾‾‾‾‾
    INSTROBE     ‾‾‾‾‾‾‾‾‾‾\\_/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾
    READY        ‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\\___________________/‾‾‾
                    |15 us   |1|10 us|   decoding, effect  |   READY waits for I/O REQUEST high, however long

The bus is read at the rising edge of INSTROBE.
"""

from __future__ import annotations

from ...core.net import Net, Wave
from ...core.waits import level, until
from . import sheet
from .readout import group_bytes
from .state import T
from .supply import Supply

STROBE, BUSY, LETTER = T["instrobe_delay"], T["busy_delay"], T["letter"]
SAMPLE = STROBE + T["strobe_width"]  # the bus is read at the rising edge of INSTROBE


class Port(Supply):
    """READY, I/O REQUEST, I/O SELECT, INSTROBE, OUTSTROBE and the data bus."""

    def watch_inputs(self) -> None:
        super().watch_inputs()
        if self._on_select not in self.select.observers:
            self.select.watch(self._on_select)

    def _on_select(self, _net: Net) -> None:
        if self.task is not None and self.ready.net.level == 0 and not self.motion.moving:
            self.finding("select-while-busy", "I/O SELECT changed while READY is low: it counts at the next READY")

    @property
    def unfinished(self) -> str:
        return self.decoder.unfinished

    async def next_byte(self) -> int:
        """Take the next byte from the bus; verify bytes are handed out meanwhile.

        I/O REQUEST and I/O SELECT are watched nets, so `value` is what a look sees.
        """
        request, kernel, ps = self.request, self.kernel, self.clock.ps
        while True:
            if request.value != 0:
                self.idle = self.pc is None
                text = (
                    "the rest of a command"
                    if not self.decoder.at_letter
                    else "a live command"
                    if self.live
                    else "a command"
                )
                self._waiting = (text, kernel.now)
                await level(request, 0)
                request = self.request  # before the first run, wiring may have made it another net
                self.idle = False
            elif request.changes == self.ended_wait and not self.live:
                self.waits("io_request=1, which ended a wait")
                await level(request, 1)  # it has had its effect; it brings no byte
                continue
            elif request.changes == self.unanswered:  # READY may have been high: it is low for motions only
                self.finding("request-while-running", "I/O REQUEST is still low as the program ends: it is served now")
            elif self.accepted >= 0 and not self.live:
                self.finding("early-request", "I/O REQUEST was lowered while READY was low: it is served now")
            self.requested = self.tick = tick = self.clock.ticks_from(kernel.now)
            if self.select.value == 1:
                await self.output_byte()
                continue
            self.tick = sampled = tick + SAMPLE
            at = ps(sampled)
            self.instrobe.wave(1, (ps(tick + STROBE), at), (0, 1))
            await until(kernel, at)
            if request.value == 1:
                self.finding("short-request", "I/O REQUEST rose before INSTROBE ended: the byte is lost")
                continue
            self.accepted = request.changes
            byte: int = self.bus.byte
            if self.decoder.at_letter:
                self.ascii = self.mode.level == 1
            self.tick = self.busy_from = sampled + BUSY
            self.busy_ps = busy = ps(sampled + BUSY)
            self._waiting = ("a byte in work", kernel.now)
            if self.motion_complete.net.value != 1:
                self.motion_complete.drive(1)
            await until(kernel, busy)
            self.ready.drive(0)
            return byte

    async def finish(self, tick: int) -> None:
        """End the handshake: READY returns at a tick, but not before I/O REQUEST has been high (s.7)."""
        if tick > self.tick:
            self.tick = tick
            await until(self.kernel, self.clock.ps(tick))
        request = self.request
        if request.changes > self.accepted:
            if request.changed_at < self.busy_ps:
                self.finding("short-request", "I/O REQUEST rose before READY fell; the byte counts")
        elif request.value == 0:
            self.waits("io_request=1 before READY returns")
            await level(request, 1)
            self.sync()
        self.ready.drive(1)

    async def output_byte(self) -> None:
        """Put the next byte of the verify group on the bus until I/O REQUEST rises (fig. 7.1)."""
        ps = self.clock.ps
        byte = self.next_output()
        self.accepted = self.request.changes
        strobe = self.tick + T["instrobe_delay"]
        width = T["strobe_width"]
        self.bus_driver.play(Wave(None, (ps(strobe - width),), ((0xFF, byte),)))
        self.outstrobe.play(Wave(1, (ps(strobe), ps(strobe + width)), (0, 1)))
        self.busy_from = strobe + width + T["busy_delay"]
        self.busy_ps = ps(self.busy_from)
        self.ready.wave(1, (self.busy_ps,), (0,))
        self.motion_complete.drive(1)
        self.waits("io_request=1 after a verify byte")
        await self.at_tick(self.busy_from + width)
        self.bus.resolve(self.kernel.seen)  # a host that drives the bus as well is found, whether anybody looks or not
        if self.request.changes > self.accepted and self.request.changed_at < ps(self.busy_from):
            self.finding("short-request", "I/O REQUEST rose before READY fell; the byte was on the bus all the same")
        if self.request.changes == self.accepted:
            await level(self.request, 1)
            self.sync()
        strobe = self.tick + T["instrobe_delay"]
        self.outstrobe.play(Wave(1, (ps(strobe), ps(strobe + width)), (0, 1)))
        self.bus_driver.play(Wave((0xFF, byte), (ps(strobe + width),), (None,)))
        await self.at_tick(strobe + width + T["busy_delay"])
        self.bus_driver.drive(None)
        self.ready.drive(1)

    def next_output(self) -> int:
        """The next byte of the group that V points at; FF where there is none."""
        if self.group is None:
            self.finding("verify-without-v", "a read-out without any V before: FF")
            return 0xFF
        if self.output is None:
            self.output = group_bytes(self, *self.group)
        if self.fetched >= len(self.output):
            self.finding("verify-overrun", f"group {self.group[0]} has {len(self.output)} bytes: FF")
            return 0xFF
        if self.group[0] == 1 and self.fetched == sheet.VERIFY_BYTES[1]:
            self.finding("verify-48", "the manual guarantees the first 48 bytes of the program")
        self.fetched += 1
        return self.output[self.fetched - 1]
