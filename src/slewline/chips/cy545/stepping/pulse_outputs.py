r"""The outputs to a motor: PULSE, CCW, STOPPED and SLEW.

      begin          begin'
    ‾‾‾|__|‾‾‾‾‾‾‾‾‾‾‾|__|‾‾‾    PULSE: low for a fixed time, whatever the rate
    ‾‾\____________________...   STOPPED: low before the first step, high about 5 ms after the last one has ended

CCW and SLEW are weak when high, so that other outputs may pull them low.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ....core.context import ChipContext
from ....core.motion.motions import MotionParameters
from ....core.motion.step_views import StrobeView
from ....core.motion.train import Playing
from ....core.wires.net import Driver
from ...cy5xx.stepping import phase_outputs
from ..registers import Registers

NO_PHASES = ((),)


class Weak:
    """An output whose high level comes only from a pull-up, so that other outputs may pull it low."""

    def __init__(self, driver: Driver) -> None:
        self.driver = driver

    def drive(self, level: int | None) -> None:
        """Pull the pin low if the level is 0; otherwise release it."""
        self.driver.drive(0 if level == 0 else None)

    def activate(self, active: bool = True) -> None:
        """Set the pin active, or inactive if `active` is False."""
        self.drive(self.driver.level_when(active))

    def deactivate(self) -> None:
        """Set the pin inactive."""
        self.activate(False)


class StepOutputs(phase_outputs.StepOutputs):
    """PULSE, CCW, STOPPED and SLEW, and a record of the motor's motions."""

    registers: Registers

    def __init__(self, chip: ChipContext, registers: Registers, ticks: Mapping[str, int]) -> None:
        self.low, self.hold = ticks["pulse_low"], ticks["hold"]
        self.stopped, self.ccw = chip.drivers["stopped"], Weak(chip.drivers["ccw"])
        self.axis, self.direction_net = chip.axes[0], chip.pins["ccw"].net
        self.stopped_changes = 0  # the number of times STOPPED has been driven
        self.motions = 0  # number of motions so far
        super().__init__(chip, registers, NO_PHASES, 0)
        self.slew = Weak(chip.drivers["slew"])  # type: ignore[assignment]

    def clear(self) -> None:
        """Set all outputs to their idle levels, for RESET and the command I."""
        super().clear()
        self.pulse.deactivate()
        self.moving(False)
        Weak(self.chip.drivers["slew"]).deactivate()
        self.point(self.registers.clockwise)

    def turn(self, clockwise: bool) -> None:
        self.registers.clockwise, self.registers.directed = clockwise, True
        self.point(clockwise)

    def point(self, clockwise: bool) -> None:
        """Drive CCW to show a direction, without changing the direction that the host has set."""
        self.ccw.drive(0 if clockwise else 1)

    @property
    def sign(self) -> int:
        """The direction in which a step would count: 1 while CCW is low, whatever pulls it low; otherwise -1."""
        return 1 if self.direction_net.level == 0 else -1

    def expected(self, sign: int) -> int:
        """Return the direction in which steps will count while the chip itself drives CCW for `sign`.

        It is 1 if another output pulls CCW low, otherwise `sign`.
        """
        own, seen = self.chip.drivers["ccw"], self.chip.kernel.seen
        pulled = any(driver.at(seen) == 0 for driver in self.direction_net.drivers if driver is not own)
        return 1 if pulled else sign

    def promise(self, playing: Playing, sign: int) -> None:
        """Promise the PULSE edges of a step train, before they are due."""
        self.pulse.play(StrobeView(playing, self.low))

    # ------------------------------------------------------------------------------------------------------- a motion
    def begin(self, text: str, parameters: Callable[[], MotionParameters], sign: int) -> int:
        """Begin to record a motion; return its number, which is 1 for the first motion."""
        self.axis.log.begin(text, parameters, self.expected(sign))
        self.motions += 1
        return self.motions

    def moving(self, on: bool) -> None:
        """Drive STOPPED now, low if `on`, otherwise high; cancel a pending change of STOPPED."""
        self.stopped_changes += 1
        self.stopped.activate(not on)

    def stops(self, tick: int, motion: int) -> None:
        """End a step at a tick; unless another step follows, STOPPED rises and the motion ends `hold` ticks later."""
        self.stopped_changes += 1
        changes = self.stopped_changes

        def over() -> None:
            if self.stopped_changes == changes:
                self.moving(False)
                if self.motions == motion:
                    self.axis.log.end()

        self.chip.kernel.call_at(self.chip.clock.ps(tick + self.hold), over)
