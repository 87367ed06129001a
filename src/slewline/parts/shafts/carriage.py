"""Parts between a motor and its load: a gear, and a carriage with backlash and hard stops."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from ...core.datasheet.option import Option
from ...errors import UsageError
from ..base.part import Part
from .sensors import fraction, fraction_or_none
from .shaft import BacklashShaft, GearedShaft, Shaft, forget_shaft, shaft_quantities

if TYPE_CHECKING:
    from ...core.motion.quantity import Quantity
    from ...core.time.kernel import Kernel


class Gear(Part):
    """A gear on a shaft, with an output shaft of its own.

    Args:
        on: the part that drives the gear.
        pinion: number of teeth of the driving wheel.
        wheel: number of teeth of the driven wheel.
        reverse: whether the driven shaft turns opposite to the driving shaft, as with two meshing wheels.
    """

    _for_users = ("position",)
    sits: ClassVar[Literal["", "may", "must"]] = "must"
    options = (
        Option("pinion", "int", 1, "teeth of the driving wheel", low=1),
        Option("wheel", "int", 1, "teeth of the driven wheel", low=1),
        Option("reverse", "bool", False, "the driven shaft turns in the opposite direction"),
    )
    quantities, forget = shaft_quantities, forget_shaft

    def __init__(
        self, kernel: Kernel, name: str, *, on: Shaft, pinion: int = 1, wheel: int = 1, reverse: bool = False
    ) -> None:
        super().__init__(kernel, name)
        self.shaft = GearedShaft(on, Fraction(-pinion if reverse else pinion, wheel))

    @property
    def position(self) -> float:
        """Position of the driven shaft, in steps; this shaft has as many steps per revolution as the motor."""
        return float(self.shaft.place)

    def shows(self) -> dict[str, Any]:
        """Return the position of the output shaft, in steps, and the number of steps per revolution."""
        return {"angle": float(self.shaft.place), "per_turn": self.shaft.per_turn}


class Carriage(Part):
    """A carriage that a shaft moves, with backlash, between hard stops.

    When the shaft reverses, the carriage stops until the backlash is taken up.  At a hard stop the shaft is
    blocked: further steps are lost and reported as a finding, and the carriage leaves the stop with the
    first step away from it.

    Args:
        on: the part that moves the carriage.
        backlash: the backlash, in steps.
        low, high: positions of the hard stops, in steps; None: no stop.
        start: the initial position, in steps, as if reached by a forward move.
        scale: travel per step, in `unit`.
        unit: the unit of the position, for example "mm".
    """

    _for_users = ("place", "lost", "scale", "unit")
    sits: ClassVar[Literal["", "may", "must"]] = "must"
    options = (
        Option(
            "backlash",
            "float",
            0,
            "travel of the shaft, after a reversal, before the carriage follows",
            low=0,
            unit="steps",
        ),
        Option("low", "float", None, "position of the lower hard stop; None: no stop", unit="steps", none=True),
        Option("high", "float", None, "position of the upper hard stop; None: no stop", unit="steps", none=True),
        Option("start", "float", 0, "initial position", unit="steps"),
        Option("scale", "float", 1, "travel per step, in `unit`"),
        Option("unit", "text", "steps", "unit of the position"),
    )
    forget = forget_shaft

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        on: Shaft,
        backlash: float = 0,
        low: float | None = None,
        high: float | None = None,
        start: float = 0,
        scale: float = 1,
        unit: str = "steps",
    ) -> None:
        super().__init__(kernel, name)
        for stop, beyond in ((low, low is not None and low > start), (high, high is not None and high < start)):
            if beyond:
                raise UsageError(f"{name}: start {start} is beyond the stop at {stop}; allowed low <= start <= high")
        self.scale, self.unit = fraction(scale), unit
        self.shaft = BacklashShaft(on, fraction(backlash), fraction(start))
        self._stops = fraction_or_none(low), fraction_or_none(high)
        self._swallowed = 0
        if low is not None or high is not None:
            self.shaft.stop_at(*self._stops)
            self.shaft.on_lost.add(self._lost)

    @property
    def place(self) -> float:
        """Position of the carriage, in `unit`."""
        return float(self.shaft.place * self.scale)

    def shows(self) -> dict[str, Any]:
        """Return the position and the hard stops (None: no stop) in the carriage's unit, and the unit itself."""
        low, high = (None if stop is None else float(stop * self.scale) for stop in self._stops)
        return {"place": self.place, "unit": self.unit, "low": low, "high": high}

    @property
    def lost(self) -> int:
        """Steps lost at the hard stops."""
        self.catch_up()
        return self._swallowed

    def catch_up(self) -> None:
        """Process the motion up to the last committed instant."""
        self.shaft.look(self.kernel.seen)

    def _lost(self, ps: int, steps: int, is_new: bool) -> None:
        motion = self.shaft.motion
        if motion.within(*self._stops).room != motion.room:
            return  # the hard stop of another load blocks the shaft
        self._swallowed += steps
        if is_new:
            text = f"the carriage hits a hard stop at {self.place:g} {self.unit}: steps are lost"
            self.finding("hard-stop", text, ps)

    def quantities(self) -> tuple[Quantity, ...]:
        """Return the position of the carriage over time as a quantity, for pictures, files and queries."""
        return (self.shaft.quantity("place", self.unit, float(self.scale)),)
