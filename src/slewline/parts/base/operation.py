r"""An operation on a chipset's host port, given to the port as a whole instead of strobe by strobe.

The port processes all bytes in one call at the end of the operation, unless a strobe is observed.

HostSlct  ‾‾‾‾\________________________________________/‾‾‾‾‾‾‾
bus       ----<     high byte     X     low byte       >-------
HostWrite ‾‾‾‾‾‾‾‾‾‾‾‾‾\_____/‾‾‾‾‾‾‾\_____/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾   (in a read operation: HostRead)
call                                       |  here the port receives all bytes in one call

The levels of the operation's wires follow from its start, its kind, and its bytes (core/wires/exchange.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import NamedTuple, Protocol

from ...core.wires.exchange import End, Exchange, Leader
from ...core.wires.net import Driver, Wave
from ...core.wires.waits import next_round, until
from ...core.wires.wave import Edges, Level

NS = 1000  # picoseconds
SETTLE_PS, SETUP_PS, LOW_PS, GAP_PS, HOLD_PS = 10 * NS, 30 * NS, 80 * NS, 80 * NS, 80 * NS


class Strobes(NamedTuple):
    """Timing of a host's strobes: low time, high time between bytes, and whether the host waits for HostRdy high."""

    low_ps: int = LOW_PS
    gap_ps: int = GAP_PS
    ready: bool = True


