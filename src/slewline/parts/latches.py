"""Latches on the outputs of a chip: the position on the fly (fig. 6.3), and the phases (fig. 4.1)."""

from __future__ import annotations

from types import MappingProxyType

from ..core.kernel import Kernel
from ..core.net import Net
from .part import Part


class PositionLatch(Part):
    """Two 74LS373 that catch the position which a chip puts out while stepping (s.6).

        enable of the high byte = OUTSTROBE low and pin 37 high        (NOR gates)
        enable of the low byte  = OUTSTROBE low and pin 37 low

    A latch is transparent while enabled and keeps what is on the bus when OUTSTROBE rises.  Later the host pulls
    `read_high` or `read_low` low and finds the byte on the same bus; the chip is in high impedance then.  The strobes
    of a verify read-out pass through the same gates.
    """

    wiring = MappingProxyType({"db": "db", "outstrobe": "outstrobe", "motion_complete": "motion_complete"})

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_bus("db", "data bus, in and out")
        self.add_pin("outstrobe", "in", "pin 10 of the chip", pull=1)
        self.add_pin("motion_complete", "in", "pin 37 of the chip", pull=1)
        self.add_pin("read_high", "in", "low: the high byte on the bus", pull=1)
        self.add_pin("read_low", "in", "low: the low byte on the bus", pull=1)
        self.high_byte = self.low_byte = 0xFF

    def rewired(self) -> None:
        for name in ("db", "outstrobe", "motion_complete"):
            self.pin(name).net.watch(self._latch)
        for name in ("read_high", "read_low"):
            self.pin(name).net.watch(self._put)

    def _latch(self, _net: Net) -> None:
        if not self.high("outstrobe"):
            if self.high("motion_complete"):
                self.high_byte = self.byte("db")
            else:
                self.low_byte = self.byte("db")

    def _put(self, _net: Net) -> None:
        level = None
        if not self.high("read_high"):
            level = (0xFF, self.high_byte)
        elif not self.high("read_low"):
            level = (0xFF, self.low_byte)
        self.drivers["db"].drive(level)

    @property
    def position(self) -> int:
        """What the two latches hold."""
        return self.high_byte << 8 | self.low_byte


class PhaseLatch(Part):
    """A latch between phase pins and motor, clocked by the rise of PULSE (s.4).

    It keeps the coils energised when I or RESET switches the phase pins off without a PULSE.  `off` high switches all
    coils off, whatever the latch holds.  Low energises, as on the chip.
    """

    wiring = MappingProxyType({"pulse": "pulse"} | {f"phase{n}": f"phase{n}" for n in (1, 2, 3, 4)})

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("pulse", "in", "clock", pull=1)
        self.add_pin("off", "in", "high: coils off", pull=0)
        for n in (1, 2, 3, 4):
            self.add_pin(f"phase{n}", "in", f"phase {n} from the chip", pull=1)
            self.add_pin(f"coil{n}", "out", f"phase {n} to the motor", initial=1)
        self.held = (1, 1, 1, 1)

    def rewired(self) -> None:
        self.pin("pulse").net.watch(self._clocked)
        self.pin("off").net.watch(lambda _: self._put())

    def _clocked(self, net: Net) -> None:
        if net.level == 1:
            one, two, three, four = (int(self.high(f"phase{n}")) for n in (1, 2, 3, 4))
            self.held = (one, two, three, four)
            self._put()

    def _put(self) -> None:
        off = self.high("off")
        for n, level in enumerate(self.held, 1):
            self.drivers[f"coil{n}"].drive(1 if off else level)
