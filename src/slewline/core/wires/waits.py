"""What a task may wait for: time, a level, an edge, or the first of several.

Each wait is a generator-based coroutine that registers the running task (waiters.py) and suspends it.
"""

from __future__ import annotations

from collections.abc import Generator
from types import coroutine
from typing import TYPE_CHECKING, Any

from .waiters import wait_for, wait_for_first, wait_until

if TYPE_CHECKING:
    from ..time.kernel import Kernel
    from .net import Net


@coroutine
def until(kernel: Kernel, ps: int) -> Generator[None, Any, None]:
    """Wait for an instant (ps); return at once if it is not in the future."""
    if wait_until(kernel, ps):
        yield


@coroutine
def next_round(kernel: Kernel) -> Generator[None, Any, None]:
    """Wait until everything that is due in this round has been done."""
    if not kernel.pass_round():
        kernel.woken.append(kernel.task)
        yield


@coroutine
def level(net: Net, wanted: int) -> Generator[None, Any, None]:
    """Wait until a net has a level, 0 or 1; return at once if it has."""
    if net.level != wanted:
        wait_for(net, wanted)
        yield


@coroutine
def edge(net: Net) -> Generator[None, Any, None]:
    """Wait for the next change of a net."""
    wait_for(net, None)
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
    there, net = wait_for_first(kernel, ps, wanted)
    return net if there else (yield)


async def polled(kernel: Kernel, net: Net, wanted: int, every: int) -> None:
    """Look at a net every so many picoseconds until it has a level; the first look is now.

    The looks are counted, not made: a level that is gone again before a look is not seen.
    """
    origin = kernel.now
    while net.level != wanted:
        await level(net, wanted)
        await until(kernel, origin + ((kernel.now - origin) // every + 1) * every)
