"""A bus driven by hand: cycles to memory, display and switches, with times and mistakes of one's own."""

from __future__ import annotations

import slewline
from slewline.core.wires.net import Driver

REST = {"select": 1, "ale": 0, "rd": 1, "wr": 1}


class BusMaster:
    """A bench with one part on a bus, and the hand that drives it; a phase of a cycle takes 1 us."""

    def __init__(self, kind: str, **options: object) -> None:
        self.bench = slewline.Bench()
        self.part = self.bench.part(kind, name="p", **options)
        self.bus = Driver(self.part.pin("db").net, "hand")
        for pin, level in REST.items():
            if pin in self.part.pins:
                self.put(pin, level)
        self.pass_time()

    def put(self, pin: str, level: int) -> None:
        """Drive a pin."""
        self.part.pin(pin).drive(level)

    def pass_time(self, time: str = "1 us") -> None:
        self.bench.run(time)

    def on_bus(self, byte: int | None) -> None:
        """Put a byte on the bus, or let go of it."""
        self.bus.drive(None if byte is None else (0xFF, byte))
        self.bench.kernel.settle()

    @property
    def floats(self) -> bool:
        """Does nobody drive the bus?"""
        return self.part.pin("db").net.level is None

    def address(self, address: int, upper: bool = True) -> None:
        """Select the part, and latch an address."""
        if upper:
            self.on_bus(address >> 8)
        self.put("select", 0)
        self.pass_time()
        self.on_bus(address & 0xFF)
        self.put("ale", 1)
        self.pass_time()
        self.put("ale", 0)
        self.pass_time()

    def read(self, address: int, upper: bool = True, ends: bool = True) -> int:
        """A read cycle; returns the byte, FF from a bus that floats."""
        self.address(address, upper)
        self.on_bus(None)
        self.put("rd", 0)
        self.pass_time()
        byte: int = self.part.pin("db").net.byte
        if ends:
            self.put("rd", 1)
            self.put("select", 1)
            self.pass_time()
        return byte

    def write(self, address: int, byte: int, upper: bool = True) -> None:
        """A write cycle."""
        self.address(address, upper)
        self.on_bus(byte)
        self.put("wr", 0)
        self.pass_time()
        self.put("wr", 1)
        self.on_bus(None)
        self.put("select", 1)
        self.pass_time()
