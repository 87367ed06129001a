"""Position of a load that a rotor moves: a shaft, a shaft after a gear, or a carriage with backlash."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any


@dataclass(frozen=True)
class Linkage:
    """Mechanical connection of a load to a rotor or to another linkage, `under`; positions are in load steps.

    The position is `offset` plus `factor` load steps for each full step of the motor, or for each step of
    `under`.  If there is backlash (`play`), the load stops when the rotor reverses, and moves again after
    the rotor has taken up `play` load steps.  If `is_lagging` is True, the commanded position is subtracted.
    """

    factor: float = 1.0
    play: float = 0.0
    offset: float = 0.0
    under: Linkage | None = None
    is_lagging: bool = False

    def begun(self, place: Any, command: Any) -> tuple[Any, ...]:
        """Return the positions of all linkages, from the rotor to this one, at the start of a run.

        `place` and `command` are the rotor's position and command, in full steps; they may be arrays if no
        linkage has backlash.
        """
        below = self.under.begun(place, command) if self.under else ()
        return *below, self._of(below[-1] if below else place, command, None)

    def follow(self, before: tuple[float, ...], place: float, command: float) -> tuple[float, ...]:
        """Return the new positions of all linkages when the rotor has moved to `place` without reversing."""
        below = self.under.follow(before[:-1], place, command) if self.under else ()
        return *below, self._of(below[-1] if below else place, command, before[-1])

    def _of(self, place: Any, command: Any, before: float | None) -> Any:
        pushed = place * self.factor + self.offset
        if self.is_lagging:
            pushed -= command
        if not self.play or before is None:
            return pushed
        return min(max(before, pushed), pushed + self.play)

    @property
    def simple(self) -> bool:
        """True if the position follows from the rotor position alone."""
        return not self.play and (self.under is None or self.under.simple)

    def bound(self, place: float, rising: bool, command: float) -> tuple[float, float, bool]:
        """Return the condition that the rotor must meet for the load to pass `place`: factor, bound, direction.

        The load passes `place` when factor * (position of the rotor) passes the bound: upwards if the direction
        is True, downwards if False.

        `rising`: True if the load's own position rises past `place`, False if it falls.
        """
        pushed = place - self.offset + (command if self.is_lagging else 0.0)
        if self.play and not rising:
            pushed -= self.play
        if self.under is None:
            return self.factor, pushed, rising
        up = rising if self.factor > 0 else not rising
        return self.under.bound(pushed / self.factor, up, command)

    def gone(self, before: tuple[float, ...], rotor_before: float, rotor: Any) -> list[Any]:
        """Return the positions of all linkages, (n,) float64 each, for n consecutive positions of the rotor.

        `before` and `rotor_before` are the positions of the linkages and of the rotor just before the first of
        the n positions.
        """
        import numpy as np

        below = self.under.gone(before[:-1], rotor_before, rotor) if self.under else []
        pushed = (below[-1] if below else rotor) * self.factor + self.offset
        if not self.play:
            return [*below, pushed]
        begin = (before[-2] if below else rotor_before) * self.factor + self.offset
        back = np.diff(pushed, prepend=begin) < 0.0
        turns = (np.flatnonzero(back[1:] != back[:-1]) + 1).tolist()
        places, here = np.empty_like(pushed), before[-1]
        for since, until in pairwise((0, *turns, len(pushed))):
            part = pushed[since:until]
            places[since:until] = np.minimum(here, part + self.play) if back[since] else np.maximum(here, part)
            here = places[until - 1]
        return [*below, places]

    def followed(self, before: Sequence[Any], rotor: Any) -> list[Any]:
        """Return the new positions of all linkages, (n,) float64 each, for n separate moves of the rotor.

        This calculates n results of `follow` together.  `before` holds the positions of each linkage before the
        moves, and `rotor` the positions of the rotor after the moves.
        """
        import numpy as np

        below = self.under.followed(before[:-1], rotor) if self.under else []
        pushed = (below[-1] if below else rotor) * self.factor + self.offset
        return [*below, np.minimum(np.maximum(before[-1], pushed), pushed + self.play) if self.play else pushed]
