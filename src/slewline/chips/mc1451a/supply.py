r"""The supply and the three causes of a reset: power-up, RESET low, RESET as a command.

RESET    ‾‾\____/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾       at least 1 µs; RESET as a command acts immediately
cycle            |  0  |  1  | ...  |  9  | 10  |           327.68 µs each, from the end of the reset
HostRdy  ‾‾\______________________________/‾‾‾‾‾‾‾‾‾‾       after ten cycles
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ...core.context import ChipContext
from ...core.time.timebase import readable
from ...core.wires.net import Net
from .cycle_clock import CycleClock


class Supplied(NamedTuple):
    """The functions that perform a chipset's actions at power-up, power-down and RESET."""

    clock_runs: Callable[[], None]  # the supply is on, and so is CLKOUT
    cleared: Callable[[], None]  # reset has begun: no packet, no motion; registers and outputs as the manual lists them
    begin: Callable[[], None]  # reset is over: cycle 0 begins
    open: Callable[[], None]  # the first command may arrive
    released: Callable[[], None]  # the supply is off: no output is driven


class Supply:
    """The supply and RESET.

    `starts` counts the resets.  Work that was scheduled before a reset is dropped, because the count has
    changed.
    """

    def __init__(
        self, chip: ChipContext, cycles: CycleClock, supplied: Supplied, ready_ticks: int, power_up_reset_ps: int
    ) -> None:
        self.chip, self.kernel, self.clock, self.cycles = chip, chip.kernel, chip.clock, cycles
        self.supplied, self.ready_ticks, self.power_up_reset_ps = supplied, ready_ticks, power_up_reset_ps
        self.reset_ticks = chip.sheet.times["reset"].ticks
        self.net = chip.pins["reset"].net
        self.powered = False
        self.starts = 0
        self.restarting = False  # RESET is the command in progress
        self.up_ps = self.fell_ps = 0  # times at which the supply came up and RESET fell
        self.net.watch(self._reset_changed)

    # ---------------------------------------------------------------------------------------------------------- supply
    def switch(self, on: bool) -> None:
        """Switch the supply on or off."""
        if on != self.powered:
            self.chip.switched(on)
            self.kernel.call_at(self.kernel.now, self.come if on else self._go)
            self.kernel.settle()

    def come(self) -> None:
        """Power up.  The rise of RESET starts the chipset; if RESET is already high, the chipset starts by itself."""
        self.powered = True
        self.up_ps = self.fell_ps = self.kernel.now
        self.supplied.clock_runs()
        self._clear()
        if not self.net.is_active:
            self._start_in(self.reset_ticks)

    def _go(self) -> None:
        self._clear()
        self.powered = False
        self.supplied.released()

    # ----------------------------------------------------------------------------------------------------------- reset
    def pulse(self) -> None:
        """Pull RESET low for 1 µs."""
        self.chip.pins["reset"].pulse(0, self.clock.ps(self.reset_ticks))

    def _reset_changed(self, net: Net) -> None:
        """Begin or end a reset when RESET has changed, once all timed work of this instant is done."""
        if not self.powered:
            return
        if net.value == net.active_level:
            self.fell_ps = self.kernel.now
            self._clear()
            return
        width, since = self.kernel.now - self.fell_ps, self.kernel.now - self.up_ps
        if width < (least := self.clock.ps(self.reset_ticks)):
            self.chip.finding(
                "short-reset", f"RESET was low for {readable(width)}; required at least {readable(least)}"
            )
        if self.fell_ps == self.up_ps and since < self.power_up_reset_ps:
            self.chip.finding("early-reset", f"RESET ended {readable(since)} after power-on; required at least 250 ms")
        self._start_in(0)

    def request(self) -> None:
        """Request a reset when the packet in progress, the RESET command, is complete."""
        self.restarting = True

    def restarted(self) -> bool:
        """Restart if the packet that has just ended was the RESET command; return whether it was."""
        if not self.restarting:
            return False
        self._clear()
        self._start_in(0)
        return True

    def _clear(self) -> None:
        """Begin a reset."""
        self.starts += 1
        self.restarting = False
        self.supplied.cleared()

    def _start_in(self, ticks: int) -> None:
        """End the reset after `ticks` clocks, when cycle 0 begins; open the host port `ready_ticks` clocks later."""
        starts = self.starts

        def start() -> None:
            if starts == self.starts:
                self.supplied.begin()

        def ready() -> None:
            if starts == self.starts:
                self.supplied.open()

        self.cycles.origin = origin = self.clock.ticks_from(self.kernel.now) + ticks
        self.kernel.call_at(self.clock.ps(origin), start)
        self.kernel.call_at(self.clock.ps(origin + self.ready_ticks), ready)
