"""The bottleneck of a figure, from a profile of the run itself: calls per item, and their modules."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from cProfile import Profile
from pathlib import Path
from pstats import Stats
from time import process_time
from typing import Any

from rows import shown

MOST = 3
FOUND: dict[str, str] = {}


def bound(name: str, prepare: Callable[[], Callable[[], object]], items: int, item: str) -> str:
    """Return the calls per item and the modules with most of the time, profiled once in a process.

    The time of a built-in function belongs to the module that calls it; one-time loading is not included.
    """
    if name not in FOUND:
        prepare()()
        profile = Profile(process_time)
        profile.runcall(prepare())
        FOUND[name] = sentence(Stats(profile).stats, items, item)  # type: ignore[attr-defined]
    return FOUND[name]


def sentence(stats: dict[tuple[str, int, str], Any], items: int, item: str) -> str:
    """Return the result of a profile as a sentence."""
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
    return f"{shown(calls / items)} calls {item}; share of the time: {shares}"


def module(file: str) -> str:
    """Return the name of a module, from its file or from "<frozen posixpath>"."""
    return Path(file.strip("<>").removeprefix("frozen ")).stem
