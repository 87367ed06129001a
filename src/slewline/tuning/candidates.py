"""The candidates: a chip's moves, one per point of a grid of ramp parameters, fastest first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from hashlib import blake2b
from typing import TYPE_CHECKING

from ..errors import UsageError
from ..language.ramp_answers import Calculator, Ramp, Value
from .grid import Grid

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

EVERY = 500  # places between two reports


class Candidates:
    """The moves at the points of a grid: the duration of each move, and the instants of its steps.

    Args:
        steps: the number of steps in every move.
        on_listed: a function that is called from time to time with the number of points computed so far.

    Raises:
        UsageError: the part refuses every move.
    """

    def __init__(
        self,
        calculator: Calculator,
        grid: Grid,
        crystal_hz: int,
        steps: int,
        on_listed: Callable[[int], object] = lambda _: None,
    ) -> None:
        self.calculator, self.grid, self.crystal_hz, self.steps = calculator, grid, crystal_hz, steps
        self.refused: dict[int, str] = {}  # place: why
        timed = []
        for place in range(grid.size):
            if place % EVERY == 0:
                on_listed(place)
            try:
                timed.append((self.ramp(place).move(steps).time_ps, place))
            except UsageError as refusal:
                self.refused[place] = str(refusal)
        if not timed:
            why = self.refused[0]
            raise UsageError(
                f"{calculator.sheet.part}: none of the {grid.size} grid points gives a valid move; "
                f"error at the first: {why}"
            )
        timed.sort()
        self.order: Sequence[int] = [place for _, place in timed]
        self.time_ps = {place: time for time, place in timed}
        self.rank = {place: rank for rank, place in enumerate(self.order)}
        self._keys: dict[int, str] = {}
        self.times = lru_cache(maxsize=256)(self._times)

    def __len__(self) -> int:
        return len(self.order)

    def values(self, place: int) -> dict[str, Value]:
        """Return the values of the ramp parameters at a grid point, by name."""
        return self.grid.at(place)

    def ramp(self, place: int) -> Ramp:
        """Return the ramp at a grid point."""
        return self.calculator.ramp(self.grid.at(place), self.crystal_hz)

    def _times(self, place: int) -> NDArray[np.int64]:
        """Return the instants of the steps of a move: (steps,) int64 ps."""
        return self.ramp(place).move(self.steps).times()

    def key(self, place: int) -> str:
        """Return the key of the move at a grid point; two points have equal keys if their step instants are equal."""
        if place not in self._keys:
            self._keys[place] = blake2b(self.times(place).tobytes(), digest_size=8).hexdigest()
        return self._keys[place]

    def neighbours(self, place: int) -> list[int]:
        """Return the neighbours of a grid point, fastest first, except any whose move the part refuses."""
        return sorted((each for each in self.grid.neighbours(place) if each in self.rank), key=self.rank.__getitem__)
