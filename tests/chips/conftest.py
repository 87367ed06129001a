"""A CY525 on a bench, with a host and a recorder, and the short questions that the tests ask."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import slewline

US = 1_000_000  # picoseconds


class Rig:
    """One CY525 named x and its host.  Times are picoseconds; at 11 MHz a clock is 1/11 us."""

    def __init__(
        self, *, crystal: str = "11 MHz", delay: str | int = 0, record: tuple[str, ...] = (), **options: object
    ) -> None:
        self.bench = slewline.Bench()
        self.x = self.bench.add("cy525", name="x", crystal=crystal, **options)
        self.host = self.bench.host(self.x, delay=delay)
        if record:
            self.bench.record(*(f"x.{pin}" for pin in record))

    def send(self, data: str | bytes, timeout: str = "60 s") -> None:
        """Send, and let time pass until the chip is idle."""
        self.host.send(data)
        self.bench.run_until_idle(timeout)

    def start(self, data: str | bytes) -> None:
        """Send what begins a program or an endless motion: time passes until the host has sent it."""
        self.host.send(data)
        self.bench.run_until(lambda: self.host.idle)

    def level(self, pin: str) -> int | None:
        return self.x.pin(pin).level

    def levels(self, *pins: str) -> tuple[int | None, ...]:
        return tuple(self.x.pin(pin).level for pin in pins)

    @property
    def phases(self) -> tuple[int | None, ...]:
        return self.levels("phase1", "phase2", "phase3", "phase4")

    def drive(self, pin: str, level: int) -> None:
        self.x.pin(pin).drive(level)

    @property
    def codes(self) -> list[str]:
        """Codes of the chip's findings so far."""
        return [found.code for found in self.x.findings]

    def edges(self, pin: str, start: int | None = None) -> list[tuple[int, int]]:
        """(instant, level) of every change of a recorded pin."""
        times, levels = self.bench.edges(f"x.{pin}", start)
        return list(zip(times.tolist(), levels.tolist(), strict=True))

    def falls(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 0]

    def rises(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 1]


@pytest.fixture
def rig() -> Callable[..., Rig]:
    """Make a rig: rig(record=("slew",), rate=80)."""
    return Rig


class Hand:
    """One CY525 named x without a host: pins are driven by hand, and what they do is noted.  Times are crystal clocks."""

    def __init__(self, *watched: str, crystal: str = "11 MHz", shuffle: int | None = None, **options: object) -> None:
        self.bench = slewline.Bench(shuffle=shuffle)
        self.x = self.bench.add("cy525", name="x", crystal=crystal, **options)
        self.trace: list[tuple[int, str, object]] = []
        for pin in watched:
            self.x.pin(pin).net.watch(lambda net, pin=pin: self.trace.append((self.now, pin, net.level)))

    @property
    def now(self) -> int:
        """The last clock that has begun."""
        return self.x.clock.ticks_until(self.bench.now_ps)

    def put(self, clock: int, pin: str, level: int | None) -> None:
        """Drive a pin at a clock, or let go of it (None)."""
        terminal, ps = self.x.pin(pin), self.x.clock.ps(clock)
        terminal.release(at=ps) if level is None else terminal.drive(level, at=ps)

    def data(self, clock: int, byte: int | None) -> None:
        """Put a byte on the data bus at a clock, or let go of the bus (None)."""
        for bit in range(8):
            self.put(clock, f"db{bit}", None if byte is None else byte >> bit & 1)

    def strobe(self, clock: int, byte: int, up: int) -> None:
        """A byte with I/O REQUEST low from one clock to another."""
        self.data(clock, byte)
        self.put(clock, "io_request", 0)
        self.put(up, "io_request", 1)
        self.data(up, None)

    def send(self, data: str | bytes) -> None:
        """Send bytes as fast as the handshake allows; ends when READY is high after the last one."""
        for byte in data.encode("ascii") if isinstance(data, str) else data:
            self.until(ready=1)
            self.data(self.now, byte)
            self.put(self.now, "io_request", 0)
            self.until(ready=0)
            self.put(self.now, "io_request", 1)
            self.data(self.now, None)
        self.until(ready=1)

    def fetch(self, number: int) -> bytes:
        """Read bytes from the chip, I/O SELECT being high."""
        data = bytearray()
        for _ in range(number):
            self.until(ready=1)
            self.put(self.now, "io_request", 0)
            self.until(ready=0)
            data.append(sum((self.x.pin(f"db{bit}").level or 0) << bit for bit in range(8)))
            self.put(self.now, "io_request", 1)
        self.until(ready=1)
        return bytes(data)

    def until(self, **levels: int) -> None:
        """Let time pass until pins have levels."""
        self.bench.run_until(lambda: all(self.x.pin(pin).level == level for pin, level in levels.items()))

    def run(self, clocks: int) -> None:
        """Let clocks pass."""
        self.bench.run_to(self.x.clock.ps(self.now + clocks))

    def run_to(self, clock: int) -> None:
        self.bench.run_to(self.x.clock.ps(clock))

    def edges(self, pin: str, since: int = 0) -> list[tuple[int, object]]:
        """(clock, level) of the changes of a watched pin, counted from a clock."""
        return [(clock - since, level) for clock, name, level in self.trace if name == pin and clock >= since]

    def falls(self, pin: str, since: int = 0) -> list[int]:
        return [clock for clock, level in self.edges(pin, since) if level == 0]

    def rises(self, pin: str, since: int = 0) -> list[int]:
        return [clock for clock, level in self.edges(pin, since) if level == 1]

    @property
    def codes(self) -> list[str]:
        """Codes of the chip's findings so far."""
        return [found.code for found in self.x.findings]


@pytest.fixture
def hand() -> Callable[..., Hand]:
    """Make a hand: hand("ready", "instrobe", rate=80)."""
    return Hand
