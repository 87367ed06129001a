"""A bench with one chip, and the short questions that the tests of the parts ask."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import slewline

US = 1_000_000  # picoseconds


class Circuit:
    """A bench with a CY525 named x; parts are added by `bench.part`.  Times are picoseconds."""

    def __init__(self, *recorded: str, shuffle: int | None = None, **options: object) -> None:
        self.bench = slewline.Bench(shuffle=shuffle)
        self.x = self.bench.add("cy525", name="x", **options)
        self.recorded = recorded

    def part(self, kind: str, name: str | None = None, **options: object):
        return self.bench.part(kind, name, **options)

    def settle(self) -> None:
        """Let the parts take their first levels; what was asked for is recorded from here on."""
        if self.recorded:
            self.bench.record(*self.recorded)
            self.recorded = ()
        self.bench.run(0)

    def finish(self, timeout: str = "60 s") -> None:
        """Let time pass until everything is idle."""
        self.settle()
        self.bench.run_until_idle(timeout)

    def level(self, pin: str) -> int | None:
        return self.bench.pin(pin).level

    def edges(self, pin: str, start: int | None = None, stop: int | None = None) -> list[tuple[int, int]]:
        """(instant, level) of every change of a recorded pin."""
        times, levels = self.bench.edges(pin, start, stop)
        return list(zip(times.tolist(), levels.tolist(), strict=True))

    def falls(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 0]

    def rises(self, pin: str, start: int | None = None) -> list[int]:
        return [time for time, level in self.edges(pin, start) if level == 1]

    def codes(self, name: str) -> list[str]:
        """Codes of the findings of a chip or part so far."""
        return [found.code for found in self.bench[name].findings]


@pytest.fixture
def circuit() -> Callable[..., Circuit]:
    """Make a circuit: circuit("x.pulse", position=0)."""
    return Circuit
