"""What lies between a motor and what it moves: a gear, and a carriage with backlash and hard stops."""

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
        on: what drives it.
        pinion: teeth of the wheel that drives.
        wheel: teeth of the one that is driven.
        reverse: the driven shaft turns the other way, as it does with two wheels.
    """

    _for_users = ("position",)
    sits: ClassVar[Literal["", "may", "must"]] = "must"
    options = (
        Option("pinion", "int", 1, "teeth of the wheel that drives", low=1),
        Option("wheel", "int", 1, "teeth of the wheel that is driven", low=1),
        Option("reverse", "bool", False, "the driven shaft turns the other way"),
    )
    quantities, forget = shaft_quantities, forget_shaft

    def __init__(
        self, kernel: Kernel, name: str, *, on: Shaft, pinion: int = 1, wheel: int = 1, reverse: bool = False
    ) -> None:
        super().__init__(kernel, name)
        self.shaft = GearedShaft(on, Fraction(-pinion if reverse else pinion, wheel))

    @property
    def position(self) -> float:
        """Steps that the driven shaft has turned, a step being that of a motor with as many a turn."""
        return float(self.shaft.place)

    def shows(self) -> dict[str, Any]:
        """Return where its shaft is, in steps, and how many make a turn."""
        return {"angle": float(self.shaft.place), "per_turn": self.shaft.per_turn}


class Carriage(Part):
    """A carriage that a shaft moves, with backlash, between hard stops.

    Where the shaft turns round it stops until the backlash is taken up.  At a hard stop the shaft is held:
    further steps are lost, with a finding, and it comes away at once in the other direction.

    Args:
        on: what moves it.
        backlash: steps.
        low, high: places of the hard stops, in steps; None: there is none.
        start: its place at the beginning, in steps; it has come there forward.
        scale: how far a step moves it, in `unit`.
        unit: of its place, for example "mm".
    """

    _for_users = ("place", "lost", "scale", "unit")
    sits: ClassVar[Literal["", "may", "must"]] = "must"
    options = (
        Option("backlash", "float", 0, "how far the shaft turns round before it follows", low=0, unit="steps"),
        Option("low", "float", None, "place of the lower hard stop; None: there is none", unit="steps", none=True),
        Option("high", "float", None, "place of the upper hard stop; None: there is none", unit="steps", none=True),
        Option("start", "float", 0, "place at the beginning", unit="steps"),
        Option("scale", "float", 1, "how far a step moves it, in `unit`"),
        Option("unit", "text", "steps", "of its place"),
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
                raise UsageError(f"{name}: start {start} lies beyond the stop at {stop}; allowed low <= start <= high")
        self.scale, self.unit = fraction(scale), unit
        self.shaft = BacklashShaft(on, fraction(backlash), fraction(start))
        self._stops = fraction_or_none(low), fraction_or_none(high)
        self._swallowed = 0
        if low is not None or high is not None:
            self.shaft.stop_at(*self._stops)
            self.shaft.on_lost.add(self._lost)

    @property
    def place(self) -> float:
        """Where it is, in its unit."""
        return float(self.shaft.place * self.scale)

    def shows(self) -> dict[str, Any]:
        """Return where it is, in its unit, and where its hard stops are, None where there is none."""
        low, high = (None if stop is None else float(stop * self.scale) for stop in self._stops)
        return {"place": self.place, "unit": self.unit, "low": low, "high": high}

    @property
    def lost(self) -> int:
        """Steps that its stops have swallowed."""
        self.catch_up()
        return self._swallowed

    def catch_up(self) -> None:
        """Work off what has happened up to the last committed instant."""
        self.shaft.look(self.kernel.seen)

    def _lost(self, ps: int, steps: int, anew: bool) -> None:
        motion = self.shaft.motion
        if motion.within(*self._stops).room != motion.room:
            return  # the stop of another load holds the shaft
        self._swallowed += steps
        if anew:
            self.finding("hard-stop", f"at {self.place:g} {self.unit} it runs into a stop: steps are lost", ps)

    def quantities(self) -> tuple[Quantity, ...]:
        """Return what the part has over time, to be drawn, written and asked."""
        return (self.shaft.quantity("place", self.unit, float(self.scale)),)
