"""Tasks that wait for an edge or an instant, whichever is first, compared with SimPy: the same waits, alternately."""

from __future__ import annotations

from collections.abc import Callable, Generator
from functools import partial
from importlib.util import find_spec
from typing import Any

import profiled
from rows import Row, prepared_by_turns

from slewline.core.time.kernel import Kernel
from slewline.core.wires.net import Driver, Net
from slewline.core.wires.waits import first_of, until

WAITS, LIMIT_PS = 20_000, 10_000
CASES = {  # picoseconds from edge to edge, and how many waits an edge ends
    "the edge comes first in half of them": (15_000, WAITS // 2),
    "the edge comes first": (7_000, WAITS),
    "the instant comes first": (0, 0),
}


def ours(period: int, edges: int) -> Callable[[], None]:
    """Return a task that waits on a kernel, with one that creates the edges."""
    kernel = Kernel()
    net = Net(kernel, "wire")
    driver = Driver(net, "source")
    ended = [0]

    async def waiting() -> None:
        for _ in range(WAITS):
            ended[0] += await first_of(kernel, kernel.now + LIMIT_PS, (net, None)) is net

    async def driving() -> None:
        for number in range(edges):
            await until(kernel, kernel.now + period)
            driver.drive(number & 1)

    kernel.spawn(waiting, name="waiting")
    kernel.spawn(driving, name="driving")

    def run() -> None:
        kernel.run(10**12)
        assert ended[0] == edges, ended

    return run


def theirs(period: int, edges: int) -> Callable[[], None]:
    """Return the same with SimPy, where an edge is an event, followed by a new one."""
    import simpy  # as in other simulators

    env = simpy.Environment()
    wire, ended = [env.event()], [0]

    def waiting() -> Generator[Any, Any, None]:
        for _ in range(WAITS):
            edge = wire[0]
            ended[0] += edge in (yield edge | env.timeout(LIMIT_PS))

    def driving() -> Generator[Any, Any, None]:
        for _ in range(edges):
            yield env.timeout(period)
            wire[0].succeed()
            wire[0] = env.event()

    env.process(waiting())
    env.process(driving())

    def run() -> None:
        env.run()
        assert ended[0] == edges, ended

    return run


def timers(kernel_is_ours: bool) -> Callable[[], Callable[[], None]]:
    """Return a task that waits for one instant after the other."""

    def prepare() -> Callable[[], None]:
        if kernel_is_ours:
            kernel = Kernel()

            async def waiting() -> None:
                for _ in range(WAITS):
                    await until(kernel, kernel.now + LIMIT_PS)

            kernel.spawn(waiting, name="waiting")
            return lambda: kernel.run(10**12)
        import simpy

        env = simpy.Environment()

        def process() -> Generator[Any, Any, None]:
            for _ in range(WAITS):
                yield env.timeout(LIMIT_PS)

        env.process(process())
        return env.run

    return prepare


def rows() -> list[Row]:
    """Return the rows of waits for an edge or an instant, and for instants alone."""
    cases: dict[str, tuple[Callable[[], Callable[[], None]], Callable[[], Callable[[], None]]]] = {
        f"20,000 waits for an edge or an instant ({name})": (
            partial(theirs, *case),
            partial(ours, *case),
        )
        for name, case in CASES.items()
    }
    cases["20,000 waits for an instant"] = timers(False), timers(True)
    found = []
    for name, (simpy, slewline) in cases.items():
        bound = profiled.bound(name, slewline, WAITS, "per wait")
        there = find_spec("simpy") is not None
        sides = prepared_by_turns(simpy, slewline) if there else ()
        found.append(Row(name, None, "x SimPy", 2.5, True, bound, sides, "" if there else "SimPy is not installed"))
    return found
