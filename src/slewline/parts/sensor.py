"""What sits on a shaft and shows something of it on a wire: the base of encoders and switches."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from ..core.counter import Scale, StepCounter
from ..errors import UsageError
from .part import Part

if TYPE_CHECKING:
    from ..core.kernel import Kernel
    from ..core.shaft import Shaft


class Sensor(Part):
    """A part whose outputs follow the counts of a shaft, on a scale, `lag_ps` later."""

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.shaft: Shaft
        self._counter: StepCounter

    def sit(self, shaft: Shaft, scale: Scale, lag_ps: int) -> None:
        """Follow a shaft from now on."""
        self.shaft = shaft
        self._counter = StepCounter(shaft.course, scale, lag_ps)
        shaft.on_cut.add(self.cut)
        shaft.on_turn.add(self._turned)

    def cut(self, ps: int) -> None:
        """The course holds up to an instant only: follow it so far."""
        self._counter = self._counter.onward(ps)

    def _turned(self) -> None:
        self._counter = self._counter.on(self.shaft.course, self.kernel.now)
        self.promise()

    def promise(self) -> None:
        """Promise the outputs under the present course."""
        raise NotImplementedError


def exact(name: str, what: str, value: float | Fraction) -> Fraction:
    """A number that a user gave, as it is written: 0.1 is a tenth."""
    if isinstance(value, bool) or not isinstance(value, (int, float, Fraction)):
        raise UsageError(f"{name}: {what} {value!r}; expected a number")
    return Fraction(str(value)) if isinstance(value, float) else Fraction(value)
