"""Goals of work that uses pins, as ratios to the reference.

They were set in virtual seconds per CPU second, on one machine: an AMD EPYC (Zen 5).  On another machine such a
figure depends more on the machine than on the work.  So a goal is divided by the figure of one commit, the reference,
for the same work on that machine; the quotient is the goal of a ratio, for which both trees run alternately.

The figure of the reference there is its figure on an Intel Xeon divided by 0.62, the speed of the Xeon relative to that
machine; only a program into an EEPROM was measured on that machine itself.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from rows import REAL, Measured, Row
from trees import ABSENT, FORMER, SHORT, Found, Workload, turns_of

TURNS = 5


@dataclass(frozen=True)
class Asked:
    """A goal in virtual seconds per second, the reference's figure on that machine, and the next goal."""

    goal: float
    made: float
    then: float | None = None

    @property
    def ratio(self) -> float:
        """The goal relative to the reference."""
        return round(self.goal / self.made, 2)


RELATIVE = {  # goals that are ratios to the reference
    "GS-C200S: a program of short moves": 1.5,
    "CY525: 2,100 short moves commanded by the host": 1.0,
    "CY545: 1,000 queries over the serial side": 2.5,
    "GS-C200S: 200 tests, each a program, a move and six exchanges": 3.0,
}
ASKED = {
    "dialogue of 10,000 commands through the pins": Asked(40, 20.92, then=3),
    "1,000 exchanges with a GS-C200S": Asked(100, 49.19, then=3.5),
    "stall detection, four encoders at 953,125 counts/s": Asked(5, 5.16),
    "stall detection, four encoders at 48,828 counts/s": Asked(20, 43.7),
    "gear, one axis follows 40,000 counts/s": Asked(9, 12.47),
    "gear, four axes follow 40,000 counts/s": Asked(2.5, 4.11),
    "1,000 times GET_STATUS, one by one": Asked(4, 4.40),
    "1,000 times GET_STATUS, queued": Asked(5, 6.74),
    "100 random moves of a script, polling the status": Asked(25, 30.97),
    "CY545: a program that polls": Asked(5, 7.18),
    "CY545: 2,000 commands over the bus": Asked(6, 3.00),
    "CY545: entry of a program into an EEPROM": Asked(6, 22.1),
}


def judged(workload: Workload, other: Path | None) -> list[Row]:
    """Return the rows of a workload; each with a goal relative to the reference is followed by that ratio."""
    if other is None:
        return [line for row in workload() for line in beside(row, [])]
    turns = turns_of(other, workload, TURNS, max(os.sched_getaffinity(0)))
    rows: list[Row] = []
    for key in turns[0][1]:
        ours = [mine[key] for _, mine in turns]
        name = ours[0].name
        was = FORMER.get(name, name)
        pairs = [(theirs[was, key[1]], mine[key]) for theirs, mine in turns] if name in ASKED | RELATIVE else []
        figure = median(found.figure for found in ours if found.figure is not None)
        row = Row(name, figure, ours[0].unit, ours[0].goal, ours[0].more_is_better, ours[0].bound)
        rows += beside(row, pairs)
    return rows


def beside(row: Row, pairs: list[tuple[Found, Found]]) -> Iterator[Row]:
    """Yield a row and, if it has such a goal, its ratio to the reference, turn by turn."""
    asked, relative = ASKED.get(row.name), RELATIVE.get(row.name)
    if asked is None and relative is None:
        yield row
        return
    bound = row.bound
    row.bound = ""
    yield row
    # CPU seconds per virtual second, of both
    sides = [(Measured(1 / theirs.known), Measured(1 / ours.known)) for theirs, ours in pairs]
    absent = "" if sides else ABSENT
    name, unit = f"{row.name}: compared with {SHORT}", f"x {SHORT}"
    if asked is None:
        yield Row(name, None, unit, relative, True, bound, sides, absent)
        return
    why = f"{bound}; the goal is {asked.goal:g} {REAL} on the machine on which {SHORT} reaches {asked.made:.3g}"
    yield Row(name, None, unit, asked.ratio, True, why, sides, absent)
    if asked.then:
        yield Row("the same, next goal", None, unit, asked.then, True, bound, sides, absent)
