"""Runs that were kept: what each comes to, as digests, and the table that one state of the project wrote.

    python -m tests.laws.kept         the table of the sources on the path, as JSON

A run is a journal or a bench file of `kept_runs`.  It is played twice: with all pins recorded, so that every edge of
every pin is compared, and with nothing recorded, so that hosts and parts exchange values and promises where they can.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import slewline
from slewline.bench import load
from slewline.errors import NotRecorded, OtherLaws, Timeout, WiringError

RUNS = Path(__file__).with_name("kept_runs")
TABLE = RUNS / "outcomes.json"
LOOKS = 97  # instants, evenly, at which positions and places are compared
EXACT = 12  # steps at the start of each axis, and as many at its end: there it counts on which side an instant falls
US = 10**6
LAGS = (0, 1, 3, 8, 20, 30, 50, 58, 70, 300, 2050, 3000)  # of the parts of these runs, us
DIGITS = 6  # of places that are no whole numbers: the last bits of a float differ between processors
GIVEN_UP = "3 s"


def names() -> list[str]:
    """The files of all runs."""
    return sorted(path.name for path in RUNS.iterdir() if path != TABLE)


def played(name: str, prepare: Callable[[slewline.Bench], object]) -> slewline.Bench:
    """Play a run on a fresh bench."""
    if name.endswith(".toml"):
        bench = load(str(RUNS / name))
        prepare(bench)
        with contextlib.suppress(Timeout):
            bench.run_until_idle(GIVEN_UP)
        return bench
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", OtherLaws)
        return slewline.replay(RUNS / name, prepare=prepare, other_laws=True)


def record_all(bench: slewline.Bench) -> None:
    """Record the pins of all chips and parts, but for clocks and what is wired to nothing."""
    bench.record()
    for name, part in bench.parts.items():
        for pin in part.pins:
            with contextlib.suppress(NotRecorded, WiringError):
                bench.record(f"{name}.{pin}")


def short(*parts: Any) -> str:
    """A digest of values."""
    return hashlib.sha256("\n".join(map(repr, parts)).encode()).hexdigest()[:16]


def edges(bench: slewline.Bench) -> dict[str, str]:
    """A digest of all edges of the pins of each chip and part, but for clocks; and of a window from edge to edge."""
    found: dict[str, Any] = {}
    for name, owner in {**bench.chips, **bench.parts}.items():
        pins = []
        for pin in owner.pins:
            with contextlib.suppress(NotRecorded, WiringError):  # a clock, or no signal
                times, levels = bench.edges(f"{name}.{pin}")
                whole = [int(time) for time in times]
                pins.append((pin, whole, [int(level) for level in levels]))
                if whole:
                    first, last = whole[len(whole) // 3], whole[len(whole) // 2]
                    for window in ((first, last), (first + 1, max(first + 1, last - 1))):
                        pins.append((pin, [int(time) for time in bench.edges(f"{name}.{pin}", *window)[0]], []))
        if pins:
            found[name] = short(*pins)
    return found


def looks(bench: slewline.Bench) -> list[int]:
    """Instants at which positions are compared: evenly, and at some steps, a picosecond before, and a lag later."""
    found = {bench.now_ps * look // LOOKS for look in range(LOOKS + 1)}
    for chip in bench.chips.values():
        for number in range(1, len(chip.axes) + 1):
            times = chip.axis(number).steps().times_ps.tolist()
            found |= {
                time + lag * US - early
                for time in [*times[:EXACT], *times[-EXACT:]]
                for lag in LAGS
                for early in (0, 1)
                if time + lag * US <= bench.now_ps
            }
    return sorted(found)


def axes(bench: slewline.Bench) -> dict[str, list[list[Any]]]:
    """Of each axis of each chip: position, number of steps, digests of their instants and of positions on the way."""
    instants = looks(bench)
    found: dict[str, Any] = {}
    for name, chip in bench.chips.items():
        found[name] = []
        for number in range(1, len(chip.axes) + 1):
            axis = chip.axis(number)
            steps = axis.steps()
            way = short(steps.times_ps.tolist(), steps.directions.tolist(), axis.position_at(instants).tolist())
            found[name].append([int(axis.position), len(steps), way])
    return found


def places(bench: slewline.Bench) -> dict[str, str]:
    """Of each quantity: a digest of its values on the way, rounded, and of the instants of all its changes."""
    instants = np.array(looks(bench), np.int64)
    found: dict[str, Any] = {}
    for name, quantity in sorted(bench.quantities().items()):
        values = quantity.values_at(instants)
        changes, _ = quantity.staircase(0, bench.now_ps)
        found[name] = short([f"{value + 0.0:.{DIGITS}g}" for value in values.tolist()], changes.tolist())
    return found


def findings(bench: slewline.Bench) -> list[str]:
    """Instant and code of each finding."""
    return [f"{finding.time_ps} {finding.code}" for finding in bench.findings]


def waveforms(bench: slewline.Bench) -> str:
    """A digest of the bytes of a VCD file with all pins."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "all.vcd"
        bench.save_vcd(path, timescale="1 ps")
        return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def state(bench: slewline.Bench) -> dict[str, Any]:
    """What can be asked at the end of a run, whether or not anything was recorded."""
    return {"end": bench.now_ps, "axes": axes(bench), "places": places(bench), "findings": findings(bench)}


def recorded(name: str) -> dict[str, Any]:
    """What a run has come to, with all pins recorded."""
    bench = played(name, record_all)
    parts = {name: chip.sheet.part for name, chip in bench.chips.items()}
    return {"parts": parts, **state(bench), "edges": edges(bench), "vcd": waveforms(bench)}


def unrecorded(name: str) -> dict[str, Any]:
    """What a run has come to with nothing recorded: hosts and parts exchange values as far as they can."""
    return state(played(name, lambda bench: None))


def main() -> None:
    print(json.dumps({name: recorded(name) for name in names()}, indent=1))


if __name__ == "__main__":
    main()
