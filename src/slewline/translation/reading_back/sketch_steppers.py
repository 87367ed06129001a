"""The motors of a sketch that is being read back, as moved by the methods of the two stepper libraries."""

from __future__ import annotations

import math
from typing import Any

from .surroundings import Surroundings


class SketchPin(int):
    """The number of a pin, with the name of its constant in the sketch."""

    name: str

    def __new__(cls, value: int, name: str) -> SketchPin:
        """Return a pin with a number and a name."""
        made = super().__new__(cls, value)
        made.name = name
        return made


class SketchStepper:
    """A stepper object of either supported library; only its motion is modelled."""

    def __init__(self, axis: int, around: Surroundings) -> None:
        self.axis, self.around = axis, around
        self.position = self.target = 0
        self.top = self.even = self.acceleration = 0.0

    def call(self, name: str, values: list[Any]) -> Any:
        """Call the method `name` with the arguments `values`, and return its result.

        Raises:
            KeyError: the library does not have this method.
        """
        return getattr(self, f"_on_{name}", _unknown)(*values)

    def _on_setMaxSpeed(self, rate: float) -> None:
        self.top = rate

    def _on_setSpeedInMilliHz(self, rate: float) -> None:
        self.top = rate / 1000

    def _on_setAcceleration(self, acceleration: float) -> None:
        if acceleration <= 0:
            raise ValueError(f"acceleration {acceleration}; allowed more than 0")
        self.acceleration = acceleration

    def _on_setDirectionPin(self, pin: int) -> None:
        del pin

    def _on_setSpeed(self, rate: float) -> None:
        if abs(rate) > self.top:
            raise ValueError("the speed is above that of setMaxSpeed")
        self.even = rate

    def _on_move(self, steps: int, blocks: int = 0) -> None:
        self._on_moveTo(self.position + steps, blocks)

    def _on_moveTo(self, position: int, blocks: int = 0) -> None:
        self.target = position
        if blocks:
            self._on_runToPosition()

    def _on_runToPosition(self) -> None:
        reached = math.sqrt(self.acceleration * abs(self.target - self.position))
        self._go(min(self.top, reached))

    def _on_runSpeedToPosition(self) -> None:
        self._go(abs(self.even))

    def _go(self, rate: float) -> None:
        if self.target != self.position and rate <= 0:
            raise ValueError("the speed or the acceleration is not set")
        self.around.move(self.axis, self.target - self.position, rate)
        self.position = self.target

    def _on_distanceToGo(self) -> int:
        return self.target - self.position

    def _on_currentPosition(self) -> int:
        return self.position

    _on_getCurrentPosition = _on_currentPosition

    def _on_setCurrentPosition(self, position: int) -> None:
        self.position = self.target = position

    def _on_stop(self) -> None:
        self.target = self.position

    def _on_isRunning(self) -> int:
        return 0

    def _on_runForward(self) -> None:
        self.target = self.position + 1

    def _on_runBackward(self) -> None:
        self.target = self.position - 1

    _on_stopMove = _on_stop


def _unknown(*values: Any) -> Any:
    raise KeyError(values)
