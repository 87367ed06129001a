r"""Bytes sent over a two-line handshake by value: the edges of all bytes of a command follow from its start.

    I/O REQUEST  ‾‾\______/‾‾‾\______/‾‾‾\______/‾‾‾‾‾‾‾‾‾‾‾‾‾‾     driven by the host
    INSTROBE     ‾‾‾‾\_/‾‾‾‾‾‾‾‾\_/‾‾‾‾‾‾‾‾\_/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾
    READY        ‾‾‾‾‾‾‾‾\_/‾‾‾‾‾‾‾‾\_/‾‾‾‾‾‾‾‾\____________/‾‾
    bytes            R   |       5  |      CR   |           |
    value          start                      taken       opened

A chip takes the same time for every byte that it only stores, and a host without delay responds to every
edge at the same instant; so all edges follow from the start, and neither end is woken until the last
byte is accepted.  Acting on the last byte takes time; READY returns high when the chip has finished.

A withdrawn exchange continues edge by edge (exchange.py): host and chip then wait for the edges that
come next.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, Protocol

from ..time.kernel import Task
from ..time.timebase import Clock
from .exchange import End, Exchange, PastExchanges, Shown
from .handshaken_bytes import ByteTimes, HandshakenBytes
from .net import Driver, Net
from .past_handshakes import ManyCommands, PastHandshakes
from .waits import suspended
from .wave import Promise, Wave


class HandshakeStage(Enum):
    """A chip's progress with a byte."""

    AWAITED = "it waits for the request"
    REQUESTED = "it waits for the end of INSTROBE"
    ACCEPTED = "it waits for the fall of READY"
    TAKEN = "READY has fallen"
    READ = "READY has fallen, and the byte has been processed"


class SendingEnd(Protocol):
    """The host's end, which sends bytes."""

    request: Driver
    bus: Driver

    def awaits(self, number: int, low: bool) -> tuple[tuple[Net, int], ...]:
        """Return the pairs (net, level) for which the host waits after `number` bytes; the first to occur wakes it.

        Args:
            low: True if I/O REQUEST is already low for the next byte; False if it is still high.
        """


class TakingEnd(End, Protocol):
    """The chip's end, which accepts bytes.

    Attributes:
        awaiting: True while the chip waits for I/O REQUEST.
        awaited: the pairs (net, level) that end this wait.
        token: the token of the chip's task when it began to wait.
        watched_nets: the nets, other than I/O REQUEST, on whose levels the chip depends.
        instrobe: the output that shows when the bus is read; None if the chip has none.
        exchange: the exchange in which bytes currently arrive by value; None if there is none.
    """

    awaiting: bool
    token: int
    awaited: tuple[tuple[Net, int | None], ...]
    watched_nets: tuple[Net, ...]
    request: Net
    ready: Driver
    instrobe: Driver | None
    byte_times: ByteTimes
    clock: Clock
    exchange: Handshakes | None

    @property
    def task(self) -> Task:
        """The chip's task, while it waits."""

    @property
    def at_letter(self) -> bool:
        """True if the next byte begins a command."""

    def takes(self, data: bytes, at: int) -> int:
        """Return how many bytes, starting at index `at`, the chip takes by value; it acts only on the last."""

    def begins(self, coming: HandshakenBytes) -> None:
        """Prepare for bytes whose transfer begins now."""

    def reached(self, number: int, stage: HandshakeStage) -> int | None:
        """Store the bytes before byte `number`, and set the handshake of byte `number` to a stage.

        Return the instant (ps) at which the chip's task continues; None if it waits for the next request.
        """

    def counted(self, low: bool) -> None:
        """Record how often I/O REQUEST has changed, up to and including its fall for the last byte.

        Args:
            low: True if I/O REQUEST is still low; False if it has risen since that fall.
        """


