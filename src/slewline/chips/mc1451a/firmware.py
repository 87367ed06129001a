"""The chipset: it owns the objects listed below, and provides the public properties.

The six parts differ in the number of axes, and in whether they have encoder inputs.

Each object knows only those above it in this picture:

    Registers   CycleClock            plain numbers; the start times of cycles
      HostInterrupt   Activity        the interrupting axis; work in progress
        Supply                        power and RESET, which restart everything
          Motion | twin               process the cycles of all axes; the twin works cycle by cycle
            Instructions              one method per row of the sheet
              Port                    strobes become packets
      Chipset                         creates them

An object calls those below it only through functions passed to it; for example, the supply restarts them
this way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...core.chip import Chip
from ...core.datasheet.table import Sheet
from ...core.motion.axis import Axis
from ...core.motion.step_views import PulseView
from ...core.motion.train import OPEN, Playing, StepTrain
from ...core.time.kernel import Kernel
from . import sheet
from .activity import Activity
from .cycle_clock import CycleClock
from .host_port import Port
from .instructions import Instructions, Moves
from .interrupt import HostInterrupt
from .motion import Motion
from .omissions import forgotten, pending_of
from .profiles.cycles import ChipsetAxis
from .registers import Registers
from .supply import Supplied, Supply

if TYPE_CHECKING:
    from ...core.motion.one_axis import OneAxis


class Chipset(Chip):
    """An MC1151A, MC1251A or MC1451A on a bench, or one of their -E versions."""

    _for_users = ("powered",)

    def __init__(self, kernel: Kernel, name: str, /, crystal_hz: int | None = None, **given: Any) -> None:
        super().__init__(kernel, name, crystal_hz, **given)
        positions = range(-(1 << 30), 1 << 30)
        self.axes = tuple(Axis(kernel, positions, 0) for _ in range(self.sheet.axes))
        self.state = Registers(self.sheet.axes)
        self._cycle_clock = CycleClock(self.clock, sheet.CYCLE_TICKS)
        self._interrupt = HostInterrupt(self.drivers["hostintrpt"], self.state)
        self._activity = Activity(self, self.state)
        ready_ticks = self.options.reset_cycles * sheet.CYCLE_TICKS
        supplied = Supplied(self._clock_runs, self._cleared, self._begin, self._open, self._released)
        self._supply = Supply(self, self._cycle_clock, supplied, ready_ticks, sheet.POWER_UP_RESET_PS)
        self._motion = self._moves()
        self._instructions = Instructions(self, self.state, self._interrupt, self._activity, self._supply, self._motion)
        self._port = Port(self, self._activity, self._supply, self._motion, self._instructions, self.options.busy_ticks)
        if not self.sheet.crystal_low_hz <= self.crystal_hz <= self.sheet.crystal_high_hz:
            self.finding("crystal", f"{self.crystal_hz / 1e6:g} MHz is outside the 6.7 to 25.6 MHz of the manual")
        if self.options.cold:
            self.idle = True
            self.waits("waiting for its supply")
        else:
            self._supply.come()

    def _moves(self) -> Moves:
        """Create the object that processes the cycles: the fast one, or its slow twin."""
        if self.options.stepwise:
            from .twin.stepwise import Stepwise

            return Stepwise(self, self.state, self._interrupt, self._activity)
        return Motion(self, self.state, self._cycle_clock, self._interrupt, self._activity)

    # ------------------------------------------------------------------------------------------------- supply and reset
    def power(self, on: bool) -> None:
        """Switch the supply on or off.

        If RESET is low at power-up, its rise starts the chip; if RESET is high, the chip starts by itself.

        Raises:
            UsageError: `on` is neither True nor False.
        """
        self._check_switch(on)
        self._supply.switch(on)

    def reset(self) -> None:
        """Pull RESET low for 1 µs."""
        self._supply.pulse()

    def _cleared(self) -> None:
        """Begin a reset: discard the packet, end all motions, set registers and outputs as listed in the manual."""
        self._motion.stop()
        for axis in self.axes:
            axis.log.end("cut")
        self.state.clear()
        self._interrupt.clear()
        self._port.begin()
        self.outputs_reset()
        self.bus_driver.drive(None)
        self._activity.clear()
        self.waits("waiting for the end of reset")

    def _begin(self) -> None:
        """End a reset: set the positions to 0, and begin cycle 0."""
        for axis in self.axes:
            axis.load(0)
        self._motion.start()

    def _open(self) -> None:
        """Allow the first command after a reset."""
        self._motion.catch_up()
        self._port.open()

    def _clock_runs(self) -> None:
        """Start CLKOUT, which runs as long as the supply is on, regardless of anything else."""
        period = StepTrain(self.clock, self.clock.ticks_from(self.kernel.now) + 1, ((sheet.CLKOUT_TICKS, OPEN),))
        self.drivers["clkout"].play(PulseView(Playing(period), sheet.CLKOUT_TICKS // 2))

    def _released(self) -> None:
        """Release every output, because the supply is off."""
        for driver in (*self.drivers.values(), self.bus_driver):
            driver.drive(None)
        self.idle = True
        self.waits("waiting for its supply")

    # ------------------------------------------------------------------------------------------------ public properties
    @property
    def powered(self) -> bool:
        """True while the supply is on."""
        return self._supply.powered

    @property
    def registers(self) -> dict[str, int]:
        """The registers of axis 1, named after the commands that write and read them, as in "pos" for SET_POS."""
        return self.registers_of(1)

    def registers_of(self, number: int) -> dict[str, int]:
        """Return the registers of an axis (counted from 1), with the same names as in `registers`."""
        self._motion.catch_up()
        return self._known(self.state.by_name(number, self._motion.cycle), number if len(self.axes) > 1 else 0)

    def axis(self, number: int) -> OneAxis:
        """Return an axis by its number, counted from 1.

        Raises:
            UnknownName: there is no such axis; the message lists the axes.
        """
        super().axis(number)
        return ChipsetAxis(self, number, self._motion if isinstance(self._motion, Motion) else None)

    @property
    def armed(self) -> bool:
        """True if any axis has a breakpoint: a change of an input may then trigger it at any time."""
        return self._activity.armed

    def left_over(self) -> list[tuple[str, str]]:
        """Return the values that still wait for an update, as one finding (code, text) per axis concerned."""
        found = []
        for state in self.state.states:
            if pending := forgotten(pending_of(state.buffer), bool(state.breakpoint), state.auto_update):
                text = f"axis {state.number}: {', '.join(pending)} without an update"
                found.append(("no-update", f"{text}: send UPDATE, MULTI_UPDATE or a breakpoint"))
        return found

    @property
    def answering(self) -> bool:
        """True while the host port is not ready, for example while it processes a byte or a word from the host."""
        return not self._port.ready


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
    """An MC1151A-E: one axis with an encoder input."""

    sheet: Sheet = sheet.MC1151A_E


class Mc1251AE(Chipset):
    """An MC1251A-E: two axes with encoder inputs."""

    sheet: Sheet = sheet.MC1251A_E


class Mc1451AE(Chipset):
    """An MC1451A-E: four axes with encoder inputs."""

    sheet: Sheet = sheet.MC1451A_E
