"""The compiled build compared with plain Python: exchanges of hosts with chips, each workload in both, alternately.

    make compiled
    python benchmarks/compiled.py [--turns 5] [--plain FOLDER] [--compiled FOLDER] [NAME ...]

Figures are CPU seconds, the median of the turns.  Both builds stay loaded, in separate processes on one core;
each reports at the start which build it is, and is used only if it is the requested one.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from statistics import median
from subprocess import PIPE, Popen

HERE = Path(__file__).resolve().parent
PLAIN, COMPILED = HERE.parent / "src", HERE.parent / "build" / "compiled"
BUILDS = ("plain Python", "compiled core")


# --------------------------------------------------------------------------------------------------------- workloads
def status_one_by_one() -> Callable[[], object]:
    """1,000 times GET_STATUS, each awaited before the next."""
    import chipset

    _, _, host = chipset.furnished("mc1451a")
    return lambda: [host.query("GET_STATUS") for _ in range(1000)]


def status_queued() -> Callable[[], object]:
    """1,000 times GET_STATUS, all queued together."""
    import chipset

    bench, _, host = chipset.furnished("mc1451a")

    def run() -> None:
        for _ in range(1000):
            host.send("GET_STATUS")
        bench.run_until_idle("10 s")

    return run


def script_of_moves() -> Callable[[], object]:
    """10 random moves of a script that polls the status until each is complete."""
    import chipset

    return chipset.scripted(10, ("wait motion_complete", "CLR_STATUS"))


def cy545_polled() -> Callable[[], object]:
    """300 queries of a register of a CY545 in text mode, with their answers."""
    import slewline

    bench = slewline.Bench()
    host = bench.host(bench.add("cy545"))
    host.send("O 129\r")
    bench.run_until_idle()
    return lambda: [host.ask("? N") for _ in range(300)]


def cy545_program() -> Callable[[], object]:
    """A program of 1,000 instructions that a CY545 reads from its external memory."""
    import slewline

    bench = slewline.Bench()
    chip = bench.add("cy545")
    bench.part("ram", to=chip, image="R 100\r" * 1000 + "0\r")
    bench.host(chip).send("X\r")
    return lambda: bench.run_until_idle("100 s")


def cy525_dialogue() -> Callable[[], object]:
    """2,000 commands to a CY525 from a host without delays."""
    from writing import MIX

    import slewline

    bench = slewline.Bench()
    bench.host(bench.add("cy525")).send("".join(MIX[n % len(MIX)] + "\r" for n in range(2_000)))
    return lambda: bench.run_until_idle("100 s")


def gsc_exchanges() -> Callable[[], object]:
    """1,000 queries to a GS-C200S on its serial line, with their answers."""
    import slewline

    bench = slewline.Bench()
    host = bench.host(bench.add("gs-c200s", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0}))
    return lambda: [host.ask("F") for _ in range(1000)]


def edge_or_timeout() -> Callable[[], object]:
    """20,000 waits of a task for an edge or an instant, half of them ended by the edge."""
    from slewline.core.time.kernel import Kernel
    from slewline.core.wires.net import Driver, Net
    from slewline.core.wires.waits import first_of, until

    kernel = Kernel()
    net = Net(kernel, "wire")
    driver = Driver(net, "source")

    async def waiting() -> None:
        for _ in range(20_000):
            await first_of(kernel, kernel.now + 10_000, (net, None))

    async def driving() -> None:
        for number in range(10_000):
            await until(kernel, kernel.now + 15_000)
            driver.drive(number & 1)

    kernel.spawn(waiting, name="waiting")
    kernel.spawn(driving, name="driving")
    return lambda: kernel.run(10**9)


WORKLOADS: dict[str, Callable[[], Callable[[], object]]] = {
    "status": status_one_by_one,
    "queued": status_queued,
    "script": script_of_moves,
    "cy545": cy545_polled,
    "program": cy545_program,
    "cy525": cy525_dialogue,
    "gs-c": gsc_exchanges,
    "edges": edge_or_timeout,
}


# ------------------------------------------------------------------------------------------------------------ by turns
def answer() -> None:
    """Serve in a separate process: print which build this is, then the seconds of each workload named on a line."""
    from rows import best_of

    from slewline.cli.version_line import build

    print(build(), flush=True)
    for name in sys.stdin:
        print(json.dumps(best_of(WORKLOADS[name.strip()], 3)[0]), flush=True)


class Build:
    """A build, loaded and ready."""

    def __init__(self, folder: Path, expected: str, core: int) -> None:
        command = [sys.executable, __file__, "--answer", str(core)]
        environment = {**os.environ, "PYTHONPATH": str(folder)}
        self.process = Popen(command, stdin=PIPE, stdout=PIPE, text=True, env=environment)
        if (found := self.line()) != expected:
            raise SystemExit(f"{folder}: its build is {found}; expected {expected}")

    def line(self) -> str:
        """Return the next line that it prints."""
        assert self.process.stdout is not None
        line = self.process.stdout.readline().strip()
        if not line:
            raise SystemExit("a workload has failed")
        return line

    def seconds(self, name: str) -> float:
        """Run a workload; return the CPU seconds."""
        assert self.process.stdin is not None
        self.process.stdin.write(f"{name}\n")
        self.process.stdin.flush()
        return float(json.loads(self.line()))


def main() -> None:
    """Compare the two builds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help=", ".join(WORKLOADS), metavar="NAME")
    parser.add_argument("--turns", type=int, default=5, help="number of runs of each workload in each build (5)")
    parser.add_argument("--plain", type=Path, default=PLAIN, help="folder of the plain build (src)")
    parser.add_argument("--compiled", type=Path, default=COMPILED, help="folder of the compiled build (build/compiled)")
    parser.add_argument("--answer", type=int, metavar="CORE", help=argparse.SUPPRESS)
    options = parser.parse_intermixed_args()
    if options.answer is not None:
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {options.answer})
        answer()
        return
    if not set(options.names) <= set(WORKLOADS):
        parser.error(f"names are {', '.join(WORKLOADS)}")
    core = max(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 0
    builds = [Build(folder, name, core) for folder, name in zip((options.plain, options.compiled), BUILDS, strict=True)]
    print("| workload | plain, s | compiled, s | plain to compiled |\n|---|---:|---:|---:|")
    for name in options.names or WORKLOADS:
        turns = []
        for turn in range(options.turns):
            order = builds if turn % 2 else builds[::-1]
            took = {id(build): build.seconds(name) for build in order}
            turns.append([took[id(build)] for build in builds])
        plain, compiled = (median(column) for column in zip(*turns, strict=True))
        ratio = median(one / two for one, two in turns)
        what = (WORKLOADS[name].__doc__ or "").rstrip(".")
        print(f"| {what} | {plain:.3f} | {compiled:.3f} | {ratio:.2f} |", flush=True)
    for build in builds:
        build.process.communicate()


if __name__ == "__main__":
    main()
