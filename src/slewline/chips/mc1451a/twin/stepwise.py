"""The chipset's motion, cycle by cycle: the slow and obvious reference for the fast path.

The fast path computes blocks of cycles ahead.  This twin processes each cycle when it begins, one axis after another
(twin_axis.py), and samples the pins at that time; it watches HOME and the encoder edge by edge (twin_inputs.py).
"""

from __future__ import annotations

from ....core.context import ChipContext
from ....core.wires.waits import until
from .. import sheet
from ..activity import Activity
from ..interrupt import HostInterrupt
from ..registers import AxisState, Registers
from .twin_axis import TwinAxis
from .twin_inputs import TwinEncoder, TwinFilter


class Stepwise:
    """The slow twin, which processes every cycle of all axes."""

    def __init__(self, chip: ChipContext, registers: Registers, interrupt: HostInterrupt, activity: Activity) -> None:
        self.chip, self.kernel, self.registers = chip, chip.kernel, registers
        self.interrupt, self.activity = interrupt, activity
        self.running = False
        self.origin = 0  # tick at which cycle 0 began
        self.begun = 0  # cycles since then, the present one included
        numbers = range(1, len(chip.axes) + 1)
        self.homes = [TwinFilter(chip, f"home{number}") for number in numbers]
        self.encoders = [TwinEncoder(chip, number) if chip.sheet.encoder else None for number in numbers]
        self.courses: list[TwinAxis] = []

    def start(self) -> None:
        """Begin cycle 0 after reset."""
        self.origin, self.begun = self.chip.clock.ticks_from(self.kernel.now), 0
        for home, encoder in zip(self.homes, self.encoders, strict=True):
            home.begin()
            if encoder is not None:
                encoder.begin()
        self.courses = [
            TwinAxis(self.chip, self.registers, state, home, encoder)
            for state, home, encoder in zip(self.registers.states, self.homes, self.encoders, strict=True)
        ]
        self.running = True
        self.task = self.kernel.spawn(self.run, name=f"{self.chip.name}: cycles")
        self.catch_up()

    @property
    def cycle(self) -> int:
        """The number of the present cycle; 0 before the first cycle begins."""
        return max(self.begun - 1, 0)

    async def run(self) -> None:
        """Process each cycle when it begins."""
        while True:
            await until(self.kernel, self.begins(self.begun))
            self.catch_up()

    def begins(self, cycle: int) -> int:
        """Return the instant (ps) at which a cycle begins."""
        return self.chip.clock.ps(self.origin + sheet.CYCLE_TICKS * cycle)

    def catch_up(self) -> None:
        """Process the cycles that have begun by now."""
        while self.running and self.begins(self.begun) <= self.kernel.now:
            self.begun += 1
            for course in self.courses:
                course.cycle(self.cycle, self.origin + sheet.CYCLE_TICKS * self.cycle)
            self.interrupt.look()
            self.activity.worked()

    def attend(self) -> None:
        """Note which motors are off after a command: switching a motor off, even briefly, ends its motion."""
        for course in self.courses:
            course.was_off |= not course.state.motor_on

    def declare(self, state: AxisState, value: int) -> None:
        """Set the position of an axis without a step; a move to a destination continues from that position."""
        self.courses[state.number - 1].relocate(value)
        if self.chip.sheet.encoder:
            state.actual = value

    def stop(self) -> None:
        """Stop for a reset or loss of supply: no cycle begins, and no step is made after this instant."""
        if self.running:
            self.task.kill()
            self.running, self.begun = False, 0
            for course in self.courses:
                course.cut()
