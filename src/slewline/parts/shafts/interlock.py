"""Steps that a shaft makes while steps are forbidden, found on request from the shaft's past motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..base.part import Part
    from .shaft import Shaft


class InterlockMonitor:
    """A monitor of a part's shaft, which finds the steps that the shaft makes while steps are forbidden.

    `hold` sets whether steps are forbidden.
    """

    def __init__(self, part: Part, shaft: Shaft) -> None:
        self.part, self.shaft = part, shaft
        self._since: int | None = None  # steps after this instant are not checked yet

    def hold(self, on: bool) -> None:
        """Treat steps of the shaft as forbidden from now on (`on`), or as allowed again."""
        if on:
            self._since = self.part.kernel.now if self._since is None else self._since
        elif self._since is not None:
            self.part.catch_up()
            self._since = None

    def steps(self) -> Iterator[tuple[int, int, int]]:
        """Yield the instant (ps) of each forbidden step since the last call, and the positions before and after it."""
        import numpy as np

        since, seen, shaft = self._since, self.part.kernel.seen, self.shaft
        if since is None or seen <= since:
            return
        self._since = seen
        place = int(shaft.place_at(np.array([since]))[0])
        times, places = shaft.changes(since, seen)
        for ps, after in zip(times.tolist(), places.tolist(), strict=True):
            yield ps, place, int(after)
            place = int(after)
