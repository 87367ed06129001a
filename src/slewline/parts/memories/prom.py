"""Commands from a PROM, without any host (s.10, fig. 10.18).

    I/O REQUEST = NAND(READY, not at the end)        READY high requests a byte, READY low ends the request
    address     = 74193 counters, clocked by the rising edge of I/O REQUEST, preset while `load` is low
    the end     = the byte FF on the bus (7430), or with `stop="address"` the address FF

The counter is clocked by I/O REQUEST and not by READY, because READY also falls during every motion of a
stored program and would advance the address past the end.
"""

from __future__ import annotations

from collections.abc import Sized
from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.time.kernel import Kernel
from ...core.wires.net import Net
from ..base.part import Part
from ..base.written_data import Data, as_bytes

ADDRESSES = 256
STOPPER = 0xFF
STOPS = ("data", "address")


def _fits(image: Sized) -> str:
    size = len(image)
    return f"an image of {size} bytes; eight address lines reach {ADDRESSES}" if size > ADDRESSES else ""


class Prom(Part):
    """A PROM of 256 bytes with its address counter."""

    _for_users = ("address", "image", "preset", "ended")
    wiring = MappingProxyType({"db": "data", "request": "request", "ready": "ready", "load": "reset"})

    options = (
        Option("image", "bytes", ..., "content from address 0 on; the rest is FF, as in an erased PROM", check=_fits),
        Option("start", "int", 0, "initial address; switches on p0 to p7 override it", low=0, high=255),
        Option(
            "stop", "choice", "data", "end of a program: the byte FF, or (binary programs) address FF", choices=STOPS
        ),
    )

    def __init__(self, kernel: Kernel, name: str, *, image: Data, start: int, stop: str) -> None:
        super().__init__(kernel, name)
        data = as_bytes(name, image)
        self.image = data.ljust(ADDRESSES, bytes([STOPPER]))
        self._by_address = stop == "address"
        self.add_bus("db", "the byte at the address")
        self.add_pin("ready", "in", "high: the chip takes a byte", pull=1)
        self.add_pin("load", "in", "low: the counter takes p0 to p7", pull=1, active=0)
        self.add_pin("request", "out", "I/O REQUEST", initial=1)
        for bit in range(8):
            self.add_pin(f"p{bit}", "in", f"preset of the counter, bit {bit}", pull=start >> bit & 1)
        self.address = start
        self._requesting = False

    def rewired(self) -> None:
        """Preset the address counter and start to follow the pins, now that the part is wired."""
        for name in ("ready", "load", *(f"p{bit}" for bit in range(8))):
            self.pin(name).net.watch(self._react)
        self.address = self.preset
        self._react()

    @property
    def preset(self) -> int:
        """The address set by pins p0 to p7, which the counter takes while `load` is low."""
        return sum(self.high(f"p{bit}") << bit for bit in range(8))

    @property
    def ended(self) -> bool:
        """True while the address counter is at the program's end: a byte FF or, with `stop="address"`, address FF."""
        return (self.address if self._by_address else self.image[self.address]) == STOPPER

    def _react(self, _net: Net | None = None) -> None:
        ready, loading = self.high("ready"), self.net("load").is_active
        if self._requesting and not ready:  # I/O REQUEST rises
            self._requesting = False
            if loading:
                text = f"pin load was still low when byte {self.address:#04x} was read: the byte is sent again"
                self.finding("load-held", text)
            else:
                self.address = (self.address + 1) % ADDRESSES
        if loading:
            self.address = self.preset
        self._requesting = ready and not self.ended
        self.drivers["request"].drive(int(not self._requesting))
        self.drivers["db"].drive((0xFF, self.image[self.address]))

    @property
    def idle(self) -> bool:
        """True if the part will change nothing unless an input changes."""
        return self.ended

    @property
    def waiting(self) -> str:
        """Event or condition that the part waits for."""
        return f"{self.name}: at address {self.address:#04x}, " + ("the end" if self.ended else "waits for READY")
