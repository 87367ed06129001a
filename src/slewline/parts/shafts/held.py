"""Steps that a shaft makes while something forbids it: found when somebody asks, by what the shaft has done."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .motor import Translator


class Held:
    """What the shaft of a motor does as long as it should not, a level of a wire saying so."""

    def __init__(self, motor: Translator) -> None:
        self.motor = motor
        self._since: int | None = None  # steps behind this instant have not been looked at

    def hold(self, on: bool) -> None:
        """Watch from now on that the motor stands; or stop watching."""
        if on:
            self._since = self.motor.kernel.now if self._since is None else self._since
        elif self._since is not None:
            self.motor.catch_up()
            self._since = None

    def steps(self) -> Iterator[tuple[int, int, int]]:
        """Yield the steps since the last question: instant (ps), place before it and behind it."""
        import numpy as np

        since, seen, shaft = self._since, self.motor.kernel.seen, self.motor.shaft
        if since is None or seen <= since:
            return
        self._since = seen
        place = int(shaft.place_at(np.array([since]))[0])
        times, places = shaft.changes(since, seen)
        for ps, after in zip(times.tolist(), places.tolist(), strict=True):
            yield ps, place, int(after)
            place = int(after)
