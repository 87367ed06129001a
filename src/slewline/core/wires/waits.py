"""What a task may wait for: time, a level, an edge, or the first of several.

Each wait is a generator-based coroutine that registers the running task under its present token and suspends it;
whatever wakes the task first moves the token on, which makes the other registrations stale.
"""

from __future__ import annotations

from collections.abc import Generator
from heapq import heappush
from types import coroutine
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..time.kernel import Kernel
    from .net import Net

STALE = 64  # entries that a net which never changes may gather before they are sorted out


@coroutine
def until(kernel: Kernel, ps: int) -> Generator[None, Any, None]:
    """Wait for an instant (ps); return at once if it is not in the future."""
    if ps > kernel.now and not kernel.pass_to(ps):
        task = kernel.task
        heappush(kernel.heap, (ps, next(kernel.order), task, task.token))  # type: ignore[union-attr]
        yield


@coroutine
def next_round(kernel: Kernel) -> Generator[None, Any, None]:
    """Wait until everything that is due in this round has been done."""
    kernel.woken.append(kernel.task)
    yield


@coroutine
def level(net: Net, wanted: int) -> Generator[None, Any, None]:
    """Wait until a net has a level, 0 or 1; return at once if it has."""
    if net.level != wanted:
        task = net.kernel.task
        net.waiters.append((task, task.token, wanted))  # type: ignore[union-attr,arg-type]
        if net.promise is not None:
            net.follow()
        yield


@coroutine
def edge(net: Net) -> Generator[None, Any, None]:
    """Wait for the next change of a net."""
    task = net.kernel.task
    net.waiters.append((task, task.token, None))  # type: ignore[union-attr,arg-type]
    if net.promise is not None:
        net.follow()
    yield


@coroutine
def first_of(kernel: Kernel, ps: int | None, *wanted: tuple[Net, int | None]) -> Generator[None, Any, Net | None]:
    """Wait for an instant (ps) or a level, whichever comes first; return the net, or None for the instant.

    Args:
        kernel: whose time it is.
        ps: None: no limit.
        wanted: nets, each with the level to wait for, 0 or 1; None: any change. A level that is there already returns
            at once, the first in the list winning.
    """
    for net, value in wanted:
        if value is not None and net.level == value:
            return net
    if ps is not None and ps <= kernel.now:
        return None
    task = kernel.task
    token = task.token  # type: ignore[union-attr]
    if ps is not None:
        heappush(kernel.heap, (ps, next(kernel.order), task, token))
    for net, value in wanted:
        if len(net.waiters) > STALE:  # what another net or the time has woken meanwhile
            net.waiters = [entry for entry in net.waiters if entry[0].token == entry[1]]
        net.waiters.append((task, token, value))  # type: ignore[arg-type]
        if net.promise is not None:
            net.follow()
    return (yield)  # type: ignore[no-any-return]


async def polled(kernel: Kernel, net: Net, wanted: int, every: int) -> None:
    """Look at a net every so many picoseconds until it has a level; the first look is now.

    The looks are counted, not made: a level that is gone again before a look is not seen.
    """
    origin = kernel.now
    while net.level != wanted:
        await level(net, wanted)
        await until(kernel, origin + ((kernel.now - origin) // every + 1) * every)
