"""Conversion of instants of a model into ticks of a board."""

from __future__ import annotations

from math import gcd
from typing import TYPE_CHECKING

from ..core.time.timebase import PS_PER_S

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


class TickMap:
    """The conversion between instants of a model and ticks of a board, computed exactly, then rounded down.

    `origin16` is the tick of instant 0, in 1/65536 tick.
    """

    def __init__(self, hz: int) -> None:
        common = gcd(hz << 16, PS_PER_S)
        self._n, self._d = (hz << 16) // common, PS_PER_S // common
        self.hz, self.origin16 = hz, 0

    def align(self, ps: int, tick: int) -> None:
        """Shift the conversion so that an instant of the model (ps) maps to a given tick of the board."""
        self.origin16 = (tick << 16) - ps * self._n // self._d

    def at(self, ps: int) -> int:
        """Return the tick at an instant (ps), in 1/65536 tick."""
        return self.origin16 + ps * self._n // self._d

    def many(self, ps: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the ticks of many instants (int64 ps), in 1/65536 tick: int64, same shape as `ps`."""
        whole, part = ps // self._d, ps % self._d
        ticks: NDArray[np.int64] = whole * self._n + part * self._n // self._d + self.origin16
        return ticks

    def ps(self, tick: int) -> int:
        """Return the last instant of the model (ps) at or before a tick of the board."""
        return (((tick << 16) - self.origin16 + 1) * self._d - 1) // self._n