class Handshakes(Exchange):
    """The handshakes between a host and a chip, made by value.

    Args:
        host, chip: the ends.
        kind: the class that computes the edges of many commands of the host together.

    Attributes:
        over: True if the last byte has been accepted; the chip may still need time to act on it.
        through: the number of bytes that the host had completed when its wait ended.
        gone: the number of bytes that the host had completed when the exchange was withdrawn.
        low: True if, at that withdrawal, I/O REQUEST was already low for the next byte.
    """

    def __init__(self, host: SendingEnd, chip: TakingEnd, kind: type[ManyCommands] = ManyCommands) -> None:
        shown: dict[Driver, Callable[[Any], Any]] = {  # of a `HandshakenBytes` its wave, of `ManyCommands` the edges
            host.request: lambda coming: coming.request(),
            host.bus: lambda coming: coming.bus(),
            chip.ready: lambda coming: coming.ready(),
        }
        if chip.instrobe is not None:
            active = chip.instrobe.active_level
            shown[chip.instrobe] = lambda coming: coming.strobe(active)
        super().__init__({}, shown, (chip,), self._left)
        self.host, self.chip, self.kind = host, chip, kind
        self.over, self.gone, self.low, self.through = True, 0, False, 0
        self.sender: Task | None = None  # the host's task, which waits for the end, or for READY
        self.woken = self.sending = False  # it has been woken; it waits for the end
        self.watched_nets: tuple[Net, ...] = ()

    # -------------------------------------------------------------------------------------------------------- by value
    @property
    def opened(self) -> bool:
        """True if the exchange is still made by value, and READY has returned high after the last byte."""
        return self.by_value and self.state.opened is not None

    def send(self, coming: HandshakenBytes) -> bool:
        """Send bytes now; return whether they are sent by value."""
        if not self.begin(coming):
            return False
        self.over = False
        self.chip.begins(coming)
        self.kernel.wake_at(coming.last, self.chip.task)
        return True

    @property
    def in_flight(self) -> int:
        """The number of bytes that the host has completed while waiting for the last; 0 if it does not wait."""
        if not self.sending:
            return 0
        return self.state.passed(self.kernel.seen, self.state.times.busy) if self.by_value else self.gone

    async def end(self) -> None:
        """Wait, in the host's task, until the handshake of the last byte ends.

        If the host releases the bus after the last byte, the handshake ends when READY falls for this byte;
        otherwise, it ends when READY is high again.
        """
        self.sender, self.woken, self.sending = self.kernel.current(), False, True
        try:
            await suspended()
        finally:
            whole = self.woken and self.by_value
            self.through, self.sending = len(self.state.data) if whole else self.in_flight, False
            self.sender = None

    async def reopened(self) -> None:
        """Wait, in the host's task, until READY is high again after the last byte."""
        self.sender, self.woken = self.kernel.current(), False
        try:
            await suspended()
        finally:
            self.sender = None

    def taken(self) -> None:
        """Record that the last byte is accepted now (called by the chip)."""
        self.over = True
        self.chip.request.changed_at = self.state.last
        if self.state.released:
            self._wake_sender()

    def opens(self) -> None:
        """Record that READY returns high now (called by the chip)."""
        self.state.opened = self.kernel.now
        self._wake_sender()

    def _wake_sender(self) -> None:
        if (sender := self.sender) is not None:
            self.woken = True
            self.kernel.wake(sender)

    def allows_wait(self, net: Net) -> bool:
        self.awaited = self.state.last <= self.kernel.seen and net.root is not self.chip.ready.net
        return self.awaited

    def past(self, net: Net, shown: Sequence[Shown]) -> Promise:
        return PastHandshakes(PastExchanges(net, shown, self.starts, self.states), self.kind)

    # ---------------------------------------------------------------------------------------------------- edge by edge
    def _enter(self) -> bool:
        chip = self.chip
        watched_nets = {net.root: None for net in chip.watched_nets}
        for root in (*(line.driver.net for line in self.answering), *watched_nets):
            for net in root.joined or (root,):
                if net.exchange is not None:
                    net.exchange.withdraw()
        if any(root.promise is not None or root.pending_drivers for root in watched_nets):
            return False
        chip.request.latched = False
        chip.task.token += 1  # it waits for nothing on the wires
        chip.token = chip.task.token
        if not super()._enter():
            self._watch_request(True)
            return False
        chip.exchange, chip.request.changes = self, chip.request.changes + 2  # of one byte at least
        for root in watched_nets:
            for net in root.joined or (root,):
                net.exchange = self
            root.sort_drivers()
        self.watched_nets = tuple(watched_nets)
        return True

    def _watch_request(self, awaited: bool) -> None:
        """Make the chip watch I/O REQUEST; if `awaited`, make the chip's task wait for the pairs in `chip.awaited`."""
        chip = self.chip
        chip.request.latched = True
        if awaited:
            for net, wanted in chip.awaited:
                net.register(chip.task, wanted)

    def withdraw(self) -> None:
        chip, coming, seen = self.chip, self.state, self.kernel.seen
        for root in self.watched_nets:
            for net in root.joined or (root,):
                net.exchange = None
            root.sort_drivers()
        super().withdraw()
        chip.exchange = None
        self.gone = coming.passed(seen, coming.times.busy)
        self.low = self.gone <= coming.current(seen)
        chip.request.changed_at = coming.latest_edge(seen)
        awaited = chip.awaiting and (self.over or self._resume(coming, seen))
        chip.counted(self.low)
        self._watch_request(awaited)
        self.over = True
        if (sender := self.sender) is not None and not self.woken:
            for net, wanted in self.host.awaits(self.gone, self.low):
                net.register(sender, wanted)

    def _left(self, seen: int) -> None:
        """Make those changes of the chip's outputs that are due now, after a withdrawal.

        Any INSTROBE pulse in progress is ended.
        """
        coming, now = self.state, self.kernel.now
        if max(coming.last, coming.opened or 0) <= seen:  # no edge is due, and no strobe has begun
            return
        for line in self.answering:
            wave, driver = line.wave, line.driver
            if driver is self.chip.instrobe:
                begun = [(time, level) for time, level in zip(wave.times, wave.levels, strict=True) if seen < time]
                number = coming.current(seen)
                end = coming.instant(number, coming.times.sample) if coming.start <= seen else now
                edges = [edge for edge in begun if edge[0] <= end]
            elif driver is self.chip.ready or seen < coming.start:
                edges = [
                    (time, level) for time, level in zip(wave.times, wave.levels, strict=True) if seen < time <= now
                ]
            else:
                edges = []
            if edges:
                times, levels = zip(*edges, strict=True)
                driver.promise = Wave(wave.level(seen), times, levels)

    def _resume(self, coming: HandshakenBytes, seen: int) -> bool:
        """Make the chip continue edge by edge with the rest of the bytes; return whether it waits for a request."""
        chip, task, kernel, now = self.chip, self.chip.task, self.kernel, self.kernel.now
        number, times = coming.current(seen), coming.times
        sample, busy = coming.instant(number, times.sample), coming.instant(number, times.busy)
        if coming.last == now > seen:  # it is due in this round
            chip.reached(number, HandshakeStage.TAKEN)
            return False
        task.token += 1
        if coming.start > seen:
            at = chip.reached(0, HandshakeStage.AWAITED)
        elif now < sample:
            at = chip.reached(number, HandshakeStage.REQUESTED)
        elif now < busy:
            at = chip.reached(number, HandshakeStage.ACCEPTED)
        elif number < len(coming.data) - 1 and coming.instant(number, times.kept) <= now:
            at = chip.reached(number + 1, HandshakeStage.AWAITED)
        else:
            at = chip.reached(number, HandshakeStage.READ)
        if at is None:
            chip.token = task.token
            return True
        if at > now:
            kernel.wake_at(at, task)
        else:
            kernel.wake(task)
        return False
