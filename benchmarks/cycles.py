"""How fast trains of cycles answer: 10 virtual seconds of an axis at top speed, at 61 % of it, and in ramps throughout.

    python benchmarks/cycles.py

Every instant is expanded, window by window into one buffer; a window of 10 ms is found and expanded; positions are
computed for every cycle.  Each case checks its own result before it is believed.
"""

from __future__ import annotations

import argparse
import statistics
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from slewline.core.cycles import CYCLE, ONE, CycleTrain, Law, Linear, SCurve
from slewline.core.timebase import Clock

CYCLES = 30_518  # 10 s
TOP = 512 * ONE
WINDOW = 1 << 20  # steps in the buffer
STRETCH = 4096  # cycles
TEN_MS = 10**10


@dataclass
class Figures:
    """What one case took, in seconds."""

    name: str
    steps: int
    instants: float  # all of them
    window: float  # 10 ms of them in mid-train
    positions: float  # all of them
    cycles: int = CYCLES


def curve() -> SCurve:
    """Ten seconds of jerk, up to the top speed."""
    quarter = CYCLES // 4
    lengths = (quarter, 0, quarter, 0, quarter, 0, quarter)
    return SCurve(TOP * 2 * quarter, 2 * quarter**3, lengths)


def cases(hz: int = 25_000_000) -> dict[str, CycleTrain]:
    """The trains."""
    laws: dict[str, Law] = {
        "top speed": Linear(TOP),
        "61 % of it": Linear(TOP * 61 // 100),
        "ramp": Linear(0, TOP // CYCLES),
        "S-curve": curve(),
    }
    cycles = CYCLES // 4 * 4
    return {name: CycleTrain(Clock(hz), 123_456, law, cycles, 4321) for name, law in laws.items()}


def median(action: Callable[[], object], rounds: int = 9) -> float:
    """Median seconds of an action, after one that warms up."""
    action()
    times = []
    for _ in range(rounds):
        start = perf_counter()
        action()
        times.append(perf_counter() - start)
    return statistics.median(times)


def measured(name: str, train: CycleTrain) -> Figures:
    """The figures of one train."""
    buffer = np.empty(WINDOW, np.int64)
    middle = train.clock.ps(train.begin(train.steps // 2))

    def instants() -> None:
        for first in range(0, train.steps, WINDOW):
            train.begins(first, min(first + WINDOW, train.steps), buffer)

    def window() -> np.ndarray:
        return train.begins(train.begun(middle - 1), train.begun(middle + TEN_MS))

    def positions() -> None:
        for i in range(0, train.cycles, STRETCH):
            train.positions(i, min(i + STRETCH, train.cycles))

    found = window()
    assert found[0] == middle and middle + TEN_MS - found[-1] < TEN_MS // len(found) * 2
    assert int(train.begins(train.steps - 1)[0]) == train.clock.ps(train.begin(train.steps - 1))
    assert int(train.positions(train.cycles, train.cycles + 1)[0]) == train.lead + train.law.travel(train.cycles)
    return Figures(name, train.steps, median(instants), median(window, 99), median(positions), train.cycles)


def figures() -> list[Figures]:
    """Of all cases; the last ones at a crystal whose period is no whole number of picoseconds."""
    odd = ((f"{name}, 24,999,999 Hz", train) for name, train in cases(24_999_999).items())
    return [measured(name, train) for name, train in (*cases().items(), *odd)]


def main() -> None:
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter).parse_args()
    print(f"{'':<28}{'M steps/s':>10}{'ns/step':>10}{'10 ms, us':>10}{'ns/cycle':>10}   4 axes: x real time")
    for case in figures():
        virtual = case.cycles * CYCLE / 25e6
        print(
            f"{case.name:<28}{case.steps / case.instants / 1e6:>10.0f}{case.instants / case.steps * 1e9:>10.2f}"
            f"{case.window * 1e6:>10.0f}{case.positions / case.cycles * 1e9:>10.1f}"
            f"   {virtual / 4 / case.instants:,.0f} (instants), {virtual / 4 / case.positions:,.0f} (cycles)"
        )


if __name__ == "__main__":
    main()
