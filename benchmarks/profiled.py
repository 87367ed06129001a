"""What bounds a figure, by a profile of the run itself: how many calls an item takes, and in which modules."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from cProfile import Profile
from pathlib import Path
from pstats import Stats
from time import process_time

from rows import shown

MOST = 3
FOUND: dict[str, str] = {}


def bound(name: str, prepare: Callable[[], Callable[[], object]], items: int, item: str) -> str:
    """Say how many calls an item takes and which modules have most of the time, profiled once in a process.

    What a built-in function takes is counted to the module that calls it; what the first run loads does not count.
    """
    if name not in FOUND:
        prepare()()
        profile = Profile(process_time)
        profile.runcall(prepare())
        FOUND[name] = sentence(Stats(profile).stats, items, item)  # type: ignore[attr-defined]
    return FOUND[name]


def sentence(stats: dict[tuple[str, int, str], tuple], items: int, item: str) -> str:
    """The sentence about what a profile has found."""
    calls, times = 0, defaultdict[str, float](float)
    for (file, _, _), (_, number, own, _, callers) in stats.items():
        calls += number
        if file != "~":
            times[module(file)] += own
            continue
        for (caller, _, _), (_, _, spent, _) in callers.items():
            times[module(caller)] += spent
    total = sum(times.values())
    largest = sorted(times, key=times.__getitem__, reverse=True)[:MOST]
    shares = ", ".join(f"{name} {times[name] / total:.0%}" for name in largest)
    return f"{shown(calls / items)} calls {item}; of the time {shares}"


def module(file: str) -> str:
    """The name of a module, from its file or from "<frozen posixpath>"."""
    return Path(file.strip("<>").removeprefix("frozen ")).stem
