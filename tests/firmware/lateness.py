"""`slewline`, with a note of each turn of a drive: when it began, and for how long the board had something to do.

python -m tests.firmware.lateness FIGURES.json drive gs-c200s --board PORT ...
"""

from __future__ import annotations

import json
import sys
from array import array
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from time import perf_counter_ns

from slewline.cli.main import invoke
from slewline.drive import talk
from slewline.drive.motor_drive import Drive

BEHIND_MS = 5.0  # a turn is due so long after the one before at the latest
BINS = {
    "late": (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100),
    "lead": (10, 20, 30, 40, 50, 60, 70, 80, 90, 100),
}  # upper ends, ms


def stolen_ms() -> int:
    """Return for how long others than this system have had its processors, ms: a virtual machine waits then."""
    with suppress(OSError, IndexError, ValueError):
        return int(Path("/proc/stat").read_text("ascii").splitlines()[0].split()[8]) * 10
    return 0


def noted(began: array[int], lead: array[int], took: array[int]) -> None:
    """Note each turn from now on: when it began, and how long it took, ns; the lead of the board, in ticks, or -1."""
    turn = Drive.turn

    def noting(drive: Drive) -> None:
        now = perf_counter_ns()
        began.append(now)
        base = drive._path.feeder.base16 >> 16
        moving = drive._path.feeder.running and drive.state == "ok" and drive._state.axis.moving
        lead.append(max(base - drive._path.clock.ticks(now), 0) if moving else -1)
        turn(drive)
        took.append(perf_counter_ns() - now)

    Drive.turn = noting  # type: ignore[method-assign]


def figures(values: list[float], bins: tuple[float, ...]) -> dict[str, object]:
    """Return what is to be told of many values."""
    ordered = sorted(values)

    def part(share: float) -> float:
        return round(ordered[min(int(share * len(ordered)), len(ordered) - 1)], 3)

    edges = [float("-inf"), *bins, float("inf")]
    counts = [sum(low < value <= high for value in ordered) for low, high in pairwise(edges)]
    return {
        "turns": len(ordered),
        "least": part(0),
        "0.1 %": part(0.001),
        "1 %": part(0.01),
        "median": part(0.5),
        "99 %": part(0.99),
        "99.9 %": part(0.999),
        "most": part(1),
        "bins": dict(zip([*map(str, bins), "more"], counts, strict=True)),
    }


def main(path: str, *words: str) -> int:
    """Run the command, and write the figures of the turns in which the motor moved."""
    began, lead, took = array("q"), array("q"), array("q")
    talk.SILENT_NS = 60 * 10**9  # an emulator that is held up is no board without supply
    noted(began, lead, took)
    stolen = stolen_ms()
    try:
        return invoke(words)
    finally:
        moving = [at for at in range(1, len(began)) if lead[at] >= 0 and lead[at - 1] >= 0]
        late = [max((began[at] - began[at - 1]) / 1e6 - BEHIND_MS, 0.0) for at in moving]
        told = {
            "stolen, ms": stolen_ms() - stolen,
            "turn took, ms": figures([took[at] / 1e6 for at in moving if at < len(took)], BINS["late"]),
            "late, ms": figures(late, BINS["late"]),
            "lead, ms": figures([lead[at] / 16_000 for at in moving], BINS["lead"]),
        }
        Path(path).write_text(json.dumps(told, indent=1) + "\n", "ascii")


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
