"""Axis quantities that are derived from measured steps, and drawn over those of the model in a picture.

    position            ____         velocity     _________
              _________|                         |         |____
       ______|         .          ______.________|         .    .
      0      1         2    steps       0        1         2    3

Of a measured step, only the start is known: the velocity is 1 / interval up to the next step, and it is
unknown before the first step and after the last.  An interval in which the direction changes is a rest,
and so is an interval that is more than REST times as long as an adjacent one: no ramp decelerates that
much from one step to the next.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...core.motion.axis import Steps
from ...core.motion.quantity import Outline, Quantity
from ...core.time.timebase import PS_PER_S
from ...errors import UsageError
from .tracks import Track

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

REST = 10


class Measured(Quantity):
    """A quantity with values at some instants, (n,) int64 ps.

    Each value holds until the next one; before the first, the quantity is NaN.
    """

    is_staircase = True

    def __init__(self, name: str, unit: str, times_ps: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        self.name, self.unit, self.times_ps, self.values = name, unit, times_ps, values
        self.from_zero = name != "position"

    def values_at(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the values at instants (ps), in any order: float64, same shape as `times_ps`; NaN where unknown."""
        import numpy as np

        found: NDArray[np.float64] = np.append(np.nan, self.values)[np.searchsorted(self.times_ps, times_ps, "right")]
        return found

    def changes(self, start: int, stop: int) -> Outline:
        """Return the measured value at `start`, followed by every change in start < t <= stop (ps)."""
        import numpy as np

        first, last = np.searchsorted(self.times_ps, (start, stop), side="right").tolist()
        values = np.append(self.values_at(np.array([start])), self.values[first:last])
        return Outline(np.append(start, self.times_ps[first:last]), values)


def velocity(steps: Steps) -> Measured:
    """Return the velocity of measured steps, steps/s: ±1 / interval, 0 in a rest, NaN after the last step."""
    import numpy as np

    lasts = np.diff(steps.times_ps)
    nearby = np.append(lasts, np.iinfo(np.int64).max)  # the last interval is followed by one that is never shorter
    shortest = np.minimum(nearby[1:], np.append(nearby[-1], lasts)[:-1])
    rests = (lasts // REST > shortest) | (steps.directions[1:] != steps.directions[:-1])
    speeds = np.where(rests, 0.0, steps.directions[:-1] * (PS_PER_S / lasts))
    return Measured("velocity", "steps/s", steps.times_ps, np.append(speeds, np.nan))


def position(steps: Steps) -> Measured:
    """Return the position, in steps, after each measured step."""
    import numpy as np

    return Measured("position", "steps", steps.times_ps, steps.positions.astype(np.float64))


def track(name: str, steps: Steps, begins: int) -> Track:
    """Return measured steps as a track, with the first step at the instant `begins` (ps) of the picture.

    Raises:
        UsageError: there are no steps, or their times are not in ascending order.
    """
    import numpy as np

    times = steps.times_ps
    if not len(times) or (np.diff(times) <= 0).any():
        raise UsageError(f"runs: {name!r} has {len(times)} steps; expected one or more, with ascending times")
    first, last = int(times[0]), int(times[-1])
    quantities = velocity(steps), position(steps)
    return Track(name, quantities, zero=first - begins, since=first, until=last, over=True)
