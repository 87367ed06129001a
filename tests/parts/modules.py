"""GS-C modules on a bench, each with a host of its own, and the short questions that the tests around them ask."""

from __future__ import annotations

import pytest

import slewline

US, MS, S = 10**6, 10**9, 10**12  # picoseconds
C200, C200S = "gs-c200", "gs-c200s"
STR = ("S10", "T100", "R10")
STRAPS = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}  # 9600 baud, no checksum

both = pytest.mark.parametrize("part", (C200, C200S))


class Modules:
    """Modules of one kind by name; parts are added by `bench.part`.  Times are picoseconds."""

    def __init__(self, part: str, *names: str, shuffle: int | None = None, chs: int = 0, **options: object) -> None:
        self.bench = slewline.Bench(shuffle=shuffle)
        straps = {**STRAPS, "chs": chs}
        self.chips = {name: self.bench.add(part, name=name, straps=straps, **options) for name in names or ("x",)}
        self.opening = "P" if part == C200 else "Po"

    def connect(self) -> None:
        """Give each module its host; wiring comes before."""
        self.hosts = {name: self.bench.host(chip, name=f"host_{name}") for name, chip in self.chips.items()}

    def __getitem__(self, name: str):
        return self.chips[name]

    @property
    def x(self):
        return self.chips["x"]

    def wire(self, *pairs: str) -> None:
        """Join pins: wire("x.uo1 y.ui1")."""
        for pair in pairs:
            self.bench.wire(*pair.split())

    def ask(self, command: str, name: str = "x") -> str:
        return self.hosts[name].ask(command)

    def enter(self, *lines: str, name: str = "x") -> None:
        """Enter a program; every line is taken."""
        assert {self.ask(line, name) for line in (self.opening, *lines)} == {"Y"}

    def start(self, *lines: str, name: str = "x") -> None:
        """Enter a program and start it: time stands behind the answer to E."""
        self.enter(*lines, name=name)
        assert self.ask("E", name) == "Y"

    def run(self, *lines: str, name: str = "x") -> None:
        """Enter a program and run it to its end."""
        self.start(*lines, name=name)
        self.bench.run_until_idle("600 s")

    def pulses(self, name: str = "x", start: int | None = None) -> list[int]:
        """The instants of the steps of a module."""
        return self.chips[name].steps(start).times_ps.tolist()

    def edges(self, pin: str, start: int | None = None) -> list[tuple[int, int]]:
        """(instant, level) of every change of a recorded pin."""
        times, levels = self.bench.edges(pin, start)
        return list(zip(times.tolist(), levels.tolist(), strict=True))

    def rises(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 1]

    def falls(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 0]

    def highs(self, pin: str) -> list[int]:
        """How long a recorded pin that rests low was high, each time."""
        return [fall - rise for rise, fall in zip(self.rises(pin), self.falls(pin), strict=True)]

    def codes(self, name: str) -> list[str]:
        """Codes of the findings of a chip or part so far."""
        return [found.code for found in self.bench[name].findings]
