"""A GS-C module on a bench, with a host, and the short questions that the tests ask.

    rig = base("gs-c200s", "clock", "mov", chs=1, options={"law": "linear in steps"})

is a module named x, point-to-point at 9600 baud and without checksum unless straps say otherwise; the pins named are
recorded.  Times are picoseconds.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from decimal import Decimal
from itertools import groupby, pairwise

import pytest

import slewline

US, MS = 10**6, 10**9  # picoseconds
CHARACTER = 11 * 10**12 // 9600
TURNROUND = MS  # from the end of a line to its effect and its answer
SETUP = 10 * US  # from DIR and MOV to the first step
WIDTH = 1_700_000  # CLOCK low
C200, C200S = "gs-c200", "gs-c200s"
PARTS = (C200, C200S)
STR = ("S10", "T100", "R10")
FAST = ("S10", "T100", "R50")
NINE_SIX = {"br0": 0, "br1": 0, "br2": 0}  # straps of 9600 baud

both = pytest.mark.parametrize("part", PARTS)


def gaps(times: Iterable[int]) -> list[int]:
    """What lies between successive instants."""
    return [after - before for before, after in pairwise(times)]


def spacing(number: int, start: int, top: int, ramp: int) -> list[int]:
    """The interval behind each step of a move: one over the rate at k = min(i, n-2-i, R), at constant acceleration;
    behind the last one a start-stop period."""
    low, high = 10 * start, 10 * top
    if high <= low:
        return [round(Decimal(10**12) / high)] * number
    squares = [Decimal(low**2) + Decimal((high**2 - low**2) * k) / ramp for k in range(min(ramp, number // 2) + 1)]
    intervals = [round(10**12 / square.sqrt()) for square in squares]
    return [intervals[max(min(i, number - 2 - i, ramp), 0)] for i in range(number)]


def within(times: list[int], start: int, stop: int) -> int:
    """How many of the instants lie at start <= t < stop."""
    return sum(start <= time < stop for time in times)


def velocity(part: str) -> str:
    """The letter of the velocity mode."""
    return "G" if part == C200 else "g"


def shown(part: str, position: int) -> str:
    """A position as V1 answers it."""
    return f"V{position}" if part == C200 else f"V{position:+d}"


class Rig:
    """One module named x and its host."""

    def __init__(
        self,
        part: str,
        record: tuple[str, ...],
        straps: Mapping[str, int],
        options: Mapping[str, object],
        baud: int | None = None,
    ) -> None:
        self.bench = slewline.Bench()
        self.x = self.bench.add(part, name="x", straps=straps, **options)
        self.host = self.bench.host(self.x, baud=baud)
        self.host.uart.follow_straps()
        self.bench.record(*(f"x.{pin}" for pin in dict.fromkeys(("txd", *record))))

    # ------------------------------------------------------------------------------------------------------ dialogue
    def ask(self, command: str, timeout: str = "5 s") -> str:
        """The answer to a command; address and checksum are the host's business."""
        return self.host.ask(command, timeout)

    def asks(self, *commands: str) -> list[str]:
        """The answers to commands, one by one."""
        return [self.ask(command) for command in commands]

    def obeyed(self, command: str) -> int:
        """Send a command; returns the instant at which it was obeyed, when its answer began."""
        start = self.bench.now_ps
        self.ask(command)
        return self.rises("txd", start)[0]

    def acts(self, command: str, at: int) -> None:
        """Give a command so that it acts at an instant; its answer is Y."""
        begins = at - TURNROUND - CHARACTER * (len(command) + 1)
        self.bench.run_to(f"{max(begins, self.bench.now_ps)} ps")
        assert self.ask(command) == "Y"

    def wire(self, data: str | bytes, fault: str = "", wait: str | int = 0) -> bytes:
        """What comes back for characters as they are: until the module has answered, and for some time more."""
        before = len(self.host.received)
        self.host.write(data, fault)
        self.bench.run_until(lambda: self.host.idle and not self.x.answering, "600 s")
        self.bench.run(wait)
        return bytes(self.host.received[before:])

    def prg(self, *lines: str) -> list[str]:
        """Enter a program; returns the answers to its lines."""
        assert self.ask("P" if self.x.sheet.part == C200 else "Po") == "Y"
        return self.asks(*lines)

    def start(self, *lines: str) -> int:
        """Enter a program and start it; returns the instant of the start, a while ago: the answer to E is there."""
        assert self.prg(*lines) == ["Y"] * len(lines)
        start = self.obeyed("E")
        assert self.host.answers[0].startswith("Y")
        return start

    def run(self, *lines: str, timeout: str = "600 s") -> int:
        """Enter a program and run it to its end; returns the instant of its start."""
        start = self.start(*lines)
        self.bench.run_until_idle(timeout)
        return start

    def listed(self) -> list[str]:
        """The lines that Q answers, without END."""
        lines = self.ask("Q").split("\r")
        assert lines.pop() == "END"
        return lines

    def pos(self) -> int:
        """The position as V1 tells it."""
        return int(self.ask("V1").removeprefix("V"))

    # ---------------------------------------------------------------------------------------------------------- pins
    def level(self, pin: str) -> int | None:
        return self.x.pin(pin).level

    def levels(self, *pins: str) -> tuple[int | None, ...]:
        return tuple(self.x.pin(pin).level for pin in pins)

    def drive(self, pin: str, level: int, at: str | int | None = None) -> None:
        self.x.pin(pin).drive(level, at=at)

    def pulses(self, start: int | None = None) -> list[int]:
        """The instants of all steps."""
        return self.x.steps(start).times_ps.tolist()

    def moves(self, start: int | None = None) -> list[int]:
        """Steps in one direction before the other one: +500, -380 ..."""
        directions = self.x.steps(start).directions.tolist()
        return [sum(steps) for _, steps in groupby(directions)]

    def cycle(self) -> int:
        """Switch the supply off and on again; returns the instant at which it is back."""
        self.x.power(False)
        self.bench.run("1 ms")
        self.x.power(True)
        return self.bench.now_ps

    def edges(self, pin: str, start: int | None = None) -> list[tuple[int, int]]:
        """(instant, level) of every change of a recorded pin."""
        times, levels = self.bench.edges(f"x.{pin}", start)
        return list(zip(times.tolist(), levels.tolist(), strict=True))

    def falls(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 0]

    def rises(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 1]

    @property
    def codes(self) -> list[str]:
        """Codes of the module's findings so far."""
        return [found.code for found in self.x.findings]


def base(
    part: str, *record: str, options: Mapping[str, object] | None = None, baud: int | None = None, **straps: int
) -> Rig:
    """A module after power-up, its pins as they are strapped: base("gs-c200", "clock", rec=0)."""
    return Rig(part, record, {**NINE_SIX, "chs": 0, **straps}, options or {}, baud)
