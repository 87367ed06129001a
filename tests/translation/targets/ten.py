"""Ten programs that are translated and run in the interpreters of targets, and what their own part does with them.

The part is run by `slewline run`, as a user runs it: its steps are those of `--steps`.  Consecutive steps in one
direction are one stretch, whether the program makes them in one move or in several.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from slewline.cli.main import invoke
from slewline.translation.meaning import Program
from slewline.translation.source_text.reading import read_program
from slewline.translation.target_writer import PlayedTrace, WriterOptions
from slewline.translation.writers import target

PROGRAMS = Path(__file__).parents[3] / "examples" / "programs"
WIRES = {"wait": 1, "dowhile": 2}  # pins of a CY525, as inputs


class Case(NamedTuple):
    """A program, the levels of its inputs, and how long its part is run; None: to its end."""

    file: str
    levels: dict[str, int] = {}  # noqa: RUF012
    until: str | None = None

    @property
    def options(self) -> WriterOptions:
        """The levels, for a program that is read back."""
        pairs = " ".join(f"{WIRES[pin]}={level}" for pin, level in self.levels.items())
        return WriterOptions(values={"inputs": pairs} if pairs else {})

    def program(self) -> Program:
        """Return what the program does."""
        path = PROGRAMS / self.file
        return read_program(path.read_text("utf-8"), path.suffix[1:], self.file)


TEN = (
    Case("five_steps.cy525"),
    Case("four_steps.cy525"),
    Case("directions.cy525"),
    Case("pulse.cy525"),
    Case("to_and_fro.cy525"),
    Case("two_groups.cy525", {"wait": 0}),
    Case("handoff.cy525", {"wait": 0}),
    Case("weld.cy525"),
    Case("two_ramps.gs-c200"),
    Case("labels.cy525", until="1 s"),
    Case("conditional_loop.cy525", until="1 s"),
    Case("long_move.gs-c200"),
)
ENDLESS = [case for case in TEN if case.until]


def stretches(steps: Iterable[int]) -> list[int]:
    """Return the stretches in one direction that steps, or moves, make: 3, -3 ..."""
    found: list[int] = []
    for each in steps:
        if found and (found[-1] > 0) == (each > 0):
            found[-1] += each
        else:
            found.append(each)
    return found


def of_part(case: Case, folder: Path) -> list[int]:
    """Return the stretches that the part of a program makes."""
    out = folder / "steps.csv"
    words = ["run", str(PROGRAMS / case.file), "-q", "--steps", str(out), "--timeout", "600 s"]
    for pin, level in case.levels.items():
        words += ["--drive", f"{pin}={level}@0 s"]
    if case.until:
        words += ["--until", case.until]
    assert invoke(words) == 0
    with out.open(encoding="utf-8") as rows:
        return stretches(int(row["direction"]) for row in csv.DictReader(rows))


def of_trace(trace: PlayedTrace) -> list[int]:
    """Return the stretches of a program that was read back, or run."""
    return stretches(each.value for each in trace.happened if each.kind == "move")


def written(case: Case, name: str, **values: str) -> str:
    """Return the text of a translation."""
    to = target(name)
    options = WriterOptions(values=values)
    return "\n".join(to.joined(line) for line in to.write(case.program(), options).lines) + "\n"


def agree(found: list[int], wanted: list[int], case: Case) -> None:
    """Compare stretches; of a program without end as many as both have made, but for the last one.

    Raises:
        AssertionError: they differ.
    """
    if not case.until:
        assert found == wanted
        return
    both = min(len(found), len(wanted)) - 1
    assert both > 5
    assert found[:both] == wanted[:both]
