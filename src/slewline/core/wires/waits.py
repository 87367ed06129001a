"""The waits of a task: for an instant, a level, an edge, or the first of several.

Each wait is a generator-based coroutine that registers the running task (waiters.py) and suspends it.
"""

from __future__ import annotations

from collections.abc import Generator
from types import coroutine
from typing import TYPE_CHECKING, Any

from .waiters import wait_at_rest, wait_for_first, wait_until

if TYPE_CHECKING:
    from ..time.kernel import Kernel
    from .net import Net


@coroutine
def until(kernel: Kernel, ps: int) -> Generator[None, Any, None]:
    """Wait until an instant (ps); return immediately if it is not in the future."""
    if wait_until(kernel, ps):
        yield


@coroutine
def suspended() -> Generator[None, None, None]:
    """Wait until `Kernel.wake` wakes the task."""
    yield


@coroutine
def next_round(kernel: Kernel) -> Generator[None, Any, None]:
    """Wait for the next round of this instant, which begins when all work of the present round has been done."""
    if not kernel.pass_round():
        kernel.woken.append(kernel.task)
        yield


@coroutine
def level(net: Net, wanted: int) -> Generator[None, Any, None]:
    """Wait until a net has a level, 0 or 1; return immediately if it already has this level."""
    if net.level != wanted:
        net.register(net.kernel.task, wanted)  # type: ignore[arg-type]
        yield


@coroutine
def edge_from_rest(net: Net, rest: int) -> Generator[None, Any, None]:
    """Wait until a net without a foreseen edge leaves its present level, 0 or 1."""
    wait_at_rest(net, rest)
    yield


@coroutine
def edge(net: Net) -> Generator[None, Any, None]:
    """Wait for the next edge of a net, in either direction."""
    net.register(net.kernel.task, None)  # type: ignore[arg-type]
    yield


@coroutine
def first_of(kernel: Kernel, ps: int | None, *wanted: tuple[Net, int | None]) -> Generator[None, Any, Net | None]:
    """Wait for an instant (ps) or a level, whichever comes first; return the net, or None for the instant.

    Args:
        kernel: the virtual time.
        ps: the instant; None for no limit.
        wanted: pairs of a net and the level to wait for, 0 or 1, or None for any edge.  If some of
            the nets already have these levels, the call immediately returns the first of those nets.
    """
    there, net = wait_for_first(kernel, ps, wanted)
    return net if there else (yield)


async def polled(kernel: Kernel, net: Net, wanted: int, every: int) -> None:
    """Sample a net periodically, starting now, until it has the wanted level.

    The period is `every` picoseconds.  The sampling instants are computed, not stepped through; a level that
    does not last until the next sampling instant is missed.
    """
    origin = kernel.now
    while net.level != wanted:
        await level(net, wanted)
        await until(kernel, origin + ((kernel.now - origin) // every + 1) * every)
