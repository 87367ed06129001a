"""A CY500 on a bench with its host, and the short questions that the tests ask; 6 MHz unless told otherwise."""

from __future__ import annotations

from itertools import pairwise

from cy5xx import Rig

import slewline

US, MS = 1_000_000, 1_000_000_000  # picoseconds
CLOCK = 1_000_000 / 6  # ps at 6 MHz
FULL = ((0, 1, 0, 1), (1, 0, 0, 1), (1, 0, 1, 0), (0, 1, 1, 0))
HALF = ((0, 1, 0, 1), (1, 1, 0, 1), (1, 0, 0, 1), (1, 0, 1, 1), (1, 0, 1, 0), (1, 1, 1, 0), (0, 1, 1, 0), (0, 1, 1, 1))


class Rig500(Rig):
    """One CY500 named x and its host."""

    def __init__(self, *, crystal: str = "6 MHz", record: tuple[str, ...] = (), **options: object) -> None:
        self.bench = slewline.Bench()
        self.x = self.bench.add("cy500", name="x", crystal=crystal, **options)
        self.host = self.bench.host(self.x)
        if record:
            self.bench.record(*(f"x.{pin}" for pin in record))

    def execute(self, command: str = "D", timeout: str = "60 s") -> None:
        super().execute(command, timeout)

    def say(self, *lines: str) -> Rig500:
        """Send commands, and let time pass until the chip is idle."""
        self.send("".join(f"{line}\r" for line in lines))
        return self

    @property
    def times(self) -> list[int]:
        """The instants of all steps so far, ps."""
        return self.x.steps().times_ps.tolist()

    @property
    def gaps(self) -> list[int]:
        """From step to step, clocks."""
        ticks = [self.x.clock.ticks_until(time) for time in self.times]
        return [b - a for a, b in pairwise(ticks)]

    @property
    def signs(self) -> list[int]:
        return self.x.steps().directions.tolist()


def made(*lines: str, **options: object) -> Rig500:
    """A rig behind some commands."""
    return Rig500(**options).say(*lines)
