"""A CY525 on a bench, with a host and a recorder, and the short questions that the tests ask."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest
from cy5xx import Rig

import slewline
from tests import tables

HERE = Path(__file__).parent
FAMILIES = [HERE / name for name in ("gs_c200", "mc1451a")]  # whose parts differ in little
TELLING = ("C200", "C200S", "ENCODERS")  # by these names a test tells parts apart


@pytest.hookimpl(wrapper=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> Iterator[None]:
    """Thin out tables before the rows of this run are selected, and join the rows that are."""
    tables.pair((item for item in items if item.path.is_relative_to(HERE)), TELLING)
    tables.take_turns((item for item in items if item.path.parent in FAMILIES), TELLING)
    yield
    tables.one_item_each(items, HERE)


@pytest.fixture(scope="session")
def rig() -> Callable[..., Rig]:
    """Make a rig: rig(record=("slew",), rate=80)."""
    return Rig


BUS = [f"db{bit}" for bit in range(8)]


class Hand:
    """One CY525 named x without a host: pins are driven by hand, and what they do is noted, in crystal clocks."""

    def __init__(self, *watched: str, crystal: str = "11 MHz", shuffle: int | None = None, **options: object) -> None:
        self.bench = slewline.Bench(shuffle=shuffle)
        self.x = self.bench.add("cy525", name="x", crystal=crystal, **options)
        self.trace: list[tuple[int, str, object]] = []
        self.watched: set[str] = set()
        self.watch(*watched)

    def watch(self, *pins: str) -> None:
        """Note the changes of pins from now on."""
        for pin in pins:
            if pin not in self.watched:
                self.watched.add(pin)
                self.x.pin(pin).net.watch(lambda net, pin=pin: self.trace.append((self.now, pin, net.level)))

    @property
    def now(self) -> int:
        """The last clock that has begun."""
        return self.x.clock.ticks_until(self.bench.now_ps)

    def put(self, clock: int, pin: str, level: int | None) -> None:
        """Drive a pin at a clock, or let go of it (None)."""
        self.put_at(self.instant(clock), pin, level)

    def instant(self, clock: int) -> int:
        """The instant of a clock, ps: now, if it is the last one that has begun."""
        return self.bench.now_ps if clock == self.now else self.x.clock.ps(clock)

    def put_at(self, ps: int, pin: str, level: int | None) -> None:
        """Drive a pin at an instant, or let go of it (None)."""
        terminal = self.x.pin(pin)
        terminal.release(at=ps) if level is None else terminal.drive(level, at=ps)

    def data(self, clock: int, byte: int | None) -> None:
        """Put a byte on the data bus at a clock, or let go of the bus (None)."""
        ps = self.instant(clock)
        for bit, pin in enumerate(BUS):
            self.put_at(ps, pin, None if byte is None else byte >> bit & 1)

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
        self.watch(*levels)
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


@pytest.fixture(scope="session")
def hand() -> Callable[..., Hand]:
    """Make a hand: hand("ready", "instrobe", rate=80)."""
    return Hand


INCREMENTS = (  # of Table VII from R 40 on, steps/s; below R 40 each is 100
    62, 45, 47, 47, 49, 49, 51, 52, 54, 55, 56, 57, 59, 60, 62, 64, 65, 68, 68, 71,
    37, 36, 38, 37, 39, 39, 39, 40, 41, 41, 42, 42, 44, 43, 45, 45, 46, 47, 47, 49,
    49, 49, 51, 51, 53, 53, 54, 55, 56, 58, 58, 59, 60, 61, 63, 63, 65, 66, 68, 68,
    70, 72, 72, 75, 76, 77, 79, 80, 83, 84, 86, 88, 89, 92, 94, 96, 98, 101, 103, 105,
    109, 110, 114, 116, 119, 123, 126,
)  # fmt: skip


class Mover(Hand):
    """A hand for motions: clocks count from the begin of the first step, and the outputs of a motion are recorded."""

    def __init__(self, *recorded: str, **options: object) -> None:
        super().__init__(**options)
        self.bench.record(*(f"x.{pin}" for pin in ("pulse", "slew", "motion_complete", "ready", *recorded)))
        self.origin = 0

    @staticmethod
    @cache
    def rate(parameter: int) -> int:
        """Steps per second at 11 MHz, by Table VII."""
        return 100 * parameter if parameter <= 40 else 4000 + sum(INCREMENTS[: parameter - 40])

    @classmethod
    def period(cls, parameter: int) -> int:
        """Clocks of a step."""
        return round(11_000_000 / cls.rate(parameter))

    @classmethod
    def way_up(cls, low: int, high: int, slope: int, divisor: int = 1, most: int = 65_535) -> list[int]:
        """Clocks of the steps from one rate to another, one by one.

        A rate unit falls due every Z * (256 - S) * 452 clocks; a step takes the next one at most.
        """
        unit, ramp_time, taken = divisor * (256 - slope) * 452, 0, 0
        steps: list[int] = []
        while low + taken < high and len(steps) < most:
            steps.append(cls.period(low + taken))
            ramp_time += steps[-1]
            taken += ramp_time >= (taken + 1) * unit
        return steps

    def give(self, data: str | bytes) -> None:
        """Send bytes; ends when READY falls for the last one."""
        data = data.encode("ascii") if isinstance(data, str) else data
        self.send(data[:-1])
        self.data(self.now, data[-1])
        self.put(self.now, "io_request", 0)
        self.until(ready=0)
        self.put(self.now, "io_request", 1)
        self.data(self.now, None)

    def begin(self, data: str | bytes = "G\r") -> None:
        """Send what begins a motion; time stands at the begin of its first step, clock 0."""
        travel = self.x.travel
        self.give(data)
        self.bench.run_until(lambda: self.x.travel != travel)
        self.origin = self.now

    def on(self, clock: int, pin: str, level: int | None) -> None:
        """Drive a pin at a clock of the motion, or let go of it (None)."""
        self.put(self.origin + clock, pin, level)

    def byte(self, clock: int, value: int | None) -> None:
        """Put a byte on the bus at a clock of the motion, or let go of the bus (None)."""
        self.data(self.origin + clock, value)

    def request(self, clock: int, rate: int, up: int | None = None) -> None:
        """Ask for a rate on the fly: I/O REQUEST low from one clock of the motion to another, or for 12,000."""
        self.strobe(self.origin + clock, rate, self.origin + (clock + 12_000 if up is None else up))

    def till(self, clock: int) -> None:
        """Let time pass up to a clock of the motion."""
        self.run_to(self.origin + clock)

    def finish(self, timeout: str = "600 s") -> None:
        """Let time pass until the chip is idle again."""
        self.bench.run_until_idle(timeout)

    def endless(self, setup: str) -> int:
        """Begin a continuous motion; the clock at which it begins to slew."""
        self.send(f"{setup}N 60000\r")
        self.begin("H\rG\r")
        self.until(slew=0)
        return self.now - self.origin

    def ask(self, rate: int) -> int:
        """Ask for a rate as a host does, until SLEW is high; the clock of the motion at which it rose."""
        self.data(self.now, rate)
        self.put(self.now, "io_request", 0)
        self.until(slew=1)
        self.put(self.now, "io_request", 1)
        self.data(self.now, None)
        return self.now - self.origin

    def begins(self) -> list[int]:
        """Clocks at which steps of the motion began, so far."""
        times = self.x.steps(self.x.clock.ps(self.origin)).times_ps
        return (self.x.clock.ticks_array(times) - self.origin).tolist()

    def periods(self) -> list[int]:
        """Clocks of every step, to the begin of the next one; the last one ends as MOTION COMPLETE falls for good."""
        begins = self.begins()
        if self.x.pin("motion_complete").level == 0:
            begins.append(self.changes("motion_complete")[-1][0])
        return [after - before for before, after in pairwise(begins)]

    def periods_from(self, clock: int) -> list[int]:
        """Clocks of the steps that began at a clock of the motion or later."""
        return self.periods()[sum(begin < clock for begin in self.begins()) :]

    def changes(self, pin: str) -> list[tuple[int, int]]:
        """(clock of the motion, level) of every change of a recorded pin since the first step began, that included."""
        times, levels = self.bench.edges(f"x.{pin}", self.x.clock.ps(self.origin))
        return list(zip((self.x.clock.ticks_array(times) - self.origin).tolist(), levels.tolist(), strict=True))


@pytest.fixture(scope="session")
def mover() -> Callable[..., Mover]:
    """Make a mover: mover("phase1", crystal="6 MHz")."""
    return Mover
