"""Two hands of a host at the host port of a chipset: one that calls the port, and one that moves the wires.

What a hand does at once is an operation: a command byte, a word written or read, or half of one.
"""

from __future__ import annotations

from random import Random
from typing import Any

import slewline

NS, US, MS = 10**3, 10**6, 10**9
PATIENCE = 100 * MS  # HostRdy is never low for so long
STROBES = ("hostwrite", "hostread")


class Hand:
    """Anybody who serves the port."""

    def __init__(self, bench: slewline.Bench, chip: Any) -> None:
        self.bench, self.chip = bench, chip
        self.operations = 0
        self.words: list[int] = []  # that were read

    def ready(self) -> None:
        """Let time pass until HostRdy is high."""
        raise NotImplementedError

    def write(self, data: bytes, command: bool = False) -> None:
        """A command byte, a word or half of one, whatever HostRdy says."""
        raise NotImplementedError

    def read(self, number: int = 2) -> bytes:
        """A word or half of one, whatever HostRdy says."""
        raise NotImplementedError

    def command(self, code: int) -> None:
        """A command byte, when the port is ready."""
        self.ready()
        self.write(bytes([code]), command=True)

    def send(self, *words: int) -> None:
        """Words, each when the port is ready."""
        for word in words:
            self.ready()
            self.write(word.to_bytes(2, "big"))

    def fetch(self, number: int = 1) -> list[int]:
        """Words, each when the port is ready."""
        found = []
        for _ in range(number):
            self.ready()
            found.append(int.from_bytes(self.read(), "big"))
        self.words += found
        return found

    def packet(self, code: int, *words: int, reads: int = 0) -> list[int]:
        """A packet: what is read behind it, the checksum last."""
        self.command(code)
        self.send(*words)
        return self.fetch(reads + 1)


class Calls(Hand):
    """A host whose strobes are as they should be: the port is told what they transfer."""

    def ready(self) -> None:
        kernel, port = self.bench.kernel, self.chip._port
        late = kernel.run_while(lambda: port.ready, kernel.now + PATIENCE)
        assert not late, self.chip.waiting

    def write(self, data: bytes, command: bool = False) -> None:
        self.operations += 1
        take = self.chip._port.command if command else self.chip._port.data
        for byte in data:
            take(byte)

    def read(self, number: int = 2) -> bytes:
        self.operations += 1
        data, port = bytearray(), self.chip._port
        for _ in range(number):
            data.append(port.read())
            port.read_on()
        return bytes(data)


class Wires(Hand):
    """A host that moves the wires of the port, one after the other, as fast as the data sheet allows."""

    def __init__(self, bench: slewline.Bench, chip: Any) -> None:
        super().__init__(bench, chip)
        self.shown: int | None = None  # on the bus
        self.rest()

    def put(self, **levels: int) -> None:
        """Levels on wires, now."""
        for pin, level in levels.items():
            self.chip.pin(pin).drive(level)

    def hold(self, **levels: int) -> None:
        """Levels on wires, for a moment."""
        self.put(**levels)
        self.wait(60)

    def bus(self, byte: int | None) -> None:
        """A byte on the bus, or nothing."""
        for bit in range(8):
            if byte is None and self.shown is not None:
                self.chip.pin(f"hostdata{bit}").release()
            elif byte is not None and (self.shown is None or (byte ^ self.shown) >> bit & 1):
                self.chip.pin(f"hostdata{bit}").drive(byte >> bit & 1)
        self.shown = byte

    def rest(self) -> None:
        """Leave the port alone."""
        self.hold(hostwrite=1, hostread=1, hostslct=1, hostcmd=0)
        self.bus(None)

    def wait(self, ns: int) -> None:
        self.bench.run(ns * NS)

    def ready(self) -> None:
        ready = self.chip.pin("hostrdy")
        if ready.level != 1:
            self.bench.run_until(ready.is_(1), PATIENCE)

    def write(self, data: bytes, command: bool = False, low: int = 50, gap: int = 60) -> None:
        self.operations += 1
        self.put(hostslct=0, hostcmd=int(command))
        for byte in data:
            self.bus(byte)
            self.wait(gap)
            self.put(hostwrite=0)
            self.wait(low)
            self.put(hostwrite=1)
        self.wait(30)
        self.put(hostslct=1, hostcmd=0)
        self.wait(50)

    def read(self, number: int = 2, let_go: bool = True) -> bytes:
        self.operations += 1
        data = bytearray()
        if let_go:
            self.bus(None)
        self.put(hostslct=0)
        for _ in range(number):
            self.wait(60)
            self.put(hostread=0)
            self.wait(50)
            data.append(self.chip.bus.byte)
            self.put(hostread=1)
        self.wait(50)
        self.put(hostslct=1)
        self.wait(30)
        return bytes(data)

    def fumble(self, rnd: Random) -> None:
        """Move any wire of the port, at any time; RESET and the supply may come between."""
        for _ in range(rnd.randrange(2, 40)):
            pin = rnd.choice((*("hostslct", "hostcmd", *STROBES * 2, "bus") * 5, "reset", "supply"))
            if pin == "bus":
                self.bus(rnd.choice((None, rnd.randrange(256))))
            elif pin == "supply":
                self.chip.power(bool(rnd.randrange(2)))
            else:
                level = rnd.randrange(2)
                self.operations += pin in STROBES and self.chip.pin(pin).level > level
                self.put(**{pin: level})
            self.wait(rnd.choice((0, 10, 30, 60, 60, 1000, 3000, 82_000)))
        self.rest()
        self.chip.power(True)
        self.chip.pin("reset").release()
