"""Power and RESET of the CY525.

RESET low for 15 us (at 6 MHz) is seen; after power-up it takes 10 ms, which the capacitor of fig. 9.1 gives to a chip
whose RESET nobody drives.  The reset acts through an inner net, so it is the last thing that happens in its instant.
"""

from __future__ import annotations

from typing import Any

from ...core.kernel import Kernel
from ...core.net import Driver, Net
from ...core.timebase import readable
from . import sheet
from .state import State, T


class Supply(State):
    """The supply pins and RESET."""

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        cold: bool = self.options.cold
        self.powered, self.cold = not cold, cold
        self.reset_valid = False
        self.reset_fell = self.powered_at = 0
        self.inner_reset = Driver(Net(kernel, f"{name}.(reset seen)"), name)
        self.inner_reset.drive(0 if cold else 1)
        kernel.settle()
        self.inner_reset.net.watch(self._on_inner_reset)
        self.waits("power")
        if self.powered:
            self.outputs_high()
            self.clock_runs()

    def watch_inputs(self) -> None:
        super().watch_inputs()
        if self._on_reset not in self.reset_net.observers:
            self.reset_net.watch(self._on_reset)

    def power(self, on: bool) -> None:
        """Switch the supply.  After power-up the registers hold their power-up values, and RESET must be low for 10 ms;
        when nobody drives RESET, the capacitor of fig. 9.1 does it."""
        self.check_switch(on)
        if on == self.powered:
            return
        self.switched(on)
        self.powered, self.cold, self.reset_valid = on, True, False
        self.inner_reset.drive(0)
        if on:
            self.reg = {name: value for name, value in self.defaults.items() if name != "position"}
            self.axis1.load(self.defaults["position"])
            self.unset = set(self.defaults)
            self.outputs_high()
            self.clock_runs()
            self._power_up_reset()
        else:
            self.outputs_off()
            self.waits("power")
        self.kernel.settle()

    def _power_up_reset(self) -> None:
        """The supply has come: who holds RESET low for 10 ms?"""
        on = self.powered_at = self.kernel.now
        if all(driver.at(self.kernel.seen) is None for driver in self.reset_net.drivers):
            charged = on + sheet.POWER_UP_RC_PS
            self.waits(f"the capacitor at RESET, charged at {readable(charged)}")
            self.kernel.call_at(charged, lambda: self._capacitor_charged(on))
            return
        self.waits("RESET low for 10 ms")
        if self.reset_net.level == 0:
            self._on_reset(self.reset_net)
        else:
            self.finding("no-power-up-reset", "RESET is high at power-up: the chip stays inert until a valid reset")

    def _capacitor_charged(self, on: int) -> None:
        """RESET rises by itself, unless somebody holds it low by now."""
        if self.powered and self.cold and self.powered_at == on:
            if self.reset_net.level == 0:
                self.reset_valid = True
            else:
                self.cold = False
                self.inner_reset.drive(1)

    def reset(self) -> None:
        """Pulse RESET low for 20 us at 6 MHz from now on."""
        self.pin("reset").pulse(0, self.clock.ps(120) + 1)

    def _on_reset(self, net: Net) -> None:
        if not self.powered:
            return
        if net.level == 0:
            fell = self.reset_fell = self.kernel.now
            warm = self.clock.ps(self.clock.ticks_until(fell) + T["reset_pulse"])
            self.kernel.call_at(fell + sheet.POWER_UP_RESET_PS if self.cold else warm, lambda: self._reset_seen(fell))
        elif self.reset_valid:
            self.reset_valid = self.cold = False
            self.inner_reset.drive(1)
        elif self.cold:
            self.finding("reset-short", "RESET low for less than 10 ms after power-up: the chip stays inert")
        else:
            self.finding("reset-short", "RESET low for less than 15 us at 6 MHz: not seen")

    def _reset_seen(self, fell: int) -> None:
        """RESET has been low for long enough; the inner net makes the kill the last thing of the instant."""
        if self.powered and self.reset_net.level == 0 and self.reset_fell == fell:
            self.reset_valid = True
            if self.cold:
                self.waits("RESET high")
            self.inner_reset.drive(0)

    def _on_inner_reset(self, net: Net) -> None:
        self.stop()
        if net.level == 1:
            self.start()
            return
        self.end_run()
        self.motion.killed()
        self.on_command("")
        self.accepted = self.ended_wait = -1
        self.decoder.reset()
        self.reset_registers()
        if self.powered:
            self.outputs_high()
            self.waits("RESET high")
        else:
            self.outputs_off()
            self.waits("power")
