"""Power and RESET.

A reset is detected if RESET is low for 15 µs (at 6 MHz), but after power-up only if it is low for 10 ms;
the capacitor of fig. 9.1 ensures this if nothing drives RESET.  The reset acts through an internal net,
so that it is the last event at its instant.  RESET's row in the sheet states the pin's active level.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple, Protocol

from ...core.context import ChipContext
from ...core.datasheet.table import Timing
from ...core.time.timebase import readable
from ...core.wires.net import Driver, Net


class PowerUp(NamedTuple):
    """The shortest RESET that is detected after power-up, and the RESET that the capacitor produces, both in ps.

    Neither depends on the crystal.
    """

    least_ps: int
    charged_ps: int


class Started(ChipContext, Protocol):
    """The members of a chip that its supply uses."""

    def start(self) -> None:
        """Start the firmware at this instant."""

    def stop(self) -> None:
        """Stop the firmware immediately."""


class Supplied(NamedTuple):
    """A chip's actions at power-up, power-down and reset."""

    powered_up: Callable[[], None]  # registers take their values after power-up; outputs are driven, the clock runs
    cleared: Callable[
        [], None
    ]  # the firmware has been killed: no program, no motion; flags and pointers as after reset
    driven: Callable[[bool], None]  # every output takes its level in reset; False, without supply: nothing is driven


class Supply:
    """The supply pins and RESET, which start and stop the firmware."""

    def __init__(self, chip: Started, supplied: Supplied, times: Mapping[str, Timing], power_up: PowerUp) -> None:
        self.chip, self.supplied, self.kernel, self.clock = chip, supplied, chip.kernel, chip.clock
        self.shortest, self.power_up = times["reset_pulse"], power_up
        self.pin = chip.pins["reset"].net
        self.active, self.rests = ("high", "low") if chip.sheet.pin("reset").active else ("low", "high")
        cold: bool = chip.options.cold
        self.powered, self.cold = not cold, cold
        self.reset_valid = False
        self.reset_fell = self.powered_at = 0
        self.inner_reset = Driver(Net(chip.kernel, f"{chip.name}.(reset seen)", active=0), chip.name)
        self.inner_reset.activate(cold)
        chip.kernel.settle()
        self.inner_reset.net.watch(self._on_inner_reset)
        self.pin.watch(self._on_reset)
        chip.waits("waiting for power")

    def switch(self, on: bool) -> None:
        """Switch the supply on or off.

        After power-up the registers have their power-up values, and RESET must be low for 10 ms; if nothing
        drives RESET, the capacitor of fig. 9.1 keeps it low.
        """
        chip = self.chip
        if on == self.powered:
            return
        chip.switched(on)
        self.powered, self.cold, self.reset_valid = on, True, False
        self.inner_reset.activate()
        if on:
            self.supplied.powered_up()
            self._power_up_reset()
        else:
            self.supplied.driven(False)
            chip.waits("waiting for power")
        self.kernel.settle()

    def _power_up_reset(self) -> None:
        """Start the power-up reset, timed by the capacitor of fig. 9.1 if RESET is undriven, otherwise by the pin."""
        on = self.powered_at = self.kernel.now
        if all(driver.at(self.kernel.seen) is None for driver in self.pin.drivers):
            charged = on + self.power_up.charged_ps
            self.chip.waits(f"waiting for the capacitor at RESET, charged at {readable(charged)}")
            self.kernel.call_at(charged, lambda: self._capacitor_charged(on))
            return
        self.chip.waits(f"waiting for RESET {self.active} for {self._least}")
        if self.pin.is_active:
            self._on_reset(self.pin)
        else:
            self.chip.finding(
                "no-power-up-reset", f"RESET is {self.rests} at power-up: the chip stays inert until a valid reset"
            )

    @property
    def _least(self) -> str:
        return f"{self.power_up.least_ps / 1_000_000_000:g} ms"

    def _capacitor_charged(self, on: int) -> None:
        """End the reset that began with the power-up at `on` (ps), unless it is over or RESET is now driven active."""
        if self.powered and self.cold and self.powered_at == on:
            if self.pin.is_active:
                self.reset_valid = True
            else:
                self.cold = False
                self.inner_reset.deactivate()

    def _on_reset(self, net: Net) -> None:
        if not self.powered:
            return
        if net.is_active:
            fell = self.reset_fell = self.kernel.now
            warm = self.clock.ps(self.clock.ticks_until(fell) + self.shortest.ticks)
            seen = fell + self.power_up.least_ps if self.cold else warm
            self.kernel.call_at(seen, lambda: self._reset_seen(fell))
        elif self.reset_valid:
            self.reset_valid = self.cold = False
            self.inner_reset.deactivate()
        elif self.cold:
            self.chip.finding(
                "reset-short",
                f"RESET {self.active} for less than {self._least} after power-up: the chip stays inert",
            )
        else:
            least = f"{self.shortest.us:g} µs at {self.shortest.mhz:g} MHz"
            self.chip.finding("reset-short", f"RESET was {self.active} for less than {least}: it was ignored")

    def _reset_seen(self, fell: int) -> None:
        """Stop the firmware if RESET has been active without interruption since `fell` (ps).

        The stop acts through an internal net, so that it is the last event at this instant.
        """
        if self.powered and self.pin.is_active and self.reset_fell == fell:
            self.reset_valid = True
            if self.cold:
                self.chip.waits(f"waiting for RESET {self.rests}")
            self.inner_reset.activate()

    def _on_inner_reset(self, net: Net) -> None:
        self.chip.stop()
        if net.is_inactive:
            self.chip.start()
            return
        self.supplied.cleared()
        self.supplied.driven(self.powered)
        self.chip.waits(f"waiting for RESET {self.rests}" if self.powered else "waiting for power")
