"""One axis as its user sees it: its position, now and in the past, its steps, its motions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar

from ...errors import UsageError
from ..messages.calls import answering
from ..messages.instead import face
from ..messages.whole import whole
from ..time.hook import Hook
from ..time.kernel import Kernel
from ..time.timebase import Time, moments, readable, window
from ..wires.pin import Condition
from .axis import Axis, Steps
from .motions import Mark, MotionEnd, MotionParameters, MotionStart
from .quantity import Position, Quantity, Velocity

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .deviation import Deviation


class ReachesCondition(Condition):
    """The condition that the position register of an axis has a certain value."""

    def __init__(self, of: OneAxis, position: int) -> None:
        allowed, number = of.motor.positions, whole(position)
        if number is None or number not in allowed:
            raise UsageError(f"{of.name}: position {position!r}; allowed {allowed[0]}..{allowed[-1]}")
        self.motor, self.position, self.text = of.motor, number, f"{of.name} at position {number}"
        self.kernel = of.kernel

    def belongs(self, kernel: Kernel) -> bool:
        """Return whether the axis is on the bench of this kernel."""
        return self.kernel is kernel

    def met(self) -> bool:
        """Return whether the register has this value now."""
        return self.motor.position == self.position

    def when(self) -> int | None:
        return self.motor.arrives(self.position)


@face
class OneAxis:
    """One axis of a chip as seen by users; the chip object itself serves as its axis 1."""

    _for_users: ClassVar[tuple[str, ...]] = (
        *("position", "travel", "position_at", "velocity_at", "steps", "motions", "marks", "phases", "parameters"),
        *("reaches", "quantities", "deviation", "registers", "motor", "on_motion_begin", "on_motion_end", "name"),
    )
    _to_set: ClassVar[Mapping[str, str]] = {
        "position": "the part counts it; a host sends the command that loads or clears it: bench.host(x).send(...)",
        "registers": "a host sends the commands that load them: bench.host(x).send(...)",
        **dict.fromkeys(("on_motion_begin", "on_motion_end"), "add a listener: .add(function)"),
    }
    kernel: Kernel
    name: str

    @property
    def motor(self) -> Axis:
        """The `Axis` that holds the position of the motor, now and in the past."""
        raise NotImplementedError

    @property
    def position(self) -> int:
        """The position register now, in steps, exact even during a move; clockwise steps count up."""
        return self.motor.position

    @property
    def travel(self) -> int:
        """The net number of steps since time 0, clockwise positive, without wrap-around."""
        return self.motor.travel

    def steps(self, start: Time | None = None, stop: Time | None = None) -> Steps:
        """Return the steps that begin in start <= t <= stop; by default, all steps that are kept, up to now.

        Raises:
            TimeError: `start` or `stop` is not a time, or `stop` comes before `start`.
            NotRecorded: the past is no longer kept that far back (`Bench(keep=)`).
        """
        return self.motor.steps(*self._window(start, stop))

    def position_at(self, times: Time | Sequence[Time] | NDArray[np.int64]) -> NDArray[np.int64] | int:
        """Return the value of the position register, in steps, at one or several past instants.

        Args:
            times: "3 ms" or picoseconds, a list of them, or an array of int64 picoseconds.

        Returns:
            An int for one instant; an int64 array for several: (n,) for a list, the same shape for an array.

        Raises:
            TimeError: an instant is not a time.
            UsageError: an instant is in the future.
            NotRecorded: the past is no longer kept that far back (`Bench(keep=)`).
        """
        instants = self._past(times)
        return self.motor.position_at(instants) if isinstance(instants, int) else self.motor.positions_at(instants)

    def velocity_at(self, times: Time | Sequence[Time] | NDArray[np.int64]) -> NDArray[np.float64] | float:
        """Return the velocity at one or several past instants, in steps/s, negative counter-clockwise.

        This is the rate at which the chip outputs its steps: 1/interval of the step in progress, and 0 at rest.

        Args:
            times: "3 ms" or picoseconds, a list of them, or an array of int64 picoseconds.

        Returns:
            A float for one instant; a float64 array for several: (n,) for a list, the same shape for an array.

        Raises:
            TimeError: an instant is not a time.
            UsageError: an instant is in the future.
            NotRecorded: the past is no longer kept that far back (`Bench(keep=)`).
        """
        instants = self._past(times)
        return self.motor.velocity_at(instants) if isinstance(instants, int) else self.motor.velocities_at(instants)

    def _past(self, times: Time | Sequence[Time] | NDArray[np.int64]) -> NDArray[np.int64] | int:
        instants = moments(times)
        last = instants if isinstance(instants, int) else int(instants.max(initial=0))
        if last > self.kernel.now:
            raise UsageError(f"{self.name}: {readable(last)} is in the future; the time is {readable(self.kernel.now)}")
        return instants

    def quantities(self) -> tuple[Quantity, ...]:
        """Return the quantities of this axis for pictures: velocity, position, and others that the part defines."""
        return Velocity(self.motor), Position(self.motor)

    def reaches(self, position: int) -> Condition:
        """Return a condition that is met when the position register has the given value.

        Raises:
            UsageError: the register cannot hold this value; the message states its range.
        """
        return ReachesCondition(self, position)

    @property
    def registers(self) -> dict[str, int]:
        """The values of the registers, keyed by their names in the manual, in lower case."""
        return {}

    def motions(self, start: Time | None = None, stop: Time | None = None) -> list[MotionStart]:
        """Return the motions that begin in start <= t <= stop; by default, all motions that are kept.

        Each motion has the command that began it, the rates in force (steps/s), its end, and its ideal if the
        part defines one.

        Raises:
            TimeError: `start` or `stop` is not a time, or `stop` comes before `start`.
            NotRecorded: the past is no longer kept that far back (`Bench(keep=)`).
        """
        return self.motor.motions(*self._window(start, stop))

    @property
    def on_motion_begin(self) -> Hook[[MotionStart]]:
        """The hook that is called with the `MotionStart` of every motion of this axis as it begins."""
        return self.motor.log.on_begin

    @property
    def on_motion_end(self) -> Hook[[MotionEnd]]:
        """The hook that is called with the `MotionEnd` of every motion of this axis as it ends."""
        return self.motor.log.on_end

    def marks(self, start: Time | None = None, stop: Time | None = None) -> list[Mark]:
        """Return the events of this axis in start <= t <= stop, except starts and ends of motions.

        The events include commands given during a motion, limits and home.  By default, all events that are kept
        are returned.

        Raises:
            TimeError: `start` or `stop` is not a time, or `stop` comes before `start`.
            NotRecorded: the past is no longer kept that far back (`Bench(keep=)`).
        """
        return self.motor.marks(*self._window(start, stop))

    def phases(self, start: Time | None = None, stop: Time | None = None) -> list[tuple[int, int, str]]:
        """Return the phases of motions between `start` and `stop`, cut off at both; by default, all that are kept.

        Returns:
            For each phase its start and its end, ps, and its name: "up", "slew", "down" ...

        Raises:
            TimeError: `start` or `stop` is not a time, or `stop` comes before `start`.
            NotRecorded: the past is no longer kept that far back (`Bench(keep=)`).
        """
        return self.motor.phases(*self._window(start, stop))

    @answering("deviation()", "; for motion in x.motions(): x.deviation(motion)")
    def deviation(self, motion: MotionStart) -> Deviation:
        """Return the greatest deviations, in magnitude, of the axis from the ideal of a motion.

        The comparison begins at the start of the ideal.  It ends at the end of the ideal, or at the present
        instant if that comes earlier.

        Raises:
            UsageError: the argument is not a motion, or the motion has no ideal.
        """
        from .deviation import deviation

        if not isinstance(motion, MotionStart):
            raise UsageError(f"{self.name}: deviation({motion!r}): expected a motion, such as {self.name}.motions()[0]")
        if motion.ideal is None:
            raise UsageError(
                f"{self.name}: the motion {motion.text} at {readable(motion.time_ps)} has no ideal motion "
                "to compare it with"
            )
        return deviation(self.motor, motion.ideal)

    def _window(self, start: Time | None, stop: Time | None) -> tuple[int, int]:
        return window(start, stop, self.kernel.now, self.motor.since)

    def parameters(self) -> MotionParameters:
        """Return the parameters of the latest motion, as plots show them; empty before the first motion.

        Returns:
            Rates in steps/s ("R = 80" -> 5978.0), and further parameters ("S" -> 200).
        """
        latest = self.motor.log.latest()
        return MotionParameters() if latest is None else MotionParameters(latest.rates, latest.notes)
