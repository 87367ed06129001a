"""The position counter, its range, and the record of the motions that it counts.

set_out      first_step            departs            over, homed or cut
---.-------------|.....___---------------|---___----------|-----
                 |<-- ideal, from the first step ----->|
"""

from __future__ import annotations

from functools import partial

from ....core.motion.axis import Axis
from ....core.motion.train import OPEN
from ..ideal import RegistersAtStart
from ..profile import Law
from ..registers import Registers


class PositionCounter:
    """The counter of a module, and its present motion.

    Args:
        wraps: True if the counter wraps at its ends; otherwise a motion beyond them causes error E5.
    """

    def __init__(self, axis: Axis, registers: Registers, law: Law, wraps: bool) -> None:
        self.axis, self.log, self.kernel = axis, axis.log, axis.kernel
        self.registers, self.law, self.wraps = registers, law, wraps
        self.made = RegistersAtStart(0, 0, 0, law)  # parameters at the start of the motion
        self.homing = False  # the motion is a homing run, whose steps are not counted
        self.heading = 0  # the direction of an endless motion

    @property
    def position(self) -> int:
        """The present position."""
        return self.axis.position

    def load(self, position: int, text: str) -> None:
        """Set the counter, and mark this in the motion log with the command `text`."""
        self.axis.load(position)
        self.log.mark("command", text)

    def clear(self) -> None:
        """Set the counter to 0, its value after power-up."""
        self.axis.load(0)

    def room(self, steps: int) -> int:
        """Return the number of steps to the counter's end in the direction of `steps`; OPEN if the counter wraps."""
        if self.wraps:
            return OPEN
        return self.axis.positions[-1] - self.position if steps > 0 else self.position

    def full(self, direction: int, stopped: bool) -> bool:
        """Return whether an endless motion has reached the limit of the counter without being stopped by a command."""
        return self.room(direction) == 0 and not stopped

    # ------------------------------------------------------------------------------------------------------ a motion
    def set_out(self, text: str, direction: int, *, homing: int = 0, endless: bool = False) -> None:
        """Begin a motion.

        Args:
            text: the command that began the motion, as in the data sheet.
            direction: 1 clockwise, -1 counter-clockwise.
            homing: the speed of a homing run, in units of 10 steps/s; 0 for other motions.
            endless: True if the motion continues until an event ends it.
        """
        self.homing = homing > 0
        self.heading = direction if endless else 0
        self.made = (
            RegistersAtStart(homing, 0, 0, self.law) if homing else RegistersAtStart(*self.registers.speeds, self.law)
        )
        self.log.begin(text, self.made.homing if homing else self.made.parameters, direction)

    def first_step(self, sign: int, number: int | None, limit: int = OPEN) -> None:
        """Record that the first step begins now; the arguments are those of `RegistersAtStart.ideal`."""
        if not self.homing:
            self.log.expect(partial(self.made.ideal, self.kernel.now, self.position, sign, number, limit))

    def mark_deviation(self, kind: str = "", text: str = "") -> None:
        """Record that the motion departs from its plan; if `kind` is given, also mark the cause."""
        self.log.depart()
        if kind:
            self.log.mark(kind, text)

    def over(self, stopped: bool) -> None:
        """End the motion after its last pulse; `stopped` is True if a command stopped it."""
        self.log.end("limit" if self.heading and self.full(self.heading, stopped) else None)

    def homed(self) -> None:
        """End a homing run that has found the home position, and set the counter to 0."""
        self.axis.load(0)
        self.log.end()

    def cut(self) -> None:
        """End the motion prematurely."""
        self.log.end("cut")
