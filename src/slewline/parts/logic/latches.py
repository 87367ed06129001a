"""Latches on the outputs of a chip: for the position while stepping (fig. 6.3) and for the phases (fig. 4.1)."""

from __future__ import annotations

from collections.abc import Iterable
from types import MappingProxyType

from ...core.time.events import Events, NoEvents
from ...core.time.kernel import Kernel
from ...core.wires.net import Net
from ...core.wires.views import gated
from ..base.clocked import Clocked
from ..base.counted import Sampled
from ..base.follower import start_rule
from ..base.part import Part

OR = (0, 1, 1, 1)


class PositionLatch(Part):
    """Two 74LS373 latches for the position that a chip outputs while stepping (s.6).

        enable of the high byte = OUTSTROBE low and pin 37 high        (NOR gates)
        enable of the low byte  = OUTSTROBE low and pin 37 low

    Each latch is transparent while enabled, and stores the byte on the bus when OUTSTROBE rises.  Later the
    host pulls `read_high` or `read_low` low and reads the stored byte from the same bus, while the chip does
    not drive it.  The strobes of a verify read-out pass through the same gates, so they change the latches.
    """

    _for_users = ("position", "high_byte", "low_byte")
    wiring = MappingProxyType({"db": "data", "outstrobe": "out_strobe", "motion_complete": "motion_complete"})

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_bus("db", "data bus, in and out")
        self.add_pin("outstrobe", "in", "pin 10 of the chip", pull=1)
        self.add_pin("motion_complete", "in", "pin 37 of the chip", pull=1)
        self.add_pin("read_high", "in", "low: the high byte on the bus", pull=1)
        self.add_pin("read_low", "in", "low: the low byte on the bus", pull=1)
        self.high_byte = self.low_byte = 0xFF

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
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
        """The position held in the two latches."""
        return self.high_byte << 8 | self.low_byte


class PhaseLatch(Part):
    """A latch between the phase pins and the motor, clocked by the rising edge of PULSE (s.4).

    The latch keeps the coils energised when the I command, or RESET, switches the phase pins off without a
    PULSE.  `off` high switches all coils off, regardless of the latch.  A low output energises its coil, as
    on the chip.
    """

    _for_users = ("held",)
    wiring = MappingProxyType({"pulse": "step"} | {f"phase{n}": f"phase{n}" for n in (1, 2, 3, 4)})
    rewired = start_rule

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("pulse", "in", "clock", pull=1)
        self.add_pin("off", "in", "high: coils off", pull=0)
        for n in (1, 2, 3, 4):
            self.add_pin(f"phase{n}", "in", f"phase {n} from the chip", pull=1, active=0)
            self.add_pin(f"coil{n}", "out", f"phase {n} to the motor", initial=1, role=f"phase{n}", active=0)
        self._coils = [Sampled(NoEvents(), 1, 1) for _ in range(4)]  # present and future contents of the latch
        inputs = ("pulse", "off", *(f"phase{n}" for n in (1, 2, 3, 4)))
        self.rule = Clocked(
            self, inputs, clock="pulse", edge=1, advance=self._advance, step=self._step, follow=self._follow
        )

    @property
    def held(self) -> tuple[int, ...]:
        """Levels in the latch, phases 1 to 4."""
        if self.rule.due:
            return self._read()
        return tuple(int(coil.level(self.kernel.seen)) for coil in self._coils)

    def _read(self) -> tuple[int, ...]:
        return tuple(int(self.high(f"phase{n}")) for n in (1, 2, 3, 4))

    # ------------------------------------------------------------------------------------------------------- changes
    def _advance(self, ps: int) -> None:
        """Update the contents of the latch to those at an instant (ps)."""
        self._hold(int(coil.level(ps)) for coil in self._coils)

    def _step(self) -> None:
        """Latch the present levels of the phase pins, because a clock edge occurs at this instant."""
        self._hold(self._read())

    def _hold(self, levels: Iterable[int]) -> None:
        self._coils = [Sampled(NoEvents(), level, level) for level in levels]

    def _follow(self, clock: Events) -> None:
        """Latch the phases at the edges of `clock` from now on."""
        off = self.rule.shown("off")
        for n, coil in enumerate(self._coils, 1):
            sampled = Sampled(clock, self.rule.shown(f"phase{n}"), coil.before)
            self._coils[n - 1] = sampled
            state = coil.before if isinstance(clock, NoEvents) else sampled
            self.rule.put(self.drivers[f"coil{n}"], gated((state, off), OR))
