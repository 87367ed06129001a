"""Compare the figures of another tree with those of this one: each workload in both, alternately, within seconds.

    python benchmarks/beside.py OTHER [--turns 9] [NAME ...]
    python benchmarks/beside.py reference [--turns 9] [NAME ...]

OTHER is the folder of another checkout; names are those of `run.py`, by default the most important ones that need no
`--long`.  `reference` is the tree of one commit, `REFERENCE` in trees.py, which does not change: eight steps of 1 %
each, unnoticed against the previous tree, are 8 % against the reference.  On a shared machine a figure varies by a
third within minutes without any change, so comparing two whole tables shows little.  Here both trees stay loaded, in
separate processes on one core, and every turn yields a ratio of neighbours: the table has the median of the ratios, and
the quartiles that contain half of them.  Exit status 1 if a median is more than a tenth worse.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from statistics import median

import run
from rows import shown
from trees import ABSENT, FORMER, Found, reference, turns_of

WORSE = 1.10
MATTER = ("exchanging", "serving", "packets", "moves", "scripts", "registers", "dialogue")


def compared(other: Path, name: str, turns: int, core: int) -> bool:
    """Print the rows of one workload; return whether none is worse."""
    pairs: dict[tuple[str, int], list[tuple[Found, Found]]] = defaultdict(list)
    for theirs, ours in turns_of(other, run.workload(name), turns, core):
        for key in ours:
            former = (FORMER.get(key[0], key[0]), key[1])
            if found := theirs.get(key) or theirs.get(former):
                pairs[key].append((found, ours[key]))
    fine = True
    for (row, _), both in pairs.items():
        if any(tree.figure is None for pair in both for tree in pair):
            continue
        old, new = (shown(median(tree.known for tree in column)) for column in zip(*both, strict=True))
        ratio = half = ""
        if all(tree.known > 0 for pair in both for tree in pair):  # a figure of 0, or beyond a limit, has none
            ratios = sorted(slower(*pair) for pair in both)
            quarter, middle = len(ratios) // 4, median(ratios)
            ratio, half = f"{middle:.2f}", f"{ratios[quarter]:.2f} to {ratios[-1 - quarter]:.2f}"
            fine &= middle <= WORSE
        print(f"| {row} | {old} | {new} {both[0][1].unit} | {ratio} | {half} |", flush=True)
    return fine


def slower(old: Found, new: Found) -> float:
    """Return how many times as long the new one takes."""
    return old.known / new.known if new.more_is_better else new.known / old.known


@contextmanager
def checkout(other: str) -> Iterator[Path]:
    """Yield the folder of the other tree: the given one, or the unpacked reference."""
    if other != "reference":
        yield Path(other).resolve()
        return
    with reference() as folder:
        if folder is None:
            raise SystemExit(f"{ABSENT}; fetch the whole history")
        yield folder


def main() -> int:
    """Compare the trees; return the exit status, 1 if a figure is worse."""
    names = list(chain.from_iterable(run.WORKLOADS.values()))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", help="a folder, or the word 'reference'", metavar="OTHER")
    parser.add_argument("names", nargs="*", help=", ".join(names), metavar="NAME")
    parser.add_argument("--turns", type=int, default=9, help="number of runs of each workload in each tree (9)")
    parser.add_argument("--core", type=int, default=max(os.sched_getaffinity(0)), help="the core for all runs")
    options = parser.parse_intermixed_args()
    if not set(options.names) <= set(names):
        parser.error(f"names are {', '.join(names)}")
    every = MATTER if options.other == "reference" else [name for name in names if name not in run.LONG]
    with checkout(options.other) as other:
        if not (other / "benchmarks" / "run.py").is_file():
            parser.error(f"{other}: no benchmarks/run.py; name the folder of a checkout")
        print("| workload | other | this tree | time, this to other | half of the ratios |\n|---|---:|---:|---:|---|")
        fine = [compared(other, name, options.turns, options.core) for name in options.names or every]
    return 0 if all(fine) else 1


if __name__ == "__main__":
    sys.exit(main())
