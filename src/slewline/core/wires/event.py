"""An event for which tasks wait, implemented as a net of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .net import Driver, Net

if TYPE_CHECKING:
    from ..time.kernel import Kernel


class Event:
    """An event that occurs at the end of a round: its net changes, and tasks that wait for this change continue."""

    def __init__(self, kernel: Kernel, name: str) -> None:
        self.count, self._driver = 0, Driver(Net(kernel, name), name)

    @property
    def net(self) -> Net:
        """The net of the event, which changes every time the event occurs."""
        return self._driver.net

    def set(self) -> None:
        """Let the event occur at the end of this round, which wakes the tasks that wait for it."""
        self.count += 1
        self._driver.drive(self.count)
