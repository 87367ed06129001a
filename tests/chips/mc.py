"""A chipset of the MC1451A family on a bench, with its host, and the short questions that the tests ask.

    rig = base("mc1451a-e", "pulse1", "atrest1")      chipset x, ready for its first command; these pins are recorded
    n = rig.begin(*T1)                                the cycle with which the move begins
    rig.rest()
    assert rig.lows("atrest1") == [(n, 1063)]

Times are picoseconds, and a cycle is named by its number since the end of reset.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import pytest

import slewline
from tests.ensembles import in_long_runs

NS, US, MS = 10**3, 10**6, 10**9  # picoseconds
ONE = 1 << 16  # a step, or a step per cycle
READY = 10  # the cycle with whose begin HostRdy rises

AXES = {"mc1151a": 1, "mc1251a": 2, "mc1451a": 4, "mc1151a-e": 1, "mc1251a-e": 2, "mc1451a-e": 4}
PARTS = tuple(AXES)
ENCODERS = tuple(part for part in PARTS if part.endswith("-e"))
SEVERAL = tuple(part for part in PARTS if AXES[part] > 1)


def of_parts(parts: Sequence[str]) -> pytest.MarkDecorator:
    """Give a test parts: the least and the greatest of them in every run, those between in long ones."""
    least, *between, greatest = parts
    return pytest.mark.parametrize("part", [least, *map(in_long_runs, between), greatest])


each = of_parts(PARTS)
with_encoder = of_parts(ENCODERS)
with_axes = of_parts(SEVERAL)

TRAPEZOID = ("SET_VEL 0x10000", "SET_ACC 0x400")  # a step per cycle, after 64 cycles and 32 steps
T1, T4 = (*TRAPEZOID, "SET_POS 1000"), (*TRAPEZOID, "SET_POS -1000")
T1_CYCLES = 1063
S1 = ("SET_PRFL_S_CRV", "SET_VEL 0x10000", "SET_MAX_ACC 0x400", "SET_JERK 0x200000", "SET_POS 1000")
S1_CYCLES = 1096
V1 = ("SET_PRFL_VEL", *TRAPEZOID)  # a step per cycle, for good

FORWARD = ((0, 0), (1, 0), (1, 1), (0, 1))  # levels of an encoder's A and B


class Rig:
    """One chipset named x and its host."""

    def __init__(
        self, part: str, record: tuple[str, ...], straps: Mapping[str, int], options: Mapping[str, object]
    ) -> None:
        self.bench = slewline.Bench()
        self.x = self.bench.add(part, name="x", straps=straps, **options)
        self.host = self.bench.host(self.x)
        self.bench.record(*(f"x.{pin}" for pin in record))
        self.turned = dict.fromkeys(range(1, 5), 0)  # counts that the encoders have made

    # ---------------------------------------------------------------------------------------------------------- time
    def at(self, cycle: int, tick: int = 0) -> int:
        """The instant of a clock in a cycle."""
        return self.x.clock.ps(self.x._cycle_clock.origin + 8192 * cycle + tick)

    @property
    def cycle(self) -> int:
        """The cycle under way."""
        return (self.x.clock.ticks_until(self.bench.now_ps) - self.x._cycle_clock.origin) // 8192

    def to(self, cycle: int, tick: int = 0) -> None:
        """Let time pass up to a clock in a cycle, what happens then included."""
        instant = self.at(cycle, tick)
        assert self.bench.now_ps <= instant, f"it is cycle {self.cycle} already"
        self.bench.run_to(instant)

    def next(self, cycles: int = 1) -> int:
        """Let time pass up to the begin of the next cycle, or of a later one; returns its number."""
        cycle = self.cycle + cycles
        self.to(cycle)
        return cycle

    def rest(self, timeout: str = "60 s") -> None:
        """Let time pass until nothing moves."""
        self.bench.run_until_idle(timeout)

    # ------------------------------------------------------------------------------------------------------ dialogue
    def do(self, *commands: str, axis: int = 0) -> int | None:
        """Send commands, such as "SET_POS 1000", and check their checksums; returns what the last one returns."""
        found = None
        for command in commands:
            name, *values = command.split()
            found = self.host.command(name, *(int(value, 0) for value in values), axis=axis)
        return found

    def packet(self, code: int, *words: int, reads: int = 0) -> tuple[int, ...]:
        """Send any packet; returns all words that are read behind it, the checksum last, whatever it is."""
        self.host.write_command(code)
        for word in words:
            self.host.write_word(word)
        return tuple(self.host.read_word() for _ in range(reads + 1))

    def says(self, *packets: str) -> None:
        """Packets as they stand here, in hexadecimal: what is written > what is read, the checksum last."""
        for packet in packets:
            written, read = packet.split(" > ")
            found = self.packet(*(int(word, 16) for word in written.split()), reads=read.count(" "))
            assert " ".join(f"{word:04x}" for word in found) == read, packet

    def update(self, *commands: str, axis: int = 0) -> int:
        """Send commands and UPDATE, early in a cycle; returns the next cycle, with which it takes effect."""
        self.do(*commands, axis=axis)
        cycle = self.next()
        self.do("UPDATE", axis=axis)
        assert self.cycle == cycle
        return cycle + 1

    def begin(self, *commands: str, axis: int = 0) -> int:
        """The same, and let time pass up to that cycle."""
        cycle = self.update(*commands, axis=axis)
        self.to(cycle)
        return cycle

    def status(self, axis: int = 0) -> int:
        """The status word, asked for over the port."""
        word = self.host.query("GET_STATUS", axis=axis)
        assert word & 0xCA00 == 0x0200  # the axis is on; bits 11, 14 and 15 stay 0
        return word

    def shows(self, name: str, axis: int = 1) -> int:
        """A register as it is now, without a word over the port."""
        return self.x.axis(axis).registers[name]

    @property
    def codes(self) -> list[str]:
        """Codes of the chipset's findings so far."""
        return [found.code for found in self.x.findings]

    # ---------------------------------------------------------------------------------------------------------- pins
    def level(self, pin: str) -> int | None:
        return self.x.pin(pin).level

    def drive(self, pin: str, level: int, at: str | int | None = None) -> None:
        self.x.pin(pin).drive(level, at=at)

    def turn(self, counts: int, apart: int = 1000, axis: int = 1) -> None:
        """Turn an encoder from now on: so many counts, so many clocks apart."""
        now, way = self.x.clock.ticks_from(self.bench.now_ps) + 1, 1 if counts > 0 else -1
        for n in range(abs(counts)):
            before = self.turned[axis]
            self.turned[axis] += way
            for pin, old, new in zip("ab", FORWARD[before % 4], FORWARD[(before + way) % 4], strict=True):
                if old != new:
                    self.drive(f"quad{pin}{axis}", new, at=self.x.clock.ps(now + n * apart))

    def pulses(self, start: int | None = None, axis: int = 1) -> list[int]:
        """The instants of the steps of an axis."""
        return self.x.axis(axis).steps(start).times_ps.tolist()

    def edges(self, pin: str, start: int | None = None) -> list[tuple[int, int]]:
        """(instant, level) of every change of a recorded pin."""
        times, levels = self.bench.edges(f"x.{pin}", start)
        return list(zip(times.tolist(), levels.tolist(), strict=True))

    def falls(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 0]

    def rises(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 1]

    def lows(self, pin: str, start: int | None = None) -> list[tuple[int, int]]:
        """When a recorded pin was low since it was ready: from which cycle on, and for how many."""
        falls, rises = self.falls(pin, start or self.at(READY)), self.rises(pin, start or self.at(READY))
        spans = [(self.in_cycles(fall), self.in_cycles(rise)) for fall, rise in zip(falls, rises, strict=True)]
        return [(fall, rise - fall) for fall, rise in spans]

    def in_cycles(self, instant: int) -> int:
        """The cycle that begins at an instant; nothing else does."""
        cycle, part = divmod(self.x.clock.ticks_from(instant) - self.x._cycle_clock.origin, 8192)
        assert part == 0, f"{part} clocks into cycle {cycle}"
        return cycle


def gaps(times: list[int]) -> list[int]:
    """What lies between successive instants."""
    return [after - before for before, after in pairwise(times)]


def base(
    part: str,
    *record: str,
    options: Mapping[str, object] | None = None,
    ready: bool = True,
    **straps: int,
) -> Rig:
    """A chipset behind its reset, its inputs as they are strapped: base("mc1451a", "pulse1", poslimit1=1)."""
    rig = Rig(part, record, straps, options or {})
    if ready:
        rig.bench.run_until(rig.x.pin("hostrdy").is_(1))
    return rig
