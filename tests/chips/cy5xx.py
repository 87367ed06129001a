"""A CY5xx on a bench, with a host and a recorder, and the short questions that the tests ask."""

from __future__ import annotations

import slewline
from slewline.core.time.timebase import picoseconds
from slewline.core.wires.waits import level, until
from slewline.parts.hosts.ends.handshake_port import CommandPort

US = 1_000_000  # picoseconds


class Rig:
    """One CY5xx named x and its host.  Times are picoseconds; at 11 MHz a clock is 1/11 us."""

    def __init__(
        self,
        *,
        part: str = "cy525",
        crystal: str = "11 MHz",
        delay: str | int = 0,
        record: tuple[str, ...] = (),
        **options: object,
    ) -> None:
        self.bench = slewline.Bench()
        self.x = self.bench.add(part, name="x", crystal=crystal, **options)
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

    def enter(self, *lines: str) -> None:
        """Enter a program."""
        self.send("".join(f"{line}\r" for line in ("E", *lines)) + "Q")

    def execute(self, command: str = "X", timeout: str = "60 s") -> None:
        """Start a program, and let time pass until it is over."""
        self.host.send(f"{command}\r")
        self.bench.run_until(self.x.pin("run").is_(0), "10 s")
        self.bench.run_until_idle(timeout)

    def pull_request(self, low: str, byte: bytes = b"", ready: bool = False) -> None:
        """Queue I/O REQUEST low for a while, whatever READY says or once it is high, with a byte on the bus or none."""

        async def action(port: CommandPort) -> None:
            if ready:
                await level(port.ready, 1)
            if byte:
                port.bus.drive((0xFF, byte[0]))
            port.request.drive(0)
            await until(self.bench.kernel, self.bench.now_ps + picoseconds(low))
            port.request.drive(1)
            port.bus.drive(None)

        self.host.do(action)

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
