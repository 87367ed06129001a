"""Workloads of other trees of this project and of this one, alternately, each loaded in a separate process."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, fields
from itertools import count
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen
from subprocess import run as run_command
from tempfile import TemporaryDirectory

from rows import Row

HERE = Path(__file__).resolve().parent.parent
REFERENCE = "df29ad1ce7894d387f1fb76bd113b1aeb730468f"
SHORT = REFERENCE[:8]
ABSENT = f"commit {SHORT} is not in this repository"
FORMER = {  # names of rows in the reference, by their present names
    "20,000 waits for an edge or an instant (the instant comes first)": (
        "20,000 waits for an edge or an instant, the instant is first"
    ),
    "20,000 waits for an edge or an instant (the edge comes first)": (
        "20,000 waits for an edge or an instant, the edge is first"
    ),
    "20,000 waits for an edge or an instant (the edge comes first in half of them)": (
        "20,000 waits for an edge or an instant, the edge is first in half of them"
    ),
    "position at 1,000,000 instants": "position of 1,000,000 instants",
    "10,000,000 steps with 1,000 read-outs, 1,000 rate changes, 100,000 calls of position_at": (
        "the same with 1,000 read-outs, 1,000 rate changes, 100,000 calls of position_at"
    ),
    "CY545: entry of a program into an EEPROM": "CY545: a program into an EEPROM",
    "64 KB written to a file, one character at a time": "64 KB, one character at a time",
    "64 KB written to a file, one character at a time, the whole file each time": (
        "64 KB, one character at a time, the whole file each time"
    ),
    "move of 16,000,000 steps: the whole move, unobserved": "the same, unobserved",
    "a move, trapezoid: plan and simulate": "a move, trapezoid: plan and play",
    "a move, S-curve: plan and simulate": "a move, S-curve: plan and play",
    "CY525, two switches watched": "two switches watched",
    "60,000 steps: encoder after an inverter": "60,000 steps: encoder behind an inverter",
    "60,000 steps: translator and motor with limits, most steps lost": "60,000 steps: the same, most steps lost",
    "lockstep, registers: a packet, byte by byte": "lockstep, the same byte by byte",
    "1,000 times GET_STATUS, queued": "the same, queued",
    "100 random moves of a script, polling the status": "100 random moves of a script, asking for the status",
    "answers while a page shows 8 chips: added delay, p99": "answers with a page on 8 chips, later at p99",
    "100 served modules, 20 of them moving: added delay compared with one module, p99": (
        "100 served modules, 20 moving: answers later than of one, p99"
    ),
    "CY525, queried once, at rest": "CY525, asked once, at rest",
    "lockstep, a packet: CPU time of the server": "lockstep, a packet: processor",
    **{
        f"paced, {line}: answer time beyond the time on the wire{each}": f"paced, {line}: beyond the wire{each}"
        for line in ("TCP", "pty")
        for each in (", median", ", p99")
    },
    "the same: memory added per move": "the same: what a move adds",
    "the same: the steps of an axis in any window of 10 ms": "the same: any 10 ms of the steps of an axis",
    "four axes at 61 % of 1.5625 Mpulses/s, 10 s": "four axes at 61 % of that, 10 s",
    "train of cycles, 61 % of top speed: expand": "train of cycles, 61 % of it: expand",
}
CHILD = """
import json, os, sys
from dataclasses import asdict
from importlib import import_module
tree, module, name, core, here = sys.argv[1:]
os.sched_setaffinity(0, {int(core)})
whose = tree if os.path.exists(f"{tree}/benchmarks/{module}.py") else here  # a workload that the other tree lacks
sys.path[:0] = [f"{whose}/benchmarks", f"{tree}/src"]
import slewline
assert slewline.__file__.startswith(tree), slewline.__file__
rows = getattr(import_module(module), name)
for _ in sys.stdin:
    print(json.dumps([asdict(row) for row in rows()]), flush=True)
"""

Workload = Callable[[], Iterable[Row]]
Seen = dict[tuple[str, int], "Found"]


@dataclass(frozen=True)
class Found:
    """A row as printed by a tree; the rows of another tree may have more columns, or fewer."""

    name: str
    figure: float | None
    unit: str
    goal: float | None
    more_is_better: bool
    bound: str

    @property
    def known(self) -> float:
        """The figure, which must have been measured."""
        assert self.figure is not None, self.name
        return self.figure


COLUMNS = {field.name for field in fields(Found)}


class Tree:
    """A workload of a checkout, loaded and ready."""

    def __init__(self, folder: Path, workload: Workload, core: int) -> None:
        environment = {**os.environ, "PYTHONPATH": f"{folder}/src"}  # of the servers that a workload starts
        module = workload.__module__.replace("__main__", "run")
        command = [sys.executable, "-c", CHILD, str(folder), module, workload.__name__, str(core), str(HERE)]
        self.what = f"{module}.{workload.__name__} of {folder}"
        self.process = Popen(command, stdin=PIPE, stdout=PIPE, text=True, env=environment)

    def __enter__(self) -> Tree:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.communicate()

    def turn(self) -> Seen:
        """Run the workload once; return its rows by name, numbered if rows share a name ("the same: ...")."""
        assert self.process.stdin is not None and self.process.stdout is not None
        with suppress(BrokenPipeError):
            self.process.stdin.write("\n")
            self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"{self.what} has failed")
        found: Seen = {}
        for row in json.loads(line):
            number = next(n for n in count() if (row["name"], n) not in found)
            found[row["name"], number] = Found(**{name: row[name] for name in COLUMNS})
        return found


def turns_of(other: Path, workload: Workload, turns: int, core: int) -> list[tuple[Seen, Seen]]:
    """Run a workload of another tree and of this one alternately; return their rows, turn by turn."""
    found = []
    with Tree(other, workload, core) as theirs, Tree(HERE, workload, core) as ours:
        for turn in range(turns):
            rows = {tree: tree.turn() for tree in ((theirs, ours) if turn % 2 else (ours, theirs))}
            found.append((rows[theirs], rows[ours]))
    return found


@contextmanager
def reference() -> Iterator[Path | None]:
    """Yield the folder of the reference, unpacked; None if its commit is not in this repository, or there is none."""
    try:
        ask = ["git", "-C", str(HERE), "cat-file", "-e", f"{REFERENCE}^{{commit}}"]
        known = run_command(ask, check=False, stderr=DEVNULL)
    except FileNotFoundError:  # no git
        yield None
        return
    if known.returncode:
        yield None
        return
    with TemporaryDirectory() as folder:
        archive = Popen(["git", "-C", str(HERE), "archive", REFERENCE], stdout=PIPE)
        run_command(["tar", "-x", "-C", folder], stdin=archive.stdout, check=True)
        archive.wait()
        yield Path(folder).resolve()
