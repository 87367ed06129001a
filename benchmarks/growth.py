"""How the time of a task grows with its size: the exponent from ten times the size and the size, alternately.

An exponent of 1 is ideal: ten times the size takes ten times as long.
"""

from __future__ import annotations

import gc
from collections.abc import Callable
from functools import partial
from math import log10
from statistics import median

from rows import Row, prepared_by_turns

import slewline
from slewline.bench.scripts.script import run_script
from slewline.core.time.kernel import Kernel
from slewline.core.wires.net import Driver, Net
from slewline.core.wires.waits import first_of, until

Case = Callable[[int], Callable[[], object]]
GOAL, TURNS = 1.1, 3
PROGRAM = "Po\rS100\rT1000\rR10\r+50\r-50\rj0\rE\r"


def programs(chips: int) -> Callable[[], object]:
    """Return a task: a number of modules, each with a program in a loop, for two seconds."""
    bench = slewline.Bench()
    modules = [
        bench.add("gs-c200s", f"m{number}", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0}) for number in range(chips)
    ]
    for host in [bench.host(module) for module in modules]:
        host.send(PROGRAM)
    bench.run("1 s")

    def run() -> None:
        before = modules[-1].motor.made
        bench.run("2 s")
        assert modules[-1].motor.made > before + 500

    return run


def moves(number: int) -> Callable[[], object]:
    """Return a task: a number of moves of 50 steps."""
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", "x"))
    host.send("A 0\rF 10\rR 100\rS 240\rZ 1\rN 50\r")

    def run() -> None:
        for move in range(number):
            host.send(f"{'+-'[move % 2]}\rG\r")
            bench.run_until_idle()

    return run


def script(lines: int) -> Callable[[], object]:
    """Return a task: a number of lines of a run script."""
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", "x"))
    text = "\n".join(f"R {number % 100 + 1}" for number in range(lines))

    def run() -> None:
        run_script(bench, host, text)
        bench.run_until_idle("1000 s")

    return run


def far(waits: int) -> Callable[[], object]:
    """Return a task: a number of waits ended by an edge, each with a distant instant as its limit."""
    kernel = Kernel()
    net = Net(kernel, "wire")
    driver = Driver(net, "source")

    async def waiting() -> None:
        for _ in range(waits):
            await first_of(kernel, kernel.now + 10**15, (net, None))

    async def driving() -> None:
        for number in range(waits):
            await until(kernel, kernel.now + 1000)
            driver.drive(number & 1)

    kernel.spawn(waiting, name="waiting")
    kernel.spawn(driving, name="driving")
    return lambda: kernel.run(10**12)


def uncollected(prepare: Case, number: int) -> Callable[[], None]:
    """Return a task without Python's garbage collector, which repeatedly visits all live objects."""
    action = prepare(number)

    def run() -> None:
        gc.disable()
        try:
            action()
        finally:
            gc.enable()

    return run


CASES: tuple[tuple[str, Case, int], ...] = (
    ("10 and 100 GS-C200S with programs", programs, 10),
    ("200 and 2,000 moves of 50 steps", moves, 200),
    ("1,000 and 10,000 lines of a script", script, 1000),
    ("10,000 and 100,000 waits with a distant time limit", far, 10_000),
)


def exponent(prepare: Case, number: int) -> float:
    """Return the power of the size with which the time grows."""
    sides = prepared_by_turns(lambda: prepare(10 * number), lambda: prepare(number), TURNS)
    return median(log10(large / small) for large, small in sides)


def rows() -> list[Row]:
    """Return the exponents; for one that is too large also without Python's garbage collector."""
    found = []
    for name, prepare, number in CASES:
        power = exponent(prepare, number)
        bound = "each takes the same time as the first"
        if power > GOAL:
            without = exponent(partial(uncollected, prepare), number)
            bound = f"Python's garbage collector ({without:.2f} without it), and the processor caches"
        found.append(Row(f"{name}: growth exponent", power, "", GOAL, False, bound))
    return found
