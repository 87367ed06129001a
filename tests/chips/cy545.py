"""A CY545 on a bench with its hosts, a memory and a recorder, and the short questions that the tests ask."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from cy5xx import Rig

import slewline

US, MS, S = 10**6, 10**9, 10**12  # picoseconds
SHUTTLE = "Y 0\rE\rP 100\rP 0\rL 3,0\r0\rQ\r"
CC10 = "Y 10\rE\rN 1\r+\rG\rD 2000\rL 50,16\rQ\r"
QUERYPROG = 'Y 0\rE\rN 50\r+\rG\r? P\r"OK"\rJ 0\rQ\r'


class Rig545(Rig):
    """A CY545B, or a CY545, named x: a host over the parallel side, one over the serial side where `serial` is set.

    Replies go to the parallel side if `replies` is set; `ram` is the memory, unless it is None.
    """

    def __init__(
        self,
        *record: str,
        part: str = "cy545b",
        crystal: str = "12 MHz",
        replies: bool = True,
        serial: bool = False,
        memory: str | None = "ram",
        **options: object,
    ) -> None:
        self.bench = slewline.Bench()
        self.x = self.bench.add(part, name="x", crystal=crystal, **options)
        self.ram = self.bench.part(memory, name="memory", to=self.x) if memory else None
        self.host = self.bench.host(self.x)
        if serial:
            self.serial = self.bench.host(self.x, over="serial")
        if record:
            self.bench.record(*(f"x.{pin}" for pin in record))
        if replies:
            self.host.send("O 81H\r")
            self.bench.run_until_idle()
        self.heard = 0

    def say(self, *lines: str, timeout: str = "100 s") -> str:
        """Send lines, let time pass until all is idle, and return what has been answered since the last time."""
        self.send("".join(f"{line}\r" for line in lines), timeout)
        return self.answer

    @property
    def answer(self) -> str:
        """What the parallel host has received since the last time."""
        heard, self.heard = self.heard, len(self.host.received)
        return bytes(self.host.received[heard:]).decode("latin-1")

    def enter(self, *lines: str, at: int = 0) -> None:
        """Enter a program at an address."""
        self.send(f"Y {at}\rE\r" + "".join(f"{line}\r" for line in lines) + "Q")

    def run_program(self, at: int = 0, timeout: str = "100 s") -> None:
        """Run the program at an address to its end."""
        self.send(f"Y {at}\rX\r", timeout)

    def state(self, pins: str) -> str:
        """Levels of some pins, as digits: state("usrb5 usrb4")."""
        return "".join(str(self.level(pin)) for pin in pins.split())

    @property
    def user(self) -> str:
        """USRB5 ... USRB0, as digits."""
        return self.state("usrb5 usrb4 usrb3 usrb2 usrb1 usrb0")


def steppable(pins: tuple[str, ...], *lines: str, **options: Any) -> Rig545:
    """A chip without a memory whose pins are recorded, and whose registers are set."""
    rig = Rig545(*pins, memory=None, replies=False, **options)
    rig.send("".join(f"{line}\r" for line in lines))
    return rig


def periods(rig: Rig545, start: int | None = None) -> list[int]:
    """From fall to fall of PULSE, ps."""
    return [b - a for a, b in pairwise(rig.falls("pulse", start))]


def near(found: float, expected: float, percent: float) -> bool:
    """Is a number as expected, to so many percent?"""
    return abs(found - expected) <= abs(expected) * percent / 100
