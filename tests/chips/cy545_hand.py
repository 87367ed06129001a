"""A CY545 whose parallel side is moved by hand, wire by wire, and the order of what happens there."""

from __future__ import annotations

import slewline
from slewline.core.time.timebase import picoseconds
from slewline.core.wires.net import Driver

US, MS = 10**6, 10**9  # picoseconds
LINES = ("io_request", "busy", "usrb6", "txd")


class Hand:
    """A chip named x; nothing is on its bus but this hand, and a memory if there is one."""

    def __init__(
        self, part: str = "cy545b", crystal: str = "12 MHz", memory: str | None = None, record: tuple[str, ...] = (),
        **options: object,
    ) -> None:  # fmt: skip
        self.bench = slewline.Bench()
        self.x = self.bench.add(part, name="x", crystal=crystal, **options)
        if memory is not None:
            self.ram = self.bench.part(memory, name="memory", to=self.x)
        self.bench.record(*(f"x.{pin}" for pin in (*LINES, *record)), "x.db")
        self._bus = Driver(self.x.bus, "hand")
        self.request(1)

    @property
    def codes(self) -> list[str]:
        return [found.code for found in self.x.findings]

    # ----------------------------------------------------------------------------------------------------- the wires
    def put(self, byte: int | None) -> None:
        """Drive the bus, or let go of it."""
        self._bus.drive(None if byte is None else (0xFF, byte))
        self.bench.kernel.settle()

    def request(self, level: int) -> None:
        self.x.pin("io_request").drive(level)

    def until(self, pin: str, level: int, timeout: str = "10 s") -> None:
        self.bench.run_until(self.x.pin(pin).is_(level), timeout)

    def run(self, us: float) -> None:
        self.bench.run(round(us * US))

    def byte(self, byte: int | None, hold: float = 0) -> None:
        """A handshake with a byte, or the empty one; IO_REQUEST stays low for so long (us) behind the fall of BUSY."""
        self.until("busy", 1)
        self.put(byte)
        self.request(0)
        self.until("busy", 0)
        self.run(hold)
        self.request(1)
        self.put(None)

    def say(self, text: str | bytes) -> None:
        """Send characters; time passes until BUSY is high again."""
        for byte in text.encode("ascii") if isinstance(text, str) else text:
            self.byte(byte)
        self.until("busy", 1, "1000 s")

    def fetch(self, hold: float = 0) -> int:
        """Read a byte, as a host does that finds FPL low."""
        self.request(0)
        self.until("busy", 0)
        found: int = self.x.bus.byte
        self.run(hold)
        self.request(1)
        self.until("busy", 1)
        return found

    def message(self) -> bytes:
        """Read while FPL is low."""
        found = bytearray()
        while self.x.pin("usrb6").level == 0:
            found.append(self.fetch())
        return bytes(found)

    # ------------------------------------------------------------------------------------------------ what has happened
    def edges(self, pin: str, since: int = 0) -> list[tuple[int, int]]:
        times, levels = self.bench.edges(f"x.{pin}", picoseconds(since))
        return [(int(t), int(v)) for t, v in zip(times, levels, strict=True)]

    def falls(self, pin: str, since: int = 0) -> list[int]:
        return [time for time, level in self.edges(pin, since) if level == 0]

    def rises(self, pin: str, since: int = 0) -> list[int]:
        return [time for time, level in self.edges(pin, since) if level == 1]

    def order(self, since: int = 0, pins: tuple[str, ...] = LINES[:3]) -> list[tuple[str, int]]:
        """(pin, level) of every change of some pins, in the order of time."""
        found = [(time, pin, level) for pin in pins for time, level in self.edges(pin, since) if time > since]
        return [(pin, level) for _, pin, level in sorted(found)]
