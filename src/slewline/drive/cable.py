"""The cable between a model and its motor: while something is under way, what goes out comes out a horizon later.

    model  ---- steps ----> feeder --> board     every step at its instant + horizon
           ---- calls ----> cable  --> outside   bytes for a host, levels of pins: at once at rest, else that much later

So what a host hears is true: "motion complete" comes when the motor has stopped, not a horizon before.  The order never
changes, for the cable only grows while something is under way.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable


class Cable:
    """Calls on their way out, in order.

    Args:
        horizon: its length, in ticks of the board.
        present: returns the tick that belongs to the present of the model.
        moving: returns whether steps are laid, or made by the model, that the board has not come to rest behind.
    """

    def __init__(self, horizon: int, present: Callable[[], int], moving: Callable[[], bool]) -> None:
        self.horizon, self._present, self._moving = horizon, present, moving
        self._calls: deque[tuple[int, Callable[[], object]]] = deque()

    @property
    def under_way(self) -> bool:
        """Is something under way: steps of the motor, or calls?"""
        return bool(self._calls) or self._moving()

    def __len__(self) -> int:
        return len(self._calls)

    def send(self, call: Callable[[], object]) -> None:
        """Make a call: now if nothing is under way, else a horizon later."""
        if self.under_way:
            self._calls.append((self._present() + self.horizon, call))
        else:
            call()

    def send_at(self, tick: int, call: Callable[[], object]) -> None:
        """Make a call that was due at a tick, in its order: at once if nothing is under way."""
        if not self.under_way:
            call()
            return
        later = []
        while self._calls and self._calls[-1][0] > tick:
            later.append(self._calls.pop())
        self._calls.append((tick, call))
        self._calls.extend(reversed(later))

    def turn(self, tick: int) -> None:
        """Make the calls that are due by a tick of the board."""
        while self._calls and self._calls[0][0] <= tick:
            self._calls.popleft()[1]()

    def flush(self) -> None:
        """Make all calls now."""
        while self._calls:
            self._calls.popleft()[1]()

    def due(self) -> int | None:
        """Return the tick at which the next call is due; None: there is none."""
        return self._calls[0][0] if self._calls else None

    def withdraw(self, tick: int) -> int:
        """Forget the calls that would be made after a tick, as if they had never been sent; return how many."""
        before = len(self._calls)
        while self._calls and self._calls[-1][0] > tick:
            self._calls.pop()
        return before - len(self._calls)
