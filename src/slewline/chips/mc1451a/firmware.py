r"""What the chipset is: reset, supply, the port, the cycles, and six parts that differ in axes and encoder inputs.

RESET    ‾‾\____/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾       1 us at least; RESET as a command does the same at once
cycle            |  0  |  1  | ...  |  9  | 10  |           327.68 us each, from the end of reset on
HostRdy  ‾‾\______________________________/‾‾‾‾‾‾‾‾‾‾       after ten cycles
"""

from __future__ import annotations

from typing import Any

from ...core.kernel import Kernel
from ...core.net import Net
from ...core.step_views import PulseView
from ...core.table import Row, Sheet
from ...core.timebase import readable
from ...core.train import OPEN, Playing, StepTrain
from . import sheet
from .instructions import Instructions
from .motion import Motion
from .port import Port
from .sheet import CLKOUT_TICKS, CYCLE_TICKS, POWER_UP_RESET_PS, TIMES

RESET_TICKS = TIMES["reset"].ticks
SELECTS = ("SET_1", "SET_2", "SET_3", "SET_4", "SET_I")  # like every GET, they change nothing that a cycle looks at


class Chipset(Instructions):
    """An MC1151A, MC1251A or MC1451A on a bench, or one of their -E versions."""

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        self.busy_ticks: int = self.options.busy_ticks
        self.ready_ticks: int = self.options.reset_cycles * CYCLE_TICKS
        self.handlers = {row.code: getattr(self, row.handler) for row in self.sheet.commands}
        self.powered = False
        self.unheeded = False  # a command has written what no cycle has seen yet
        self.starts = 0  # counts resets: what was due before one is not done
        self.up_ps = 0
        self.started = False  # the first command may come: reset is over
        if self.options.stepwise:
            from .stepwise import Stepwise

            self.motion = Stepwise(self)
        else:
            self.motion = Motion(self)
        self.port = Port(self)
        self.pins["reset"].net.watch(self._reset_changed)
        if not self.sheet.crystal_low_hz <= self.crystal_hz <= self.sheet.crystal_high_hz:
            self.finding("crystal", f"{self.crystal_hz / 1e6:g} MHz is outside the 6.7 to 25.6 MHz of the manual")
        if self.options.cold:
            self.idle = True
            self.waits("its supply")
        else:
            self._power_up()

    # ------------------------------------------------------------------------------------------------- supply and reset
    def power(self, on: bool) -> None:
        """Switch the supply.  A bare part comes up with the end of a power-up reset; else RESET says when."""
        self.check_switch(on)
        if on != self.powered:
            self.switched(on)
            self.kernel.call_at(self.kernel.now, self._power_up if on else self._power_off)
            self.kernel.settle()

    def _power_up(self) -> None:
        self.powered = True
        self.up_ps = self.fell_ps = self.kernel.now
        period = StepTrain(self.clock, self.clock.ticks_from(self.kernel.now) + 1, ((CLKOUT_TICKS, OPEN),))
        self.drivers["clkout"].play(PulseView(Playing(period), CLKOUT_TICKS // 2))
        self._clear()
        if self.pins["reset"].level != 0:
            self._start_in(RESET_TICKS)

    def _power_off(self) -> None:
        self._clear()
        self.powered, self.idle = False, True
        for driver in (*self.drivers.values(), self.bus_driver):
            driver.drive(None)
        self.waits("its supply")

    def reset(self) -> None:
        """Pull RESET low for 1 us."""
        self.pin("reset").pulse(0, self.clock.ps(RESET_TICKS))

    def _reset_changed(self, net: Net) -> None:
        """RESET acts behind all timed work of its instant."""
        if not self.powered:
            return
        if net.value == 0:
            self.fell_ps = self.kernel.now
            self._clear()
            return
        width, since = self.kernel.now - self.fell_ps, self.kernel.now - self.up_ps
        if width < (least := self.clock.ps(RESET_TICKS)):
            self.finding("short-reset", f"RESET low for {readable(width)}; at least {readable(least)}")
        if self.fell_ps == self.up_ps and since < POWER_UP_RESET_PS:
            self.finding("early-reset", f"RESET ends {readable(since)} after the supply came; at least 250 ms")
        self._start_in(0)

    def restart(self) -> None:
        """The command RESET."""
        self._clear()
        self._start_in(0)

    def _clear(self) -> None:
        """Everything to its state in reset."""
        self.starts += 1
        self.motion.stop()
        for axis in self.axes:
            axis.log.end("cut")
        self.forget()
        self.port.begin()
        self.outputs_reset()
        self.bus_driver.drive(None)
        self.idle = self.started = False
        self.waits("the end of reset")

    def _start_in(self, ticks: int) -> None:
        """Reset is over so many clocks from now."""
        starts = self.starts

        def start() -> None:
            if starts == self.starts:
                for axis in self.axes:
                    axis.load(0)
                self.motion.start()

        def ready() -> None:
            if starts == self.starts:
                self.motion.catch_up()
                self.port.open()
                self.started = True
                self.refresh_idle()

        self.origin = self.clock.ticks_from(self.kernel.now) + ticks
        self.kernel.call_at(self.clock.ps(self.origin), start)
        self.kernel.call_at(self.clock.ps(self.origin + self.ready_ticks), ready)

    # ---------------------------------------------------------------------------------------------------------- at work
    def perform(self, row: Row, value: int) -> int | None:
        """A packet is complete: do what it says; the registers show the present cycle.  Returns what is to be read."""
        handler = self.handlers[row.code]
        found: int | None = handler(value) if row.args else handler()
        if not row.name.startswith("GET") and row.name not in SELECTS:
            self.unheeded = True
            self.motion.attend()
        return found

    def interrupt(self) -> None:
        """With no interrupt pending, the lowest axis with an event that its mask lets through interrupts."""
        if not self.interrupting:
            for state in self.states:
                if state.interrupts:
                    self.interrupting = state.number
                    self.drivers["hostintrpt"].drive(0)
                    return

    def worked(self) -> None:
        """A cycle has been worked: what commands had written by then has been seen."""
        self.unheeded = any(state.update is not None for state in self.states)
        self.refresh_idle()

    def refresh_idle(self) -> None:
        """Something has begun or ended.  An axis whose breakpoint waits for a time is not idle."""
        busy = self.unheeded or not self.port.ready
        self.idle = not busy and not any(state.in_motion or state.breakpoint == "time" for state in self.states)
        awaited = self._awaited()
        if self.started and awaited != self._waiting[0]:
            self.waits(awaited)

    def _awaited(self) -> str:
        """What the chipset waits for when reset is over."""
        moving = [state.number for state in self.states if state.in_motion]
        if moving:
            return f"the motion of {'axis' if len(moving) == 1 else 'axes'} {', '.join(map(str, moving))}"
        for state in self.states:
            if state.breakpoint == "time":
                return f"time {state.comparison}, the breakpoint of axis {state.number}"
        return "a command"

    @property
    def armed(self) -> bool:
        """Does an axis have a breakpoint, which an input may meet at any time?"""
        return any(state.breakpoint for state in self.states)

    @property
    def answering(self) -> bool:
        """Is a byte or a word of the host in work?"""
        return not self.port.ready


class Mc1151A(Chipset):
    """An MC1151A: one axis."""

    sheet: Sheet = sheet.MC1151A


class Mc1251A(Chipset):
    """An MC1251A: two axes."""

    sheet: Sheet = sheet.MC1251A


class Mc1451A(Chipset):
    """An MC1451A: four axes."""

    sheet: Sheet = sheet.MC1451A


class Mc1151AE(Chipset):
    """An MC1151A-E: one axis with encoder input."""

    sheet: Sheet = sheet.MC1151A_E


class Mc1251AE(Chipset):
    """An MC1251A-E: two axes with encoder inputs."""

    sheet: Sheet = sheet.MC1251A_E


class Mc1451AE(Chipset):
    """An MC1451A-E: four axes with encoder inputs."""

    sheet: Sheet = sheet.MC1451A_E
