"""The registration of a task that is about to wait, in the heap and on nets; and an event for which tasks wait.

A task is registered under its current token; the first event that wakes it increments the token, which makes the other
registrations stale.  The waiting task is the running one, so these functions are called from inside it (waits.py).
"""

from __future__ import annotations

from heapq import heappush

from ..time.kernel import Kernel
from .net import Driver, Net


def wait_until(kernel: Kernel, ps: int) -> bool:
    """Register the running task for an instant (ps) and return True.

    If no wait is needed to reach the instant, return False, and do not register the task.
    """
    if ps <= kernel.now or kernel.pass_to(ps):
        return False
    task = kernel.task
    heappush(kernel.heap, (ps, next(kernel.order), task, task.token))  # type: ignore[union-attr]
    return True


def wait_at_rest(net: Net, rest: int) -> None:
    """Register the running task to be woken when a net without a foreseen edge leaves level `rest`, 0 or 1."""
    net.value = rest  # while nothing waited for it, it did not follow its promise
    task = net.kernel.task
    entry = (task, task.token, 1 - rest)  # type: ignore[union-attr]
    if net.waiters is None:
        net.waiters = [entry]  # type: ignore[list-item]
    else:
        net.waiters.append(entry)  # type: ignore[arg-type]


def wait_for_first(
    kernel: Kernel, ps: int | None, wanted: tuple[tuple[Net, int | None], ...]
) -> tuple[bool, Net | None]:
    """Register the running task for an instant (ps) and for levels of nets, each 0, 1 or None for any change.

    If one of the levels has already been reached, return True and its net.  If the instant has already been
    reached, return True and None.  In both cases the task is not registered.  Otherwise, return False and
    None.
    """
    for net, value in wanted:
        if value is not None and net.level == value:
            return True, net
    if ps is not None and ps <= kernel.now:
        return True, None
    task = kernel.task
    if ps is not None:
        heappush(kernel.heap, (ps, next(kernel.order), task, task.token))  # type: ignore[union-attr]
    for net, value in wanted:
        net.register(task, value)  # type: ignore[arg-type]
    return False, None


class Event:
    """An event that occurs at the end of a round: its own net changes, and tasks that wait for this change continue."""

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
