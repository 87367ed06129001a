r"""The serial side: RXD and TXD, at a baud rate set by two carriage returns (ch. 16, The Serial Interface).

    RXD   ‾‾\____/‾‾‾‾\____/‾‾‾‾‾‾‾‾‾\___________________/‾‾‾‾   a carriage return, at the level of the pin: TTL
            |0   |1   |2   |3        |5                  |9       its edges, in bits

The baud rate is measured over the nine bits from the first edge to the last.  CTS high makes the host wait.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

from ....core.datasheet.channel import AdaptiveLine
from ....core.time.timebase import PS_PER_S, Clock
from ....core.wires.characters import frames_of, transmit
from ....core.wires.receiver import Character, Receiver
from ....core.wires.serial import OVERSAMPLING, TTL, CharacterFormat, bit_clock
from ....core.wires.waiters import Event
from ....core.wires.waits import until
from ..sheet import BAUD_TOLERANCE

if TYPE_CHECKING:
    from ....core.context import ChipContext
    from ....core.time.kernel import Task
    from ....core.wires.net import Net
    from .user_bits import UserBits

ROOM = 3  # characters that the chip buffers while it is busy
EDGES = (0, 1, 2, 3, 5, 9)  # of a carriage return, in bits
LINE_FEED = (0, 2, 3, 4, 5, 9)
SKEW = 0.25  # tolerance of an edge, in bits


WAITING = "waiting for the rest of a command on RXD"


class CommandReader(Protocol):
    """The reader that assembles commands from the received characters."""

    def kept(self, data: bytes, at: int) -> int:
        """Return how many bytes of `data`, from index `at` on, the chip only stores; -1 if it acts on each one."""

    def keep(self, data: bytes) -> None:
        """Store bytes as counted by `kept`, in the command in progress."""


class SerialSide:
    """RXD, TXD and CTS; `buffer` contains the waiting characters, and `arrived` changes as a character arrives."""

    def __init__(self, chip: ChipContext, ticks: Mapping[str, int], bits: UserBits) -> None:
        self.chip, self.kernel, self.bits = chip, chip.kernel, bits
        channel = chip.sheet.through(AdaptiveLine)
        self.standard, self.word = channel.bauds, CharacterFormat(channel.bits, channel.parity, channel.stop)
        self.fixed_baud: int | None = chip.options.fixed_baud
        self.shortest, self.longest = (chip.clock.ps(ticks[f"{which}_bit"]) for which in ("shortest", "longest"))
        self.rxd, self.txd = chip.pins["rxd"].net, chip.drivers["txd"]
        self._event = Event(chip.kernel, f"{chip.name}.(serial)")
        self.listener: Task | None = None
        self.receiver: Receiver | None = None
        self.watching = self.reported = False
        self.buffer: deque[int] = deque()
        self.over_ps = 0  # the end of the stop bit of the last character
        self.clock: Clock | None = None  # of sixteen times the rate; None: not adapted
        self.edges: list[int] = []
        self.first_bit: float | None = None  # the bit of the first carriage return (ps)
        self.owned, self.free = False, True  # this side owns the chip; no side does
        self.reader: CommandReader

    @property
    def arrived(self) -> Net:
        """The net that changes whenever a character has arrived."""
        return self._event.net

    @property
    def rate(self) -> float | None:
        """The rate of reception and transmission, in baud; None before it has been measured."""
        return None if self.clock is None else self.clock.hz / OVERSAMPLING

    # ---------------------------------------------------------------------------------------------------------- reset
    def restart(self) -> None:
        """Restart as after reset: the next two carriage returns set the baud rate, unless it is fixed."""
        self.killed()
        self.rest(TTL)
        if self.fixed_baud is not None:
            self._listen_at(bit_clock(self.fixed_baud, self.chip.name))
            return
        self.watching, self.reported = True, False
        self.rxd.watch(self._edge)

    def killed(self) -> None:
        """Stop receiving, and discard the received characters."""
        if self.watching:
            self.rxd.unwatch(self._edge)
        if self.listener is not None:
            self.listener.kill()
        if self.receiver is not None:
            self.receiver.close()
        self.listener = self.receiver = self.clock = self.first_bit = None
        self.watching = False
        self.buffer.clear()
        self.edges.clear()

    def rest(self, level: int | None) -> None:
        """Drive a level on TXD; None releases TXD, because the supply is off."""
        self.txd.drive(level)

    def listening(self, on: bool) -> None:
        """Drive CTS low if `on`, so that the host may send; otherwise drive it high."""
        self.bits.clear_to_send(int(not on))

    def take(self) -> int:
        """Remove and return the oldest character in the buffer."""
        return self.buffer.popleft()

    # ------------------------------------------------------------------------------------------------------- adaption
    def _edge(self, net: Net) -> None:
        """Process an edge on RXD while the baud rate is not known."""
        level, edges = net.level, self.edges
        if self.clock is not None or level is None or (not edges and level == TTL):
            return
        edges.append(self.kernel.now)
        if len(edges) < len(EDGES):
            return
        bit = (edges[-1] - edges[0]) / EDGES[-1]
        if not self._looks_like(EDGES, bit):
            line_feed = self.first_bit is not None and self._looks_like(LINE_FEED, bit)
            del edges[:2]
            self.first_bit = None
            if self._is_unreported():
                came = (
                    "a line feed (\\n) between carriage returns"
                    if line_feed
                    else "characters before two carriage returns"
                )
                self.chip.finding("not-adapted", f"{came}: no rate is recognised; start with \\r\\r, without \\n")
            return
        edges.clear()
        first, self.first_bit = self.first_bit, bit
        if first is not None and abs(bit - first) <= BAUD_TOLERANCE * first:
            self._adapt((first + bit) / 2)

    def _looks_like(self, edges: tuple[int, ...], bit: float) -> bool:
        """Return whether the recorded edges match `edges`, the edges of a certain character.

        `edges` are in bits from the first edge; a bit lasts `bit` ps.
        """
        begin = self.edges[0]
        return all(abs(time - begin - at * bit) <= SKEW * bit for time, at in zip(self.edges, edges, strict=True))

    def _adapt(self, bit_ps: float) -> None:
        """Adopt the baud rate measured on two carriage returns, if the chip supports it."""
        rate = PS_PER_S / bit_ps
        fits = self.shortest * (1 - BAUD_TOLERANCE) <= bit_ps <= self.longest * (1 + BAUD_TOLERANCE)
        if not fits or all(abs(rate - standard) > BAUD_TOLERANCE * standard for standard in self.standard):
            slowest, fastest = (PS_PER_S / ps for ps in (self.longest, self.shortest))
            if self._is_unreported():
                self.chip.finding(
                    "wrong-rate",
                    f"two carriage returns at {rate:.0f} baud; the chip adapts to standard rates from {slowest:.0f} to "
                    f"{fastest:.0f} baud at {self.chip.crystal_hz / 1e6:g} MHz; set the host to one of these",
                )
            return
        self._listen_at(Clock(round(OVERSAMPLING * rate)))

    def _is_unreported(self) -> bool:
        """Return True only for the first call since the reset, so that only one failure to adapt is reported."""
        reported, self.reported = self.reported, True
        return not reported

    # ------------------------------------------------------------------------------------------------------------- in
    def _listen_at(self, clock: Clock) -> None:
        self.clock, self.frames = clock, frames_of(clock.hz, self.word, TTL)
        self.listener = self.kernel.spawn(self._listen, clock, name=f"{self.chip.name} listens")

    async def _listen(self, clock: Clock) -> None:
        if self.watching:  # not while an edge is reported: the next listener would be skipped
            self.watching = False
            self.rxd.unwatch(self._edge)
        self.receiver = Receiver(self.rxd, clock, self.word, TTL)
        await self.receiver.receive(self._receive, self._passed, self._acts)

    def _acts(self, data: bytes, at: int) -> int:
        """Return the index in `data`, at least `at`, of the next character on which the chip acts.

        While it waits for the rest of a command, it only stores characters that neither end the command nor are
        mistakes.  It acts on the first character of a command, which decides which side owns the chip; once it
        has that character, it has not processed it yet.
        """
        fresh = len(self.buffer)  # characters that the firmware takes in the next round
        if not self.chip.idle or fresh > min(at, 1) or not (self.owned or (fresh and self.free)):
            return at
        return max(at - fresh + self.reader.kept(data, at - fresh), at)

    def _passed(self, data: bytes) -> None:
        """Store characters of a command that have no fault."""
        self.reader.keep(data)
        if self.receiver is not None:
            self.over_ps = self.receiver.latest_ps
            self.chip.waits(WAITING, self.receiver.latest_ps)

    def one_by_one(self) -> None:
        """Take each character when it is complete, because the other side begins a command."""
        if self.receiver is not None:
            self.receiver.one_by_one()

    def catch_up(self) -> None:
        """Store the characters received up to now, so that a query of the chip's state includes them."""
        if self.receiver is not None:
            self.receiver.catch_up()

    def _receive(self, character: Character) -> None:
        self.over_ps = character.end_ps
        if character.framing_wrong:
            self.chip.finding("serial-framing", f"no stop bit after {character.byte:#04x}: the byte is lost")
        elif len(self.buffer) >= ROOM:
            self.chip.finding(
                "serial-overrun",
                f"{character.byte:#04x} arrived while {ROOM} characters were waiting, and is lost; pause between "
                "commands, or wait for CTS",
            )
        else:
            self.buffer.append(character.byte)
            self._event.set()

    @property
    def receiving(self) -> bool:
        """True while a character is being received."""
        return self.receiver is not None and self.receiver.receiving

    # ------------------------------------------------------------------------------------------------------------ out
    async def send(self, message: bytes) -> None:
        """Send characters; they are lost if no baud rate is known."""
        if self.clock is None:
            self.chip.finding("not-adapted", f"{message!r} is lost, because no baud rate was known yet")
            return
        chip = self.chip
        chip.waits("sending on TXD")
        await until(self.kernel, self.over_ps)
        await transmit(self.txd, self.frames, message)
        chip.sync_forward()
