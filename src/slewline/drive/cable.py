"""The cable between a model and its motor: while the motor moves, all output is delayed by a horizon.

    model  ---- steps ----> feeder --> board     every step at its instant + horizon
           ---- calls ----> cable  --> outside   bytes for a host, levels of pins: immediate at rest, else delayed too

The horizon is a fixed time, the same for steps and calls.  So messages to a host are true: "motion
complete" arrives when the motor has stopped, not one horizon earlier.  Calls never overtake each
other, because the delay never becomes shorter while output is pending.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable


class Cable:
    """Delayed output calls, in order.

    Args:
        horizon: the delay, in board ticks.
        present: a function that returns the tick that corresponds to the current time of the model.
        moving: a function that returns True from the first step of the model until the board has come to
            rest after the last one.
    """

    def __init__(self, horizon: int, present: Callable[[], int], moving: Callable[[], bool]) -> None:
        self.horizon, self._present, self._moving = horizon, present, moving
        self._calls: deque[tuple[int, Callable[[], object]]] = deque()

    @property
    def in_progress(self) -> bool:
        """True while motor steps or calls are pending."""
        return bool(self._calls) or self._moving()

    def __len__(self) -> int:
        return len(self._calls)

    def send(self, call: Callable[[], object]) -> None:
        """Make a call: immediately if no steps or calls are pending, else one horizon later."""
        if self.in_progress:
            self._calls.append((self._present() + self.horizon, call))
        else:
            call()

    def send_at(self, tick: int, call: Callable[[], object]) -> None:
        """Make a call when the board reaches a tick; calls are made in order of ticks.

        If no steps or calls are pending, make the call immediately.
        """
        if not self.in_progress:
            call()
            return
        later = []
        while self._calls and self._calls[-1][0] > tick:
            later.append(self._calls.pop())
        self._calls.append((tick, call))
        self._calls.extend(reversed(later))

    def turn(self, tick: int) -> None:
        """Make the calls that are due at or before a board tick."""
        while self._calls and self._calls[0][0] <= tick:
            self._calls.popleft()[1]()

    def flush(self) -> None:
        """Make all pending calls now."""
        while self._calls:
            self._calls.popleft()[1]()

    def due(self) -> int | None:
        """Return the tick of the next pending call; None if no call is pending."""
        return self._calls[0][0] if self._calls else None

    def withdraw(self, tick: int) -> int:
        """Discard the calls due after a tick, as if they had never been sent; return their number."""
        before = len(self._calls)
        while self._calls and self._calls[-1][0] > tick:
            self._calls.pop()
        return before - len(self._calls)