class Strobed:
    """The instants of an operation (ps), and the levels of its lines; the strobe edges are computed on demand."""

    __slots__ = ("end", "first", "how", "last", "number", "start")

    def __init__(self, now: int, number: int, how: Strobes) -> None:
        self.number, self.how = number, how
        self.start = now + SETTLE_PS  # the port is selected
        self.first = self.start + SETUP_PS  # the first strobe falls
        self.last = self.first + number * (how.low_ps + how.gap_ps) - how.gap_ps  # the last one rises
        self.end = self.last + HOLD_PS  # the port is released

    @property
    def falls(self) -> list[int]:
        """Instants at which the strobe falls (ps), one per byte."""
        apart = self.how.low_ps + self.how.gap_ps
        return [self.first + n * apart for n in range(self.number)]

    @property
    def rises(self) -> list[int]:
        """Instants at which the strobe rises (ps), one per byte."""
        return [fall + self.how.low_ps for fall in self.falls]

    def strobe(self) -> Edges:
        """Return the edges of the strobe."""
        return 1, tuple(sorted((*self.falls, *self.rises))), (0, 1) * self.number

    def select(self) -> Edges:
        """Return the edges of HostSlct."""
        return 1, (self.start, self.end), (0, 1)

    def command(self) -> Edges:
        """Return the edges of HostCmd during an operation that is a command."""
        return 0, (self.start, self.end), (1, 0)

    def bus(self, data: bytes) -> Edges:
        """Return the edges of the bus while `data` is written; the byte changes halfway between two strobes."""
        changes = [rise + self.how.gap_ps // 2 for rise in self.rises[:-1]]
        return None, (self.start, *changes, self.end), (*((0xFF, byte) for byte in data), None)


class Taken(NamedTuple):
    """An operation that is given to the port as a whole; the levels of its lines follow from these attributes.

    Attributes:
        strobes: the instants of the operation.
        data: the bytes written; None: it is a read operation.
        command: whether the written byte is a command.
        answer: the bytes read; empty for a write operation.
    """

    strobes: Strobed
    data: bytes | None
    command: bool
    answer: bytes


class PortEnd(End, Protocol):
    """The host port of a chipset, as the answering end of a host's operations."""

    bus_driver: Driver
    access_ps: int  # from the falling edge of HostRead until a byte is on the bus
    let_go_ps: int  # from its rising edge until the byte is off the bus

    def takes(self, number: int, reading: bool, ps: int) -> bool:
        """Return whether the port can process, as a whole, an operation of `number` bytes that begins now.

        Args:
            number: the number of bytes.
            reading: whether it is a read operation; otherwise, it is a write operation.
            ps: the instant of its first strobe.
        """

    def shows(self, number: int) -> bytes:
        """Return the bytes that a read operation of `number` bytes would read now."""

    def operated(self, number: int, data: bytes | None, command: bool) -> None:
        """Process an operation whose last strobe ends now.

        Args:
            number: the number of bytes.
            data: the bytes written; None: it is a read operation.
            command: whether the written byte is a command.
        """

    def resume(self, falls: Sequence[int], rises: Sequence[int], data: bytes | None, over: bool) -> None:
        """Follow the pins from now on, in the middle of an operation.

        Args:
            falls, rises: the instants (ps) of the strobe edges so far.
            data: all bytes that the operation writes; None: it is a read operation.
            over: whether the port has already processed the operation.
        """


class HostLines(NamedTuple):
    """The drivers with which a host drives the host port of a chipset."""

    select: Driver
    command: Driver
    writing: Driver
    reading: Driver
    bus: Driver


class Operation(Leader[Exchange]):
    """The current or latest operation of a host on one chipset.

    Args:
        lines: the host's drivers on the chipset's host port.
    """

    chip: PortEnd

    def __init__(self, lines: HostLines) -> None:
        super().__init__(lines.select.net)
        self.lines, self.kernel = lines, lines.bus.kernel
        self.data: bytes | None = None  # bytes written; None: it is a read operation
        self.command = False
        self.strobes = Strobed(0, 0, Strobes())
        self.over = True  # the chipset has processed it
        self.shown = bytearray()  # bytes read
        self.waited = False  # the host waits for the end: the operation has not been cut short

    def begin(self, strobes: Strobed, data: bytes | None, command: bool = False) -> bool:
        """Begin, at this instant, an operation that the port processes as a whole; return False if impossible.

        Args:
            strobes: the instants of the operation.
            data: the bytes written; None: it is a read operation.
            command: whether the written byte is a command.
        """
        exchange = self.possible()
        if exchange is None or not self.chip.takes(strobes.number, data is None, strobes.first):
            return False
        answer = self.chip.shows(strobes.number) if data is None else b""
        if not exchange.begin(Taken(strobes, data, command, answer)):
            return False
        self.strobes, self.data, self.command, self.over = strobes, data, command, False
        self.shown[:] = answer
        return True

    async def take_place(self) -> bytes:
        """Wait until the operation has ended and the port is released; return the bytes read, b"" after a write."""
        strobes, exchange, self.waited = self.strobes, self.exchange, True
        try:
            await until(self.kernel, strobes.last)
            await next_round(self.kernel)  # the edge is seen, unless the drive of a wire changes in the same instant
            if exchange is not None and exchange.by_value:
                self._record_end()
            await until(self.kernel, strobes.end)
        finally:
            self.waited = False
        return bytes(self.shown)

    def promise(self, strobes: Strobed, data: bytes | None, command: bool = False) -> None:
        """Promise all edges of an operation, for a chipset that follows its pins; arguments as for `begin`."""
        self.leave()
        lines = self.lines
        lines.select.wave(*strobes.select())
        (lines.reading if data is None else lines.writing).wave(*strobes.strobe())
        if command:
            lines.command.wave(*strobes.command())
        if data is not None:
            lines.bus.wave(*strobes.bus(data))

    def _record_end(self) -> None:
        """Let the chipset process the whole operation, now that its last strobe has ended."""
        self.over = True
        self.chip.operated(self.strobes.number, self.data, self.command)

    # --------------------------------------------------------------------------------------------- operations as values
    def made(self, ends: tuple[PortEnd, ...]) -> Exchange | None:
        """Return an exchange between the host and the chipset.

        Return None if the operation cannot be given to the chipset as a whole.

        Args:
            ends: the host ports on the wires; there must be exactly one, and its bus must be the host's bus.
        """
        lines = self.lines
        if len(ends) != 1 or ends[0].bus_driver.net is not lines.bus.net:
            return None
        (self.chip,) = ends
        led = {
            lines.select: lambda taken: Wave(*taken.strobes.select()),
            lines.command: _command,
            lines.writing: lambda taken: _strobe(taken, taken.data is not None),
            lines.reading: lambda taken: _strobe(taken, taken.data is None),
            lines.bus: _bus,
        }
        answering = {self.chip.bus_driver: lambda taken: self._answer(taken, taken.strobes.end)}
        return Exchange(led, answering, ends, self._withdrawn)

    def _answer(self, taken: Taken, ps: int) -> Wave:
        """Return the levels that the chipset drives on the bus because of the strobe edges up to an instant (ps)."""
        if taken.data is not None:
            return Wave(None, (), ())
        edges: dict[int, Level] = {}
        for fall, rise, byte in zip(taken.strobes.falls, taken.strobes.rises, taken.answer, strict=False):
            if fall <= ps:
                edges[fall + self.chip.access_ps] = 0xFF, byte
            if rise <= ps:
                edges[rise + self.chip.let_go_ps] = None
        return Wave(None, tuple(edges), tuple(edges.values()))

    def _withdrawn(self, seen: int) -> None:
        """Let the chipset follow the pins from now on; the strobe edges up to the instant `seen` (ps) have taken place.

        In a read operation, the host still samples the bus at the ends of the remaining strobes.
        """
        falls, rises = self.strobes.falls, self.strobes.rises
        if seen >= self.strobes.end:
            return
        answer = self._answer(Taken(self.strobes, self.data, self.command, bytes(self.shown)), seen)
        if answer.times:
            self.chip.bus_driver.promise = answer
        over = [rise for rise in rises if rise <= seen]
        if len(over) == len(rises) and not self.over:
            self._record_end()
        self.chip.resume([fall for fall in falls if fall <= seen], over, self.data, self.over)
        if self.data is None and not self.over:
            del self.shown[len(over) :]
            for rise in rises[len(over) :]:
                if rise <= self.kernel.now:  # the host samples before anything changes in that instant
                    self._sample(self.strobes)
                else:
                    self.kernel.call_at(rise, partial(self._sample, self.strobes))

    def _sample(self, strobes: Strobed) -> None:
        """Sample the bus at the end of a strobe, unless the host's operation has been cut short."""
        if self.waited and strobes is self.strobes:
            self.shown.append(self.lines.bus.net.byte)  # type: ignore[attr-defined]


# --------------------------------------------------------------------------------------- levels of the host drivers
def _command(taken: Taken) -> Wave:
    return Wave(*taken.strobes.command()) if taken.command else Wave(0, (), ())


def _strobe(taken: Taken, its: bool) -> Wave:
    """Return the levels of HostWrite or HostRead: strobes if the operation uses this line (`its`), otherwise high."""
    return Wave(*taken.strobes.strobe()) if its else Wave(1, (), ())


def _bus(taken: Taken) -> Wave:
    """Return the levels that the host drives on the bus."""
    return Wave(None, (), ()) if taken.data is None else Wave(*taken.strobes.bus(taken.data))
